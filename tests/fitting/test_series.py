"""Fits of many force curves: maps, archives, series of files."""

import base64
import json
import re
import zipfile
from concurrent.futures import Future
from pathlib import Path

import numpy as np
import pytest
from curve_formats import jpk_map
from matplotlib.figure import Figure
from scipy.optimize import brentq, curve_fit

from ase_roughcontact import FittedCurves, fit_curves, read_fitted_curves
from ase_roughcontact._util.printing import plain
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.cli import main
from ase_roughcontact.cli.curves_page import page_of_curves
from ase_roughcontact.fitting.curve_files import read_curve
from ase_roughcontact.fitting.series.figures import draw_series
from ase_roughcontact.fitting.series.grid import grid_of
from ase_roughcontact.fitting.series.listing import curve_at, listed_curves
from ase_roughcontact.fitting.series.row import FittedCurve
from ase_roughcontact.fitting.series.summary import SeriesSummary

RADIUS, STIFFNESS, NOISE = 5000.0, 0.05, 0.01  # nm, nN/nm, nN
SOFT, STIFF = 2e-6, 40e-6  # nN/nm^2: 2 and 40 kPa
SHAPE, PIXEL = (6, 4), 2.0  # columns and rows, um
OPTIONS = {"stiffness": STIFFNESS * UNITS["N/m"], "workers": 1}
INDENTER = "paraboloid 5 um"


def modulus_at(column, row):
    """Modulus of a stiff stripe on a soft sample (nN/nm^2)."""
    return STIFF if column in (2, 3) else SOFT


def pull_off_at(column):
    return 0.2 + 0.05 * column  # nN


def measured(column, row):
    """Heights of the base (nm) and forces (nN) of both branches, with noise."""
    depth = np.linspace(0.0, 2000.0, 4001)
    force = 4.0 / 3.0 * modulus_at(column, row) * np.sqrt(RADIUS) * depth**1.5
    depth, force = depth[force < 1.5], force[force < 1.5]
    along = depth + force / STIFFNESS
    base = np.linspace(800.0, -along[-1], 300)
    down = np.interp(-base, along, force)
    neck = -pull_off_at(column) * (1.0 - base / 150.0)
    up = np.where((base > 0.0) & (base < 150.0), neck, down)
    noise = np.random.default_rng(100 * row + column).normal(size=(2, 300))
    height = base + 30.0 * row  # of a sample that is not flat
    forces = np.array([down, up[::-1]]) + NOISE * noise + 0.1
    return (height, forces[0]), (height[::-1], forces[1])


def write_text(file, column, row):
    """Table of a curve with its place."""
    lines = [f"# x (um): {PIXEL * column}", f"# y (um): {PIXEL * row}"]
    lines += ["height (nm),force (nN),branch"]
    approach, retraction = (np.transpose(branch) for branch in measured(column, row))
    lines += [f"{z:.4f},{f:.6f},approach" for z, f in approach]
    lines += [f"{z:.4f},{f:.6f},retraction" for z, f in retraction]
    file.write_text("\n".join(lines) + "\n")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Map of small files in the order of rows; one has no curve."""
    folder = tmp_path_factory.mktemp("map")
    for row in range(SHAPE[1]):
        for column in range(SHAPE[0]):
            write_text(folder / f"{row}-{column}.csv", column, row)
    (folder / "1-4.csv").write_text("nothing\n")
    return folder


@pytest.fixture(scope="module")
def found(folder):
    return list(fit_curves(folder, INDENTER, **OPTIONS))


def test_the_moduli_of_a_map_are_found_within_their_errors(found):
    deviations = []
    for i, curve in enumerate(found):
        if not curve.message:
            true = modulus_at(i % SHAPE[0], i // SHAPE[0]) * UNITS["nN"] / UNITS["nm²"]
            off = curve.contact_modulus - true
            deviations.append(off / curve.contact_modulus_error)
            assert curve.contact_modulus == pytest.approx(true, rel=0.1)
            assert curve.converged and curve.doubts == ""
            assert curve.misfit == pytest.approx(1.0, abs=0.15)
    assert len(deviations) == 23
    assert 0.5 < np.std(deviations) < 1.6
    assert abs(np.mean(deviations)) < 0.8


def test_contact_points_follow_the_height_of_the_sample(found):
    heights = [curve.contact_height / UNITS["nm"] for curve in found]
    expected = [30.0 * (i // SHAPE[0]) for i in range(len(found))]
    known = np.isfinite(heights)
    off = np.subtract(heights, expected)[known]
    # the free force of .1 nN is a deflection of 2 nm
    np.testing.assert_allclose(off, -2.0, atol=12.0)


def test_pull_off_forces_are_relative_to_the_free_force(found):
    for i, curve in enumerate(found):
        if not curve.message:
            force = curve.pull_off_force / UNITS["nN"]
            assert force == pytest.approx(pull_off_at(i % SHAPE[0]), abs=4.0 * NOISE)


def test_a_fit_of_a_map_is_an_independent_least_squares_fit(folder, found):
    """SciPy's curve_fit, with the force on the cantilever by bisection."""
    (height, force), _ = measured(2, 1)

    def model(base, modulus, contact, offset, slope):
        def balance(f, depth):
            pressed = max(depth - f / STIFFNESS, 0.0)
            return 4.0 / 3.0 * 1e-6 * modulus * np.sqrt(RADIUS) * pressed**1.5 - f

        depths = contact - base
        forces = [
            brentq(balance, 0.0, d * STIFFNESS, (d,), xtol=1e-12) if d > 0.0 else 0.0
            for d in depths
        ]
        return np.array(forces) + offset + slope * (base - base.max())

    start = (30.0, 40.0, 0.0, 0.0)
    values, covariance = curve_fit(model, height, force, start)
    curve = found[SHAPE[0] + 2]
    kPa = UNITS["kPa"]
    error = curve.contact_modulus_error / kPa
    assert curve.contact_modulus / kPa == pytest.approx(values[0], abs=0.02 * error)
    assert error == pytest.approx(np.sqrt(covariance[0, 0]), rel=0.3)


