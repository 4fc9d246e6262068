"""Fits of force curves: derivatives, recovered parameters, errors, jumps."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from force_curves import sampled
from matplotlib.figure import Figure

from ase_roughcontact import cantilever_curve
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.cli import main
from ase_roughcontact.fitting.figures import draw_fit
from ase_roughcontact.fitting.fit import fit_curve
from ase_roughcontact.fitting.force_curve import ForceCurve
from ase_roughcontact.fitting.least_squares import Fit
from ase_roughcontact.fitting.parameters import (
    FREE,
    ForceDerivatives,
    changed,
    value_of,
)
from ase_roughcontact.fitting.residuals import Residuals
from ase_roughcontact.fitting.smooth_fit import SmoothFit, smooth_fit
from ase_roughcontact.scene import Scene, relax_loop
from ase_roughcontact.scene.config import InteractionConfig
from ase_roughcontact.theory import sphere_theory

SCENE = """
[substrate]
model = "atoms"
spacing = 3.0
shape = [12, 12]
contact_modulus = 30.0
hardness = inf
[sphere]
radius = "3 nm"
[roughness]
unit = "a0"
rms_slope = 0.1
long_wavelength = 16.0
seed = 1
[interaction]
kind = "adhesive"
work_of_adhesion = {work}
[path]
kind = "loop"
deepest = "0.1 nm"
tolerance = 0.03
cantilever = {stiffness}
"""
NN = UNITS["nN"]
NOISE = 0.02 * NN
OFFSET, SLOPE = 0.3, -0.02  # of the baseline (nN, nN/nm)
ZERO = 37.0  # height at which the depth of the curves is zero


def scene(work=0.1, stiffness=2.0):
    return Scene.parse(SCENE.format(work=work, stiffness=stiffness))


def curve_of(scene, noise=NOISE, points=60):
    """Approach and retraction at equal steps of the base, with noise."""
    exact = cantilever_curve(relax_loop(scene, validity="ignore"), scene.cantilever)
    zero = scene.first_contact
    return sampled(exact, 25.0 - zero, points, noise, ZERO - zero)


@pytest.fixture(scope="module")
def measured():
    return curve_of(scene())


@pytest.fixture(scope="module")
def drifted(measured):
    height = (measured.base - measured.base.max()) / UNITS["nm"]
    return measured.less(-NN * (OFFSET + SLOPE * height))


@pytest.fixture(scope="module")
def trials():
    return []


@pytest.fixture(scope="module")
def fitted(drifted, trials):
    free = ["force_offset", "work_of_adhesion", "force_slope"]
    start = scene(work=0.085)
    return fit_curve(start, drifted, free, lambda *trial: trials.append(trial))


def forces_and_derivatives(scene, heights, free=(), with_range=False):
    """Forces at heights, and their derivatives to parameters."""
    held = scene.with_values(
        {"path.control": "height", "path.kind": "steps", "solver.accuracy": 1e-10}
    )
    stepper = held.stepper(held.frames())
    derivatives = ForceDerivatives(scene, free, with_range)
    forces, rows, state = [], [], stepper.start
    for height in heights:
        relaxed = stepper.relax(state, height)
        forces.append(relaxed.fields.normal_force)
        rows.append(derivatives.of(relaxed))
        state = stepper.commit(relaxed).state
    return np.array(forces), np.array(rows)


def difference(forces, value):
    """Derivative of forces to a parameter by differences of fourth order."""
    near, far = (
        forces(value * (1 + step)) - forces(value * (1 - step)) for step in (1e-4, 2e-4)
    )
    return (8 * near - far) / (12e-4 * value)


def test_derivatives_agree_with_differences():
    made = scene().with_values({"interaction.attraction_range": "0.12 nm"})
    heights = made.first_contact - np.array([2.0, 0.5])
    _, derivatives = forces_and_derivatives(made, heights, FREE)
    for i, name in enumerate(FREE):

        def forces(x, name=name):
            return forces_and_derivatives(changed(made, {name: x}), heights)[0]

        expected = difference(forces, value_of(made, name))
        np.testing.assert_allclose(derivatives[:, i], expected, rtol=1e-6)


def attractive(kind, attraction_range, **parameters):
    """Scene with a wall of a range (Å)."""
    parameters |= {"work_of_adhesion": 0.1}
    parameters["attraction_range"] = f"{attraction_range:.17g} Å"
    return scene().with_values(
        {
            "interaction": InteractionConfig(kind, parameters),
            "substrate.shape": (28, 28),
        }
    )


@pytest.mark.parametrize(
    "kind, others", [("power-law", {"relative_cutoff": 4.0}), ("dugdale", {})]
)
def test_the_derivative_to_the_range_agrees_with_differences(kind, others):
    made = attractive(kind, 3.0, **others)
    heights = made.first_contact - np.array([1.5, 0.5])
    _, rows = forces_and_derivatives(made, heights, with_range=True)

    def forces(x):
        return forces_and_derivatives(attractive(kind, x, **others), heights)[0]

    expected = 3.0 * difference(forces, 3.0)  # to the logarithm
    np.testing.assert_allclose(rows[:, 0], expected, rtol=1e-4)


def test_a_curve_has_branches_jumps_and_noise(measured):
    down, up = measured.branches
    assert (down.direction, up.direction) == (-1.0, 1.0)
    assert (down.points.stop, up.points.stop) == (60, 119)
    assert measured.noise == pytest.approx(NOISE, rel=0.2)
    assert measured.deepest == pytest.approx(measured.depth.max(), abs=0.2)
    for branch in (down, up):
        force = measured.force[branch.points]
        jump = branch.direction * (force[branch.jump + 1] - force[branch.jump])
        assert jump > 0.2 * NN
    assert ForceCurve(measured.depth, measured.force).branches[0].jump is not None


def test_parameters_are_recovered_from_a_curve_with_jumps_and_drift(
    fitted, drifted, trials
):
    assert fitted.converged
    assert dict(zip(fitted.names, fitted.units, strict=True)) == {
        **{"work_of_adhesion": "J/m²", "force_offset": "nN", "force_slope": "nN/nm"},
        "height_offset": "nm",
    }
    true = np.array([0.1, OFFSET, SLOPE, ZERO / 10])
    by_noise = fitted.contributions["noise"]
    assert (abs(fitted.values - true) < 3 * by_noise).all()
    assert (by_noise < [0.0025, 0.01, 0.005, 0.0034]).all()
    assert fitted.noise == pytest.approx(NOISE, rel=0.2)
    assert -1.0 < fitted.correlation[0, -1] < 0.0
    np.testing.assert_allclose(np.diag(fitted.correlation), 1.0)
    assert "work_of_adhesion" in str(fitted) and "J/m²" in str(fitted)
    # all forces agree with the fit, but at the jumps, which are not compared
    assert np.count_nonzero(~fitted.compared) < 10
    residual = (fitted.fitted - drifted.force)[fitted.compared]
    assert np.abs(residual).max() < 5 * NOISE
    # the first trial has the force of the free tip
    (first, largest), (last, rms) = trials[0], trials[-1]
    assert list(first) == list(fitted.names)
    assert first["force_offset"] == pytest.approx(OFFSET, abs=0.03)
    assert last["force_offset"] == pytest.approx(fitted.values[1], abs=0.01)
    assert rms < largest


def test_a_smooth_sphere_has_the_same_work_without_the_baseline(measured, drifted):
    found = smooth_fit(scene(), drifted, ["force_offset", "force_slope"])
    smooth = smooth_fit(scene(), measured)
    without = smooth.work_of_adhesion
    assert smooth.theory == "Maugis-Dugdale" and 0.05 < without < 0.15
    for branch in measured.branches:  # it snaps in and is pulled off
        base, force = measured.base[branch.points], smooth.fitted[branch.points]
        deepest = np.argmin(base)
        assert force[np.argmax(base)] == 0.0
        last = measured.force[branch.points][deepest]
        assert force[deepest] == pytest.approx(last, rel=0.2)
    assert found.work_of_adhesion == pytest.approx(without, rel=0.05)
    assert smooth_fit(scene(), drifted).work_of_adhesion < 0.9 * without


def test_derivatives_of_residuals_agree_with_differences(measured):
    problem = Residuals(scene(), measured, ["work_of_adhesion"])
    x = np.array([1.0, ZERO / 10 - problem.values(problem.start)[1]])
    change = np.array([0.02, 0.005])
    low, high = (problem.trial(each).residuals for each in (x - change, x + change))
    rows = problem.trial(x).jacobian
    expected = 0.5 * (high - low)
    # within the kinks of the force, where atoms come into contact
    np.testing.assert_allclose(rows[-2:] @ change, expected[-2:], rtol=0.25)
    agree = abs(rows @ change - expected) < 0.05 * abs(expected).max()
    assert np.count_nonzero(~agree) < 6  # points that come to a jump or leave it


def test_a_jump_is_known_to_the_distance_of_the_points_around_it(measured):
    problem = Residuals(scene(), measured, [])
    rows = problem.trial(problem.start).jacobian[-2:, -1]  # standard errors per nm
    for row, branch in zip(rows, measured.branches, strict=True):
        base = measured.base[branch.points][branch.jump : branch.jump + 2]
        uniform = abs(np.diff(base)) / np.sqrt(12)
        assert abs(row) == pytest.approx(UNITS["nm"] / uniform[0])


def test_points_between_a_jump_and_its_counterpart_are_not_compared(measured):
    problem = Residuals(scene(), measured, ["work_of_adhesion"])
    trial = problem.trial(problem.start * [1.5, 1.0])  # it is pulled off later
    up = measured.branches[1]
    after = up.points.start + up.jump + 2
    left_out = ~trial.compared[after:-2]
    assert np.count_nonzero(left_out) > 3 and not left_out[-10:].any()
    assert not trial.residuals[after:-2][left_out].any()
    assert not trial.jacobian[after:-2][left_out].any()
    # which does not pay, as the pull-off itself is compared
    count = np.count_nonzero(left_out) - 2.0
    assert trial.residuals[-1] ** 2 > 9.0 * count


def test_the_change_by_the_grid_agrees_with_much_finer_grids(measured):
    smooth = scene().with_values({"roughness": None, "path.tolerance": 3e-3})
    fine = smooth.with_values({"substrate.model": "continuum", "substrate.refine": 4})
    problem = Residuals(smooth, measured, [])
    given = problem.trial(problem.start)
    other = problem.trial(problem.start, fine)
    change = problem.changes(given)["grid"][:, 0]
    both = given.compared & other.compared & (change != 0.0)
    assert np.count_nonzero(both) > 30
    # the error is quadratic
    expected = (other.residuals - given.residuals)[both] * 16 / 15
    error = np.linalg.norm(change[both] - expected) / np.linalg.norm(expected)
    assert error < 0.5


def test_the_range_of_the_wall_is_in_the_errors_of_a_fit():
    assumed, true = (
        attractive("exponential", x, relative_cutoff=4.0).with_values(
            {"roughness": None}
        )
        for x in (2.5, 1.5)
    )
    curve = curve_of(true, points=40)
    found = fit_curve(assumed, curve)
    error = abs(found.values[0] - 0.1)
    assert 3.0 * found.contributions["noise"][0] < error < 2.0 * found.errors[0]
    squares = sum(part**2 for part in found.contributions.values())
    np.testing.assert_allclose(found.errors**2, squares)
    # a factor of two, with effects on branches and jumps that are added without signs
    problem = Residuals(assumed, curve, ["work_of_adhesion"])
    first = problem.values(problem.start)
    trial = problem.trial(
        np.array([found.values[0] / first[0], found.values[1] - first[1]])
    )
    changes = problem.changes(trial)["range"].sum(axis=1)
    by_point = (np.linalg.pinv(trial.jacobian) * changes)[0]
    parts = [by_point[branch.points].sum() for branch in curve.branches]
    expected = abs(np.array([*parts, *by_point[-2:]])).sum() * first[0]
    assert found.contributions["range"][0] == pytest.approx(expected)


def test_a_factor_of_two_of_the_range_changes_the_residuals_by_their_derivative(
    measured,
):
    model = Residuals(scene(), measured, ["work_of_adhesion"])
    trial = model.trial(model.start)
    change = model.changes(trial)["range"].sum(axis=1)
    assert abs(trial.by_range).max() > 0.0
    np.testing.assert_allclose(change, np.log(2.0) * trial.by_range)


def test_standard_errors_do_not_depend_on_the_noise_that_weights_the_points():
    """Few points of a repulsive contact, pressed in by a stiff instrument."""
    repelled = scene().with_values({"interaction": InteractionConfig("repulsive")})
    soft, free = curve_of(repelled, points=6), ["contact_modulus"]
    curve = ForceCurve(soft.depth, soft.force)
    found = fit_curve(repelled, curve, free)
    squares = np.sum((found.fitted - curve.force)[found.compared] ** 2)
    degrees = found.compared.sum() - len(found.values)
    assert 5 < degrees < 10
    assert found.noise == pytest.approx(np.sqrt(squares / degrees), rel=1e-9)
    weighted = ForceCurve(curve.depth, curve.force)
    weighted.__dict__["noise"] = 3.0 * curve.noise
    other = fit_curve(repelled, weighted, free)
    np.testing.assert_allclose(other.errors, found.errors, rtol=1e-3)
    assert other.noise == pytest.approx(found.noise, rel=1e-3)


@pytest.mark.parametrize(
    "radius, modulus, name",
    [(1e6, 30.0, "JKR"), (4.0, 30.0, "MD"), (0.4, 3000.0, "DMT")],
)
@pytest.mark.parametrize("stiffness", [1.0, np.inf])
def test_the_fit_of_a_smooth_sphere_agrees_with_theory(
    radius, modulus, name, stiffness
):
    made = scene().with_values(
        {"sphere.radius": f"{radius} nm", "substrate.contact_modulus": modulus}
    )
    wall = made.wall
    sphere = made.radius, made.contact_modulus, wall.work_of_adhesion
    theory = sphere_theory(*sphere, wall.attraction_range)
    assert theory.symbol == name
    depth, force = theory.curve(2.0 * float(theory.contact_radius(0.0)))
    stable = slice(int(np.argmin(force)), None)
    order = np.argsort(-depth[stable])
    depth, force = depth[stable][order] + 0.7, force[stable][order]
    curve = ForceCurve(depth, force, stiffness * radius * UNITS["N/m"])
    start = made.with_values({"interaction.work_of_adhesion": 0.06})
    smooth = smooth_fit(start, curve)
    assert smooth.theory == theory.name
    assert smooth.work_of_adhesion == pytest.approx(0.1, rel=0.02)


def test_the_command_fits_a_table_and_draws_it(tmp_path, capsys, measured):
    base = -measured.depth - measured.force / measured.stiffness
    bend = measured.force / measured.stiffness
    lines = ["distance (nm),deflection (nm),force (nN)"]
    lines += [
        f"{d / 10},{b / 10},{f / NN}"
        for d, b, f in zip(base, bend, measured.force, strict=True)
    ]
    (tmp_path / "curve.csv").write_text("\n".join(lines))
    text = SCENE.format(work=0.1, stiffness=1.0).replace("cantilever = 1.0", "")
    (tmp_path / "scene.toml").write_text(text)
    picture = tmp_path / "fit.png"
    files = [str(tmp_path / name) for name in ("curve.csv", "scene.toml")]
    options = ["--free", "work_of_adhesion, force_offset", "--picture", str(picture)]
    assert main(["fit", *files, *options]) == 0
    text, trials = capsys.readouterr()
    # a short ramp, which ends within the range of the attraction
    assert trials.startswith("note: the free force of the retraction changes by")
    line = r"^residual/noise [\d.]+: work_of_adhesion 0\.1, force_offset 0\.0"
    assert re.search(line, trials, re.MULTILINE)
    assert len(trials.splitlines()) > 1
    assert re.search(r"parameter +value +± error +unit +noise +range +grid\n", text)
    assert re.search(r"force_offset +\S+ +\S+ +nN +\S+ +\S+ +\S+\n", text)
    assert re.search(r"work_of_adhesion +0\.\d+ +\S+ +J/m²", text)
    assert "smooth sphere (Maugis-Dugdale): work_of_adhesion 0." in text
    assert picture.stat().st_size > 10_000


def with_forces(curve, change=0.0, stiffness=None, depth=None):
    """Curve with other forces, at the same depths if none are given."""
    k = curve.stiffness if stiffness is None else stiffness
    return ForceCurve(curve.depth if depth is None else depth, curve.force + change, k)


def reversed_force(curve):
    """Curve with forces of the wrong sign, at the same heights of the base."""
    depth = curve.force / curve.stiffness - curve.base
    return with_forces(curve, -2.0 * curve.force, depth=depth)


def test_a_wrong_sign_is_reported_before_the_first_trial(measured):
    assert measured.doubts == []
    away = with_forces(
        measured, depth=-measured.depth - 2.0 * measured.force / measured.stiffness
    )
    for wrong in (away, reversed_force(measured)):
        (doubt,) = wrong.doubts
        assert "negative in tension" in doubt
    for name, wrong in (("distance", away), ("force", reversed_force(measured))):
        with pytest.raises(ValueError, match=f"sign of the {name}"):
            fit_curve(scene(), wrong)
    small, trials = scene().with_values({"substrate.shape": (2, 2)}), []
    reported = pytest.warns(UserWarning, match="tension")
    failed = pytest.raises(ValueError, match=r"ended with: .*edge")
    with reported, failed:
        fit_curve(small, reversed_force(measured), callback=trials.append)
    assert not trials


def test_the_points_of_a_jump_may_be_at_one_height_of_the_base(measured):
    base = measured.base.copy()
    for branch in measured.branches:
        last = branch.points.start + branch.jump
        base[last] = base[last + 1]
    depth = -base - measured.force / measured.stiffness
    found = fit_curve(scene(), ForceCurve(depth, measured.force, measured.stiffness))
    assert found.converged
    assert found.values[0] == pytest.approx(0.1, rel=0.1)


def offset(curve):
    return with_forces(curve, 0.1 * NN)


def in_contact(curve):
    """Curve that ends in contact: it has no free part."""
    near = curve.base < curve.base.min() + 3.0
    part = ForceCurve(curve.depth[near], curve.force[near], curve.stiffness)
    assert part.far_force > 5.0 * NOISE
    return part


def without_deflection(curve):
    """Curve with a depth other than -(base + bend)."""
    return with_forces(curve, 0.0, np.inf, curve.force / curve.stiffness - curve.base)


def pulled(curve):
    """Curve with a force that is not in the scene, not far above the noise."""
    first, last = np.quantile(curve.base, [0.5, 0.8])
    return with_forces(
        curve, -3.0 * NOISE * ((curve.base > first) & (curve.base < last))
    )


@pytest.mark.parametrize(
    ("change", "free", "message"),
    [
        (in_contact, [], None),
        (offset, [], r"the free part of the curve is at 0\.107 nN, not zero"),
        (without_deflection, [], r"the residuals of 0\.\d+ nN are far above the noise"),
        (pulled, ["work_of_adhesion"], r"the fit is .* points in a row"),
    ],
)
def test_a_fit_warns_of_what_is_not_in_the_scene(measured, change, free, message):
    found = fit_curve(scene(), change(measured), free)
    printed = " ".join(str(found).split())
    assert all(f"warning: {warning}" in printed for warning in found.warnings)
    if message is None:
        assert found.warnings == ()
    else:
        assert any(re.match(message, warning) for warning in found.warnings)


@pytest.mark.parametrize(("largest", "doubtful"), [(0.5, True), (0.9999, False)])
def test_a_fit_warns_of_correlated_parameters(largest, doubtful, monkeypatch):
    # 0.87 to 0.998, which depends on single atoms
    monkeypatch.setattr(
        "ase_roughcontact.fitting.least_squares.MAX_CORRELATION", largest
    )
    repelled = scene().with_values({"interaction": InteractionConfig("repulsive")})
    curve = curve_of(repelled, noise=0.1 * NOISE, points=15)
    found = fit_curve(repelled, curve, ["contact_modulus", "radius"])
    assert found.converged
    warned = ["can't both be determined" in warning for warning in found.warnings]
    assert any(warned) == doubtful


@pytest.mark.parametrize(
    ("value", "row"), [(19.2e-6, "19.200 1.0 kPa 1.0"), (2.5e-8, "25.000 1.0 Pa 1.0")]
)
def test_moduli_of_soft_samples_are_printed_in_small_units(value, row):
    scale = UNITS[row.split()[2]] / UNITS["GPa"]
    error, point = np.array([scale]), np.zeros(1)
    names, units = ("contact_modulus",), ("GPa",)
    arrays = np.array([value]), error, {"noise": error}, np.eye(1), point, point, point
    fit = Fit(names, units, *arrays, np.ones(1, bool), 1.0, True)
    assert f"contact_modulus {row}" in " ".join(str(fit).split())


def fit_with(monkeypatch, trial, curve):
    """Fit with other trials; return the fit and what was reported of them."""
    exact, trials = Residuals.trial, []
    monkeypatch.setattr(Residuals, "trial", lambda *given: trial(exact, *given))
    fit = fit_curve(scene(0.05), curve, callback=lambda *each: trials.append(each))
    return fit, trials


def test_a_fit_without_progress_ends_and_is_not_converged(measured, monkeypatch):
    calls = []

    def worse(exact, *given):  # at each call
        calls.append(given)
        trial = exact(*given)
        return replace(trial, residuals=trial.residuals * 1.3 ** len(calls))

    found, trials = fit_with(monkeypatch, worse, measured)
    assert not found.converged
    assert str(found).startswith("NOT CONVERGED")
    assert 1 < len(trials) <= 7  # two with progress


@pytest.mark.parametrize("error", [RuntimeError, ZeroDivisionError, OverflowError])
def test_a_trial_that_fails_leaves_the_best_one_so_far(measured, monkeypatch, error):
    calls = []

    def failing(exact, problem, x, *scene):
        calls.append(x)
        if len(calls) == 3:
            raise error("the window is too small")
        return exact(problem, x, *scene)

    found, trials = fit_with(monkeypatch, failing, measured)
    assert len(trials) == 2 and not found.converged
    assert found.warnings[0].endswith("can't be calculated: the window is too small")
    best = min(trials, key=lambda trial: trial[1])[0]
    assert found.values[0] == pytest.approx(best["work_of_adhesion"])


def test_a_pull_off_in_a_gap_of_the_points_is_named(measured):
    away = measured.branches[1]
    last = away.points.start + away.jump
    kept = np.r_[: last - 3, last + 5 : measured.force.size]
    points = measured.depth[kept], measured.force[kept], measured.stiffness
    (warning,) = fit_curve(scene(), ForceCurve(*points)).warnings
    first, end = measured.base[[last - 4, last + 5]] / UNITS["nm"]
    assert warning.startswith("the pull-off is in a gap of the measured points")
    assert f"at {first:.4g} to {end:.4g} nm" in warning


def test_wrong_fits_are_refused(measured):
    def fit(depth, free):
        fit_curve(scene(), ForceCurve(depth, np.zeros(3)), free)

    with pytest.raises(ValueError, match="4 points, got 3"):
        fit([1.0, 2.0, 3.0], ["radius", "contact_modulus"])
    with pytest.raises(ValueError, match="'hurst'"):
        fit([1.0, 2.0, 3.0], ["hurst"])
    with pytest.raises(ValueError, match=r"shapes \(2,\) and"):
        fit([1.0, 2.0], ["radius"])
    hard = scene().with_values({"interaction": InteractionConfig(kind="hard")})
    with pytest.raises(ValueError, match='kind = "adhesive"'):
        fit_curve(hard, measured)
    with pytest.raises(ValueError, match="5 measured values"):
        fit_curve(hard, ForceCurve(np.arange(5.0), np.full(5, 3.0)), ["radius"])


def test_a_fit_is_drawn_as_curve_residuals_and_tension(tmp_path, monkeypatch, fitted):
    figures = []

    def saved(figure, file, **_):
        figures.append(figure)
        Path(file).touch()

    monkeypatch.setattr(Figure, "savefig", saved)
    smooth = SmoothFit(0.1, "JKR", 0.9 * fitted.fitted)
    draw_fit(fitted, smooth, tmp_path / "fit.png")
    (figure,) = figures
    upper, lower, detail = figure.axes
    measured, points = fitted.distance / UNITS["nm"], fitted.compared.copy()
    points[: np.argmin(measured) + 1] = False  # the points of the retraction
    for axes in (upper, detail):
        assert axes.get_ylabel() == "normal force $N$ (nN)"
        lines = {line.get_label(): line.get_data() for line in axes.lines}
        along, force = lines["fit"]
        turn = np.argmin(along) + 1
        drawn = np.interp(measured, along[turn:], force[turn:])
        np.testing.assert_allclose(drawn[points], fitted.fitted[points] / NN, atol=1e-3)
        for label, expected in (
            ("smooth sphere", smooth.fitted),
            ("measured at a jump, not compared", fitted.force[~fitted.compared]),
        ):
            np.testing.assert_allclose(lines[label][1], expected / NN)
    residuals = ((fitted.fitted - fitted.force) / NN)[fitted.compared]
    np.testing.assert_allclose(lower.lines[0].get_ydata(), residuals)
    # the detail shows the largest tension, and not all of the curve
    low, high = detail.get_ylim()
    assert low < fitted.force.min() / NN < fitted.far_force / NN < high
    assert np.ptp(detail.get_xlim()) < 0.9 * np.ptp(measured)


def test_masked_points_of_a_curve_are_refused(measured):
    force = np.ma.array(measured.force, mask=measured.force == measured.force.max())
    with pytest.raises(ValueError, match="force must be finite"):
        ForceCurve(measured.depth, force)
