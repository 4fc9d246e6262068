"""Creep and relaxation series of viscoelastic solids."""

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from ase_roughcontact.elasticity.creep import Creep, fit_relaxation

MODULI, TIMES = [0.3, 0.2, 0.4], [0.1, 1.0, 30.0]


@pytest.fixture(params=["solid", "fluid"])
def relaxation(request):
    """Relative moduli and relaxation times."""
    return (MODULI, TIMES) if request.param == "solid" else ([0.3, 0.7], [0.1, 1.0])


def test_creep_has_the_complex_modulus_of_its_relaxation_and_is_converted_back(
    relaxation,
):
    creep, (g, t) = Creep.of_relaxation(*relaxation), np.array(relaxation)
    frequency, time = np.logspace(-3, 3, 7)[:, None], np.logspace(-3, 2, 4)[:, None]
    expected = 1.0 - (g / (1.0 + 1j * frequency * t)).sum(axis=1)
    assert creep.modulus(frequency[:, 0]) == pytest.approx(expected, rel=1e-12)
    expected = 1.0 + (g * np.expm1(-time / t)).sum(axis=1)
    assert creep.relaxation(time[:, 0]) == pytest.approx(expected, abs=1e-12)


def test_convolution_of_creep_and_relaxation_is_the_time(relaxation):
    creep = Creep.of_relaxation(*relaxation)
    integral, _ = quad(
        lambda t: creep.compliance(t) * creep.relaxation(2.0 - t), 0.0, 2.0
    )
    assert integral == pytest.approx(2.0, rel=1e-9)


def test_standard_solid_creeps_slower_than_it_relaxes():
    creep = Creep.standard_solid(relaxed=0.2, time=3.0)
    assert creep.times == pytest.approx((15.0,))
    assert creep.relaxed == pytest.approx(0.2)
    assert creep.compliance(1e9) == pytest.approx(5.0)


@pytest.mark.parametrize("elapsed", [1e-9, 0.3, 1e6])
def test_a_step_solves_the_equations_of_the_terms(relaxation, elapsed):
    creep = Creep.of_relaxation(*relaxation)
    before, after, start = 2.0, 5.0, 0.7

    def rate(t, q):
        pressure = before + (after - before) * t / elapsed
        slow = (np.array(creep.compliances) * pressure - q[: len(creep.times)]) / (
            np.array(creep.times)
        )
        return np.append(slow, creep.flow * pressure)[: creep.terms]

    options = {"method": "Radau", "rtol": 1e-10, "atol": 1e-12}
    solved = solve_ivp(rate, (0.0, elapsed), np.full(creep.terms, start), **options)
    step = creep.over(elapsed)
    found = step.decay * start + step.old * before + step.new * after
    assert found == pytest.approx(solved.y[:, -1], rel=1e-7)


def test_a_sudden_step_is_instantaneous_and_a_long_one_relaxed():
    creep = Creep.standard_solid(0.2, 1.0)
    assert creep.over(0.0).compliance == 1.0
    assert creep.over(0.0)[:2] == (1.0, 0.0)
    assert creep.over(1e12).compliance == pytest.approx(5.0)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Creep([1.0], [1.0, 2.0]), "length"),
        (lambda: Creep([1.0], [-1.0]), "times"),
        (lambda: Creep([1.0], [1.0], flow=-1.0), "flow"),
        (lambda: Creep.of_relaxation([0.7, 0.7], [1.0, 2.0]), "1.4"),
        (lambda: Creep.standard_solid(1.5, 1.0), "1.5"),
        (lambda: Creep([1.0], [1.0]).over(-1.0), "elapsed"),
    ],
)
def test_errors_say_what_is_wrong(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_moduli_of_a_series_are_fitted():
    creep = Creep.of_relaxation([0.3, 0.5], [0.01, 1.0])
    omega = np.logspace(-2, 4, 61)
    moduli = 40.0 * creep.modulus(omega)
    fit = fit_relaxation(omega, moduli.real, moduli.imag, per_decade=2)
    assert fit.error < 1e-6
    assert fit.modulus == pytest.approx(40.0, rel=1e-5)
    assert fit.creep.modulus(omega) == pytest.approx(creep.modulus(omega), rel=1e-5)


def test_moduli_of_a_power_law_are_fitted_to_the_error_that_is_stated():
    omega = np.logspace(-3, 3, 49)
    moduli = (1j * omega) ** 0.3
    fit = fit_relaxation(omega, moduli.real, moduli.imag)
    found = fit.modulus * fit.creep.modulus(omega)
    error = np.sqrt(np.mean(abs(found / moduli - 1.0) ** 2))
    assert error == pytest.approx(fit.error, rel=1e-6)
    assert 1e-3 < fit.error < 0.05


def test_errors_of_measured_moduli_say_what_is_wrong():
    with pytest.raises(ValueError, match="length"):
        fit_relaxation([1.0, 2.0], [1.0, 2.0], [1.0])
    with pytest.raises(ValueError, match="elastic"):
        fit_relaxation([1.0, 10.0], [1.0, 1.0], [1e-9, 1e-9])


def test_series_over_twenty_decades_are_converted():
    times, moduli = np.logspace(-10.0, 10.0, 20), np.full(20, 0.99 / 20)
    creep = Creep.of_relaxation(moduli, times)
    assert creep.relaxed == pytest.approx(0.01, rel=1e-12)
    found, found_times = creep.relaxation_series()
    assert found_times[::-1] == pytest.approx(times, rel=1e-12)
    assert found == pytest.approx(moduli, rel=1e-11)


def test_maxwell_fluid_has_no_terms_but_its_flow():
    creep = Creep.of_relaxation([1.0], [2.0])
    assert creep == Creep((), (), flow=0.5)
    assert creep.terms == 1 and creep.relaxed == 0.0
    assert creep.compliance(3.0) == pytest.approx(2.5)
    assert creep.relaxation(2.0) == pytest.approx(np.exp(-1.0))
    assert creep.modulus(0.0) == 0.0


def test_equal_times_are_one_term():
    expected = Creep.of_relaxation([0.6], [1.0])
    found = Creep.of_relaxation([0.3, 0.3], [1.0, 1.0])
    assert found.times == pytest.approx(expected.times)
    assert found.compliances == pytest.approx(expected.compliances)
