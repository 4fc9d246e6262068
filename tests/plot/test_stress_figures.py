"""Figures of the stress below a contact, drawn by functions."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from ase_roughcontact import plot
from ase_roughcontact.analysis import ContactMap, stress_planes, stress_section
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
    plot.plot_stress_section(axes, section, yield_strength=0.02)
    contours = axes.collections[0]
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
    image = plot.plot_stress_map(axes, plane, seen).images[0]
    assert image.get_array().max() == pytest.approx(0.62 * 0.05 / GPA, rel=0.01)
    assert axes.get_title() == "depth 4.8 nm"


def test_stress_over_depth_is_on_the_axis_of_a_sphere(axes):
    plot.plot_stress_over_depth(axes, stress_section(hertz_map(), SOLID))
    lines = {line.get_label(): line.get_data() for line in axes.lines}
    stress, depth = lines["von Mises"]
    assert depth[stress.argmax()] == pytest.approx(4.8, abs=0.5)
    pressure = lines[r"$-\sigma_{zz}$"][0]
    assert pressure == pytest.approx(0.05 / GPA / (1 + (depth / 10) ** 2), rel=0.02)


def test_map_and_line_show_the_yield_strength(axes):
    seen, strength = hertz_map(), 0.02
    (plane,) = stress_planes(seen, SOLID, [48.0])
    plot.plot_stress_map(axes, plane, seen, yield_strength=strength)
    _, limit = axes.collections
    assert limit.levels == pytest.approx([strength / GPA])
    line = Figure().subplots()
    section = stress_section(seen, SOLID)
    plot.plot_stress_over_depth(line, section, "MPa", yield_strength=strength)
    drawn = {each.get_label(): each.get_xdata() for each in line.lines}
    assert drawn["yield strength"][0] == pytest.approx(1e3 * strength / GPA)


def test_scale_ends_at_the_given_stress(axes):
    (plane,) = stress_planes(hertz_map(), SOLID, [48.0])
    image = plot.plot_stress_map(axes, plane, hertz_map(), largest=20.0).images[0]
    section = stress_section(hertz_map(), SOLID)
    other = plot.plot_stress_section(Figure().subplots(), section, largest=20.0)
    contours = other.collections[0]
    assert contours.levels[-1] == image.norm.boundaries[-1] == 20.0
