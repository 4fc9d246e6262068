"""Rate and state friction: the law, against closed forms and an integrated state."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ase_roughcontact import RateAndState
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.interactions import STATE
from ase_roughcontact.interactions.friction import make_law
from ase_roughcontact.interactions.rate_and_state import radiation_damping

MU, A, B, LENGTH, RATE = 0.5, 0.01, 0.016, 3.0, 2.0
LAW = RateAndState(MU, A, B, LENGTH, RATE)
PRESSURE = np.array([0.5, 1.0, 2.0])


def bound(law, pressure, rate, state):
    rate, state = np.full(pressure.shape, rate), np.full(pressure.shape, state)
    nothing = np.full(pressure.shape, np.nan)
    history = {STATE.name: state}
    return law.bound(pressure, nothing, rate, math.nan, history, nothing, nothing)


@pytest.mark.parametrize("rate", [1e-3, 1.0, 1e4])
def test_steady_friction_has_the_logarithm_of_the_rate(rate):
    expected = MU + (A - B) * math.log(rate / RATE)
    found = bound(LAW, PRESSURE, rate, -math.log(rate / RATE))
    assert found == pytest.approx(expected * PRESSURE, rel=1e-12)


def test_friction_vanishes_at_rest_and_without_pressure():
    assert not bound(LAW, PRESSURE, 0.0, 3.0).any()
    assert not bound(LAW, -PRESSURE, 1.0, 3.0).any()
    # linear at rates far below the ones of the logarithm
    slow = np.array([1e-30, 2e-30])
    found = bound(LAW, np.ones(2), slow, 0.0)
    assert found[1] == pytest.approx(2.0 * found[0], rel=1e-6)


@pytest.mark.parametrize("rate", [1e-30, 1e-3, 1e4])
def test_the_rate_of_a_traction_is_the_inverse_of_the_bound(rate):
    traction = bound(LAW, PRESSURE, rate, 0.3)
    history = {STATE.name: np.full(3, 0.3)}
    found, slope = LAW.slip_rate(traction, PRESSURE, history)
    assert found == pytest.approx(np.full(3, rate), rel=1e-10)
    step = 1e-6 * traction
    above, _ = LAW.slip_rate(traction + step, PRESSURE, history)
    below, _ = LAW.slip_rate(traction - step, PRESSURE, history)
    assert slope == pytest.approx((above - below) / (2.0 * step), rel=1e-6)


@pytest.mark.parametrize("slip_law", [False, True])
@pytest.mark.parametrize("rate", [1e-6, 0.7, 5.0])
def test_the_state_at_a_constant_rate_is_the_integral_of_its_law(slip_law, rate):
    law = RateAndState(MU, A, B, LENGTH, RATE, slip_law=slip_law)

    def change(time, theta):
        ratio = rate * theta / LENGTH
        return -ratio * np.log(ratio) if slip_law else 1.0 - ratio

    start, duration = 0.4, 2.5
    theta = LENGTH / RATE * math.exp(start)
    end = solve_ivp(change, (0.0, duration), [theta], rtol=1e-11, atol=1e-14).y[0, -1]
    found = law.aged({STATE.name: np.array([start])}, np.array([rate]), duration)
    expected = math.log(RATE * end / LENGTH)
    assert found[STATE.name][0] == pytest.approx(expected, abs=1e-9)


def test_at_rest_the_state_of_the_ageing_law_grows_by_the_time():
    found = LAW.aged({STATE.name: np.zeros(1)}, np.zeros(1), 30.0)
    expected = math.log(1.0 + 30.0 * RATE / LENGTH)
    assert found[STATE.name][0] == pytest.approx(expected, rel=1e-12)


def test_at_rest_the_state_of_the_slip_law_stays():
    law = RateAndState(MU, A, B, LENGTH, RATE, slip_law=True)
    found = law.aged({STATE.name: np.full(1, 0.7)}, np.zeros(1), 30.0)
    assert found[STATE.name][0] == pytest.approx(0.7)


def test_damping_by_radiation_is_the_impedance_of_shear_waves():
    # 30 GPa and 2700 kg/m^3: a speed of 3333 m/s
    keys = {
        "coefficient": 0.6,
        "direct_effect": 0.01,
        "evolution_effect": 0.015,
        "distance": "1 nm",
        "velocity": "1 um/s",
        "density": 2700.0,
        "shear_modulus": 30.0,
    }
    law = make_law("rate-and-state", keys, 2.5)
    assert law.distance == 10.0
    assert law.velocity == 1e4
    expected = 2700.0 * math.sqrt(30e9 / 2700.0)
    assert law.damping / UNITS["Pa s/m"] == pytest.approx(expected, rel=1e-9)
    found = radiation_damping(30.0 * UNITS["GPa"], 2700.0 * UNITS["kg/m^3"])
    assert law.damping == pytest.approx(found)


def test_damping_needs_density_and_shear_modulus_or_neither():
    keys = {
        "coefficient": 0.6,
        "direct_effect": 0.01,
        "evolution_effect": 0.015,
        "distance": "1 nm",
        "velocity": "1 um/s",
    }
    with pytest.raises(ValueError, match="density and shear_modulus"):
        make_law("rate-and-state", {**keys, "density": 2700.0}, 2.5)
    assert make_law("rate-and-state", keys, 2.5).damping == 0.0


@pytest.mark.parametrize(
    "values", [(0.0, A, B, LENGTH, RATE), (MU, 0.0, B, LENGTH, RATE)]
)
def test_coefficient_and_direct_effect_are_positive(values):
    with pytest.raises(ValueError, match="must be"):
        RateAndState(*values)
