"""Cubic crystals as continua, against finite elements and closed forms."""

import numpy as np
import pytest
from depth_elements import compliance, isotropic
from matscipy.elasticity import coalesce_elastic_constants
from numpy.polynomial.legendre import leggauss
from spring_crystal import fcc_springs

from ase_roughcontact.elasticity import Cubic, Isotropic

COPPER = (168.4, 121.4, 75.4)
GOLD = (186.0, 157.0, 42.0)
HALF_SPACE = 1.3 * np.concatenate([np.linspace(0, 3, 60), np.linspace(3.2, 20, 70)])


@pytest.mark.parametrize("constants", [COPPER, GOLD])
@pytest.mark.parametrize("angle", [0.0, 0.3, np.pi / 4])
def test_wave_compliance_agrees_with_finite_elements(constants, angle):
    stiffness = coalesce_elastic_constants(*constants, convention="Cij")
    expected = compliance([(stiffness, HALF_SPACE)], 1 / 1.3, angle)
    q = np.array([np.cos(angle), np.sin(angle)]) / 1.3
    measured = Cubic(*constants, x="100").wave_compliance(*q)
    assert measured == pytest.approx(expected, rel=2e-6)


COMPONENTS = ["", "lateral_", "cross_"]


@pytest.mark.parametrize("component", COMPONENTS)
@pytest.mark.parametrize("x", ["110", "100"])
def test_isotropic_constants_give_the_isotropic_solid(x, component):
    c, i = isotropic(1.0, 0.3), np.arange(-50, 60)
    cubic, expected = Cubic(c[0, 0], c[0, 1], c[3, 3], x), Isotropic(1.0, 0.3)
    assert cubic.contact_modulus == pytest.approx(1.0, rel=1e-13)
    assert cubic.coupling == pytest.approx(expected.coupling)
    found, known = (  # and so are the compliances of cells, of the same harmonics
        getattr(s, component + "wave_compliance")(0.1 * i[:, None] + 0.01, 0.2 * i)
        for s in (cubic, expected)
    )
    np.testing.assert_allclose(found, known, rtol=0.0, atol=5e-12 * known.max())


@pytest.mark.parametrize("component", COMPONENTS)
def test_long_waves_of_a_crystal_agree_with_the_cubic_solid(crystal, component):
    q = 1e-6 * np.array([[1.0, 0.8, 0.5, 0.1], [0.0, 0.3, 0.5, -0.7]])
    cubic = Cubic(*fcc_springs(np.sqrt(2))[1])
    found, expected = (
        getattr(solid, f"{component}wave_compliance")(*q) for solid in (crystal, cubic)
    )
    np.testing.assert_allclose(found, expected, atol=1e-5 * expected.max(), rtol=0.0)
    assert crystal.coupling == pytest.approx(cubic.coupling, rel=1e-5)
    assert crystal.contact_modulus == pytest.approx(cubic.contact_modulus, rel=1e-5)


@pytest.mark.parametrize("component", COMPONENTS)
def test_x_axis_turns_the_crystal_by_45_degrees(component):
    turn, q = np.array([[1, 1], [-1, 1]]) / np.sqrt(2), np.array([0.3, 0.1])
    found, other = (
        getattr(Cubic(*COPPER, x), component + "wave_compliance")(*v)
        for x, v in (("110", q), ("100", turn.T @ q))
    )
    if component == "lateral_":
        found, other = (np.array([[m[0], m[2]], [m[2], m[1]]]) for m in (found, other))
        other = turn @ other @ turn.T
    elif component:
        other = turn @ other
    np.testing.assert_allclose(found, other, rtol=1e-12)


def test_contact_modulus_is_the_mean_inverse():
    angles = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    cubic = Cubic(*COPPER)
    mean = np.mean(1 / cubic.surface_modulus(angles))
    assert 1 / cubic.contact_modulus == pytest.approx(mean, rel=1e-12)
    np.testing.assert_allclose(1 / cubic.wave_modulus([0.1, 2.0]), mean, rtol=1e-3)


@pytest.mark.parametrize("component", COMPONENTS)
@pytest.mark.parametrize("i, j", [(2, 1), (0, 3), (31, 30), (-33, 5), (200, 90)])
def test_cell_compliance_has_the_displacements_of_its_waves(i, j, component):
    solid, (x, weights) = Cubic(*COPPER), leggauss(30)
    x, y = np.broadcast_arrays(i + x[:, None] / 2, j + x / 2)
    waves = getattr(solid, component + "wave_compliance")
    across = (np.arctan2(y, x) + np.pi / 2)[..., None]
    if component == "cross_":
        # the inverse Fourier transform: a principal value over all directions
        angle = np.pi / 400 * (np.arange(200) + 0.5)
        first, second = (
            waves(np.cos(across + a), np.sin(across + a)) for a in (angle, -angle)
        )
        point = ((first - second) / np.sin(angle)).mean(axis=-1) / 2
    else:
        point = waves(np.cos(across), np.sin(across))[..., 0]
    expected = weights @ (point / np.hypot(x, y)) @ weights / (8 * np.pi)
    found = getattr(solid, component + "cell_compliance")(np.array([i]), j, 2.0)
    np.testing.assert_allclose(
        found[..., 0], 2.0 * expected, atol=1e-8 * abs(expected).max()
    )


def test_self_compliance_is_the_integral_of_the_point_solution():
    points, weights = leggauss(60)
    angles, w, cubic = np.pi / 4 * points, np.pi / 4 * weights, Cubic(*COPPER)
    value = 4 * np.sum(w / (2 * np.cos(angles)) / cubic.surface_modulus(angles))
    assert cubic.self_compliance(2.0) == pytest.approx(2.0 * value / np.pi, rel=1e-9)


def test_an_unstable_crystal_is_refused():
    with pytest.raises(ValueError, match="c12 < c11"):
        Cubic(100.0, 120.0, 50.0)
    for c44 in (0.01, 600.0):
        with pytest.raises(ValueError, match=r"0.01 and 100"):
            Cubic(110.0, 100.0, c44)
    with pytest.raises(ValueError, match="111"):
        Cubic(*COPPER, x="111")
