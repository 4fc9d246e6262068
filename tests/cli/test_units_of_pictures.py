"""Figures of a run show the values of ``curve.csv`` and ``sweep.traj``.

The figures are inspected instead of being saved.
"""

import re

import numpy as np
import pytest
from command_cases import MODULUS, RADIUS, WORK, hertz_area, keep_figure
from matplotlib.figure import Figure

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.cli import main

NN, GPA, NM = UNITS["nN"], UNITS["GPa"], UNITS["nm"]


def points(axes, label):
    """Return the points of all lines with a label, in order."""
    lines = [line for line in axes.get_lines() if line.get_label().startswith(label)]
    assert lines, f"no line {label!r}"
    return np.concatenate([line.get_xydata() for line in lines])


def dmt_area(force):
    return hertz_area(force + 2.0 * np.pi * WORK * RADIUS)


def test_areas_are_relative_to_hertz_and_loads_in_nanonewton(case):
    upper, axes = case.figures["curve.png"].axes
    assert axes.get_xlabel().endswith("(nN)")
    force, area = case.column("normal_force"), case.column("contact_area")
    push = force > 0.0
    x, y = points(axes, "simulation").T
    np.testing.assert_allclose(x, force[push] / NN)
    np.testing.assert_allclose(y, (area / hertz_area(abs(force)))[push], rtol=1e-6)
    assert "nm" in upper.get_ylabel()
    x, y = points(upper, "simulation").T
    np.testing.assert_allclose(x, force[push] / NN)
    np.testing.assert_allclose(y, area[push] / NM**2)
    x, y = upper.get_lines()[0].get_data()
    np.testing.assert_allclose(y, hertz_area(x * NN) / NM**2, rtol=1e-6)


def test_simulated_areas_are_labelled_by_wall_and_grid(case):
    labels = [line.get_label() for line in case.figures["curve.png"].axes[0].lines]
    (label,) = [each for each in labels if each.startswith("simulation")]
    assert "wall" in label and "atoms, spacing 0.25 nm" in label


def test_lines_of_theory_are_in_the_units_of_the_axes(case):
    upper, axes = case.figures["curve.png"].axes
    if case.control != "height":
        assert not any("DMT" in line.get_label() for line in axes.get_lines())
        label = "Eq. (4)" if case.control == "load" else "simulation"
        x, y = points(upper, label).T
        relative = points(axes, label)[:, 1]
        np.testing.assert_allclose(y, relative * hertz_area(x * NN) / NM**2)
        return
    x, y = points(upper, "DMT").T
    np.testing.assert_allclose(y, dmt_area(x * NN) / NM**2, rtol=1e-6)
    x, y = points(axes, "DMT").T
    np.testing.assert_allclose(y, dmt_area(x * NN) / hertz_area(x * NN), rtol=1e-6)


def test_forces_are_drawn_against_the_controlled_quantity(case):
    control, figures = case.control, case.figures
    if control == "load":
        assert "force.png" not in figures
        return
    (axes,) = figures["force.png"].axes
    assert axes.get_xlabel().endswith("(Å)") and control in axes.get_xlabel()
    assert axes.get_ylabel().endswith("(nN)")
    expected = np.column_stack([case.column(control), case.column("normal_force") / NN])
    if control == "height":  # in, and out again from the deepest step
        found = [points(axes, way) for way in ("approach", "retraction")]
        np.testing.assert_allclose(found[0], expected[:2])
        np.testing.assert_allclose(found[1], expected[1:])
    else:
        np.testing.assert_allclose(points(axes, "simulation"), expected)


def test_forces_of_theory_are_those_at_the_drawn_depths(case):
    control, figures = case.control, case.figures
    if control == "load":
        assert figures.keys() == {"curve.png", "contact.png"}
        return
    (axes,) = figures["force.png"].axes
    name, work = ("DMT", WORK) if control == "height" else ("Hertz", 0.0)
    x, y = points(axes, name).T
    touch = (case.column("height") + case.column("penetration"))[0]
    depth = touch - x if control == "height" else x
    assert depth.min() >= -1e-9 and depth.max() > 1.0
    a = np.sqrt(RADIUS * depth.clip(0.0))
    force = 4.0 / 3.0 * MODULUS * a**3 / RADIUS - 2.0 * np.pi * work * RADIUS
    np.testing.assert_allclose(y, force / NN, rtol=1e-6, atol=1e-9)


