"""Figures: what is drawn, in which units, into the axes that are given."""

import numpy as np
import pytest
from ase.units import GPa, J, m

mpl = pytest.importorskip("matplotlib")
mpl.use("Agg")

from built import atoms_under  # noqa: E402
from matplotlib.colors import to_rgb  # noqa: E402
from matplotlib.figure import Figure  # noqa: E402

import ase_roughcontact as rc  # noqa: E402
from ase_roughcontact import plot  # noqa: E402
from ase_roughcontact.analysis import ContactMap  # noqa: E402
from ase_roughcontact.elasticity import Creep, fit_relaxation  # noqa: E402
from ase_roughcontact.results.flat_record import FlatStep  # noqa: E402
from ase_roughcontact.theory import JKR, Hertz  # noqa: E402

NANONEWTON = 1e-9 * J / m
RADIUS, MODULUS, SPACING = 400.0, 0.9, 2.5


@pytest.fixture
def axes():
    return Figure().subplots()


@pytest.fixture(scope="module")
def sphere_contact():
    """Smooth sphere on a hard wall."""
    sphere = rc.RoughSphere(RADIUS)
    atoms = atoms_under(
        sphere, rc.HardWall(), (24, 24), modulus=MODULUS, spacing=SPACING, height=-1.0
    )
    rc.ActiveSet(atoms, logfile=None).run(fmax=1e-7)
    return atoms


@pytest.fixture(scope="module")
def loop():
    sphere = rc.RoughSphere(30.0)
    wall = rc.LennardJones93.adhesive(1.0, 1.0, 0.05)
    atoms = atoms_under(sphere, wall, (16, 16))
    return rc.adhesion_loop(atoms, deepest=1.0, step=0.2, window="auto", tolerance=0.01)


def line(axes, label):
    """Coordinates of a line by its label."""
    (found,) = [each for each in axes.lines if each.get_label() == label]
    return found.get_data()


def test_all_axes_tell_quantity_and_unit(sphere_contact, loop, tmp_path):
    with plot.style():
        figure = Figure(figsize=(6.8, 5.2))
        one, two, three, four, five, six = figure.subplots(2, 3).flat
        load = np.geomspace(1, 10, 4)
        plot.plot_curve(one, load, load, 2 * load)
        plot.plot_contact(two, rc.snapshot(sphere_contact), 20.0)
        plot.plot_pressure(three, ContactMap.from_atoms(sphere_contact), 20.0)
        plot.plot_loop(four, loop, {"JKR": -1.0})
        plot.plot_force(five, [1.0, 2.0], [-1.0, 1.0], pull_off_force=2.0)
        plot.plot_convergence(six, {"one": ([1, 2], [1.0, 0.1])})
        figure.savefig(tmp_path / "figure.pdf")
    assert (tmp_path / "figure.pdf").stat().st_size > 10_000
    without = r"contact area $A/A_\mathrm{Hertz}$", "steps of the optimizer"
    for axes in figure.axes:
        for text in (axes.get_xlabel(), axes.get_ylabel()):
            assert text.endswith(")") or text in without


def test_force_shows_tension_on_a_linear_axis_beside_the_laws(axes):
    force = np.array([0.0, -2.0, 3.0]) * NANONEWTON
    theory = {"JKR": ([0.0, 1.0], [-NANONEWTON, 500.0 * NANONEWTON])}
    assert (
        plot.plot_force(axes, [-1.0, 0.0, 1.0], force, theory, 4.0 * NANONEWTON) is axes
    )
    np.testing.assert_allclose(line(axes, "simulation")[1], [0.0, -2.0, 3.0])
    np.testing.assert_allclose(line(axes, "JKR")[1], [-1.0, 500.0])
    np.testing.assert_allclose(line(axes, "pull-off, theory")[1], -4.0)
    assert axes.get_yscale() == "linear"
    low, high = axes.get_ylim()
    assert -5.0 < low < -4.0 and 3.0 < high < 4.0


def test_a_theory_outside_of_the_axes_is_not_in_the_legend(axes):
    theory = {"DMT": ([0.0, 1.0], [-9.0, -8.0]), "JKR": ([0.0, 1.0], [2.0, 3.0])}
    plot.plot_force(axes, [0.0, 1.0], [1.0, 3.0], theory)
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert labels == ["JKR", "simulation"]


