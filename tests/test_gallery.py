"""The examples of the gallery, each run at a small size: what it tells, its picture."""

import re
import sys
from dataclasses import replace
from importlib import import_module
from pathlib import Path

import pytest

from ase_roughcontact.scene import Scene

pytest.importorskip("matplotlib").use("Agg")

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
SMALL = {
    "first_contact": ["--size", "24"],
    "hertz_optimizers": ["--size", "12"],
    "load_sweep": ["--radius", "100"],
    "cantilever": ["--steps", "25"],
    "measured_topography": ["--size", "32"],
    "adhesion_loop": ["--radius", "30", "--stiffness", "1"],
    "ensemble_database": ["--seeds", "2", "--loads", "1", "3", "--workers", "1"],
    "own_wall": [],
    "mixed_calculator": ["--size", "6"],
}


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    """Result of an example, and what it printed, after its picture has been seen."""

    def ran(name):
        monkeypatch.chdir(tmp_path)
        monkeypatch.syspath_prepend(str(EXAMPLES / "gallery"))
        result = import_module(name).main(SMALL[name])
        assert (tmp_path / f"{name}.png").stat().st_size > 5000
        return result, capsys.readouterr().out

    yield ran
    for name in SMALL:
        sys.modules.pop(name, None)


def last_number(text):
    """Last number of the last line."""
    return float(re.findall(r"-?\d+\.?\d*(?:e-?\d+)?", text.splitlines()[-1])[-1])


@pytest.mark.parametrize(
    "name, tolerance",
    [
        ("first_contact", 0.01),
        ("cantilever", 0.03),
        ("measured_topography", 0.02),
        ("own_wall", 5e-4),
    ],
)
def test_error_that_is_printed_last_is_small(run, name, tolerance):
    error, text = run(name)
    assert abs(error) < tolerance
    assert last_number(text) / 100 == pytest.approx(error, abs=5e-4)


def test_five_optimizers_find_hertz_s_force(run):
    errors, _ = run("hertz_optimizers")
    assert len(errors) == 5
    assert max(map(abs, errors.values())) < 0.02


def test_adhesion_loop_pulls_off_as_maugis_and_dugdale_say(run):
    (loop,), text = run("adhesion_loop")
    force, theory = map(float, text.splitlines()[-1].split()[2:4])
    assert force == pytest.approx(theory, rel=0.02)
    assert loop.pull_off_force == pytest.approx(force * 3.14159 * 0.02 * 30, rel=1e-3)


def test_load_sweep_leaves_a_movie_and_columns(run, tmp_path):
    ratio, text = run("load_sweep")
    assert 0.5 < ratio < 2.0
    assert f"{ratio:.3f} of Eq. (4)" in text
    assert (tmp_path / "sweep.traj").exists()
    assert "pressure:R:1" in (tmp_path / "sweep.extxyz").read_text()


def test_ensemble_is_in_the_database(run, tmp_path):
    ratio, text = run("ensemble_database")
    assert 0.3 < ratio < 10.0
    assert "of 4 steps" in text
    assert (tmp_path / "spheres.db").exists()


@pytest.mark.parametrize(
    "name, optimizer",
    [
        ("first_contact", "ActiveSet"),
        ("measured_topography", "NewtonKrylov"),
        ("mixed_calculator", "LBFGS"),
    ],
)
def test_a_contact_that_did_not_converge_is_told(run, monkeypatch, name, optimizer):
    monkeypatch.syspath_prepend(str(EXAMPLES / "gallery"))
    cls = getattr(import_module(name), optimizer)
    monkeypatch.setattr(cls, "run", lambda *_, **__: False)
    with pytest.raises(RuntimeError, match="did not converge"):
        run(name)


def test_steps_of_an_ensemble_that_did_not_converge_are_counted(run, monkeypatch):
    scene = Scene.default()
    short = replace(scene, solver=replace(scene.solver, max_steps=1))
    monkeypatch.setattr(Scene, "default", lambda: short)
    with pytest.raises(RuntimeError, match=r"spheres\.db: 0 steps converged, not 4"):
        run("ensemble_database")


def test_springs_as_calculator_and_as_constraints_are_the_same(run):
    error, _ = run("mixed_calculator")
    assert error < 1e-5


def test_every_example_has_its_picture_and_its_line_in_the_index():
    index = (EXAMPLES / "README.md").read_text()
    for name in SMALL:
        assert f"[`{name}.py`](gallery/{name}.py)" in index
        assert f"images/{name}.png" in index
    for target in re.findall(r'(?:\]\(|src=")([^)":]+)[)"]', index):
        assert (EXAMPLES / target).exists(), target


@pytest.mark.parametrize("name", SMALL)
def test_examples_and_their_pictures_are_small(name):
    lines = (EXAMPLES / "gallery" / f"{name}.py").read_text().splitlines()
    assert len(lines) <= 60
    assert (EXAMPLES / "images" / f"{name}.png").stat().st_size < 150_000
