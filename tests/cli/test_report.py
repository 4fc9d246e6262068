"""Printed output and pictures of a run."""

import re
from dataclasses import replace

import pytest

from ase_roughcontact.cli.figures import draw, write_view
from ase_roughcontact.cli.report import (
    heading,
    largest_tension,
    row,
    time_left,
    touching_height,
)
from ase_roughcontact.scene import NANONEWTON, Scene
from ase_roughcontact.scene.reference import reference_for

SMOOTH = """
[substrate]
contact_modulus = 100.0
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
def sticky(tmp_path_factory):
    """A smooth sticky sphere that comes and goes: scene, laws, records, folder."""
    scene = adhesive(SMOOTH, 0.5)
    folder = tmp_path_factory.mktemp("sticky")
    records = list(scene.run(folder))
    write_view(scene, folder)
    return scene, reference_for(scene), records, folder


# Text


def test_the_table_of_a_sticky_scene_tells_law_pull_off_and_tension(sticky):
    scene, laws, records, _ = sticky
    head = heading(scene, laws)
    assert "Maugis-Dugdale" in head and "Pull-off force: -" in head
    assert "A/A_MD" in head and "depth (Å)" in head and "Eq. (4)" not in head
    rows = [row(scene, laws, record, 5) for record in records]
    assert rows[0].split()[-2:] == ["-", f"{records[0].seconds:.2f}"]
    ratio = float(rows[2].split()[-2])
    assert ratio == pytest.approx(1.0, abs=0.2)
    told = largest_tension(laws, records)
    least = min(record.normal_force for record in records) / NANONEWTON
    assert f"{least:.4g} nN; pull-off force: -" in told
    assert "theory, smooth sphere, w = 0.5 J/m²" in told
    assert largest_tension(laws, records[2:3]) == ""


def test_a_step_that_is_not_converged_is_no_tension_of_the_path(sticky):
    _, laws, records, _ = sticky
    lost = replace(records[1], normal_force=-100.0, converged=False)
    assert largest_tension(laws, [*records, lost]) == largest_tension(laws, records)


def test_an_indenter_that_was_pulled_off_tells_the_load_that_was_asked_for(sticky):
    text = SMOOTH.replace('"penetration"', '"load"')
    scene = adhesive(text.replace("[-4.0, 0.0, 2.0, 0.0, -4.0]", "[1.0, -60.0]"), 0.5)
    lost = replace(sticky[2][0], step=1, converged=False, message="stalled at a force")
    told = row(scene, reference_for(scene), lost, 2)
    assert told.endswith("PULLED OFF: no contact holds -60 nN")
    stalled = replace(lost, repulsive_atoms=1)
    told = row(scene, reference_for(scene), stalled, 2)
    assert told.endswith("NOT CONVERGED: stalled at a force (forces in eV/Å)")


def test_all_lines_of_theory_tell_that_they_are_and_of_what(sticky):
    scene, laws, _, _ = sticky
    about = [line for line in heading(scene, laws).splitlines() if "w = " in line]
    assert len(about) == 3
    assert all(re.search("[Tt]heory.*smooth sphere, w = 0.5 J/m²", a) for a in about)


def test_time_left_is_that_of_the_steps_before_by_their_costs(sticky):
    records = [replace(record, seconds=2.0) for record in sticky[2]]
    costs = [0.0, 1.0, 2.0, 3.0, 7.0, 8.0]
    assert time_left(costs, records[:1], kept=0) is None
    assert time_left(costs, records[:2], kept=0) == 2.0 * 6.0
    assert time_left(costs, records[:3], kept=1) == 4.0 / 2.0 * 5.0
    assert time_left(costs, records[:3], kept=2) is None
    assert time_left(costs, records, kept=0) == 0.0


def test_a_row_tells_time_left_once_it_is_a_second(sticky):
    scene, laws, records, _ = sticky
    assert row(scene, laws, records[0], 5, 80.2).endswith("about 0:01:20 left")
    assert "left" not in row(scene, laws, records[0], 5, 0.2)


# Pictures


def test_a_path_with_tension_has_a_picture_of_its_force(sticky):
    pytest.importorskip("matplotlib")
    scene, laws, records, folder = sticky
    assert draw(scene, laws, records, folder) == [
        "curve.png",
        "force.png",
        "contact.png",
    ]
    pulled = [record for record in records if record.normal_force <= 0.0]
    assert draw(scene, laws, pulled, folder) == ["force.png", "contact.png"]
    assert draw(scene, laws, records[:1], folder) == []


def test_a_force_that_is_only_rounding_is_not_drawn_on_a_logarithmic_axis(
    sticky, monkeypatch
):
    plot = pytest.importorskip("ase_roughcontact.plot")
    scene, laws, records, folder = sticky
    drawn = []
    monkeypatch.setattr(
        plot, "plot_curve", lambda axes, load, *_: drawn.append(list(load))
    )
    rounding = replace(records[2], normal_force=1e-9, tolerance=2e-9)
    draw(scene, laws, [records[2], rounding], folder)
    assert drawn == [[records[2].normal_force / NANONEWTON]]


def test_maps_tell_where_on_the_path_they_are_and_share_a_range(sticky, monkeypatch):
    plot = pytest.importorskip("ase_roughcontact.plot")
    scene, laws, records, folder = sticky
    panels, show = [], plot.plot_contact

    def shown(panel, *given, **options):
        panels.append(panel)
        return show(panel, *given, **options)

    monkeypatch.setattr(plot, "plot_contact", shown)
    draw(scene, laws, records, folder)
    titles = [panel.get_title() for panel in panels]
    assert titles[1].startswith("penetration 2 Å, ")
    ways = [title.splitlines()[1] for title in titles]
    assert ways == ["approach", "approach", "retraction"]
    assert len({panel.get_xlim() for panel in panels}) == 1


def test_loads_that_only_press_need_no_picture_of_the_force(tmp_path):
    pytest.importorskip("matplotlib")
    text = ROUGH.replace('"penetration"', '"load"')
    scene = Scene.parse(text.replace("[-4.0, 0.0, 2.0, 0.0, -4.0]", "[1.0, 20.0]"))
    records = list(scene.run(tmp_path))
    assert draw(scene, reference_for(scene), records, tmp_path) == [
        "curve.png",
        "contact.png",
    ]


def test_a_path_of_heights_tells_where_the_sphere_touches(sticky):
    scene, _, records, _ = sticky
    assert touching_height(scene, records) == ""
    scene = replace(scene, path=replace(scene.path, control="height"))
    touched = next(r.height for r in records if r.penetration == 0.0)
    assert touching_height(scene, records).endswith(f"at a height of {touched:.4g} Å.")
