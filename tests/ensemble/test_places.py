"""A scene at a grid of places on its scan."""

from operator import attrgetter
from pathlib import Path

import numpy as np
import pytest
from ensemble_scenes import Here
from matplotlib.figure import Figure

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.cli import main
from ase_roughcontact.ensemble import read_places, run_places
from ase_roughcontact.ensemble.ensemble_plan import EnsemblePlan
from ase_roughcontact.ensemble.places import Place, as_map, places_of
from ase_roughcontact.scene import Scene, relax_loop
from ase_roughcontact.scene.results import write_inputs

SCENE = """
[substrate]
spacing = 2.5
shape = [16, 16]
contact_modulus = 30.0
hardness = inf
[sphere]
radius = "3 nm"
[topography]
file = "scan.txt"
role = "{role}"
detrend = "none"
margin = "2 nm"
[interaction]
kind = "adhesive"
work_of_adhesion = 0.05
[path]
"""
STEPS = 'control = "height"\nvalues = [-1.0, 3.0]\n'
LOOP = 'kind = "loop"\ndeepest = 0.7\ntolerance = 0.1\n'


def assert_same(found, expected):
    """Compare places: a file has other units than the calculation."""
    for place, other in zip(found, expected, strict=True):
        assert (place.x, place.y) == (other.x, other.y)
        for name in ("normal_force", "area", "pull_off_force", "penetration"):
            near = pytest.approx(getattr(other, name), rel=1e-11)
            assert getattr(place, name) == near
        assert (place.converged, place.message) == (other.converged, other.message)


@pytest.fixture
def scene_of(tmp_path):
    x, y = 0.25 * np.arange(41)[:, None], 0.25 * np.arange(33)
    scan = 0.2 * np.exp(-((x - 2) ** 2) / 2 - (y - 2) ** 2 / 2) * np.ones((41, 33))
    header = "Width: 10.25 nm\nHeight: 8.25 nm\nValue units: nm"
    np.savetxt(tmp_path / "scan.txt", scan.T, header=header)

    def write(path, role="substrate"):
        (tmp_path / "scene.toml").write_text(SCENE.format(role=role) + path)
        return Scene.read(tmp_path / "scene.toml")

    return write


def test_a_plan_of_places_has_no_time_for_errors_by_the_pixels_of_the_scan(scene_of):
    scenes = places_of(scene_of(STEPS), (2, 1))
    run, place = (
        EnsemblePlan.of(scenes, 1, places=places).plan for places in (False, True)
    )
    assert place.step_seconds < 0.5 * run.step_seconds


@pytest.mark.parametrize("role", ["substrate", "indenter"])
def test_a_place_has_the_forces_of_a_scene_with_that_center(scene_of, tmp_path, role):
    scene = scene_of(STEPS, role)
    run = run_places(scene, (2, 1), tmp_path / "out", Here())
    key = attrgetter("x")
    found = sorted(run, key=key)
    assert [(each.x, each.y) for each in found] == [(20.0, 20.0), (80.0, 20.0)]
    there = scene.with_values({"topography.center": ("2 nm", "2 nm")})
    first, last = there.relax()
    assert found[0].normal_force == pytest.approx(last.normal_force)
    assert found[0].area == last.contact_area
    lowest = min(first.normal_force, last.normal_force)
    assert found[0].pull_off_force == pytest.approx(max(0.0, -lowest))
    assert found[0].normal_force != pytest.approx(found[1].normal_force, rel=0.1)
    assert_same(sorted(read_places(tmp_path / "out" / "places.csv"), key=key), found)


def test_a_loop_gives_the_pull_off_force_of_each_place(scene_of, tmp_path):
    scene = scene_of(LOOP)
    (place,) = run_places(scene, (1, 1), tmp_path / "out", Here())
    there = scene.with_values({"topography.center": ("2 nm", "2 nm")})
    loop = relax_loop(there, validity="ignore")
    assert place.results["dissipated_energy"] == loop.dissipated_energy
    assert place.pull_off_force == pytest.approx(loop.pull_off_force)
    assert place.area == loop.turn.contact_area
    assert place.normal_force == loop.turn.normal_force
    assert place.penetration == pytest.approx(0.7)
    (stored,) = read_places(tmp_path / "out" / "places.csv")
    assert stored.penetration == pytest.approx(0.7)
    assert stored.results == pytest.approx(place.results, nan_ok=True)


