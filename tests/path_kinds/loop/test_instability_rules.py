"""Criteria for halving a step of a loop and for instabilities, on both sides."""

import math
from dataclasses import replace

import pytest
from built import atoms_under

from ase_roughcontact import RoughSphere, load_path
from ase_roughcontact.path_kinds.loop.instabilities import balanced, jumped

EPSILON = 1e-6
SIDES = pytest.mark.parametrize("side", [-1, 1], ids=["below", "above"])


@pytest.fixture(scope="module")
def state():
    """State with round numbers: a height of 2 Å, 3 eV/Å, 100 interacting atoms.

    Without a stiffness the force is a straight line between states.
    """
    sphere = RoughSphere(20.0)
    atoms = atoms_under(sphere, shape=(16, 16))
    record = next(load_path(atoms, penetrations=[0.2]))
    return replace(
        record,
        height=2.0,
        normal_force=3.0,
        contact_stiffness=math.nan,
        energy=7.0,
        max_force=1e-3,
        repulsive_atoms=10,
        attractive_atoms=90,
    )


def after(state, lost, down=0.5, force=3.0, **changes):
    """Return the state after a step down in which some energy was lost."""
    work = 0.5 * (state.normal_force + force) * down
    given = {"height": state.height - down, "normal_force": force}
    return replace(state, energy=state.energy + work - lost, **given | changes)


@SIDES
@pytest.mark.parametrize("down", [0.5, -0.5], ids=["down", "up"])
@pytest.mark.parametrize("force", [3.0, -1.0])
def test_an_instability_loses_more_energy_than_any_intermediate_force_explains(
    state, force, down, side
):
    # half the difference of the forces, and residual forces on 100 atoms
    explained = (0.5 * abs(3.0 - force) + 100 * 1e-3) * abs(down)
    new = after(state, explained * (1.0 + side * EPSILON), down, force)
    assert jumped(state, new) == (side > 0)


@SIDES
@pytest.mark.parametrize("sign", [-1, 1])
@pytest.mark.parametrize("force, largest", [(3.0, 3.0), (-5.0, 5.0)])
def test_the_energy_balance_is_relative_to_the_larger_force(
    state, force, largest, sign, side
):
    allowed = (0.01 * largest + 100 * 1e-3) * 0.5
    new = after(state, sign * allowed * (1.0 + side * EPSILON), force=force)
    assert balanced(state, new, 0.01, 0.5) == (side < 0)
    assert not balanced(state, replace(new, converged=False), 0.01, 0.5)


@SIDES
def test_the_energy_balance_near_zero_force_is_relative_to_the_smallest_force(
    state, side
):
    light = replace(state, normal_force=0.01)
    allowed = (0.01 * 0.5 + 100 * 1e-3) * 0.5
    new = after(light, allowed * (1.0 + side * EPSILON), force=-0.01)
    assert balanced(light, new, 0.01, 0.5) == (side < 0)


@SIDES
@pytest.mark.parametrize("down", [0.5, -0.5], ids=["down", "up"])
def test_a_force_that_is_no_parabola_is_not_balanced_though_the_energy_is(
    state, down, side
):
    # N = 3 + c t (1 - t) (1 - 2 t), which does no work, has the slope c at both ends
    allowed = 0.01**0.75 * 3.0 + 100 * 1e-3
    slope = allowed * 18.0 / math.sqrt(3.0) * (1.0 + side * EPSILON)
    curved = replace(state, contact_stiffness=slope / down)
    new = after(curved, 0.0, down)
    assert balanced(curved, new, 0.01, 0.5) == (side < 0)
