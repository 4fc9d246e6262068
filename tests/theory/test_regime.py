"""Which law applies: smooth and rough spheres of the laboratory and of the paper."""

from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ase_roughcontact import SelfAffine, theory
from ase_roughcontact.theory import regime

# Units a0 = E* = 1.
ROUGH = SelfAffine(0.1, 0.8, 4.0, 512.0)
RHO = 4 / (0.2 * np.pi) * np.sqrt(12)
BIG = 1e5


def paper_adhesion(work):
    """Return the paper's wall of a work of adhesion w/(E* a0)."""
    reach = np.sqrt(12 * work)
    return {
        "work_of_adhesion": work,
        "attraction_range": reach,
        "kappa_repulsive": theory.KAPPA_REPULSIVE,
    }


# Smooth spheres


def test_smooth_sphere_without_adhesion_is_hertzian():
    found = regime(3.0, 50.0, 2.0)
    assert found.law == "Hertz"
    assert_allclose(found.contact_area, theory.Hertz(50.0, 2.0).contact_area(3.0))
    assert_allclose(found.mean_pressure, 3.0 / found.contact_area)
    assert found.pull_off_force is None


# Rough spheres


def test_area_is_linear_over_two_decades_of_load_for_each_decade_of_the_radius():
    found = regime(1.0, BIG, 1.0, ROUGH)
    assert_allclose(found.linear_decades, 2 * np.log10(BIG / RHO))


def test_tip_of_an_afm_has_no_significant_linear_range():
    # The paper, on R = 100 a0; R = 10^5 a0 has more than seven decades.
    assert regime(1.0, 100.0, 1.0, ROUGH).linear_decades < 1.5
    assert regime(1.0, BIG, 1.0, ROUGH).linear_decades > 7


def test_weak_adhesion_changes_only_kappa():
    found = regime(1e4, BIG, 1.0, ROUGH, **paper_adhesion(0.0005))
    assert found.law == "rough, linear"
    assert_allclose(1 / 2.9 - found.inverse_kappa, 0.044, rtol=0.02)
    assert_allclose(found.rough_pressure, 0.1 * found.inverse_kappa)
    assert_allclose(found.contact_area, 1e4 / found.rough_pressure, rtol=0.01)


def test_sphere_flattened_by_adhesion_is_smooth_with_less_work_of_adhesion():
    smoother = SelfAffine(1e-3, 0.8, 4.0, 512.0)
    cost = theory.flattening_energy(1.0, smoother)
    adhesion = {"work_of_adhesion": 100 * cost, "attraction_range": 0.01}
    found = regime(0.1, BIG, 1.0, smoother, **adhesion)
    assert found.law == "JKR"
    assert_allclose(found.effective_work_of_adhesion, 99 * cost)
    area = theory.JKR(BIG, 1.0, 99 * cost).contact_area(0.1)
    assert_allclose(found.contact_area, area)


def test_compliant_wall_makes_the_first_asperity_blunter():
    factor = theory.ASPERITY_FACTOR_REPULSIVE
    load = 1e-3
    hard = regime(load, BIG, 1.0, ROUGH)
    soft = regime(
        load,
        BIG,
        1.0,
        ROUGH,
        kappa_repulsive=theory.KAPPA_REPULSIVE,
        asperity_factor=factor,
    )
    assert_allclose(hard.asperity_radius, RHO)
    assert_allclose(soft.contact_area / hard.contact_area, factor ** (2 / 3))


def test_any_object_with_the_numbers_of_a_surface_is_rough():
    plain = SimpleNamespace(
        rms_slope=0.1, hurst=0.8, short_wavelength=4.0, long_wavelength=512.0
    )
    assert regime(1e4, BIG, 1.0, plain) == regime(1e4, BIG, 1.0, ROUGH)


def test_regime_prints_law_and_numbers_with_their_meaning():
    text = str(regime(1e4, BIG, 1.0, ROUGH, **paper_adhesion(0.0005)))
    lines = text.splitlines()
    assert lines[0] == "rough, linear: many asperities as on rough flats, A = N/p_rough"
    assert any("decades of load with A ~ N" in line and "7.3" in line for line in lines)
    assert "None" not in text


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"normal_force": np.nan}, "normal_force must be a finite"),
        ({"normal_force": -1.0}, "normal_force must"),
        ({"radius": 0.0}, "radius must be"),
        ({"work_of_adhesion": 0.1}, "attraction_range must be given"),
        ({"work_of_adhesion": -0.1}, "work_of_adhesion must be"),
        ({"kappa_repulsive": 0.0}, "kappa_repulsive must be"),
    ],
)
def test_unphysical_arguments_are_refused(arguments, message):
    given = {"normal_force": 1.0, "radius": BIG, "contact_modulus": 1.0}
    with pytest.raises(ValueError, match=message):
        regime(**given | {"roughness": ROUGH} | arguments)
