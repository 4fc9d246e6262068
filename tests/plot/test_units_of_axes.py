"""Each axis of each figure is in the unit of its label.

What is drawn, times the unit in the label, are values in ASE's units.
"""

import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from built import atoms_under
from matplotlib.figure import Figure

import ase_roughcontact as rc
from ase_roughcontact import plot
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.analysis import ContactMap
from ase_roughcontact.elasticity.creep import Creep, RelaxationFit
from ase_roughcontact.fitting.figures import draw_fit
from ase_roughcontact.fitting.least_squares import Fit
from ase_roughcontact.path_kinds.loop.cantilever import (
    CantileverBranch,
    CantileverCurve,
    CantileverJump,
)
from ase_roughcontact.theory import KAPPA_HARD

RNG = np.random.default_rng(7)
COUNT = 5


def values(scale=1.0):
    return scale * RNG.uniform(1.0, 2.0, COUNT)


def unit_in(label):
    """Return the unit at the end of a label; 1 for a quantity without one."""
    found = re.search(r"\(([^()]*)\)$", label)
    units = UNITS | {"rad/s": 1.0}
    return units[found[1].replace("$^2$", "²")] if found else 1.0


def drawn(axes, name):
    """Return the points of a line by its label or number, in ASE's units."""
    lines = axes.get_lines()
    if isinstance(name, str):
        lines, name = [each for each in lines if each.get_label() == name], 0
    x, y = map(np.asarray, lines[name].get_data())
    return [x * unit_in(axes.get_xlabel()), y * unit_in(axes.get_ylabel())]


def bars(axes):
    """Return the ends of the vertical error bars in order, shape (k, 2)."""
    ends = [
        segment[:, 1] for each in axes.collections for segment in each.get_segments()
    ]
    return np.array(ends) * unit_in(axes.get_ylabel())


def on_the_right(axes, y):
    """Return values on the scale at the right of values on that at the left."""
    (scale,) = axes.child_axes
    forward, _ = scale._functions
    return forward(y) * unit_in(scale.get_ylabel().replace("\n", " "))


def axes_of(draw, *given, **options):
    axes = Figure().subplots()
    draw(axes, *given, **options)
    return axes


@pytest.fixture
def kept(monkeypatch):
    """Figures that are kept in place of being written."""
    figures = []

    def saved(figure, file, **_):
        figures.append(figure)
        Path(file).touch()

    monkeypatch.setattr(Figure, "savefig", saved)
    return figures


def steps_of(**columns):
    """Steps with these columns."""
    rows = zip(*columns.values(), strict=True)
    return [SimpleNamespace(**dict(zip(columns, row, strict=True))) for row in rows]


def columns_of(steps, *names):
    return [np.array([getattr(step, name) for step in steps]) for name in names]


SLIDING = steps_of(
    lateral_x=np.linspace(0.0, 4.0, COUNT),
    lateral_y=values(),
    lateral_force_x=values(),
    lateral_force_y=values(),
    largest_friction=values(2.0),
    stick_area=values(30.0),
    slip_area=values(20.0),
)
ALONG = [0.6, 0.8]  # of a path across the grid


def along(x, y):
    return ALONG[0] * x + ALONG[1] * y


def test_friction_loop():
    axes = axes_of(plot.plot_friction_loop, SLIDING, ALONG, bounds=True)
    names = "lateral_x", "lateral_y", "lateral_force_x", "lateral_force_y"
    x, y, force_x, force_y = columns_of(SLIDING, *names)
    (limit,) = columns_of(SLIDING, "largest_friction")
    path = along(x, y)
    for label, force in {
        "along the path": along(force_x, force_y),
        "across it": along(force_y, -force_x),
        "all slip": limit,
    }.items():
        np.testing.assert_allclose(drawn(axes, label), [path, force])


@pytest.mark.parametrize("name", ["stick", "slip"])
def test_areas_of_stick_and_slip(name):
    axes = axes_of(plot.plot_slip_areas, SLIDING, ALONG)
    x, y, area = columns_of(SLIDING, "lateral_x", "lateral_y", f"{name}_area")
    np.testing.assert_allclose(drawn(axes, name), [along(x, y), area])


def test_areas_over_the_distance_travelled_turn_where_the_path_turns():
    steps = steps_of(
        lateral_x=np.array([0.0, 10.0, 20.0, 10.0, 20.0]),
        lateral_y=np.zeros(COUNT),
        stick_area=values(30.0),
        slip_area=values(20.0),
    )
    axes = axes_of(plot.plot_slip_areas, steps, over_distance=True)
    distance = [0.0, 10.0, 20.0, 30.0, 40.0]
    for name in ("stick", "slip"):
        expected = [distance, *columns_of(steps, f"{name}_area")]
        np.testing.assert_allclose(drawn(axes, name), expected)
    turns = [drawn(axes, number)[0][0] for number in (0, 1)]
    assert turns == [20.0, 30.0]


