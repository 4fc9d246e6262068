"""Scenes with a scan as the roughness."""

import re
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from small_scene import SMALL

from ase_roughcontact import HeightMap, RoughSphere, SelfAffine
from ase_roughcontact.ensemble import run_places
from ase_roughcontact.ensemble.cases import case_of
from ase_roughcontact.ensemble.columns import scene_columns
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.reference import reference_for

ROUGH = SelfAffine(0.05, 0.8, 8.0, 64.0, seed=1)  # Å
SCAN = -ROUGH.heights((64, 64), 2.0) / 10  # nm
SMOOTH = SMALL[: SMALL.index("[roughness]")] + SMALL[SMALL.index("[path]") :]
SECTION = '[topography]\nfile = "scan.txt"\nrole = "substrate"\n'


def write(folder, heights):
    """Write a scan (nm) with points at a distance of 2 Å."""
    width = 0.2 * len(heights)
    header = f"Width: {width:g} nm\nHeight: {width:g} nm\nValue units: nm"
    np.savetxt(folder / "scan.txt", heights.T, header=header)


@pytest.fixture
def folder(tmp_path):
    write(tmp_path, SCAN)
    return tmp_path


def read(folder, section=SECTION, scene=SMOOTH):
    (folder / "scan.toml").write_text(scene + section)
    return Scene.read(folder / "scan.toml")


def test_the_scan_is_sought_beside_the_scene_file(folder, monkeypatch):
    monkeypatch.chdir("/")
    scene = read(folder)
    expected = HeightMap.from_topography(folder / "scan.txt", "substrate")
    assert scene.surface == RoughSphere(scene.radius, expected)
    assert scene.with_values({"substrate.model": ""}).is_continuum


def test_the_scan_is_found_in_the_folder_of_a_run(folder):
    (folder / "run").mkdir()
    (folder / "scan.txt").rename(folder / "run" / "scan.txt")
    section = SECTION.replace("scan.txt", "elsewhere/scan.txt")
    assert isinstance(read(folder / "run", section).rough, HeightMap)


def test_roles_and_places_follow_from_the_section(folder):
    section = SECTION.replace("substrate", "indenter")
    section += 'unit = "nm"\ncenter = [2.0, 3.0]\ndetrend = "none"\n'
    rough = read(folder, section).rough
    assert rough.heights((1, 1), 1.0)[0, 0] == pytest.approx(-10 * SCAN[10, 15])
    assert rough.center == pytest.approx((126.0 - 20.0, 30.0))


def test_a_scan_is_pressed_and_its_path_resumed(folder):
    scene = read(folder, SECTION + 'center = "highest"\nmargin = 2.0\n')
    steps, again = (list(scene.run(folder / "run")) for _ in range(2))
    assert [step.normal_force for step in steps] == [s.normal_force for s in again]
    smooth = replace(scene, topography=None).relax([0.6])
    assert 0.0 < steps[-1].contact_area < next(smooth).contact_area
    assert steps[-1].converged


@pytest.mark.parametrize(
    "name", ["curve.csv", "Sweep.traj", "scene.toml", "places.csv", "curve.csv.new"]
)
@pytest.mark.parametrize("out", ["run", "."])
def test_a_scan_with_the_name_of_a_result_is_refused(folder, name, out):
    (folder / "scan.txt").rename(folder / name)
    content = (folder / name).read_bytes()
    scene = read(folder, SECTION.replace("scan.txt", name))
    for write in (lambda: scene.run(folder / out), lambda: places(scene, folder / out)):
        with pytest.raises(ValueError, match=name):
            list(write())
    assert (folder / name).read_bytes() == content
    assert {path.name for path in folder.iterdir()} == {name, "scan.toml"}


def places(scene, folder):
    with ThreadPoolExecutor(1) as pool:
        yield from run_places(scene, (1, 1), folder, pool)


def test_theory_for_a_scan_follows_from_its_statistics(folder):
    scene = read(folder, scene=SMOOTH.replace("radius = 60.0", "radius = 120.0"))
    rough = scene.rough
    statistics = rough.statistics()
    assert rough.rms_slope == statistics.rms_slope
    kappa, light = scene.bodies.kappa_repulsive, 1e-4
    area = light * kappa / (statistics.rms_slope * scene.contact_modulus)
    assert scene.bodies.predicted_area(light) == pytest.approx(area, rel=0.02)
    assert reference_for(scene).rough_above == 0.0


