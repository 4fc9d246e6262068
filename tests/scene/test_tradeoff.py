"""Error budget of a scene, and the cheapest plan for a wanted error."""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from ase_roughcontact.cli import main
from ase_roughcontact.cli.figures import draw_tradeoff
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.choices import Choice, Tradeoff
from ase_roughcontact.scene.tradeoff import tradeoff

TEXT = """
[substrate]
spacing = 2.0
contact_modulus = 100.0
hardness = inf
model = "{model}"
[sphere]
radius = 100.0
[roughness]
long_wavelength = 16.0
[interaction]
kind = "hard"
[path]
values = [30.0, 100.0]
"""


def scene(model="continuum"):
    return Scene.parse(TEXT.format(model=model))


@cache
def study(model="continuum", error=0.05):
    return tradeoff(scene(model), error)


def errors_of(found, source):
    return {c.label: c.error for c in found.choices if c.source == source}


def test_errors_of_grids_are_those_against_finer_ones():
    fine = scene().with_values({"substrate.refine": 8}).relax()
    exact = np.array([step.continuum_area for step in fine])
    for level, error in errors_of(study(), "grid").items():
        steps = scene().with_values({"solver.accuracy": level}).relax()
        areas = np.array([step.continuum_area for step in steps])
        true = abs(areas / exact - 1.0).max()
        assert error == pytest.approx(true, abs=0.015)
    assert errors_of(study(), "grid")["high"] < 0.01


def test_most_accurate_scene_has_the_error_that_it_estimates():
    steps = scene().with_values({"solver.accuracy": "high"}).relax()
    estimate = max(step.area_error / step.continuum_area for step in steps)
    assert errors_of(study(), "grid")["high"] == pytest.approx(estimate)
    assert errors_of(study(), "boundary")["free"] == pytest.approx(estimate)


def test_error_of_one_realisation_is_the_spread_of_four():
    fast = scene().with_values({"solver.accuracy": "fast"})
    first = fast.roughness.seed
    areas = [
        [
            step.continuum_area
            for step in fast.with_values({"roughness.seed": n}).relax()
        ]
        for n in range(first, first + 4)
    ]
    spread = np.std(areas, axis=0, ddof=1) / np.mean(areas, axis=0)
    assert errors_of(study(), "realisations")["1"] == pytest.approx(spread.max())


def test_error_of_the_height_is_relative_to_the_penetration():
    found = tradeoff(scene(), of="height", steps=1)
    assert not errors_of(found, "theory")
    high = scene().with_values({"solver.accuracy": "high"})
    (hard,), (soft,) = (
        high.with_values({"interaction.kind": kind, "path.values": (30.0,)}).relax()
        for kind in ("hard", "repulsive")
    )
    error = abs(hard.height - soft.height) / hard.penetration
    assert errors_of(found, "wall")["repulsive instead"] == pytest.approx(error)


def test_steps_out_of_contact_have_no_relative_error():
    away = {"path.control": "height", "path.values": (50.0, -1.0)}
    found = tradeoff(scene().with_values(away), 0.5)
    assert found.choices
    assert np.all(np.isfinite([choice.error for choice in found.choices]))


def test_all_sources_are_compared():
    sources = {choice.source for choice in study().choices}
    assert sources == {"scene", "grid", "boundary", "wall", "theory", "realisations"}
    assert "tolerance" in {choice.source for choice in study("atoms").choices}
    assert errors_of(study(), "boundary")["cell of 2 diameters"] < 0.05
    assert errors_of(study(), "wall")["repulsive instead"] > 0.1
    single, four = (errors_of(study(), "realisations")[n] for n in ("1", "4"))
    assert four == pytest.approx(single / 2.0)


def test_plan_is_the_fastest_that_suffices_and_is_kept_on_another_surface():
    found = study()
    assert [choice.source for choice in found.plan] == ["grid", "boundary"]
    assert sum(choice.error for choice in found.plan) < 0.05
    assert found.kept and found.checked < 0.05
    assert "accuracy" in found.toml and "kept." in str(found)
    planned = Scene.parse(TEXT.format(model="continuum") + "[solver]\n")
    assert planned.with_values(found.plan[0].settings).check() is None


def made(*choices, wanted=0.1, **options):
    made = [Choice(*each) for each in choices]
    return Tradeoff(wanted, ("1 nN",), tuple(made), **options)


def test_front_has_the_choices_that_no_other_beats_in_both():
    found = made(
        ("grid", "fast", 0.1, 1.0),
        ("grid", "high", 0.01, 9.0),
        ("wall", "hard", 0.2, 5.0),
        ("theory", "Hertz", 0.3, 0.0),
    )
    assert [choice.label for choice in found.front] == ["fast", "high", "Hertz"]
    starred = [line for line in str(found).splitlines() if line.endswith("  *")]
    assert len(starred) == 3
    assert "No plan has an error of 0.1" in str(found) and not found.kept


def test_table_and_picture_name_the_answer(tmp_path):
    of_area, of_height = (
        made(("grid", "fast", 0.1, 1.0), of=of) for of in ("area", "height")
    )
    for found, name in ((of_area, "area"), (of_height, "height")):
        heading = ["source", "choice", name, "error", "time", "(s)", "memory", "(GB)"]
        assert str(found).splitlines()[0].split() == heading
    pictures = []
    for number, found in enumerate((of_area, of_area, of_height)):
        draw_tradeoff(found, tmp_path / f"{number}.png")
        pictures.append((tmp_path / f"{number}.png").read_bytes())
    assert pictures[0] == pictures[1] != pictures[2]


