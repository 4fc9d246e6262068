"""Files of a version with other output columns stay readable."""

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from ase.io import Trajectory, read
from small_scene import SMALL

from ase_roughcontact._util.files import table_rows
from ase_roughcontact.atoms.trajectory import checksum
from ase_roughcontact.cli import main
from ase_roughcontact.ensemble import read_ensemble, read_places, run_ensemble
from ase_roughcontact.ensemble.columns import step_columns
from ase_roughcontact.scene import Scene

FILES = {"trajectory": "sweep.traj", "csv": "curve.csv"}
# Columns that a later version has added.
LATER = ("area_error", "area_column", "validity", "perimeter", "attractive_atoms")


def change_columns(columns):
    """Remove columns that were added later, and add one that is not known now."""
    for name in LATER:
        del columns[name]
    columns["temperature"] = 300.0


@pytest.fixture(scope="module")
def older(tmp_path_factory):
    """Folder of a run whose files have other columns, and its scene file."""
    base = tmp_path_factory.mktemp("older")
    (base / "my.toml").write_text(SMALL)
    scene = Scene.read(base / "my.toml")
    list(scene.run(base / "out"))
    frames = read(base / "out" / "sweep.traj", ":")
    with Trajectory(base / "out" / "sweep.traj", "w") as trajectory:
        for frame in frames:
            change_columns(frame.info["load_step"])
            frame.info["checksum"] = checksum(frame)
            trajectory.write(frame)
    return base


def test_an_older_run_is_continued(older):
    scene = Scene.read(older / "my.toml")
    targets = [*scene.targets, 1.1 * scene.targets[-1]]
    files = {n: older / "out" / f for n, f in FILES.items()}
    *before, last = scene.relax(targets, resume=True, validity="ignore", **files)
    assert math.isnan(before[0].area_error) and before[0].attractive_atoms == -1
    assert before[0].normal_force > 0.0 and before[0].validity == ""
    assert last.area_error >= 0.0
    with open(files["csv"], newline="") as table:
        rows = list(table_rows(table))
    assert [float(row["area_error"]) >= 0.0 for row in rows] == [False, False, True]
    assert "temperature" not in rows[0]


@pytest.mark.parametrize("command", ["figure", "report"])
def test_an_older_run_is_drawn(older, command, capsys):
    assert main([command, str(older / "out")]) == 0
    assert capsys.readouterr().err == ""


def test_an_older_database_is_read_and_continued(tmp_path, monkeypatch):
    database, scene = tmp_path / "e.db", Scene.parse(SMALL)

    def older_columns(*arguments):
        columns = step_columns(*arguments)
        change_columns(columns)
        return columns

    worker = "ase_roughcontact.ensemble.worker.step_columns"
    with ThreadPoolExecutor(1) as pool:
        with monkeypatch.context() as patch:
            patch.setattr(worker, older_columns)
            *_, last = run_ensemble([scene], database, pool, steps=[[0]])
        assert last.steps == 1
        *_, last = run_ensemble([scene], database, pool)
    assert last.steps == 2
    columns = read_ensemble(database)
    np.testing.assert_array_equal(np.isnan(columns["area_error"]), [True, False])
    assert columns["attractive_atoms"].tolist() == [-1, 0]
    assert (columns["normal_force"] > 0.0).all() and "temperature" not in columns


def test_an_older_table_of_places_is_read(tmp_path):
    table = tmp_path / "places.csv"
    table.write_text("x (nm),y (nm),contact_area (nm²),humidity\n1.0,2.0,3.0,0.4\n")
    (place,) = read_places(table)
    assert (place.x, place.y, place.area) == (10.0, 20.0, 300.0)
    assert math.isnan(place.pull_off_force) and not place.converged
