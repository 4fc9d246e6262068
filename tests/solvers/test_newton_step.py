"""Balance of the load by the indenter alone."""

from unittest.mock import patch

import numpy as np
import pytest
from contacts import constant, contact_of, green, solve, spring

from ase_roughcontact.contact.support import Support
from ase_roughcontact.interactions import LennardJones93
from ase_roughcontact.solvers.soft.energy import ContactEnergy, EnergyState, Increment
from ase_roughcontact.solvers.soft.indenter_height import balance_load

REPULSIVE = LennardJones93.repulsive(1.0, 1.0)
ADHESIVE = LennardJones93.adhesive(1.0, 1.0, 0.005)


def scene(wall=REPULSIVE, *, heights=None, **options):
    if heights is None:
        x = np.arange(32) - 15.5
        waves = 0.2 * np.random.default_rng(1).standard_normal((32, 32))
        heights = (x[:, None] ** 2 + x**2) / 640.0 + waves
    return contact_of(heights, wall, **options)


def out_of_balance(wall, held, solid):
    """A state with the indenter slightly too low, and the relaxed one."""
    contact = scene(wall, solid=solid)
    last = solve(contact, held, tolerance=1e-10)
    energy = ContactEnergy.of(contact, Support.of(held))
    return EnergyState(energy, last.pressure, last.height - 5e-9), last


@pytest.mark.parametrize("held", [constant(20.0), spring(3.0, -8.0)])
def test_the_indenter_is_balanced_alone_and_without_a_convolution(held, solid):
    state, last = out_of_balance(REPULSIVE, held, solid)
    halfspace = state.function.contact.halfspace
    pairs = halfspace.pairs
    assert state.surface_error < 1e-7 < 1e-6 < abs(state.load_residual)
    balanced = balance_load(state, 1e-7)
    assert balanced.error < 1e-7
    assert balanced.height == pytest.approx(last.height, abs=1e-10)
    assert balanced.pressure is state.pressure
    assert halfspace.pairs == pairs
    assert balance_load(balanced, 1e-7) is balanced


def test_a_balanced_indenter_needs_no_inverse_of_the_wall(solid):
    state, _ = out_of_balance(REPULSIVE, constant(20.0), solid)
    assert state.function.inverse
    with patch.object(type(REPULSIVE), "inverse", side_effect=AssertionError):
        balanced = balance_load(state, 1e-7)
    assert balanced.error < 1e-7


def test_the_indenter_is_not_balanced_alone_under_attraction(solid):
    state, _ = out_of_balance(ADHESIVE, constant(20.0), solid)
    tolerance = 0.9 * abs(state.load_residual)
    assert balance_load(state, tolerance) is state


@pytest.mark.parametrize("inverse", [True, False])
def test_the_quadratic_model_has_its_minimum_at_the_newton_step(inverse):
    """The step of dense Newton equations, for which slope and curvature cancel."""
    x = np.arange(8) - 3.5
    contact = contact_of((x[:, None] ** 2 + x**2) / 160.0, REPULSIVE)
    energy = ContactEnergy(contact, Support.of(constant(8.0)), inverse=inverse)
    pressure = np.maximum(0.4 - (x[:, None] ** 2 + x**2) / 30.0, 0.0)
    state = EnergyState(energy, pressure, -0.5)
    compliance, stiffness = green(contact), np.diag(state.stiffness.ravel())
    size = x.size**2
    matrix = np.zeros((size + 1, size + 1))
    matrix[:-1, :-1] = np.eye(size) + stiffness @ compliance
    matrix[:-1, -1] = np.diag(stiffness)
    matrix[-1, :-1] = 1.0
    missing = 8.0 - pressure.sum()
    step = np.linalg.solve(matrix, [*state.residual.ravel(), missing])
    opening = (compliance @ step[:-1]).reshape(pressure.shape)
    increment = Increment(step[:-1].reshape(pressure.shape), opening, step[-1])
    curvature = state.hessian([increment])[0, 0]
    assert state.slope(increment) == pytest.approx(-curvature, rel=1e-9)