TIMED = steps_of(
    time=np.arange(1.0, COUNT + 1.0),
    penetration=values(),
    base=values(),
    normal_force=values(),
    contact_area=values(30.0),
    continuum_area=values(30.0),
)


@pytest.mark.parametrize("column", ["normal_force", "contact_area", "continuum_area"])
@pytest.mark.parametrize("x", ["time", "penetration", "base"])
def test_columns_of_a_path_in_time(column, x):
    if x == "time":
        axes = axes_of(plot.plot_over_time, TIMED, column)
    else:
        axes = axes_of(plot.plot_over_depth, TIMED, column, along=x)
    np.testing.assert_allclose(drawn(axes, -1), columns_of(TIMED, x, column))


def test_theory_of_a_path_in_time():
    depth, force = values(), values()
    axes = axes_of(plot.plot_over_depth, TIMED, theory={"Hertz": (depth, force)})
    np.testing.assert_allclose(drawn(axes, "Hertz"), [depth, force])


@pytest.mark.parametrize("column", ["contact_area", "continuum_area"])
def test_areas_of_theory_of_a_path_in_time(column):
    depth, area = values(), values(30.0)
    theory = {"Hertz": (depth, area)}
    axes = axes_of(plot.plot_over_depth, TIMED, column, theory=theory)
    np.testing.assert_allclose(drawn(axes, "Hertz"), [depth, area])
    axes = axes_of(plot.plot_over_time, TIMED, column, theory={"Hertz": area})
    np.testing.assert_allclose(drawn(axes, "Hertz"), [*columns_of(TIMED, "time"), area])


def test_moduli_over_frequency():
    omega, storage, loss = np.geomspace(0.1, 10.0, COUNT), values(), values()
    creep = Creep.of_relaxation([0.5], [1.0])
    fit = RelaxationFit(3.0 * UNITS["MPa"], creep, 0.0)
    unit = {"unit": "MPa"}
    moduli = storage * UNITS["MPa"], loss * UNITS["MPa"]
    axes = axes_of(plot.plot_moduli, fit, omega, storage, loss, **unit)
    for label, modulus in zip(("storage", "loss"), moduli, strict=True):
        np.testing.assert_allclose(drawn(axes, label)[1], modulus)
    assert axes.get_xlabel() == "angular frequency (rad/s)"


def test_area_over_load():
    load, area, error = values(), values(30.0), values()
    nN, nm2 = UNITS["nN"], UNITS["nm²"]
    given = load / nN, area / nm2
    axes = axes_of(plot.plot_area, *given, {"law": given}, area_error=error / nm2)
    for label in ("simulation", "law"):
        np.testing.assert_allclose(drawn(axes, label), [load, area])
    expected = np.stack([area - 2.0 * error, area + 2.0 * error], axis=1)
    np.testing.assert_allclose(bars(axes), expected)
    relative = axes_of(plot.plot_curve, load / nN, area, area / 2.0, area_error=error)
    np.testing.assert_allclose(drawn(relative, "simulation"), [load, np.full(COUNT, 2)])


def test_force_over_depth():
    depth, force = np.arange(1.0, COUNT + 1.0), values()
    theory = {"law": (depth, force)}
    axes = axes_of(plot.plot_force, depth, force, theory, pull_off_force=0.3)
    for label in ("simulation", "law"):
        np.testing.assert_allclose(drawn(axes, label), [depth, force])
    np.testing.assert_allclose(drawn(axes, "pull-off, theory")[1], -0.3)


@pytest.fixture(scope="module")
def loop():
    wall = rc.LennardJones93.adhesive(1.0, 1.0, 0.05)
    atoms = atoms_under(rc.RoughSphere(30.0), wall, (16, 16))
    return rc.adhesion_loop(atoms, deepest=1.0, step=0.2, window="auto", tolerance=0.01)


