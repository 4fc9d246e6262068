"""The active-set solver against closed forms, dense solutions and KKT conditions."""

import math

import numpy as np
import pytest
from contacts import (
    ROUGH,
    assert_optimal,
    centred,
    green,
    pairs,
    rough_sphere,
    solve,
    spring,
    steps,
)
from contacts import contact_of as contact_with
from numpy.testing import assert_allclose
from scipy.optimize import nnls
from solids import CONTINUA

from ase_roughcontact.contact import Contact
from ase_roughcontact.elasticity import Layer
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace
from ase_roughcontact.interactions import HardWall, LennardJones93, PlasticWall
from ase_roughcontact.solvers.hard.active_set import active_set
from ase_roughcontact.solvers.hard.complementarity import ComplementarityProblem
from ase_roughcontact.solvers.hard.defect_correction import GAP_NOT_FINITE, NO_PROGRESS
from ase_roughcontact.solvers.optimality import optimality_residuals
from ase_roughcontact.topography import RoughSphere, SelfAffine


def contact_of(heights, **options):
    return contact_with(heights, HardWall(), **options)


def sphere(n, radius, spacing=1.0):
    return RoughSphere(radius).heights((n, n), spacing, centred((n, n), spacing))


def force(contact, state):
    return contact.halfspace.cell_area * state.pressure.sum()


# Hertz


@pytest.fixture(scope="module")
def hertz():
    """A sphere with a contact radius of 38.4 atoms."""
    n, radius = 128, 512.0
    a = 0.3 * n
    contact = contact_of(sphere(n, radius))
    return contact, solve(contact, 4 * a**3 / (3 * radius)), a, radius


def test_depth_area_energy_and_pressure_agree_with_hertz(hertz):
    contact, state, a, radius = hertz
    load = force(contact, state)
    assert_allclose(-state.height, a**2 / radius, rtol=2e-4)
    assert_allclose((state.pressure > 0).sum(), np.pi * a**2, rtol=0.02)
    elastic = 8 * a**5 / (15 * radius**2)
    assert_allclose(state.energy - load * state.height, elastic, rtol=1e-3)
    r = np.sqrt(2 * radius * contact.heights)
    inside = r < 0.9 * a
    hemisphere = 2 * a / (np.pi * radius) * np.sqrt(1 - (r[inside] / a) ** 2)
    assert_allclose(state.pressure[inside], hemisphere, rtol=0.01)


def test_error_of_the_force_falls_with_the_spacing():
    radius, a = 8.0, 0.6
    errors = []
    for n in (8, 32, 128):
        contact = contact_of(sphere(n, radius, 2.0 / n), spacing=2.0 / n)
        state = solve(contact, height=-(a**2) / radius)
        errors.append(abs(force(contact, state) * 3 * radius / (4 * a**3) - 1))
    assert errors[2] < errors[1] / 10 < errors[0] / 100


# Dense solutions


@pytest.fixture(scope="module")
def dense(solid):
    """A small rough contact, and its solution by non-negative least squares."""
    heights = 2 * rough_sphere((14, 12), 40.0)
    height = -heights.min() - 0.8
    contact = contact_of(heights, solid=solid)
    factor = np.linalg.cholesky(green(contact))
    target = np.linalg.solve(factor, -(heights + height).ravel())
    pressure, _ = nnls(factor.T, target)
    return contact, height, pressure.reshape(heights.shape)


def test_pressure_at_a_height_agrees_with_non_negative_least_squares(dense):
    contact, height, pressure = dense
    state = solve(contact, height=height, tolerance=1e-10)
    assert 5 < np.count_nonzero(pressure) < pressure.size
    assert_allclose(state.pressure, pressure, atol=1e-9)


def test_periodic_solution_agrees_with_non_negative_least_squares(solid):
    heights = ROUGH.heights((12, 10), 1.0)
    contact = contact_of(heights, periodic=True, solid=solid)
    state = solve(contact, 3.0, tolerance=1e-10)
    # at the height found, a small mean compliance only shifts the height
    matrix = green(contact) + 1.0
    factor = np.linalg.cholesky(matrix)
    shifted = -(heights + state.height).ravel() + 3.0
    pressure, _ = nnls(factor.T, np.linalg.solve(factor, shifted))
    assert 5 < np.count_nonzero(pressure) < pressure.size
    assert_allclose(state.pressure.ravel(), pressure, atol=1e-9)


# Westergaard: a wavy surface, z = amplitude (1 + cos(2 pi x/wavelength))


@pytest.mark.parametrize("share", [0.25, 0.5, 0.75])
def test_westergaard_width_and_pressure(share):
    n, amplitude = 512, 1.0
    psi = 2 * np.pi * np.arange(n) / n
    full = np.pi * amplitude / n
    mean = full * np.sin(np.pi * share / 2) ** 2
    contact = contact_of(amplitude * np.cos(psi)[:, None] * np.ones(4), periodic=True)
    state = solve(contact, mean * 4 * n)
    assert_allclose((state.pressure > 0).mean(), share, atol=1.5 / n)
    half = (psi - np.pi) / 2
    inside = np.abs(half) < 0.9 * np.pi * share / 2
    root = np.sqrt(np.sin(np.pi * share / 2) ** 2 - np.sin(half[inside]) ** 2)
    assert_allclose(
        state.pressure[inside, 0], 2 * full * np.cos(half[inside]) * root, rtol=0.01
    )


