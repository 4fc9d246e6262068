"""Scenes with the scan of a whole tip, and doubtful scans."""

import re

import numpy as np
import pytest

from ase_roughcontact import HeightMap, RoughSphere, SelfAffine
from ase_roughcontact.ensemble.columns import scene_columns
from ase_roughcontact.results.scan_errors import COPIES_LEFT_OUT
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.reference import reference_for

X, Y = np.meshgrid(np.arange(-30.0, 34.0), np.arange(-33.0, 31.0), indexing="ij")
TIP = -(4.0 * X**2 + 4.0 * Y**2) / 200.0  # Å, radius 100 Å at a spacing of 2 Å
TEXT = """
substrate = { spacing = 2.0, contact_modulus = 100.0, hardness = inf }
sphere = { radius = inf }
path = { control = "load", values = [2.0, 40.0] }
[topography]
file = "scan.npy"
role = "indenter"
unit = "Å"
spacing = 2.0
detrend = "none"
center = "highest"
"""


@pytest.fixture
def read(tmp_path):
    def scene(heights=TIP, lines=()):
        np.save(tmp_path / "scan.npy", heights)
        text = TEXT
        for old, new in dict(lines).items():
            assert old in text
            text = text.replace(old, new)
        found = Scene.parse(text, str(tmp_path / "scene.toml"))
        found.check()
        return found

    return scene


def steps(scene):
    return [(s.normal_force, s.penetration, s.contact_area) for s in scene.relax()]


def test_the_summary_of_an_array_says_which_index_and_which_radius_is_meant(read):
    line = read().topography.summary
    assert "64 x 64 points (first index along x), 0 (0 %) missing" in line
    assert line.endswith(", curvature of the scan itself: radius 10 nm ± 0.0 %")


ROUGH = SelfAffine(0.05, 0.8, 8.0, 32.0, seed=1).heights((64, 64), 2.0)
LOADS = 'control = "load", values = [2.0, 40.0]'
DEPTHS = {LOADS: 'control = "penetration", values = [0.5, 1.5]'}
ADHESIVE = 'interaction = { kind = "adhesive", work_of_adhesion = 0.05 }\npath'
SHAPE = {"{ spacing": "{ shape = [50, 50], spacing"}


@pytest.mark.parametrize("lines", [{}, DEPTHS, {**DEPTHS, "path": ADHESIVE}])
def test_the_scan_of_a_paraboloid_gives_the_steps_of_a_sphere(read, lines):
    whole = read(lines=lines).with_values({"substrate.model": "atoms"})
    assert whole.surface == RoughSphere(np.inf, whole.scan)
    sphere = whole.with_values({"sphere.radius": "10 nm", "topography": None})
    assert whole.plan().runs
    assert COPIES_LEFT_OUT in whole.plan().left_out
    assert np.array(steps(whole)) == pytest.approx(np.array(steps(sphere)), rel=1e-4)


def test_a_plan_of_a_rough_tip_runs_as_the_tip_does(read):
    free, fixed = (read(TIP + ROUGH, DEPTHS | each) for each in ({}, SHAPE))
    wide = read(lines=DEPTHS | SHAPE | {"radius = inf": 'radius = "1 mm"'})
    assert all(scene.plan().runs for scene in (free, fixed, wide))
    assert np.array(steps(free)) == pytest.approx(np.array(steps(fixed)), rel=1e-3)


def test_theory_of_a_tip_follows_from_its_radius_of_curvature(read):
    scene = read()
    assert scene.radius == pytest.approx(100.0)
    assert scene.rough is None and not scene.is_flat
    smooth = reference_for(scene).smooth
    assert (smooth.name, smooth.radius) == ("Hertz", scene.radius)
    assert scene.warnings == []


