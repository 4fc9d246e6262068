"""Loops of scenes that turn by themselves, or in tension."""

import pytest

from ase_roughcontact import cantilever_curve
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.cli import main
from ase_roughcontact.scene import Scene, relax_loop
from ase_roughcontact.scene.preview import preview

LOOP = """
[substrate]
spacing = 2.5
contact_modulus = 100.0
hardness = inf
[sphere]
unit = "a0"
radius = 20.0
[interaction]
kind = "adhesive"
work_of_adhesion = 1.0
[path]
kind = "loop"
tolerance = 0.05
[solver]
accuracy = "fast"
"""


def printed(capsys, *arguments):
    assert main(list(map(str, arguments))) == 0
    return " ".join(capsys.readouterr().out.split())


@pytest.fixture(scope="module")
def loop():
    return relax_loop(Scene.parse(LOOP), validity="ignore")


@pytest.mark.parametrize("newton_per_metre", [0.01, 1.0, 100.0])
def test_a_loop_that_turns_by_itself_holds_every_cantilever(loop, newton_per_metre):
    curve = cantilever_curve(loop, newton_per_metre * UNITS["N/m"])
    assert curve.pull_off_force == pytest.approx(loop.pull_off_force, rel=0.05)
    assert curve.turn_force == loop.turn.normal_force
    assert curve.turn_penetration == pytest.approx(loop.turn.penetration)


def test_run_prints_the_turn_and_why_a_pull_off_force_is_a_lower_bound(
    tmp_path, capsys
):
    scene = tmp_path / "loop.toml"
    scene.write_text(LOOP.replace("tolerance", "deepest = 0.5\ntolerance"))
    out = printed(capsys, "run", scene, "--out", tmp_path / "out")
    assert "turn at -" in out and "and a depth of 0.05 nm" in out
    assert "is a lower bound" in out
    assert main(["report", str(tmp_path / "out")]) == 0
    assert "is a lower bound" in (tmp_path / "out" / "report.html").read_text()
    scene.write_text(LOOP)
    out = printed(capsys, "run", scene, "--out", tmp_path / "deep")
    assert "lower bound" not in out


def test_plan_says_that_the_deepest_state_is_an_estimate(tmp_path, capsys, loop):
    scene = tmp_path / "loop.toml"
    scene.write_text(LOOP)
    out = printed(capsys, "plan", scene)
    assert "an estimate" in out
    depth = Scene.read(scene).planned.targets.item()
    assert 0.5 < depth / loop.turn.penetration < 3.0
    assert list(preview(Scene.read(scene)).targets) == [depth]


def test_a_loop_without_attraction_needs_a_depth():
    adhesive = 'kind = "adhesive"\nwork_of_adhesion = 1.0'
    scene = Scene.parse(LOOP.replace(adhesive, 'kind = "repulsive"'))
    with pytest.raises(ValueError, match=r"\[path\] .* needs deepest"):
        scene.check()