def test_a_bad_file_has_a_message_and_does_not_stop_the_others(folder, found):
    bad = found[SHAPE[0] + 4]
    assert bad.file == str(folder / "1-4.csv")
    assert "no rows" in bad.message and np.isnan(bad.contact_modulus)
    assert sum(bool(curve.message) for curve in found) == 1


def test_a_curve_without_a_contact_keeps_what_is_known_without_a_fit(tmp_path):
    noise = 0.01 * np.random.default_rng(0).normal(size=200)
    table = np.column_stack([np.linspace(500.0, 0.0, 200), noise])
    head = "height (nm),force (nN)"
    np.savetxt(tmp_path / "a.csv", table, delimiter=",", header=head, comments="")
    (curve,) = fit_curves(tmp_path / "a.csv", INDENTER, **OPTIONS)
    assert "no contact is found" in curve.message
    assert curve.points == 200
    assert curve.noise / UNITS["nN"] == pytest.approx(0.01, rel=0.2)


def test_a_run_continues_after_an_interruption(folder, found, tmp_path):
    files = sorted(folder.iterdir())[:5]
    whole = fit_curves(files, INDENTER, tmp_path / "whole", **OPTIONS)
    assert len(list(whole)) == 5
    uninterrupted = (tmp_path / "whole" / "curves.csv").read_bytes()
    parts = fit_curves(files, INDENTER, tmp_path / "parts", **OPTIONS)
    for _ in range(3):
        next(parts)
    parts.close()
    table = tmp_path / "parts" / "curves.csv"
    assert len(read_fitted_curves(table)) == 3
    table.write_bytes(table.read_bytes()[:-30])  # killed while it wrote a row
    again = list(fit_curves(files, INDENTER, tmp_path / "parts", **OPTIONS))
    assert table.read_bytes() == uninterrupted
    moduli = [curve.contact_modulus for curve in again]
    expected = [curve.contact_modulus for curve in found[:5]]
    np.testing.assert_allclose(moduli, expected, rtol=1e-10)


def test_a_folder_of_another_fit_is_refused(folder, tmp_path):
    run = fit_curves(folder, INDENTER, tmp_path / "out", **OPTIONS)
    next(run)
    run.close()
    with pytest.raises(ValueError, match="indenter"):
        next(fit_curves(folder, "cone 35 deg", tmp_path / "out", **OPTIONS))


def test_tasks_of_an_executor_give_the_results_in_order(folder, found):
    class Here:
        """Executor of tasks in this process, which counts them."""

        count = 0

        def submit(self, function, *arguments):
            self.count += 1
            done = Future()
            done.set_result(function(*arguments))
            return done

    executor = Here()
    read = list(fit_curves(folder, stiffness=OPTIONS["stiffness"], executor=executor))
    assert executor.count == 2  # 24 curves
    assert [curve.noise for curve in read[:10]] == [curve.noise for curve in found[:10]]
    assert [curve.file for curve in read] == [curve.file for curve in found]


