"""Walls against closed forms and against differences of their own energy."""

import json
import math
import pickle
from functools import partial
from itertools import pairwise

import mpmath as mp
import numpy as np
import pytest
from hard_walls import HARD_WALLS
from numpy.testing import assert_allclose, assert_array_equal
from scipy.integrate import quad

from ase_roughcontact.interactions import WALLS, HardWall, LennardJones93

E, A0, W = 2.0, 3.0, 0.05  # none of them one, so that no power of them hides

REPULSIVE = LennardJones93.repulsive(E, A0)
ADHESIVE = LennardJones93.adhesive(E, A0, W)
FULL = LennardJones93.full(distance=A0, work_of_adhesion=W)
EXAMPLES = {
    "repulsive": REPULSIVE,
    "stiff repulsive": LennardJones93.repulsive(E, A0, stiffness=7.0, core=0.8 * A0),
    "weakly adhesive": LennardJones93.adhesive(E, A0, 1e-4 * W),
    "adhesive": ADHESIVE,
    "full": FULL,
    "full, short": LennardJones93.full(
        distance=A0, work_of_adhesion=W, onset=A0, cutoff=2.5 * A0, core=0.3 * A0
    ),
}
every_wall = pytest.mark.parametrize("wall", EXAMPLES.values(), ids=EXAMPLES.keys())
ATTRACTIVE = {"adhesive": ADHESIVE, "full": FULL} | HARD_WALLS
with_tail = pytest.mark.parametrize("wall", ATTRACTIVE.values(), ids=ATTRACTIVE.keys())
ANY = EXAMPLES | HARD_WALLS
any_wall = pytest.mark.parametrize("wall", ANY.values(), ids=ANY.keys())


def energy(wall, gap):
    return wall.evaluate(np.asarray(gap))[0]


def pressure(wall, gap):
    return wall.evaluate(np.asarray(gap))[1]


def stiffness(wall, gap):
    return wall.evaluate(np.asarray(gap))[2]


def stiffness_scale(wall):
    return W / wall.attraction_range**2 if wall.hard else wall.stiffness


def pieces(wall):
    """Pairs of neighbouring joints: core, minimum, begin and end of the tail."""
    if wall.hard:
        taper = getattr(wall, "relative_taper", 0.0)
        joints = {0.0, *(wall.attraction_range * (1.0 + k * taper) for k in (-1, 1))}
    else:
        joints = {wall.core, wall.distance, getattr(wall, "onset", wall.distance)}
    return list(pairwise(sorted({-A0, *joints, wall.cutoff, wall.cutoff + A0})))


def derivative(function, gap, step, side):
    """Sixth-order difference from the left (-1), both sides (0) or the right (1)."""
    offsets = np.arange(-3.0, 4.0) + 3 * side
    unit = np.eye(7)[1]
    weights = np.linalg.solve(np.vander(offsets, increasing=True).T, unit) / step
    return weights @ function(gap + step * offsets[:, None])


@pytest.mark.parametrize("name", ["repulsive", "stiff repulsive"])
def test_the_inverse_of_a_wall_returns_the_gaps_of_pressures(name):
    wall = EXAMPLES[name]
    unit = wall.stiffness * wall.distance
    given = unit * np.append(0.0, np.geomspace(1e-6, 150.0, 400))
    gap, exact, stiff = wall.inverse(given)
    assert_allclose(exact[1:], pressure(wall, gap[1:]), rtol=1e-11, atol=1e-14 * unit)
    assert_allclose(stiff[1:], stiffness(wall, gap[1:]), rtol=1e-12)
    assert (gap[0], exact[0], stiff[0]) == pytest.approx((A0, 0.0, wall.stiffness))
    error = abs(exact - given) / stiff / gap
    assert error[given <= unit].max() < 1e-10
    assert error.max() < 2e-4


def test_walls_without_an_inverse_say_so():
    assert [w.invertible for w in (ADHESIVE, FULL, HardWall())] == [False] * 3
    with pytest.raises(NotImplementedError, match="no inverse"):
        ADHESIVE.inverse(np.zeros(1))


def gaps_and_derivatives(wall, function, low, high):
    """Gaps of a piece and differences taken within it; also at its ends if soft."""
    gaps = np.linspace(low, high, 31)
    step = min(1e-3 * A0, (high - low) / 200)
    left, right = gaps[gaps < low + 3 * step], gaps[gaps > high - 3 * step]
    middle = gaps[left.size : gaps.size - right.size]
    parts = [(left, 1), (middle, 0), (right, -1)]
    curve = partial(function, wall)
    slopes = np.concatenate([derivative(curve, g, step, s) for g, s in parts])
    inside = slice(1, -1) if wall.hard else slice(None)
    return gaps[inside], slopes[inside]


# Derivatives


