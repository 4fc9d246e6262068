"""Fits of viscoelastic solids to an approach and a hold of closed form."""

import json
import math

import numpy as np
import pytest
from fitting import curve_formats as formats

from ase_roughcontact import fit_curves, read_fitted_curves
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.cli import main
from ase_roughcontact.fitting.curve_files import read_with_times
from ase_roughcontact.fitting.force_curve import ForceCurve
from ase_roughcontact.fitting.relaxation import fit_relaxation
from ase_roughcontact.fitting.series.row import FittedCurve
from ase_roughcontact.theory.indenters import Cone, named_indenter

NM, NN, KPA, N_M = (UNITS[unit] for unit in ("nm", "nN", "kPa", "N/m"))
ANGLE, RATE, RAMP, HOLD = math.radians(70.0), 500.0 * NM, 1.0, 8.0  # Å/s, s
RELAXED, RELAXING, TIME = 2.0 * KPA, 3.0 * KPA, 1.5
CONE = Cone(ANGLE)


def force_of_ramp(time):
    """Force of a cone that is pressed in at a constant rate and held, by integrals.

    With n = c (v t)^2: the integral of exp(-(t - s)/tau) 2 c v^2 s over the ramp.
    """
    c = float(CONE.force(1.0)) * RATE**2
    end = np.clip(time, 0.0, RAMP)
    fading = np.exp(-np.maximum(time, 0.0) / TIME)
    inside = np.exp(end / TIME) * (end - TIME) + TIME
    return c * (RELAXED * end**2 + RELAXING * 2.0 * TIME * fading * inside)


def measured(noise=0.0):
    """Times, and the curve, with the first contact at 1 s and a depth of 300 nm."""
    time = np.linspace(0.0, 2.0 + HOLD, 10001)
    depth = RATE * np.minimum(time - 1.0, RAMP) + 300.0 * NM
    force = force_of_ramp(time - 1.0)
    force += noise * NN * np.random.default_rng(0).normal(size=time.size)
    return time, ForceCurve(depth, force, 0.1 * N_M)


def test_relaxed_modulus_time_and_contact_are_found():
    fit = fit_relaxation(*measured(), CONE)
    assert fit.converged
    assert fit.contact_modulus == pytest.approx(RELAXED, rel=2e-3)
    assert fit.instantaneous_modulus == pytest.approx(RELAXED + RELAXING, rel=2e-3)
    assert fit.relaxation_times == pytest.approx([TIME], rel=2e-3)
    assert fit.relaxation_moduli == pytest.approx([0.6], rel=2e-3)
    assert fit.contact_depth == pytest.approx(300.0 * NM, abs=0.3 * NM)


def test_with_noise_they_are_within_their_errors():
    fit = fit_relaxation(*measured(noise=0.05), CONE)
    error = fit.contact_modulus_error
    assert abs(fit.contact_modulus - RELAXED) < 3.0 * error < 0.05 * RELAXED
    (time,), (error,) = fit.relaxation_times, fit.relaxation_times_errors
    assert abs(time - TIME) < 3.0 * error < 0.1 * TIME
    assert fit.warnings == ()


def test_holds_of_a_series_are_fitted_one_by_one(tmp_path):
    for number in (1, 2):
        time, curve = measured(noise=0.02 * number)
        lines = ["time (s),depth (nm),force (nN),branch"]
        depth, force = curve.depth / NM, curve.force / NN
        kinds = np.where(time < 1.0 + RAMP, "approach", "hold")
        points = zip(time, depth, force, kinds, strict=True)
        lines += [f"{t:.6f},{d:.6f},{f:.6f},{kind}" for t, d, f, kind in points]
        (tmp_path / f"{number}.csv").write_text("\n".join(lines) + "\n")
    folder = tmp_path / "out"
    files = [tmp_path / "1.csv", tmp_path / "2.csv"]
    found = list(fit_curves(files, "cone 70 deg", folder, relaxation=1))
    for curve in found:
        assert curve.contact_modulus == pytest.approx(RELAXED, rel=0.02)
        assert curve.instantaneous_modulus == pytest.approx(
            RELAXED + RELAXING, rel=0.02
        )
        assert curve.relaxation_times == pytest.approx([TIME], rel=0.05)
        assert curve.misfit == pytest.approx(1.0, abs=0.2)
    stored = read_fitted_curves(folder / "curves.csv")
    assert stored[1].relaxation_times == pytest.approx(found[1].relaxation_times)
    with pytest.raises(ValueError, match="--indenter"):
        next(fit_curves(files, relaxation=1))


