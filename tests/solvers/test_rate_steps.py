"""Time steps of rate and state friction, against an integrated block on a spring."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ase_roughcontact import Coulomb, Creep, RateAndState
from ase_roughcontact.contact.support import LateralSupport
from ase_roughcontact.elasticity import Isotropic
from ase_roughcontact.elasticity.lateral import LateralHalfSpace
from ase_roughcontact.interactions import STATE
from ase_roughcontact.interactions.local_friction import LocalFriction
from ase_roughcontact.solvers.lateral.friction import solve_friction
from ase_roughcontact.solvers.lateral.rate_step import RateContact, step_in_time
from ase_roughcontact.solvers.lateral.slip import Drive

# Block of one atom on a solid that hardly deforms.
BLOCK = LateralHalfSpace((1, 1), 1.0, Isotropic(1e6, 0.3))
PRESSURE, MU, A, LENGTH = 0.1, 0.6, 0.01, 1.0


def resting(law, pressure):
    none = np.zeros((2, *pressure.shape))
    return RateContact(law, pressure, none, none, {STATE.name: none[0]})


def sliding_block(law, kick=0.0):
    """Block in steady sliding at the reference rate, with another traction."""
    pressure = np.full((1, 1), PRESSURE)
    traction = PRESSURE * (MU + kick)
    history = {STATE.name: np.zeros((1, 1))}
    rate, _ = law.slip_rate(np.full((1, 1), traction), pressure, history)
    along = np.array([1.0, 0.0])[:, None, None]
    return RateContact(law, pressure, traction * along, rate * along, history)


def pulled(contact, stiffness, rate, duration, tolerance=1e-6):
    """Block after a step, at a rate of the base of the spring."""
    x, y = contact.tractions[:, 0, 0].tolist()
    before = LateralSupport((x, y), stiffness)
    after = LateralSupport((x + stiffness * rate * duration, y), stiffness)
    drive = Drive(np.zeros((2, 1, 1)), (before, after))
    return step_in_time(BLOCK, contact, drive, duration, tolerance)


def change_of_block(law, stiffness, rate):
    """Rates of traction and state of a block on a spring."""

    def change(time, values):
        traction, state = values
        history = {STATE.name: np.array([state])}
        v = law.slip_rate(np.array([traction]), np.array([PRESSURE]), history)[0][0]
        by_ageing = law.velocity * math.exp(-state) / law.distance - v / law.distance
        by_slip = -v / law.distance * (math.log(v / law.velocity) + state)
        return [stiffness * (rate - v), by_slip if law.slip_law else by_ageing]

    return change


@pytest.mark.parametrize("slip_law", [False, True])
def test_a_velocity_step_has_direct_and_evolution_effect(slip_law):
    law = RateAndState(MU, A, 0.015, LENGTH, 1.0, slip_law=slip_law)
    stiffness, rate = 0.05, 3.0
    durations = np.geomspace(0.003, 0.12, 25)
    contact, found = sliding_block(law), []
    for duration in durations:
        contact = pulled(contact, stiffness, rate, duration).contact
        found.append(contact.tractions[0, 0, 0] / PRESSURE)
    times = np.cumsum(durations)
    change = change_of_block(law, stiffness, rate)
    options = {"t_eval": times, "rtol": 1e-9, "atol": 1e-12}
    expected = solve_ivp(change, (0.0, times[-1]), [PRESSURE * MU, 0.0], **options)
    steady = MU + (A - law.evolution_effect) * math.log(rate)
    assert max(found) - MU > 0.8 * A * math.log(rate)
    assert abs(found[-1] - steady) < 0.2 * (max(found) - steady)
    assert np.array(found) == pytest.approx(expected.y[0] / PRESSURE, abs=1e-4)


def growth(stiffness_ratio):
    """Measured and exact complex growth rate of a block near steady sliding."""
    law = RateAndState(MU, A, 2.0 * A, LENGTH, 1.0)
    critical = PRESSURE * A / LENGTH
    stiffness = stiffness_ratio * critical
    # of the logarithms of rate and state
    matrix = np.array([[2.0 - stiffness_ratio, 2.0], [-1.0, -1.0]])
    values, vectors = np.linalg.eig(matrix.T)
    left = vectors[:, values.imag.argmax()]

    def part(contact):
        rate = math.log(contact.rates[0, 0, 0])
        return left @ [rate, contact.history[STATE.name][0, 0]]

    contact, steps, duration = sliding_block(law, 1e-3 * A), 25, 0.1
    start = part(contact)
    for _ in range(steps):
        contact = pulled(contact, stiffness, 1.0, duration).contact
    found = np.log(part(contact) / start)
    return found / (steps * duration), values[values.imag.argmax()]


@pytest.mark.parametrize(("ratio", "sign"), [(0.99, 1.0), (1.01, -1.0)])
def test_sliding_is_unstable_below_the_critical_stiffness(ratio, sign):
    found, expected = growth(ratio)
    # (1 - k/k_c)/2 times (b - a)/a
    assert expected.real == pytest.approx(0.5 * (1.0 - ratio))
    assert sign * found.real > 0.0
    assert found.real == pytest.approx(expected.real, rel=0.1)
    # near (V/D_c) sqrt((b - a)/a)
    assert found.imag == pytest.approx(1.0, rel=0.01)


def test_errors_of_the_steps_decrease_with_the_square_of_their_duration():
    law = RateAndState(MU, A, 0.015, LENGTH, 1.0)
    change, rate, time = change_of_block(law, 0.05, 2.0), 2.0, 0.4
    expected = solve_ivp(
        change, (0.0, time), [PRESSURE * MU, 0.0], rtol=1e-10, atol=1e-14
    ).y[0, -1]
    errors = []
    for count in 8, 16:
        contact = sliding_block(law)
        for _ in range(count):
            contact = pulled(contact, 0.05, rate, time / count).contact
        errors.append(abs(contact.tractions[0, 0, 0] - expected))
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.3)


@pytest.mark.parametrize("spring", [None, 0.8])
def test_without_effects_of_rate_and_state_friction_is_coulombs(spring):
    n, mu, moved = 16, 0.3, 0.1
    half = LateralHalfSpace((n, n), 1.0, Isotropic(1.0, 0.0))
    x = (np.arange(n) - 0.5 * (n - 1)) / (0.45 * n)
    pressure = 0.1 * np.sqrt(np.maximum(1.0 - x[:, None] ** 2 - x**2, 0.0))
    law = RateAndState(mu, 1e-10, 0.0, 1e-6, 1.0)
    bounds = LocalFriction(
        Coulomb(mu), pressure, pressure > 0.0, 1.0, (0.0, 0.0)
    ).bounds()
    imposed, supports = np.zeros((2, n, n)), None
    if spring is None:
        imposed[0] = moved
    else:
        after = LateralSupport((0.8 * bounds.sum(), 0.0), spring)
        supports = LateralSupport((0.0, 0.0), spring), after
    drive = Drive(imposed, supports)
    step = step_in_time(half, resting(law, pressure), drive, 1.0, 1e-5)
    expected = solve_friction(
        half, bounds, imposed, support=drive.support(1.0, np.zeros(2))
    )
    assert expected.slipping.any()
    assert not expected.slipping[pressure > 0.0].all()
    difference = abs(step.contact.tractions - expected.tractions).max()
    assert difference < 1e-6 * bounds.max()


def test_damping_holds_the_load_that_friction_does_not():
    damping, load = 0.02, 0.2
    law = RateAndState(MU, A, 0.0, LENGTH, 1.0, damping=damping)
    contact = sliding_block(law)
    x = contact.tractions[0, 0, 0]
    supports = LateralSupport((x, 0.0)), LateralSupport((load, 0.0))
    drive = Drive(np.zeros((2, 1, 1)), supports)
    step = step_in_time(BLOCK, contact, drive, 1.0, 1e-4)
    rate = step.contact.rates[0, 0, 0]
    friction = PRESSURE * (MU + A * math.log(rate))
    assert friction + damping * rate == pytest.approx(load, rel=1e-5)


def test_tractions_of_atoms_that_stick_relax_like_the_solid():
    n, creep = 3, Creep((0.5, 2.0), (0.3, 2.0), flow=0.1)
    half = LateralHalfSpace((n, n), 1.0, Isotropic(1.0, 0.3))
    law = RateAndState(1e3, 1.0, 0.0, 1.0, 1e-9)
    pressure = np.ones((n, n))
    contact = replace(resting(law, pressure), past=[np.zeros((2, n, n))] * creep.terms)
    imposed = np.zeros((2, n, n))
    imposed[0] = 0.1
    drive, held = Drive(imposed), Drive(np.zeros((2, n, n)))
    first = step_in_time(half, contact, drive, 1e-9, 1e-8, creep=creep)
    step, time, duration = first, 0.0, 1e-3
    while time < 1.0:
        step = step_in_time(half, step.contact, held, duration, 1e-8, creep=creep)
        time, duration = time + duration, 1.1 * duration
    ratio = step.contact.tractions[0] / first.contact.tractions[0]
    assert ratio == pytest.approx(np.full((n, n), creep.relaxation(time)), rel=1e-3)
