"""With the rest of ASE: files, optimizers, constraints, other calculators, copies."""

from functools import partial

import numpy as np
import pytest
from ase import optimize
from ase.calculators.harmonic import SpringCalculator
from ase.calculators.mixing import SumCalculator
from ase.constraints import FixAtoms, FixCartesian
from ase.db import connect
from ase.io import read, write
from ase.optimize import precon, sciopt
from ase.parallel import world
from built import atoms_under

import ase_roughcontact as rc
from ase_roughcontact.analysis import ContactMap

SPHERE = rc.RoughSphere(10.0)
WALL = rc.LennardJones93.adhesive(1.0, 1.0, 0.02)


make_atoms = partial(atoms_under, SPHERE, WALL, shape=(4, 3), height=0.6)


@pytest.fixture(scope="module")
def energy():
    """Energy of the relaxed atoms."""
    atoms = make_atoms()
    rc.NewtonKrylov(atoms, logfile=None).run(fmax=1e-10)
    return atoms.get_potential_energy()


# Files


def round_trip(frame, path):
    if path.suffix in (".db", ".json"):
        with connect(path) as database:
            database.write(frame, data=frame.info)
        return connect(path).get_atoms(id=1, add_additional_information=True)
    write(path, frame)
    return read(path)


@pytest.mark.parametrize("name", ["a.traj", "a.extxyz", "a.db", "a.json"])
def test_results_of_a_frame_survive_a_file(tmp_path, periodic, name):
    atoms = make_atoms(shape=(6, 5), periodic=periodic)
    rc.NewtonKrylov(atoms, logfile=None).run(fmax=1e-8)
    frame = rc.snapshot(atoms)
    again = round_trip(frame, tmp_path / name)
    near = {"rtol": 0, "atol": 2e-8}  # text has eight digits after the point
    assert again.get_potential_energy() == pytest.approx(frame.get_potential_energy())
    np.testing.assert_allclose(again.get_forces(), frame.get_forces(), **near)
    np.testing.assert_allclose(again.positions, frame.positions, **near)
    before, after = ContactMap.from_frame(frame), ContactMap.from_frame(again)
    np.testing.assert_array_equal(after.contact, before.contact)
    np.testing.assert_allclose(after.pressure, before.pressure, **near)


@pytest.mark.parametrize("name", ["a.traj", "a.extxyz", "a.db"])
def test_frame_from_a_file_can_be_relaxed_further(tmp_path, periodic, name):
    atoms = make_atoms(shape=(6, 5), periodic=periodic)
    rc.NewtonKrylov(atoms, logfile=None).run(fmax=1e-8)
    frame = round_trip(rc.snapshot(atoms, step=4), tmp_path / name)
    assert (frame.info | frame.info.get("data", {}))["step"] == 4
    for again in (frame, rc.restore(frame, 1.0)):
        again.calc = atoms.calc
        assert np.abs(again.get_forces()).max() < 1e-6
        again.positions[-1, 2] -= 0.1
        assert rc.NewtonKrylov(again, logfile=None).run(fmax=1e-8)


# Optimizers

# GPMin is left out: it stores the matrix of all coordinates of all steps.
OPTIMIZERS = [
    optimize.BFGS,
    optimize.BFGSLineSearch,
    optimize.FIRE,
    optimize.FIRE2,
    optimize.GoodOldQuasiNewton,
    optimize.LBFGS,
    optimize.LBFGSLineSearch,
    optimize.MDMin,
    optimize.ODE12r,
    precon.PreconFIRE,
    partial(precon.PreconLBFGS, precon=None),  # its own is off for few atoms
    sciopt.SciPyFminBFGS,
    sciopt.SciPyFminCG,
]


@pytest.mark.parametrize("optimizer", OPTIMIZERS)
def test_any_optimizer_of_ase_relaxes_the_atoms(optimizer, energy):
    atoms = make_atoms()
    optimizer(atoms, logfile=None).run(fmax=1e-4, steps=1000)
    assert np.abs(atoms.get_forces()).max() < 1e-4
    assert atoms.get_potential_energy() == pytest.approx(energy, rel=1e-5)


# Constraints


@pytest.mark.parametrize(
    "constraint",
    [FixAtoms([13, 20]), FixCartesian([13, 20]), FixCartesian([13, 20], (0, 0, 1))],
    ids=["atoms", "all directions", "z"],
)
def test_surface_atoms_can_be_fixed(constraint):
    atoms = make_atoms()
    atoms.set_constraint([*atoms.constraints, constraint])
    assert optimize.LBFGS(atoms, logfile=None).run(fmax=1e-5, steps=500)
    assert (atoms.positions[[13, 20], 2] == 0.0).all()
    left = atoms.get_forces(apply_constraint=False)[:-1, 2]
    free = np.delete(left, [13, 20])
    assert np.abs(free).max() < 1e-5 < np.abs(left[[13, 20]]).min()


# Other calculators


def test_sum_with_another_calculator_adds_energy_and_forces():
    atoms = make_atoms()
    atoms.positions[:-1, 2] += np.linspace(-0.1, 0.1, len(atoms) - 1)
    spring = SpringCalculator(0.9 * atoms.positions, 0.3)
    parts = []
    for calculator in (atoms.calc, spring, SumCalculator([atoms.calc, spring])):
        atoms.calc = calculator
        forces = atoms.get_forces(apply_constraint=False)
        parts.append((atoms.get_potential_energy(), forces))
    (one, force), (other, push), (both, sum_of_forces) = parts
    assert both == pytest.approx(one + other)
    np.testing.assert_allclose(sum_of_forces, force + push, atol=1e-12)
    assert abs(push).max() > 0.1 and abs(force).max() > 0.1


# In parallel


class SecondOfTwo:
    """Communicator of the second of two processes."""

    rank, size = 1, 2

    def sum(self, value, root=-1):
        return value

    def broadcast(self, value, root):
        return value

    def barrier(self):
        return None


def test_every_process_of_a_parallel_run_has_the_results(tmp_path, monkeypatch, energy):
    monkeypatch.setattr(world, "comm", SecondOfTwo())
    assert (world.rank, world.size) == (1, 2)
    atoms = make_atoms()
    assert optimize.LBFGS(atoms, logfile=None).run(fmax=1e-5, steps=500)
    assert atoms.get_potential_energy() == pytest.approx(energy, rel=1e-6)
    movie = tmp_path / "sweep.traj"
    atoms = make_atoms(shape=(12, 12))
    (step,) = rc.load_path(atoms, heights=[0.6], output=rc.Output(trajectory=movie))
    assert read(movie, parallel=False).info["load_step"]["energy"] == step.energy