def test_without_an_indenter_curves_are_read_only(folder):
    (curve,) = fit_curves(folder / "0-0.csv", **OPTIONS)
    assert np.isnan(curve.contact_modulus) and not curve.message
    assert curve.pull_off_force / UNITS["nN"] == pytest.approx(0.2, abs=4.0 * NOISE)


@pytest.mark.parametrize(
    ("indenter", "options", "advice"),
    [
        ("ball 5 um", {}, "unknown indenter"),
        ("cone 35 deg", {"adhesion": "jkr"}, "needs a sphere"),
        ("sphere 5 um", {"adhesion": "vdw"}, "jkr"),
        ("", {"adhesion": "jkr"}, "--indenter"),
        ("sphere 5 um", {"adhesion": "jkr", "relaxation": 1}, "not fitted together"),
        ("pyramid 35 deg", {"thickness": 1e4}, "no formula for a thin layer"),
        ("", {"deepest": 100.0}, "--indenter"),
        ("sphere 5 um", {"relaxation": 1, "thickness": 1e4}, "--thickness"),
        ("sphere 5 um", {"relaxation": 1, "deepest": 100.0}, "--deepest"),
        ("sphere 5 um", {"relaxation": 1, "branch": "retraction"}, "--branch"),
    ],
)
def test_settings_without_a_fit_are_an_error(folder, indenter, options, advice):
    with pytest.raises(ValueError, match=advice):
        next(fit_curves(folder, indenter, **options))


def test_an_archive_has_the_curves_of_its_files(folder, found, tmp_path):
    with zipfile.ZipFile(tmp_path / "a.zip", "w") as archive:
        for name in ("0-1.csv", "1-4.csv"):
            archive.write(folder / name, name)
    first, second = fit_curves(tmp_path / "a.zip", INDENTER, **OPTIONS)
    assert (first.member, first.number) == ("0-1.csv", 1)
    assert first.contact_modulus == pytest.approx(found[1].contact_modulus)
    assert second.message.startswith("contains no rows")


def test_files_are_in_the_order_of_the_numbers_in_their_names(tmp_path):
    with zipfile.ZipFile(tmp_path / "a.zip", "w") as archive:
        for name in ("c10.csv", "c2.csv", "c1.csv"):
            (tmp_path / name).write_text("")
            archive.writestr(name, "")
    listed = listed_curves([tmp_path])
    names = [Path(curve.file).name + curve.member for curve in listed]
    archived = ["a.zipc1.csv", "a.zipc2.csv", "a.zipc10.csv"]
    assert names == [*archived, "c1.csv", "c2.csv", "c10.csv"]


@pytest.fixture
def jpk(tmp_path):
    """Map of 2 x 2 curves of JPK."""
    pytest.importorskip("afmformats")
    curves = []
    for row, column in ((0, 0), (0, 1), (1, 1), (1, 0)):  # back and forth
        place = 1e-6 * PIXEL * np.array([column, row])
        branches = [(1e-9 * z, 1e-9 * f) for z, f in measured(column + 1, row)]
        curves.append((place, *branches))
    jpk_map(tmp_path / "map.jpk-force-map", curves, (2, 2), 1e-6 * PIXEL)
    return tmp_path / "map.jpk-force-map"


def test_curves_of_a_map_of_jpk_agree_with_single_files(jpk, found):
    fitted = list(fit_curves(jpk, INDENTER, workers=1))
    places = [(curve.column, curve.row) for curve in fitted]
    assert places == [(0, 0), (1, 0), (1, 1), (0, 1)]
    for curve in fitted:
        assert (curve.x, curve.y) == pytest.approx(
            (PIXEL * UNITS["um"] * curve.column, PIXEL * UNITS["um"] * curve.row)
        )
        other = found[SHAPE[0] * curve.row + curve.column + 1]
        assert curve.contact_modulus == pytest.approx(other.contact_modulus, rel=1e-3)


def test_a_map_lists_its_curves_if_none_is_chosen(jpk):
    with pytest.raises(ValueError, match=r"4 force curves: choose one by --curve"):
        read_curve(jpk)
    with pytest.raises(ValueError, match="from 1 to 4, got 5"):
        read_curve(jpk, curve=5)


def test_a_curve_is_chosen_by_its_place(jpk, folder):
    number, position = curve_at(jpk, "1.9 um, 1.8 um")
    assert number == 3
    assert position.x == pytest.approx(2.0 * UNITS["um"])
    with pytest.raises(ValueError, match="x from 0 to 2 um, got 9 um"):
        curve_at(jpk, "9 um, 0 um")
    with pytest.raises(ValueError, match='"2 um, 3 um"'):
        curve_at(jpk, "9 um")


