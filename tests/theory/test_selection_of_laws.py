"""Selection of laws, on both sides of every limit, and their numbers.

The limits are calculated from independent formulas, in units of E*.
"""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from ase.units import GPa, J, m
from numpy.testing import assert_allclose

from ase_roughcontact import SelfAffine, theory
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.reference import reference_for
from ase_roughcontact.theory import (
    KAPPA_REPULSIVE,
    RoughSphereTheory,
    crossover_load,
    flattening_energy,
    regime,
    sphere_theory,
)

RADIUS = 1e5
OFFSET = 1e-6
SIDES = pytest.mark.parametrize("side", [-1, 1], ids=["below", "above"])
# Limits of Maugis' parameter, and the laws below and above them.
LIMITS = pytest.mark.parametrize(
    "limit, laws", [(0.1, ("DMT", "Maugis-Dugdale")), (5.0, ("Maugis-Dugdale", "JKR"))]
)
PULL_OFF = {"DMT": 2.0, "JKR": 1.5}  # in units of pi w R

SLOPE, HURST, SHORT, LONG = 0.1, 0.8, 4.0, 512.0
ROUGH = SelfAffine(SLOPE, HURST, SHORT, LONG)
SMOOTHER = SelfAffine(1e-3, HURST, SHORT, LONG)
# h'rms/h''rms, and the radius of the first asperity by Eq. (6)
M2, M4 = (
    (1.0 - (SHORT / LONG) ** (m - 2.0 * HURST)) / (m - 2.0 * HURST) for m in (2, 4)
)
WIDTH = SHORT / (2.0 * math.pi) * math.sqrt(M2 / M4)
ASPERITY = SHORT / (2.0 * math.pi * SLOPE) * math.sqrt(2 * (2 - HURST) / (1 - HURST))


def beside(limit, side):
    """Return a number just below a limit, or just above it."""
    return limit * (1.0 + side * OFFSET)


