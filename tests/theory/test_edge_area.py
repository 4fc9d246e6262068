"""Contact area of the continuum from the fields at the edge of a hard contact."""

from itertools import product

import numpy as np
import pytest
from built import atoms_under

import ase_roughcontact as rc
from ase_roughcontact.elasticity.layer import Layer
from ase_roughcontact.theory import Hertz, MaugisDugdale
from ase_roughcontact.theory.counted_area import continuum_area, open_sides
from ase_roughcontact.theory.edge_area import edge_area


def fields(depth, modulus):
    """Return pressure and gap next to a straight edge, at distances inside."""
    strength = 0.3
    pressure = strength * np.sqrt(depth.clip(0.0))
    gap = 4.0 / 3.0 * strength / modulus * (-depth).clip(0.0) ** 1.5
    return pressure, gap


@pytest.mark.parametrize(
    "shape, normal",
    [((24, 24), n) for n in ((1, 0), (0, 1), (1, 1), (1, 2), (3, -1))]
    + [((25, 35), (1, 0)), ((25, 35), (0, 1))],
)
def test_straight_edges_are_found_between_the_points(shape, normal):
    """Periodic strips at angles to the grid, which wrap around odd windows, too."""
    spacing, modulus, (a, b) = 0.5, 7.0, normal
    period = np.gcd(a * shape[0], b * shape[1])
    lines = a * np.arange(shape[0])[:, None] + b * np.arange(shape[1])
    half = shape[0] * shape[1] * spacing**2 / 2
    errors = []
    for shift in np.arange(0.0, 2.0, 0.1):
        across = (lines - shift + period / 2) % period - period / 2
        depth = (period / 4 - abs(across)) * spacing / np.hypot(a, b)
        pressure, gap = fields(depth, modulus)
        edges = open_sides(pressure > 0.0, True).sum() * spacing
        found = edge_area(pressure, gap, spacing, modulus, periodic=True)
        errors.append((found.area - half) / (edges * spacing))
    # counting errs by up to 0.5, and the mean of counts for curved edges by 0.12
    assert max(map(abs, errors)) < 0.03
    assert abs(np.mean(errors)) < 0.011


def test_full_contact_is_known_to_half_a_point():
    pressure, gap = np.ones((6, 6)), np.zeros((6, 6))
    full = edge_area(pressure, gap, 0.5, 1.0, periodic=True)
    assert full == (9.0, 0.125, 0.0, 0.0)


def test_points_under_the_hardness_at_the_edge_add_to_the_error():
    depth = np.array([-1.0, 0.5, 1.5, 2.5, 1.5, 0.5])
    pressure, gap = (np.tile(field, (6, 1)) for field in fields(depth, 1.0))
    elastic, plastic = (
        edge_area(np.minimum(pressure, limit), gap, 0.5, 1.0, True, limit)
        for limit in (10.0, pressure[0, 1])
    )
    assert elastic.plastic_error == 0.0
    assert plastic.plastic_error == pytest.approx(0.02 * 12 * 0.5**2)


def relaxed(indenter, load, wall=None, shape=(8, 8), window="auto", **options):
    """Step at a load on a grid of the continuum, in units of E* and a0."""
    grid = {key: options.pop(key, None) for key in ("grid", "accuracy")}
    if grid["grid"] is None:
        grid = {"grid": "a0", "accuracy": 1e-6}
    wall = wall or rc.HardWall()
    atoms = atoms_under(indenter, wall, shape, fixed=False, **options)
    path = rc.load_path(atoms, loads=[load], window=window, validity="ignore", **grid)
    return next(path)


def smooth_sphere(radius, wall, load, accuracy):
    """Step on a smooth sphere at a level of accuracy."""
    grid = {"grid": "continuum", "accuracy": accuracy}
    return relaxed(rc.RoughSphere(radius), load, wall, **grid)


def westergaard(width, shift=0.0, side=64, normal=(1, 0)):
    """Step on the surface 1 - cos(q.r) in contact on strips of a width.

    In a square cell, with waves that have a normal along the grid or at an angle to it.
    """
    (a, b), points = normal, np.arange(side)
    wave = side / np.hypot(a, b)
    amplitude = 0.05 * wave / (2 * np.pi)
    phase = 2 * np.pi * (a * points[:, None] + b * points + shift) / side
    indenter = rc.HeightMap(amplitude * (1.0 - np.cos(phase)), 1.0, periodic=True)
    pressure = np.pi * amplitude / wave * np.sin(np.pi * width / (2 * wave)) ** 2
    window = {"shape": (side, side), "window": "fixed", "periodic": True}
    return relaxed(indenter, pressure * side**2, **window)


@pytest.mark.parametrize("width", np.arange(20.0, 22.0, 0.2))
def test_straight_edges_along_the_grid_have_a_larger_error(width):
    """All sides are cut at the same part, so that their errors do not average out."""
    step = westergaard(width)
    error = abs(step.continuum_area - 64 * width)
    assert error < 2.0 * step.area_error < 0.03 * step.continuum_area