def test_a_place_needs_positions_in_the_file(tmp_path):
    (tmp_path / "a.csv").write_text("height (nm),force (nN)\n1,0\n0,0\n")
    with pytest.raises(ValueError, match="does not say where"):
        curve_at(tmp_path / "a.csv", "1 um, 1 um")


def at(x, y, **values):
    return FittedCurve("a", x=x * UNITS["um"], y=y * UNITS["um"], **values)


def test_places_make_the_grid_of_a_map_with_gaps(found):
    curves = [at(i, 2.0 * j) for i in (0, 1, 4) for j in (0, 1)] + [FittedCurve("b")]
    grid = grid_of(curves)
    assert grid.shape == (5, 2)
    assert grid.extent == pytest.approx(np.array([-0.5, 4.5, -1.0, 3.0]) * 1e4)
    values = grid.values(np.arange(7.0))
    expected = [[0, 2, np.nan, np.nan, 4], [1, 3, np.nan, np.nan, 5]]
    np.testing.assert_array_equal(values, expected)


def test_a_line_of_decreasing_places_is_a_map_of_one_row():
    curves = [at(-10.0 * i, 2.0, column=i, row=0) for i in range(6)]
    grid = grid_of(curves)
    np.testing.assert_allclose(grid.spacing, np.array([-10.0, 10.0]) * UNITS["um"])
    left, right, lower, upper = np.array(grid.extent) / UNITS["um"]
    assert (left, right) == pytest.approx((5.0, -55.0))
    assert (lower, upper) == pytest.approx((-3.0, 7.0))


def test_places_without_a_grid_have_none():
    places = np.random.default_rng(0).uniform(size=(20, 2))
    assert grid_of([at(x, y) for x, y in places]) is None
    assert grid_of([at(1.0, 1.0), at(1.0, 1.0)]) is None


def test_numbers_in_the_file_make_the_grid_of_places_with_noise():
    corners = [(0, 0), (9, 0), (0, 9), (9, 9)]
    curves = [at(i, j + 0.01 * i, column=i + 3, row=j) for i, j in corners]
    grid = grid_of(curves)
    assert grid.shape == (10, 10)
    np.testing.assert_allclose(grid.spacing, UNITS["um"], rtol=1e-6)


def test_a_summary_counts_failures_by_their_reason():
    moduli = (1.0, 2.0, 3.0, 5.0)
    good = [FittedCurve("a", contact_modulus=x, converged=True) for x in moduli]
    bad = [FittedCurve("a", message=f"only {n} points") for n in (3, 4)]
    lost = FittedCurve("a", contact_modulus=9.0)
    summary = SeriesSummary([*good, *bad, lost])
    assert summary.failures == [(2, "only 3 points"), (1, "the fit has not converged")]
    np.testing.assert_allclose(summary.quartiles["contact_modulus"], [1.75, 2.5, 3.5])


def test_a_summary_also_has_the_medians_of_curves_without_doubts():
    moduli = [1.0, 2.0, 3.0, 40.0, 50.0]
    curves = [
        FittedCurve("a", contact_modulus=k * UNITS["GPa"], converged=True, doubts=doubt)
        for k, doubt in zip(moduli, ["", "", "", "tilted", "tilted"], strict=True)
    ]
    lines = plain(*SeriesSummary(curves).parts).splitlines()
    every, certain = [each.split() for each in lines if "contact_modulus" in each]
    assert every[1:] == ["3.000", "2.000", "40.00", "GPa", "5"]
    assert certain[1:] == ["2.000", "GPa", "(3", "curves)"]


def test_the_command_writes_a_table_and_maps(folder, tmp_path, capsys):
    out = tmp_path / "out"
    names = [str(folder / name) for name in ("0-0.csv", "0-2.csv", "1-4.csv")]
    words = ["curves", *names, "--indenter", INDENTER, "--out", str(out)]
    words += ["--cantilever", "0.05 N/m", "--workers", "1"]
    assert main(words) == 1  # one has failed
    printed = capsys.readouterr().out
    assert "1 of 3 curves failed" in printed
    heads = (out / "curves.csv").read_text().splitlines()[0]
    assert "contact_modulus (Pa)" in heads and "pull_off_force (nN)" in heads
    for name in ("maps.png", "histogram.png"):
        assert (out / name).read_bytes().startswith(b"\x89PNG")
    page = (out / "curves.html").read_text()
    assert "1 of 3 curves failed." in re.findall(r'"answer">(.*?)</p>', page)[0]
    assert page.count('<tr class="failed">') == 1


