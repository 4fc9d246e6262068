"""Scaled Fourier modes: gradient, norms, ASE's optimizers, steps, cost."""

from functools import cache

import numpy as np
import pytest
from ase.constraints import FixAtoms, Hookean
from ase.optimize import FIRE, FIRE2, LBFGS, BFGSLineSearch, LBFGSLineSearch
from ase.optimize.sciopt import SciPyFminBFGS, SciPyFminCG

import ase_roughcontact as rc

SPHERE = rc.RoughSphere(radius=10.0)


def make_atoms(wall=None, *, shape=(8, 6), periodic=False, load=0.0, **options):
    """Atoms of unit spacing and contact modulus under a sphere."""
    options = {"height": 0.6, "spacing": 1.0, **options}
    atoms = rc.substrate("Cu", shape, SPHERE, periodic=periodic, **options)
    atoms.calc = rc.RoughContact(SPHERE, 1.0, wall, load=load)
    return atoms


def spring(atoms, stiffness=0.7):
    point = (*atoms.positions[-1, :2], -0.5)
    atoms.set_constraint(Hookean(len(atoms) - 1, point, stiffness, rt=0.0))
    return atoms


def shaken(atoms, rng, amplitude=0.05):
    atoms.positions[:-1, 2] = rng.normal(0.0, amplitude, len(atoms) - 1)
    return atoms


def assert_gradient(modes, rng):
    """Compare with finite differences in directions that mix all modes."""
    x, gradient, step = modes.get_x(), modes.get_gradient().copy(), 1e-5
    directions = list(rng.normal(size=(6, modes.ndofs())) / modes.ndofs() ** 0.5)
    for direction in [*directions, np.eye(modes.ndofs())[-1]]:
        energies = []
        for sign in (1, -1):
            modes.set_x(x + sign * step * direction)
            energies.append(modes.get_value())
        slope = (energies[0] - energies[1]) / (2 * step)
        assert gradient @ direction == pytest.approx(slope, rel=1e-6, abs=1e-6)


# Value and gradient


@pytest.mark.parametrize("shape", [(8, 6), (7, 5), (5, 8), (6, 7), (1, 4)], ids=str)
def test_gradient_is_the_derivative_of_the_value(shape, periodic, wall, rng):
    atoms = make_atoms(wall, shape=shape, periodic=periodic, load=0.3, fixed=False)
    for supported in (atoms, spring(atoms)):
        assert_gradient(rc.FourierModes(shaken(supported, rng)), rng)


@pytest.mark.parametrize("tied", [False, True])
def test_value_and_norm_are_energy_and_largest_force_of_the_atoms(
    periodic, wall, rng, tied
):
    atoms = make_atoms(wall, periodic=periodic, load=0.3, fixed=False)
    atoms = shaken(spring(atoms) if tied else atoms, rng)
    modes = rc.FourierModes(atoms)
    largest = np.linalg.norm(atoms.get_forces(), axis=1).max()
    assert modes.get_value() == pytest.approx(atoms.get_potential_energy(), rel=1e-12)
    gradient = modes.get_gradient()
    assert modes.gradient_norm(gradient) == pytest.approx(largest, rel=1e-12)


def test_norm_of_a_step_is_the_largest_displacement(periodic, rng):
    atoms = shaken(make_atoms(periodic=periodic, fixed=False), rng)
    modes = rc.FourierModes(atoms)
    x, before = modes.get_x(), atoms.positions[:, 2].copy()
    step = rng.normal(size=modes.ndofs())
    modes.set_x(x + step)
    moved = np.abs(atoms.positions[:, 2] - before).max()
    assert modes.gradient_norm(step) == pytest.approx(moved, rel=1e-10)


def test_coordinates_are_transformed_to_modes_and_back(periodic, rng):
    atoms = shaken(make_atoms(periodic=periodic), rng)
    before = atoms.positions.copy()
    modes = rc.FourierModes(atoms)
    modes.set_x(modes.get_x())
    np.testing.assert_allclose(atoms.positions, before, atol=1e-14)


def test_curvature_is_nearly_one(rng):
    atoms = make_atoms(height=30.0)
    modes = rc.FourierModes(atoms)
    step = 1e-3 * rng.normal(size=modes.ndofs())
    step[-1] = 0.0
    modes.set_x(step + modes.get_x())
    assert 0.05 < 2 * modes.get_value() / (step @ step) < 1.0


# ASE's optimizers


def controlled_atoms(control):
    fixed = control == "fixed"
    atoms = make_atoms(load=0.0 if fixed else 0.5, fixed=fixed)
    return spring(atoms) if control == "spring" else atoms


@cache
def relaxed_atoms(control):
    atoms = controlled_atoms(control)
    assert LBFGS(atoms, logfile=None).run(fmax=1e-7)
    return atoms