def test_a_hold_that_is_too_short_is_doubted():
    time, curve = measured(noise=0.5)
    kept = time < 2.05
    short = ForceCurve(curve.depth[kept], curve.force[kept], curve.stiffness)
    fit = fit_relaxation(time[kept], short, CONE, terms=2)
    assert any("fit fewer terms" in w or "three standard" in w for w in fit.warnings)


@pytest.mark.parametrize("terms", [1, 2])
def test_relaxation_times_of_an_elastic_solid_are_not_known(terms):
    time, curve = measured()
    force = RELAXED * CONE.force(curve.depth - 300.0 * NM)
    force += 0.02 * NN * np.random.default_rng(0).normal(size=time.size)
    elastic = ForceCurve(curve.depth, force, curve.stiffness)
    fit = fit_relaxation(time, elastic, CONE, terms)
    unknown = np.isnan(fit.relaxation_times)
    assert unknown.any()
    np.testing.assert_array_equal(np.isnan(fit.relaxation_times_errors), unknown)
    assert sum("is not known" in warning for warning in fit.warnings) == unknown.sum()
    assert any("fit fewer terms" in w for w in fit.warnings) == (terms > 1)
    assert "not known" in str(fit)


def test_the_longest_relaxation_time_of_a_series_is_a_known_one():
    times = math.nan, 0.5, 1.5
    curve = FittedCurve("c.h5", "", 1, relaxation_times=times)
    assert curve.relaxation_time == 1.5


def test_times_that_do_not_increase_are_an_error():
    time, curve = measured()
    with pytest.raises(ValueError, match="increasing times"):
        fit_relaxation(time[::-1], curve, CONE)


@pytest.fixture
def file(tmp_path):
    """Approach, hold and retraction in a file of an instrument."""
    time, curve = measured(noise=0.02)
    height, force = curve.base / NM * 1e-9, curve.force / NN * 1e-9
    ramp = time < 2.0
    up = np.linspace(height[-1], height[0], 500), np.linspace(force[-1], 0.0, 500)
    parts = [(height[ramp], force[ramp]), (height[~ramp], force[~ramp]), up]
    keys = {"spring constant": 0.1, "sensitivity": 50e-9}
    formats.afm_hdf5(name := tmp_path / "c.h5", "creep-compliance", parts, **keys)
    return name


def test_approach_and_hold_of_an_instrument_are_read_with_their_times(file):
    time, curve = read_with_times(file)
    assert len(time) == 10001
    # the helper writes a point each millisecond
    fit = fit_relaxation(time, curve, named_indenter("cone 70 deg"))
    assert fit.relaxation_times == pytest.approx([TIME], rel=0.01)


def test_the_command_fits_a_hold(file, tmp_path, capsys):
    words = ["curve", str(file), "--indenter", "cone 70 deg", "--relaxation", "1"]
    words += ["--json", "--picture", str(tmp_path / "hold.png")]
    assert main(words) == 0
    line = json.loads(capsys.readouterr().out)
    assert line["relaxation_moduli"] == pytest.approx([0.6], rel=0.02)
    assert line["units"]["relaxation_times"] == "s"
    assert line["remarks"] == []  # the hold is not left out
    assert (tmp_path / "hold.png").exists()
    assert main([*words[:2], "--relaxation", "1"]) == 2
