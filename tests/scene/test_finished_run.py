"""Results of a run as one object."""

import sys
import warnings
from shutil import copy, copytree

import numpy as np
import pytest

from ase_roughcontact import Results
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.analysis import ContactMap
from ase_roughcontact.loading import trajectory
from ase_roughcontact.loading.trajectory import (
    frame_of_step,
    places_of_steps,
    read_frames,
)
from ase_roughcontact.path_kinds.loop.instabilities import AdhesionLoop
from ase_roughcontact.scene import Scene
from ase_roughcontact.theory import Hertz

SCENE = """
[substrate]
contact_modulus = 80.0
spacing = "0.25 nm"
[sphere]
radius = "30 nm"
[interaction]
kind = "hard"
[path]
values = ["1 nN", "4 nN", "9 nN"]
[output]
keep = "all"
"""
LOOP = """
[substrate]
contact_modulus = 1.0
spacing = "1 nm"
[sphere]
radius = "20 nm"
[interaction]
kind = "dugdale"
work_of_adhesion = 0.01
attraction_range = "1 nm"
[path]
kind = "loop"
deepest = "0 nm"
step = "0.5 nm"
tolerance = 0.1
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    steps = list(Scene.parse(SCENE).run(folder, validity="ignore"))
    return folder, steps


def test_results_are_the_sequence_of_the_steps_of_the_run(run):
    folder, steps = run
    results = Results(folder)
    assert len(results) == 3 and list(results) == steps
    assert results[-1] == steps[2] and results[1:] == steps[1:]


def test_a_column_is_an_array_with_a_unit(run):
    folder, steps = run
    results = Results(folder)
    expected = [step.contact_area for step in steps]
    np.testing.assert_array_equal(results["contact_area"], expected)
    assert results.units["contact_area"] == "Å^2"
    assert results["window"].tolist() == [step.window for step in steps]
    with pytest.raises(ValueError, match="contact_area"):
        results["contact_aera"]


def test_a_map_has_force_and_area_of_its_step(run):
    folder, steps = run
    seen = Results(folder).map(1)
    assert seen.normal_force == pytest.approx(steps[1].normal_force, rel=1e-6)
    assert seen.contact_area == pytest.approx(steps[1].contact_area)
    assert seen.gap[seen.contact].max() == pytest.approx(0.0, abs=1e-4)


def test_a_map_reads_no_other_frame(run, monkeypatch):
    unpacked, read = trajectory.unpacked, []
    monkeypatch.setattr(
        trajectory, "unpacked", lambda text: read.append(len(text)) or unpacked(text)
    )
    results = Results(run[0])
    assert results.steps_with_map == [0, 1, 2] and read == []
    results.map(2)
    assert len(read) == 1


def test_the_frame_of_a_step_is_the_one_that_is_read_in_turn(run):
    folder, _ = run
    file = folder / "sweep.traj"
    expected = list(read_frames(file))
    assert list(places_of_steps(file)) == [0, 1, 2]
    for number, frame in enumerate(expected):
        assert frame_of_step(file, number) == frame


@pytest.mark.parametrize("part", [-1, 80])  # arrays, and the description
def test_a_damaged_frame_is_an_error_that_names_it(run, tmp_path, part):
    file = tmp_path / "a.traj"
    text = bytearray((run[0] / "sweep.traj").read_bytes())
    place = places_of_steps(run[0] / "sweep.traj")[2]
    text[place.start + part % place.size] ^= 0xFF
    file.write_bytes(text)
    with pytest.raises(ValueError, match=r"frame 2 .*damaged"):
        frame_of_step(file, 2)


def test_a_damaged_frame_leaves_the_others(run, tmp_path):
    text = bytearray((run[0] / "sweep.traj").read_bytes())
    text[-1] ^= 1
    (tmp_path / "a.traj").write_bytes(text)
    found = ContactMap.from_frame(frame_of_step(tmp_path / "a.traj", 0))
    assert found.contact.any()


def test_maps_follow_a_run_that_replaces_its_frames(tmp_path):
    running = Scene.parse(SCENE.replace('"all"', '"last"')).run(tmp_path)
    next(running)
    results = Results(tmp_path)
    assert results.map(0).normal_force == pytest.approx(UNITS["nN"], rel=1e-3)
    next(running)
    with pytest.raises(ValueError, match="step 0 has no frame"):
        results.map(0)
    found = Results(tmp_path).map(1).normal_force
    assert found == pytest.approx(4.0 * UNITS["nN"], rel=1e-3)


def test_a_cut_off_frame_is_reported_at_the_line_of_the_user(run, tmp_path):
    copytree(run[0], tmp_path, dirs_exist_ok=True)
    text = (tmp_path / "sweep.traj").read_bytes()
    (tmp_path / "sweep.traj").write_bytes(text[:-1])
    with pytest.warns(RuntimeWarning, match="frame 2 .* is cut off") as found:
        assert Results(tmp_path).steps_with_map == [0, 1]
    assert found[0].filename == __file__


def test_a_step_that_is_not_there_is_named_with_the_steps_that_are(run):
    for ask in (Results(run[0]).map, Results(run[0]).to_xarray):
        with pytest.raises(IndexError, match="no step 3: give 0 to 2"):
            ask(3)


def test_a_step_without_a_frame_has_no_map(tmp_path):
    scene = Scene.parse(SCENE.replace('"all"', '"last"'))
    list(scene.run(tmp_path, validity="ignore"))
    with pytest.raises(ValueError, match="nearest is 2: give keep"):
        Results(tmp_path).map(0)


def test_a_table_of_pandas_has_columns_and_units(run):
    pytest.importorskip("pandas", reason="needs the extra tables")
    folder, steps = run
    table = Results(folder).to_pandas()
    assert table.index.name == "step" and len(table) == 3
    assert table["normal_force"].tolist() == [step.normal_force for step in steps]
    assert table.attrs["units"]["normal_force"] == "eV/Å"


def test_a_data_set_of_xarray_has_coordinates_units_and_load(run):
    pytest.importorskip("xarray", reason="needs the extra tables")
    folder, steps = run
    found, seen = Results(folder).to_xarray(-1), Results(folder).map(-1)
    np.testing.assert_allclose(found["x"], seen.x / 10.0)
    np.testing.assert_allclose(found["pressure"] * UNITS["GPa"], seen.pressure)
    assert found["pressure"].attrs["units"] == "GPa"
    assert found["gap"].dims == ("x", "y")
    assert found.attrs["step"] == 2
    assert found.attrs["normal_force"] == pytest.approx(9.0, rel=1e-3)
    assert found.attrs["penetration"] == steps[2].penetration / 10.0


@pytest.mark.parametrize(
    "module, call",
    [("pandas", lambda r: r.to_pandas()), ("xarray", lambda r: r.to_xarray(0))],
)
def test_a_missing_package_is_named_with_its_extra(run, monkeypatch, module, call):
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(ImportError, match=rf"needs {module}.*\[tables\]"):
        call(Results(run[0]))


def test_theory_of_the_results_is_the_theory_of_the_scene(run):
    results = Results(run[0])
    hertz = Hertz(300.0, results.scene.contact_modulus)
    force = results["normal_force"]
    expected = hertz.contact_area(force)
    np.testing.assert_allclose(results.reference.smooth.contact_area(force), expected)


def test_a_loop_and_its_pull_off_force(tmp_path):
    list(Scene.parse(LOOP).run(tmp_path, validity="ignore"))
    results = Results(tmp_path)
    assert isinstance(results.loop, AdhesionLoop)
    assert results.values["pull_off_force"] == results.loop.pull_off_force > 0.0
    assert results.loop.pull_off_force == pytest.approx(
        -results["normal_force"].min(), rel=0.1
    )


def test_steps_are_no_loop(run):
    with pytest.raises(ValueError, match='kind = "steps"'):
        _ = Results(run[0]).loop


def test_a_figure_has_the_area_in_printed_units_beside_theory(run):
    results = Results(run[0])
    (axes,) = results.figure().axes
    lines = {line.get_label(): line.get_xydata() for line in axes.lines}
    expected = results["normal_force"] / UNITS["nN"], results["continuum_area"] / 100.0
    np.testing.assert_allclose(lines["simulation"].T, expected)
    assert axes.get_ylabel() == "continuum area (nm²)"
    force, area = lines[results.reference.smooth.label].T
    hertz = Hertz(300.0, results.scene.contact_modulus).contact_area(
        force * UNITS["nN"]
    )
    np.testing.assert_allclose(area, hertz / 100.0)


def test_a_figure_of_other_columns(run):
    results = Results(run[0])
    (axes,) = results.figure("largest_pressure", along="penetration").axes
    assert axes.get_ylabel() == "largest pressure (GPa)"
    pressure = axes.lines[-1].get_ydata() * UNITS["GPa"]
    np.testing.assert_allclose(pressure, results["largest_pressure"])


def test_bars_show_twice_the_error_of_the_force(tmp_path):
    path = '[path]\ncontrol = "penetration"\nvalues = ["0.1 nm"]\n'
    scene = Scene.parse(SCENE.partition("[path]")[0] + path)
    (step,) = scene.run(tmp_path, validity="ignore")
    (axes,) = Results(tmp_path).figure().axes
    ((_, low), (_, high)) = axes.collections[0].get_segments()[0]
    assert high - low == pytest.approx(4.0 * step.force_error / UNITS["nN"])


def test_a_column_against_itself_is_a_line(run):
    (axes,) = Results(run[0]).figure("normal_force").axes
    x, y = axes.lines[0].get_data()
    np.testing.assert_array_equal(x, y)


@pytest.mark.parametrize("columns", [("window", "step"), ("step", "window")])
def test_a_column_of_texts_is_not_drawn(run, columns):
    with pytest.raises(ValueError, match="window has texts, such as '"):
        Results(run[0]).figure(*columns)


@pytest.mark.parametrize(
    "values, columns",
    [
        (
            {"path.control": "penetration", "path.values": (1.0,)},
            ("penetration", "normal force"),
        ),
        ({"path.values": ("1 nN",)}, ("normal force", "continuum area")),
    ],
)
def test_a_figure_shows_what_the_path_controls_by_default(tmp_path, values, columns):
    list(Scene.parse(SCENE).with_values(values).run(tmp_path, validity="ignore"))
    (axes,) = Results(tmp_path).figure().axes
    labels = axes.get_xlabel(), axes.get_ylabel()
    assert tuple(label.partition(" (")[0] for label in labels) == columns


@pytest.mark.parametrize("direction, axis", [(0, "x"), (30, "x"), (90, "y")])
def test_a_figure_shows_friction_along_the_slide(tmp_path, direction, axis):
    text = SCENE.replace("[sphere]", "poisson = 0.3\n[sphere]").partition("values")[0]
    path = 'values = ["1 nN"]\nkind = "sliding"\ndisplacements = [0, 1]\nsteps = 1\n'
    text += f"{path}direction = {direction}\n[friction]\ncoefficient = 0.2\n"
    list(Scene.parse(text).run(tmp_path, validity="ignore"))
    (axes,) = Results(tmp_path).figure().axes
    assert axes.get_xlabel().startswith(f"lateral {axis}")
    assert axes.get_ylabel().startswith(f"lateral force {axis}")
    force = axes.lines[0].get_ydata()  # nN
    along = {"x": np.cos, "y": np.sin}[axis](np.radians(direction))
    np.testing.assert_allclose(force, [0.0, 0.2 * along], rtol=1e-3, atol=1e-6)


def test_equal_runs_have_no_difference(run):
    assert not Results(run[0]).diff(run[0])


def test_differences_name_keys_steps_and_columns(run, tmp_path):
    other = Scene.parse(SCENE.replace('"4 nN", "9 nN"', '"5 nN"'))
    list(other.run(tmp_path, validity="ignore"))
    found = Results(run[0]).diff(tmp_path)
    assert found and found.steps == (2, 3)
    assert "loads" in found.scene[0]
    assert found.columns["normal_force"] == pytest.approx(UNITS["nN"], rel=1e-3)
    assert "seconds" not in found.columns and "precision" not in found.columns


def test_results_are_shown_by_steps_in_printed_units(run):
    results = Results(run[0])
    assert "steps=3" in repr(results) and "eV/Å" in repr(results)
    table = results._repr_html_()
    assert table.count("<tr>") == 1 + 3
    assert "<th>normal force (nN)</th>" in table and "<td>9</td>" in table


def test_a_table_names_steps_that_did_not_converge_and_limits(tmp_path):
    text = SCENE.replace("hard", "repulsive") + "[solver]\nmax_steps = 1\n"
    list(Scene.parse(text).run(tmp_path, validity="ignore"))
    table = Results(tmp_path)._repr_html_()
    assert table.count("<td>False</td>") == 3
    assert "<th>validity</th>" in table


def test_the_middle_of_a_long_table_is_left_out(tmp_path):
    path = 'first = "1 nN"\nlast = "9 nN"\nsteps = 22\n[output]\nkeep = "last"\n'
    scene = Scene.parse(SCENE.partition("values")[0] + path)
    list(scene.run(tmp_path, validity="ignore"))
    rows = Results(tmp_path)._repr_html_().split("<tr><th>")[2:]
    heads = [row.partition("<")[0] for row in rows]
    assert heads == [*map(str, range(10)), "...", *map(str, range(12, 22))]


def test_another_folder_is_refused(tmp_path):
    with pytest.raises(ValueError, match="not the folder of a run"):
        Results(tmp_path)


def test_a_run_without_a_finished_step_has_no_results(run, tmp_path):
    copy(run[0] / "scene.toml", tmp_path)
    with pytest.raises(ValueError, match="no step is finished"):
        Results(tmp_path)


def test_a_run_that_is_never_iterated_warns(tmp_path):
    with pytest.warns(UserWarning, match=r"list\(Scene.run\(...\)\)") as found:
        Scene.parse(SCENE).run(tmp_path / "out")
    assert found[0].filename == __file__
    assert not (tmp_path / "out").exists()


def test_a_run_that_is_begun_or_closed_does_not_warn(tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        next(Scene.parse(SCENE).run(tmp_path, validity="ignore"))
        Scene.parse(SCENE).relax().close()
