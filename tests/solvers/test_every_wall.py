"""What holds for hard, plastic, soft and attractive walls, whatever their solver."""

import numpy as np
import pytest
from contacts import constant, contact_of, rough_sphere, solve, spring, steps
from numpy.testing import assert_allclose

import ase_roughcontact as rc
from ase_roughcontact.solvers.hard.active_set import active_set
from ase_roughcontact.solvers.soft.newton import newton_krylov


def walls(length=1.0, pressure=1.0):
    """Walls in units of length and pressure."""
    adhesive = 0.02 * pressure * length, 0.5 * length
    weak = 0.005 * pressure * length
    return {
        "hard": rc.HardWall(),
        "plastic": rc.PlasticWall(0.05 * pressure),
        "repulsive": rc.LennardJones93.repulsive(pressure, length),
        "adhesive": rc.LennardJones93.adhesive(pressure, length, weak),
        "exponential": rc.ExponentialWall(*adhesive),
        "power-law": rc.PowerLawWall(*adhesive),
        "dugdale": rc.DugdaleWall(*adhesive),
    }


WALLS = walls()
LOAD = 15.0
every_wall = pytest.mark.parametrize("name", WALLS)
repulsive_walls = pytest.mark.parametrize("name", ["hard", "plastic", "repulsive"])


def two_springs(height):
    """Energy and force of a spring with a stop on the way to the surface."""
    near, far = spring(1.0, -20.0)(height), spring(5.0, -0.4)(height)
    return near if height > -0.4 else tuple(np.add(near, far))


def make(name, n=32, **options):
    return contact_of(rough_sphere((n, n)), WALLS[name], **options)


@every_wall
def test_load_and_height_control_agree(name, periodic, solid):
    contact = make(name, periodic=periodic, solid=solid)
    loaded = solve(contact, LOAD, tolerance=1e-9)
    options = {"start": loaded.pressure, "tolerance": 1e-9}
    held = solve(contact, height=loaded.height, **options)
    assert_allclose(held.pressure, loaded.pressure, atol=1e-6)
    assert_allclose(held.pressure.sum(), LOAD, rtol=1e-6)
    assert_allclose(loaded.energy, held.energy + LOAD * held.height, rtol=1e-8)


@every_wall
@pytest.mark.parametrize("stiffness", [0.01, 3.0, 1e4])
def test_a_spring_leads_to_the_contact_under_its_force(name, stiffness, periodic):
    contact = make(name, periodic=periodic)
    loaded = solve(contact, LOAD, tolerance=1e-9)
    held = spring(stiffness, loaded.height - LOAD / stiffness)
    repulsive = name in ("hard", "plastic", "repulsive")
    start = None if repulsive else 0.99 * loaded.pressure
    state = solve(contact, held, loaded.height, start, 1e-9)
    assert_allclose(state.pressure, loaded.pressure, atol=1e-6)
    assert_allclose(state.height, loaded.height, atol=1e-6)
    stored = 0.5 * LOAD**2 / stiffness
    expected = loaded.energy - LOAD * loaded.height + stored
    assert_allclose(state.energy, expected, rtol=1e-6)


@every_wall
def test_force_is_minus_the_derivative_of_the_relaxed_energy(name, periodic):
    contact, d = make(name, periodic=periodic), 1e-4
    middle = solve(contact, LOAD, tolerance=1e-10)
    options = {"start": middle.pressure, "tolerance": 1e-10}
    low, high = (
        solve(contact, height=middle.height + s * d, **options) for s in (-1, 1)
    )
    assert_allclose((low.energy - high.energy) / (2 * d), LOAD, rtol=1e-4)


