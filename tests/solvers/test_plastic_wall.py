"""Plastic contact against dense solutions, closed forms and optimality conditions."""

import math
from functools import partial

import numpy as np
import pytest
from contacts import (
    assert_optimal,
    centred,
    contact_of,
    green,
    pairs,
    rough_sphere,
    solve,
    steps,
)
from numpy.testing import assert_allclose, assert_array_equal
from scipy.optimize import lsq_linear

from ase_roughcontact.interactions import HardWall, PlasticWall
from ase_roughcontact.solvers.hard.bounds import clip_to_sum, with_sum
from ase_roughcontact.topography import RoughSphere, SelfAffine

solve = partial(solve, tolerance=1e-7)
PARTS_OF_THE_HARDNESS = (0.01, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99)


def rough(n, *, periodic=False, slope=0.1, seed=3):
    """A rough flat of a periodic surface, or a rough sphere."""
    if periodic:
        return SelfAffine(slope, 0.8, 4.0, n, seed=seed).heights((n, n), 1.0)
    roughness = SelfAffine(slope, 0.8, 4.0, min(n, 64), seed=seed)
    return rough_sphere((n, n), 8.0 * n, roughness)


def cost(contact, most, load=None, **options):
    """The relaxed state, which must be optimal and take few pairs of transforms."""
    *_, state = done = steps(contact, load, **options)
    assert state.converged, state.message
    assert_optimal(contact, state, load)
    assert pairs(done) <= most
    return state


# Independent solutions


@pytest.mark.parametrize("hardness", [0.02, 0.1, 0.3])
@pytest.mark.parametrize("part", [0.05, 0.5, 0.95])
def test_pressure_agrees_with_bounded_least_squares(hardness, part):
    heights = rough(14, slope=0.3)
    contact = contact_of(heights, PlasticWall(hardness))
    load = part * hardness * heights.size
    state = solve(contact, load, tolerance=1e-10)
    factor = np.linalg.cholesky(green(contact))
    target = np.linalg.solve(factor, -(heights + state.height).ravel())
    dense = lsq_linear(factor.T, target, (0.0, hardness), method="bvls", tol=1e-14)
    assert_allclose(state.pressure.ravel(), dense.x, atol=1e-8 * hardness)
    assert 0 < (state.pressure == hardness).sum() < heights.size or part < 0.5


@pytest.mark.parametrize("periodic", [False, True])
def test_without_a_limit_it_is_the_hard_wall(periodic):
    heights = rough(48, periodic=periodic)
    load = 0.01 * heights.size
    hard = solve(contact_of(heights, HardWall(), periodic=periodic), load)
    same = solve(contact_of(heights, PlasticWall(math.inf), periodic=periodic), load)
    harder = solve(contact_of(heights, PlasticWall(10.0), periodic=periodic), load)
    assert_array_equal(same.pressure, hard.pressure)
    assert same.height == hard.height
    assert_allclose(harder.pressure, hard.pressure, atol=1e-6)


def test_fully_plastic_contact_is_the_overlap_of_rigid_bodies():
    """Of a solid that is much stiffer than hard: A = N/H, below the height."""
    hardness = 1e-7
    contact = contact_of(rough(64), PlasticWall(hardness))
    load = 0.3 * hardness * contact.heights.size
    state = solve(contact, load, tolerance=1e-13)
    assert_allclose((state.pressure > 0.0).sum() * hardness, load, rtol=1e-3)
    flows = state.pressure == hardness
    overlaps = contact.heights + state.height < 0.0
    assert np.count_nonzero(flows != overlaps) < 0.005 * flows.size