def test_maps_show_the_pressure_in_gigapascal_at_the_positions_of_the_atoms(case):
    records, frames = case.records, case.frames
    *panels, bar = case.figures["contact.png"].axes
    assert bar.get_ylabel() == "pressure (GPa)"
    touching = [i for i, row in enumerate(records) if int(row["repulsive_atoms"])]
    assert len(panels) == len(touching)
    for panel, i in zip(panels, touching, strict=True):
        frame, image = frames[i], panel.get_images()[0]
        left, right, bottom, top = image.get_extent()
        shown = image.get_array()
        length, unit = panel.texts[-1].get_text().split()
        assert unit == "nm"
        assert np.ptp(panel.lines[-1].get_xdata()) == pytest.approx(float(length))
        cells = np.array([right - left, top - bottom]) * NM / 2.5
        np.testing.assert_allclose(cells, shown.shape[::-1])
        area = np.count_nonzero(~np.ma.getmaskarray(shown)) * 2.5**2
        assert area == pytest.approx(float(records[i]["contact_area"]))
        force = 2.5**2 * GPA * np.ma.sum(shown)
        pull = frame.get_initial_charges().clip(max=0.0).sum() * GPA * 2.5**2
        assert force + pull == pytest.approx(float(records[i]["normal_force"]))
        x = left * NM + frame.positions[-1, 0] - frame.positions[:, 0].min()
        assert x == pytest.approx(-0.5 * 2.5)


def test_circles_of_theory_have_the_radius_of_the_contact(case):
    control, records, figures = case.control, case.records, case.figures
    panels = figures["contact.png"].axes[:-1]
    for panel, record in zip(panels, records, strict=True):
        label = {"height": "Maugis"}.get(control, "Hertz")
        found = np.linalg.norm(points(panel, label), axis=1) * NM
        force = float(record["normal_force"])
        limits = hertz_area(max(force, 0.0)), dmt_area(force)
        if control == "height":
            jkr = 0.75 * RADIUS / MODULUS * 6.0 * np.pi * WORK * RADIUS
            assert 0.9 * np.sqrt(limits[1] / np.pi) < found[0] < 2.0 * np.cbrt(jkr)
        else:
            np.testing.assert_allclose(found, np.sqrt(limits[0] / np.pi), rtol=1e-6)


def test_titles_of_maps_state_force_and_target(case):
    control, records, figures = case.control, case.records, case.figures
    panels = figures["contact.png"].axes[:-1]
    assert len({panel.get_xlim() for panel in panels}) == 1
    for panel, record in zip(panels, records, strict=True):
        title = panel.get_title()
        force = float(re.search(r"(-?[0-9.]+) nN", title)[1])
        assert force == pytest.approx(float(record["normal_force"]) / NN, rel=6e-3)
        if control != "load":
            place = float(re.search(rf"{control} (-?[0-9.]+) Å", title)[1])
            assert place == pytest.approx(float(record[control]), rel=6e-3)
        way = {"0": "approach", "1": "approach", "2": "retraction"}[record["step"]]
        assert (way in title) == (control == "height")


@pytest.mark.parametrize("role", ["indenter", "substrate"])
def test_maps_on_a_scan_are_oriented_as_the_scan(role, tmp_path, monkeypatch):
    # a bump nearer to the first line and the last column of the scan
    x, y = np.meshgrid(np.arange(32.0), np.arange(30.0), indexing="ij")
    square = (x - 20.0) ** 2 + (y - 10.0) ** 2
    bump = -0.02 * square if role == "indenter" else np.exp(-square / 18.0)
    np.save(tmp_path / "scan.npy", bump)
    text = f"""
    substrate = {{ model = "atoms", contact_modulus = "5 MPa", hardness = inf }}
    sphere = {{ radius = inf }}
    [topography]
    file = "scan.npy"
    role = "{role}"
    spacing = "1 nm"
    unit = "nm"
    detrend = "none"
    [interaction]
    kind = "hard"
    [path]
    values = ["1e-4 nN"]
    """
    (tmp_path / "scene.toml").write_text(text)
    drawn = {}
    monkeypatch.setattr(Figure, "savefig", keep_figure(drawn))
    main(["run", str(tmp_path / "scene.toml"), "--out", str(tmp_path / "out")])
    panel, bar = drawn["contact.png"].axes
    assert bar.get_ylabel() == "pressure (kPa)"
    (left, right), (bottom, top) = panel.get_xlim(), panel.get_ylim()
    assert bottom > top and (left > right) == (role == "indenter")
    image = panel.get_images()[0]
    ends, shown = image.get_extent(), np.ma.filled(image.get_array(), 0.0)
    middle = [
        np.average(np.linspace(*ends[2 * k : 2 * k + 2], n), weights=shown.sum(axis=k))
        for k, n in enumerate(shown.shape[::-1])
    ]
    across, up = panel.transLimits.transform(middle)
    if role == "indenter":  # the circle and the map are around the contact
        np.testing.assert_allclose([across, up], 0.5, atol=0.05)
        circle = points(panel, "Hertz").mean(axis=0)
        np.testing.assert_allclose(circle, middle, atol=0.3)
    else:
        assert across == pytest.approx(20.5 / 32, abs=0.05)
        assert up == pytest.approx(1.0 - 10.5 / 30, abs=0.05)
