"""Attractions of hard walls against closed forms and differences of their energy."""

import numpy as np
import pytest
from hard_walls import HARD_WALLS, D, W
from numpy.testing import assert_allclose, assert_array_equal

from ase_roughcontact import LennardJones93
from ase_roughcontact.interactions import (
    DugdaleWall,
    ExponentialWall,
    HardWall,
    PowerLawWall,
    make_wall,
    scaled_attraction,
)

every_wall = pytest.mark.parametrize("wall", HARD_WALLS.values(), ids=HARD_WALLS.keys())


@every_wall
def test_attraction_vanishes_without_a_step(wall):
    energy, pressure, _ = wall.evaluate((1.0 - 1e-9) * wall.cutoff)
    assert abs(energy) < 1e-8 * W
    assert abs(pressure) < 1e-7 * W / D or wall is HARD_WALLS["sharp"]


@every_wall
def test_wall_only_attracts_and_the_largest_tension_is_that_in_contact(wall):
    pressure = wall.evaluate(np.linspace(0.0, wall.cutoff, 200))[1]
    assert (pressure <= 0.0).all()
    assert -pressure[0] == -pressure.min() == pytest.approx(W / D, rel=0.03)
    assert wall.attractive and wall.hard


@every_wall
def test_energy_continues_linearly_at_overlaps(wall):
    overlap = np.array([-0.3, -1e-9])
    energy, pressure, stiffness = wall.evaluate(overlap)
    at_contact = wall.evaluate(0.0)
    assert_allclose(energy, at_contact[0] - overlap * at_contact[1], rtol=1e-14)
    assert_array_equal(pressure, at_contact[1])
    assert_array_equal(stiffness, 0.0)


def test_exponential_and_power_law_have_their_form_below_the_cutoff():
    gaps = np.linspace(0.0, 2.0 * D, 9)
    wall = ExponentialWall(W, D, relative_cutoff=40.0)
    assert_allclose(wall.evaluate(gaps)[1], -W / D * np.exp(-gaps / D), rtol=1e-12)
    wall = PowerLawWall(W, D, exponent=2.0, relative_cutoff=1e6)
    expected = -W * (1.0 + gaps / (2.0 * D)) ** -2
    assert_allclose(wall.evaluate(gaps)[0], expected, rtol=1e-5)


def test_dugdale_tension_is_constant_and_ends_linearly_around_its_range():
    tension = -DugdaleWall(W, D).evaluate(D * np.array([0.0, 0.8, 1.0, 1.1, 1.2]))[1]
    assert_allclose(tension * D / W, [1.0, 1.0, 0.5, 0.25, 0.0], atol=1e-12)


def test_scene_parameters_are_in_spacings_and_joule_per_square_metre():
    parameters = {"work_of_adhesion": 1.0, "attraction_range": 0.5}
    wall = make_wall("dugdale", 0.5, 2.0, parameters)
    assert wall.attraction_range == 1.0
    assert wall.work_of_adhesion == pytest.approx(0.062415, rel=1e-4)
    wall = make_wall("power-law", 0.5, 2.0, {"work_of_adhesion": 1.0, "exponent": 2.0})
    assert (wall.exponent, wall.attraction_range, wall.cutoff) == (2.0, 2.0, 40.0)


@pytest.mark.parametrize(
    "wall, arguments, message",
    [
        (ExponentialWall, (0.0, 1.0), "work_of_adhesion"),
        (ExponentialWall, (1.0, np.nan), "attraction_range"),
        (ExponentialWall, (1.0, 1.0, -1.0), "relative_cutoff"),
        (ExponentialWall, (1.0, 1.0, 1e-3), r"relative_cutoff .* 0\.01"),
        (PowerLawWall, (1.0, 1.0, 0.0), "exponent"),
        (DugdaleWall, (1.0, 1.0, 1.0), "relative_taper"),
    ],
)
def test_parameters_out_of_range_are_errors(wall, arguments, message):
    with pytest.raises(ValueError, match=message):
        wall(*arguments)


# Local work of adhesion

LOCAL = {
    **HARD_WALLS,
    "adhesive": LennardJones93.adhesive(1.0, 1.0, W),
    "full": LennardJones93.full(distance=1.0, work_of_adhesion=W),
}


@pytest.mark.parametrize("wall", LOCAL.values(), ids=LOCAL.keys())
def test_local_factor_scales_the_work_of_adhesion_and_not_the_repulsion(wall):
    contact = wall.contact_distance
    gaps = contact + np.linspace(-0.2, wall.cutoff, 4000)
    factor = np.full(gaps.shape, 0.3)
    plain = np.array(wall.evaluate(gaps))
    energy, pressure, stiffness = scaled_attraction(wall, gaps, factor)
    beyond = gaps >= contact if not wall.hard else gaps > -1.0
    assert_allclose(pressure[beyond], 0.3 * plain[1, beyond], rtol=1e-14)
    assert_allclose(stiffness[~beyond], plain[2, ~beyond], rtol=1e-14)
    assert_allclose(-scaled_attraction(wall, contact, 0.3)[0], 0.3 * W, rtol=1e-12)
    # the derivative of the energy stays the pressure
    work = -0.5 * (pressure[1:] + pressure[:-1]) * np.diff(gaps)
    assert_allclose(np.cumsum(work), energy[1:] - energy[0], atol=2e-2 * W)


def test_factor_of_one_changes_nothing_and_a_hard_wall_has_no_attraction_to_scale():
    gaps = np.linspace(0.0, 2.0, 9)
    for wall in (*LOCAL.values(), HardWall()):
        plain, scaled = wall.evaluate(gaps), scaled_attraction(wall, gaps, gaps * 0 + 1)
        assert_allclose(scaled, plain, atol=1e-17)