def test_sphere_flows_first_below_its_centre():
    """Hertz: the largest pressure is the hardness at N = pi^3 R^2 H^3/(6 E*^2)."""
    n, radius, hardness = 128, 2000.0, 0.01
    heights = RoughSphere(radius).heights((n, n), 1.0, centred((n, n)))
    load = math.pi**3 * radius**2 * hardness**3 / 6.0
    contact = contact_of(heights, PlasticWall(hardness))
    for factor, flows in ((0.98, False), (1.02, True)):
        state = solve(contact, factor * load)
        assert bool((state.pressure == hardness).any()) is flows
    assert (state.pressure == hardness)[n // 2, n // 2]


# Loads


def small_random_contact(seed):
    heights = SelfAffine(0.8, 0.8, 4.0, 8.0, domain=8.0, seed=seed).heights((8, 8), 1.0)
    return contact_of(heights, PlasticWall(0.05), periodic=True)


@pytest.mark.parametrize("seed", [17, 26])
def test_load_is_carried_where_few_atoms_are_in_elastic_contact(seed):
    contact = small_random_contact(seed)
    state = solve(contact, 1.6, tolerance=1e-6)
    assert_optimal(contact, state, 1.6, gap=2e-6)


@pytest.mark.slow
def test_load_is_carried_by_twenty_thousand_random_surfaces():
    for seed in range(20_000):
        contact = small_random_contact(seed)
        state = solve(contact, 1.6, tolerance=1e-6)
        assert_optimal(contact, state, 1.6, gap=2e-6)


@pytest.mark.parametrize("periodic", [False, True])
@pytest.mark.parametrize("atoms", [1, 2, 5, 16, 32, 63, 64])
def test_load_of_the_hardness_on_a_number_of_atoms(atoms, periodic):
    for seed in range(5):
        heights = rough(8, periodic=periodic, slope=0.5, seed=seed)
        contact = contact_of(heights, PlasticWall(0.07), periodic=periodic)
        state = solve(contact, atoms * 0.07, tolerance=1e-12)
        assert_optimal(contact, state, atoms * 0.07)


# The energy


def test_wall_is_consistent():
    gap = np.linspace(-1.0, 1.0, 41)
    wall, d = PlasticWall(0.3), 1e-6
    energy, pressure, stiffness = wall.evaluate(gap)
    slope = (wall.evaluate(gap + d)[0] - wall.evaluate(gap - d)[0]) / (2 * d)
    away = abs(gap) > d
    assert_allclose(pressure[away], -slope[away], rtol=1e-7)
    assert (stiffness == 0.0).all() and (energy >= 0.0).all()


# Cost


@pytest.mark.parametrize("periodic", [False, True])
@pytest.mark.parametrize("hardness", [0.01, 0.1])
@pytest.mark.parametrize("part", PARTS_OF_THE_HARDNESS)
@pytest.mark.slow
def test_at_most_200_pairs(periodic, hardness, part):
    heights = rough(256, periodic=periodic)
    contact = contact_of(heights, PlasticWall(hardness), periodic=periodic)
    load, tolerance = part * hardness * heights.size, 1e-5 * hardness
    state = cost(contact, 200, load, tolerance=tolerance)
    cost(contact, 200, height=state.height, tolerance=tolerance)


@pytest.mark.parametrize("seed", [23, 52, 193, 199, 306])
def test_at_most_86_pairs_from_random_starts(seed):
    rng = np.random.default_rng(seed)
    n, periodic = int(rng.choice([8, 12, 16])), rng.random() < 0.6
    slope, domain = 10 ** rng.uniform(-1.5, 0), 12.0 if n == 12 else n
    flat = SelfAffine(slope, 0.8, 4.0, 8.0, domain=domain, seed=seed)
    hardness = slope * 10 ** rng.uniform(-2, 1)
    wall = PlasticWall(hardness)
    contact = contact_of(flat.heights((n, n), 1.0), wall, periodic=periodic)
    load = rng.uniform(0.02, 0.98) * hardness * n * n
    random = hardness * rng.random((n, n)) if rng.random() >= 0.5 else None
    cost(contact, 86, load, start=random, tolerance=1e-8 * hardness)


@pytest.mark.parametrize("depth", [1e-4, -1e-3])
@pytest.mark.parametrize("seed", range(6))
def test_full_contact_at_a_height_takes_few_pairs(seed, depth):
    """Just below the height of a full contact some atoms flow, above some open."""
    heights = SelfAffine(0.1, 0.8, 4.0, 8.0, domain=8.0, seed=seed).heights((8, 8), 1.0)
    contact = contact_of(heights, PlasticWall(1.0), periodic=True)
    full = contact.halfspace.elastic_pressure(heights - heights.mean())
    height = -heights.mean() - depth * np.ptp(heights)
    cost(contact, 60, height=height, start=full - full.min(), tolerance=1e-8)


# Starts and extremes


@pytest.mark.parametrize("hardness", [1e-12, 1e-6, 1e-3, 1.0, 1e6])
@pytest.mark.parametrize("periodic", [False, True])
@pytest.mark.parametrize("part", [1e-9, 1e-3, 0.5, 1.0 - 1e-9])
def test_hardness_of_any_size(hardness, periodic, part):
    heights = rough(16, periodic=periodic, slope=0.5)
    contact = contact_of(heights, PlasticWall(hardness), periodic=periodic)
    load = part * hardness * heights.size
    state = solve(contact, load, tolerance=1e-6 * min(hardness, 1.0))
    assert_optimal(contact, state, load)
    assert math.isfinite(state.height)


# Bounded sums


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e9])
def test_clipped_values_of_any_size_have_the_given_sum(scale):
    assert_allclose(clip_to_sum(np.array([[-2.6, -1.9, -0.6]]), 2.0, 1.0).sum(), 2.0)
    rng = np.random.default_rng(5)
    for size in rng.integers(1, 40, 300):
        values = scale * rng.normal(size=(1, size)).round(int(rng.integers(5)))
        total = size * rng.random()
        clipped = clip_to_sum(values, total, 1.0)
        assert clipped.min() >= 0.0 and clipped.max() <= 1.0
        assert_allclose(clipped.sum(), total, rtol=1e-13)


@pytest.mark.parametrize("total", [0.1, 1.0, 1.5, 2.5, 3.9])
def test_sum_is_changed_between_the_bounds_first(total):
    pressure = np.array([[0.0, 0.3, 0.6, 1.0]])
    push = np.array([[-1.0, 0.0, 0.0, 1.0]])
    changed = with_sum(pressure, total, 1.0, push)
    assert_allclose(changed.sum(), total)
    assert changed.min() >= 0.0 and changed.max() <= 1.0
    if 1.0 <= total <= 3.0:
        assert changed[0, 0] == 0.0 and changed[0, -1] == 1.0
