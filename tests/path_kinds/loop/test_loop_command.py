"""Loops from a scene file and from the command line."""

import csv
import io
import math
import re
import shutil
from contextlib import redirect_stdout
from dataclasses import replace
from itertools import islice

import numpy as np
import pytest
from loop_scene import LOOP
from small_scene import SMALL

from ase_roughcontact import adhesion_loop
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.cli import main
from ase_roughcontact.paths.restart import read_restart, read_steps, restart_file
from ase_roughcontact.scene import Scene, relax_loop
from ase_roughcontact.stepping.step import Stepper


@pytest.fixture(scope="module")
def printed(tmp_path_factory):
    """Folder of the results of a loop from the command line, and what was printed."""
    folder = tmp_path_factory.mktemp("loop")
    (folder / "loop.toml").write_text(LOOP)
    with redirect_stdout(io.StringIO()) as text:
        assert main(["run", str(folder / "loop.toml"), "--out", str(folder)]) == 0
    return folder, text.getvalue()


@pytest.fixture(scope="module")
def run(printed):
    return printed[0]


def test_the_loop_of_a_scene_agrees_with_the_loop_of_its_atoms():
    scene = Scene.parse(LOOP)
    loop = relax_loop(scene, validity="ignore")
    options = {"deepest": 2.0, "step": 0.5, "tolerance": 0.01, "accuracy": "fast"}
    direct = adhesion_loop(scene.atoms(), **options, validity="ignore")
    assert loop.pull_off_force == direct.pull_off_force > 0.0
    assert f"pull-off force {loop.pull_off_force:.4g} eV/Å" in str(loop)
    forces = [state.normal_force for state in scene.relax(validity="ignore")]
    states = (*loop.approach, *loop.retraction[1:])
    assert forces == [state.normal_force for state in states]
    assert scene.cantilever == pytest.approx(60.0 * UNITS["J/m^2"])


def test_the_largest_step_is_a_tenth_of_the_way_down_by_default():
    scene = Scene.parse(LOOP.replace("step = 0.5", ""))
    wall = scene.wall
    down = wall.cutoff - wall.contact_distance + 2.0
    assert scene.path.loop(scene.bodies).step == pytest.approx(down / 10)


def test_the_force_curve_of_the_cantilever_is_a_table(run):
    with open(run / "cantilever.csv") as table:
        rows = list(csv.DictReader(table))
    deflection, force = (
        np.array([float(row[name]) for row in rows])
        for name in ("deflection (nm)", "force (nN)")
    )
    np.testing.assert_allclose(force, 60.0 * deflection, rtol=1e-6)
    assert [row["branch"] for row in rows] == sorted(row["branch"] for row in rows)
    assert force[0] == 0.0
    assert rows[0]["distance (nm)"] == rows[-1]["distance (nm)"]


def test_a_loop_prints_its_states_and_characteristic_values(printed):
    _, text = printed
    heads, units = (
        next(line for line in text.splitlines() if word in line.split()).split()
        for word in ("stiffness", "(N/m)")
    )
    assert heads == ["depth", "force", "stiffness", "area", "p", "max", "time"]
    assert units == ["step", "(Å)", "(nN)", "(N/m)", "(nm²)", "(GPa)", "(s)"]
    for words in ("pull-off force", "cantilever +60 N/m\n", "cantilever snap-in +from"):
        assert re.search(words, text)
    assert re.search(r"dissipated energy +[\d.]+ ± [\d.]+ eV\n", text)


def test_a_loop_without_instability_prints_no_remainder_of_the_tolerance():
    wall = 'kind = "adhesive"\nwork_of_adhesion = 1.0'
    scene = Scene.parse(LOOP.replace(wall, 'kind = "repulsive"'))
    printed = scene.path.summary(scene.bodies, tuple(scene.relax(validity="ignore")))
    assert re.fullmatch(r"none within .* of [\d.]+ eV", printed["dissipated energy"])


def test_the_energy_lost_in_a_loop_with_a_state_without_energy_is_not_known():
    scene = Scene.parse(LOOP)
    first, second, *others = scene.relax(validity="ignore")
    states = first, replace(second, energy=math.nan, converged=False), *others
    printed = scene.path.summary(scene.bodies, states)
    assert "not known" in printed["dissipated energy"]


@pytest.mark.parametrize(
    "old, new, message",
    [
        ('"0.2 nm"', '"-0.9 nm"', r"deepest must be .* above -0\.\d+ nm, .* -0\.9 nm"),
        ('"loop"', '"lop"', "unknown kind of path 'lop'"),
        ("step = 0.5", "step = -1.0", "step must be .* > 0"),
        ("cantilever = 60.0", "cantilever = 0.0", "cantilever_stiffness must be"),
    ],
)
def test_wrong_loops_are_errors_of_the_path(old, new, message):
    with pytest.raises(ValueError, match=rf"\[path\] {message}"):
        Scene.parse(LOOP.replace(old, new)).check()


def test_a_cantilever_that_is_too_soft_leaves_the_results_of_the_loop(tmp_path, capsys):
    (tmp_path / "loop.toml").write_text(LOOP.replace('"0.2 nm"', '"-0.1 nm"'))
    arguments = ["run", str(tmp_path / "loop.toml"), "--out", str(tmp_path), "--quiet"]
    assert main(arguments) == 1
    assert "jumps in beyond the deepest state" in capsys.readouterr().err
    assert (tmp_path / "loop.png").exists()


