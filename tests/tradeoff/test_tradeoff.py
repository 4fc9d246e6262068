"""Error budget of a scene, and the cheapest plan for a wanted error."""

import json
import re
from dataclasses import replace
from functools import cache
from itertools import chain, combinations

import numpy as np
import pytest
from matplotlib.figure import Figure

from ase_roughcontact.cli import main
from ase_roughcontact.plot import plot_tradeoff
from ase_roughcontact.plot.files import check_picture
from ase_roughcontact.scene import Loop, Scene, relax_loop
from ase_roughcontact.tradeoff.figures import draw_tradeoff
from ase_roughcontact.tradeoff.result import Choice, Tradeoff
from ase_roughcontact.tradeoff.tradeoff import tradeoff

TEXT = """
[substrate]
spacing = 2.0
contact_modulus = 100.0
hardness = inf
model = "{model}"
[sphere]
unit = "a0"
radius = 100.0
[roughness]
unit = "a0"
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
    for choice in (each for each in study().choices if each.source == "grid"):
        steps, error = scene().with_values(choice.settings).relax(), choice.error
        areas = np.array([step.continuum_area for step in steps])
        true = abs(areas / exact - 1.0).max()
        assert error == pytest.approx(true, abs=0.015)
    assert errors_of(study(), "grid")["high"] < 0.01


def test_estimates_that_are_not_known_are_named(monkeypatch):
    relax = Scene.relax

    def without_errors(self, *arguments, **options):
        for step in relax(self, *arguments, **options):
            yield replace(step, area_error=np.nan)

    monkeypatch.setattr(Scene, "relax", without_errors)
    found = tradeoff(scene("atoms"), 0.05, steps=1)
    (text,) = (text for text in found.left_out if "estimated error" in text)
    assert "finest grid in 1 of 1 steps" in text


def areas_of(**values):
    steps = scene().with_values(values).relax(validity="ignore")
    return np.array([[step.continuum_area, step.area_error] for step in steps]).T


def test_errors_below_the_estimate_of_the_finest_grid_are_bounds():
    (high, _), (finest, estimate) = (
        areas_of(**{"solver.accuracy": accuracy}) for accuracy in ("high", 0.001)
    )
    difference, bound = abs(high / finest - 1.0).max(), (estimate / finest).max()
    found = {c.label: c for c in study().choices if c.source == "grid"}
    assert found["high"].error == pytest.approx(max(difference, bound))
    assert found["high"].is_bound == (difference < bound)
    assert not found["fast"].is_bound


def test_without_memory_for_a_finer_grid_high_has_its_own_estimate(monkeypatch):
    large = {"roughness.domain": 256.0, "path.values": (30.0,)}
    steps = scene().with_values({"solver.accuracy": "high"} | large).relax()
    (estimate,) = (step.area_error / step.continuum_area for step in steps)
    monkeypatch.setattr("ase_roughcontact.windows.memory.available_memory", lambda: 2e8)
    found = tradeoff(scene().with_values(large), 0.5)
    (high,) = (choice for choice in found.choices if choice.label == "high")
    assert high.is_bound and high.error == pytest.approx(estimate)
    assert 'a grid finer than "high", which needs more memory' in found.left_out


def test_error_of_the_boundary_is_that_on_the_same_grid():
    found = {c.label: c for c in study().choices if c.source == "boundary"}
    assert found["free"].error == 0.0
    cell = found["cell of 2 diameters"]
    (free, _), (periodic, _) = (
        areas_of(**{"solver.accuracy": "high"}, **settings)
        for settings in ({}, cell.settings)
    )
    assert cell.error == pytest.approx(abs(periodic / free - 1.0).max())


def test_grids_of_too_many_points_are_left_out_and_named():
    given = scene().with_values({"path.values": (3.0, 100.0)})
    found = tradeoff(given, 0.5, points=2**14)
    assert found.steps == ("3 nN",)
    assert "1 of 2 listed steps" in found.left_out[0]
    fewer = tradeoff(given.with_values({"path.values": (3.0,)}), 0.5, points=2000)
    (cell,) = (text for text in fewer.left_out if "4 diameters" in text)
    assert cell == "boundary cell of 4 diameters: a grid of 1.6e+04 points"
    assert f"Left out: {cell}." in str(fewer)


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
    away = scene().with_values({"path.control": "height", "path.values": (50.0, -1.0)})
    found = tradeoff(away, 0.5)
    assert np.all(np.isfinite([choice.error for choice in found.choices]))
    with pytest.raises(ValueError, match="in contact"):
        tradeoff(away.with_values({"path.values": (50.0,)}), 0.5)


@pytest.mark.parametrize(
    "given, message",
    [
        ({"error": 0.0}, "error must"),
        ({"error": 5.0}, "below 1"),
        ({"steps": 0}, "steps must"),
        ({"points": 0}, "points must"),
        ({"of": "depth"}, "unknown answer"),
        ({"of": "force"}, "area or of the height"),
    ],
)
def test_arguments_that_make_no_sense_are_errors(given, message):
    with pytest.raises(ValueError, match=message):
        tradeoff(scene(), **given)
    for control in ("height", "penetration"):
        with pytest.raises(ValueError, match="area or of the force"):
            tradeoff(scene().with_values({"path.control": control}), of="height")


@pytest.mark.parametrize("command", [["tradeoff"], ["fit", "curve.csv", "my.toml"]])
def test_a_picture_that_can_not_be_written_is_refused_before_anything_is_read(
    command, tmp_path, capsys
):
    assert main([*command, "--picture", "a.docx"]) == 2
    assert "a picture ends in one of ." in capsys.readouterr().err
    assert main([*command, "--picture", str(tmp_path / "no" / "a.png")]) == 2
    assert "no folder" in capsys.readouterr().err
    (tmp_path / "mine.png").write_bytes(b"\x89PNG of another program")
    assert main([*command, "--picture", str(tmp_path / "mine.png")]) == 2
    assert "mine.png was not written by" in capsys.readouterr().err


def test_table_and_picture_name_the_answer(tmp_path):
    found = made(("grid", "fast", 0.1, 1.0), of="height")
    assert re.search(r"source +choice +height error", str(found))
    for name, first in (("t", b"\x89PNG"), ("t.svg", b"<?xml"), ("t.PDF", b"%PDF")):
        draw_tradeoff(found, tmp_path / name)
        assert (tmp_path / name).read_bytes().startswith(first)
        check_picture(tmp_path / name)  # the next study may replace it
    axes = Figure().subplots()
    plot_tradeoff(axes, [("grid", "fast", 0.1, 1.0)], of="height")
    assert axes.get_ylabel() == "error of the height"


def test_all_sources_are_compared():
    sources = {choice.source for choice in study().choices}
    assert sources == {"scene", "grid", "boundary", "wall", "theory", "realisations"}
    assert "model" in {choice.source for choice in study("atoms").choices}
    assert "tolerance" in {choice.source for choice in study("atoms").choices}
    assert errors_of(study(), "boundary")["cell of 2 diameters"] < 0.05
    assert errors_of(study(), "wall")["repulsive instead"] > 0.1
    single, four = (errors_of(study(), "realisations")[n] for n in ("1", "4"))
    assert four == pytest.approx(single / 2.0)
    first = scene().roughness.seed
    areas = [
        areas_of(**{"solver.accuracy": "fast", "roughness.seed": seed})[0]
        for seed in range(first, first + 4)
    ]
    spread = np.std(areas, axis=0, ddof=1) / np.mean(areas, axis=0)
    assert single == pytest.approx(spread.max())


def test_counted_atoms_have_the_error_of_their_area_against_the_continuum():
    (row,) = (each for each in study("atoms").choices if each.source == "model")
    counted = [step.contact_area for step in scene("atoms").relax()]
    high = scene().with_values({"solver.accuracy": "high"}).relax()
    continuum = [step.continuum_area for step in high]
    error = abs(np.divide(counted, continuum) - 1.0).max()
    assert row.error == pytest.approx(error, abs=2e-3) and error > 0.05
    assert "counted atoms where the continuum is meant" in str(study("atoms"))
    assert "model" not in {each.source for each in study().choices}


def test_errors_between_the_levels_have_grids_between_theirs():
    cost = {c.label: c.cost for c in study().choices if c.source == "grid"}
    assert cost["fast"] < cost["3 %"] < cost["2 %"] < cost["normal"]
    assert cost["normal"] < cost["0.5 %"] < cost["high"]


def test_the_largest_error_is_named_with_the_next_command():
    grid = Choice("grid", "fast", 0.01, 1.0, settings={"solver.accuracy": "fast"})
    scatter = "realisations", "1", 0.4, 1.0
    text = " ".join(str(made(scatter, plan=(grid,), wanted=0.02)).split())
    assert "scatter of single realisations: 0.4, 40 times the plan's" in text
    assert "ase-roughcontact ensemble SCENE --error 0.02" in text
    small = str(made(("realisations", "1", 0.01, 1.0), plan=(grid,), wanted=0.02))
    assert "ase-roughcontact run SCENE" in small and "largest error" not in small


LOOP = {
    "roughness": None,
    "sphere.radius": 20.0,
    "interaction.kind": "dugdale",
    "interaction.work_of_adhesion": 0.3,
    "interaction.attraction_range": "0.4 nm",
    "path": Loop(deepest=0.5, tolerance=0.05),
}


@pytest.mark.slow
def test_the_pull_off_force_of_a_loop_is_traded():
    loop = scene("atoms").with_values(LOOP)
    found = tradeoff(loop, 0.1, of="force")
    steps = errors_of(found, "steps")
    coarse, accurate = (
        relax_loop(
            loop.with_values({"path.tolerance": each, "solver.accuracy": 1e-8}),
            validity="ignore",
        )
        for each in (1e-2, 1e-4)
    )
    error = abs(coarse.pull_off_force / accurate.pull_off_force - 1.0)
    assert steps["0.01"] == pytest.approx(error, abs=1e-3)
    assert found.kept and "tolerance = 0.01" in found.toml


def test_of_a_loop_only_the_force_is_traded():
    with pytest.raises(ValueError, match="pull-off force"):
        tradeoff(scene("atoms").with_values(LOOP), of="area")


def test_optimizers_of_ase_are_traded_with_the_solver():
    values = {"solver.optimizer": "LBFGS", "path.values": (10.0,)}
    soft = scene("atoms").with_values(values | {"interaction.kind": "repulsive"})
    found = tradeoff(soft, 0.05, of="height")
    errors = errors_of(found, "optimizer")
    assert errors["built-in solver"] == 0.0
    fmax = float(f"{1e-3 * soft.contact_modulus * soft.spacing**2:.2g}")
    loose = soft.with_values({"solver.fmax": fmax})
    tight = soft.with_values({"solver.optimizer": None, "solver.accuracy": 1e-8})
    (loose,), (tight,) = loose.relax(validity="ignore"), tight.relax()
    error = abs(loose.height - tight.height) / tight.penetration
    assert errors[f"LBFGS, fmax = {fmax:g} eV/Å"] == pytest.approx(error, rel=0.05)
    assert "# without optimizer" in found.toml


def test_plan_is_the_fastest_that_suffices_and_is_kept_on_another_surface():
    found = study()
    assert [choice.source for choice in found.plan] == ["grid", "boundary"]
    assert sum(choice.error for choice in found.plan) < 0.05
    assert found.kept and 0.0 < found.checked < 0.05
    assert "accuracy" in found.toml and "kept." in str(found)
    planned = Scene.parse(TEXT.format(model="continuum") + "[solver]\n")
    assert planned.with_values(found.plan[0].settings).check() is None


def test_plan_is_checked_against_a_finer_grid_on_another_surface():
    other = {"roughness.seed": scene().roughness.seed + 4}
    settings = dict(chain.from_iterable(c.settings.items() for c in study().plan))
    planned, _ = areas_of(**settings, **other)
    finest, estimate = areas_of(**{"solver.accuracy": 0.001}, **other)
    error = max(abs(planned / finest - 1.0).max(), (estimate / finest).max())
    assert study().checked == pytest.approx(error)


def made(*choices, wanted=0.1, **options):
    made = [Choice(*each) for each in choices]
    return Tradeoff(wanted, ("1 nN",), tuple(made), **options)


def test_text_names_front_plan_and_what_is_missing():
    found = made(
        ("grid", "fast", 0.1, 1.0),
        ("grid", "high", 0.08, 9.0, 0.0, 0.0, {}, True),
        ("grid", "slow", 0.08, 9.5),
        ("boundary", "free", 0.0, 9.0),
        ("boundary", "small cell", 0.5, 10.0),
        ("wall", "hard", 0.0, 1.0),
        ("theory", "Hertz", 0.3, 0.0),
    )
    assert [choice.label for choice in found.front] == ["fast", "high", "free"]
    text = str(found)
    assert sum(line.endswith("  *") for line in text.splitlines()) == 3
    text = " ".join(text.split())
    assert not found.kept and "No plan has an error of 0.1" in text
    assert "may be 0.07 in all" in text
    assert "The smallest are grid high: < 8.0e-02 and boundary free: 0.0e+00." in text
    grid = Choice("grid", "fast", 0.06, 1.0, settings={"solver.accuracy": "fast"})
    planned = made(("realisations", "1", 0.4, 1.0), plan=(grid,), checked=0.06)
    assert planned.realisations == 25  # 0.4/5 beside 0.06
    assert 'accuracy = "fast"' in str(planned)
    assert "mean over surfaces: 25 realisations" in str(planned)
    worse = replace(planned, checked=0.2)
    assert "at most 2.00e-01: NOT KEPT" in str(worse)


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
    found = errors_of(tradeoff(full, 0.1, steps=1, of="height"), "cutoff")
    assert 0.0 < found["20 a0"] < found["10 a0"] < found["3 a0"]


def test_all_choices_have_the_same_local_work_of_adhesion():
    """The default period of the field depends on the range of the wall."""
    text = """
    sphere = { unit = "a0", radius = 20.0 }
    interaction = { kind = "full", work_of_adhesion = 0.2 }
    heterogeneity = { unit = "a0", rms = 0.5, long_wavelength = 8.0, seed = 3 }
    path = { control = "penetration", values = [0.5] }
    [substrate]
    model = "atoms"
    spacing = 2.0
    contact_modulus = 100.0
    hardness = inf
    """
    found = tradeoff(Scene.parse(text), of="force", steps=1)
    assert errors_of(found, "cutoff")["10 a0"] < 1e-3
    assert errors_of(found, "scene")["as given"] < 1e-3


CROWDED = [
    ("scene", "as given", 1e-2, 1.0),
    ("grid", "normal", 1e-2, 1.0),
    ("grid", "fast", 1.1e-2, 0.9),
    ("boundary", "free", 0.0, 1.0),
    ("tolerance", "0.0001", 0.0, 1.01),
    ("tolerance", "0.1", 1e-11, 0.99),
    ("theory", "Eq. (4)", 0.2, 0.0),
]


def test_labels_overlap_neither_each_other_nor_lines():
    axes = Figure(layout="constrained").subplots()
    plot_tradeoff(axes, CROWDED, {1, 2}, wanted=0.01)
    axes.get_figure().draw_without_rendering()
    boxes = {text.get_text(): text.get_window_extent() for text in axes.texts}
    assert "as given, normal" in boxes and len(boxes) == 6
    assert not any(
        one.overlaps(other) for one, other in combinations(boxes.values(), 2)
    )
    height = axes.transData.transform((1.0, 0.01))[1]
    assert not any(box.y0 < height < box.y1 for box in boxes.values())


def test_zeros_are_drawn_at_the_edge_and_the_axes_say_so():
    axes = Figure().subplots()
    plot_tradeoff(axes, CROWDED, wanted=0.05)
    drawn = {line.get_label(): line.get_xydata() for line in axes.lines}
    assert drawn["boundary"] == pytest.approx(np.array([[1.0, 1e-3]]))
    assert drawn["tolerance"][:, 1] == pytest.approx([1e-3, 1e-3])
    assert drawn["theory"] == pytest.approx(np.array([[0.09, 0.2]]))
    assert axes.get_ylim()[0] > 1e-4
    assert "lower edge" in axes.get_ylabel() and "left edge" in axes.get_xlabel()
    plot_tradeoff(other := Figure().subplots(), CROWDED[:3], wanted=1e-3)
    assert "edge" not in other.get_ylabel() + other.get_xlabel()
