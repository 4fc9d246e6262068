"""The substrate as ASE Atoms: built, checked, written, read back, restored."""

import ase.io
import numpy as np
import pytest
from ase.optimize import LBFGS
from ase.units import GPa

import ase_roughcontact as rc
from ase_roughcontact.atoms.grid import SurfaceGrid

SPHERE = rc.RoughSphere(radius=20.0)
MODULUS = 100 * GPa


def make_atoms(shape=(8, 6), **options):
    return rc.substrate("Cu", shape, SPHERE, **options)


def relaxed_atoms(**options):
    """Return atoms relaxed under an adhesive wall, some of them attracted."""
    atoms = make_atoms(height=2.0, **options)
    wall = rc.LennardJones93.adhesive(MODULUS, rc.fcc_spacing("Cu"), 0.05)
    atoms.calc = rc.RoughContact(SPHERE, MODULUS, wall)
    LBFGS(atoms, logfile=None).run(fmax=1e-5)
    return atoms


# Building


WAVES = rc.SelfAffine(0.1, 0.8, 4.0, 8.0, domain=16.0)
MAP = rc.HeightMap(np.cos(np.arange(16.0))[:, None] * np.ones(12), 1.0, periodic=True)


@pytest.mark.parametrize(
    "indenter, shape, period",
    [
        (WAVES, (16, 12), "16 x 16"),
        (rc.RoughSphere(np.inf, WAVES), (12, 16), "16 x 16"),
        (MAP, (16, 11), "16 x 12"),
    ],
)
def test_a_flat_indenter_of_another_period_than_the_cell_is_warned_of(
    indenter, shape, period
):
    message = f"{shape[0]} x {shape[1]} Å .* {period} Å.* shape of {period} spacings"
    with pytest.warns(UserWarning, match=message) as found:
        rc.substrate("Cu", shape, indenter, spacing=1.0, periodic=True)
    assert found[0].filename == __file__


@pytest.mark.parametrize(
    "indenter, shape, periodic",
    [
        (WAVES, (16, 16), True),
        (MAP, (16, 12), True),
        (MAP, (8, 8), False),
        (rc.RoughSphere(1e3, WAVES), (8, 8), True),  # may touch in the middle only
        (rc.HeightMap(np.zeros((16, 16)), 1.0), (8, 8), True),  # makes no such claim
    ],
)
def test_no_other_indenter_is_warned_of(indenter, shape, periodic):
    atoms = rc.substrate("Cu", shape, indenter, spacing=1.0, periodic=periodic)
    assert SurfaceGrid.of(atoms).window == shape


def test_spacing_agrees_with_the_100_surface():
    assert rc.fcc_spacing("Cu") == pytest.approx(3.61 / np.sqrt(2))
    assert rc.fcc_spacing("Si") == pytest.approx(5.43 / np.sqrt(2))
    assert SurfaceGrid.of(make_atoms()).spacing == pytest.approx(rc.fcc_spacing("Cu"))


@pytest.mark.parametrize("shape", [(8, 6), (7, 5), (1, 9), (9, 1), (1, 1)])
def test_grid_follows_from_the_atoms(shape, periodic):
    grid = SurfaceGrid.of(make_atoms(shape, periodic=periodic))
    assert grid.window == shape
    assert grid.periodic == periodic
    if periodic:
        assert grid.shape == shape
    else:
        assert all(2 * n - 1 <= N for N, n in zip(grid.shape, shape, strict=True))


def test_atoms_are_ordered_by_rows_along_y_with_the_indenter_last():
    atoms = make_atoms((4, 3), spacing=2.0, periodic=True)
    np.testing.assert_array_equal(atoms.positions[1, :2], (0.0, 2.0))
    np.testing.assert_array_equal(atoms.positions[3, :2], (2.0, 0.0))
    assert atoms.get_chemical_symbols() == ["Cu"] * 12 + ["X"]


def test_indenter_is_above_an_atom_at_the_height_of_one_spacing():
    atoms = make_atoms((7, 5), spacing=2.0)
    np.testing.assert_array_equal(atoms.positions[-1], (6.0, 4.0, 2.0))


def test_centre_moves_the_window_against_the_indenter():
    atoms = make_atoms((8, 6), spacing=2.0, center=(4.0, -2.0))
    assert SurfaceGrid.of(atoms).origin == (-4.0, -8.0)


def test_indenter_is_fixed_by_default_and_optionally_free():
    assert make_atoms().constraints[0].index.tolist() == [len(make_atoms()) - 1]
    assert not make_atoms(fixed=False).constraints


