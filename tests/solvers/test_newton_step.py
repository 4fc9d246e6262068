"""Parts of a Newton step: linear system, combination and balance of the load."""

from dataclasses import replace

import numpy as np
import pytest
from contacts import constant, contact_of, green, solve, spring

from ase_roughcontact.elasticity.circulant import CirculantModel
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.interactions import LennardJones93
from ase_roughcontact.solvers.energy import ContactEnergy
from ase_roughcontact.solvers.gcr import gcr
from ase_roughcontact.solvers.increments import (
    Increment,
    combine,
    hessian_along,
    line_search,
    moved,
    slope_along,
)
from ase_roughcontact.solvers.indenter_height import balance_load
from ase_roughcontact.solvers.newton_system import NewtonSystem

REPULSIVE = LennardJones93.repulsive(1.0, 1.0)
ADHESIVE = LennardJones93.adhesive(1.0, 1.0, 0.005)


def scene(wall=REPULSIVE, *, heights=None, **options):
    if heights is None:
        x = np.arange(32) - 15.5
        waves = 0.2 * np.random.default_rng(1).standard_normal((32, 32))
        heights = (x[:, None] ** 2 + x**2) / 640.0 + waves
    return contact_of(heights, wall, **options)


# Generalised conjugate residuals


def test_gcr_solves_a_dense_system(rng):
    matrix = np.eye(30) + 0.1 * rng.standard_normal((30, 30))
    right = rng.standard_normal(30)
    residual = right.copy()
    found = gcr(matrix.__matmul__, np.copy, residual, 1e-12, 30)
    np.testing.assert_allclose(found, np.linalg.solve(matrix, right), atol=1e-11)
    np.testing.assert_allclose(residual, right - matrix @ found, atol=1e-13)


def test_gcr_stops_at_the_tolerance_or_the_number_of_steps(rng):
    matrix = np.diag(np.linspace(1.0, 10.0, 50))
    right = rng.standard_normal(50)
    loose = right - matrix @ gcr(matrix.__matmul__, np.copy, right.copy(), 0.1, 50)
    assert 1e-3 < np.linalg.norm(loose) <= 0.1
    assert gcr(matrix.__matmul__, np.copy, right.copy(), 100.0, 50) == 0.0
    one = gcr(matrix.__matmul__, np.copy, right.copy(), 1e-9, 1)
    assert np.linalg.matrix_rank(np.stack([one, right])) == 1


# The linear system


@pytest.mark.parametrize("held", [None, 0.0, 2.0], ids=["fixed", "load", "spring"])
def test_newton_equations_are_those_of_dense_algebra(held, rng, solid):
    contact = scene(heights=rng.uniform(0.0, 2.0, (8, 6)), periodic=True, solid=solid)
    stiffness = np.maximum(rng.standard_normal((8, 6)), 0.0)
    residual, load = rng.standard_normal((8, 6)), 3.0
    box = Box((0, 0), (8, 6))
    system = NewtonSystem(CirculantModel(contact.halfspace, box), box, stiffness, held)
    change = system.solve(system.scaled(residual), load, 1e-5, 60)
    d, ones = stiffness.ravel(), np.ones(48)
    matrix = np.block(
        [
            [np.eye(48) + d[:, None] * green(contact), d[:, None]],
            [ones if held is not None else 0.0 * ones, -held if held else held == 0.0],
        ]
    )
    if held is None:
        matrix[-1, -1], load = 1.0, 0.0
    elif held == 0.0:
        matrix[-1, -1] = 0.0
    expected = np.linalg.solve(matrix, np.append(residual.ravel(), load))
    np.testing.assert_allclose(change, expected, atol=2e-4 * abs(expected).max())


# Combination and line search


def state_and_increments(rng, wall, solid):
    energy = ContactEnergy(scene(wall, solid=solid), constant(5.0))
    pressure = np.maximum(0.05 * rng.standard_normal((32, 32)), 0.0)
    state = energy.state(pressure, 0.3)
    changes = 0.1 * rng.standard_normal((3, 32, 32))
    increments = [Increment(x, energy.opening(x), 0.1 * x[0, 0]) for x in changes]
    return energy, state, increments


@pytest.mark.parametrize("wall", [REPULSIVE, ADHESIVE], ids=["repulsive", "adhesive"])
def test_a_combination_of_increments_leads_downhill(wall, rng, solid):
    energy, state, increments = state_and_increments(rng, wall, solid)
    assert slope_along(energy, state, combine(energy, state, increments)) < 0.0


def test_a_combination_minimises_the_quadratic_model(rng, solid):
    energy, state, increments = state_and_increments(rng, REPULSIVE, solid)
    combined = combine(energy, state, increments)
    hessian = hessian_along(energy, state, [combined, *increments])
    slopes = [slope_along(energy, state, increment) for increment in increments]
    np.testing.assert_allclose(hessian[0, 1:], np.negative(slopes), rtol=1e-6)


@pytest.mark.parametrize("wall", [REPULSIVE, ADHESIVE], ids=["repulsive", "adhesive"])
def test_the_line_search_lowers_the_energy(wall, rng, solid):
    energy, state, increments = state_and_increments(rng, wall, solid)
    increment = combine(energy, state, increments)
    length, new = line_search(energy, state, increment)
    assert 0.0 < length <= 1.0
    assert new.energy < state.energy
    assert new.energy == moved(energy, state, increment, length).energy


def test_uphill_the_line_search_finds_nothing(rng, solid):
    energy, state, increments = state_and_increments(rng, REPULSIVE, solid)
    uphill = Increment.combination([-1.0], [combine(energy, state, increments)])
    assert line_search(energy, state, uphill) == (0.0, None)


# Balance of the load


def out_of_balance(wall, held, solid):
    """Energy, and its relaxed state with the indenter slightly too low."""
    contact = scene(wall, solid=solid)
    last = solve(contact, held, tolerance=1e-10)
    energy = ContactEnergy(contact, held)
    return energy, energy.state(last.pressure, last.height - 5e-9), last


@pytest.mark.parametrize("held", [constant(20.0), spring(3.0, -8.0)])
def test_the_indenter_is_balanced_alone_and_without_a_convolution(held, solid):
    energy, state, last = out_of_balance(REPULSIVE, held, solid)
    pairs = energy.contact.halfspace.pairs
    assert state.surface_error < 1e-7 < 1e-6 < abs(state.load_residual)
    balanced = balance_load(energy, state, 1e-7)
    assert balanced.error < 1e-7
    assert balanced.height == pytest.approx(last.height, abs=1e-10)
    assert balanced.pressure is state.pressure
    assert energy.contact.halfspace.pairs == pairs
    assert balance_load(energy, balanced, 1e-7) is balanced


def test_the_indenter_is_not_balanced_alone_under_attraction(solid):
    energy, state, _ = out_of_balance(ADHESIVE, constant(20.0), solid)
    tolerance = 0.9 * abs(state.load_residual)
    assert balance_load(energy, state, tolerance) is state


def test_a_balance_that_raises_energy_or_error_is_rejected(solid):
    energy, state, _ = out_of_balance(REPULSIVE, constant(20.0), solid)
    soft = replace(state, stiffness=1e-3 * state.stiffness)  # the step would be long
    assert balance_load(energy, soft, 1e-7) is soft
    without_wall = replace(state, stiffness=0.0 * state.stiffness)
    assert balance_load(energy, without_wall, 1e-7) is without_wall