def test_maps_on_the_page_have_the_moduli_at_their_places(folder, found, tmp_path):
    (tmp_path / "curves.csv").write_text("")
    (text,) = re.findall(r'id="data">(.*?)</script>', page_of_curves(found, tmp_path))
    maps = json.loads(text)["maps"]
    (frame,) = maps["frames"]
    (left, right, columns), (low, high, rows) = frame["x"], frame["y"]
    assert (columns, rows) == SHAPE
    units = {each["name"]: each["unit"] for each in maps["fields"]}
    values = np.frombuffer(base64.b64decode(frame["contact_modulus"]), "<f4")
    values = values.reshape(rows, columns)
    x, y = np.linspace(left, right, columns), np.linspace(low, high, rows)
    for each in found:
        modulus = each.contact_modulus / UNITS[units["contact_modulus"]]
        if each.message:
            continue
        column = np.argmin(abs(x - each.x / UNITS["um"]))
        row = np.argmin(abs(y - each.y / UNITS["um"]))
        assert values[row, column] == pytest.approx(modulus, rel=1e-6)
    assert np.isnan(values).sum() == 1


def test_curves_at_one_place_are_drawn_over_their_number(folder, tmp_path, capsys):
    for number in (1, 2):
        lines = (folder / "0-0.csv").read_text().splitlines(keepends=True)
        (tmp_path / f"{number}.csv").write_text("".join(lines[2:]))
    words = ["curves", *(str(tmp_path / f"{n}.csv") for n in (1, 2)), "--json"]
    words += ["--indenter", INDENTER, "--cantilever", "0.05 N/m", "--workers", "1"]
    assert main([*words, "--out", str(tmp_path / "out")]) == 0
    assert len(capsys.readouterr().out.splitlines()) == 2
    assert (tmp_path / "out" / "series.png").exists()
    assert not (tmp_path / "out" / "maps.png").exists()


def test_bars_of_a_series_are_standard_errors_in_the_unit_of_the_axis(
    tmp_path, monkeypatch
):
    drawn = []
    monkeypatch.setattr(
        Figure,
        "savefig",
        lambda figure, file, **_: [drawn.append(figure), Path(file).touch()],
    )
    nm, kPa = UNITS["nm"], UNITS["kPa"]
    curves = [
        FittedCurve(
            "a",
            contact_modulus=modulus * kPa,
            contact_modulus_error=0.1 * kPa,
            contact_height=height * nm,
            contact_height_error=2.0 * nm,
            converged=True,
        )
        for modulus, height in ((2.0, -30.0), (3.0, 0.0), (4.0, 50.0))
    ]
    draw_series(curves, tmp_path)
    modulus, height = drawn[0].axes
    for axes, label, error in (
        (modulus, "contact modulus\n(kPa)", 0.1),
        (height, "contact point\n(nm)", 2.0),
    ):
        assert axes.get_ylabel() == label
        (bars,) = axes.containers
        ends = np.array(bars.lines[2][0].get_segments())[:, :, 1]
        np.testing.assert_allclose(np.ptp(ends, axis=1), 2.0 * error)
    np.testing.assert_allclose(height.lines[0].get_ydata(), [0.0, 30.0, 80.0])


def test_curves_have_columns_with_units_tables_and_figures(tmp_path):
    kpa, um = UNITS["kPa"], UNITS["um"]
    numbers = [(1.0, 2.0), (2.0, 4.0), (np.nan, np.nan)]
    curves = FittedCurves(
        FittedCurve("a.csv", number=i, x=x * um, contact_modulus=e * kpa, noise=1.0)
        for i, (x, e) in enumerate(numbers)
    )
    assert curves.units["contact_modulus"] == "eV/Å^3"
    np.testing.assert_allclose(curves["x"], np.array([1.0, 2.0, np.nan]) * um)
    assert curves[1] == [*curves][1] and curves[:2]["number"].tolist() == [0, 1]
    assert repr(curves) == (
        "FittedCurves(curves=3, not_fitted=0, median_modulus=3 kPa)"
    )
    (axes,) = curves.figure(file=tmp_path / "map.pdf").axes
    assert (tmp_path / "map.pdf").read_bytes()[:4] == b"%PDF"
    assert axes.get_xlabel() == "x (um)"
    assert axes.get_ylabel() == "contact modulus (kPa)"
    (points,) = (each for each in axes.lines if each.get_label() == "simulation")
    np.testing.assert_allclose(points.get_xydata(), numbers)
    assert "<td>not known</td>" in curves._repr_html_()
    with pytest.raises(ValueError, match="'contact_modulus'"):
        curves["contact_modulos"]
