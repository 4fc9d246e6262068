"""The command that compares optimizers on a scene."""

import csv
import json
import re

import pytest
from loop_scene import LOOP
from small_scene import SMALL

from ase_roughcontact.cli import main
from ase_roughcontact.scene import Scene, relax_loop
from ase_roughcontact.scene.optimizers import compare_on, deepest_atoms

NAMES = "NewtonKrylov, LBFGS on modes"


@pytest.fixture
def scene(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "small.toml"
    file.write_text(SMALL)
    return file


def test_table_csv_and_picture_are_written(scene, tmp_path, capsys):
    words = ["optimizers", str(scene), "--names", NAMES, "--table", "found.csv"]
    assert main(words) == 0
    printed = capsys.readouterr().out
    assert all(name in printed for name in NAMES.split(", "))
    assert (tmp_path / "optimizers.png").read_bytes().startswith(b"\x89PNG")
    with open(tmp_path / "found.csv", newline="") as file:
        assert [row["optimizer"] for row in csv.DictReader(file)] == NAMES.split(", ")


def test_json_has_a_line_for_each_optimizer(scene, capsys):
    words = ["optimizers", str(scene), "--names", "NewtonKrylov,GPMin", "--json"]
    assert main(words) == 1
    newton, failed = map(json.loads, capsys.readouterr().out.splitlines())
    assert newton["converged"] and newton["changed_atoms"] == 0
    assert newton["units"]["energy_error"] == "eV"
    assert not failed["converged"] and failed["energy_error"] is None


def test_unknown_names_are_refused(scene, capsys):
    assert main(["optimizers", str(scene), "--names", "FIRE3"]) == 2
    assert "FIRE2" in capsys.readouterr().err


PATHS = {
    "load": 'control = "load"\nvalues = [4.0, 1.0]',
    "penetration": 'control = "penetration"\nvalues = [0.4, 0.1]',
    "height": 'control = "height"\nvalues = [-0.4, -0.1]',
}


@pytest.mark.parametrize("control", PATHS)
def test_state_is_the_deepest_of_the_scene(control):
    head, *_ = re.split(r"\[path\]|\[solver\]", SMALL)
    scene = Scene.parse(f"{head}[path]\n{PATHS[control]}")
    steps = list(scene.relax(validity="ignore"))
    compared = compare_on(scene, ["NewtonKrylov"], accuracy=1e-4)
    assert compared.normal_force == pytest.approx(steps[0].normal_force, rel=1e-4)
    assert compared.contact_atoms == steps[0].repulsive_atoms
    assert (deepest_atoms(scene).calc.parameters["load"] > 0.0) == (control == "load")


def test_deepest_state_of_a_loop_is_compared():
    scene = Scene.parse(LOOP)
    loop = relax_loop(scene, validity="ignore")
    deepest = max(loop.approach, key=lambda step: step.penetration)
    compared = compare_on(scene, ["NewtonKrylov"])
    assert compared.contact_atoms == deepest.repulsive_atoms