@pytest.mark.parametrize("part", ["first", "third", "deepest", "last but one"])
def test_an_interrupted_loop_is_continued(run, tmp_path, part):
    scene, expected = Scene.parse(LOOP), read_steps(restart_file(run / "sweep.traj"))
    deepest = min(range(len(expected)), key=lambda i: expected[i].height)
    number = {"first": 0, "third": 2, "deepest": deepest}
    count = 1 + number.get(part, len(expected) - 2)
    interrupted = scene.run(tmp_path, validity="ignore")
    list(islice(interrupted, count))
    interrupted.close()
    assert len(read_restart(restart_file(tmp_path / "sweep.traj")).steps) == count
    states = list(scene.run(tmp_path, validity="ignore"))
    assert [state.height for state in states] == [state.height for state in expected]
    for name in ("normal_force", "contact_area", "contact_stiffness", "energy"):
        found, known = ([getattr(s, name) for s in each] for each in (states, expected))
        # after the turn the first step starts from another prediction
        tolerance = 1e-6 if part == "deepest" else 1e-9
        assert found == pytest.approx(known, rel=tolerance, abs=1e-12), name


def test_another_cantilever_keeps_the_states_of_a_loop(run, tmp_path, monkeypatch):
    folder = tmp_path / "loop"
    shutil.copytree(run, folder)
    soft = Scene.parse(LOOP).with_values({"path.cantilever": 1e3})
    monkeypatch.setattr(Stepper, "relax", lambda *_, **__: pytest.fail("calculated"))
    (tmp_path / "loop.toml").write_text(soft.toml)
    command = ["run", str(tmp_path / "loop.toml"), "--out", str(folder), "--quiet"]
    assert main(command) == 0
    assert Scene.of_results(folder).cantilever == pytest.approx(1e3 * UNITS["N/m"])
    for name in "curve.csv", "cantilever.csv":
        same = (folder / name).read_bytes() == (run / name).read_bytes()
        assert same == (name == "curve.csv")


def test_a_plan_of_a_loop_has_its_deepest_state_and_what_its_cantilever_holds(
    tmp_path, capsys
):
    (tmp_path / "loop.toml").write_text(LOOP.replace("= 60.0", "= 0.2"))
    assert main(["plan", str(tmp_path / "loop.toml")]) == 0
    text = capsys.readouterr().out
    _, found, plan = text.partition("The deepest state of the loop")
    assert found and re.search(r"\n *2.000 +18x18 ", plan)
    note = "Cantilever of 0.2 N/m: if the contact still pulls with more than about 0.04"
    assert note in " ".join(text.split())
    assert main(["tradeoff", str(tmp_path / "loop.toml")]) == 2
    assert "pull-off force" in capsys.readouterr().err
    with pytest.raises(ValueError, match='kind = "loop"'):
        relax_loop(Scene.default())


@pytest.mark.parametrize("command", ["plan", "run"])
def test_a_wall_beyond_the_roughness_is_an_error_before_a_loop_begins(
    tmp_path, capsys, command
):
    wall = 'kind = "power-law"\nattraction_range = "3 a0"'
    text = LOOP.replace('kind = "adhesive"', wall).replace("shape = [18, 18]", "")
    text = text.replace(
        "[interaction]",
        "[roughness]\nunit = 'a0'\nlong_wavelength = 8.0\n[interaction]",
    )
    (tmp_path / "loop.toml").write_text(text)
    options = ["--out", str(tmp_path / "out")] if command == "run" else []
    assert main([command, str(tmp_path / "loop.toml"), *options]) > 0
    out, err = capsys.readouterr()
    message = "give the roughness a domain of "
    assert message in (err if command == "run" else out)
    assert "state" not in out or command == "plan"
    assert not (tmp_path / "out").exists()


def test_a_loop_does_not_replace_the_results_of_another_scene(run, tmp_path, capsys):
    folder = shutil.copytree(run, tmp_path / "results")
    results = {
        name: (folder / name).read_bytes() for name in ("curve.csv", "sweep.traj")
    }
    scene = tmp_path / "other.toml"
    scene.write_text(LOOP.replace("0.2 nm", "0.19 nm"))
    assert main(["run", str(scene), "--out", str(folder)]) == 2
    assert 'deepest was "0.2 nm", is "0.19 nm"' in capsys.readouterr().err
    assert {name: (folder / name).read_bytes() for name in results} == results
    scene.write_text(LOOP)
    list(Scene.parse(SMALL).run(tmp_path / "steps"))
    assert main(["run", str(scene), "--out", str(tmp_path / "steps")]) == 2
    assert "results of another scene" in capsys.readouterr().err
    (tmp_path / "steps" / "scene.toml").unlink()
    assert main(["run", str(scene), "--out", str(tmp_path / "steps")]) == 2
    assert "holds steps of another path" in capsys.readouterr().err


def test_a_folder_of_places_is_no_folder_of_a_run(tmp_path, capsys):
    folder, scene = tmp_path / "results", tmp_path / "other.toml"
    folder.mkdir()
    (folder / "places.csv").touch()
    (folder / "scene.toml").write_text(SMALL.replace("60.0", "61.0"))
    for text in (SMALL, LOOP):
        scene.write_text(text)
        assert main(["run", str(scene), "--out", str(folder)]) == 2
        assert "[sphere] radius was 61.0" in capsys.readouterr().err
    assert not (folder / "sweep.traj").exists()
