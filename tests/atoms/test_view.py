"""Frames for viewers: the indenter cut open, contact in colour, and columns."""

from pathlib import Path

import numpy as np
import pytest
from ase.data import covalent_radii
from ase.gui.images import Images
from ase.io import read, write
from ase.optimize import FIRE
from ase.units import GPa
from built import atoms_under

import ase_roughcontact as rc
from ase_roughcontact.analysis.view import (
    ATTRACTED,
    CONTACT,
    INDENTER,
    TAG_INDENTER,
    view_frames,
    with_columns,
    with_indenter,
)

SPHERE = rc.RoughSphere(20.0, rc.SelfAffine(0.1, 0.8, 4.0, 8.0, seed=2))
MODULUS = 0.9


def relaxed(periodic=False, shape=(9, 8)):
    """Atoms of unit spacing under a rough adhesive sphere."""
    wall = rc.LennardJones93.adhesive(MODULUS, 1.0, 0.02)
    atoms = atoms_under(SPHERE, wall, shape, modulus=MODULUS, periodic=periodic)
    atoms.positions[-1, 2] -= 0.3
    rc.NewtonKrylov(atoms, logfile=None).run(fmax=1e-6)
    return atoms


def read_all(file):
    return read(file, ":")


def split(shown):
    """Surface atoms, the indenter, and the atoms that show it."""
    (axis,) = np.flatnonzero(shown.numbers == 0)
    return shown[:axis], shown[axis], shown[axis + 1 :]


def scale_of(shown):
    info = shown.info
    return np.array([info["horizontal_scale"]] * 2 + [info["vertical_scale"]])


def test_distance_of_indenter_and_surface_is_the_gap(periodic):
    atoms = relaxed(periodic)
    gap = atoms.calc.state(atoms).gap
    below, _, body = split(with_indenter(atoms))
    assert set(body.get_tags()) == {TAG_INDENTER}
    below = (below.positions / scale_of(with_indenter(atoms))).reshape(9, 8, 3)
    body = body.positions / scale_of(with_indenter(atoms))
    for i, j in ((3, 5), (4, 6), (5, 5)):
        column = abs(body[:, :2] - below[i, j, :2]).max(1) < 1e-9
        # in a periodic cell gaps count from the mean plane, and so does the picture
        lowest = body[column, 2].min()
        np.testing.assert_allclose(lowest - below[i, j, 2], gap[i, j], atol=1e-12)


def test_surface_atoms_are_scaled_around_the_axis():
    frame = rc.snapshot(relaxed())
    shown = with_indenter(frame, SPHERE)
    below, axis, _ = split(shown)
    expected = frame.positions - frame.positions[-1] * [1, 1, 0]
    expected[:, 2] -= frame.positions[:-1, 2].min()
    scale = scale_of(shown)
    np.testing.assert_allclose(below.positions, expected[:-1] * scale, atol=1e-12)
    np.testing.assert_allclose(axis.position, expected[-1] * scale, atol=1e-12)
    assert not shown.pbc.any() and not shown.cell.array.any()


def test_ase_draws_no_graph_of_energies_over_a_view(tmp_path):
    atoms = relaxed()
    write(tmp_path / "view.traj", [with_indenter(atoms)] * 2)
    frames = read(tmp_path / "view.traj", ":")
    assert [frame.calc for frame in frames] == [None, None]
    # what `ase gui` draws if it is a number
    images = Images(frames)
    assert np.isnan(images.graph("i, e - E[-1]")[1]).all()


def test_contact_and_attracted_atoms_have_their_own_elements():
    atoms = relaxed(shape=(24, 24))
    below, _, body = split(with_indenter(atoms))
    pressure = atoms.calc.state(atoms).pressure.ravel()
    symbols = np.select([pressure > 0, pressure < 0], [CONTACT, ATTRACTED], "Cu")
    assert list(below.symbols) == list(symbols)
    assert set(symbols) == {CONTACT, ATTRACTED, "Cu"}
    assert set(body.symbols) == {INDENTER}
    assert list(below.get_tags()) == list(rc.snapshot(atoms).get_tags()[:-1])


def test_atoms_that_touch_under_tension_are_shown_in_contact():
    wall, options = rc.ExponentialWall(0.05, 0.5, 3.0), {"modulus": MODULUS}
    atoms = atoms_under(rc.RoughSphere(20.0), wall, (16, 16), height=-0.2, **options)
    rc.NewtonKrylov(atoms, logfile=None).run(fmax=1e-6)
    state = atoms.calc.state(atoms)
    assert (state.contact & (state.pressure < 0.0)).any()
    surface, _, _ = split(with_indenter(atoms))
    assert ((surface.symbols == CONTACT) == state.contact.ravel()).all()


def test_indenter_is_cut_behind_most_of_the_contact_and_closed():
    below, _, body = split(with_indenter(relaxed()))
    x, y, z = body.positions.T
    contact = below.positions[below.get_tags() == 1, 1]
    assert (contact < y.min()).sum() < 0.7 * len(contact) <= (contact <= y.min()).sum()
    cut = y == y.min()
    steps = np.diff(np.sort(z[cut & (x == x[cut].min())]))
    assert steps.max() < 1.0001 * np.diff(np.unique(below.positions[:, 0])).min()
    assert z.max() > np.ptp(x) / 4  # the dome


