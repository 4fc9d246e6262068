"""Columns of stresses on all kinds of paths are the stress of the relaxed atoms."""

import pytest
from built import atoms_under

import ase_roughcontact as rc
from ase_roughcontact.analysis import ContactMap, stress_field
from ase_roughcontact.elasticity import Isotropic, largest_stress
from ase_roughcontact.loading.trajectory import read_frames

SPHERE, SOLID = rc.RoughSphere(100.0), Isotropic(1.0, 0.3)
ADHESIVE = rc.LennardJones93.adhesive(1.0, 1.0, 0.02)
OUTPUT = rc.Output(columns=["largest_von_mises", "von_mises_depth", "largest_tension"])

pytestmark = pytest.mark.filterwarnings("ignore::ase_roughcontact.ValidityWarning")


def check(step, contact_map, solid=SOLID):
    """Compare the columns of a step with the stress below a map in double precision."""
    field = stress_field(contact_map, solid)
    expected, tension = (
        largest_stress(field, each) for each in ("von_mises", "tension")
    )
    assert step.largest_von_mises > 0.0
    assert step.largest_von_mises == pytest.approx(expected.value, rel=1e-4)
    assert step.von_mises_depth == pytest.approx(expected.depth, rel=1e-2)
    assert step.largest_tension == pytest.approx(tension.value, rel=1e-3)


@pytest.mark.parametrize("periodic", [True, False])
@pytest.mark.parametrize("depth", [2.5, 0.5])  # pressed, and pulled
def test_columns_under_a_soft_wall_with_adhesion(periodic, depth):
    atoms = atoms_under(SPHERE, ADHESIVE, (48, 48), solid=SOLID, periodic=periodic)
    (step,) = rc.load_path(atoms, penetrations=[depth], output=OUTPUT)
    assert (step.normal_force < 0.0) == (depth < 1.0)
    check(step, ContactMap.from_atoms(atoms))


def test_columns_under_a_wall_with_a_hardness():
    wall = rc.PlasticWall(0.02)
    atoms = atoms_under(SPHERE, wall, (48, 48), solid=SOLID)
    (step,) = rc.load_path(atoms, penetrations=[1.0], output=OUTPUT)
    seen = ContactMap.from_atoms(atoms)
    assert seen.pressure.max() == pytest.approx(0.02)
    check(step, seen)


def test_columns_in_time_on_a_viscoelastic_solid():
    solid = rc.Viscoelastic(SOLID, rc.Creep.standard_solid(relaxed=0.5, time=1.0))
    atoms = atoms_under(SPHERE, rc.HardWall(), (32, 32), solid=solid, periodic=True)
    dwell = rc.Schedule(0.0).step(0.4).hold(0.1)
    *_, step = rc.time_path(atoms, penetrations=dwell, tolerance=0.1, output=OUTPUT)
    assert step.time == 0.1
    check(step, ContactMap.from_atoms(atoms))  # the modulus does not matter


def test_columns_of_a_loop_to_the_largest_tension(tmp_path):
    sphere, wall = rc.RoughSphere(50.0), rc.LennardJones93.adhesive(1.0, 1.0, 0.005)
    atoms = atoms_under(sphere, wall, (20, 20), solid=SOLID, periodic=True)
    output = rc.Output(
        trajectory=tmp_path / "loop.traj", keep="all", columns=OUTPUT.columns
    )
    loop = rc.adhesion_loop(atoms, deepest=0.6, step=1.0, tolerance=0.1, output=output)
    pulled = min(loop.retraction, key=lambda step: step.normal_force)
    assert pulled.normal_force < 0.0
    frames = read_frames(tmp_path / "loop.traj")
    (frame,) = [f for f in frames if f.info["load_step"]["step"] == pulled.step]
    check(pulled, ContactMap.from_frame(frame, sphere))


def test_column_of_a_periodic_cell_is_the_column_of_one_contact_in_a_large_cell():
    found = []
    for n, periodic in ((40, False), (200, True)):
        atoms = atoms_under(
            SPHERE, rc.HardWall(), (n, n), solid=SOLID, periodic=periodic
        )
        (step,) = rc.load_path(atoms, penetrations=[0.5], output=OUTPUT)
        found.append(step.largest_von_mises / step.largest_pressure)
    assert found[1] == pytest.approx(found[0], rel=0.02)
