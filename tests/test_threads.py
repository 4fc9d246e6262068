"""Solvers with arrays in many small blocks, shared by threads."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

import ase_roughcontact as rc
from ase_roughcontact._util import kernels
from ase_roughcontact._util.threads import threads
from ase_roughcontact.contact import Contact
from ase_roughcontact.elasticity.fft import Blocking
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace, PeriodicHalfSpace
from ase_roughcontact.interactions import RepulsiveLennardJones93
from ase_roughcontact.solvers.hard.active_set import active_set
from ase_roughcontact.solvers.soft.newton import newton_krylov

SIDE = 48
BLOCKS = Blocking(500, 8, 100, whole_grid_bytes=0)
WALLS = {
    "hard": rc.HardWall(),
    "repulsive": rc.LennardJones93.repulsive(1.0, 1.0),
    "adhesive": rc.LennardJones93.adhesive(1.0, 1.0, 0.005),
}


@pytest.fixture(autouse=True)
def small_blocks(monkeypatch):
    monkeypatch.setattr(kernels, "BLOCK_SIZE", 200)
    with threads(2):
        yield


def contact_of(kind, wall):
    i, j = np.indices((SIDE, SIDE)) - 24
    heights = (i**2 + j**2) / 600.0 + 0.1 * np.random.default_rng(3).random(
        (SIDE, SIDE)
    )
    return Contact(kind(heights.shape, 1.0, 1.0, blocking=BLOCKS), heights, wall)


def relaxed(contact, load=20.0):
    solver = active_set if contact.wall.hard else newton_krylov
    *_, last = solver(
        contact,
        height=0.3,
        external=lambda height: (load * height, -load),
        start=None,
        tolerance=1e-6,
    )
    return last


@pytest.mark.parametrize("wall", WALLS)
@pytest.mark.parametrize("kind", [FreeHalfSpace, PeriodicHalfSpace])
def test_results_do_not_depend_on_the_number_of_threads(kind, wall):
    states = []
    for count in (1, 3):
        with threads(count):
            states.append(relaxed(contact_of(kind, WALLS[wall])))
    one, three = states
    assert one.converged
    assert three.height == one.height
    assert_array_equal(three.pressure, one.pressure)


class OneArray(rc.Interaction):
    """An exponential wall that returns the same array three times."""

    cutoff, contact_distance = 20.0, 0.0
    work_of_adhesion = attraction_range = 0.0

    def evaluate(self, gap):
        value = np.exp(-gap)
        return value, value, value


def test_arrays_returned_by_a_wall_are_not_overwritten():
    assert relaxed(contact_of(FreeHalfSpace, OneArray())).converged


class Broken(RepulsiveLennardJones93):
    """A wall with a pressure that is not a number at the lowest atoms."""

    def evaluate(self, gap):
        energy, pressure, stiffness = super().evaluate(gap)
        return energy, np.where(gap < 0.9, np.nan, pressure), stiffness


@pytest.mark.parametrize("row", [0, SIDE - 1])
def test_a_wall_that_returns_nan_is_reported(row):
    contact = contact_of(FreeHalfSpace, Broken(1.0, 1.0, 0.5))
    contact.heights[:] = 3.0
    contact.heights[row, 5] = 0.0
    last = relaxed(contact)
    assert not last.converged
    assert "not finite" in last.message