@pytest.mark.parametrize("control", ["fixed", "load", "spring"])
@pytest.mark.parametrize(
    "optimizer, options",
    [
        (FIRE, {}),
        (FIRE2, {}),
        (LBFGS, {"alpha": 1.0}),
        (BFGSLineSearch, {}),
        (LBFGSLineSearch, {"alpha": 1.0}),
        (SciPyFminCG, {"alpha": 1.0}),
        (SciPyFminBFGS, {"alpha": 1.0}),
    ],
)
def test_optimizers_find_the_same_energy_as_on_atoms(optimizer, options, control):
    reference, atoms = relaxed_atoms(control), controlled_atoms(control)
    with optimizer(rc.FourierModes(atoms), logfile=None, **options) as dynamics:
        assert dynamics.run(fmax=1e-6, steps=1000)
    energy = reference.get_potential_energy()
    assert atoms.get_potential_energy() == pytest.approx(energy, rel=1e-8)
    assert np.linalg.norm(atoms.get_forces(), axis=1).max() < 1e-6
    assert atoms.positions[-1, 2] == pytest.approx(reference.positions[-1, 2], abs=1e-4)


def test_a_load_takes_hardly_more_steps_of_fire_than_a_height():
    sphere = rc.RoughSphere(radius=130.0)
    atoms = rc.substrate("Cu", (32, 32), sphere, spacing=1.0, fixed=False)
    atoms.calc = rc.RoughContact(sphere, 1.0, load=3.8)
    modes = rc.FourierModes(atoms)
    fire = FIRE(modes, maxstep=modes.maxstep, logfile=None)
    assert fire.run(fmax=1e-5, steps=400)


# The atoms while an optimizer works on their modes


def test_atoms_are_in_the_present_iterate_at_every_step():
    atoms = make_atoms(load=0.5, fixed=False)
    modes, seen = rc.FourierModes(atoms), []
    dynamics = LBFGS(modes, alpha=1.0, logfile=None)
    dynamics.attach(lambda: seen.append(atoms.get_forces()))
    for _ in dynamics.irun(fmax=1e-6, steps=5):
        norm = modes.gradient_norm(modes.get_gradient())
        assert np.abs(atoms.get_forces()).max() == pytest.approx(norm, rel=1e-9)
        np.testing.assert_array_equal(seen[-1], atoms.get_forces())
    assert len(seen) == 6
    assert len({forces[-1, 2] for forces in seen}) == 6


def deeper(atoms):
    atoms.positions[-1, 2] -= 0.2


def free_under_load(atoms):
    atoms.set_constraint()


def tied(atoms):
    spring(atoms, stiffness=2.0)


def fixed_deeper(atoms):
    deeper(atoms)
    atoms.set_constraint(FixAtoms([-1]))


def spring_pulled(atoms):
    atoms.constraints[0].origin = atoms.constraints[0].origin - [0.0, 0.0, 0.3]


def more_load(atoms):
    atoms.calc.set(load=1.1)


def stiffer(atoms):
    atoms.calc.set(contact_modulus=1.7)


@pytest.mark.filterwarnings("ignore:the load of")
@pytest.mark.parametrize(
    "changes",
    [
        [deeper, deeper, deeper],
        [stiffer, deeper],
        [free_under_load, more_load, fixed_deeper],
        [tied, spring_pulled, free_under_load],
    ],
    ids=["heights", "modulus", "loads", "springs"],
)
def test_later_runs_relax_the_atoms_as_they_are_now(changes, periodic):
    atoms = make_atoms(periodic=periodic, load=0.5)
    modes = rc.FourierModes(atoms)
    dynamics = LBFGS(modes, alpha=1.0, logfile=None)
    assert dynamics.run(fmax=1e-6, steps=500)
    for change in changes:
        change(atoms)
        height = atoms.positions[-1, 2]
        assert dynamics.run(fmax=1e-6, steps=500)
        if modes.support.fixed:
            assert atoms.positions[-1, 2] == height
        expected = atoms.copy()
        expected.positions[:-1, 2] = 0.0
        expected.calc = rc.RoughContact(**atoms.calc.parameters)
        assert rc.NewtonKrylov(expected).run(fmax=1e-9)
        force, other = (a.calc.state(a).normal_force for a in (atoms, expected))
        assert force == pytest.approx(other, rel=1e-4)


def test_modes_follow_atoms_that_are_moved_during_a_run():
    atoms = make_atoms()
    dynamics = LBFGS(rc.FourierModes(atoms), alpha=1.0, logfile=None)
    dynamics.attach(lambda: deeper(atoms) if dynamics.nsteps == 3 else None)
    assert dynamics.run(fmax=1e-6, steps=500)
    assert atoms.positions[-1, 2] == 0.6 - 0.2
    assert np.abs(atoms.get_forces()[:-1]).max() < 1e-6


@pytest.mark.parametrize(
    "change, words",
    [
        (lambda atoms: atoms.calc.set(wall=rc.HardWall()), "ActiveSet"),
        (lambda atoms: atoms.set_constraint(FixAtoms([3])), "ASE's optimizers"),
    ],
    ids=["hard wall", "fixed atom"],
)
def test_later_runs_refuse_what_the_modes_do_not_support(change, words):
    atoms = make_atoms()
    dynamics = LBFGS(rc.FourierModes(atoms), alpha=1.0, logfile=None)
    assert dynamics.run(fmax=1e-3)
    change(atoms)
    with pytest.raises(ValueError, match=words):
        dynamics.run(fmax=1e-3)
