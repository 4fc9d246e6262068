"""Every solver on every solid: results that do not depend on the solver."""

from dataclasses import dataclass

import numpy as np
import pytest
from ase.optimize import LBFGS
from ase.optimize.precon import PreconLBFGS
from built import atoms_under
from pressed import ROUGH, SOFT, largest_force, pressed_atoms
from scipy.optimize import lsq_linear
from solids import CONTINUA

import ase_roughcontact as rc
from ase_roughcontact.atoms.calculator import contact_of
from ase_roughcontact.elasticity import ElasticSolid, Isotropic, Layer
from ase_roughcontact.topography import BoundedSurface

SMOOTH = rc.RoughSphere(40.0)
WALLS = {
    "repulsive": SOFT,
    "adhesive": rc.LennardJones93.adhesive(1.0, 1.0, 0.02),
    "full": rc.LennardJones93.full(distance=1.0, work_of_adhesion=0.04, cutoff=3.0),
    "exponential": rc.ExponentialWall(0.04, 1.0, relative_cutoff=3.0),
}


@pytest.fixture(params=["crystal", *CONTINUA])
def solid(request, crystal):
    return crystal if request.param == "crystal" else CONTINUA[request.param]


@pytest.mark.parametrize("wall", WALLS)
def test_newton_leaves_no_forces(solid, wall, periodic):
    atoms = pressed_atoms(WALLS[wall], solid=solid, periodic=periodic)
    assert rc.NewtonKrylov(atoms).run(fmax=1e-8)
    assert atoms.calc.state(atoms).repulsive_atoms > 3
    assert largest_force(atoms) < 1.1e-8


@pytest.mark.parametrize(
    "method",
    [
        lambda atoms: LBFGS(rc.FourierModes(atoms), logfile=None),
        lambda a: PreconLBFGS(a, precon=rc.HalfSpacePrecon(a), logfile=None),
    ],
    ids=["LBFGS", "PreconLBFGS"],
)
def test_optimizers_of_ase_agree_with_newton(solid, method, periodic):
    forces = []
    for optimizer in (rc.NewtonKrylov, method):
        atoms = pressed_atoms(solid=solid, periodic=periodic)
        assert optimizer(atoms).run(fmax=1e-6, steps=800)
        forces.append(atoms.calc.state(atoms).normal_force)
    assert forces[0] == pytest.approx(forces[1], rel=1e-4)


@pytest.mark.parametrize("hardness", [np.inf, 0.06], ids=["hard", "plastic"])
def test_active_set_is_the_solution_of_the_dense_problem(solid, hardness):
    # 0 <= p <= H that minimises p.G.p/2 + g.p, by least squares with the Cholesky
    # factor
    atoms = pressed_atoms(rc.PlasticWall(hardness), solid=solid, n=10)
    assert rc.ActiveSet(atoms).run(fmax=1e-9)
    state, contact = atoms.calc.state(atoms), contact_of(atoms)
    i, j = (k.ravel() for k in np.indices((10, 10)))
    dense = solid.cell_compliance(i[:, None] - i, j[:, None] - j, 1.0)
    factor = np.linalg.cholesky(dense)
    gap = (contact.heights + atoms.positions[-1, 2]).ravel()
    load = -np.linalg.solve(factor, gap)
    expected = lsq_linear(factor.T, load, (0.0, hardness), method="bvls").x
    np.testing.assert_allclose(state.pressure.ravel(), expected, atol=1e-7)
    assert (expected > 0.0).sum() > 5
    assert hardness == np.inf or 0 < (expected == hardness).sum() < 100


@pytest.mark.parametrize("wall", [rc.HardWall(), SOFT], ids=["hard", "soft"])
def test_automatic_windows_agree_with_a_large_one(solid, wall):
    results = []
    for window, n in (("auto", 8), ("fixed", 48)):
        atoms = pressed_atoms(wall, solid=solid, n=n, fixed=False)
        path = rc.load_path(atoms, loads=[2.0, 10.0], fmax=1e-7, window=window)
        results.append(list(path))
    for auto, fixed in zip(*results, strict=True):
        assert auto.converged and fixed.converged
        assert auto.repulsive_atoms == fixed.repulsive_atoms
        assert auto.penetration == pytest.approx(fixed.penetration, abs=1e-5)


@dataclass(frozen=True)
class Brim(BoundedSurface):
    """Paraboloid with a flat brim, a little above the surface around its contact."""

    brim: float

    def heights(self, shape, spacing, origin=(0.0, 0.0)):
        x, y = (o + spacing * np.arange(n) for o, n in zip(origin, shape, strict=True))
        r = np.hypot(x[:, None], y)
        return np.where(r < 5.5, r**2 / 20, np.where(r < 9.0, self.brim, r**2))

    def reach(self, level, spacing, origin=(0.0, 0.0)):
        if level < self.brim:
            return min(5.5, np.sqrt(20 * max(level, 0.0)))
        return max(9.0, np.sqrt(level))


def test_atoms_that_a_bulge_lifts_into_contact_are_in_the_window():
    indenter, touching = Brim(1.005), []
    for window, n in (("auto", 4), ("fixed", 40)):
        atoms = atoms_under(indenter, rc.HardWall(), (n, n), solid=Layer(1.0, 3.0))
        (step,) = rc.load_path(atoms, penetrations=[1.0], fmax=1e-7, window=window)
        assert step.converged
        touching.append(step.repulsive_atoms)
    assert touching[0] == touching[1] > 50


def test_spacing_of_atoms_and_crystal_must_agree(crystal):
    atoms = atoms_under(SMOOTH, shape=(4, 4), solid=crystal, spacing=1.1)
    with pytest.raises(ValueError, match="build it with spacing"):
        atoms.get_potential_energy()


class Skew(ElasticSolid):
    """Softer along one diagonal than along the other."""

    contact_modulus = 1.0

    def wave_compliance(self, qx, qy):
        q2 = qx**2 + qy**2
        return 2.0 * (1.0 + 0.1 * qx * qy / q2) / np.sqrt(q2)

    def cell_compliance(self, i, j, spacing):
        return Isotropic(1.0).cell_compliance(i, j, spacing)


def test_a_solid_without_the_symmetry_is_refused():
    atoms = atoms_under(ROUGH, shape=(4, 4), solid=Skew())
    with pytest.raises(ValueError, match="plane waves must be even in x and in y"):
        atoms.get_potential_energy()
