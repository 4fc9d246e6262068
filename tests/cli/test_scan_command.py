"""The command with a scene that has a scan as roughness."""

import json
import re
import shutil
import sys

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter
from small_scene import SMALL

from ase_roughcontact._util.files import table_rows
from ase_roughcontact.cli import main

SMOOTH = SMALL[: SMALL.index("[roughness]")] + SMALL[SMALL.index("[path]") :]
SMOOTH = SMOOTH.replace("radius = 60.0", 'radius = "60 a0"')
SECTION = '[topography]\nfile = "data/scan.txt"\nrole = "indenter"\nunit = "nm"\n'


@pytest.fixture
def scene(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "data").mkdir()
    heights = gaussian_filter(np.random.default_rng(1).normal(size=(40, 40)), 1.5)
    header = "Width: 10 nm\nHeight: 10 nm\nValue units: pm"
    np.savetxt("data/scan.txt", 20 * heights / heights.std(), header=header)
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
        steps = list(table_rows(table))
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


def test_plan_run_and_page_show_what_was_read_from_a_scan(scene, tmp_path, capsys):
    scan = np.loadtxt("data/scan.txt")
    highest = np.argwhere(scan == scan[17:-17, 17:-17].max())[0][::-1] * 0.25
    scan[30, 2] = np.nan
    header = "Width: 10 nm\nHeight: 10 nm\nValue units: pm"
    np.savetxt("data/scan.txt", scan, header=header)
    (tmp_path / scene).write_text(
        SMOOTH + SECTION + 'center = "highest"\nmargin = "4.2 nm"\n'
    )
    parts = (
        "scan.txt, the indenter: 10 x 10 nm, 40 x 40 points (rows of a matrix along "
        "x), 1 (0.062 %) missing, rms height 0.0198",
        f"highest at ({highest[0]:g}, {highest[1]:g}) nm",
    )
    texts = []
    for command in (["plan", scene], ["run", scene, "--out", "results"]):
        main(command)
        texts.append(" ".join(capsys.readouterr().out.split()))
    main(["report", "results"])
    texts.append((tmp_path / "results" / "report.html").read_text())
    for text in texts:
        assert [part for part in parts if part not in text] == [], text
    assert "sphere of radius 15.3" in texts[0]


@pytest.mark.filterwarnings("default:scan.txt")
def test_doubts_about_a_scan_are_warnings(scene, tmp_path, capsys):
    header = "Width: 10 nm\nHeight: 10 nm\nValue units: pm"
    np.savetxt("data/scan.txt", 1e-3 * np.loadtxt("data/scan.txt"), header=header)
    main(["plan", scene])
    (line,) = capsys.readouterr().err.splitlines()
    assert "warning: scan.txt: the rms slope is 5.17e-05" in line
    main(["run", scene, "--out", "results", "--quiet"])
    main(["report", "results"])
    page = (tmp_path / "results" / "report.html").read_text()
    assert "scan.txt: the rms slope is" in page


def test_lengths_of_errors_about_a_scan_are_in_nanometres(scene, tmp_path, capsys):
    for line, message in (
        ('center = ["4 nm", "12 nm"]', "spans 9.75 x 9.75 nm, got (4, 12) nm"),
        ("[path]\nvalues = [1e3]", "defined up to 4.75 nm from its axis"),
    ):
        text = SMOOTH if line.startswith("center") else SMOOTH[: SMOOTH.index("[path]")]
        text = re.sub("shape = .*", "", text)
        (tmp_path / scene).write_text(f"{text}{SECTION}{line}\n")
        assert main(["run", scene, "--out", "out"]) > 0
        printed = capsys.readouterr()
        assert message in " ".join((printed.out + printed.err).split())
    (tmp_path / scene).write_text(SMOOTH + SECTION + 'margin = "6 nm"\n')
    assert main(["places", scene, "--out", "places"]) == 2
    assert "a margin of 6 nm leaves no places on the scan" in capsys.readouterr().err