@any_wall
def test_pressure_is_minus_the_derivative_of_the_energy_on_both_sides_of_joints(wall):
    for low, high in pieces(wall):
        gaps, slope = gaps_and_derivatives(wall, energy, low, high)
        noise = 1e-12 * stiffness_scale(wall) * A0
        assert_allclose(pressure(wall, gaps), -slope, rtol=1e-7, atol=noise)


@any_wall
def test_stiffness_is_minus_the_derivative_of_the_pressure_on_both_sides(wall):
    for low, high in pieces(wall):
        gaps, slope = gaps_and_derivatives(wall, pressure, low, high)
        expected = stiffness(wall, gaps)
        if not wall.attractive and high == wall.distance:
            gaps, slope, expected = gaps[:-1], slope[:-1], expected[:-1]
        noise = 1e-11 * stiffness_scale(wall)
        assert_allclose(expected, -slope, rtol=1e-7, atol=noise)


def test_stiffness_of_the_repulsive_wall_drops_from_the_bulk_value_to_zero():
    below, at = stiffness(REPULSIVE, [np.nextafter(A0, 0.0), A0])
    assert below == pytest.approx(E / A0, rel=1e-14)
    assert at == 0.0
    slope = derivative(lambda g: pressure(REPULSIVE, g), np.array([A0]), 1e-3 * A0, -1)
    assert_allclose(slope, -E / A0, rtol=1e-7)


@every_wall
def test_energy_pressure_and_stiffness_are_continuous_at_every_joint(wall):
    scales = wall.stiffness * A0 ** np.array([2, 1, 0])
    for joint, _ in pieces(wall)[1:]:
        curves = np.array(wall.evaluate(joint * np.array([1 - 1e-13, 1, 1 + 1e-13])))
        steps = np.ptp(curves, axis=1) / np.maximum(scales, abs(curves).max(axis=1))
        if not wall.attractive and joint == wall.distance:
            steps = steps[:2]  # the stiffness is discontinuous
        assert steps.max() < 1e-9


# Closed forms


def test_minimum_of_the_full_wall_has_its_depth_distance_and_curvature():
    curves = FULL.evaluate(np.array([A0]))
    assert_allclose(np.ravel(curves), [-W, 0.0, 27 * W / A0**2], rtol=1e-14)


def test_full_wall_is_the_9_3_form_up_to_the_onset_of_its_cutoff():
    depth = 3 * W / math.sqrt(10)  # epsilon
    ratio = 1.5 ** (1 / 6) * (5 / 3) ** (1 / 6) * A0  # sigma = (5/2)^(1/6) r0
    gaps = np.linspace(FULL.core, FULL.onset, 40)
    nine_three = depth * (2 / 15 * (ratio / gaps) ** 9 - (ratio / gaps) ** 3)
    assert_allclose(energy(FULL, gaps), nine_three, rtol=1e-13, atol=1e-14 * W)


def test_repulsive_branch_is_the_9_3_form_shifted_to_zero_at_its_minimum():
    gaps = np.linspace(REPULSIVE.core, A0, 30)
    depth = E * A0 / 27
    nine_three = depth / 2 * ((A0 / gaps) ** 9 - 3 * (A0 / gaps) ** 3)
    assert_allclose(energy(REPULSIVE, gaps), nine_three + depth, atol=1e-14 * E * A0)


def test_adhesive_wall_repels_like_the_repulsive_one():
    gaps = np.linspace(-A0, 0.999 * A0, 50)
    assert_array_equal(pressure(ADHESIVE, gaps), pressure(REPULSIVE, gaps))
    assert_array_equal(stiffness(ADHESIVE, gaps), stiffness(REPULSIVE, gaps))


def test_range_of_the_smooth_tail_is_root_of_12_w_over_k():
    assert_allclose(ADHESIVE.attraction_range, math.sqrt(12 * W * A0 / E), rtol=1e-14)


def test_largest_tension_of_the_smooth_tail_is_4kd_over_27_at_a_third_of_the_range():
    reach = ADHESIVE.attraction_range
    gaps = A0 + reach * np.linspace(0, 1, 301)
    tension = -pressure(ADHESIVE, gaps)
    assert np.argmax(tension) == 100
    assert_allclose(tension[100], 4 / 27 * E / A0 * reach, rtol=1e-14)


@with_tail
def test_work_of_adhesion_is_the_depth_and_the_integral_of_the_tension(wall):
    begin, end = wall.contact_distance, wall.cutoff
    joints = [low for low, _ in pieces(wall) if begin < low < end]
    work, _ = quad(
        lambda g: -pressure(wall, [g])[0], begin, end, points=joints, epsabs=1e-13
    )
    assert_allclose(work, W, rtol=1e-10)
    assert_allclose(-energy(wall, [begin]), W, rtol=1e-14)


