"""Fits of JKR and DMT to the retraction of a force curve."""

import json

import numpy as np
import pytest
from scipy.optimize import minimize

from ase_roughcontact import fit_curves
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.cli import main
from ase_roughcontact.fitting.adhesion import fit_adhesion
from ase_roughcontact.fitting.force_curve import ForceCurve

# E* (nN/nm^2), w (J/m^2), R (nm), stiffness (nN/nm)
SOFT = ("jkr", 50e-6, 5e-3, 5000.0, 0.1)
STIFF = ("dmt", 3.0, 0.02, 20.0, 10.0)
MODULUS = UNITS["nN"] / UNITS["nm"] ** 2


def contact(theory, modulus, work, radius, stiffness):
    """Heights of the base (nm), rising towards the pull-off, and forces (nN)."""
    a = np.linspace(0.0, 1.2 * radius, 20_001)[1:]
    depth, force = a**2 / radius, 4.0 / 3.0 * modulus * a**3 / radius
    if theory == "jkr":
        depth = depth - np.sqrt(2.0 * np.pi * work * a / modulus)
        force = force - np.sqrt(8.0 * np.pi * work * modulus * a**3)
    else:
        force = force - 2.0 * np.pi * work * radius
    base = -(depth + force / stiffness)
    stable = slice(int(np.argmax(base)), None)
    return base[stable][::-1], force[stable][::-1]


def measured(theory, modulus, work, radius, stiffness, noise=5e-3, seed=0):
    """Heights of the base (nm) and forces (nN) of both branches, with noise."""
    at, force = contact(theory, modulus, work, radius, stiffness)
    tension = -force.min()
    lowest = at[np.flatnonzero(force > 3.0 * tension)[-1]]
    base = np.linspace(lowest, at[-1] + 3.0 * (at[-1] - lowest), 1500)
    back = np.where(base > at[-1], 0.0, np.interp(base, at, force))
    forth = np.where(base > 0.0, 0.0, np.interp(base, at, force))
    forces = np.array([forth[::-1], back]) + 0.3 * tension
    forces += noise * tension * np.random.default_rng(seed).normal(size=forces.shape)
    return (base[::-1], forces[0]), (base, forces[1])


def curve_of(case, **options):
    base, force = np.hstack(measured(*case, **options))
    depth = -base - force / case[-1]
    stiffness = case[-1] * UNITS["N/m"]
    return ForceCurve(depth * UNITS["nm"], force * UNITS["nN"], stiffness, 1500)


@pytest.mark.parametrize("case", [SOFT, STIFF], ids=["jkr", "dmt"])
def test_modulus_and_work_of_adhesion_are_found_within_their_errors(case):
    theory, modulus, work, radius, _ = case
    deviations = []
    for seed in range(8):
        fit = fit_adhesion(curve_of(case, seed=seed), radius * UNITS["nm"], theory)
        assert fit.converged
        off = fit.contact_modulus - modulus * MODULUS
        deviations.append(off / fit.contact_modulus_error)
        off = fit.work_of_adhesion - work * UNITS["J/m²"]
        deviations.append(off / fit.work_of_adhesion_error)
    assert 0.4 < np.std(deviations) < 1.8
    assert fit.work_of_adhesion == pytest.approx(work * UNITS["J/m²"], rel=0.05)


def test_saturated_forces_are_left_out_of_a_fit_of_adhesion():
    theory, modulus, work, radius, _ = SOFT
    whole = curve_of(SOFT)
    force = np.minimum(whole.force, 0.4 * whole.force.max())
    depth = -whole.base - force / whole.stiffness
    fit = fit_adhesion(
        ForceCurve(depth, force, whole.stiffness, whole.turn),
        radius * UNITS["nm"],
        theory,
    )
    off = fit.contact_modulus - modulus * MODULUS
    assert abs(off) < 3.0 * fit.contact_modulus_error < 0.1 * fit.contact_modulus
    assert fit.work_of_adhesion == pytest.approx(work * UNITS["J/m²"], rel=0.05)


def test_a_fit_without_noise_is_exact():
    theory, modulus, work, radius, _ = SOFT
    fit = fit_adhesion(curve_of(SOFT, noise=1e-5), radius * UNITS["nm"], theory)
    assert fit.contact_modulus == pytest.approx(modulus * MODULUS, rel=2e-4)
    assert fit.work_of_adhesion == pytest.approx(work * UNITS["J/m²"], rel=2e-4)
    assert fit.contact_depth == pytest.approx(0.0, abs=0.1 * UNITS["nm"])