@pytest.mark.parametrize(
    "options, message",
    [
        ({"shape": (0, 4)}, "shape must be .*>= 1"),
        ({"shape": 4}, "shape must be"),
        ({"shape": (4.5, 4)}, "shape must be"),
        ({"spacing": 0.0}, "spacing must be .*> 0"),
        ({"spacing": -1.0}, "spacing must be .*> 0"),
        ({"spacing": np.nan}, "spacing must be .*> 0"),
        ({"height": np.nan}, "height must be a finite number"),
        ({"center": (np.inf, 0.0)}, "center_x must be a finite number"),
        ({"center": 3.0}, "center must be"),
        ({"symbol": "Fe"}, "surface of Fe"),
        ({"symbol": "Xx"}, "unknown chemical symbol 'Xx'"),
        ({"symbol": "Xx", "spacing": 1.0}, "unknown chemical symbol 'Xx'"),
        ({"symbol": "X", "spacing": 1.0}, "unknown chemical symbol 'X'"),
        ({"indenter": None}, "indenter must be a surface"),
    ],
)
def test_bad_arguments_are_refused(options, message):
    arguments = {"symbol": "Cu", "shape": (4, 4), "indenter": SPHERE, **options}
    with pytest.raises(ValueError, match=message):
        rc.substrate(**arguments)


# Checking


def moved(index):
    def move(atoms):
        atoms.positions[index, 1] += 0.1

    return move


def lose_the_last_row(atoms):
    rows, columns = SurfaceGrid.of(atoms).shape
    del atoms[(rows - 1) * columns : rows * columns]


def stretch_cell(atoms):
    atoms.cell[0, 0] *= 1.1


def skew_cell(atoms):
    atoms.cell[0, 1] = 1.0


@pytest.mark.parametrize(
    "spoil, message",
    [
        (lambda atoms: atoms.numbers.sort(), "must be the indenter"),
        (lambda atoms: atoms.pop(), "must be the indenter.* none have"),
        (lambda atoms: atoms.append("X"), "must be the indenter"),
        (lambda atoms: atoms.pop(10), "grid"),
        (moved(10), r"atom 10 .* by 0\.1"),
        (moved(0), r"atom 0 .* by 0\.1"),
        (lambda atoms: atoms.set_pbc((True, False, False)), r"pbc .*got \(True, False"),
        (lambda atoms: atoms.set_pbc(True), r"pbc must be .*got \(True, True, True\)"),
        (lose_the_last_row, "padding"),
        (skew_cell, "cell must be"),
        (stretch_cell, "whole numbers of spacings"),
        (lambda atoms: atoms.positions.fill(0.0), "grid with rows of"),
    ],
)
def test_broken_atoms_are_refused(periodic, spoil, message):
    atoms = make_atoms(periodic=periodic)
    spoil(atoms)
    with pytest.raises(ValueError, match=message):
        SurfaceGrid.of(atoms)


# Files


def test_snapshot_has_contact_as_tags_and_pressure_as_charges():
    atoms = relaxed_atoms()
    frame, state = rc.snapshot(atoms), atoms.calc.state(atoms)
    assert len(frame) == 8 * 6 + 1
    tags = frame.get_tags()
    assert tags[-1] == 0
    np.testing.assert_array_equal(tags[:-1] == 1, state.pressure.ravel() > 0)
    np.testing.assert_array_equal(tags[:-1] == 2, state.pressure.ravel() < 0)
    assert set(tags) == {0, 1, 2}
    pressure = frame.get_initial_charges()[:-1] * GPa
    np.testing.assert_allclose(pressure, state.pressure.ravel(), rtol=1e-14)


def test_restored_window_equals_the_window_of_an_unrelaxed_frame(rng):
    atoms = relaxed_atoms()
    atoms.positions[:-1, 2] += rng.normal(0.0, 0.1, len(atoms) - 1)
    frame = rc.snapshot(atoms)
    rebuilt = rc.restore(frame, MODULUS)
    window = rebuilt[np.append(SurfaceGrid.of(rebuilt).in_window, True)]
    np.testing.assert_allclose(window.positions, frame.positions, rtol=0, atol=1e-12)


@pytest.mark.parametrize("fixed", [True, False])
def test_restored_indenter_is_fixed_if_it_was(fixed):
    frame = rc.snapshot(relaxed_atoms(fixed=fixed))
    assert bool(rc.restore(frame, MODULUS).constraints) == fixed


def pressures_lost(frame, path):
    ase.io.write(path, frame)
    return ase.io.read(path)


def damaged(frame, path):
    text = frame.info["pressure"]
    frame.info["pressure"] = text[:20] + ("A" if text[20] != "A" else "B") + text[21:]
    return frame


def other_window(frame, path):
    frame.info["pressure"] = rc.snapshot(relaxed_atoms(shape=(7, 6))).info["pressure"]
    return frame


@pytest.mark.parametrize("change", [pressures_lost, damaged, other_window])
def test_frame_without_its_pressures_is_refused_with_advice(tmp_path, change):
    frame = change(rc.snapshot(relaxed_atoms()), tmp_path / "a.json")
    with pytest.raises(ValueError, match=r"no pressures.*data=frame\.info"):
        rc.pressure_of(frame)
    assert len(rc.restore(frame, MODULUS)) > len(frame)  # needs positions only
