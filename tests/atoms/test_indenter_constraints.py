"""Which constraints the solvers support."""

import numpy as np
import pytest
from ase.constraints import (
    ExternalForce,
    FixAtoms,
    FixCartesian,
    FixCom,
    FixedLine,
    FixedPlane,
    Hookean,
)
from built import atoms_under

import ase_roughcontact as rc

SPHERE = rc.RoughSphere(40.0)
LAST = 64


def make_atoms(constraint, wall=None, load=1.0):
    atoms = atoms_under(SPHERE, wall, load=load, periodic=True, fixed=False)
    atoms.positions[-1, 2] -= 0.3
    atoms.set_constraint(constraint)
    return atoms


@pytest.mark.parametrize(
    "constraint",
    [
        FixedLine(range(LAST + 1), [0, 0, 1]),
        FixedPlane([LAST], [1, 0, 0]),
        FixedPlane(range(LAST), [0.6, 0.8, 0.0]),
        FixCartesian(range(LAST + 1), (True, True, False)),
    ],
    ids=["lines along z", "indenter in a plane", "atoms in planes", "lateral"],
)
@pytest.mark.parametrize("wall", [None, rc.HardWall()], ids=["soft", "hard"])
def test_lateral_constraints_change_nothing(constraint, wall):
    atoms, free = make_atoms(constraint, wall), make_atoms([], wall)
    for each in (atoms, free):
        assert (rc.ActiveSet if wall else rc.NewtonKrylov)(each).run(fmax=1e-8)
    np.testing.assert_array_equal(atoms.positions, free.positions)


@pytest.mark.filterwarnings("ignore:the load of")
@pytest.mark.parametrize(
    "constraint",
    [
        FixAtoms([LAST]),
        FixAtoms([-1]),
        FixCartesian([LAST]),
        FixCartesian([LAST], (False, False, True)),
        FixedLine([LAST], [1, 0, 0]),
        FixedPlane([LAST], [0, 0, 1]),
    ],
    ids=["atom", "last atom", "cartesian", "z", "line along x", "plane across z"],
)
def test_constraints_of_the_indenter_along_z_fix_its_height(constraint):
    atoms = make_atoms(constraint)
    height = atoms.positions[-1, 2]
    assert rc.NewtonKrylov(atoms).run(fmax=1e-8)
    assert atoms.positions[-1, 2] == height
    assert atoms.calc.state(atoms).normal_force != pytest.approx(1.0, rel=1e-3)


@pytest.mark.parametrize(
    "constraint",
    [
        FixCom(),
        FixAtoms([3]),
        FixCartesian([3, LAST]),
        FixedLine([3], [1, 0, 1]),
        FixedPlane([LAST], [0, 1, 1]),
        ExternalForce(3, LAST, 0.1),
        Hookean(0, 1, 1.0, rt=1.0),
    ],
    ids=["centre", "atom", "two atoms", "line", "plane", "force", "bond"],
)
@pytest.mark.parametrize("optimizer", [rc.NewtonKrylov, rc.FourierModes])
def test_other_constraints_are_refused_by_name(optimizer, constraint):
    atoms = make_atoms(constraint)
    with pytest.raises(
        ValueError, match="one of ASE's optimizers on the atoms"
    ) as info:
        optimizer(atoms)
    assert str(constraint) in str(info.value)


@pytest.mark.filterwarnings("ignore:the load of")
def test_hard_wall_with_a_spring_on_the_indenter():
    spring = Hookean(LAST, (4.0, 4.0, -2.0), 0.7, rt=0.5)
    atoms = make_atoms(spring, rc.HardWall())
    load = atoms.calc.parameters["load"]
    optimizer = rc.ActiveSet(atoms)
    assert optimizer.run(fmax=1e-8)
    expected = load + 0.7 * (atoms.positions[-1, 2] + 2.0 - 0.5)
    assert atoms.calc.state(atoms).normal_force == pytest.approx(expected, rel=1e-9)
    assert optimizer.optimality_residuals.load_error == pytest.approx(0.0, abs=1e-9)
    atoms = make_atoms([FixAtoms([LAST]), spring], rc.HardWall())
    assert rc.ActiveSet(atoms).run(fmax=1e-8)


def test_spring_beside_the_indenter_is_refused():
    with pytest.raises(ValueError, match="beside the indenter"):
        rc.NewtonKrylov(make_atoms(Hookean(LAST, (0.0, 0.0, -1.0), 1.0, rt=0.0)))