@repulsive_walls
def test_any_start_leads_to_the_same_contact(name, periodic, rng, solid):
    contact = make(name, periodic=periodic, solid=solid)
    expected = solve(contact, LOAD, tolerance=1e-9)
    light = solve(contact, 0.7 * LOAD, tolerance=1e-9).pressure
    random = rng.standard_normal((32, 32))
    patch = 1.0 * (np.hypot(*np.indices((32, 32)) - 16) < 3)
    for start in (0.3 * light, light, random, 1e-6 * abs(random), patch, 10 * patch):
        for height in (-10.0, 30.0):
            state = solve(contact, LOAD, height, start, 1e-9)
            assert_allclose(state.pressure, expected.pressure, atol=1e-6)
            assert_allclose(state.height, expected.height, atol=1e-6)
        held = solve(contact, None, expected.height, start, 1e-9)
        assert_allclose(held.pressure, expected.pressure, atol=1e-6)


@every_wall
def test_start_from_the_solution_costs_one_convolution(name, periodic, solid):
    contact = make(name, periodic=periodic, solid=solid)
    last = solve(contact, LOAD, tolerance=1e-9)
    again = steps(contact, LOAD, last.height, last.pressure, 1e-7)
    assert again[-1].converged
    assert len(again) == 1 or contact.wall.hard
    if not contact.wall.hard or contact.wall.purely_hard:
        assert [state.pairs for state in again] == [1.0]


@every_wall
def test_units_change_neither_the_steps_nor_the_result(name):
    length, pressure = 2.0**-32, 2.0**37  # powers of two, for the same rounding
    force = pressure * length**2
    heights = rough_sphere((80, 80))
    scaled = contact_of(
        heights * length,
        walls(length, pressure)[name],
        spacing=length,
        solid=pressure,
    )
    one = steps(contact_of(heights, WALLS[name]), 30.0)
    other = steps(scaled, 30.0 * force, tolerance=1e-6 * force)
    assert one[-1].converged and len(one) == len(other)
    assert_allclose(other[-1].pressure / pressure, one[-1].pressure, atol=1e-12)
    assert_allclose(other[-1].height / length, one[-1].height, rtol=1e-10)
    assert_allclose(other[-1].energy / (force * length), one[-1].energy, rtol=1e-10)


@pytest.mark.parametrize("name", ["hard", "repulsive"])
@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"height": np.nan}, "height"),
        ({"tolerance": 0.0}, "tolerance"),
        ({"start": np.zeros((2, 2))}, r"start .* \(32, 32\)"),
        ({"start": np.full((32, 32), np.nan)}, "start"),
    ],
)
def test_bad_input_is_refused(name, change, message):
    with pytest.raises(ValueError, match=message):
        steps(make(name), **change)


@pytest.mark.parametrize(
    ("name", "support", "message"),
    [
        ("hard", constant(-2.0), r"load .* got -2"),
        ("hard", spring(-1.0, 0.0), "must not decrease"),
        ("hard", two_springs, "constant load or a linear spring"),
        ("plastic", constant(60.0), r"60 .* 0\.05 .* 51\.2"),
    ],
)
def test_a_support_that_a_wall_cannot_hold_is_refused(name, support, message):
    with pytest.raises(ValueError, match=message):
        steps(make(name), support)


@pytest.mark.parametrize("name", ["repulsive", "exponential", "hard"])
def test_a_wall_of_the_other_kind_is_refused_with_the_solver_to_use(name):
    solver = newton_krylov if name == "hard" else active_set
    options = {"height": 0.0, "external": None, "start": None, "tolerance": 1e-6}
    with pytest.raises(ValueError, match="ActiveSet"):
        next(solver(make(name), **options))


@pytest.mark.parametrize("name", ["hard", "power-law"])
def test_height_that_no_load_reaches_is_refused(name):
    contact = make(name, periodic=True)
    height = -contact.heights.mean() - 0.1
    with pytest.raises(ValueError, match="give a load"):
        steps(contact, height=height)
    load = 2.0 * np.ptp(contact.heights) * contact.heights.size
    assert solve(contact, load, height).pressure.min() > 0.0