def test_a_fit_has_the_least_squares_of_an_independent_search():
    """Nelder and Mead's simplex on the closed forms, without derivatives."""
    radius = SOFT[3] * UNITS["nm"]
    fit = fit_adhesion(curve_of(SOFT), radius, "jkr", with_slope=False)
    assert 0 < np.sum(~fit.compared) < 5
    _, (base, force) = measured(*SOFT)
    last = int(np.argmax(np.diff(force)))
    tension = force[last + 1 :].mean() - force.min()

    def squares(x):
        at, values = contact("jkr", 50e-6 * x[0], 5e-3 * x[1], *SOFT[3:])
        inside = np.interp(base[: last + 1] - x[2], at, values) + tension * x[3]
        outside = np.full(len(base) - last - 1, tension * x[3])
        off = np.append(inside, outside) - force
        return np.sum(off[fit.compared] ** 2)

    options = {"xatol": 1e-6, "fatol": 1e-7, "maxiter": 2000}
    x = (0.9, 1.1, 1.0, 0.3)
    for _ in range(4):  # a simplex may stop too early
        found = minimize(squares, x, method="Nelder-Mead", options=options)
        x = found.x
    residual = (fit.fitted - fit.curve.force)[fit.compared] / UNITS["nN"]
    assert residual @ residual == pytest.approx(found.fun, rel=1e-5)
    off = fit.contact_modulus - 50e-6 * found.x[0] * MODULUS
    assert abs(off) < 0.1 * fit.contact_modulus_error
    off = fit.work_of_adhesion - 5e-3 * found.x[1] * UNITS["J/m²"]
    assert abs(off) < 0.1 * fit.work_of_adhesion_error


@pytest.mark.parametrize(("case", "other"), [(SOFT, "dmt"), (STIFF, "jkr")])
def test_the_theory_of_the_other_limit_is_a_warning(case, other):
    theory, radius = case[0], case[3] * UNITS["nm"]
    wrong = fit_adhesion(curve_of(case), radius, other)
    assert any(f"--adhesion {theory}" in warning for warning in wrong.warnings)
    right = fit_adhesion(curve_of(case), radius, theory)
    assert not any("Tabor" in warning for warning in right.warnings)


def test_a_retraction_without_tension_is_an_error():
    base = np.linspace(-100.0, 400.0, 500)
    force = np.where(base < 0.0, -0.01 * base, 0.0)
    force += 0.01 * np.random.default_rng(0).normal(size=500)
    depth = -(base + force / 0.1) * UNITS["nm"]
    curve = ForceCurve(depth, force * UNITS["nN"], 0.1 * UNITS["N/m"], 0)
    with pytest.raises(ValueError, match="no adhesion is found"):
        fit_adhesion(curve, 1e4)


def write(file, case):
    lines = ["height (nm),force (nN),branch"]
    for name, branch in zip(("approach", "retraction"), measured(*case), strict=True):
        lines += [f"{z:.5f},{f:.6f},{name}" for z, f in np.transpose(branch)]
    file.write_text("\n".join(lines) + "\n")


def test_the_commands_fit_the_work_of_adhesion(tmp_path, capsys):
    write(tmp_path / "a.csv", SOFT)
    words = [str(tmp_path / "a.csv"), "--cantilever", "0.1 N/m", "--adhesion", "jkr"]
    sphere = ["--indenter", "paraboloid 5 um", "--json"]
    picture = ["--picture", str(tmp_path / "a.png")]
    assert main(["curve", *words, *sphere, *picture]) == 0
    line = json.loads(capsys.readouterr().out)
    assert line["work_of_adhesion"] == pytest.approx(5e-3, rel=0.02)
    assert line["units"]["work_of_adhesion"] == "J/m²"
    assert (tmp_path / "a.png").exists()
    assert main(["curve", *words, *picture, "--indenter", "cone 35 deg"]) == 2
    assert "needs a sphere" in capsys.readouterr().err
    stiffness = 0.1 * UNITS["N/m"]
    options = {"adhesion": "jkr", "stiffness": stiffness}
    (curve,) = fit_curves(tmp_path / "a.csv", "paraboloid 5 um", **options)
    work = curve.work_of_adhesion / UNITS["J/m²"]
    assert work == pytest.approx(line["work_of_adhesion"], rel=1e-6)