def chosen(pair, side):
    return pair[(side + 1) // 2]


def range_for(parameter, radius, work):
    """Return the range D of the attraction for a Maugis parameter with stress w/D."""
    return work * np.cbrt(9.0 * radius / (2.0 * np.pi * work)) / parameter


# Smooth spheres


@SIDES
@LIMITS
@pytest.mark.parametrize("radius, work", [(50.0, 0.02), (1e6, 1e-4)])
def test_smooth_spheres_follow_the_law_of_maugis_parameter(
    radius, work, limit, laws, side
):
    attraction = range_for(beside(limit, side), radius, work)
    law = chosen(laws, side)
    adhesion = {"work_of_adhesion": work, "attraction_range": attraction}
    assert sphere_theory(radius, 1.0, **adhesion).name == law
    found = regime(0.0, radius, 1.0, **adhesion)
    assert found.law == law
    assert found.maugis_parameter == pytest.approx(limit, rel=2 * OFFSET)
    pull_off = found.pull_off_force / (np.pi * work * radius)
    assert 1.4999 < pull_off < 2.0001
    if law in PULL_OFF:
        assert pull_off == pytest.approx(PULL_OFF[law])


@SIDES
@LIMITS
def test_scenes_are_compared_with_the_law_of_maugis_parameter(limit, laws, side):
    a0, modulus, work = 2.5, 100.0 * GPa, 0.2 * J / m**2
    # the range of a full wall is the spacing
    third = 2.0 * np.pi / 9.0 * (a0 * beside(limit, side)) ** 3 * modulus**2 / work**2
    scene = Scene.parse(
        f"""
        substrate = {{ model = "atoms", spacing = {a0}, contact_modulus = 100.0 }}
        sphere = {{ unit = "a0", radius = {third / a0!r} }}
        interaction = {{ kind = "full", work_of_adhesion = 0.2 }}
        """
    )
    assert reference_for(scene).smooth.name == chosen(laws, side)


@SIDES
def test_adhesion_is_neglected_if_it_increases_the_area_by_less_than_a_tenth(side):
    radius, work = 1e6, 1e-4
    ratio = 1.1**1.5  # of the cubes of the radii by JKR and by Hertz
    force = 3.0 * np.pi * work * radius * 2.0 * ratio / (ratio - 1.0) ** 2
    attraction = range_for(100.0, radius, work)
    adhesion = {"work_of_adhesion": work, "attraction_range": attraction}
    found = regime(beside(force, side), radius, 1.0, **adhesion)
    assert found.law == chosen(("JKR", "Hertz"), side)
    hertz = np.pi * (0.75 * force * radius) ** (2.0 / 3.0)
    assert found.contact_area == pytest.approx(1.1 * hertz, rel=1e-5)


# Rough spheres


@SIDES
@pytest.mark.parametrize("kappa", [2.0, KAPPA_REPULSIVE])
def test_rough_spheres_are_smooth_from_the_crossover_load_on(kappa, side):
    radius = 1e5
    load = 9.0 * np.pi**3 / 16.0 * radius**2 * (SLOPE / kappa) ** 3  # Eq. (5)
    assert load == pytest.approx(float(crossover_load(radius, 1.0, SLOPE, kappa)))
    found = regime(beside(load, side), radius, 1.0, ROUGH, kappa_repulsive=kappa)
    assert found.law == chosen(("rough, linear", "Hertz"), side)


@SIDES
@pytest.mark.parametrize("factor", [1.0, 3.0])
def test_the_first_asperity_carries_loads_below_its_own_crossover(factor, side):
    radius = 1e5
    load = float(crossover_load(factor * ASPERITY, 1.0, SLOPE))
    found = regime(beside(load, side), radius, 1.0, ROUGH, asperity_factor=factor)
    assert found.law == chosen(("first asperity", "rough, linear"), side)


@SIDES
def test_a_sphere_smaller_than_the_first_asperity_is_smooth(side):
    found = regime(1e-9, beside(ASPERITY, side), 1.0, ROUGH)
    assert found.law == chosen(("Hertz", "first asperity"), side)


@SIDES
def test_rough_flats_are_sticky_where_kappa_of_attraction_and_wall_are_equal(side):
    reach = 0.3
    attraction = np.pi * (3.0 / 16.0) ** (2.0 / 3.0) / (SLOPE * reach)
    attraction *= (4.0 * reach / (SLOPE * 4.0 * WIDTH)) ** (2.0 / 3.0)
    work = beside(1.0 / (KAPPA_REPULSIVE * attraction), side)
    wall = {"attraction_range": reach, "kappa_repulsive": KAPPA_REPULSIVE}
    found = regime(1e4, RADIUS, 1.0, ROUGH, work_of_adhesion=work, **wall)
    assert (found.law == "sticky rough") == (found.inverse_kappa < 0.0) == (side > 0)
    assert (found.contact_area is None) == (side > 0)
    assert abs(found.inverse_kappa) < 2 * OFFSET


@SIDES
def test_roughness_is_flattened_if_the_work_of_adhesion_exceeds_its_energy(side):
    cost = flattening_energy(1.0, SMOOTHER)
    sphere = RoughSphereTheory(1e5, 1.0, SMOOTHER, beside(cost, side), 1e-4)
    assert sphere.sticky
    assert (sphere.law(1e-9) == "sticky rough") == (side < 0)
    assert (sphere.effective_work_of_adhesion > 0.0) == (side > 0)


# Numbers of a law


def paper_adhesion(work):
    """Return the paper's wall of a work of adhesion w/(E* a0)."""
    reach = np.sqrt(12 * work)
    return {
        "work_of_adhesion": work,
        "attraction_range": reach,
        "kappa_repulsive": KAPPA_REPULSIVE,
    }


def test_smooth_sphere_without_adhesion_is_hertzian():
    found = regime(3.0, 50.0, 2.0)
    assert found.law == "Hertz"
    assert_allclose(found.contact_area, theory.Hertz(50.0, 2.0).contact_area(3.0))
    assert_allclose(found.mean_pressure, 3.0 / found.contact_area)
    assert found.pull_off_force is None


def test_area_is_linear_over_two_decades_of_load_for_each_decade_of_the_radius():
    found = regime(1.0, RADIUS, 1.0, ROUGH)
    assert_allclose(found.linear_decades, 2 * np.log10(RADIUS / ASPERITY))


def test_weak_adhesion_changes_only_kappa():
    found = regime(1e4, RADIUS, 1.0, ROUGH, **paper_adhesion(0.0005))
    assert found.law == "rough, linear"
    assert_allclose(1 / 2.9 - found.inverse_kappa, 0.044, rtol=0.02)
    assert_allclose(found.rough_pressure, 0.1 * found.inverse_kappa)
    assert_allclose(found.contact_area, 1e4 / found.rough_pressure, rtol=0.01)


def test_sphere_flattened_by_adhesion_is_smooth_with_less_work_of_adhesion():
    cost = flattening_energy(1.0, SMOOTHER)
    adhesion = {"work_of_adhesion": 100 * cost, "attraction_range": 0.01}
    found = regime(0.1, RADIUS, 1.0, SMOOTHER, **adhesion)
    assert found.law == "JKR"
    assert_allclose(found.effective_work_of_adhesion, 99 * cost)
    area = theory.JKR(RADIUS, 1.0, 99 * cost).contact_area(0.1)
    assert_allclose(found.contact_area, area)


def test_compliant_wall_makes_the_first_asperity_blunter():
    factor = theory.ASPERITY_FACTOR_REPULSIVE
    wall = {"kappa_repulsive": KAPPA_REPULSIVE, "asperity_factor": factor}
    hard = regime(1e-3, RADIUS, 1.0, ROUGH)
    soft = regime(1e-3, RADIUS, 1.0, ROUGH, **wall)
    assert_allclose(hard.asperity_radius, ASPERITY)
    assert_allclose(soft.contact_area / hard.contact_area, factor ** (2 / 3))


def test_any_object_with_the_numbers_of_a_surface_is_rough():
    plain = SimpleNamespace(**vars(ROUGH))
    assert regime(1e4, RADIUS, 1.0, plain) == regime(1e4, RADIUS, 1.0, ROUGH)


def test_regime_prints_law_and_numbers_with_their_meaning():
    text = str(regime(1e4, RADIUS, 1.0, ROUGH, **paper_adhesion(0.0005)))
    lines = text.splitlines()
    assert lines[0] == "rough, linear: many asperities as on rough flats, A = N/p_rough"
    assert any("decades of load with A ~ N" in line and "7.3" in line for line in lines)
    assert "None" not in text
