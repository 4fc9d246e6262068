"""Fits of moduli and times of relaxation to curves over time."""

import numpy as np
import pytest

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.cli import main
from ase_roughcontact.fitting.curve_files import read_in_time
from ase_roughcontact.fitting.time_fit import fit_in_time
from ase_roughcontact.scene import Scene

NM, NN = UNITS["nm"], UNITS["nN"]
TEXT = """
[substrate]
model = "atoms"
contact_modulus = 2.0
spacing = "4 nm"
shape = [20, 20]
relaxation_moduli = [0.6]
relaxation_times = [0.5]
[sphere]
radius = "100 nm"
[interaction]
kind = "hard"
[path]
kind = "time"
control = "penetration"
values = [0, "8 nm", 0]
rate = 20.0
dwell = 2.0
"""
TRUE = Scene.parse(TEXT)
CREEP = {"path.control": "load", "path.values": [0, 200.0], "path.rate": 1000.0}


def measured(scene, column, noise, shift=0.0):
    """Return a curve with noise, relative to its range, of a shifted tip (Å)."""
    if shift:
        values = [value - shift for value in (0.0, 8.0 * NM, 0.0)]
        scene = scene.with_values({"path.values": values})
    exact = scene.with_values({"path.tolerance": 1e-4})
    steps = list(exact.relax(validity="ignore"))
    time = np.linspace(0.0, steps[-1].time, 150)
    times, values = np.transpose([(s.time, getattr(s, column)) for s in steps])
    values = np.interp(time, times, values)
    noise *= np.ptp(values)
    return time, values + noise * np.random.default_rng(2).normal(size=len(time))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::ase_roughcontact.ValidityWarning")
def test_modulus_relaxation_and_height_are_recovered():
    time, force = measured(TRUE, "normal_force", 2e-3, shift=3.0)
    first = {"substrate.contact_modulus": 3.0, "substrate.relaxation_moduli": [0.3]}
    scene = TRUE.with_values(first | {"substrate.relaxation_times": [1.0]})
    free = "contact_modulus", "relaxation_moduli", "relaxation_times"
    fit = fit_in_time(scene, time, force, free)
    assert fit.converged, fit.warnings
    assert fit.names == (
        *("contact_modulus", "relaxation_moduli[0]", "relaxation_times[0]"),
        "height_offset",
    )
    true = np.array([2.0, 0.6, 0.5, 0.3])
    assert (abs(fit.values - true) < 3.0 * fit.errors).all()
    assert (fit.errors[:3] < 0.02 * true[:3]).all()
    assert fit.noise == pytest.approx(2e-3 * np.ptp(force), rel=0.2)
    assert set(fit.contributions) == {"noise", "grid", "time steps"}
    assert fit.warnings == ()


def test_errors_agree_with_the_linearised_problem():
    time, force = measured(TRUE, "normal_force", 5e-3)
    fit = fit_in_time(TRUE, time, force, ["contact_modulus"])
    (_, low), (_, high) = (
        measured(TRUE, "normal_force", 0.0, shift=s) for s in (-1.0, 1.0)
    )
    # forces are proportional to the modulus; heights in nm
    slopes = np.stack([fit.fitted / fit.values[0], (high - low) * NM / 2.0], axis=1)
    covariance = fit.noise**2 * np.linalg.inv(slopes.T @ slopes)
    errors = np.sqrt(np.diag(covariance))
    assert fit.contributions["noise"] == pytest.approx(errors, rel=0.1)
    expected = covariance[0, 1] / errors.prod()
    assert fit.correlation[0, 1] == pytest.approx(expected, abs=0.05)


