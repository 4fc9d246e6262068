"""Atoms that stick to the indenter, relaxed by ASE's optimizers."""

import re

import numpy as np
import pytest
from ase.constraints import FixAtoms, FixCartesian, Hookean
from ase.io import read, write
from ase.optimize import FIRE, LBFGS, BFGSLineSearch
from built import atoms_under

from ase_roughcontact import (
    ActiveSet,
    Coulomb,
    FourierModes,
    HardWall,
    LennardJones93,
    NewtonKrylov,
    RoughContact,
    RoughSphere,
    Tresca,
    load_path,
    release,
    restore,
    sliding_path,
    snapshot,
    stick,
)
from ase_roughcontact.analysis import ContactMap
from ase_roughcontact.atoms.sticking import SlipError
from ase_roughcontact.elasticity import Cubic, Isotropic, Layer

SPHERE, LAW = RoughSphere(radius=200.0), Coulomb(10.0)
ISOTROPIC = Isotropic(0.8, poisson=0.3)
CUBIC = Cubic(1.1, 0.77, 0.47)
MOVE = np.array([0.008, 0.003])
LOOSE = "ignore::ase_roughcontact.ValidityWarning"


def atoms_on(shape=(16, 15), wall=None, solid=ISOTROPIC, **options):
    wall = wall or HardWall()
    return atoms_under(SPHERE, wall, shape, solid=solid, spacing=2.5, **options)


def pressed(depth=0.5, **options):
    atoms = atoms_on(**options)
    list(load_path(atoms, penetrations=[depth], fmax=1e-7, validity="ignore"))
    return atoms


def slid(path, law=LAW, depth=0.5, **options):
    """Return atoms after a sliding path, and its last step."""
    keys = ("bases", "spring", "coupling") if path is None else ("coupling",)
    moves = {key: options.pop(key) for key in keys if key in options}
    if path is not None:
        moves["displacements"] = path
    atoms = atoms_on(**options)
    steps = sliding_path(
        atoms, law, penetrations=depth, fmax=1e-7, validity="ignore", **moves
    )
    return atoms, list(steps)[-1]


def pulled(atoms, along, stiffness):
    """Constraints by which a spring pulls the indenter sideways."""
    last, start = len(atoms) - 1, atoms.positions[-1]
    spring = Hookean(last, start + np.array([*along, 0.0]), k=stiffness, rt=0.0)
    return [FixCartesian(last, (False, False, True)), spring]


def force_of(step):
    return [step.lateral_force_x, step.lateral_force_y]


@pytest.mark.parametrize("periodic", [False, True])
@pytest.mark.parametrize("wall", [HardWall(), LennardJones93.repulsive(0.8, 2.5)])
def test_forces_are_minus_the_gradient_of_the_energy(periodic, wall):
    atoms = pressed(wall=wall, periodic=periodic)
    sticking = stick(atoms, LAW)
    sticking.move(atoms, MOVE)
    rng, start = np.random.default_rng(0), atoms.positions.copy()
    moves = np.zeros(start.shape)
    moves[:-1, :2] = rng.standard_normal((len(atoms) - 1, 2))
    if not wall.hard:
        moves[:, 2] = 1e-2 * rng.standard_normal(len(atoms))
    forces = atoms.get_forces(apply_constraint=False)

    def energy_at(positions):
        atoms.positions[:] = positions
        return atoms.calc.get_property("energy", atoms)

    ends = [energy_at(start + length * moves) for length in (1e-4, -1e-4)]
    assert -(forces * moves).sum() == pytest.approx(np.diff(ends)[0] / -2e-4, rel=1e-6)
    assert atoms.calc.results["energies"].sum() == pytest.approx(ends[1])
    # all atoms that stick move with the indenter
    energy_at(start)
    force = atoms.get_forces(apply_constraint=False)[sticking.index, :2].sum(axis=0)
    for axis in range(2):
        ends = []
        for length in (1e-4, -1e-4):
            place = start.copy()
            place[[*sticking.index, -1], axis] += length
            ends.append(energy_at(place))
        assert force[axis] == pytest.approx(np.diff(ends)[0] / 2e-4, rel=1e-6)


