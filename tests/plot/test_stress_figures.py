"""Figures of the stress below a contact, drawn from functions and by the command."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from ase_roughcontact import plot
from ase_roughcontact.analysis import ContactMap, stress_planes, stress_section
from ase_roughcontact.cli import main
from ase_roughcontact.elasticity import Isotropic

SOLID = Isotropic(0.9, 0.3)
GPA = 0.00624150907  # eV/Å^3


@pytest.fixture
def axes():
    return Figure().subplots()


def hertz_map(a=100.0):
    x = 10.0 * np.arange(-20.0, 21.0)
    pressure = 0.05 * np.sqrt(np.maximum(1.0 - (x[:, None] ** 2 + x**2) / a**2, 0.0))
    return ContactMap(pressure, pressure > 0, 10.0, (-200.0, -200.0), periodic=False)


def test_section_has_its_largest_stress_marked_below_the_pressure(axes):
    section = stress_section(hertz_map(), SOLID)
    contours = plot.plot_stress_section(axes, section, yield_strength=0.02)
    largest = 0.62 * 0.05 / GPA
    assert contours.levels[-1] >= largest > contours.levels[-2]
    (x,), (z,) = axes.lines[0].get_data()
    assert abs(x) < 1.1 and z == pytest.approx(-4.8, abs=0.5)
    bottom, top = axes.get_ylim()
    assert bottom == pytest.approx(-20.0, rel=0.02) and top > 0.0
    assert max(axes.get_yticks()) <= 0.0


def test_map_has_the_largest_stress_of_the_plane(axes):
    seen = hertz_map()
    (plane,) = stress_planes(seen, SOLID, [48.0])
    image = plot.plot_stress_map(axes, plane, seen)
    assert image.get_array().max() == pytest.approx(0.62 * 0.05 / GPA, rel=0.01)
    assert axes.get_title() == "depth 4.8 nm"


def test_stress_over_depth_is_on_the_axis_of_a_sphere(axes):
    plot.plot_stress_over_depth(axes, stress_section(hertz_map(), SOLID))
    lines = {line.get_label(): line.get_data() for line in axes.lines}
    stress, depth = lines["von Mises"]
    assert depth[stress.argmax()] == pytest.approx(4.8, abs=0.5)
    pressure = lines[r"$-\sigma_{zz}$"][0]
    assert pressure == pytest.approx(0.05 / GPA / (1 + (depth / 10) ** 2), rel=0.02)


SCENE = """
[substrate]
contact_modulus = 100.0
poisson = 0.3
hardness = inf
shape = [32, 32]
[sphere]
radius = 400.0
[interaction]
kind = "hard"
[path]
values = [20.0]
"""


@pytest.mark.parametrize("asked", [True, False])
def test_run_draws_the_stress_if_it_is_asked_for(asked, tmp_path, capsys):
    text = SCENE + '[output]\ncolumns = ["von_mises_depth"]\n' if asked else SCENE
    (tmp_path / "scene.toml").write_text(text)
    out = tmp_path / "out"
    assert main(["run", str(tmp_path / "scene.toml"), "--out", str(out)]) == 0
    assert ("stress.png" in capsys.readouterr().out) == asked
    assert (out / "stress.png").exists() == asked
