"""Atoms that ASE itself writes, without `snapshot`, and reads.

The formats .traj, .json and .db lose what a surface keeps of earlier steps, and the
last two the name of the indenter: going on is an error then, and right otherwise.
"""

import numpy as np
import pytest
from ase.constraints import FixAtoms
from ase.io import Trajectory, read, write
from built import atoms_under

import ase_roughcontact as rc
from ase_roughcontact.elasticity import Isotropic

SPHERE = rc.RoughSphere(100.0)
SOLID = Isotropic(1.0, poisson=0.3)
VISCOELASTIC = rc.Viscoelastic(1.0, rc.Creep.standard_solid(relaxed=0.5, time=1.0))
PLASTIC = rc.PlasticWall(0.05, permanent=True)
LAW = rc.Coulomb(0.3)
FORMATS = ["traj", "json", "db", "extxyz"]


def hard(solid=None, wall=None):
    return atoms_under(SPHERE, wall or rc.HardWall(), (32, 32), solid=solid)


def press(atoms, depth):
    (step,) = rc.load_path(atoms, penetrations=[depth], validity="ignore")
    return step


def age(atoms, schedule):
    times = rc.time_path(atoms, penetrations=schedule, tolerance=0.5, validity="ignore")
    return list(times)[-1]


def slide(atoms, path):
    steps = rc.sliding_path(
        atoms, LAW, penetrations=0.8, displacements=path, validity="ignore"
    )
    return list(steps)[-1]


# How atoms are made, loaded, and followed further.
KINDS = {
    "plastic": (
        lambda: hard(wall=PLASTIC),
        lambda atoms: press(atoms, 1.0),
        lambda atoms: press(atoms, 0.7).normal_force,
    ),
    "creep": (
        lambda: hard(VISCOELASTIC),
        lambda atoms: age(atoms, rc.Schedule(0.0).ramp(1.0, time=1.0)),
        lambda atoms: age(atoms, rc.Schedule(1.0).hold(0.5)).normal_force,
    ),
    "slip": (
        lambda: hard(SOLID),
        lambda atoms: slide(atoms, [0.0, 0.02]),
        lambda atoms: slide(atoms, [0.02, 0.04]).lateral_force_x,
    ),
}


def reread(atoms, path, **options):
    write(path, atoms, **options)
    return read(path)


@pytest.fixture(scope="module", params=KINDS)
def kept(request):
    """Atoms with a surface that keeps something, and what follows from it."""
    make, load, follow = KINDS[request.param]
    atoms = make()
    load(atoms)
    again = atoms.copy()
    again.calc = make().calc
    return atoms, make, follow, follow(again)


@pytest.mark.parametrize("format", FORMATS)
@pytest.mark.parametrize("calculator", [True, False])
def test_atoms_without_their_memory_are_refused(tmp_path, kept, format, calculator):
    atoms, make, follow, expected = kept
    plain = atoms if calculator else atoms.copy()
    read_back = reread(plain, tmp_path / f"a.{format}")
    read_back.calc = make().calc
    if format == "extxyz":
        assert follow(read_back) == pytest.approx(expected, rel=1e-5)
        return
    for use in (follow, rc.snapshot, lambda a: a.get_potential_energy()):
        with pytest.raises(ValueError, match=r"snapshot\(atoms\)"):
            use(read_back)


@pytest.mark.parametrize("format", FORMATS)
def test_snapshots_have_the_memory_or_are_refused(tmp_path, kept, format):
    atoms, make, follow, expected = kept
    read_back = reread(rc.snapshot(atoms), tmp_path / f"a.{format}")
    solid = make().calc.parameters["solid"] or 1.0
    if format in ("json", "db"):  # not written with data=frame.info
        with pytest.raises(ValueError, match=r"data=frame\.info"):
            rc.restore(read_back, solid)
        return
    read_back = rc.restore(read_back, solid)
    read_back.calc = make().calc
    assert follow(read_back) == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("format", FORMATS)
def test_elastic_atoms_go_on_from_any_format(tmp_path, format, periodic):
    atoms = atoms_under(SPHERE, None, (16, 16), periodic=periodic)
    press(atoms, 0.3)
    read_back = reread(atoms, tmp_path / f"a.{format}")
    read_back.calc = atoms_under(SPHERE, None, (16, 16)).calc
    energy = atoms.get_potential_energy()
    assert read_back.get_potential_energy() == pytest.approx(energy, rel=1e-6)
    forces = [press(each, 0.2).normal_force for each in (atoms, read_back)]
    assert forces[0] == pytest.approx(forces[1], rel=1e-5)


@pytest.mark.parametrize("format", FORMATS)
def test_another_indenter_is_refused_after_any_format(tmp_path, format):
    atoms = atoms_under(SPHERE, None, (8, 8), height=-0.5)
    read_back = reread(atoms, tmp_path / f"a.{format}")
    other = rc.RoughSphere(90.0)
    read_back.calc = rc.RoughContact(other, 1.0)
    with pytest.raises(ValueError, match="built for"):
        read_back.get_potential_energy()
    read_back.info.pop("indenter", None)
    read_back.set_tags(0)  # on purpose
    expected = atoms_under(other, None, (8, 8), height=-0.5).get_potential_energy()
    assert read_back.get_potential_energy() == pytest.approx(expected)


def test_tags_of_users_are_not_taken_for_marks():
    atoms = atoms_under(SPHERE, None, (8, 8), height=-0.5)
    energy = atoms.get_potential_energy()
    for tag in (-1, 1, 6, 7, 1000):
        again = atoms_under(SPHERE, None, (8, 8), height=-0.5)
        again.set_tags(tag)
        assert again.get_potential_energy() == energy


def test_a_tag_of_the_indenter_alone_is_not_taken_for_a_frame():
    atoms = atoms_under(SPHERE, None, (8, 8), height=-0.5)
    energy = atoms.get_potential_energy()
    tagged = atoms_under(SPHERE, None, (8, 8), height=-0.5)
    tagged.set_tags([0] * (len(tagged) - 1) + [6])
    assert tagged.get_potential_energy() == energy
    tagged.set_tags(6)
    tagged.set_initial_charges([0.5] * len(tagged))
    assert tagged.get_potential_energy() == energy


# Atoms that stick


@pytest.fixture
def stuck():
    atoms = hard(SOLID)
    press(atoms, 0.8)
    rc.stick(atoms, rc.Tresca(0.5)).move(atoms, (0.002, 0.0))
    return atoms


@pytest.mark.parametrize("format", FORMATS)
def test_atoms_that_stick_can_be_written_but_not_continued(tmp_path, stuck, format):
    stuck.get_potential_energy()
    read_back = reread(stuck, tmp_path / f"a.{format}")
    last = len(stuck) - 1
    fixed = [c for c in read_back.constraints if isinstance(c, FixAtoms)]
    assert [c.index.tolist() for c in fixed] == [[last]]
    np.testing.assert_allclose(read_back.positions, stuck.positions, atol=1e-7)
    read_back.calc = rc.RoughContact(SPHERE, solid=SOLID, wall=rc.HardWall())
    with pytest.raises(ValueError, match=r"snapshot\(atoms\)"):
        read_back.get_forces()


def test_a_trajectory_of_an_optimizer_has_the_fixed_indenter(tmp_path, stuck):
    with Trajectory(tmp_path / "a.traj", "w", stuck) as file:
        file.write()
    (frame,) = read(tmp_path / "a.traj", ":")
    force = np.ones((len(frame), 3))
    for constraint in frame.constraints:
        constraint.adjust_forces(frame, force)
    assert not force[-1].any()
