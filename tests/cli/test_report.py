"""Printed output and figures of a run."""

import math
import re
from dataclasses import replace

import pytest
from small_scene import ROUGH, SMOOTH, adhesive

from ase_roughcontact import nN, plot
from ase_roughcontact._util.printing import entries, plain
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.cli import main
from ase_roughcontact.cli.figures import draw, write_view
from ase_roughcontact.cli.report import (
    StepTable,
    exceeded_limits,
    files_table,
    inputs,
    results,
    summary,
    table_columns,
)
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.reference import reference_for
from ase_roughcontact.theory import asperity_radius


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Approach and retraction of a smooth adhesive sphere: theory, steps, folder."""
    scene = adhesive(SMOOTH, 0.5)
    folder = tmp_path_factory.mktemp("adhesive")
    steps = list(scene.run(folder))
    write_view(scene, steps, folder)
    return reference_for(scene), steps, folder


# Text


def row_of(reference, step, **options):
    """Words of the row of a step, and the notes below it."""
    text = plain(*StepTable(reference).parts(step, **options)).splitlines()
    place = next(i for i, line in enumerate(text) if line.split()[0][0].isdigit())
    return text[place].split(), " ".join(" ".join(text[place + 1 :]).split())


def test_an_adhesive_scene_is_described_with_theory_and_pull_off_force(run):
    described = inputs(run[0])
    assert "Maugis-Dugdale" in described["theory"] and "A/A_MD" in described
    assert described["pull-off force"].endswith("nN (Maugis-Dugdale: theory, smooth "
                                                "sphere, w = 0.5 J/m²)")  # fmt: skip
    heads = [column.head for column in table_columns(run[0])]
    assert heads[:3] == ["depth (Å)", "load (nN)", "area (nm²)"]
    assert "theory" not in heads and "theory" not in inputs(
        reference_for(Scene.parse(SMOOTH))
    )


def test_numbers_that_a_scene_asks_for_are_in_its_table_before_the_time():
    asked = '[output]\ncolumns = ["conductance", "message", "penetration"]\n'
    reference = reference_for(Scene.parse(SMOOTH + asked))
    (step,) = reference.scene.relax([20.0])
    columns = table_columns(reference)
    heads = [column.head.partition(" (")[0] for column in columns]
    assert heads[-3:] == ["p max", "conductance", "time"]
    assert heads.count("depth") == 1
    assert float(columns[-2].text_of(step)) == pytest.approx(step.conductance, rel=1e-3)


@pytest.mark.parametrize(
    "kind, without_rim",
    [("adhesive", True), ("full", True), ("dugdale", False), ("repulsive", False)],
)
def test_the_area_of_a_soft_adhesive_wall_is_said_to_lack_the_rim(kind, without_rim):
    scene = Scene.parse(SMOOTH + f'[interaction]\nkind = "{kind}"\n')
    if scene.interaction.kind != "repulsive":
        scene = adhesive(SMOOTH, 0.5, kind)
    described = inputs(reference_for(scene))
    (area,) = (text for name, text in described.items() if name.startswith("A/"))
    assert ("rim under tension" in area) == without_rim
    assert ("soft wall enlarges it" in area) == (kind == "repulsive")
    label, *numbers = described["wall"].split(", ")
    assert label == scene.wall.label
    if scene.wall.attractive:
        nm = scene.wall.attraction_range / UNITS["nm"]
        assert numbers == [
            "0.5 J/m²",
            f"range of the attraction {nm:.3g} nm",
            "which follows from the spacing: attraction_range sets it",
        ]
        given = scene.with_values({"interaction.attraction_range": f"{nm} nm"})
        assert "spacing" not in inputs(reference_for(given))["wall"]


def test_rows_have_the_area_relative_to_theory_and_the_time(run):
    reference, steps, _ = run
    assert row_of(reference, steps[0])[0][4:] == ["-", "0", f"{steps[0].seconds:.2f}"]
    assert float(row_of(reference, steps[2])[0][4]) == pytest.approx(1.0, abs=0.2)
    assert row_of(reference, steps[2], restored=True)[0][-1] == "restored"


def test_at_light_loads_theory_is_for_the_first_asperity():
    for kind, factor in (("hard", 1.0), ("repulsive", 3.0)):
        text = ROUGH.replace("radius = 60.0", "radius = 3000.0")
        scene = Scene.parse(f'{text}[interaction]\nkind = "{kind}"\n')
        reference = reference_for(scene)
        rho = factor * asperity_radius(scene.rough)
        plateau = (rho / scene.radius) ** (2 / 3)
        light, heavy = reference.relative_area([1e-3 * nN, 1e6 * nN])
        assert light == pytest.approx(plateau)
        assert heavy == pytest.approx(1.0, rel=0.02)
        assert f"A/A_Hertz = {plateau:.3g}" in inputs(reference)["theory"]


def test_the_largest_tension_is_compared_with_the_pull_off_force(run):
    reference, steps, _ = run
    tension = -min(step.normal_force for step in steps) / nN
    text = results(reference, steps)["largest tension"]
    assert text.startswith(f"{tension:.4g} nN; pull-off force: ")
    assert "largest tension" not in results(reference, steps[2:3])
    lost = replace(steps[1], normal_force=-100.0, converged=False)
    assert results(reference, [*steps, lost])["largest tension"] == text


def test_counted_areas_are_printed_beside_the_area_of_the_continuum(run):
    reference, steps, _ = run
    areas = {"contact_area": 442.0, "continuum_area": 384.0}
    last = replace(steps[2], step=2, continuum_area_error=8.0, **areas)
    text = results(reference, [*steps[:2], last])["counted areas"]
    assert re.findall(r"[\d.]+", text) == ["4.420", "2", "3.840", "0.080"]
    continuum = reference.scene.with_values({"substrate.model": "continuum"})
    asked = replace(reference, scene=continuum)
    assert "counted areas" not in results(asked, [last])


def test_an_area_of_the_continuum_with_an_unknown_error_says_so(run):
    reference, steps, _ = run
    last = replace(steps[2], continuum_area=384.0, continuum_area_error=math.nan)
    text = results(reference, [*steps[:2], last])["counted areas"]
    assert "±" not in text
    assert "3.840 nm², error not known" in text


@pytest.mark.parametrize(
    "model, errors, text",
    [
        ("atoms", [0.17], "17 %, "),
        ("atoms", [0.17, 0.05], "5 to 17 %, "),
        ("continuum", [0.17], "8.5 %, "),  # of twice the area
        ("atoms", [0.002], "0.2 %, "),
        ("atoms", [0.0005], ""),
    ],
)
def test_errors_of_areas_are_a_range_of_the_area_asked_for(run, model, errors, text):
    reference, steps, _ = run
    asked = reference.scene.with_values({"substrate.model": model})
    areas = {"contact_area": 1.0, "continuum_area": 2.0}
    shown = [replace(steps[2], area_error=error, **areas) for error in errors]
    found = results(replace(reference, scene=asked), shown).get("errors of areas", "")
    assert found.startswith(text) and bool(found) == bool(text)


def test_errors_that_are_not_known_are_named_with_their_reasons(run):
    reference, steps, _ = run
    known = replace(steps[2], area_error=0.1, contact_area=1.0)
    unknown = replace(steps[2], height_error=math.nan, unknown_errors="at a jump")
    older = replace(steps[2], area_error=math.nan)  # of a file without the reason
    found = results(reference, [known, unknown, unknown, older])
    assert " 10 %" in found["errors of areas"]
    first, second = found["errors not known"].split("; ")
    assert first == "in 2 of 4 steps: at a jump"
    assert second.startswith("in 1 of 4 steps: ")
    text = plain(*StepTable(reference, verbose=True).parts(unknown))
    assert " ".join(text.split()).endswith("height - Å; -: not known, at a jump")


def test_errors_of_steps_are_printed_with_verbose(run):
    reference, steps, _ = run
    values = {"normal_force": -2.0, "contact_area": 10.0, "height_error": 0.03}
    step = replace(steps[2], force_error=0.1, area_error=3.0, **values)
    text = plain(*StepTable(reference, verbose=True).parts(step))
    shown = " ".join(text.split())
    assert shown.endswith("area 0.30, load 0.050, height 0.030 Å")


def test_limits_that_all_steps_exceed_are_only_below_the_table(run):
    reference, steps, _ = run
    small = [replace(step, validity="R/a0 = 0.5 < 1") for step in steps[:3]]
    steep = replace(steps[3], validity="R/a0 = 0.5 < 1; slope = 0.6 > 0.5")
    words, note = row_of(reference, small[0])
    assert words[-1] != "*" and not note
    assert row_of(reference, steep)[1] == "* LIMITS: slope"
    limits = exceeded_limits([*small, steep])
    assert limits["R/a0 < 1"].startswith("in 4 of 4 steps: ")
    assert limits["slope > 0.5"].startswith("in 1 of 4 steps: ")


def test_a_pulled_off_indenter_is_marked_with_the_requested_load(run):
    text = SMOOTH.replace('"penetration"', '"load"')
    scene = adhesive(text.replace("[-4.0, 0.0, 2.0, 0.0, -4.0]", "[1.0, -60.0]"), 0.5)
    lost = replace(run[1][0], step=1, converged=False, message="stalled at a force")
    reference = reference_for(scene)
    assert row_of(reference, lost)[1] == "PULLED OFF: no contact at -60 nN"
    _, note = row_of(reference, replace(lost, repulsive_atoms=1))
    assert note == "NOT CONVERGED: stalled at a force"


@pytest.mark.parametrize("size", [1.0, 1e7, 1e300])
def test_the_output_of_a_run_fits_80_columns_whatever_the_size_of_the_numbers(
    run, size
):
    reference, steps, _ = run
    values = {"penetration": -1.5 * size, "normal_force": -size}
    large = replace(steps[2], contact_area=size, seconds=1e5, **values)
    words = plain(*StepTable(reference).parts(large)).splitlines()[-1].split()
    assert len(words) == 1 + len(table_columns(reference))
    parts = [entries(inputs(reference).items())]
    for step in [*steps, large]:
        parts += StepTable(reference, verbose=True).parts(step)
    parts += [*summary(reference, steps), files_table(["curve.png"], steps)]
    assert max(map(len, plain(*parts).splitlines())) <= 80


# Figures


def test_a_run_with_its_only_frame_out_of_contact_says_that_it_has_no_maps(
    tmp_path, capsys
):
    file, out = tmp_path / "scene.toml", tmp_path / "results"
    file.write_text(SMOOTH + '[output]\nkeep = "last"\n')
    reason = 'as no step with a frame is in contact: run with keep = "all"'
    assert main(["run", str(file), "--out", str(out)]) == 0
    assert f"no contact.png, {reason}" in " ".join(capsys.readouterr().out.split())
    assert main(["report", str(out)]) == 0
    assert "No contact.png, as no step" in (out / "report.html").read_text("utf-8")
    assert not (out / "contact.png").exists()


def test_a_path_with_tension_has_a_figure_of_the_force(run):
    reference, steps, folder = run
    names = ["curve.png", "force.png", "contact.png"]
    assert draw(reference, steps, folder) == names
    tensile = [step for step in steps if step.normal_force <= 0.0]
    assert draw(reference, tensile, folder) == names[1:]
    assert draw(reference, steps[:1], folder) == []


def test_curves_of_theory_reach_beyond_the_deepest_step(tmp_path, monkeypatch):
    curves = []
    monkeypatch.setattr(
        plot, "plot_force", lambda axes, x, y, theory, *_: curves.append((x, theory))
    )
    text = SMOOTH.replace("[-4.0, 0.0, 2.0, 0.0, -4.0]", "[-2.0, 3.0]")
    scene = adhesive(text.replace("100.0", "1.0").replace("60.0", "300.0"), 0.05)
    # of the soft solid only a part of the contact is under pressure
    draw(reference_for(scene), list(scene.run(tmp_path, "ignore")), tmp_path)
    ((depths, theory),) = curves
    assert depths == pytest.approx([-2.0, 3.0])
    assert all(depth.max() > 3.0 for depth, _ in theory.values())


def test_forces_below_the_tolerance_are_not_drawn_on_a_logarithmic_axis(
    run, monkeypatch
):
    reference, steps, folder = run
    drawn = []
    monkeypatch.setattr(
        plot, "plot_curve", lambda axes, load, *_: drawn.append(list(load))
    )
    rounding = replace(steps[1], normal_force=1e-9, tolerance=2e-9)
    draw(reference, [steps[2], rounding], folder)
    assert drawn == [[steps[2].normal_force / nN]]