def test_lengths_of_a_scan_may_have_units(folder):
    section = 'center = ["2 nm", 3.0]\nmargin = "5 Å"\nspacing = ["0.2 nm", "2 Å"]\n'
    rough = read(folder, SECTION + section).rough
    assert rough.center == pytest.approx((20.0, 30.0))
    assert rough.spacing == pytest.approx((2.0, 2.0))
    section = SECTION + 'center = "highest"\nmargin = "2 nm"\n'
    center = read(folder, section).rough.center
    assert center == read(folder, section.replace('"2 nm"', "2.0")).rough.center
    assert min(center) >= 20.0 and max(center) <= 106.0
    with pytest.raises(ValueError, match=r"12\.8 x 12\.8 nm.* 9 nm"):
        read(folder, section.replace("2 nm", "90 Å"))


def test_a_scan_of_one_asperity_is_not_compared_with_rough_surfaces(tmp_path):
    x = np.linspace(-np.pi, np.pi, 64)
    write(tmp_path, 0.02 * np.cos(x)[:, None] * np.cos(x))
    adhesive = '[interaction]\nkind = "adhesive"\nwork_of_adhesion = 0.05\n'
    for section in (SECTION, SECTION + adhesive):
        reference = reference_for(read(tmp_path, section))
        assert reference.rough_above is None
        assert "as sharp as an asperity" in reference.explanation


def test_columns_of_an_ensemble_describe_the_scan(folder):
    scene = read(folder)
    columns = scene_columns(scene)
    assert columns["rms_slope"] == scene.rough.rms_slope
    short = scene.rough.short_wavelength / scene.spacing
    assert columns["short_wavelength"] == pytest.approx(short, rel=1e-12)
    assert columns["seed"] == -1
    assert case_of(scene) != case_of(replace(scene, topography=None))


@pytest.mark.parametrize(
    "section, message",
    [
        ('[topography]\nrole = "substrate"', "give file"),
        ('[topography]\nfile = "scan.txt"', 'give role, .*: "indenter" or "substrate"'),
        (SECTION.replace("substrate", "tip"), "unknown role 'tip'"),
        (SECTION.replace("scan.txt", "none.txt"), r"cannot read a scan from .*none"),
        (SECTION + "center = [1.0]", "center must be"),
        (SECTION + 'detrend = "tilt"', ".*detrend 'tilt'"),
    ],
)
def test_errors_name_the_section(folder, section, message):
    with pytest.raises(ValueError, match=rf"\[topography\] {message}"):
        read(folder, section)


def test_a_scan_that_has_changed_is_read_again(folder):
    first = read(folder).rough
    write(folder, 2 * SCAN)
    assert read(folder).rough.rms_slope == pytest.approx(2 * first.rms_slope)


def doubts(scene):
    return [each for each in scene.warnings if each.startswith("scan.txt")]


def with_noise(points=0.0, lines=0.0):
    """Return the scan with noise (nm)."""
    rng = np.random.default_rng(1)
    return SCAN + points * rng.normal(size=SCAN.shape) + lines * rng.normal(size=64)


@pytest.mark.parametrize(
    ("noise", "advice"),
    [
        # the filter would remove 14 % of the slope of the surface
        ({"points": 0.002}, "slope, which changes areas: give a scan with less noise"),
        ({"points": 0.01}, 'give cutoff_wavelength = "0.8 nm", which also removes'),
        ({"lines": 0.01}, 'give detrend = "lines"'),
        ({}, ""),
    ],
)
def test_noise_is_printed_and_keys_that_help_are_offered(folder, noise, advice):
    write(folder, with_noise(**noise))
    scene = read(folder)
    found = scene.scan.measurement.noise
    text = f"noise {0.1 * found.points:.2g} nm, of lines {0.1 * found.lines:.2g} nm"
    assert text in scene.topography.summary
    warnings = " ".join(doubts(scene))
    assert advice in warnings
    assert bool(advice) == ("% of the mean square slope" in warnings)


def test_the_advised_filter_removes_the_noise(folder):
    write(folder, with_noise(points=0.01))
    filtered = read(folder, SECTION + 'cutoff_wavelength = "1.2 nm"\n')
    assert "filtered below 1.2 nm" in filtered.topography.summary
    assert doubts(filtered) == []
    assert filtered.scan.rms_slope < 0.7 * read(folder).scan.rms_slope


def test_outliers_are_reported_and_removed(folder):
    scan = SCAN.copy()
    scan[30, 40] += 3.0
    write(folder, scan)
    assert "1 single points stick out far" in " ".join(doubts(read(folder)))
    removed = read(folder, SECTION + "remove_outliers = true\n")
    assert doubts(removed) == []
    assert removed.scan.rms_slope < 0.1 < read(folder).scan.rms_slope


