"""Measured and random surfaces that are pressed against a flat."""

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from ase_roughcontact._util.files import table_rows
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.cli import main
from ase_roughcontact.cli.description import bodies
from ase_roughcontact.cli.figures import draw
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.reference import reference_for
from ase_roughcontact.topography import SelfAffine

PIXEL, POINTS, AMPLITUDE = 2.0, 64, 0.5  # nm

SCENE = """
substrate = { model = "atoms", contact_modulus = 100.0, hardness = inf }
sphere = { radius = inf }
interaction = { kind = "hard" }
path = { values = ["100 MPa"] }
[topography]
file = "scan.npy"
role = "substrate"
spacing = 2.0
unit = "nm"
periodic = true
"""
RANDOM = """
[roughness]
unit = "a0"
short_wavelength = 8.0
long_wavelength = 32.0
domain = 128.0
[solver]
accuracy = "fast"
"""


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """A folder of its own for each test, in which the scans are."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def wave():
    """Write the scan of a cosine along x."""
    x = 2.0 * math.pi * np.arange(POINTS) / POINTS
    np.save("scan.npy", AMPLITUDE * np.cos(x)[:, None] * np.ones((1, 8)))


@pytest.mark.parametrize("part", [0.1, 0.25, 0.7])
def test_area_and_gap_of_a_wave_agree_with_westergaard(wave, part):
    # p* = pi E* Delta/lambda; A/A0 = (2/pi) asin(sqrt(p/p*)); H. M. Westergaard,
    # J. Appl. Mech. 6, 49 (1939)
    full = math.pi * 100e3 * AMPLITUDE / (POINTS * PIXEL)
    scene = Scene.parse(SCENE.replace('"100 MPa"', f'"{part * full} MPa"'))
    scene.check()
    (step,) = scene.relax()
    pressure = step.normal_force / scene.bodies.nominal_area
    assert pressure == pytest.approx(part * full * UNITS["MPa"])
    assert step.nominal_pressure == pytest.approx(pressure)
    # both agree for the elastic contact of a hard wall
    conductance = 2.0 * step.contact_stiffness / scene.contact_modulus
    assert step.conductance == pytest.approx(conductance, rel=1e-3)
    fraction = 2.0 / math.pi * math.asin(math.sqrt(part))
    assert step.continuum_area / scene.bodies.nominal_area == pytest.approx(
        fraction, abs=0.01
    )
    # mean gap by K. L. Johnson, Contact Mechanics (1985), section 13.2
    a = math.sin(math.pi * fraction / 2.0) ** 2
    gap = AMPLITUDE * (1.0 - a + a * math.log(a)) * UNITS["nm"]
    assert step.mean_gap == pytest.approx(gap, rel=0.02)


def test_the_command_prints_and_draws_a_flat_without_a_sphere(wave, folder, capsys):
    (folder / "flat.toml").write_text(SCENE)
    assert main(["run", "flat.toml", "--out", "out"]) == 0
    main(["report", "out"])
    page = (folder / "out" / "report.html").read_text()
    printed = capsys.readouterr().out
    assert [w for w in ("Hertz", "sphere", "radius") if w in printed] == []
    for text in (printed, page):
        assert "Hertz" not in text
        assert "rough flat, periodic cell of 128 x 16 nm" in text
    with open("out/curve.csv") as table:
        (step,) = table_rows(table)
    assert float(step["nominal_pressure"]) == pytest.approx(100.0 * UNITS["MPa"])
    (text,) = re.findall(r'id="data">(.*?)</script>', page)
    data = json.loads(text)
    assert data["x"] == data["theory"]["x"] == "nominal_pressure"
    assert 100.0 <= data["theory"]["lines"][0]["x"][-1] < 200.0  # MPa
    assert (folder / "out" / "curve.png").exists()


def test_maps_of_a_flat_have_one_unit_of_pressure(wave, folder, monkeypatch):
    titles = []

    def saved(figure, file, **_):
        titles.extend(axes.get_title() for axes in figure.axes)
        Path(file).touch()

    monkeypatch.setattr(Figure, "savefig", saved)
    text = SCENE.replace('["100 MPa"]', '["0.05 MPa", "100 MPa"]')
    (folder / "flat.toml").write_text(text)
    assert main(["run", "flat.toml", "--out", "out"]) == 0
    maps = [title for title in titles if title.endswith("Pa")]
    assert maps == ["(a) 0.05 MPa", "(b) 100 MPa"]


def test_the_figure_of_a_flat_has_the_columns_of_the_table(wave, monkeypatch):
    figures = []

    def saved(figure, file, **_):
        figures.append(figure)
        Path(file).touch()

    monkeypatch.setattr(Figure, "savefig", saved)
    scene = Scene.parse(SCENE.replace('["100 MPa"]', '["30 MPa", "100 MPa"]'))
    scene = scene.with_values({"output.columns": ["conductance"]})
    steps = list(scene.relax())
    assert draw(reference_for(scene), steps, Path(), shown=[]) == ["curve.png"]
    upper, middle, lower = figures[0].axes
    nominal, nm, unit = scene.bodies.nominal_area, UNITS["nm"], UNITS["N/m"]
    area, error = (
        np.array([getattr(s, name) for s in steps]) / nominal
        for name in (scene.area_column, "area_error")
    )
    drawn = {line.get_label(): line for line in upper.get_lines()}
    x, y = drawn["simulation"].get_data()
    assert x == pytest.approx([30.0, 100.0])
    assert y == pytest.approx(area)
    segments = np.array([each.get_segments() for each in upper.collections])[0]
    assert (
        pytest.approx(np.array([area - 2.0 * error, area + 2.0 * error]))
        == segments[:, :, 1].T
    )
    gaps = [s.mean_gap / nm for s in steps]
    assert middle.get_lines()[0].get_ydata() == pytest.approx(gaps)
    stiffness = [s.contact_stiffness / unit for s in steps]
    assert lower.get_lines()[0].get_ydata() == pytest.approx(stiffness)


def fraction_and_error(heights, pressure):
    """Contact fraction of a scan, and its estimated error."""
    np.save("scan.npy", heights)
    is_mirrored = "true" if len(heights) > POINTS else "false"
    text = SCENE.replace("= true", f"= {is_mirrored}").replace("100 MPa", pressure)
    scene = Scene.parse(text)
    (step,) = scene.relax(validity="ignore")
    nominal = scene.bodies.nominal_area
    assert nominal == pytest.approx(400.0 * heights.size)  # no line is left out
    return step.continuum_area / nominal, step.area_error / nominal


def test_errors_of_a_scan_without_period_contain_how_it_goes_on():
    rough, covered, errors = SelfAffine(0.2, 0.8, 4.0, 256.0, domain=256.0), 0, []
    whole = rough.heights((256, 256), 1.0)
    for i in range(0, 256, POINTS):
        part = whole[i : i + POINTS, :POINTS]
        mirrored = np.vstack([part, part[::-1]])
        mirrored = np.hstack([mirrored, mirrored[:, ::-1]])
        found, error = fraction_and_error(part, "200 MPa")
        expected, of_grid = fraction_and_error(mirrored, "200 MPa")
        covered += abs(found - expected) < 2.0 * error
        errors.append(error)
        assert error > 3.0 * of_grid
    assert covered >= 3  # nine of ten, in the mean
    assert max(errors) < 0.3 * found


def test_the_part_of_the_scan_that_is_left_out_is_printed(wave):
    text = SCENE.replace("periodic = true", "")
    x = np.linspace(-1.0, 1.0, POINTS)
    np.save("scan.npy", np.load("scan.npy") + 0.3 * x[:, None] ** 2)
    scene = Scene.parse(text)
    removed = scene.bodies.problem.topography.rough.edge_change / 10.0
    expected = f"a smooth surface (rms height {removed:.3g} nm) is subtracted"
    assert expected in bodies(scene)["indenter"]


def test_random_flats_have_kappa_of_hard_walls():
    text = SCENE[: SCENE.index("[topography]")] + RANDOM
    text = text.replace('"atoms"', '"continuum"')
    scene = Scene.parse(text)
    (step,) = scene.relax()
    kappa = step.continuum_area * scene.rough.rms_slope * scene.contact_modulus
    assert 1.8 < kappa / step.normal_force < 2.5


@pytest.mark.parametrize(
    ("role", "periodic", "warned"),
    [("indenter", False, True), ("indenter", True, False), ("substrate", False, False)],
)
def test_a_scanned_indenter_without_a_tip_is_a_flat_with_a_warning(
    role, periodic, warned
):
    np.save("scan.npy", SelfAffine(0.2, 0.8, 8.0, 64.0, seed=1).heights((64, 64), 1.0))
    text = SCENE.replace('substrate"\n', f'{role}"\n')
    scene = Scene.parse(text.replace("= true", f"= {str(periodic).lower()}"))
    assert scene.is_flat
    assert ("no tip found" in "".join(scene.warnings)) is warned


@pytest.mark.parametrize("pixel", [(2.0, 3.0), (3.0, 2.0), (2.0, 2.0012), (2.0, 1.03)])
@pytest.mark.parametrize("turned", [False, True])
def test_pixels_that_are_no_squares_give_the_area_of_westergaard(wave, pixel, turned):
    text = SCENE.replace("spacing = 2.0", f"spacing = {list(pixel)}")
    if turned:
        text += "transpose = true\n"
    length = POINTS * pixel[1 if turned else 0]
    part = 0.25
    full = math.pi * 100e3 * AMPLITUDE / length
    scene = Scene.parse(text.replace('"100 MPa"', f'"{part * full} MPa"'))
    assert scene.spacing <= 10.0 * min(pixel) * (1.0 + 1e-9)
    (step,) = scene.relax(scan_errors=False)
    fraction = 2.0 / math.pi * math.asin(math.sqrt(part))
    assert step.continuum_area / scene.bodies.nominal_area == pytest.approx(
        fraction, abs=0.01
    )
    gap = 0.75 + 0.25 * math.log(0.25)
    assert step.mean_gap == pytest.approx(gap * AMPLITUDE * UNITS["nm"], rel=0.02)


def test_the_strain_of_pixels_that_are_no_squares_is_shown_and_in_the_error():
    rough = SelfAffine(0.05, 0.8, 16.0, 64.0, seed=1, domain=64.0)
    np.save("scan.npy", rough.heights((64, 64), 1.0))
    errors = []
    for pixel in (2.0, 2.0 * 64 / 63.5):
        scene = Scene.parse(SCENE.replace("spacing = 2.0", f"spacing = [2.0, {pixel}]"))
        (step,) = scene.relax()
        errors.append(step.area_error / step.continuum_area)
    assert scene.scan.spacing[1] == pytest.approx(10.0 * pixel)
    strain = 81 * 1.6 / (64 * pixel) - 1.0  # 80 x 81 squares
    assert f"changed by {100 * strain:.2g} %" in bodies(scene)["indenter"]
    assert errors[0] < abs(strain) < errors[1] < 5.0 * abs(strain)


def test_a_substrate_that_looks_like_a_tip_is_a_flat():
    x = np.linspace(-1.0, 1.0, POINTS)
    np.save("scan.npy", -(x[:, None] ** 2) - x**2)
    for role, is_flat in (("substrate", True), ("indenter", False)):
        text = SCENE.replace('substrate"\n', f'{role}"\ndetrend = "none"\n')
        scene = Scene.parse(text.replace("periodic = true", ""))
        assert scene.is_flat is is_flat


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("radius = inf", 'radius = "1 um"', "unit of loads 'MPa'"),
        ("hardness", "shape = [80, 8], hardness", "at most 64 x 8"),
    ],
)
def test_what_does_not_fit_a_flat_is_an_error(wave, old, new, message):
    with pytest.raises(ValueError, match=message):
        Scene.parse(SCENE.replace(old, new)).check()
