"""Optimizers, dynamics and files of ASE with an elastic foundation."""

import numpy as np
import pytest
from ase import units
from ase.constraints import FixAtoms
from ase.md.verlet import VelocityVerlet
from ase.optimize import LBFGS
from ase.optimize.precon import PreconLBFGS
from pair_crystal import pair_potential

import ase_roughcontact as rc
from ase_roughcontact.foundation import FoundationPrecon, add_indenter, crystal_slab


def pressed(surface, n, layers=2):
    size = n, n
    atoms, foundation = crystal_slab("Cu", size, layers, pair_potential(), surface)
    add_indenter(atoms, rc.RoughSphere(15.0))
    atoms.positions[-1, 2] -= 0.4
    return atoms, foundation


def preconditioned(atoms, foundation):
    precon = FoundationPrecon(atoms, foundation)
    return PreconLBFGS(atoms, precon=precon, use_armijo=False, logfile=None)


def test_steps_with_the_preconditioner_do_not_increase_with_the_cell(surface):
    steps = {}
    for n in (6, 12):
        optimizer = preconditioned(*pressed(surface, n))
        assert optimizer.run(fmax=1e-3, steps=100)
        steps[n] = optimizer.nsteps
    optimizer = LBFGS(pressed(surface, 12)[0], logfile=None)
    assert optimizer.run(fmax=1e-3, steps=500)
    assert steps[12] <= 2 * steps[6]
    assert steps[12] < 0.5 * optimizer.nsteps


def test_preconditioner_is_the_hessian_of_the_atoms_at_rest(surface):
    size = 3, 3
    atoms, foundation = crystal_slab("Cu", size, 3, pair_potential(), surface)
    precon = FoundationPrecon(atoms, foundation)
    matrix = precon.asarray()
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-10)
    vector = np.random.default_rng(1).normal(size=len(matrix))
    vector.reshape(-1, 3)[:9] -= vector.reshape(-1, 3)[:9].mean(axis=0)
    np.testing.assert_allclose(precon.solve(matrix @ vector), vector, atol=1e-9)
    forces = []
    for sign in (1, -1):
        moved = atoms.copy()
        moved.calc = foundation
        moved.positions += sign * 1e-4 * vector.reshape(-1, 3)
        forces.append(moved.get_forces())
    hessian = ((forces[1] - forces[0]) / 2e-4).ravel()
    np.testing.assert_allclose(matrix @ vector, hessian, rtol=1e-5, atol=1e-5)


def energies(atoms, step, steps, temperature=100.0):
    """Total and kinetic energies, twenty times in a run of dynamics (eV)."""
    scatter = np.sqrt(units.kB * temperature * atoms.get_masses())[:, np.newaxis]
    random = np.random.default_rng(1).standard_normal((len(atoms), 3))
    atoms.set_momenta(scatter * random)
    dynamics = VelocityVerlet(atoms, step * units.fs)
    result = []
    for _ in range(20):
        dynamics.run(steps // 20)
        result.append((atoms.get_total_energy(), atoms.get_kinetic_energy()))
    return np.transpose(result)


def test_dynamics_conserve_the_energy_to_second_order_in_the_time_step(surface):
    change = []
    for step in (2.0, 1.0):
        size = 3, 3
        atoms, _ = crystal_slab("Cu", size, 2, pair_potential(), surface)
        total, kinetic = energies(atoms, step, round(80 / step))
        change.append(np.ptp(total))
    assert change[0] / change[1] == pytest.approx(4.0, rel=0.05)
    assert change[1] < 2e-3 * kinetic.mean()
    lowest = atoms.positions[:9, 2].mean()
    assert lowest == pytest.approx(surface.column(2).positions[1, 2], abs=1e-10)


def test_constraints_hold(surface):
    atoms, _ = pressed(surface, 6)
    atoms.set_constraint([*atoms.constraints, FixAtoms([50, 51])])
    before = atoms.positions.copy()
    assert LBFGS(atoms, logfile=None).run(fmax=1e-3, steps=200)
    moved = atoms.positions - before
    np.testing.assert_array_equal(moved[[50, 51, -1]], 0.0)
    np.testing.assert_allclose(moved[:36].mean(axis=0), 0.0, atol=1e-10)
    assert abs(moved[36:-1]).max() > 0.1