def test_adhesion_loop(loop):
    axes = axes_of(plot.plot_loop, loop, {"JKR": 0.7})
    lines = axes.get_lines()
    ends = []
    for name in ("approach", "retraction"):
        steps = getattr(loop, name)
        expected = columns_of(steps, "penetration", "normal_force")
        curve = [line.get_label() for line in lines].index(name)
        np.testing.assert_allclose(drawn(axes, curve + 1), expected)
        x, y = drawn(axes, curve)
        for end in (0, -1):
            np.testing.assert_allclose((x[end], y[end]), np.transpose(expected)[end])
        force, error = columns_of(steps, "normal_force", "force_error")
        ends += [force - 2.0 * error, force + 2.0 * error]
    down, up = np.stack(ends[:2], axis=1), np.stack(ends[2:], axis=1)
    np.testing.assert_allclose(bars(axes), np.concatenate([down, up]))
    np.testing.assert_allclose(drawn(axes, "JKR")[1], -0.7)
    arrows = [each.xy for each in axes.texts] + [each.xyann for each in axes.texts]
    states = [step for jump in loop.jumps for step in (jump.after, jump.before)]
    tips = [(s.penetration, s.normal_force / UNITS["nN"]) for s in states]
    np.testing.assert_allclose(sorted(map(tuple, arrows)), sorted(tips))


def test_cantilever():
    distance, force, stiffness = values(), values(), 0.2
    jumps = (CantileverJump(2.0, 0.5, -1.5),)
    branch = CantileverBranch(distance, force, force / stiffness, jumps)
    axes = axes_of(plot.plot_cantilever, CantileverCurve(stiffness, branch, branch))
    for name in ("approach", "retraction"):
        np.testing.assert_allclose(drawn(axes, name), [distance, force])
    deflection = on_the_right(axes, force / UNITS["nN"])
    np.testing.assert_allclose(deflection, force / stiffness)
    np.testing.assert_allclose(axes.texts[0].xy, [0.2, -1.5 / UNITS["nN"]])


PRESSURE, MODULUS, SCALE = np.geomspace(1e-4, 1e-2, COUNT), 0.4, 0.05


def test_area_of_a_flat():
    part, error = values(0.01), values(1e-3)
    axes = axes_of(plot.plot_flat_area, PRESSURE, part, SCALE, error)
    np.testing.assert_allclose(drawn(axes, "simulation"), [PRESSURE, part])
    expected = np.stack([part - 2.0 * error, part + 2.0 * error], axis=1)
    np.testing.assert_allclose(bars(axes), expected)
    p, area = drawn(axes, 1)
    inside = area < 1.0
    np.testing.assert_allclose(area[inside], KAPPA_HARD * p[inside] / SCALE)


def test_gap_of_a_flat():
    gap = values()
    axes = axes_of(plot.plot_flat_gap, PRESSURE, gap)
    np.testing.assert_allclose(drawn(axes, 0), [PRESSURE, gap])


def test_stiffness_and_conductance_of_a_flat():
    stiffness, conductance = values(), values(5.0)
    given = PRESSURE, stiffness, MODULUS, conductance
    axes = axes_of(plot.plot_flat_conductance, *given)
    np.testing.assert_allclose(drawn(axes, "stiffness"), [PRESSURE, stiffness])
    line = axes.get_lines()[1].get_ydata()
    np.testing.assert_allclose(on_the_right(axes, line), conductance)


@pytest.fixture(scope="module")
def frame():
    """A contact with friction that slips in part, above atoms 2.5 Å apart."""
    sphere = rc.RoughSphere(300.0)
    solid = rc.elasticity.Isotropic(0.8, poisson=0.3)
    atoms = atoms_under(sphere, rc.HardWall(), (24, 20), solid=solid, spacing=2.5)
    path = rc.sliding_path(
        atoms,
        rc.Coulomb(0.3),
        penetrations=1.0,
        displacements=[0.0, 0.1],
        validity="ignore",
    )
    list(path)
    return rc.snapshot(atoms)


def assert_map(axes, image, expected, seen, unit):
    """Compare a map with values in ASE's units at the positions of the atoms."""
    nm, (left, right, bottom, top) = UNITS["nm"], image.get_extent()
    corner = seen.x[0] - 0.5 * seen.spacing, seen.y[0] - 0.5 * seen.spacing
    np.testing.assert_allclose([left * nm, bottom * nm], corner)
    sides = np.array([right - left, top - bottom]) * nm / seen.spacing
    np.testing.assert_allclose(sides, expected.shape)
    shown = np.ma.filled(image.get_array(), 0.0).T * UNITS[unit]
    np.testing.assert_allclose(shown, expected, atol=1e-12)


@pytest.mark.parametrize("unit", ["GPa", "MPa"])
def test_map_of_the_pressure(frame, unit):
    seen = ContactMap.from_frame(frame)
    axes = Figure().subplots()
    plot.plot_contact(axes, frame, 12.0, unit=unit, circle_label="circle")
    image = axes.images[0]
    assert_map(axes, image, np.where(seen.contact, seen.pressure, 0.0), seen, unit)
    np.testing.assert_allclose(np.hypot(*drawn(axes, "circle")), 12.0)