# Control and starts


@pytest.fixture(scope="module")
def rough(solid):
    """A rough sphere, solved on two coarser grids first."""
    contact = contact_of(rough_sphere((128, 128)), solid=solid)
    return contact, 60.0, solve(contact, 60.0, tolerance=1e-8)


def assert_same(state, other, atol=1e-6):
    assert_allclose(state.pressure, other.pressure, atol=atol)
    assert_allclose(state.height, other.height, atol=atol)


def test_cold_start_without_coarser_grids_agrees(rough):
    contact, load, state = rough
    assert_same(solve(contact, load, tolerance=1e-8, coarsest=128), state)


def test_atoms_that_cannot_touch_neither_matter_nor_cost_transforms(rough):
    contact, load, _ = rough
    inner = np.s_[32:96, 32:96]
    window = contact_of(contact.heights[inner].copy(), solid=contact.halfspace.solid)
    if contact.halfspace.solid.bulges:
        pytest.skip("atoms outside may touch")
    light = steps(contact, 0.01, tolerance=1e-8)
    alone = solve(window, 0.01, tolerance=1e-8)
    assert_allclose(light[-1].pressure[inner], alone.pressure, atol=1e-6)
    assert pairs(light) < pairs(steps(contact, load, tolerance=1e-8)) / 3


def test_complementary_energy_falls_with_every_step(rough):
    contact, _, _ = rough
    displacement, load = contact.halfspace.displacement, 0.1 * contact.heights.size
    energies = [
        (step.pressure * (contact.heights - displacement(step.pressure) / 2)).sum()
        for step in steps(contact, load, tolerance=1e-8)
    ]
    assert len(energies) > 3
    assert np.all(np.diff(energies) <= 1e-12 * abs(energies[0]))


def test_a_free_window_nearly_in_contact_needs_few_steps():
    contact = contact_of(rough_sphere((128, 128)))
    load = 0.1 * contact.heights.size
    *_, state = done = steps(contact, load)
    assert 0.6 < np.mean(state.pressure > 0.0) < 1.0
    assert len(done) <= 20
    assert_optimal(contact, state, load)


@pytest.mark.parametrize("solid", [1.0, Layer(0.5, 3.0, 2.0, 0.3, 0.2)])
@pytest.mark.parametrize("part", [0.5, 0.8, 0.99, 1.2])
def test_nearly_full_contacts_of_periodic_surfaces(part, solid):
    rough = SelfAffine(0.1, 0.8, 4.0, 16.0, seed=0, domain=48.0)
    heights = rough.heights((48, 36), 1.0)
    contact = contact_of(heights, periodic=True, solid=solid)
    full = contact.halfspace.elastic_pressure(heights - heights.mean())
    load = -part * full.min() * heights.size
    state = solve(contact, load)
    assert 0.7 < np.mean(state.pressure > 0.0) <= 1.0
    assert_optimal(contact, state, load)
    if part > 1.0:
        assert_allclose(state.pressure, full + load / heights.size, rtol=1e-5)


def test_corrections_combined_or_not_end_in_the_same_contact():
    roughness = SelfAffine(0.1, 0.8, 4.0, 256.0, seed=1)
    contact = contact_of(rough_sphere((256, 256), 2560.0, roughness))
    load = 0.022 * 256**2  # 40 % of the atoms in contact
    assert_same(solve(contact, load), solve(contact, load, slow_contraction=1.0))


def test_every_step_carries_the_load_and_the_last_one_is_converged(rough):
    contact, load, _ = rough
    done = steps(contact, load)
    assert_allclose([force(contact, step) for step in done], load, rtol=1e-12)
    assert min(step.pressure.min() for step in done) >= 0.0
    assert not any(step.converged for step in done[:-1])


def test_error_is_the_force_that_closes_the_gap_of_an_atom():
    contact = contact_of(np.zeros((1, 1)), spacing=2.0, solid=3.0)
    first, *_ = steps(contact, height=-0.1)
    last = solve(contact, height=-0.1)
    assert_allclose(first.error, force(contact, last), rtol=1e-6)


def test_tolerance_is_a_force(rough):
    contact, load, _ = rough
    state = solve(contact, load, tolerance=1e-10)
    gap_per_force = contact.halfspace.self_compliance / contact.halfspace.cell_area
    assert_optimal(contact, state, load, gap=1.001e-10 * gap_per_force)


def test_a_tolerance_below_rounding_errors_is_reported(rough):
    contact, load, _ = rough
    last = steps(contact, load, tolerance=1e-30)[-1]
    assert not last.converged
    assert last.status.kind == NO_PROGRESS
    assert_optimal(contact, last, load, gap=1e-12)


# Special contacts


