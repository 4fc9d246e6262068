"""The command draws stresses at given places, and a slider over depth in the report."""

import re
import shutil
import subprocess
from contextlib import contextmanager
from unittest.mock import patch

import numpy as np
import pytest
from ase.io import read
from command_cases import keep_figure
from matplotlib.figure import Figure
from PIL import Image

from ase_roughcontact.analysis import ContactMap, stress_planes, stress_section
from ase_roughcontact.cli import main
from ase_roughcontact.cli.stress_figures import depth_pictures
from ase_roughcontact.elasticity import Isotropic, von_mises
from ase_roughcontact.scene import Scene

GPA = 0.00624150907  # eV/Å^3
SCENE = """
[substrate]
contact_modulus = 100.0
poisson = 0.3
hardness = inf
shape = [32, 32]
[sphere]
radius = "100 nm"
[interaction]
kind = "hard"
[path]
values = [20.0]
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Function that returns the folder of a run with a scene."""
    folders = {}

    def folder_of(asked):
        if asked not in folders:
            folder = tmp_path_factory.mktemp("run")
            (folder / "scene.toml").write_text(SCENE + asked)
            out = folder / "out"
            assert main(["run", str(folder / "scene.toml"), "--out", str(out)]) == 0
            folders[asked] = out
        return folders[asked]

    return folder_of


FORCE = 20.0 * 0.624150907  # eV/Å
# Contact radius by Hertz (Å).
RADIUS = (0.75 * FORCE * 1000.0 / (100.0 * GPA)) ** (1.0 / 3.0)
GLASS = Isotropic(100.0 * GPA, 0.3)
ASKED = '[output]\ncolumns = ["von_mises_depth"]\n'


@pytest.mark.parametrize("asked", [ASKED, ""])
def test_run_draws_the_stress_if_it_is_asked_for(asked, run):
    assert (run(asked) / "stress.png").exists() == bool(asked)


def panels_of(folder, *options):
    """Panels of stress.png by the letter in their title."""
    figures = {}
    with patch.object(Figure, "savefig", keep_figure(figures)):
        assert main(["figure", str(folder), *options]) == 0
    axes = figures["stress.png"].axes
    return {title: each for each in axes if (title := each.get_title(loc="left"))}


def test_figure_has_the_stress_at_the_given_places(run):
    folder = run(ASKED)
    panels = panels_of(folder, "--along", "y", "--at", "2 Å", "--depth", "1")
    seen = ContactMap.from_frame(read(folder / "sweep.traj"))
    (plane,) = stress_planes(seen, GLASS, [10.0])
    section = stress_section(seen, GLASS, "y", at=2.0)
    above, below, line = (panels[name] for name in ("(a)", "(b)", "(c)"))
    assert above.get_xlabel() == "$y$ (nm)"
    assert above.figure.get_suptitle() == "20 nN, section at $x$ = $0.2$ nm"
    assert below.get_title() == "depth 1 nm"
    (image,) = below.get_images()
    np.testing.assert_allclose(image.get_array().T, von_mises(plane.stress) / GPA)
    stress = von_mises(section.stress) / GPA
    drawn = {each.get_label(): each.get_data() for each in line.lines}["von Mises"]
    expected = stress[:, stress.max(axis=0).argmax()], section.depth / 10.0
    np.testing.assert_allclose(drawn, expected)
    assert line.get_xlabel() == "stress (GPa)" and line.get_ylabel() == "depth (nm)"


def test_figure_contains_the_largest_stress_by_default(run):
    panels = panels_of(run(ASKED))
    (image,) = panels["(b)"].get_images()
    largest = 0.62 * 1.5 * FORCE / (np.pi * RADIUS**2) / GPA
    assert image.get_array().max() == pytest.approx(largest, rel=0.02)
    assert image.norm.boundaries[-1] >= image.get_array().max()


@pytest.mark.parametrize(
    ("asked", "options", "advice"),
    [
        (ASKED, ["--depth", "-1"], "--depth .* at least 0"),
        (ASKED, ["--depth", "1 kg"], "--depth"),
        (ASKED, ["--at", "1 mm"], "between"),
    ],
)
def test_places_that_have_no_stress_are_errors(asked, options, advice, run, capsys):
    assert main(["figure", str(run(asked)), *options]) == 2
    assert re.search(advice, capsys.readouterr().err)


def test_places_are_drawn_though_stresses_are_not_asked_for(run, tmp_path, capsys):
    folder = shutil.copytree(run(""), tmp_path / "out")
    assert panels_of(folder, "--along", "y")["(a)"].get_xlabel() == "$y$ (nm)"
    scene = folder / "scene.toml"
    scene.write_text(scene.read_text().replace("poisson = 0.3", ""))
    assert main(["figure", str(folder), "--along", "y"]) == 2
    assert "give poisson" in capsys.readouterr().err


