"""Printed output and figures of a run."""

import re
from dataclasses import replace

import numpy as np
import pytest

from ase_roughcontact import plot
from ase_roughcontact.cli.figures import draw, write_view
from ase_roughcontact.cli.report import summary, table_header, table_row
from ase_roughcontact.ensemble import Progress
from ase_roughcontact.scene import NANONEWTON, Scene
from ase_roughcontact.scene.reference import reference_for

SMOOTH = """
[substrate]
contact_modulus = 100.0
hardness = inf
[sphere]
radius = 60.0
[path]
control = "penetration"
values = [-4.0, 0.0, 2.0, 0.0, -4.0]
"""
ROUGH = SMOOTH + "[roughness]\nlong_wavelength = 16.0\n"


def adhesive(text, work, kind="adhesive"):
    return Scene.parse(
        f'{text}[interaction]\nkind = "{kind}"\nwork_of_adhesion = {work}\n'
    )


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Approach and retraction of a smooth adhesive sphere: theory, steps, folder."""
    scene = adhesive(SMOOTH, 0.5)
    folder = tmp_path_factory.mktemp("adhesive")
    steps = list(scene.run(folder))
    write_view(scene, folder)
    return reference_for(scene), steps, folder


# Text


def test_the_header_of_an_adhesive_scene_has_theory_and_pull_off_force(run):
    header = table_header(run[0])
    assert "Maugis-Dugdale" in header and "Pull-off force: " in header
    assert "A/A_MD" in header and "depth (Å)" in header and "Eq. (4)" not in header


@pytest.mark.parametrize(
    "kind, without_rim",
    [("adhesive", True), ("full", True), ("dugdale", False), ("repulsive", False)],
)
def test_the_area_of_a_soft_adhesive_wall_is_said_to_lack_the_rim(kind, without_rim):
    scene = Scene.parse(SMOOTH + f'[interaction]\nkind = "{kind}"\n')
    if scene.interaction.kind != "repulsive":
        scene = adhesive(SMOOTH, 0.5, kind)
    header = table_header(reference_for(scene))
    assert ("rim under tension" in header) == without_rim


def test_the_wall_is_printed_by_its_label(run):
    for wall in ("hard", "repulsive"):
        scene = Scene.parse(f'{SMOOTH}[interaction]\nkind = "{wall}"\n')
        assert scene.wall.label in table_header(reference_for(scene)).splitlines()[0]


def test_rows_have_the_area_relative_to_theory_and_the_time(run):
    reference, steps, _ = run
    rows = [table_row(reference, step).split() for step in steps]
    assert rows[0][-2:] == ["-", f"{steps[0].seconds:.2f}"]
    assert float(rows[2][-2]) == pytest.approx(1.0, abs=0.2)


def test_the_summary_compares_the_largest_tension_with_the_pull_off_force(run):
    reference, steps, folder = run
    text = summary(reference, steps, folder, ["curve.png"])
    tension = -min(step.normal_force for step in steps) / NANONEWTON
    assert f"{tension:.4g} nN; pull-off force: " in text
    assert "theory, smooth sphere, w = 0.5 J/m²" in text
    assert "tension" not in summary(reference, steps[2:3], folder, [])


def test_errors_of_areas_are_a_range_or_one_number(run):
    reference, steps, folder = run
    large, small = (
        replace(steps[2], area_error=part * steps[2].contact_area)
        for part in (0.17, 0.05)
    )
    assert "of the areas: 17 %; nine" in summary(reference, [large], folder, [])
    text = summary(reference, [large, small], folder, [])
    assert "of the areas: 5 to 17 %; nine" in text


@pytest.mark.parametrize("part, printed", [(0.002, True), (0.0005, False)])
def test_errors_of_areas_below_a_thousandth_are_not_printed(run, part, printed):
    reference, steps, folder = run
    step = replace(steps[2], area_error=part * steps[2].contact_area)
    text = summary(reference, [step], folder, [])
    assert ("Estimated errors of the areas" in text) == printed


def test_errors_of_areas_are_those_of_the_area_that_is_asked_for(run):
    reference, steps, folder = run
    step = replace(steps[2], contact_area=1.0, continuum_area=2.0, area_error=0.3)
    assert "of the areas: 30 %; nine" in summary(reference, [step], folder, [])
    of_continuum = reference.scene.with_values({"substrate.model": "continuum"})
    text = summary(replace(reference, scene=of_continuum), [step], folder, [])
    assert "of the areas: 15 %; nine" in text


@pytest.mark.parametrize(
    "control, errors",
    [
        ("penetration", {"load error (%)": "5", "area error (%)": "30"}),
        ("load", {"height error (Å)": "0.03", "area error (%)": "30"}),
    ],
)
def test_rows_have_the_errors_that_their_headings_name(run, control, errors):
    reference, steps, _ = run
    scene = reference.scene
    scene = replace(scene, path=replace(scene.path, control=control))
    reference = replace(reference, scene=scene)
    step = replace(
        steps[2],
        normal_force=-2.0,
        force_error=0.1,
        contact_area=10.0,
        area_error=3.0,
        height_error=0.03,
        penetration_error=0.07,
    )
    heads = re.split(r" {2,}", table_header(reference).splitlines()[-1].strip())
    cells = dict(zip(heads, table_row(reference, step).split(), strict=True))
    assert errors.items() <= cells.items()


def test_limits_that_all_steps_exceed_are_only_below_the_table(run):
    reference, steps, folder = run
    small = [replace(step, validity="R/a0 = 0.5 < 1") for step in steps[:3]]
    steep = replace(steps[3], validity="R/a0 = 0.5 < 1; slope = 0.6 > 0.5")
    assert "LIMITS" not in table_row(reference, small[0])
    assert table_row(reference, steep).endswith("LIMITS: slope")
    text = summary(reference, [*small, steep], folder, [])
    assert "  R/a0 < 1 in 4 of 4 steps: " in text
    assert "  slope > 0.5 in 1 of 4 steps: " in text


def test_steps_that_are_not_converged_do_not_count_as_tension(run):
    reference, steps, folder = run
    lost = replace(steps[1], normal_force=-100.0, converged=False)
    texts = [summary(reference, s, folder, []) for s in (steps, [*steps, lost])]
    assert texts[0] == texts[1]


def test_a_pulled_off_indenter_is_marked_with_the_requested_load(run):
    text = SMOOTH.replace('"penetration"', '"load"')
    scene = adhesive(text.replace("[-4.0, 0.0, 2.0, 0.0, -4.0]", "[1.0, -60.0]"), 0.5)
    lost = replace(run[1][0], step=1, converged=False, message="stalled at a force")
    row = table_row(reference_for(scene), lost)
    assert row.endswith("PULLED OFF: no contact at -60 nN")
    row = table_row(reference_for(scene), replace(lost, repulsive_atoms=1))
    assert row.endswith("NOT CONVERGED: stalled at a force (forces in eV/Å)")


def test_lines_with_results_of_theory_name_the_system(run):
    lines = [line for line in table_header(run[0]).splitlines() if "w = " in line]
    assert len(lines) == 3
    assert all(re.search("[Tt]heory.*smooth sphere, w = 0.5 J/m²", x) for x in lines)


@pytest.mark.parametrize(
    "elapsed, left, end",
    [
        (3.0, 80.2, "about 0:01:20 left"),
        (3.0, 1e30, "about 3.2e+22 years left"),
        (3.0, 0.2, ""),
        (0.5, 24.0, ""),  # nearly all of the time was that of the start
        (0.5, np.nan, ""),
    ],
)
def test_a_row_has_the_time_left_if_it_is_a_second_and_known(run, elapsed, left, end):
    reference, steps, _ = run
    row = table_row(reference, steps[0], Progress(1, 3, elapsed, left))
    assert row.endswith(end)
    assert ("left" in row) == bool(end)


def test_the_summary_of_a_path_of_heights_has_the_height_of_first_contact(run):
    reference, steps, folder = run
    assert "touches" not in summary(reference, steps, folder, [])
    scene = reference.scene
    scene = replace(scene, path=replace(scene.path, control="height"))
    text = summary(replace(reference, scene=scene), steps, folder, [])
    height = next(step.height for step in steps if step.penetration == 0.0)
    assert f"at a height of {height:.4g} Å." in text


@pytest.mark.parametrize("size", [1.0, 1e7, 1e300])
def test_columns_are_separated_whatever_the_size_of_the_numbers(run, size):
    reference, steps, _ = run
    values = {"penetration": -1.5 * size, "normal_force": -size, "seconds": size}
    large = replace(steps[2], contact_area=size, **values)
    headings = len(re.split(r" {2,}", table_header(reference).splitlines()[-1].strip()))
    assert len(table_row(reference, large).split()) == headings


# Figures


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
    rounding = replace(steps[2], normal_force=1e-9, tolerance=2e-9)
    draw(reference, [steps[2], rounding], folder)
    assert drawn == [[steps[2].normal_force / NANONEWTON]]


def test_maps_have_titles_and_share_a_range(run, monkeypatch):
    panels, plot_contact = [], plot.plot_contact

    def collect(panel, *arguments, **options):
        panels.append(panel)
        return plot_contact(panel, *arguments, **options)

    monkeypatch.setattr(plot, "plot_contact", collect)
    draw(*run)
    titles = [panel.get_title() for panel in panels]
    assert titles[1].startswith("(b) penetration 2 Å, ")
    directions = [title.splitlines()[1] for title in titles]
    assert directions == ["approach", "approach", "retraction"]
    assert len({panel.get_xlim() for panel in panels}) == 1


def test_compressive_loads_have_no_figure_of_the_force(tmp_path):
    text = ROUGH.replace('"penetration"', '"load"')
    scene = Scene.parse(text.replace("[-4.0, 0.0, 2.0, 0.0, -4.0]", "[1.0, 20.0]"))
    steps = list(scene.run(tmp_path))
    names = ["curve.png", "contact.png"]
    assert draw(reference_for(scene), steps, tmp_path) == names
