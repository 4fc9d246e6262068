"""Frames for viewers: the indenter as atoms, thinned, centred, with columns."""

import numpy as np
import pytest
from ase.io import read, write
from ase.units import GPa

from ase_roughcontact import (
    LennardJones93,
    NewtonKrylov,
    RoughContact,
    RoughSphere,
    SelfAffine,
    load_path,
    snapshot,
    substrate,
)
from ase_roughcontact.atoms.view import (
    TAG_INDENTER,
    centred,
    thinned,
    with_columns,
    with_indenter,
)

SPHERE = RoughSphere(20.0, SelfAffine(0.1, 0.8, 4.0, 8.0, seed=2))
LARGE = RoughSphere(1000.0, SelfAffine(0.1, 0.8, 4.0, 128.0, seed=1))
MODULUS = 0.9


def relaxed(periodic=False, shape=(9, 8)):
    """Atoms of unit spacing under a rough adhesive sphere."""
    wall = LennardJones93.adhesive(MODULUS, 1.0, 0.02)
    atoms = substrate("Cu", shape, SPHERE, spacing=1.0, periodic=periodic)
    atoms.calc = RoughContact(SPHERE, MODULUS, wall)
    atoms.positions[-1, 2] -= 0.3
    NewtonKrylov(atoms, logfile=None).run(fmax=1e-6)
    return atoms


@pytest.fixture
def automatic(tmp_path):
    """First frame of a path with automatic windows."""
    atoms = substrate("Cu", (8, 8), LARGE, spacing=1.0, fixed=False)
    atoms.calc = RoughContact(LARGE, MODULUS)
    movie = tmp_path / "sweep.traj"
    list(load_path(atoms, loads=[0.01], window="auto", trajectory=movie))
    return read(movie, 0)


def test_indenter_surface_is_above_every_atom_at_its_gap(periodic):
    atoms = relaxed(periodic)
    gap = atoms.calc.state(atoms).gap.ravel()
    shown = with_indenter(atoms)
    below, sphere = shown[:72], shown[shown.get_tags() == TAG_INDENTER]
    np.testing.assert_array_equal(sphere.positions[:, :2], below.positions[:, :2])
    height = sphere.positions[:, 2] - below.positions[:, 2]
    # in a periodic cell gaps count from the mean plane, and so does the picture
    np.testing.assert_allclose(height, gap, rtol=0, atol=1e-12)


def test_frame_from_a_file_shows_the_same_indenter(tmp_path):
    atoms = relaxed()
    snapshot(atoms).write(tmp_path / "frame.traj")
    shown = with_indenter(read(tmp_path / "frame.traj"), SPHERE)
    np.testing.assert_allclose(shown.positions, with_indenter(atoms).positions)


def test_indenter_surface_has_another_element_and_other_tags():
    atoms = relaxed()
    shown = with_indenter(atoms, symbol="Au")
    assert set(shown.symbols) == {"Cu", "X", "Au"}
    assert list(shown.get_tags()[:73]) == list(snapshot(atoms).get_tags())
    assert (shown.get_tags() == 1).sum() == atoms.calc.state(atoms).repulsive_atoms


def test_half_of_the_indenter_surface_can_be_left_out():
    shown = with_indenter(relaxed(), half=True)
    sphere = shown[shown.get_tags() == TAG_INDENTER]
    assert len(sphere) == 9 * 4
    assert sphere.positions[:, 1].min() == 4.0


def test_frames_of_automatic_windows_have_the_indenter_above_them(automatic):
    shown = with_indenter(automatic, LARGE)
    k = len(automatic) - 1
    gap = with_columns(automatic, LARGE).arrays["gap"][:-1]
    height = shown.positions[k + 1 :, 2] - shown.positions[:k, 2]
    np.testing.assert_allclose(height, gap, atol=1e-12)
    assert gap[automatic.get_tags()[:-1] == 1].max() < 1.0  # where the wall begins