@contextmanager
def saved_figures():
    """List of the figures that are saved, which are not drawn."""
    figures = []

    def saved(figure, file, **_):
        figures.append(figure)
        Image.new("RGB", (4, 4)).save(file, "PNG")

    with patch.object(Figure, "savefig", saved):
        yield figures


@pytest.fixture(scope="module")
def report(run):
    """Text of the page, and the figures on it."""
    with saved_figures() as figures:
        assert main(["report", str(run(ASKED))]) == 0
    return (run(ASKED) / "report.html").read_text(), figures


def test_report_has_no_figure_of_another_section(run, tmp_path):
    folder = shutil.copytree(run(""), tmp_path / "out")
    shutil.copy(run(ASKED) / "stress.png", folder)
    assert main(["report", str(folder)]) == 0
    page = (folder / "report.html").read_text()
    assert page.count("data:image/png") == 2  # curve.png and contact.png


def test_report_has_a_slider_over_pictures_at_all_depths(report):
    page, _ = report
    found = re.findall(r'data-depth="([\d.]+) nm([^"]*)" src="data:image/png;', page)
    depths = [float(depth) for depth, _ in found]
    assert depths == sorted(depths) and len(set(depths)) == len(depths) > 8
    assert f'<input type="range" min="0" max="{len(depths) - 1}">' in page
    (deepest,) = [float(depth) for depth, words in found if "largest" in words]
    assert deepest == pytest.approx(0.48 * RADIUS / 10.0, rel=0.05)
    assert page.count('class="shown"') == 1


def test_pictures_of_the_slider_have_the_stress_at_their_depths_on_one_scale(
    report, run
):
    _, figures = report
    seen = ContactMap.from_frame(read(run(ASKED) / "sweep.traj"))
    maps = [each.axes[0] for each in figures if "depth" in each.axes[0].get_title()]
    assert len(maps) > 8
    for axes in maps:
        _, depth, unit = axes.get_title().split()
        (plane,) = stress_planes(seen, GLASS, [10.0 * float(depth)])
        (image,) = axes.get_images()
        expected = von_mises(plane.stress).T / GPA
        np.testing.assert_allclose(image.get_array(), expected, rtol=0.02, atol=0.01)
        assert unit == "nm"
    assert len({image.norm.vmax for axes in maps for image in axes.get_images()}) == 1


@pytest.mark.parametrize("periodic", [True, False])
def test_pictures_of_many_points_have_the_stress_of_fewer(periodic):
    x, y = np.arange(-300.0, 300.0), np.arange(-12.0, 12.0)
    pressure = 0.05 * np.exp(-((x[:, None] / 60) ** 2) - (y / 5) ** 2)
    seen = ContactMap(pressure, pressure > 0.01, 1.0, (x[0], y[0]), periodic)
    with saved_figures() as figures:
        pictures = list(depth_pictures(Scene.parse(SCENE), seen))
    *_, last = pictures
    (image,) = figures[-1].axes[0].get_images()
    (plane,) = stress_planes(seen, GLASS, [10.0 * float(last.depth.split()[0])])
    full = von_mises(plane.stress) / GPA
    expected = full.reshape(300, 2, 12, 2).mean(axis=(1, 3))
    found = image.get_array().T
    np.testing.assert_allclose(found, expected, atol=0.02 * expected.max())
    np.testing.assert_allclose(image.get_extent(), [-30.05, 29.95, -1.25, 1.15])


CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")


@pytest.mark.slow
@pytest.mark.skipif(not CHROMIUM, reason="needs the browser Chromium")
def test_slider_shows_the_picture_of_its_depth(report, tmp_path):
    move = (
        "<script>const slider = document.querySelector('.depths input');"
        "slider.value = 3;"
        "slider.dispatchEvent(new Event('input'))</script>"
    )
    (tmp_path / "moved.html").write_text(report[0] + move)
    options = "--headless", "--no-sandbox", "--disable-gpu", "--dump-dom"
    page = (tmp_path / "moved.html").as_uri()
    shown = subprocess.run(
        [CHROMIUM, *options, page], capture_output=True, text=True, check=True
    ).stdout
    images = re.findall(r"<img[^>]*data-depth[^>]*>", shown)
    assert [n for n, each in enumerate(images) if 'class="shown"' in each] == [3]
    depth = re.search(r'data-depth="([^"]*)"', images[3])[1]
    assert f'aria-valuetext="{depth}"' in shown