@pytest.mark.parametrize(
    ("lines", "heights", "message"),
    [
        ({"[topography]": "[roughness]\n[topography]"}, TIP, r"or \[topography\], not"),
        ({"radius = inf": ""}, TIP, r"radius of 10 nm ± \S+ % .* radius = inf"),
        ({"radius = inf": ""}, ROUGH, "give radius = inf"),
        ({}, -TIP, "edge of the scan: is the height reversed"),
        (
            {'center = "highest"': ""},
            -TIP,
            "height reversed.* radius of the sphere",
        ),
        ({'"none"': '"nome"'}, TIP, "did you mean 'none'"),
    ],
)
def test_tips_without_a_radius_or_with_a_wrong_one_are_refused(
    read, lines, heights, message
):
    with pytest.raises(ValueError, match=message):
        read(heights, lines=lines)


def test_a_substrate_and_a_sphere_without_a_scan_have_a_default_radius(read):
    lines = {"radius = inf": "", "indenter": "substrate"}
    assert read(ROUGH, lines=lines).radius == 1000.0 * 2.0
    copper = Scene.parse('[substrate]\nmaterial = "Cu"')
    assert copper.radius == 1000.0 * copper.spacing


def test_the_radius_of_a_whole_tip_is_not_fitted(read):
    from ase_roughcontact.fitting.parameters import value_of

    with pytest.raises(ValueError, match="radius can't be fitted"):
        value_of(read(), "radius")


SPHERE = {"radius = inf": 'radius = "30 nm"', '"indenter"': '"substrate"'}
HOLES = ROUGH.copy()
HOLES[20:40] = np.nan


@pytest.mark.parametrize(
    ("heights", "lines", "message"),
    [
        (HOLES, {}, "31 % of the points are missing"),
        (np.zeros((64, 64)), {'center = "highest"': ""}, "all heights are the same"),
        (1e-4 * ROUGH, {}, "rms slope is 4.99e-06"),
        (30.0 * ROUGH, {}, "rms slope is 1.5, usual"),
        (200.0 * ROUGH, {"radius = inf": 'radius = "1 nm"'}, "of the sphere, 1 nm"),
        (ROUGH, {"spacing = 2.0\n": 'spacing = "0.1 mm"\n'}, "6.4 mm wide"),
        (TIP, {'"indenter"': '"indenter"'}, "radius of about 10 nm ± 0.0 % at its"),
    ],
)
def test_doubtful_scans_are_named(read, heights, lines, message):
    warnings = read(heights, lines=SPHERE | lines).warnings
    assert any(re.search(message, each) for each in warnings), warnings


def test_usual_scans_are_not_doubted(read):
    for lines in (SPHERE, SPHERE | {'"indenter"': '"indenter"'}):
        scene = read(ROUGH, lines=lines)
        assert scene.warnings == []
        assert isinstance(scene.rough, HeightMap)


def test_the_fitted_modulus_belongs_to_the_sample(read):
    from ase_roughcontact.fitting.parameters import changed, value_of

    of_both = read(lines={"radius = inf": 'radius = inf, material = "Si3N4"'})
    assert value_of(of_both, "contact_modulus") == pytest.approx(100.0)
    same = changed(of_both, {"contact_modulus": 100.0})
    assert same.contact_modulus == pytest.approx(of_both.contact_modulus)


def test_a_whole_tip_may_be_higher_than_its_radius(read):
    assert read(40.0 * TIP).warnings == []
    assert "scan.npy, the indenter: " in read().topography.summary


def test_the_indices_of_an_array_may_be_exchanged(read):
    rows = read(TIP[:50].T, {"detrend": "transpose = true\ndetrend"})
    summary = rows.topography.summary
    assert "50 x 64 points (second index along x)" in summary
    assert summary == read(TIP[:50]).topography.summary.replace("first", "second")
    assert steps(rows) == steps(read(TIP[:50]))


def test_an_ensemble_has_no_slope_of_roughness_of_a_whole_tip(read):
    smooth = Scene.parse('[substrate]\nmaterial = "Cu"')
    assert scene_columns(smooth)["rms_slope"] == 0.0
    assert np.isnan(scene_columns(read())["rms_slope"])
