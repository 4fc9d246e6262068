"""Two rough, elastic bodies in one scene: heights and compliances are added."""

import numpy as np
import pytest

from ase_roughcontact import HeightMap, SelfAffine
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.cli.description import bodies
from ase_roughcontact.scene import Scene

GPA = UNITS["GPa"]
# Spectrum of both bodies.
SPECTRUM = "unit = 'a0'\nshort_wavelength = 4.0\nlong_wavelength = 16.0\n"
SOLIDS = """
[substrate]
contact_modulus = 100.0
spacing = 2.0
[tip]
contact_modulus = 300.0
[interaction]
kind = "hard"
"""
ROUGH = f"""
[tip.roughness]
rms_slope = 0.03
seed = 5
{SPECTRUM}
[substrate.roughness]
rms_slope = 0.04
seed = 5
{SPECTRUM}
"""
SPHERE = (
    SOLIDS
    + ROUGH
    + '[sphere]\nunit = "a0"\nradius = 200.0\n[path]\nvalues = ["20 nN"]\n'
)
FLAT = SOLIDS + ROUGH + '[sphere]\nradius = inf\n[path]\nvalues = ["1 GPa"]\n'


def by_hand(shape, spacing, origin, domain=None):
    """Return the heights of the tip less the heights of the substrate (Å)."""
    waves = {"short_wavelength": 8.0, "long_wavelength": 32.0, "domain": domain}
    tip = SelfAffine(0.03, 0.8, **waves, seed=5)
    base = SelfAffine(0.04, 0.8, **waves, seed=5 + 2**32)
    grid = shape, spacing, origin
    return tip.heights(*grid) - base.heights(*grid)


def test_the_surface_is_the_tip_less_the_substrate():
    rough = Scene.parse(SPHERE).rough
    grid = (10, 8), 2.0, (-4.0, 6.0)
    assert rough.heights(*grid) == pytest.approx(by_hand(*grid), abs=1e-12)


def test_the_contact_modulus_is_of_both_bodies():
    scene = Scene.parse(SPHERE)
    assert scene.contact_modulus == pytest.approx(GPA / (1 / 100.0 + 1 / 300.0))
    changes = {"tip.contact_modulus": None, "tip.youngs_modulus": 200.0}
    young = scene.with_values(changes | {"tip.poisson": 0.25})
    expected = GPA / (1 / 100.0 + (1 - 0.25**2) / 200.0)
    assert young.contact_modulus == pytest.approx(expected)


def test_pressures_of_both_elastic_bodies_meet_the_conditions_of_contact():
    scene = Scene.parse(FLAT)
    stepper = scene.stepper(scene.frames())
    [target] = scene.targets
    relaxed = stepper.relax(stepper.start, target)
    pressure, spacing = relaxed.fields.pressure, relaxed.halfspace.spacing
    n, m = pressure.shape
    origin = relaxed.problem.origin(relaxed.state.window)
    heights = by_hand((n, m), spacing, origin)
    # displacements of tip and substrate by their own compliances, 2/(q E*)
    q = (
        2
        * np.pi
        * np.hypot(np.fft.fftfreq(n, spacing)[:, None], np.fft.fftfreq(m, spacing))
    )
    q[0, 0] = np.inf
    gap = heights.copy()
    for modulus in (100.0, 300.0):
        waves = 2.0 / (modulus * GPA * q) * np.fft.fft2(pressure)
        gap += np.fft.ifft2(waves).real
    gap -= gap.min()
    touches = pressure > 0.0
    assert 0.01 < touches.mean() < 0.9
    assert pressure.min() >= 0.0
    assert pressure.mean() == pytest.approx(GPA, rel=1e-6)
    assert gap[touches].max() < 1e-3 * heights.std()