@pytest.mark.parametrize("options", [{}, {"periodic": True}, {"solid": CUBIC}])
def test_relaxed_atoms_agree_with_the_friction_solver(options):
    atoms, expected = pressed(**options), slid([[0.0, 0.0], MOVE], **options)
    before = atoms.get_potential_energy()
    stick(atoms, LAW).move(atoms, MOVE)
    assert LBFGS(atoms, logfile=None).run(fmax=1e-7, steps=600)
    force = atoms.calc.get_property("lateral_force", atoms)
    assert force == pytest.approx(force_of(expected[1]), rel=1e-4)
    energy = atoms.get_potential_energy() - before
    assert energy == pytest.approx(expected[1].lateral_energy, rel=1e-5)
    # the displacements are those that ASE has found
    found, fields = (
        ContactMap.from_atoms(each).lateral for each in (atoms, expected[0])
    )
    largest = abs(fields["displacement_x"]).max()
    for key, values in fields.items():
        scale = largest if key.startswith("displacement") else abs(values).max()
        assert found[key] == pytest.approx(values, abs=3e-4 * scale), key


@pytest.mark.filterwarnings("ignore:nothing holds")  # at first, if it sticks first
@pytest.mark.parametrize("first", [False, True])
def test_a_spring_pulls_the_indenter_as_on_a_path_of_its_base(first):
    small, base = {"depth": 0.1, "shape": (8, 8)}, np.array([0.02, 0.01])
    _, expected = slid(None, bases=[[0.0, 0.0], base], spring=3.0, **small)
    atoms = pressed(**small)
    start, spring = atoms.positions[-1].copy(), pulled(atoms, base, 3.0)
    atoms.set_constraint([] if first else spring)
    sticking = stick(atoms, LAW)
    if first:
        atoms.set_constraint([sticking, *spring])
    assert LBFGS(atoms, logfile=None).run(fmax=1e-6, steps=300)
    moved = atoms.positions[-1] - start
    assert moved[:2] == pytest.approx([expected.lateral_x, expected.lateral_y], 1e-4)
    assert moved[2] == 0.0
    assert atoms.calc.get_property("lateral_force", atoms) == pytest.approx(
        force_of(expected), 1e-4
    )


def test_under_a_load_the_indenter_is_held_sideways_only():
    wall = LennardJones93.repulsive(0.8, 2.5)
    atoms = atoms_on(wall=wall, fixed=False)
    list(load_path(atoms, loads=[5.0], fmax=1e-7, validity="ignore"))
    atoms.set_constraint(FixCartesian(len(atoms) - 1, (True, True, False)))
    stick(atoms, LAW).move(atoms, MOVE)
    height = atoms.positions[-1, 2]
    atoms.positions[-1, 2] += 0.01
    assert LBFGS(atoms, logfile=None).run(fmax=1e-6, steps=500)
    assert atoms.calc.get_property("normal_force", atoms) == pytest.approx(
        5.0, abs=1e-5
    )
    assert atoms.positions[-1, 2] == pytest.approx(height, abs=1e-5)


def test_paths_end_and_begin_with_atoms_that_stick(tmp_path):
    path = MOVE + np.array([-MOVE, [0.0, 0.0], [0.0, 0.002], [0.002, 0.002]])
    atoms, _ = slid(path[:2])
    sticking = stick(atoms, LAW)
    assert abs(atoms.get_forces()).max() < 1e-6  # relaxed
    sticking.move(atoms, path[2] - MOVE)
    assert LBFGS(atoms, trajectory=tmp_path / "a.traj", logfile=None).run(fmax=1e-7)
    release(atoms)
    assert atoms.constraints[0].todict() == FixAtoms([len(atoms) - 1]).todict()
    rest = list(
        sliding_path(
            atoms, LAW, penetrations=0.5, displacements=path[2:], validity="ignore"
        )
    )
    for found, until in zip(rest, (3, 4), strict=True):
        _, expected = slid(path[:until])
        assert force_of(found) == pytest.approx(force_of(expected), rel=1e-5)
        assert found.slip_area == 0.0


def test_frames_have_the_lateral_forces(tmp_path):
    atoms = pressed()
    sticking = stick(atoms, LAW)
    sticking.move(atoms, MOVE)
    LBFGS(atoms, logfile=None).run(fmax=1e-6)
    force = atoms.calc.get_property("lateral_force", atoms)
    write(tmp_path / "frame.extxyz", snapshot(atoms))
    for frame in (snapshot(atoms), read(tmp_path / "frame.extxyz"), slid([0, 0.01])[0]):
        if frame.calc.name == "roughcontact":
            force, frame = (
                frame.calc.get_property("lateral_force", frame),
                snapshot(frame),
            )
        on_indenter = frame.get_forces(apply_constraint=False)[-1, :2]
        assert on_indenter == pytest.approx(-force, rel=1e-6)
        assert frame.info["lateral_force"] == pytest.approx(force)
        in_info = {"traction_x", "traction_y", "slipping"}
        assert in_info <= frame.info.keys() - frame.arrays.keys()
        fields = ContactMap.from_frame(frame).lateral
        tractions = 2.5**2 * fields["traction_x"].sum()
        assert tractions == pytest.approx(force[0], rel=1e-4)
        assert fields.keys() == in_info | {"displacement_x", "displacement_y"}


