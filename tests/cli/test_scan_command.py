"""The command with a scene whose roughness is a scan."""

import csv
import json
import shutil
import sys

import numpy as np
import pytest
from small_scene import SMALL

from ase_roughcontact.cli import main

SMOOTH = SMALL[: SMALL.index("[roughness]")] + SMALL[SMALL.index("[path]") :]
SECTION = '[topography]\nfile = "data/scan.txt"\nrole = "indenter"\nunit = "nm"\n'


@pytest.fixture
def scene(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "data").mkdir()
    heights = np.random.default_rng(1).normal(size=(40, 40))
    header = "Width: 10 nm\nHeight: 10 nm\nValue units: pm"
    np.savetxt("data/scan.txt", 20 * heights, header=header)
    (tmp_path / "scan.toml").write_text(SMOOTH + SECTION)
    return "scan.toml"


def test_results_of_a_scan_contain_it_and_can_be_drawn_elsewhere(scene, tmp_path):
    assert main(["run", scene, "--out", "results", "--quiet"]) == 0
    shutil.rmtree("data")
    shutil.move("results", "moved")
    (tmp_path / "moved" / "contact.png").unlink()
    assert main(["figure", "moved"]) == 0
    assert (tmp_path / "moved" / "contact.png").exists()


def test_places_on_a_scan_are_cases_of_an_ensemble(scene, capsys):
    places = "topography.center=[4.5,4.5],[5.5,5.0]"
    options = ["--set", places, "--workers", "1", "--json"]
    assert main(["ensemble", scene, "--table", "places.csv", *options]) == 0
    last = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert last["failures"] == {}
    with open("places.csv") as table:
        steps = list(csv.DictReader(table))
    deepest = {step["normal_force"] for step in steps if step["step"] == "1"}
    assert (len(steps), len(deepest)) == (4, 2)


@pytest.mark.parametrize("command", ["run", "plan"])
def test_a_missing_reader_of_scans_is_named_in_a_line(
    scene, tmp_path, command, capsys, monkeypatch
):
    monkeypatch.setitem(sys.modules, "SurfaceTopography", None)
    (tmp_path / "data" / "scan.gwy").touch()
    (tmp_path / scene).write_text(SMOOTH + SECTION.replace(".txt", ".gwy"))
    assert main([command, scene]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "scan.gwy needs the package SurfaceTopography" in line
    assert "pip install '.[topography]' in the folder of the source code" in line