def test_a_place_has_the_marks_and_the_error_of_a_run_with_that_center(
    scene_of, tmp_path
):
    scene = scene_of(STEPS)
    (place,) = run_places(scene, (1, 1), tmp_path / "out", Here())
    there = scene.with_values({"topography.center": ("2 nm", "2 nm")})
    first, last = there.relax(validity="ignore", scan_errors=False)
    names = {
        entry.partition(" = ")[0]
        for step in (first, last)
        for entry in filter(None, step.validity.split("; "))
    }
    assert names and set(place.validity.split("; ")) == names
    assert place.area_error == last.area_error > 0.0
    (stored,) = read_places(tmp_path / "out" / "places.csv")
    assert stored.validity == place.validity
    assert stored.area_error == pytest.approx(place.area_error)


def test_the_report_of_places_counts_them_and_their_marks(scene_of, tmp_path, capsys):
    folder = tmp_path / "out"
    list(run_places(scene_of(STEPS), (2, 1), folder, Here()))
    assert main(["report", str(folder)]) == 0
    page = (folder / "report.html").read_text()
    assert ", 2 places" in page and "converged within" not in page
    assert "in 2 of 2 places" in page
    (first, _) = sorted(read_places(folder / "places.csv"), key=attrgetter("x"))
    assert f"{first.normal_force / UNITS['nN']:.4g}"[:4] in page


def test_a_place_says_that_its_pull_off_force_is_a_lower_bound(scene_of, tmp_path):
    scene = scene_of(LOOP.replace("0.7", "-0.2"))
    (place,) = run_places(scene, (1, 1), tmp_path / "out", Here())
    assert place.converged and "is a lower bound" in place.message


def test_places_are_not_calculated_again(scene_of, tmp_path):
    executor, scene = Here(), scene_of(STEPS)
    run = run_places(scene, (2, 1), tmp_path / "out", executor)
    next(run)
    run.close()
    assert len(read_places(tmp_path / "out" / "places.csv")) == 1
    again = Here()
    assert len(list(run_places(scene, (2, 1), tmp_path / "out", again))) == 2
    assert again.count == 1
    with pytest.raises(ValueError, match=r"\[path\] kind"):
        list(run_places(scene_of(LOOP), (2, 1), tmp_path / "out", again))
    out = tmp_path / "run"
    out.mkdir()
    (out / "sweep.traj").touch()  # the scene of a run is not replaced
    write_inputs(scene_of(LOOP), out / "scene.toml")
    with pytest.raises(ValueError, match="another scene"):
        list(run_places(scene_of(STEPS), (1, 1), out, Here()))
    with pytest.raises(ValueError, match=r"\[topography\]"):
        next(run_places(Scene.default(), (1, 1), tmp_path))


def test_places_that_failed_are_calculated_again_in_more_steps(scene_of, tmp_path):
    scene, folder = scene_of(STEPS), tmp_path / "out"
    few = scene.with_values({"solver.max_steps": 1})

    def places_of(scene):  # in any order
        return sorted(run_places(scene, (2, 1), folder, Here()), key=attrgetter("x"))

    failed = places_of(few)
    assert not any(place.converged for place in failed)
    assert_same(places_of(few), failed)
    found = places_of(scene)
    assert all(place.converged for place in found)
    known = sorted(read_places(folder / "places.csv"), key=attrgetter("x"))
    assert_same(known, found)


def test_a_row_in_which_a_run_was_killed_is_calculated_again(scene_of, tmp_path):
    scene, table = scene_of(STEPS), tmp_path / "out" / "places.csv"
    first = list(run_places(scene, (2, 1), tmp_path / "out", Here()))
    text = table.read_text()
    table.write_text(text[:-20])
    assert_same(read_places(table), first[:1])
    heads = "x (nm),y (nm),normal_force (nN),continuum_area (nm²),pull_off_force (nN),"
    assert text.startswith(heads)
    force = float(text.splitlines()[1].split(",")[2])
    assert force == pytest.approx(first[0].normal_force / UNITS["nN"])
    executor = Here()
    run = run_places(scene, (2, 1), tmp_path / "out", executor)
    assert_same(*(sorted(each, key=attrgetter("x")) for each in (run, first)))
    assert executor.count == 1 and table.read_text() == text


def test_a_place_that_did_not_converge_is_not_in_the_maps():
    found = Place(0.0, 0.0, area=3.0, converged=True)
    others = Place(0.0, 5.0, area=4.0), Place(5.0, 5.0, area=5.0, converged=True)
    _, _, values = as_map([found, *others], "area")
    np.testing.assert_array_equal(values, [[3.0, np.nan], [np.nan, 5.0]])