def test_atoms_that_would_slip_are_named():
    law, atoms = Tresca(4e-4), pressed()
    sticking, before = stick(atoms, law), atoms.positions.copy()
    sticking.move(atoms, (0.001, 0.0))
    message = (
        rf"of {len(sticking.index)} atoms .* moves by \(0\.008, 0\) Å .* "
        "use sliding_path"
    )
    with pytest.raises(SlipError, match=message) as error:
        sticking.move(atoms, (0.007, 0.0))
    moved = (atoms.positions - before)[:, 0]
    assert moved.max() == pytest.approx(0.001)  # nothing since
    # those that the message names are at the edge; a path has more, as loads are shared
    first = int(re.search(r"atoms (\d+)", str(error.value))[1])
    path, step = slid([0.0, 0.008], law=law)
    assert path.arrays["slipping"][first] == 1.0
    count = int(re.match(r"\d+", str(error.value))[0])
    assert count <= round(step.slip_area / 2.5**2)


@pytest.mark.parametrize(
    "optimizer, stiffness",
    [(FIRE, 3.0), (LBFGS, 3.0), (BFGSLineSearch, 3.0), (LBFGS, 0.1)],
)
def test_a_spring_that_makes_atoms_slip_ends_the_run(optimizer, stiffness):
    atoms = pressed(0.1, shape=(8, 8))
    atoms.set_constraint(pulled(atoms, (0.02, 0.01), stiffness))
    stick(atoms, Coulomb(0.1))
    run = optimizer(atoms, logfile=None).run
    if stiffness > 1.0:
        with pytest.raises(SlipError, match=r"(2|4) of 9"):
            run(fmax=1e-6, steps=500)
    else:
        assert run(fmax=1e-6, steps=500)


def test_an_optimizer_may_move_the_indenter_too_far():
    atoms = pressed(0.1, shape=(8, 8))
    atoms.set_constraint(pulled(atoms, (0.02, 0.01), 0.1))
    stick(atoms, Coulomb(0.1))
    positions = atoms.get_positions()
    positions[-1, :2] += MOVE  # the spring does not pull so far
    atoms.set_positions(positions)
    force = atoms.get_forces()[-1, :2]
    assert (force < 0.0).all()
    atoms.set_constraint([FixAtoms([len(atoms) - 1]), *atoms.constraints[2:]])
    with pytest.raises(SlipError, match=r"moves by \(0\.008, 0\.003\)"):
        atoms.get_forces()


def test_atoms_that_have_slipped_do_not_stick():
    atoms, step = slid([0.0, 0.02], law=Coulomb(0.3))
    slipping = round(step.slip_area / 2.5**2)
    with pytest.raises(SlipError, match=f"^{slipping} of .* slip already"):
        stick(atoms, Coulomb(0.3))
    atoms, _ = slid([0.0, 0.008])
    before = atoms.positions.copy()
    with pytest.raises(SlipError, match="slip already"):  # by another law
        stick(atoms, Tresca(1e-5))
    assert (atoms.positions == before).all()


def test_what_does_not_support_atoms_that_stick_says_so():
    atoms = pressed()
    stick(atoms, LAW)
    for call in (
        lambda: stick(atoms, LAW),
        lambda: ActiveSet(atoms),
        lambda: load_path(atoms, penetrations=[0.6]),
        lambda: sliding_path(
            atoms, LAW, penetrations=0.5, displacements=[0, 1], optimizer=LBFGS
        ),
    ):
        with pytest.raises(ValueError, match=r"stick to the indenter: .* release"):
            call()
    release(atoms)
    assert ActiveSet(atoms).run(fmax=1e-6)
    soft = pressed(wall=LennardJones93.repulsive(0.8, 2.5))
    stick(soft, LAW)
    for kind in (NewtonKrylov, FourierModes):
        with pytest.raises(ValueError, match="stick to the indenter"):
            kind(soft)


