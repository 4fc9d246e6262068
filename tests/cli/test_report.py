"""What a run tells: laws that it is compared with, lines of text, pictures."""

import re
from dataclasses import replace

import numpy as np
import pytest

from ase_roughcontact import theory
from ase_roughcontact.cli.figures import draw, write_view
from ase_roughcontact.cli.report import (
    heading,
    largest_tension,
    row,
    time_left,
    touching_height,
)
from ase_roughcontact.scene import NANONEWTON, Scene
from ase_roughcontact.scene.reference import laws_of

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
    return scene, laws_of(scene), records, folder


# Laws


@pytest.mark.parametrize(
    "radius, work, kind, name",
    [
        (60.0, 0.5, "adhesive", "Maugis-Dugdale"),
        (1e6, 5.0, "full", "JKR"),
        (5.0, 0.05, "full", "DMT"),
    ],
)
def test_a_smooth_sticky_sphere_is_compared_with_the_law_of_its_maugis_parameter(
    radius, work, kind, name
):
    text = SMOOTH.replace("radius = 60.0", f"radius = {radius}")
    laws = laws_of(adhesive(text, work, kind))
    assert laws.smooth.name == name and laws.rough_from is None
    limits = ["JKR", "DMT"] if name == "Maugis-Dugdale" else []
    assert [law.name for law in laws.limits] == limits


def test_without_adhesion_the_law_is_hertz():
    scene = Scene.parse(SMOOTH)
    laws, force = laws_of(scene), np.array([-1.0, 0.0, 2.0])
    assert (laws.smooth.name, laws.smooth.pull_off_force) == ("Hertz", 0.0)
    np.testing.assert_array_equal(laws.smooth.area(force)[1:], scene.hertz_area([0, 2]))
    assert np.isnan(laws.smooth.area(force)[0])


def test_areas_and_curves_of_a_law_belong_together_and_pull_off_is_the_least_force():
    scene = adhesive(SMOOTH, 0.5)
    laws = laws_of(scene)
    for law in (laws.smooth, *laws.limits):
        depth, force = law.curve(40.0)
        assert force.min() == pytest.approx(law.pull_off_force, rel=1e-4)
        stable = slice(int(force.argmin()) + 1, None)
        assert (np.diff(depth[stable]) > 0).all() and (np.diff(force[stable]) > 0).all()
        last = np.sqrt(law.area(force[-1:]) / np.pi)
        assert last == pytest.approx([40.0], rel=0.02)
        assert np.isnan(law.area(1.01 * law.pull_off_force))


def test_hertz_s_curve_is_its_force():
    scene = Scene.parse(SMOOTH)
    depth, force = laws_of(scene).smooth.curve(10.0)
    expected = theory.hertz_force(depth, scene.radius, scene.contact_modulus)
    np.testing.assert_array_equal(force, expected)
    assert depth[-1] == pytest.approx(100.0 / scene.radius)


@pytest.mark.parametrize(
    "longest, work, told, left",
    [
        (16.0, 0.05, "Eq. (4) with adhesion", 0.05),
        (256.0, 0.2, "no closed form, as rough flats stick", 0.2),
        (40.0, 0.5, "no closed form, as the contact without load", 0.5),
        (8.0, 0.5, "adhesion of w = 0.5 J/m² flattens the roughness", 0.442),
    ],
)
def test_a_rough_sticky_sphere_is_compared_with_what_theory_has_for_it(
    longest, work, told, left
):
    scene = adhesive(ROUGH.replace("16.0", str(longest)), work)
    laws = laws_of(scene)
    assert laws.told.startswith(told) and laws.smooth.pull_off_force < 0.0
    assert laws.smooth.sphere == f"smooth sphere, w = {left:.3g} J/m²"
    assert laws.smooth.sphere in laws.told
    assert (laws.rough_from is not None) == (told == "Eq. (4) with adhesion")
    assert (scene.inverse_kappa > 0.0) == (told == "Eq. (4) with adhesion")


def test_adhesion_flattens_only_what_is_not_wider_than_the_contact():
    for longest in (8.0, 40.0):
        scene = adhesive(ROUGH.replace("16.0", str(longest)), 0.5)
        law = laws_of(adhesive(SMOOTH, 0.5)).smooth
        radius = np.sqrt(law.area(np.array(0.0)) / np.pi)
        wide = radius >= 0.5 * longest * scene.spacing
        assert ("flattens" in laws_of(scene).told) == wide == (longest == 8.0)


def test_equation_4_with_adhesion_is_not_told_below_its_range():
    scene = adhesive(ROUGH, 0.05)
    laws = laws_of(scene)
    area = laws.rough_area(scene, laws.rough_from * np.array([-1.0, 0.99, 1.0, 9.0]))
    assert list(np.isnan(area)) == [True, True, False, False]
    assert area[3] == scene.predicted_area(9.0 * laws.rough_from)
    assert "too low below about" in laws.told


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
    told = row(scene, laws_of(scene), lost, 2)
    assert told.endswith("PULLED OFF: no contact holds -60 nN")
    stalled = replace(lost, repulsive_atoms=1)
    told = row(scene, laws_of(scene), stalled, 2)
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
    assert draw(scene, laws_of(scene), records, tmp_path) == [
        "curve.png",
        "contact.png",
    ]


def test_a_path_of_heights_tells_where_the_sphere_touches(sticky):
    scene, _, records, _ = sticky
    assert touching_height(scene, records) == ""
    scene = replace(scene, path=replace(scene.path, control="height"))
    touched = next(r.height for r in records if r.penetration == 0.0)
    assert touching_height(scene, records).endswith(f"at a height of {touched:.4g} Å.")