def test_strips_that_the_grid_does_not_resolve_are_an_error():
    """Open strips narrower than three points, also where no point is open."""
    ratios = []
    for shift, opening in product((0.0, 0.2, 0.4), np.arange(0.1, 3.0, 0.3)):
        step = westergaard(64.0 - opening, shift)
        error = abs(step.continuum_area - 64 * (64.0 - opening))
        ratios.append(error / step.area_error)
        assert step.area_error < 0.02 * step.continuum_area
    assert np.mean(np.less(ratios, 2.0)) >= 0.9


def test_a_strip_between_points_in_contact_is_within_twice_the_error():
    """No point is open, and the strip is nearly as wide as their distance."""
    step = westergaard(31.1, 0.5, side=32)
    assert step.contact_area == 32 * 32
    assert abs(step.continuum_area - 32 * 31.1) < 2.0 * step.area_error


@pytest.mark.slow
def test_nine_of_ten_random_strips_of_about_a_point_are_within_twice_the_error():
    """At angles to the grid; H. M. Westergaard, J. Appl. Mech. 6, A49 (1939)."""
    rng, within = np.random.default_rng(3), []
    for _ in range(60):
        normal = [(1, 0), (0, 1), (1, 1), (2, 1), (1, -2)][rng.integers(5)]
        side, opening = int(rng.integers(32, 49)), rng.uniform(0.3, 1.7)
        wave = side / np.hypot(*normal)
        step = westergaard(wave - opening, rng.uniform(), side, normal)
        area = side**2 * (1.0 - opening / wave)
        within.append(abs(step.continuum_area - area) < 2.0 * step.area_error)
    assert np.mean(within) >= 0.9


@pytest.mark.parametrize("accuracy", ["fast", "normal"])
def test_contact_with_attraction_has_the_area_of_maugis(accuracy):
    radius = MaugisDugdale(150.0, 1.0, 0.02, 0.7).contact_radius(4.71)
    step = smooth_sphere(150.0, rc.DugdaleWall(0.02, 0.7), 4.71, accuracy)
    assert abs(step.continuum_area - np.pi * radius**2) < 2.0 * step.area_error
    assert step.area_error < 0.004 * step.continuum_area


@pytest.mark.parametrize("accuracy", [0.02, "normal"])
def test_plastic_wall_that_does_not_yield_has_the_area_of_hertz(accuracy):
    area = np.pi * Hertz(500.0, 1.0).contact_radius(10.0) ** 2
    plastic, hard = (
        smooth_sphere(500.0, wall, 10.0, accuracy)
        for wall in (rc.PlasticWall(0.02), rc.HardWall())
    )
    assert plastic.plastic_atoms == 0
    assert plastic.continuum_area == pytest.approx(hard.continuum_area, rel=1e-5)
    assert plastic.area_error == pytest.approx(hard.area_error, rel=1e-3)
    assert abs(plastic.continuum_area - area) < 2.0 * plastic.area_error
    assert plastic.area_error < 0.003 * area


@pytest.mark.parametrize(
    "radius, error", [(2.0, 0.06), (4.0, 0.02), (8.0, 0.005), (16.0, 0.0015)]
)
def test_smooth_spheres_of_few_points(radius, error):
    """At any contact radius, and within twice the estimate."""
    sphere = rc.RoughSphere(1000.0)
    law = Hertz(sphere.radius, 1.0)
    for offset in (0.0, 0.11, 0.27):
        contact = radius * (1.0 + offset)
        step = relaxed(sphere, law.force(contact))
        difference = abs(step.continuum_area - np.pi * contact**2)
        assert difference < error * step.continuum_area
        assert difference < 2.0 * step.area_error


@pytest.mark.parametrize("modulus, load", [(0.1, 20.0), (10.0, 3.0), (10.0, 20.0)])
def test_edge_on_a_layer_has_the_modulus_of_the_layer(modulus, load):
    sphere = rc.RoughSphere(200.0)
    solid = Layer(modulus, 1.0, 1.0)
    coarse, fine = (
        relaxed(sphere, load, solid=solid, spacing=spacing) for spacing in (1.0, 0.25)
    )
    error = abs(coarse.continuum_area - fine.continuum_area)
    assert error < 2.0 * coarse.area_error
    assert error < 0.02 * fine.continuum_area


def test_area_of_a_lightly_loaded_atom_is_not_negative():
    for load in (1e-8, 1e-4):
        step = relaxed(rc.RoughSphere(1000.0), load)
        assert step.repulsive_atoms == 1
        assert 0.0 <= step.continuum_area < 2.0 * step.area_error


def test_contact_that_ends_at_the_window_has_no_edge_of_its_own():
    """A flat punch: the correction by the perimeter, as for the model of atoms."""
    heights = np.zeros((16, 16))
    punch = rc.HeightMap(heights, 1.0)
    step = relaxed(punch, 10.0, shape=(16, 16), window="unchecked")
    assert step.contact_area == 256.0
    expected = continuum_area(256.0, step.perimeter, 1.0)
    assert step.continuum_area == pytest.approx(expected)
