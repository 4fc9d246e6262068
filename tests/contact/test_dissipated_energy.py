"""Energy that creep dissipates over a time step with a pressure linear in time."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

from ase_roughcontact import Creep
from ase_roughcontact.contact import State
from ase_roughcontact.contact.creep import (
    after_step,
    before_step,
    creep_energy,
    dissipated_energy,
    dissipation_rate,
    with_depths,
)
from ase_roughcontact.elasticity import Isotropic
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace
from ase_roughcontact.elasticity.lattice import Box

HALFSPACE = FreeHalfSpace((4, 5), 1.0, Isotropic(1.0))
BOX = Box((0, 0), (4, 5))
CREEPS = {
    "solid": Creep([0.5, 2.0], [0.3, 4.0]),
    "flow and a term": Creep([0.5], [0.3], flow=0.4),
    "flow": Creep([], [], flow=0.4),
}


@pytest.fixture(params=CREEPS.values(), ids=CREEPS.keys())
def creep(request):
    return request.param


def after(state, pressure, creep, elapsed):
    """Return the state after a step with a pressure."""
    step = creep.over(elapsed)
    displacement = step.compliance * HALFSPACE.displacement(pressure)
    before = with_depths(before_step(state, step), HALFSPACE)
    return after_step(
        replace(before, pressure=pressure, displacement=displacement), step
    )


@pytest.fixture
def course(rng, creep):
    """State in the midst of creep, and the state at a time after it."""
    first, second = rng.random((2, *BOX.shape))
    start = after(State.flat(BOX, 0.0), 2.0 * first, creep, 0.0)
    start = after(start, first, creep, 0.5)

    def at(time, duration):
        pressure = first + (second - first) * time / duration
        return after(start, pressure, creep, time)

    return start, at


@pytest.mark.parametrize("duration", [1e-5, 1e-3, 0.1, 2.0, 50.0])
def test_it_is_the_integral_of_the_power(course, creep, duration):
    start, at = course
    power, _ = quad(
        lambda t: dissipation_rate(at(t, duration), creep),
        0.0,
        duration,
        points=[min(0.1, 0.1 * duration)],
        epsrel=1e-10,
    )
    found = dissipated_energy(start, at(duration, duration), creep, duration)
    assert found == pytest.approx(power, rel=1e-6)


@pytest.mark.parametrize("duration", [1e-6, 1.0, 1e4])
def test_it_is_the_work_that_is_not_stored(course, creep, duration):
    start, at = course
    end = at(duration, duration)

    def stored(state):
        solid = 0.5 * np.sum(state.pressure * -state.displacement)
        return solid + creep_energy(state, creep)

    def depth(time):
        state = at(time, duration)
        return sum(state.depths.values()) - state.displacement

    # mean depth over the step, by Gauss's rule on intervals that shrink to its ends
    nodes, weights = np.polynomial.legendre.leggauss(12)
    edges = duration * np.concatenate([[0.0], np.geomspace(1e-9, 1.0, 40)])
    mean = sum(
        0.5 * (b - a) * w * depth(0.5 * (a + b) + 0.5 * (b - a) * x)
        for a, b in pairwise(edges)
        for x, w in zip(nodes, weights, strict=True)
    )
    change = end.pressure - start.pressure
    work = np.sum(end.pressure * depth(duration) - start.pressure * depth(0.0))
    work -= np.sum(change * mean) / duration
    found = dissipated_energy(start, end, creep, duration)
    assert found == pytest.approx(
        work - (stored(end) - stored(start)), abs=1e-9 * abs(work)
    )
