"""Criteria of stickiness against their closed forms, and asperities of JKR."""

import numpy as np
import pytest

from ase_roughcontact import SelfAffine, theory
from ase_roughcontact.theory.self_affine import rms_height

ROUGH = SelfAffine(0.1, 0.8, 4.0, 512.0)


def criteria(roughness=ROUGH, modulus=1.0, work=0.005, reach=0.245):
    found = theory.stickiness(roughness, modulus, work, reach)
    return {criterion.name: criterion for criterion in found}


def test_parameter_of_fuller_and_tabor_follows_from_rms_height_and_curvature():
    height = rms_height(ROUGH)
    radius = 2.0 * theory.slope_to_curvature_ratio(ROUGH) / 0.1
    expected = 3.0 * height**1.5 / radius**0.5 / 0.02
    found = criteria(modulus=3.0, work=0.02)["Fuller-Tabor"].value
    assert found == pytest.approx(expected, rel=1e-12)


def test_persson_and_tosatti_compare_the_energy_of_flattening():
    work = theory.flattening_energy(2.0, ROUGH)
    for factor, sticky in ((0.99, False), (1.01, True)):
        found = criteria(modulus=2.0, work=factor * work)["Persson-Tosatti"]
        assert found.value == pytest.approx(1.0 / factor)
        assert found.sticky is sticky


def test_a_single_wave_is_flattened_by_its_closed_form():
    """U = E* q h^2/4, with the rms height h."""
    wave = SelfAffine(0.1, 0.8, 8.0, 8.0)
    q = 2.0 * np.pi / 8.0
    assert rms_height(wave) == pytest.approx(0.1 / q)
    found = criteria(wave, work=0.05)["Persson-Tosatti"].value
    assert found == pytest.approx(q * (0.1 / q) ** 2 / 4.0 / 0.05)


@pytest.mark.parametrize("longest", [8.0, 32.0])
def test_criteria_of_a_narrow_band_follow_from_its_height_and_curvature(longest):
    rough = SelfAffine(0.1, 0.8, 4.0, longest, seed=1, domain=1024.0)
    height, slope, curvature = vars(rough.statistics()).values()
    found = criteria(rough, work=0.02, reach=0.3)
    expected = height**1.5 / (2.0 / curvature) ** 0.5 / 0.02
    assert found["Fuller-Tabor"].value == pytest.approx(expected, rel=0.02)
    attraction = theory.inverse_kappa_attractive(0.02, 1.0, 0.3, slope, curvature)
    expected = 1.0 / (theory.KAPPA_HARD * attraction)
    assert found["Pastewka-Robbins"].value == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("work, printed", [(0.0005, 0.04), (0.005, 0.25)])
def test_pastewka_and_robbins_have_the_numbers_of_their_paper(work, printed):
    """1/kappa_att of Appl. Phys. Lett. 108, 221601 (2016), kappa_rep = 2."""
    wide = SelfAffine(0.1, 0.8, 4.0, 1e12)
    found = criteria(wide, work=work, reach=np.sqrt(12.0 * work))["Pastewka-Robbins"]
    assert found.value == pytest.approx(1.0 / (2.0 * printed), rel=0.15)
    assert not found.sticky


def test_law_of_a_rough_sphere_lists_the_criteria():
    adhesion = {"work_of_adhesion": 0.03, "attraction_range": 0.5}
    found = theory.regime(1.0, 1000.0, 1.0, ROUGH, **adhesion)
    assert found.criteria == theory.stickiness(ROUGH, 1.0, **adhesion)
    soft = {"kappa_repulsive": theory.KAPPA_REPULSIVE, **adhesion}
    found_soft = theory.regime(1.0, 1000.0, 1.0, ROUGH, **soft)
    assert found_soft.criteria == theory.stickiness(ROUGH, 1.0, **soft)
    assert "Fuller-Tabor: not sticky (13.4 >= 10)" in str(found)
    assert "Pastewka-Robbins: sticky (0.354 < 1)" in str(found)
    assert theory.regime(1.0, 1000.0, 1.0, ROUGH).criteria == ()
