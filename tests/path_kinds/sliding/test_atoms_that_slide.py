"""Atoms after sliding paths: lateral displacements, frames, views and files."""

import numpy as np
import pytest
from ase.io import read, write
from ase.optimize import LBFGS
from ase.units import GPa
from built import atoms_under
from same_frames import assert_is_snapshot

from ase_roughcontact import (
    Coulomb,
    HardWall,
    LennardJones93,
    Output,
    RoughContact,
    RoughSphere,
    load_path,
    sliding_path,
)
from ase_roughcontact.analysis import ContactMap, write_map
from ase_roughcontact.analysis.view import SLIPS, with_columns, with_indenter
from ase_roughcontact.atoms.grid import SurfaceGrid
from ase_roughcontact.atoms.snapshot import TAG_SLIPPING, restore, snapshot
from ase_roughcontact.elasticity import Isotropic
from ase_roughcontact.loading.trajectory import read_frames

SPHERE, SOLID = RoughSphere(radius=200.0), Isotropic(0.8, poisson=0.3)
PATH = np.array([[0.0, 0.0], [0.1, 0.05], [0.15, 0.05], [0.05, 0.0]])


def calculator():
    return RoughContact(SPHERE, solid=SOLID, wall=HardWall())


def atoms_on(**options):
    wall, window = HardWall(), (32, 30)
    return atoms_under(SPHERE, wall, window, solid=SOLID, spacing=2.5, **options)


def slide(atoms, path=PATH, coefficient=0.3, **options):
    law = Coulomb(coefficient)
    return list(
        sliding_path(atoms, law, penetrations=1.0, displacements=path, **options)
    )


def test_atoms_that_stick_move_with_the_indenter():
    atoms = atoms_on()
    before = atoms.positions.copy()
    slide(atoms, PATH[:2], coefficient=1e3)
    moved = (atoms.positions - before)[:-1, :2]
    grid = SurfaceGrid.of(atoms)
    inside = moved[grid.in_window].reshape(32, 30, 2)
    contact = atoms.calc.get_property("contact", atoms)
    assert contact.any()
    assert inside[contact] == pytest.approx(np.tile(PATH[1], (contact.sum(), 1)))
    fields = ContactMap.from_atoms(atoms).lateral
    assert fields["displacement_x"][contact] == pytest.approx(PATH[1, 0])
    assert fields["displacement_y"][contact] == pytest.approx(PATH[1, 1])
    # those outside move less, in the same direction
    assert (inside[~contact, 0] > 0.0).all()
    assert inside[~contact, 0].max() < PATH[1, 0]
    assert (atoms.positions[-1, :2] == before[-1, :2]).all()


def test_the_indenter_has_the_lateral_force():
    atoms = atoms_on()
    last = slide(atoms)[-1]
    force = [last.lateral_force_x, last.lateral_force_y]
    assert atoms.calc.get_property("lateral_force", atoms) == pytest.approx(force)
    assert snapshot(atoms).info["lateral_force"] == pytest.approx(force)
    assert (atoms.get_forces(apply_constraint=False)[:, :2] == 0.0).all()
    assert (atoms_on().calc.get_property("lateral_force", atoms_on()) == 0.0).all()


def test_results_agree_with_the_last_step_after_an_optimizer_of_ase():
    atoms, wall = atoms_on(), LennardJones93.repulsive(0.8, 2.5)
    atoms.calc.set(wall=wall)
    last = slide(atoms, PATH[:3], optimizer=LBFGS, fmax=1e-3)[-1]
    force = [last.lateral_force_x, last.lateral_force_y]
    assert atoms.calc.get_property("lateral_force", atoms) == pytest.approx(force)


def test_a_surface_that_slid_can_be_loaded_again():
    slid, new = atoms_on(), atoms_on()
    slide(slid)
    (again,), (expected,) = (
        list(load_path(each, penetrations=[1.5])) for each in (slid, new)
    )
    assert again.normal_force == pytest.approx(expected.normal_force, rel=1e-6)
    assert SurfaceGrid.of(slid) == SurfaceGrid.of(new)
    list(load_path(slid, penetrations=[8.0], window="auto"))  # in another window
    assert SurfaceGrid.of(slid).window != (32, 30)


def test_a_missing_atom_is_noticed():
    atoms = atoms_on()
    slide(atoms)
    del atoms[3]
    with pytest.raises(ValueError, match="have slid, got"):
        SurfaceGrid.of(atoms)


@pytest.mark.parametrize("form", ["traj", "extxyz"])
def test_frames_carry_fields_and_continue_the_path(tmp_path, form):
    file, whole = tmp_path / "path.traj", atoms_on()
    steps = slide(whole, output=Output(trajectory=file))
    frame = read(file, index=2)
    if form != "traj":
        write(tmp_path / f"f.{form}", frame)
        frame = read(tmp_path / f"f.{form}")
    fields = ContactMap.from_frame(frame).lateral
    slips = fields["slipping"] > 0.0
    assert (frame.get_tags()[:-1].reshape(32, 30) == TAG_SLIPPING).sum() == slips.sum()
    assert 2.5**2 * slips.sum() == pytest.approx(steps[2].slip_area)
    force = 2.5**2 * fields["traction_x"].sum()
    assert force == pytest.approx(steps[2].lateral_force_x)
    # positions of sites do not depend on displacements
    start = ContactMap.from_frame(read(file, index=0))
    assert ContactMap.from_frame(frame).x == pytest.approx(start.x)
    for atoms in (frame, restore(frame, SOLID)):
        atoms.calc = calculator()
        last = slide(atoms, PATH[2:])[-1]
        found = [last.lateral_force_x, last.lateral_force_y]
        expected = [steps[3].lateral_force_x, steps[3].lateral_force_y]
        assert found == pytest.approx(expected, rel=1e-4)
        # x and y of extxyz have eight digits
        moved = atoms.positions[0] - whole.positions[0]
        assert moved[:2] == pytest.approx([0.0, 0.0], abs=1e-6)


def test_views_show_which_atoms_slip(tmp_path):
    atoms = atoms_on()
    last = slide(atoms)[-1]
    slipping = round(last.slip_area / 2.5**2)
    assert 0 < slipping < last.repulsive_atoms
    assert with_indenter(atoms).symbols.count(SLIPS) == slipping
    columns = with_columns(atoms)
    assert columns.arrays["slipping"].sum() == slipping
    seen = ContactMap.from_atoms(atoms)
    for key, unit in (("displacement_y", 1.0), ("traction_x", GPa)):
        expected = pytest.approx(seen.lateral[key].ravel() / unit)
        assert columns.arrays[key][:-1] == expected
    write_map(seen, tmp_path / "map.npz")
    fields = np.load(tmp_path / "map.npz")
    assert fields["slipping"].sum() == slipping
    assert fields["displacement_x"].max() == pytest.approx(
        seen.lateral["displacement_x"].max() / 10.0
    )


def test_frames_of_a_sliding_path_are_snapshots_of_its_atoms(tmp_path):
    atoms, output = atoms_on(), Output(trajectory=tmp_path / "a.traj")
    options = {"displacements": PATH, "coupling": "solved", "output": output}
    path = sliding_path(atoms, Coulomb(0.3), penetrations=1.0, **options)
    snapshots = [snapshot(atoms) for _ in path]
    frames = list(read_frames(output.trajectory))
    assert len(frames) == len(snapshots) == len(PATH)
    for frame, expected in zip(frames, snapshots, strict=True):
        assert_is_snapshot(frame, expected)