def test_steps_that_did_not_converge_are_crossed_and_no_line_leads_to_them(axes):
    force = np.array([5.0, 9.0, -1.0, -2.0]) * NANONEWTON
    ok = [True, False, True, True]
    plot.plot_force(axes, [2.0, 1.5, 1.0, 0.0], force, converged=ok)
    np.testing.assert_allclose(line(axes, "not converged"), [[1.5], [9.0]])
    np.testing.assert_allclose(line(axes, "simulation")[1], [5.0, np.nan, -1.0, -2.0])


def test_areas_have_bars_of_twice_their_errors_and_crosses_if_not_converged(axes):
    load = np.array([1.0, 2.0, 3.0])
    errors = {"converged": [True, False, True], "area_error": [0.1, 0.2, 0.0]}
    plot.plot_curve(axes, load, 2.0 * load, load, **errors)
    assert list(line(axes, "simulation")[0]) == [1.0, 3.0]
    assert [list(x) for x in line(axes, "not converged")] == [[2.0], [2.0]]
    (bars,) = axes.collections
    ends = np.array([path.vertices[:, 1] for path in bars.get_paths()])
    np.testing.assert_allclose(ends, [[1.8, 2.2], [1.8, 2.2], [2.0, 2.0]])


def test_atoms_that_are_attracted_are_shown_beside_those_in_contact(axes):
    sphere = rc.RoughSphere(30.0)
    wall = rc.LennardJones93.adhesive(1.0, 1.0, 0.05)
    atoms = atoms_under(sphere, wall, (16, 16))
    plot.plot_contact(axes, rc.snapshot(atoms))
    state = atoms.calc.state(atoms)
    grey = axes.images[1].get_array()
    assert grey.count() == state.attractive_atoms > 0


def test_error_bars_of_forces_and_depths_are_twice_the_errors(axes):
    plot.plot_force(
        axes,
        [1.0, 2.0],
        np.array([1.0, 5.0]) * NANONEWTON,
        depth_error=[0.1, 0.2],
        force_error=np.array([0.5, 0.0]) * NANONEWTON,
    )
    depths, forces = (bars.get_segments() for bars in axes.containers[0].lines[2])
    np.testing.assert_allclose(depths[1], [[1.6, 5.0], [2.4, 5.0]])
    np.testing.assert_allclose(forces[0], [[1.0, 0.0], [1.0, 2.0]])


def test_a_path_in_and_out_is_drawn_as_two(axes):
    plot.plot_force(axes, [0.0, 1.0, 0.0, -1.0], [0.0, 5.0, -1.0, 0.0])
    assert list(line(axes, "approach")[0]) == [0.0, 1.0]
    assert list(line(axes, "retraction")[0]) == [1.0, 0.0, -1.0]


def test_x_is_drawn_to_the_right_and_y_upwards(axes):
    heights = np.ones((8, 12))
    heights[7, 2] = -0.1  # at x = 3 and y = -4 spacings from the axis
    indenter = rc.HeightMap(heights, SPACING)
    atoms = atoms_under(
        indenter, rc.HardWall(), (8, 12), modulus=MODULUS, spacing=SPACING, height=0.0
    )
    rc.ActiveSet(atoms, logfile=None).run(fmax=1e-7)
    image = plot.plot_contact(axes, rc.snapshot(atoms)).images[0]
    (row,), (column,) = np.nonzero(~np.ma.getmaskarray(image.get_array()))
    left, right, bottom, top = image.get_extent()
    x = left + (column + 0.5) / 8 * (right - left)
    y = bottom + (row + 0.5) / 12 * (top - bottom)
    assert (x, y) == pytest.approx((0.3 * SPACING, -0.4 * SPACING))
    assert image.origin == "lower"


def test_circles_of_hertz_and_of_first_contact_have_their_radii(axes, sphere_contact):
    frame = rc.snapshot(sphere_contact)
    plot.plot_contact(axes, frame, 20.0, first_contact_radius=50.0)
    hertz, first = (np.hypot(*each.get_data()) for each in axes.lines)
    np.testing.assert_allclose(hertz, 2.0)  # nm
    np.testing.assert_allclose(first, 5.0)
    assert axes.get_xlim()[1] > 5.0
    assert axes.lines[0].get_linestyle() != axes.lines[1].get_linestyle()
    _, labels = axes.get_legend_handles_labels()
    assert labels == ["smooth sphere (Hertz)", "first contact $a'$"]


