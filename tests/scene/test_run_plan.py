"""Plans of runs, by a trial on a coarser grid, against what is then measured."""

import json
import tracemalloc

import numpy as np
import pytest

from ase_roughcontact._util.printing import plain
from ase_roughcontact.cli import main
from ase_roughcontact.cli.figures import write_view
from ase_roughcontact.ensemble import product
from ase_roughcontact.ensemble.ensemble_plan import EnsemblePlan
from ase_roughcontact.paths.planned_steps import Plan, PlannedStep, StartCosts
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.preview import coarser_scene
from ase_roughcontact.scene.run_plan import run_plan

SOLID = """
[substrate]
contact_modulus = 100.0
spacing = 2.0
hardness = inf
[sphere]
radius = "40 nm"
"""
HARD = SOLID + '[interaction]\nkind = "hard"\n'
STEPS = HARD + '[path]\nfirst = "2 nN"\nlast = "50 nN"\nsteps = 8\n'
FLAT = """
[substrate]
contact_modulus = 100.0
spacing = 1.0
periodic = true
hardness = inf
[sphere]
radius = inf
[roughness]
unit = "a0"
rms_slope = 0.1
short_wavelength = 8.0
long_wavelength = 32.0
domain = "128 a0"
seed = 3
[interaction]
kind = "hard"
[path]
values = ["1 GPa"]
"""
LOOP = (
    SOLID
    + """
[interaction]
kind = "adhesive"
work_of_adhesion = 0.05
attraction_range = "0.6 nm"
[path]
kind = "loop"
deepest = "0.2 nm"
"""
)


def test_the_files_of_a_run_are_planned_within_a_third(tmp_path):
    scene, folder = tmp_path / "scene.toml", tmp_path / "out"
    scene.write_text(STEPS)
    plan = run_plan(Scene.read(scene))
    assert main(["run", str(scene), "--out", str(folder), "--quiet"]) == 0
    files = sum(each.stat().st_size for each in folder.iterdir())
    assert plan.count == 8
    assert 3 / 4 < plan.files / files < 4 / 3


def test_the_steps_of_a_loop_are_planned_within_a_third():
    scene = Scene.parse(LOOP)
    steps = list(scene.relax())
    assert 3 / 4 < run_plan(scene).count / len(steps) < 4 / 3


def test_the_plan_of_a_loop_with_a_trial_that_ends_early_is_a_lower_bound(monkeypatch):
    monkeypatch.setattr("ase_roughcontact.scene.run_plan._MAX_SECONDS", 0.0)
    plan = run_plan(Scene.parse(LOOP))
    assert (plan.count, plan.at_least) == (1, True)
    assert " at least 0:00:01 of" in " ".join(plain(*plan.printed("", 1.0)).split())


def test_the_restart_file_has_the_pressure_of_the_last_but_one_window(tmp_path):
    text = STEPS.replace("40 nm", "1 um").replace('first = "2 nN"', 'first = "2 uN"')
    scene = Scene.parse(text.replace("steps = 8", "steps = 2"))
    steps = scene.run(tmp_path, validity="ignore")
    planned = tuple(PlannedStep(1.0, window=step.window) for step in steps)
    size = (tmp_path / "sweep.restart.npz").stat().st_size
    assert 3 / 4 < Plan(planned, (), 1e9).restart / size < 4 / 3


def test_the_time_grows_with_the_grid_by_the_pairs_of_the_trial():
    scene = Scene.parse(STEPS)
    fine = scene.with_values({"substrate.refine": 4})
    coarse, plan = run_plan(scene), run_plan(fine)
    assert plan.step_seconds > coarse.step_seconds
    assert plan.uncertainty < 2.0


def test_a_step_of_a_rough_flat_has_the_pairs_of_its_own_grid(monkeypatch):
    scene = Scene.parse(FLAT)
    monkeypatch.setattr(
        "ase_roughcontact.scene.run_plan.pair_timer",
        lambda halfspace: lambda grid: 1e3 * (grid == (128, 128)),
    )
    planned = run_plan(scene).step_seconds / 1e3 - 40.0
    (step,) = scene.relax()
    assert 1 / 1.4 < planned / step.pairs < 1.4


def test_a_plan_has_the_time_and_memory_of_the_start_of_the_process():
    alone = run_plan(Scene.parse(STEPS))
    start = StartCosts(program=2.0, libraries=300e6, scene=50.0, memory=1e9)
    plan = run_plan(Scene.parse(STEPS), start)
    assert plan.seconds - plan.step_seconds > 52.0
    assert (plan.memory, alone.memory < 0.3e9) == (1e9, True)