def test_a_map_of_the_sum_gives_the_same_contact(tmp_path):
    [both] = Scene.parse(FLAT).relax(scan_errors=False)
    scene = Scene.parse(FLAT)
    n, m = scene.bodies.cell
    heights = by_hand((n, m), 2.0, (-(n // 2) * 2.0, -(m // 2) * 2.0))
    np.save(tmp_path / "sum.npy", -heights)
    sections = "[topography]\nfile = 'sum.npy'\nunit = 'Å'\nspacing = 2.0\n"
    sections += "role = 'substrate'\nperiodic = true\ndetrend = 'none'\n"
    text = SOLIDS + sections + FLAT.partition(ROUGH)[2]
    one = Scene.parse(text, str(tmp_path / "scene.toml"))
    [step] = one.relax(scan_errors=False)
    assert one.contact_modulus == scene.contact_modulus
    assert step.contact_area == pytest.approx(both.contact_area, rel=0.02)
    assert step.mean_gap == pytest.approx(both.mean_gap, rel=0.02)


def test_the_hardness_is_the_smaller_one():
    scene = Scene.parse(SPHERE)
    assert np.isnan(scene.hardness)
    given = {"substrate.hardness": 8.0, "tip.hardness": 3.0}
    assert scene.with_values(given).hardness == pytest.approx(3.0 * GPA)
    given = {"substrate.hardness": 2.0, "tip.hardness": 3.0}
    assert scene.with_values(given).hardness == pytest.approx(2.0 * GPA)
    # the hardness of one body alone may be unknown
    assert np.isnan(scene.with_values({"tip.hardness": np.inf}).hardness)


def test_a_material_of_the_tip_may_be_given_in_either_section():
    substrate = '[substrate]\nmaterial = "SiO2"\n[path]\nvalues = [5.0]\n'
    sphere = Scene.parse(
        f'{substrate}[sphere]\nunit = "a0"\nradius = 60.0\nmaterial = "diamond"\n'
    )
    tip = Scene.parse(
        f'{substrate}[sphere]\nradius = "60 a0"\n[tip]\nmaterial = "diamond"\n'
    )
    assert tip.contact_modulus == sphere.contact_modulus
    assert tip.hardness == sphere.hardness
    with pytest.raises(ValueError, match=r"\[tip\].*once"):
        tip.with_values({"sphere.material": "diamond"}).check()


def test_statistics_of_each_body_and_of_both_are_described():
    found = bodies(Scene.parse(SPHERE))
    assert "slope 0.03," in found["tip roughness"]
    assert "slope 0.04," in found["substrate roughness"]
    assert "slope 0.05," in found["roughness of both"]


def test_a_rough_substrate_alone_is_pressed_by_a_smooth_sphere():
    text = SOLIDS + "[substrate.roughness]\nrms_slope = 0.04\nseed = 5\n" + SPECTRUM
    scene = Scene.parse(
        text + "[sphere]\nunit = 'a0'\nradius = 200.0\n[path]\nvalues = [5.0]\n"
    )
    waves = {"short_wavelength": 8.0, "long_wavelength": 32.0}
    base = SelfAffine(0.04, 0.8, **waves, seed=5 + 2**32)
    expected = -base.heights((6, 6), 2.0)
    assert scene.rough.heights((6, 6), 2.0) == pytest.approx(expected, abs=1e-12)


def test_the_seed_of_both_is_set_at_once():
    scene = Scene.parse(SPHERE).with_values({"roughness.seed": 7})
    assert (scene.tip_roughness.seed, scene.substrate_roughness.seed) == (7, 7)
    scene = scene.with_values({"tip.roughness.seed": 8})
    assert (scene.tip_roughness.seed, scene.substrate_roughness.seed) == (8, 7)


def test_the_text_of_a_scene_gives_the_same_scene():
    scene = Scene.parse(SPHERE)
    assert Scene.parse(scene.toml) == scene
    assert scene.changes_from(scene.with_values({"tip.roughness.seed": 6})) == [
        "[tip.roughness] seed was 6, is 5"
    ]


def test_periods_of_random_bodies_on_a_flat_are_equal():
    scene = Scene.parse(FLAT)
    wide = scene.with_values({"substrate.roughness.long_wavelength": 24.0})
    assert wide.bodies.cell == (96, 96)
    assert wide.rough.periods == (192.0, 192.0)
    given = wide.with_values({"tip.roughness.domain": 64})
    with pytest.raises(ValueError, match=r"\[tip.roughness\] domain is 12.8 nm"):
        given.check()


def scan_text(tmp_path, name, shape, spacing):
    """Write a scan, and return its section without the title."""
    x, y = (spacing * np.arange(n) for n in shape)
    heights = 0.1 * np.sin(2 * np.pi * x[:, None] / 24.0) + 0.05 * np.cos(y / 3.0)
    np.save(tmp_path / name, heights)
    return f"file = '{name}'\nunit = 'Å'\nspacing = {spacing}\n"


def test_the_middle_of_two_scans_is_sampled_with_the_smaller_pixels(tmp_path):
    tip = "[tip.topography]\n" + scan_text(tmp_path, "tip.npy", (48, 40), 2.0)
    base = "[substrate.topography]\n" + scan_text(tmp_path, "s.npy", (61, 61), 3.0)
    end = '[sphere]\nradius = inf\n[path]\nvalues = ["1 GPa"]\n'
    scene = Scene.parse(SOLIDS + tip + base + end, str(tmp_path / "scene.toml"))
    assert scene.spacing == 2.0
    assert scene.bodies.cell == (46, 38)
    maps = [part.surface for part in scene.bodies.parts]
    assert [each.shape for each in maps] == [(46, 38)] * 2
    grid = (46, 38), 2.0, (-46.0, -38.0)
    inner = scene.tip_topography.surface.heights(*grid)
    inner = inner + scene.substrate_topography.surface.heights(*grid)
    # but for the smooth surface that makes them periodic
    smooth = scene.rough.heights(*grid) - HeightMap(inner, 2.0).made_periodic().heights(
        *grid
    )
    assert np.ptp(smooth) < 1e-9


@pytest.mark.parametrize(("shape", "known"), [((24, 24), True), ((20, 22), False)])
def test_errors_of_two_scans_are_known_if_they_have_the_same_pixels(
    tmp_path, shape, known
):
    tip = "[tip.topography]\n" + scan_text(tmp_path, "tip.npy", shape, 2.0)
    base = "[substrate.topography]\n" + scan_text(tmp_path, "s.npy", (24, 24), 2.0)
    end = '[sphere]\nradius = inf\n[path]\nvalues = ["0.1 GPa"]\n'
    scene = Scene.parse(SOLIDS + tip + base + end, str(tmp_path / "scene.toml"))
    [step] = scene.relax(validity="ignore")
    assert np.isfinite(step.height_error) == known
    assert np.isfinite(step.area_error) == known
    assert ("common grid" in step.not_known.get("height_error", "")) != known


def test_a_scan_and_random_roughness_have_one_cell(tmp_path):
    scan = "[substrate.topography]\n" + scan_text(tmp_path, "s.npy", (48, 48), 2.0)
    tip = f"[tip.roughness]\nrms_slope = 0.03\n{SPECTRUM}"
    end = '[sphere]\nradius = inf\n[path]\nvalues = ["1 GPa"]\n'
    scene = Scene.parse(SOLIDS + scan + tip + end, str(tmp_path / "scene.toml"))
    assert scene.bodies.cell == (48, 48)
    assert scene.rough.periods == (96.0, 96.0)


@pytest.mark.parametrize(
    ("extra", "words"),
    [
        ("[roughness]\nseed = 1", r"\[roughness\].*\[tip.roughness\]"),
        ("[tip.topography]\nfile = 'a.npy'", r"\[tip.topography\], not both"),
    ],
)
def test_sections_that_contradict_each_other_are_named(extra, words):
    with pytest.raises(ValueError, match=words):
        Scene.parse(SPHERE + extra).check()


def test_a_scan_of_a_body_has_no_other_role(tmp_path):
    scan = "[tip.topography]\nrole = 'substrate'\n"
    scan += scan_text(tmp_path, "tip.npy", (20, 20), 2.0)
    end = "[sphere]\nunit = 'a0'\nradius = 200.0\n[path]\nvalues = [5.0]\n"
    scene = Scene.parse(SOLIDS + scan + end, str(tmp_path / "scene.toml"))
    with pytest.raises(ValueError, match=r'\[tip.topography\] role must be "indenter"'):
        scene.check()


def test_a_tip_without_a_modulus_is_not_elastic():
    scene = Scene.parse(
        '[substrate]\nmaterial = "Cu"\n[tip]\nhardness = 3.0\n[path]\nvalues = [5.0]'
    )
    with pytest.raises(ValueError, match=r"\[tip\] hardness needs material"):
        scene.check()
