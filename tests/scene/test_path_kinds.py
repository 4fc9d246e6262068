"""Kinds of path, with one that is added from outside of the package."""

import re
from dataclasses import dataclass

import numpy as np
import pytest
from small_scene import SMALL

from ase_roughcontact.cli import main
from ase_roughcontact.plot import draw_file
from ase_roughcontact.scene import Loop, PathKind, Scene, Steps
from ase_roughcontact.scene.path_kind import PATHS
from ase_roughcontact.scene.preview import preview
from ase_roughcontact.scene.results import outputs
from ase_roughcontact.scene.section import lengths


@dataclass(frozen=True)
class Oscillation(PathKind):
    """Height that oscillates around a mean."""

    kind = "swing"
    control = "height"
    columns = {"height": "height", "normal_force": "force"}
    captions = {"oscillation.png": "Force along the path."}

    mean: float | str = 0.0
    amplitude: float | str = 1.0
    cycles: int = 1
    steps: int = 4

    def targets(self, bodies):
        path = self.plain(["mean", "amplitude"], lengths(bodies.spacing), "Å")
        phase = 2.0 * np.pi * np.arange(self.cycles * self.steps + 1) / self.steps
        return path.mean + path.amplitude * np.cos(phase)

    def summary(self, bodies, states):
        force = max(state.normal_force for state in states)
        return {"largest force": f"{force:.4g} eV/Å"}

    def draw(self, bodies, states, folder, ending="png"):
        forces, name = [state.normal_force for state in states], f"oscillation.{ending}"
        draw_file(folder / name, lambda axes, y: axes.plot(y, "o-"), forces)
        yield name


PATH = '[path]\nkind = "swing"\nmean = "0.2 nm"\namplitude = 1.0\ncycles = 2\n'
ELASTIC = SMALL.replace("[substrate]", "[substrate]\nhardness = inf")
TEXT = ELASTIC[: ELASTIC.index("[path]")] + PATH
HEIGHTS = [3.0, 2.0, 1.0, 2.0, 3.0, 2.0, 1.0, 2.0, 3.0]


def test_a_scene_has_the_targets_of_a_kind_of_path_from_outside():
    scene = Scene.parse(TEXT)
    scene.check()
    np.testing.assert_allclose(scene.targets, HEIGHTS)
    forces = [step.normal_force for step in scene.relax(validity="ignore")]
    np.testing.assert_allclose(forces[:4], forces[4:8], rtol=1e-3, atol=1e-6)
    assert np.argmax(forces) in (2, 6)


def test_a_scene_with_a_kind_from_outside_is_written_and_read_again():
    scene = Scene.parse(TEXT)
    assert Scene.parse(scene.toml).changes_from(scene) == []
    other = scene.with_values({"path.cycles": 3})
    assert other.identity != scene.identity and len(other.targets) == 13
    assert list(preview(scene).targets) == pytest.approx(HEIGHTS)


def test_the_commands_know_a_kind_from_outside(tmp_path, capsys):
    file, folder = tmp_path / "scene.toml", tmp_path / "out"
    file.write_text(TEXT)
    assert main(["plan", str(file)]) == 0
    assert re.search(r"height .*\n +\(Å\)", capsys.readouterr().out)
    assert main(["run", str(file), "--out", str(folder)]) == 0
    lines = capsys.readouterr().out.splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith("step"))
    assert lines[start - 1].split() == ["height", "force"]
    rows = [line.split() for line in lines[start + 1 : start + 10]]
    assert [float(row[1]) for row in rows] == HEIGHTS
    assert [row[0] for row in rows] == [f"{number}/8" for number in range(9)]
    assert any(line.startswith("largest force ") for line in lines)
    assert (folder / "oscillation.png").stat().st_size > 5000
    assert main(["run", str(file), "--out", str(folder), "--quiet"]) == 0  # resumed
    assert main(["report", str(folder)]) == 0
    assert "Force along the path." in (folder / "report.html").read_text()


STEPS, LOOP = "values = [1.0]\n", 'kind = "loop"\ndeepest = 0.2\n'


@pytest.mark.parametrize(
    "path, lines, keys",
    [
        (LOOP, "first = 1.0\nlast = 2.0\nsteps = 3", "first, last, steps"),
        (LOOP, "values = [1.0]", "values"),
        (LOOP, 'control = "penetration"', "control"),
        (LOOP, 'scale = "linear"', "scale"),
        *((STEPS, f"{key} = 0.5", key) for key in ("deepest", "step", "cantilever")),
        (STEPS, "tolerance = 0.5", "tolerance"),
    ],
)
def test_keys_of_another_kind_are_an_error(path, lines, keys):
    other = "steps" if path == LOOP else "loop"
    message = rf'\[path\] {keys} need kind = "{other}", .*: omit {keys}, or give kind'
    with pytest.raises(ValueError, match=message):
        Scene.parse(f"[path]\n{path}{lines}")


def test_another_kind_has_only_its_own_keys():
    steps = Scene(path=Loop(deepest=1.0)).with_values(
        {"path.control": "height", "path.kind": "steps", "path.values": (1.0, 2.0)}
    )
    assert steps.path == Steps(heights=(1.0, 2.0))


def test_the_entries_of_a_loop_that_identify_its_calculation():
    assert Loop(2.0).given == {"kind": "loop", "deepest": 2}


RELAXING = (
    "[substrate]\nmaterial = 'Cu'\nrelaxation_moduli = [0.5]\n"
    "relaxation_times = [1.0]\n"
)
FRICTION = "[substrate]\nmaterial = 'Cu'\n[friction]\ncoefficient = 0.3\n"


@pytest.mark.parametrize(
    "section, attribute, message",
    [(RELAXING, "in_time", "viscoelastic"), (FRICTION, "has_friction", "sideways")],
)
def test_a_kind_of_path_says_what_it_has_that_a_solid_or_friction_needs(
    section, attribute, message, monkeypatch
):
    scene = Scene.parse(PATH + section)
    with pytest.raises(ValueError, match=message):
        scene.check()
    monkeypatch.setattr(Oscillation, attribute, True)
    scene.check()


def test_a_file_with_the_name_of_a_picture_of_any_kind_is_refused():
    pictures = {name for kind in PATHS.values() for name in kind.captions}
    assert "oscillation.png" in pictures
    assert pictures <= outputs()
