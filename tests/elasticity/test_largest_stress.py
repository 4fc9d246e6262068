"""Equivalent stresses, and the largest one below a surface."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from ase_roughcontact.elasticity import (
    Isotropic,
    Layer,
    StressField,
    largest_stress,
    principal_stresses,
    tension,
    tresca,
    von_mises,
)


def hertz(n, a, centre=(0.0, 0.0)):
    x, y = (np.arange(n) - (n - 1) / 2 - shift for shift in centre)
    return np.sqrt(np.maximum(1 - (x[:, None] ** 2 + y**2) / a**2, 0.0))


def axis_difference(t, nu):
    """Radial less axial stress of Hertz on the axis: von Mises and Tresca stress."""
    radial = -((1 + nu) * (1 - t * np.arctan(1 / t)) - 0.5 / (1 + t * t))
    return radial + 1 / (1 + t * t)


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
def test_largest_stress_below_a_sphere(nu):
    expected = minimize_scalar(
        lambda t: -axis_difference(t, nu), bounds=(0.1, 2), method="bounded"
    )
    field = StressField(Isotropic(1.0, nu), 2.0, hertz(96, 30.0, (4.3, -2.0)))
    for measure in ("von_mises", "tresca"):
        found = largest_stress(field, measure)
        assert found.value == pytest.approx(-expected.fun, rel=1e-3)
        assert found.depth == pytest.approx(60 * expected.x, rel=0.03)
        assert found.x == pytest.approx(2 * (47.5 + 4.3), abs=2.0)
        assert found.y == pytest.approx(2 * (47.5 - 2.0), abs=2.0)


# Johnson, Contact Mechanics (1985), Sec. 7.1: to the surface from mu = 0.3 on
@pytest.mark.parametrize(("friction", "deep"), [(0.1, True), (0.5, False)])
def test_largest_stress_comes_to_the_surface_under_friction(friction, deep):
    pressure = hertz(96, 30.0)
    tractions = np.stack([friction * pressure, 0 * pressure])
    field = StressField(Isotropic(1.0, 0.3), 1.0, pressure, tractions)
    assert (largest_stress(field).depth > 6.0) == deep


@pytest.mark.parametrize("periodic", [True, False])
def test_largest_stress_near_the_surface_is_the_largest_of_close_points(periodic):
    x = np.arange(128)
    height = np.cos(x[:, None] / 7) + np.cos(x / 6) + np.cos(x[:, None] / 9 + x / 11)
    pressure = np.sqrt(np.maximum(height - 1.2, 0.0))
    tractions = np.stack([0.5 * pressure, 0 * pressure])
    field = StressField(Isotropic(1.0, 0.3), 1.0, pressure, tractions, periodic)
    found = largest_stress(field)
    points = (np.linspace(-3.0, 3.0, 25) + each for each in (found.x, found.y))
    points = [np.clip(each, 0.0, 127.0) for each in points]
    assert found.depth == 1.0
    expected = von_mises(field.stress_at(*points, 1.0)).max()
    assert found.value == pytest.approx(expected, rel=2e-3)
    grid = von_mises(field.stress(1.0)).max()
    assert grid * (1 - 1e-6) < found.value < 1.05 * grid


def test_single_precision_finds_the_same_largest_stress():
    pressure = hertz(96, 30.0)
    double, single = (
        largest_stress(StressField(Isotropic(1.0, 0.3), 1.0, pressure, dtype=each))
        for each in (np.float64, np.float32)
    )
    assert single.value == pytest.approx(double.value, rel=1e-5)
    assert single.depth == pytest.approx(double.depth, rel=1e-3)


def test_largest_stress_of_many_contacts_is_found_by_all_planes():
    x = np.arange(96)
    pressure = np.zeros((96, 96))
    for i, j, a, p in ((30, 40, 9, 1.0), (60, 33, 14, 1.1), (55, 70, 20, 0.9)):
        square = 1 - ((x[:, None] - i) ** 2 + (x - j) ** 2) / a**2
        pressure += p * np.sqrt(np.maximum(square, 0.0))
    field = StressField(Isotropic(1.0, 0.3), 1.0, pressure)
    planes = [von_mises(field.stress(z)).max() for z in np.arange(2.0, 14.0)]
    found = largest_stress(field)
    assert found.value == pytest.approx(max(planes), rel=5e-3)
    assert (found.x, found.y) == pytest.approx((60, 33), abs=1.5)


def test_tension_is_largest_behind_a_sliding_sphere():
    pressure = hertz(96, 30.0)
    tractions = np.stack([0.5 * pressure, 0 * pressure])
    field = StressField(Isotropic(1.0, 0.3), 1.0, pressure, tractions)
    found = largest_stress(field, "tension")
    assert found.x == pytest.approx(47.5 - 30.0, abs=2.0)
    assert found.depth == pytest.approx(1.0)


@pytest.mark.parametrize("measure", ["von_mises", "tension"])
def test_there_is_no_stress_and_no_place_without_tractions(measure):
    field = StressField(Isotropic(1.0, 0.3), 1.0, np.zeros((16, 16)))
    found = largest_stress(field, measure)
    assert found.value == 0.0
    assert np.isnan([found.depth, found.x, found.y]).all()


def test_measures_of_known_stresses():
    stress = np.array([[3.0, 1, -1, 0, 0, 0], [0, 0, 0, 0, 2, 0], [5, 5, 5, 0, 0, 0]]).T
    np.testing.assert_allclose(von_mises(stress), [12**0.5, 12**0.5, 0], atol=1e-12)
    np.testing.assert_allclose(tresca(stress), [4, 4, 0], atol=1e-12)
    np.testing.assert_allclose(tension(stress), [3, 2, 5], atol=1e-12)
    assert principal_stresses(stress).shape == (3, 3)


def test_unknown_measure_is_an_error():
    field = StressField(Isotropic(1.0, 0.3), 1.0, np.ones((8, 8)))
    with pytest.raises(ValueError, match="von_mises"):
        largest_stress(field, "mises")


def test_the_largest_stress_takes_few_transforms():
    field = StressField(Isotropic(1.0, 0.3), 1.0, hertz(256, 80.0), periodic=True)
    largest_stress(field)
    assert field.pairs < 8.0


def test_principal_stresses_are_eigenvalues():
    stress = np.random.default_rng(2).normal(size=(6, 40)) * np.logspace(-90, 9, 40)
    xx, yy, zz, yz, xz, xy = stress
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    expected = np.linalg.eigvalsh(np.moveaxis(tensor, 2, 0)).T
    error = abs(principal_stresses(stress) - expected).max(axis=0)
    assert (error / abs(stress).max(axis=0)).max() < 1e-7


# a hard coating on a soft solid bends, and cracks from its interface
@pytest.mark.parametrize("measure", [tension, von_mises])
def test_largest_stress_of_a_stiff_layer_is_at_its_interface(measure):
    thickness, points = 12.0, np.arange(40.0, 56.0)
    field = StressField(Layer(20.0, thickness, 1.0, 0.3, 0.3), 1.0, hertz(96, 10.0))
    expected = measure(field.stress_at(points, points, thickness)).max()
    found = largest_stress(field, measure.__name__)
    assert found.depth == thickness
    assert found.value == pytest.approx(expected, rel=5e-3)


def test_largest_stress_of_a_soft_layer_is_above_or_below_its_interface():
    field = StressField(Layer(1.0, 6.0, 20.0, 0.2, 0.4), 1.0, hertz(96, 20.0))
    points, depths = np.arange(36.0, 60.0), np.linspace(1.0, 15.0, 141)
    planes = [von_mises(field.stress_at(points, points, z)).max() for z in depths]
    found = largest_stress(field)
    assert found.value == pytest.approx(max(planes), rel=5e-3)
    assert found.depth == pytest.approx(depths[np.argmax(planes)], abs=0.5)


def test_largest_principal_stress_is_negative_under_pressure_everywhere():
    field = StressField(Isotropic(1.0, 0.3), 1.0, np.ones((8, 8)), periodic=True)
    assert largest_stress(field, "tension").value == pytest.approx(-0.3 / 0.7)


def test_largest_stress_is_independent_of_the_edges_of_a_periodic_window():
    pressure = hertz(64, 20.0)
    for rows in (0, 32):
        moved = np.roll(pressure, (rows, rows), (0, 1))
        field = StressField(Isotropic(1.0, 0.3), 1.0, moved, periodic=True)
        found = largest_stress(field)
        if not rows:
            expected = found
        assert found.value == pytest.approx(expected.value, rel=1e-6)
        assert (found.x - rows) % 64 == pytest.approx(expected.x, abs=1e-3)


def test_largest_stress_at_the_edge_of_a_window_is_a_stress_there():
    pressure = np.zeros((32, 32))
    pressure[:, -3:] = 1.0
    field = StressField(Isotropic(1.0, 0.3), 1.0, pressure)
    found = largest_stress(field)
    there = von_mises(field.stress_at([found.x], [found.y], found.depth))
    assert found.value == pytest.approx(there[0, 0], rel=0.01)