def test_core_is_the_second_order_taylor_polynomial_of_the_branch():
    core = mp.mpf(FULL.core)
    series = mp.taylor(lambda g: W / 2 * ((A0 / g) ** 9 - 3 * (A0 / g) ** 3), core, 2)
    for gap in (-5.0 * A0, 0.0, 0.9 * FULL.core):
        value = sum(term * (gap - core) ** n for n, term in enumerate(series))
        assert_allclose(energy(FULL, [gap]), float(value), rtol=1e-12)


@any_wall
def test_energy_force_and_stiffness_vanish_beyond_the_cutoff(wall):
    gaps = wall.cutoff * np.array([1.0, 1 + 1e-15, 1.5, 1e6])
    assert_array_equal(wall.evaluate(gaps), np.zeros((3, 4)))


@every_wall
def test_wall_repels_exactly_below_its_contact_distance(wall):
    gaps = np.linspace(-A0, wall.cutoff, 1000)
    assert_array_equal(pressure(wall, gaps) > 0, gaps < wall.contact_distance)
    assert wall.attractive == bool((pressure(wall, gaps) < 0).any())


# Units, values, objects


@every_wall
def test_shape_of_gaps_is_kept_and_gaps_are_not_changed(wall):
    gaps = np.linspace(-1, 5, 24).reshape(2, 3, 4) * A0
    before = gaps.copy()
    assert all(curve.shape == (2, 3, 4) for curve in wall.evaluate(gaps))
    assert_array_equal(gaps, before)
    assert all(curve.shape == (0,) for curve in wall.evaluate(gaps[:0, 0, 0]))


def test_zero_work_of_adhesion_gives_the_repulsive_wall():
    assert LennardJones93.adhesive(E, A0, 0.0) == REPULSIVE


def test_tail_shorter_than_rounding_is_not_attractive():
    wall = LennardJones93.adhesive(E, A0, 1e-300)
    assert np.min(wall.evaluate(np.linspace(0.5, 2.0, 50) * A0)[1]) == 0.0


def test_hard_wall_is_free_until_it_touches_and_infinite_inside():
    curves = HardWall().evaluate(np.array([-1e-9, 0.0, 2.0]))
    assert_array_equal(curves, 3 * [[np.inf, 0.0, 0.0]])
    assert (HardWall().cutoff, HardWall().contact_distance) == (0.0, 0.0)
    assert not HardWall().attractive


@pytest.mark.parametrize("wall", [HardWall(), *EXAMPLES.values()])
def test_wall_survives_json_and_pickle(wall):
    parameters = json.loads(json.dumps(wall.todict()))
    assert parameters == wall.todict()
    assert WALLS[parameters.pop("kind")](**parameters) == wall
    copy = pickle.loads(pickle.dumps(wall))
    assert copy == wall
    assert hash(copy) == hash(wall)


# Errors


REPULSIVE_KEYS = {"contact_modulus": E, "spacing": A0}
ADHESIVE_KEYS = REPULSIVE_KEYS | {"work_of_adhesion": W}
FULL_KEYS = {"distance": A0, "work_of_adhesion": W}


@pytest.mark.parametrize(
    "make, keys, change, message",
    [
        (make, keys, {name: bad}, name)
        for bad in (0.0, -1.0, math.inf, None)
        for make, keys, name in (
            (LennardJones93.repulsive, REPULSIVE_KEYS, "contact_modulus"),
            (LennardJones93.adhesive, ADHESIVE_KEYS, "spacing"),
            (LennardJones93.full, FULL_KEYS, "distance"),
            (LennardJones93.full, FULL_KEYS, "work_of_adhesion"),
        )
    ]
    + [
        (LennardJones93.repulsive, REPULSIVE_KEYS, {"stiffness": 0.0}, "stiffness"),
        (LennardJones93.repulsive, REPULSIVE_KEYS, {"core": 0.0}, "core"),
        (LennardJones93.adhesive, ADHESIVE_KEYS, {"work_of_adhesion": -W}, ">= 0"),
        (LennardJones93.adhesive, ADHESIVE_KEYS, {"stiffness": -1.0}, "stiffness"),
        (LennardJones93.full, FULL_KEYS, {"cutoff": math.inf}, "cutoff"),
        (LennardJones93.full, FULL_KEYS, {"cutoff": 0.5 * A0}, "onset and cutoff"),
        (LennardJones93.full, FULL_KEYS, {"onset": 0.5 * A0}, "onset and cutoff"),
        (LennardJones93.full, FULL_KEYS, {"onset": 11 * A0}, "onset and cutoff"),
        (LennardJones93.full, FULL_KEYS, {"onset": math.nan}, "onset"),
        (LennardJones93.full, FULL_KEYS, {"core": A0}, "core"),
    ],
)
def test_impossible_walls_are_refused_by_parameter(make, keys, change, message):
    with pytest.raises(ValueError, match=message):
        make(**keys | change)


def test_the_full_wall_has_no_order_of_arguments_to_mistake():
    with pytest.raises(TypeError):
        LennardJones93.full(1.0, 0.1)
