"""Energy of a soft contact and its derivatives, against differences and scipy."""

import numpy as np
import pytest
from contacts import constant, contact_of, spring

from ase_roughcontact.interactions import LennardJones93
from ase_roughcontact.solvers.energy import ContactEnergy
from ase_roughcontact.solvers.increments import (
    Increment,
    hessian_along,
    moved,
    slope_along,
)
from ase_roughcontact.solvers.indenter_height import carrying_height

REPULSIVE = LennardJones93.repulsive(1.0, 1.0)


@pytest.fixture
def energy(periodic, wall, solid, rng):
    heights = rng.uniform(0.0, 2.0, (9, 8))
    contact = contact_of(heights, wall, periodic=periodic, solid=solid)
    return ContactEnergy(contact, spring(3.0, -2.0))


def random_state(energy, rng):
    pressure = 0.1 * rng.standard_normal(energy.contact.heights.shape)
    return energy.state(pressure, 0.4)


def random_increment(energy, rng):
    pressure = 0.1 * rng.standard_normal(energy.contact.heights.shape)
    return Increment(pressure, energy.opening(pressure), float(rng.standard_normal()))


def test_slope_is_the_derivative_of_the_energy(energy, rng):
    state, increment = random_state(energy, rng), random_increment(energy, rng)
    h = 1e-6
    up, down = (moved(energy, state, increment, t).energy for t in (h, -h))
    assert slope_along(energy, state, increment) == pytest.approx(
        (up - down) / (2 * h), 1e-5
    )


def test_hessian_is_the_derivative_of_the_slopes(energy, rng):
    state = random_state(energy, rng)
    increments = [random_increment(energy, rng) for _ in range(3)]
    h = 1e-6
    expected = [
        [
            slope_along(energy, moved(energy, state, one, h), other)
            - slope_along(energy, moved(energy, state, one, -h), other)
            for other in increments
        ]
        for one in increments
    ]
    hessian = hessian_along(energy, state, increments)
    np.testing.assert_allclose(hessian, np.array(expected) / (2 * h), rtol=1e-4)


def test_a_combination_is_linear(energy, rng):
    increments = [random_increment(energy, rng) for _ in range(2)]
    combined = Increment.combination([2.0, -0.5], increments)
    expected = 2.0 * increments[0].pressure - 0.5 * increments[1].pressure
    np.testing.assert_allclose(combined.pressure, expected, atol=1e-14)
    opening = energy.opening(combined.pressure)
    np.testing.assert_allclose(combined.opening, opening, atol=1e-13)
    heights = [increment.height for increment in increments]
    assert combined.height == pytest.approx(2.0 * heights[0] - 0.5 * heights[1])


def test_stiffness_of_springs_is_measured(energy):
    assert energy.spring_stiffness(0.7) == pytest.approx(3.0, rel=1e-9)


def loaded(load):
    heights = np.random.default_rng(1).uniform(0.0, 2.0, (9, 8))
    return ContactEnergy(contact_of(heights, REPULSIVE), constant(load))


@pytest.mark.parametrize("load", [1e-12, 1e-3, 1.0, 1e3])
def test_the_wall_carries_the_load_at_the_carrying_height(load):
    energy = loaded(load)
    height = carrying_height(energy)
    flat = np.zeros(energy.contact.heights.shape)
    pressure = energy.contact.wall(energy.contact.gap(flat, height))[1]
    assert pressure.sum() == pytest.approx(load, rel=1e-9, abs=1e-15)


def test_the_carrying_height_depends_on_the_opening():
    energy = loaded(1.0)
    opening = np.full(energy.contact.heights.shape, 0.25)
    expected = carrying_height(energy) - 0.25
    assert carrying_height(energy, opening) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("load", [0.0, -1.0])
def test_no_height_carries_a_load_that_does_not_push(load):
    assert carrying_height(loaded(load)) is None