def test_thinned_frame_has_every_second_row_at_scaled_positions():
    frame = snapshot(relaxed())
    shown = thinned(frame, 2)
    assert len(shown) == 5 * 4 + 1
    rows = frame.positions[:-1].reshape(9, 8, 3)[::2, ::2].reshape(-1, 3)
    np.testing.assert_allclose(2 * shown.positions[:-1], rows)
    np.testing.assert_allclose(2 * shown.positions[-1], frame.positions[-1])
    np.testing.assert_allclose(2 * shown.cell.array, frame.cell.array)
    assert shown.get_potential_energy() == frame.get_potential_energy()


def test_thinning_applies_to_the_indenter_surface():
    shown = with_indenter(relaxed(), every=3)
    assert (shown.get_tags() == TAG_INDENTER).sum() == 3 * 3


def test_thinned_frame_of_a_large_window_has_few_atoms():
    atoms = substrate("Cu", (512, 512), RoughSphere(1e4))
    atoms.calc = RoughContact(RoughSphere(1e4), MODULUS)
    assert len(with_indenter(atoms, every=8)) == 2 * 64 * 64 + 1


def test_centred_frames_have_the_axis_at_the_origin(automatic):
    for frame in (automatic, snapshot(relaxed()), with_indenter(relaxed())):
        moved = centred(frame)
        axis = moved.positions[moved.numbers == 0]
        np.testing.assert_allclose(axis[:, :2], 0.0, atol=1e-12)
        apart = moved.positions - frame.positions
        np.testing.assert_allclose(apart, apart[[0]].repeat(len(apart), 0), atol=1e-12)
        assert moved.get_potential_energy() == frame.get_potential_energy()


def test_columns_are_pressure_contact_and_gap():
    atoms = relaxed()
    state, columns = atoms.calc.state(atoms), with_columns(atoms)
    pressure = state.pressure.ravel() / GPa
    np.testing.assert_allclose(columns.arrays["pressure"], np.append(pressure, 0.0))
    assert columns.arrays["contact"].tolist() == [*state.contact.ravel(), 0]
    np.testing.assert_allclose(columns.arrays["gap"], np.append(state.gap.ravel(), 0.0))


def test_columns_are_named_in_an_extxyz_file(tmp_path):
    columns = with_columns(relaxed())
    write(tmp_path / "frame.extxyz", columns)
    header = (tmp_path / "frame.extxyz").read_text().splitlines()[1]
    assert "pressure:R:1:contact:I:1:gap:R:1" in header
    again = read(tmp_path / "frame.extxyz")
    for name in ("pressure", "contact", "gap"):
        np.testing.assert_allclose(again.arrays[name], columns.arrays[name], atol=1e-8)


def test_columns_of_a_frame_have_no_gap_without_its_indenter():
    assert "gap" not in with_columns(snapshot(relaxed())).arrays


def test_views_do_not_change_the_atoms():
    atoms = relaxed()
    before = atoms.positions.copy()
    for view in (with_indenter, with_columns, centred, lambda a: thinned(a, 2)):
        view(atoms)
    np.testing.assert_array_equal(atoms.positions, before)
    assert not atoms.get_tags().any() and set(atoms.arrays) <= {
        "numbers", "positions", "tags",
    }  # fmt: skip


def test_columns_do_not_change_the_frame():
    frame = snapshot(relaxed())
    with_columns(frame, SPHERE)
    assert "pressure" not in frame.arrays


@pytest.mark.parametrize(
    "look, message",
    [
        (lambda frame: with_indenter(frame), "give indenter="),
        (lambda frame: with_indenter(frame, 3.0), "indenter"),
        (lambda frame: with_indenter(frame, SPHERE, symbol="Xx"), "unknown.*'Xx'"),
        (lambda frame: with_indenter(frame, SPHERE, every=0), "every"),
        (lambda frame: thinned(frame, 1.5), "every"),
        (lambda frame: with_columns(frame, "sphere"), "indenter"),
    ],
)
def test_bad_arguments_are_refused(look, message):
    frame = snapshot(relaxed())
    with pytest.raises(ValueError, match=message):
        look(frame)