def test_pressure_of_a_smooth_sphere_lies_on_hertz_s(axes, sphere_contact):
    seen = ContactMap.from_atoms(sphere_contact)
    hertz = Hertz(RADIUS, MODULUS)
    a = float(hertz.contact_radius(seen.normal_force))
    assert plot.plot_pressure(axes, seen, a) is axes
    r, drawn = line(axes, "smooth sphere (Hertz)")
    expected = hertz.pressure(10 * r[:-1], a)
    np.testing.assert_allclose(drawn[:-1] * GPa, expected, rtol=1e-6)
    r, found = line(axes, "atoms in contact")
    within = r < 0.8 * a / 10
    assert within.sum() > 4
    np.testing.assert_allclose(
        found[within], np.interp(r[within], *line(axes, "smooth sphere (Hertz)")),
        rtol=0.02,
    )  # fmt: skip


def test_loop_shows_both_ways_jumps_and_theory(axes, loop):
    theory = JKR(30.0, 1.0, 0.05).pull_off_force
    assert plot.plot_loop(axes, loop, {"JKR": theory}) is axes
    depth, force = line(axes, "retraction")
    ends = loop.retraction[0].penetration, loop.retraction[-1].penetration
    assert depth[[0, -1]] == pytest.approx(ends) and ends[0] == 1.0
    assert axes.get_xlabel() == "depth (Å)"
    assert -force.min() * NANONEWTON == pytest.approx(loop.pull_off_force)
    assert line(axes, "JKR")[1][0] * NANONEWTON == pytest.approx(-theory)
    assert force.min() * NANONEWTON == pytest.approx(-theory, rel=0.35)  # towards DMT
    jumps = len(loop.approach_jumps) + len(loop.retraction_jumps)
    assert len(axes.texts) == jumps == 2


def test_convergence_leaves_errors_of_zero_out(axes):
    curves = {"a": ([1, 2, 3], [1.0, -0.1, 0.0]), "b": ([1, 5], [1.0, 1e-3])}
    assert plot.plot_convergence(axes, curves, "atoms", "error (%)") is axes
    assert [each.tolist() for each in line(axes, "a")] == [[1, 2], [1.0, 0.1]]
    assert axes.get_yscale() == "log"
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("atoms", "error (%)")
    with pytest.raises(ValueError, match=r"b: .*same length"):
        plot.plot_convergence(axes, {"b": ([1, 2], [1.0])})


def test_style_holds_within_its_context_only():
    before = mpl.rcParams["font.size"]
    with plot.style():
        assert Figure().get_size_inches()[0] == pytest.approx(86 / 25.4, abs=0.02)
        assert mpl.rcParams["font.size"] == 8
    assert mpl.rcParams["font.size"] == before


# Maps of linear sRGB, after Viénot, Brettel and Mollon (1999).
DICHROMACY = {
    "protanopia": [[0.112, 0.888, 0], [0.112, 0.888, 0], [0.004, -0.004, 1]],
    "deuteranopia": [[0.293, 0.707, 0], [0.293, 0.707, 0], [-0.022, 0.022, 1]],
}


@pytest.mark.parametrize("width, length", [(30.0, 10.0), (12.4, 2.0), (0.026, 0.01)])
def test_scale_bar_is_a_round_length_in_place_of_the_axes(axes, width, length):
    axes.set(xlim=(-width / 2, width / 2), ylim=(-width / 2, width / 2))
    plot.scale_bar(axes, "nm")
    (bar,) = axes.lines
    np.testing.assert_allclose(np.ptp(bar.get_xdata()), length)
    assert [text.get_text() for text in axes.texts] == [f"{length:g} nm"]
    assert max(bar.get_ydata()) < axes.get_ylim()[0]  # below the map
    assert not len(axes.get_xticks()) and not axes.get_xlabel()
    assert np.ptp(axes.get_xlim()) == pytest.approx(width)


@pytest.mark.parametrize("kind", DICHROMACY)
def test_colours_are_distinguished_without_red_or_green(kind):
    linear = np.array([to_rgb(colour) for colour in plot.COLOURS]) ** 2.2
    seen = np.clip(linear @ np.transpose(DICHROMACY[kind]), 0, 1) ** (1 / 2.2)
    apart = np.linalg.norm(seen[:, None] - seen, axis=-1)
    assert apart[np.triu_indices(len(seen), 1)].min() > 0.1


