"""What a run tells: laws that it is compared with, lines of text, pictures."""

from dataclasses import replace

import numpy as np
import pytest

from ase_roughcontact import theory
from ase_roughcontact.report import (
    draw,
    heading,
    largest_tension,
    row,
    time_left,
    write_view,
)
from ase_roughcontact.report.laws import laws_of
from ase_roughcontact.scene import NANONEWTON, Scene

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
    assert laws.smooth.name == name and laws.predicts_force
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
    "longest, work, told, name",
    [
        (16.0, 0.05, "Eq. (4) with adhesion", "Hertz"),
        (256.0, 0.2, "rough flats stick", "Hertz"),
        (16.0, 0.5, "adhesion flattens the roughness", "Maugis-Dugdale"),
    ],
)
def test_a_rough_sticky_sphere_is_compared_with_what_theory_has_for_it(
    longest, work, told, name
):
    scene = adhesive(ROUGH.replace("16.0", str(longest)), work)
    laws = laws_of(scene)
    assert laws.told.startswith(told) and laws.smooth.name == name
    assert laws.predicts_force == (name != "Hertz")
    assert (scene.inverse_kappa > 0.0) == (told == "Eq. (4) with adhesion")


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
    assert f"{least:.4g} nN; Maugis-Dugdale pulls off at" in told
    assert largest_tension(laws, records[2:3]) == ""


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


def test_loads_that_only_press_need_no_picture_of_the_force(tmp_path):
    pytest.importorskip("matplotlib")
    text = ROUGH.replace('"penetration"', '"load"')
    scene = Scene.parse(text.replace("[-4.0, 0.0, 2.0, 0.0, -4.0]", "[1.0, 20.0]"))
    records = list(scene.run(tmp_path))
    assert draw(scene, laws_of(scene), records, tmp_path) == [
        "curve.png",
        "contact.png",
    ]