@pytest.mark.parametrize(
    "name, first", [("t.svg", b"<?xml"), ("t.PDF", b"%PDF"), ("t", b"\x89PNG")]
)
def test_ending_of_a_picture_is_its_format(tmp_path, name, first):
    draw_tradeoff(made(("grid", "fast", 0.1, 1.0)), tmp_path / name)
    assert (tmp_path / name).read_bytes().startswith(first)


@pytest.mark.parametrize("command", [["tradeoff"], ["fit", "curve.csv", "my.toml"]])
def test_unknown_format_of_a_picture_is_refused_before_anything_is_read(
    command, capsys
):
    assert main([*command, "--picture", "a.docx"]) == 2
    assert "a picture ends in one of ." in capsys.readouterr().err


def test_fastest_whole_is_chosen_among_the_three_that_should_be(monkeypatch):
    """Products of single times: 80, 160 and 320 with a cell, 400 and more without."""
    single = {"fast": 10.0, "normal": 20.0, "high": 40.0}
    with_cell = {"fast": 5.0, "normal": 3.0, "high": 8.0}
    relax = Scene.relax

    def timed(self, *args, **options):
        times = with_cell if self.substrate.periodic else single
        for step in relax(self, *args, **options):
            yield replace(step, seconds=times[self.solver.accuracy])

    monkeypatch.setattr(Scene, "relax", timed)
    plan = tradeoff(scene(), 1.0, steps=1).plan
    assert [each.label for each in plan] == ["normal", "cell of 2 diameters"]


@pytest.mark.parametrize("of, control", [("height", "load"), ("force", "penetration")])
def test_errors_of_other_answers_are_those_against_a_finer_grid(of, control):
    target = 10.0 if control == "load" else 3.0
    values = {"sphere.radius": 50.0, "roughness.long_wavelength": 8.0}
    values |= {"path.control": control, "path.values": (target,)}
    given = scene().with_values(values)
    found = errors_of(tradeoff(given, 0.05, of=of), "grid")
    column = {"height": "height", "force": "normal_force"}[of]

    def answers(**grid):
        steps = list(given.with_values(grid).relax(validity="ignore"))
        return np.array([[getattr(s, column), s.penetration] for s in steps]).T

    (coarse, _), (fine, depth) = (
        answers(**{key: value})
        for key, value in (("solver.accuracy", "fast"), ("substrate.refine", 4))
    )
    scale = depth if of == "height" else fine
    error = (abs(coarse - fine) / scale).max()
    assert found["fast"] == pytest.approx(error, abs=2e-3)
    assert found["high"] < 0.3 * found["fast"]


@pytest.mark.parametrize(
    "of, control", [("force", "load"), ("height", "height"), ("height", "penetration")]
)
def test_an_answer_that_the_path_prescribes_has_no_error(of, control):
    given = scene().with_values({"path.control": control})
    with pytest.raises(ValueError, match=f"the path prescribes the {of}"):
        tradeoff(given, of=of)
    with pytest.raises(ValueError, match="unknown answer"):
        tradeoff(given, of="depth")


def test_realisations_make_up_for_what_the_plan_leaves():
    grid = Choice("grid", "fast", 0.06, 1.0, 0.0, {"solver.accuracy": "fast"})
    found = made(("realisations", "1", 0.4, 1.0), plan=(grid,), checked=0.06)
    assert found.realisations == 25  # 0.4/5 beside 0.06
    assert 'accuracy = "fast"' in str(found)
    assert "mean over surfaces: 25 realisations" in str(found)
    worse = made(("realisations", "1", 0.4, 1.0), plan=(grid,), checked=0.2)
    assert "NOT KEPT" in str(worse)


def test_command_prints_table_or_lines_and_draws(tmp_path, capsys):
    file, picture = tmp_path / "my.toml", tmp_path / "t.png"
    file.write_text(TEXT.format(model="atoms"))
    command = ["tradeoff", str(file), "--error", "0.05", "--picture", str(picture)]
    assert main([*command, "--json", "--error-of", "height"]) == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert lines[0]["error_of"] == "height"
    assert {"source", "error", "seconds", "on_front", "in_plan"} <= set(lines[0])
    assert lines[0]["units"] == {"memory": "bytes", "seconds": "s"}
    assert picture.stat().st_size > 1000


def test_cutoffs_of_a_full_wall_are_choices():
    full = scene("atoms").with_values(
        {
            "interaction.kind": "full",
            "interaction.work_of_adhesion": 0.1,
            "sphere.radius": 40.0,
            "roughness": None,
            "path.values": (5.0,),
        }
    )
    found = errors_of(tradeoff(full, 0.1, steps=1), "cutoff")
    assert found["30 a0"] < 1e-9
    assert found["10 a0"] <= found["3 a0"]


@pytest.mark.parametrize("given", [{"error": 0.0}, {"steps": 0}, {"seconds": -1.0}])
def test_arguments_out_of_range_are_errors(given):
    (name,) = given
    with pytest.raises(ValueError, match=name):
        tradeoff(scene(), **given)


def test_all_choices_have_the_same_local_work_of_adhesion():
    """The default period of the field depends on the range of the wall."""
    text = """
    sphere = { radius = 20.0 }
    substrate = { spacing = 2.0, contact_modulus = 100.0, hardness = inf }
    interaction = { kind = "full", work_of_adhesion = 0.2 }
    heterogeneity = { rms = 0.5, long_wavelength = 8.0, seed = 3 }
    path = { control = "penetration", values = [0.5] }
    """
    found = tradeoff(Scene.parse(text), of="force", steps=1)
    assert errors_of(found, "cutoff")["10 a0"] < 1e-3
    assert errors_of(found, "scene")["as given"] < 1e-3