def test_small_pressures_have_more_colours_with_a_small_exponent(frame):
    for exponent in (1.0, 0.5):
        axes = Figure().subplots()
        image = plot.plot_contact(axes, frame, largest=4.0, exponent=exponent).images[
            -1
        ]
        assert image.norm(1.0) == pytest.approx(0.25**exponent)


def test_map_of_the_tractions(frame):
    seen = ContactMap.from_frame(frame)
    size = np.hypot(seen.lateral["traction_x"], seen.lateral["traction_y"])
    slips = seen.lateral["slipping"] > 0.0
    axes = Figure().subplots()
    images = plot.plot_tractions(axes, frame).images
    for image, part in zip(images, (seen.contact & ~slips, slips), strict=True):
        assert part.any()
        assert_map(axes, image, np.where(part, size, 0.0), seen, "GPa")


def test_scales_of_tractions_end_at_the_largest_one(frame, kept, tmp_path):
    plot.draw_tractions(tmp_path / "t.png", [frame], ["one"])
    panel, *scales = kept[0].axes
    lateral = ContactMap.from_frame(frame).lateral
    largest = np.hypot(lateral["traction_x"], lateral["traction_y"]).max()
    for scale, image in zip(scales, panel.get_images(), strict=True):
        assert image.norm.vmax * unit_in(scale.get_xlabel()) == pytest.approx(largest)


@pytest.mark.parametrize("count", [1, 2, 3])
def test_titles_of_tractions_are_inside_of_the_figure(count, frame, kept, tmp_path):
    title = "0.0375 nm, 9.06 nN"
    plot.draw_tractions(tmp_path / "t.png", [frame] * count, [title] * count)
    (figure,) = kept
    figure.draw_without_rendering()
    for panel in figure.axes[:count]:
        assert panel.get_title(loc="right") == title
        box = panel._right_title.get_window_extent()
        assert box.y1 <= figure.bbox.y1 and box.x0 >= figure.bbox.x0


def test_pressure_over_rings(frame):
    seen = ContactMap.from_frame(frame)
    axes = axes_of(plot.plot_pressure, seen, 12.0)
    radius, pressure = drawn(axes, "smooth sphere (Hertz)")
    assert radius[-1] == pytest.approx(12.0)
    force = 2.0 * np.pi * np.trapezoid(pressure * radius, radius)
    assert force == pytest.approx(seen.normal_force, rel=1e-3)
    radius, pressure = drawn(axes, "all atoms")
    force = 2.0 * np.pi * np.trapezoid(pressure * radius, radius)
    assert force == pytest.approx(seen.normal_force, rel=0.05)


@pytest.mark.parametrize("unit", ["nm", "s"])
def test_fit_and_residuals(unit, kept, tmp_path):
    distance, force, fitted = values(), values(), values()
    fit = Fit(
        *((), (), np.zeros(0), np.zeros(0), {}, np.zeros((0, 0))),
        distance=distance,
        force=force,
        fitted=fitted,
        compared=np.array([True, False, True, True, True]),
        noise=1.0,
        converged=True,
        far_force=0.0,
        abscissa=("time" if unit == "s" else "distance", unit),
    )
    draw_fit(fit, None, tmp_path / "f.png")
    upper, lower = kept[0].axes  # without tension, two panels
    part = fit.compared
    points = drawn(upper, "measured")
    np.testing.assert_allclose(points, [distance[part], force[part]])
    hollow = drawn(upper, "measured at a jump, not compared")
    np.testing.assert_allclose(hollow, [distance[~part], force[~part]])
    np.testing.assert_allclose(drawn(upper, "fit"), [distance, fitted])
    expected = [distance[part], (fitted - force)[part]]
    np.testing.assert_allclose(drawn(lower, 0), expected)


@pytest.mark.parametrize("tension", [0.0, 0.5])
def test_contact_fills_the_figure_of_a_fit_and_tension_has_a_panel(
    tension, kept, tmp_path
):
    distance = np.linspace(0.0, 1e4, 2001)  # Å; the contact ends at 100 Å
    force = np.where(distance < 100.0, 2.0 - distance / 30.0, 0.0).clip(min=-tension)
    fit = Fit(
        *((), (), np.zeros(0), np.zeros(0), {}, np.zeros((0, 0))),
        distance=distance,
        force=force,
        fitted=force,
        compared=np.ones(distance.size, bool),
        noise=0.01,
        converged=True,
        far_force=0.0,
    )
    draw_fit(fit, None, tmp_path / "f.png")
    upper, lower, *details = kept[0].axes
    end = 95.0 if tension else 55.0  # a step, or less than the noise, before
    for axes in (upper, lower):
        left, right = np.array(axes.get_xlim()) * unit_in(axes.get_xlabel())
        assert left < 0.0 and end < right < 130.0
    assert len(details) == bool(tension)