def test_one_atom_in_contact_carries_the_depth_over_its_compliance():
    contact = contact_of(sphere(9, 0.1))
    state = solve(contact, height=-1e-3, tolerance=1e-12)
    assert np.count_nonzero(state.pressure) == 1
    depth_per_pressure = 4 * math.log(1 + math.sqrt(2)) / np.pi
    assert_allclose(state.pressure[4, 4], 1e-3 / depth_per_pressure, rtol=1e-8)


def test_no_load_is_carried_at_first_touch(solid):
    contact = contact_of(rough_sphere((20, 20)), solid=solid)
    state = solve(contact, 0.0)
    assert state.height == pytest.approx(contact.first_contact, abs=1e-14)
    assert not state.pressure.any()


def test_a_spring_may_be_far_from_zero_height():
    # its force there has the rounding of the height times the stiffness
    near, forces = rough_sphere((24, 24)), []
    for level in (0.0, 1e8):
        contact = contact_of(near + level)
        touch = -float(contact.heights.min())
        *_, state = steps(contact, spring(100.0, touch - 1.0), touch)
        assert state.converged
        forces.append(state.pressure.sum())
    assert forces[1] == pytest.approx(forces[0], rel=1e-7)


def test_stiffness_of_a_square_punch():
    # 2 E* a 1.1523, a half of the side; within half an atom of the edge
    n = 64
    state = solve(contact_of(np.zeros((n, n))), 1.0)
    assert_allclose(-1 / state.height, 2 * 1.1523 * n / 2, rtol=0.01)


def test_periodic_surface_leaves_full_contact_when_the_indenter_rises(solid):
    contact = contact_of(ROUGH.heights((24, 24), 1.0), periodic=True, solid=solid)
    full = solve(contact, 4000.0)
    assert full.pressure.min() > 0.0
    height = -contact.heights.mean() + 0.1
    state = solve(contact, height=height, start=full.pressure + 1.0)
    assert 0 < np.count_nonzero(state.pressure) < state.pressure.size
    assert_optimal(contact, state)


def test_hard_wall_is_the_limit_of_stiff_soft_walls(relax, solid):
    heights = sphere(9, 10.0)
    hard = solve(contact_of(heights, solid=solid), height=-0.5)
    errors = []
    for stiffness in (10.0, 100.0):
        wall = LennardJones93.repulsive(1.0, 1.0, stiffness=stiffness)
        soft = Contact(FreeHalfSpace(heights.shape, 1.0, solid), heights, wall)
        height = wall.contact_distance - 0.5
        found = soft.evaluate(relax(soft, height), height)
        errors.append(found.normal_force / hard.pressure.sum() - 1)
    assert abs(errors[1]) < 0.2 * abs(errors[0])
    assert abs(errors[1]) < 0.02


# Cost and units


def test_cost_of_a_rough_sphere(solid):
    n = 256
    surface = RoughSphere(10.0 * n, SelfAffine(0.1, 0.8, 4.0, 256.0, seed=0))
    contact = contact_of(surface.heights((n, n), 1.0, centred((n, n))), solid=solid)
    done = steps(contact, 4 * (0.3 * n) ** 3 / (30 * n))
    assert len(done) <= 18  # exact convolutions
    # measured: 24 on the isotropic solid, 28 on the cubic one, 43 on the hard layer
    most = 90 if solid is CONTINUA["hard layer"] else 56
    assert pairs(done) < most


def test_a_gap_that_is_not_finite_is_reported():
    contact = contact_of(rough_sphere((40, 40)))
    displacement = contact.halfspace.displacement
    contact.halfspace.displacement = lambda pressure: displacement(pressure) * np.nan
    last = steps(contact, 20.0)[-1]
    assert not last.converged
    assert last.status.kind == GAP_NOT_FINITE


@pytest.mark.parametrize("wall", [HardWall(), PlasticWall(0.05)])
@pytest.mark.parametrize("control", [{"load": 5.0}, {"height": -3.0}])
def test_a_pressure_that_is_not_finite_is_reported(wall, control, monkeypatch):
    def solve(problem, target):
        return np.full((32, 32), np.nan)

    monkeypatch.setattr(ComplementarityProblem, "solve", solve)
    last = steps(contact_with(rough_sphere((32, 32)), wall), **control)[-1]
    assert not last.converged
    assert last.status.kind == GAP_NOT_FINITE


# What is refused


@pytest.fixture
def small():
    return contact_of(rough_sphere((8, 8)))


def first(contact, **changes):
    args = {"height": 0.0, "external": None, "start": None, "tolerance": 1e-6}
    return next(active_set(contact, **{**args, **changes}))


def test_optimality_residuals_of_a_wrong_solution(small):
    pressure, height = np.zeros((8, 8)), small.first_contact - 0.25
    residuals = optimality_residuals(small, pressure, height, load=3.0)
    assert_allclose([residuals.penetration, residuals.load_error], [0.25, 3.0])
    pressure[0, 0], pressure[7, 7] = 1e-3, -2e-3
    residuals = optimality_residuals(small, pressure, 10.0)
    assert residuals.tension == 2e-3
    assert residuals.gap_in_contact > 9.0
