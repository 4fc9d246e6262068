"""The half space as a preconditioner of ASE's preconditioned optimizers."""

import numpy as np
import pytest
from ase.optimize.precon import PreconFIRE, PreconLBFGS
from built import atoms_under

import ase_roughcontact as rc


def make_atoms(n=5, *, wall=None, periodic=False, **options):
    sphere = rc.RoughSphere(radius=20.0 * n)
    load = 0.0 if options.get("fixed", True) else 0.5
    return atoms_under(
        sphere, wall, (n, n), load=load, height=0.6, periodic=periodic, **options
    )


def test_solve_is_the_inverse_of_the_product(periodic, rng):
    precon = rc.HalfSpacePrecon(make_atoms(periodic=periodic))
    x = rng.normal(size=3 * len(make_atoms(periodic=periodic)))
    np.testing.assert_allclose(precon.solve(precon.Pdot(x)), x, rtol=1e-12)
    np.testing.assert_allclose(precon.Pdot(precon.solve(x)), x, rtol=1e-12)


def test_preconditioner_is_symmetric_and_positive_definite(periodic):
    matrix = rc.HalfSpacePrecon(make_atoms(4, periodic=periodic)).asarray()
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-13 * matrix.max())
    assert np.linalg.eigvalsh(matrix).min() > 0.0


def test_preconditioner_is_the_hessian_of_the_solid_and_the_reference(rng):
    atoms = make_atoms()
    atoms.positions[-1, 2] = 30.0
    u = rng.normal(size=len(atoms) - 1)
    atoms.positions[:-1, 2] = u
    x = np.zeros((len(atoms), 3))
    x[:-1, 2] = u
    product = rc.HalfSpacePrecon(atoms).Pdot(x.ravel()).reshape(-1, 3)[:-1, 2]
    elastic = -atoms.get_forces()[:-1, 2]
    np.testing.assert_allclose(product, elastic + 3.0 * u, atol=1e-12)


def fine_atoms(fixed):
    """Atoms four times as fine as the range of the wall."""
    sphere = rc.RoughSphere(radius=40.0)
    atoms = rc.substrate("Cu", (24, 24), sphere, spacing=0.25, height=0.6, fixed=fixed)
    wall = rc.LennardJones93.repulsive(1.0, 1.0)
    load = 0.0 if fixed else 0.5
    atoms.calc = rc.RoughContact(sphere, 1.0, wall, load=load)
    return atoms


@pytest.mark.parametrize("fixed", [True, False], ids=["height", "load"])
@pytest.mark.parametrize(
    "optimizer, options, accuracy",
    [(PreconLBFGS, {"memory": 20}, 1e-8), (PreconFIRE, {"maxmove": 5.0}, 1e-6)],
)
def test_optimizers_reach_the_same_energy_in_fewer_steps(
    optimizer, options, accuracy, fixed
):
    reference, atoms, plain = (fine_atoms(fixed) for _ in range(3))
    assert rc.NewtonKrylov(reference).run(fmax=1e-9)
    precon = rc.HalfSpacePrecon(atoms)
    dynamics = optimizer(atoms, precon=precon, logfile=None, **options)
    assert dynamics.run(fmax=1e-6, steps=1000)
    energy = reference.get_potential_energy()
    assert atoms.get_potential_energy() == pytest.approx(energy, rel=accuracy)
    slow = optimizer(plain, precon=None, logfile=None, **options)
    assert not slow.run(fmax=1e-6, steps=dynamics.nsteps)