def test_loads_of_a_flat_are_planned_as_pressures(tmp_path, capsys):
    text = HARD.replace('"40 nm"', "inf")
    text += "[roughness]\nlong_wavelength = '16 a0'\n[path]\nvalues = ['20 MPa']\n"
    (tmp_path / "flat.toml").write_text(text)
    main(["plan", str(tmp_path / "flat.toml")])
    assert " 20.00 " in capsys.readouterr().out


def test_a_load_above_the_hardness_of_the_whole_flat_cannot_run():
    plastic = 'kind = "plastic"\nhardness = "2 GPa"'
    text = FLAT.replace('kind = "hard"', plastic).replace('"1 GPa"', '"1 GPa", "3 GPa"')
    first, second = Scene.parse(text).plan().steps
    assert first.problem == ""
    assert "give a smaller load" in second.problem


def test_files_of_a_run_include_the_copied_scan(tmp_path):
    wave = np.cos(0.5 * np.arange(200))
    np.savetxt(tmp_path / "scan.txt", 0.1 * wave * wave[:, None])
    tip = '[topography]\nfile = "scan.txt"\nrole = "substrate"\n'
    tip += 'spacing = "2 nm"\nunit = "nm"\n'
    (tmp_path / "scene.toml").write_text(STEPS + tip)
    (tmp_path / "smooth.toml").write_text(STEPS)
    with_scan, smooth = (
        Scene.read(tmp_path / f"{name}.toml").plan() for name in ("scene", "smooth")
    )
    size = (tmp_path / "scan.txt").stat().st_size
    assert (with_scan.inputs, smooth.inputs) == (size, 0)
    assert with_scan.files > size


def test_a_scene_that_is_too_large_for_a_trial_has_a_wide_range():
    large = Scene.parse(STEPS).with_values({"sphere.radius": "400 mm"})
    plan = run_plan(large)
    assert not plan.run_steps
    assert plan.uncertainty == 3.0


def test_the_trial_of_an_attractive_wall_resolves_its_range():
    soft = Scene.parse(LOOP).with_values({"substrate.contact_modulus": 1.0})
    narrow = soft.with_values({"interaction.attraction_range": "0.15 nm"})
    assert coarser_scene(soft)[1] == 4
    assert coarser_scene(narrow)[1] == 2


def test_cases_of_an_ensemble_are_planned_with_their_workers():
    scenes = product(Scene.parse(STEPS), {"sphere.radius": ["40 nm", "60 nm", "80 nm"]})
    plan = EnsemblePlan.of(scenes, workers=2)
    assert (plan.cases, plan.steps, plan.workers) == (3, 24, 2)
    assert plan.seconds == pytest.approx(plan.costs * plan.plan.step_seconds)
    assert 2.0 < plan.costs < 4.0
    assert plan.rows == 27  # steps, and a row of each case


def test_a_plan_of_an_ensemble_calculates_no_case(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.toml").write_text(STEPS)
    radii = "sphere.radius=40 nm,60 nm"
    assert main(["ensemble", "scene.toml", "--set", radii, "--plan", "--json"]) == 0
    totals = json.loads(capsys.readouterr().out)
    assert (totals["cases"], totals["steps"]) == (2, 16)
    assert [each.name for each in tmp_path.iterdir()] == ["scene.toml"]


def test_the_number_of_cases_of_a_plan_must_be_known(tmp_path, capsys):
    (tmp_path / "scene.toml").write_text(STEPS)
    error = ["--error", "0.1", "--plan"]
    assert main(["ensemble", str(tmp_path / "scene.toml"), *error]) == 2
    assert "--set roughness.seed=0:9:10" in capsys.readouterr().err


def test_frames_for_viewing_are_made_one_after_another(tmp_path):
    shape = "periodic = true\nshape = [160, 160]\n[sphere]"
    scene = Scene.parse(STEPS.replace("[sphere]", shape))
    steps = list(scene.run(tmp_path))
    write_view(scene, steps[:1], tmp_path)  # imports

    def peak(number):
        tracemalloc.start()
        write_view(scene, steps[:number], tmp_path)
        found = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return found

    # a view of 40 x 40 atoms is small, a frame of 160 x 160 is not
    assert peak(8) - peak(4) < 0.1 * peak(4)