def test_a_table_in_which_a_bit_has_changed_is_refused_or_has_the_same_values(
    scene_of, tmp_path
):
    table = tmp_path / "out" / "places.csv"
    list(run_places(scene_of(STEPS), (2, 1), tmp_path / "out", Here()))
    written, found = table.read_bytes(), read_places(table)
    refused = 0
    for place in range(0, len(written), 2):
        damaged = bytearray(written)
        damaged[place] ^= 1 << place % 8
        table.write_bytes(damaged)
        try:
            # a row in which a run was killed is calculated again
            assert_same(read_places(table), found[: len(read_places(table))])
        except ValueError as error:
            assert "places.csv is damaged" in str(error)
            refused += 1
    assert refused > 0.5 * len(written) / 2


def test_a_place_is_one_more_row_of_the_table(scene_of, tmp_path):
    table, sizes = tmp_path / "out" / "places.csv", []
    for _ in run_places(scene_of(STEPS), (2, 1), tmp_path / "out", Here()):
        sizes.append((table.stat().st_ino, len(read_places(table))))
        with pytest.raises(RuntimeError, match="another run"):
            list(run_places(scene_of(STEPS), (2, 1), tmp_path / "out", Here()))
    assert sizes == [(sizes[0][0], 1), (sizes[0][0], 2)]


def test_a_place_beyond_the_scan_has_a_message(scene_of, tmp_path):
    scene = scene_of(STEPS).with_values({"topography.margin": 0.0})
    with pytest.warns(UserWarning, match="1 of 1 .*margin"):
        (place,) = run_places(scene, (1, 1), tmp_path / "out", Here())
    assert not place.converged and np.isnan(place.area)
    assert "choose a smaller window, or a center further inside" in place.message


def test_places_without_a_margin_are_half_a_window_from_the_edges(scene_of, tmp_path):
    scene = scene_of(STEPS).with_values({"topography.margin": None})
    found = list(run_places(scene, (2, 1), tmp_path / "out", Here()))
    # the window has 16 x 16 points, 0.25 nm apart
    assert sorted(each.x for each in found) == [20.0, 80.0]
    assert all(each.converged for each in found)


@pytest.mark.filterwarnings("ignore:scan.txt. the scan itself has a radius")
@pytest.mark.parametrize("role", ["substrate", "indenter"])
def test_the_command_draws_scan_and_maps(scene_of, tmp_path, capsys, monkeypatch, role):
    pool, figures = "ase_roughcontact.ensemble.places.worker_pool", []
    monkeypatch.setattr(pool, lambda executor, workers: Here())

    def saved(figure, file, **_):
        figures.append(figure)
        Path(file).touch()

    monkeypatch.setattr(Figure, "savefig", saved)
    scene_of(STEPS, role)
    scene, out = str(tmp_path / "scene.toml"), str(tmp_path / "out")
    options = ["--grid", "2x1", "--workers", "1", "--out", out]
    assert main(["places", scene, *options]) == 0
    lines = capsys.readouterr().out.splitlines()
    rows = [
        line for line in lines if " nm" not in line and line.split()[1:2] == ["2.000"]
    ]
    assert len(rows) == 2 and all(line.endswith("*") for line in rows)
    assert any(line.split()[:2] == ["*", "LIMITS:"] for line in lines)
    assert (tmp_path / "out" / "places.png").exists()
    (figure,) = figures
    panels, bars = figure.axes[:3], figure.axes[3:]
    assert [bar.get_ylabel() for bar in bars] == [
        "height of the scan (nm)",
        "contact area (nm²)",
        "pull-off force (nN)",
    ]
    (scan,), (area,) = (panel.collections for panel in panels[:2])
    # the bump of the scan is at (2, 2) nm, where the first place is
    heights, corners = scan.get_array(), scan.get_coordinates()
    row, column = np.unravel_index(np.argmax(heights), heights.shape)
    bump = corners[row : row + 2, column : column + 2].mean(axis=(0, 1))
    np.testing.assert_allclose(bump, [2.0, 2.0], atol=0.1)
    assert heights.max() == pytest.approx(0.2, rel=0.01)
    assert panels[0].get_xlim() == panels[1].get_xlim()
    (places,) = panels[0].lines
    np.testing.assert_allclose(sorted(places.get_xdata()), [2.0, 8.0])
    np.testing.assert_allclose(places.get_ydata(), [2.0, 2.0])
    found = sorted(read_places(tmp_path / "out" / "places.csv"), key=attrgetter("x"))
    expected = [[place.area / 100.0 for place in found]]
    np.testing.assert_allclose(area.get_array(), expected)