def test_creep_of_a_table_is_fitted_by_the_command(tmp_path, capsys):
    scene = TRUE.with_values(CREEP)
    time, depth = measured(scene, "penetration", 2e-3)
    file, table = tmp_path / "creep.toml", tmp_path / "creep.csv"
    first = {"substrate.relaxation_moduli": [0.5]}
    file.write_text(scene.with_values(first).toml)
    rows = (
        f"{1e3 * t:.9g};{(d + 2.0) / NM:.9g}" for t, d in zip(time, depth, strict=True)
    )
    table.write_text("\n".join(["time (ms);depth (nm)", *rows]))
    picture = tmp_path / "fit.png"
    assert main(["fit", str(table), str(file), "--picture", str(picture)]) == 0
    printed = capsys.readouterr().out
    rows = {
        words[0]: words[1:] for words in map(str.split, printed.splitlines()) if words
    }
    for name, value in (("relaxation_moduli[0]", 0.6), ("relaxation_times[0]", 0.5)):
        found, error = map(float, rows[name][:2])
        assert abs(found - value) < 3.0 * error < 0.1 * value
    assert float(rows["height_offset"][0]) == pytest.approx(-0.2, abs=0.05)
    assert picture.stat().st_size > 10_000


@pytest.mark.slow
def test_terms_that_a_curve_does_not_show_are_named():
    time, force = measured(TRUE, "normal_force", 2e-3)
    two = {"relaxation_moduli": [0.3, 0.3], "relaxation_times": [0.49, 0.51]}
    scene = TRUE.with_values({f"substrate.{k}": v for k, v in two.items()})
    fit = fit_in_time(scene, time, force, ["relaxation_moduli"])
    assert any("can't both be determined" in each for each in fit.warnings)


def test_another_path_than_the_measured_one_is_doubted():
    time, force = measured(TRUE, "normal_force", 1e-3)
    scene = TRUE.with_values({"path.rate": 10.0})
    fit = fit_in_time(scene, time, force, ["contact_modulus"])
    assert any("the path" in each for each in fit.warnings)


@pytest.mark.parametrize(
    ("keys", "time", "free", "message"),
    [
        ({}, [0.0, 1.0, 9.0, 2.0, 2.1, 2.2], ["relaxation_times"], "lasts from 0 to 9"),
        ({}, [0.0, 1.0], ["relaxation_times"], "4 points"),
        ({}, [0.0, 1.0], ["hardness"], "free parameter"),
        (
            {"substrate.relaxation_moduli": [1.0]},
            [0.0, 1.0, 1.1, 1.2, 1.3],
            ["relaxation_moduli"],
            "below 1",
        ),
    ],
)
def test_errors_say_what_is_expected(keys, time, free, message):
    scene = TRUE.with_values(keys)
    with pytest.raises(ValueError, match=message):
        fit_in_time(scene, np.array(time), np.zeros(len(time)), free)


def test_a_deflection_in_volts_over_time_is_a_force(tmp_path):
    file = tmp_path / "curve.csv"
    file.write_text(
        "branch,time (s),deflection (V)\napproach,1,0.5\nretraction,2,0.2\n"
    )
    stiffness = 3.0 * UNITS["N/m"]
    for branch, times, volts in ((None, [1, 2], [0.5, 0.2]), ("approach", [1], [0.5])):
        time, force = read_in_time(file, "force", branch, stiffness, "50 nm/V")
        assert time == pytest.approx(times)
        assert force == pytest.approx(150.0 * NN * np.array(volts))
    with pytest.raises(ValueError, match="--sensitivity"):
        read_in_time(file, "force", stiffness=stiffness)


def test_equal_values_are_refused():
    time = np.linspace(0.0, 2.0, 10)
    with pytest.raises(ValueError, match="10 measured values"):
        fit_in_time(TRUE, time, np.zeros(10), ["contact_modulus"])


def test_a_table_without_times_is_refused(tmp_path):
    (file := tmp_path / "curve.csv").write_text("depth (nm),force (nN)\n1,2\n2,3\n")
    with pytest.raises(ValueError, match=r"time \(s\) and force"):
        read_in_time(file, "force")