def test_a_constraint_that_is_removed_without_release_is_an_error():
    atoms = pressed(0.1, shape=(8, 8))
    law, others = Tresca(0.1), pulled(atoms, (0.02, 0.0), 0.5)
    sticking, before = stick(atoms, law), atoms.positions.copy()
    copy, frame = atoms.copy(), snapshot(atoms)
    atoms.set_constraint(others)
    for call in (
        lambda: LBFGS(atoms, logfile=None).run(fmax=1e-6),
        lambda: stick(atoms, law),
        lambda: load_path(atoms, penetrations=[0.2]),
    ):
        with pytest.raises(ValueError, match=r"not among atoms\.constraints.* release"):
            call()
    assert (atoms.positions == before).all()
    atoms.set_constraint([sticking, *others])
    assert LBFGS(atoms, logfile=None).run(fmax=1e-6)
    force, moved = (
        atoms.calc.get_property("lateral_force", atoms)[0],
        atoms.positions - before,
    )
    assert force == pytest.approx(0.5 * (0.02 - moved[-1, 0]), rel=1e-4)
    assert force > 1e-3
    for other in (copy, frame):  # the frame is no longer stuck
        other.calc = RoughContact(SPHERE, solid=ISOTROPIC, wall=HardWall())
        assert other.get_potential_energy() > 0.0
    atoms.set_constraint(others)
    release(atoms)
    assert (atoms.get_forces(apply_constraint=False)[:, :2] == 0.0).all()


def test_other_atoms_that_stick_at_the_same_positions_have_other_forces():
    class Inner(Tresca):
        """Friction on atoms under more than half of the largest pressure."""

        def bound(self, pressure, *_):
            return np.where(pressure > 0.5 * pressure.max(), 1.0, 0.0)

    atoms, other = pressed(), pressed()
    all_touching, inner = stick(atoms, LAW), stick(other, Inner(1.0))
    assert len(inner.index) < len(all_touching.index)
    all_touching.move(atoms, MOVE)
    others = [c for c in atoms.constraints if c is not all_touching]
    first = atoms.calc.get_property("lateral_force", atoms)
    atoms.set_constraint([*others, inner])
    force = atoms.get_forces(apply_constraint=False)[inner.index, :2].sum(axis=0)
    assert atoms.calc.get_property("lateral_force", atoms) == pytest.approx(-force)
    assert abs(force[0]) < 0.9 * abs(first[0])


@pytest.mark.parametrize("displacement", [0.05, (0.1,), (np.nan, 0.0), (0, 0, 0)])
def test_a_move_needs_two_finite_numbers(displacement):
    atoms = pressed(0.1, shape=(8, 8))
    sticking, before = stick(atoms, LAW), atoms.positions.copy()
    with pytest.raises(ValueError, match="displacement"):
        sticking.move(atoms, displacement)
    assert (atoms.positions == before).all()


def test_what_cannot_stick_says_why():
    with pytest.raises(ValueError, match="relax the atoms first"):
        stick(atoms_on(), LAW)
    with pytest.raises(TypeError, match=r"law such as Coulomb\(0\.3\), got 0\.3"):
        stick(pressed(), 0.3)
    with pytest.raises(NotImplementedError, match="Layer"):
        stick(pressed(solid=Layer(0.8, 20.0, 0.05)), LAW)
    coupled, _ = slid([0.0, 0.008], coupling="solved")
    with pytest.raises(ValueError, match='"neglected"'):
        stick(coupled, LAW)
    atoms = pressed()
    frame = snapshot(atoms)
    frame.calc = atoms.calc
    with pytest.raises(ValueError, match=r"padding .*restore\(snapshot"):
        stick(frame, LAW)
    whole = restore(frame, ISOTROPIC)
    whole.calc = RoughContact(SPHERE, solid=ISOTROPIC, wall=HardWall())
    assert len(stick(whole, LAW).index) == frame.info["contact_area"] / 2.5**2
    whole.positions[-1, 0] += 0.1
    with pytest.raises(ValueError, match=r" 0\.1 Å .* method move"):
        whole.get_forces()


def test_atoms_have_no_lateral_forces_unless_they_stick():
    atoms, _ = slid([[0.0, 0.0], MOVE])
    energy = atoms.get_potential_energy()
    stick(atoms, LAW)  # noticed without a move
    assert abs(atoms.get_forces(apply_constraint=False)[:, :2]).max() > 1e-3
    assert atoms.get_potential_energy() > energy
    assert not atoms[:5].constraints  # parts are without it