def test_heights_are_scaled_so_that_the_curvature_of_a_large_sphere_is_visible():
    sphere = rc.RoughSphere(5000.0)
    atoms = atoms_under(sphere, shape=(32, 32), modulus=MODULUS, height=0.0)
    shown = with_indenter(atoms)
    below, _, body = split(shown)
    assert shown.info["vertical_scale"] > 50 * shown.info["horizontal_scale"]
    width = np.ptp(below.positions[:, 0])
    x, _, z = body.positions.T
    lowest = [z[x == each].min() for each in np.unique(x)]
    assert 0.05 * width < np.ptp(lowest) < 0.3 * width


def test_large_windows_are_thinned():
    atoms = rc.substrate("Cu", (512, 300), rc.RoughSphere(1e4))
    atoms.calc = rc.RoughContact(rc.RoughSphere(1e4), MODULUS)
    below, _, body = split(with_indenter(atoms))
    assert len(below) == 47 * 27 and len(body) < 3000
    assert len(split(with_indenter(atoms, rows=8))[0]) == 8 * 5
    distance = np.diff(np.unique(below.positions[:, 0]))
    radius = covalent_radii[29]
    assert (distance < 2 * 0.89 * radius).all()  # circles of viewers overlap


def test_columns_are_pressure_contact_and_gap():
    atoms = relaxed()
    state, columns = atoms.calc.state(atoms), with_columns(atoms)
    pressure = state.pressure.ravel() / GPa
    np.testing.assert_allclose(columns.arrays["pressure"], np.append(pressure, 0.0))
    assert columns.arrays["contact"].tolist() == [*state.contact.ravel(), 0]
    np.testing.assert_allclose(columns.arrays["gap"], np.append(state.gap.ravel(), 0.0))


def test_columns_of_a_frame_have_no_gap_without_its_indenter(tmp_path):
    write(tmp_path / "a.traj", rc.snapshot(relaxed()))
    assert "gap" not in with_columns(read(tmp_path / "a.traj")).arrays


def test_frames_and_views_do_not_change_the_atoms():
    atoms = relaxed()
    before, tags = atoms.positions.copy(), atoms.get_tags()
    for view in (rc.snapshot, with_indenter, with_columns):
        view(atoms)
    np.testing.assert_array_equal(atoms.positions, before)
    np.testing.assert_array_equal(atoms.get_tags(), tags)
    assert set(atoms.arrays) <= {"numbers", "positions", "tags"}
    assert set(atoms.info) == {"indenter", "support"}


@pytest.mark.parametrize("form", [Path, str, read_all])
def test_a_trajectory_of_an_optimizer_of_ase_is_seen_as_its_states_are(tmp_path, form):
    atoms, file = relaxed(), tmp_path / "fire.traj"
    atoms.positions[-1, 2] -= 0.2
    FIRE(atoms, trajectory=str(file), logfile=None).run(fmax=0.0, steps=3)
    shown = view_frames(form(file), atoms.calc, rows=6)
    assert len(shown) == 4 and shown[0].info != shown[-1].info
    last = with_indenter(atoms, rows=6)
    assert shown[-1].symbols.count(CONTACT) > 0
    assert str(shown[-1].symbols) == str(last.symbols)
    assert shown[-1].info == last.info
    np.testing.assert_allclose(shown[-1].positions, last.positions, atol=1e-12)


def test_one_frame_and_chosen_frames_of_a_file_are_seen(tmp_path):
    atoms, file = relaxed(), tmp_path / "fire.traj"
    FIRE(atoms, trajectory=str(file), logfile=None).run(fmax=0.0, steps=4)
    every = view_frames(file, atoms.calc)
    chosen = view_frames(f"{file}@::2", atoms.calc)
    assert [each.info for each in chosen] == [each.info for each in every[::2]]
    (one,) = view_frames(read(file, -1), atoms.calc)
    assert one.info == every[-1].info


def test_a_trajectory_without_its_calculator_says_what_it_lacks(tmp_path):
    atoms, file = relaxed(), tmp_path / "fire.traj"
    write(file, atoms)
    with pytest.raises(ValueError, match="no pressures"):
        with_indenter(read(file), SPHERE)
    with pytest.raises(TypeError, match="calculator"):
        view_frames(file, SPHERE)
    other = rc.RoughContact(rc.RoughSphere(30.0), contact_modulus=MODULUS)
    with pytest.raises(ValueError, match="indenter"):
        view_frames(file, other)


@pytest.mark.parametrize(
    "look, message",
    [
        (lambda frame: with_indenter(frame), "give indenter="),
        (lambda frame: with_indenter(frame, 3.0), "indenter"),
        (lambda frame: with_indenter(frame, SPHERE, rows=1), "rows"),
        (lambda frame: with_columns(frame, "sphere"), "indenter"),
    ],
)
def test_bad_arguments_are_refused(look, message):
    frame = rc.snapshot(relaxed())
    with pytest.raises(ValueError, match=message):
        look(frame)