def test_measured_moduli_lie_on_the_series_that_they_were_made_of(axes):
    omega = np.logspace(-2, 3, 6)
    moduli = 5.0 * Creep.standard_solid(relaxed=0.1, time=1.0).modulus(omega)
    fit = fit_relaxation(omega, moduli.real, moduli.imag)
    plot.plot_moduli(axes, fit, omega, moduli.real, moduli.imag, unit="MPa")
    for measured, fitted in zip(axes.lines[::2], axes.lines[1::2], strict=True):
        x, y = fitted.get_data()
        found = np.exp(np.interp(np.log(omega), np.log(x), np.log(y)))
        assert found == pytest.approx(measured.get_ydata(), rel=0.01)
    assert axes.lines[0].get_ydata()[0] < axes.lines[0].get_ydata()[-1]  # storage grows
    assert axes.get_ylabel() == "modulus (MPa)"


def test_forces_that_are_equal_but_for_rounding_are_not_magnified(axes):
    force = 1.6 + 1e-12 * np.arange(4.0)  # eV/Å
    plot.plot_force(axes, [0.0, 1.0, 2.0, 3.0], force)
    low, high = axes.get_ylim()
    assert high - low > 0.1 * force.max()


def test_curves_take_steps_in_place_of_arrays():
    atoms = atoms_under(rc.RoughSphere(100.0), rc.HardWall(), (16, 16))
    steps = list(rc.load_path(atoms, penetrations=[0.1, 0.2], validity="ignore"))
    load = np.array([step.normal_force for step in steps]) / NANONEWTON
    areas = np.array([step.contact_area for step in steps])
    hertz = Hertz(100.0, 1.0).contact_area(load * NANONEWTON)
    cases = [
        (plot.plot_area, {}, load, areas / 100.0),
        (plot.plot_curve, {"hertz_area": hertz}, load, areas / hertz),
        (plot.plot_force, {}, [0.1, 0.2], load),
    ]
    for draw, options, x, y in cases:
        axes = Figure().subplots()
        assert draw(axes, steps, **options) is axes
        np.testing.assert_allclose(line(axes, "simulation"), [x, y])
        assert len(axes.containers) == 1  # error bars
        with pytest.raises(TypeError, match="needs steps, or"):
            draw(Figure().subplots(), x, **options)


def test_maps_are_drawn_from_atoms_frames_and_maps(sphere_contact):
    shown = sphere_contact, rc.snapshot(sphere_contact)
    shown = *shown, ContactMap.from_atoms(sphere_contact)
    maps = [plot.plot_contact(Figure().subplots(), each) for each in shown]
    for other in maps[1:]:
        found, expected = other.images[0].get_array(), maps[0].images[0].get_array()
        np.testing.assert_allclose(found, expected)
    rings = [plot.plot_pressure(Figure().subplots(), each) for each in shown]
    first = line(rings[0], "all atoms")
    for other in rings[1:]:
        np.testing.assert_allclose(line(other, "all atoms"), first)


def test_figures_of_flats_take_steps_in_place_of_arrays():
    rough = rc.SelfAffine(0.1, 0.8, 4.0, 16.0, domain=16.0)
    atoms = atoms_under(rough, rc.HardWall(), (16, 16), periodic=True)
    output = rc.Output(record=FlatStep, columns=["conductance"])
    path = rc.load_path(atoms, loads=[2.0, 5.0], output=output, validity="ignore")
    steps = list(path)
    load = np.array([step.normal_force for step in steps])
    area = np.array([step.contact_area for step in steps])
    pressure = load / 256.0 / (1e-3 * GPa)  # MPa
    axes = plot.plot_flat_area(Figure().subplots(), steps, scale=0.1)
    np.testing.assert_allclose(line(axes, "simulation"), [pressure, area / 256.0])
    axes = plot.plot_flat_gap(Figure().subplots(), steps)
    gaps = [step.mean_gap / 10.0 for step in steps]
    np.testing.assert_allclose(axes.lines[0].get_data(), [pressure, gaps])
    axes = plot.plot_flat_conductance(Figure().subplots(), steps, modulus=1.0)
    stiffness = [step.contact_stiffness * m**2 / J for step in steps]
    np.testing.assert_allclose(line(axes, "stiffness"), [pressure, stiffness])
    assert len(line(axes, "conductance")[0]) == 2
    for draw in (plot.plot_flat_area, plot.plot_flat_gap, plot.plot_flat_conductance):
        with pytest.raises(TypeError, match="needs"):
            draw(Figure().subplots(), pressure)
