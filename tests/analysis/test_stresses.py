"""Stresses below contact maps: planes, sections and first yield."""

import math

import numpy as np
import pytest

import ase_roughcontact as rc
from ase_roughcontact.analysis import (
    ContactMap,
    first_yield,
    stress_field,
    stress_planes,
    stress_section,
)
from ase_roughcontact.elasticity import Isotropic, von_mises

SOLID = Isotropic(0.9, 0.3)
COLUMNS = ["largest_von_mises", "von_mises_depth", "von_mises_x", "von_mises_y"]


def hertz_map(a=20.0, lateral=None):
    x = np.arange(-30.0, 34.0)
    pressure = np.sqrt(np.maximum(1.0 - (x[:, None] ** 2 + x**2) / a**2, 0.0))
    tractions = {}
    if lateral:
        tractions = {"traction_x": lateral * pressure, "traction_y": 0.0 * pressure}
    place = (-30.0, -30.0)
    return ContactMap(pressure, pressure > 0, 1.0, place, False, lateral=tractions)


def test_planes_are_planes_of_the_section():
    seen = hertz_map(lateral=0.2)
    section = stress_section(seen, SOLID, "x", at=2.0, depths=[5.0, 9.0])
    for k, plane in enumerate(stress_planes(seen, SOLID, [5.0, 9.0])):
        assert plane.depth == section.depth[k]
        expected = plane.stress[:, :, 32]  # y = 2
        np.testing.assert_allclose(section.stress[:, k], expected, atol=1e-6)
    np.testing.assert_array_equal(section.pressure, seen.pressure[:, 32])


def test_section_along_y_of_a_sphere_is_the_section_along_x():
    seen = hertz_map()
    along_x, along_y = (stress_section(seen, SOLID, each) for each in "xy")
    for found in (along_x, along_y):
        assert found.stress.shape == (6, 60, 64)
    np.testing.assert_allclose(
        von_mises(along_x.stress), von_mises(along_y.stress), atol=1e-9
    )
    assert along_x.depth[-1] == pytest.approx(40.0, rel=0.02)


def test_section_outside_of_a_map_is_an_error():
    with pytest.raises(ValueError, match="between -30 and 33 Å"):
        stress_section(hertz_map(), SOLID, at=50.0)


@pytest.mark.parametrize("depths", [[], [-1.0], [math.nan]])
def test_wrong_depths_of_a_section_are_errors(depths):
    with pytest.raises(ValueError, match="depth"):
        stress_section(hertz_map(), SOLID, depths=depths)


def test_friction_of_the_map_counts():
    plain, rubbed = (stress_field(hertz_map(lateral=mu), SOLID) for mu in (None, 0.5))
    assert plain.stress(5.0)[4, 30, 30] == pytest.approx(0.0, abs=1e-6)
    assert rubbed.stress(5.0)[4, 30, 30] > 0.2


def path(loads, columns=COLUMNS, solid=SOLID):
    sphere = rc.RoughSphere(2000.0)
    atoms = rc.substrate("Cu", (16, 16), sphere, spacing=1.0, fixed=False)
    atoms.calc = rc.RoughContact(sphere, None, rc.HardWall(), solid=solid)
    output = rc.Output(columns=columns)
    return list(rc.load_path(atoms, loads=loads, output=output, window="auto"))


# Johnson, Contact Mechanics (1985), Eq. (6.9): p0 = 1.61 Y for nu = 0.3
def test_smooth_sphere_yields_at_1_61_times_the_yield_strength():
    strength = 0.01
    largest = 1.61 * strength
    load = (math.pi * largest) ** 3 * 2000.0**2 / (6 * 0.9**2)
    found = first_yield(path(load * np.array([0.3, 0.7, 1.6])), strength)
    assert found.normal_force == pytest.approx(load, rel=0.02)
    radius = (0.75 * load * 2000.0 / 0.9) ** (1 / 3)
    assert found.depth == pytest.approx(0.48 * radius, rel=0.05)
    assert abs(found.x) < 1.0 and abs(found.y) < 1.0


def test_first_yield_is_not_known_beyond_the_path():
    steps = path([20.0, 40.0])
    for strength in (1.0, 1e-4):
        assert math.isnan(first_yield(steps, strength).normal_force)
    with pytest.raises(ValueError, match="largest_von_mises"):
        first_yield(path([20.0], None), 1.0)


def test_first_yield_needs_the_poisson_ratio():
    with pytest.raises(ValueError, match="Poisson's ratio"):
        first_yield(path([20.0], solid=Isotropic(0.9)), 1.0)