def test_a_part_of_a_scan_that_is_declared_periodic_is_doubted(folder):
    write(folder, SCAN[:40, :40])
    (warning,) = doubts(read(folder, SECTION + "periodic = true\n"))
    assert "from one edge to the opposite" in warning
    assert "is the scan periodic?" in warning


def test_bad_lines_are_doubts_and_are_removed(folder):
    scan = SCAN.copy()
    scan[:, 20:22] = 0.0
    write(folder, scan)
    (warning,) = doubts(read(folder))
    assert "all heights equal: lines 20-21" in warning
    assert "remove_bad_lines = true" in warning
    mended = read(folder, SECTION + "remove_bad_lines = true\n")
    assert doubts(mended) == []
    write(folder, SCAN)
    assert mended.scan.rms_slope == pytest.approx(read(folder).scan.rms_slope, rel=0.02)


def test_scars_change_the_area_of_a_flat_and_their_removal_restores_it(folder):
    scene = SMOOTH[: SMOOTH.index("[sphere]")] + "[sphere]\nradius = inf\n"
    scene += '[interaction]\nkind = "hard"\n[path]\nvalues = ["50 MPa"]\n'
    section = SECTION + "periodic = true\n"
    rough = 5.0 * SCAN.std()
    scan = SCAN.copy()
    scan[20:40, 30] += rough
    scan[40:60, 50] += rough
    areas = []
    for heights, mended in (
        (SCAN, ""),
        (scan, ""),
        (scan, "remove_bad_lines = true\n"),
    ):
        write(folder, heights)
        (step,) = read(folder, section + mended, scene).relax(scan_errors=False)
        areas.append(step.continuum_area)
    assert areas[1] < 0.5 * areas[0]
    assert areas[2] == pytest.approx(areas[0], rel=0.05)  # waves of four points


def tip_scene(folder, scan, keys="", radius="inf"):
    """Return the scene of the scan of an indenter of 12.8 nm."""
    write(folder, scan)
    scene = SMOOTH.replace("radius = 60.0", f"radius = {radius}")
    section = SECTION.replace("substrate", "indenter") + 'detrend = "none"\n' + keys
    return read(folder, section, scene)


PLACES = 0.2 * (np.arange(64.0) - 32.0)  # nm
SQUARES = PLACES[:, None] ** 2 + PLACES**2


def test_the_radius_of_a_scanned_tip_has_an_error(folder):
    scene = tip_scene(folder, SCAN - SQUARES / 12.0)
    assert scene.whole_tip is not None
    (radius, error) = re.search(
        r"curvature of the scan itself: radius (\S+) nm ± (\S+) %",
        scene.topography.summary,
    ).groups()
    assert float(radius) == pytest.approx(6.0, rel=0.03 * float(error))
    assert 0.0 < float(error) < 20.0


def test_a_rough_flat_with_the_bow_of_a_scanner_is_taken_for_a_flat(folder):
    scene = tip_scene(folder, 3.0 * SCAN - SQUARES / 400.0)
    assert scene.is_flat
    assert "no tip found" in " ".join(doubts(scene))


def test_a_lens_may_be_a_flat_with_the_bow_of_a_scanner(folder):
    scene = tip_scene(folder, 0.01 * SCAN - SQUARES / 100.0)
    assert scene.whole_tip is not None
    assert 'if it is a flat, give detrend = "curvature"' in " ".join(doubts(scene))
    sharp = tip_scene(folder, 0.01 * SCAN - SQUARES / 12.0)
    assert "if it is a flat" not in " ".join(doubts(sharp))


def test_debris_on_the_edge_hides_a_tip_unless_there_is_a_margin(folder):
    scan = 0.1 * SCAN - SQUARES / 12.0
    scan[2, 3] = 20.0
    hidden = tip_scene(folder, scan)
    assert "Give margin" in " ".join(doubts(hidden))
    found = tip_scene(folder, scan, 'center = "highest"\nmargin = "1.2 nm"\n')
    assert found.radius == pytest.approx(60.0, rel=0.1)


def test_a_place_near_the_edge_of_a_scan_asks_for_a_margin(folder):
    scene = SMOOTH.replace("shape", "#shape")
    section = SECTION + 'unit = "nm"\ncenter = [2.0, 6.4]\n'
    with pytest.raises(ValueError, match=r" nm .*\(margin\)"):
        next(read(folder, section, scene).relax([8.0]))
