"""Half spaces without a margin: the same energies and forces from fewer atoms."""

import numpy as np
import pytest
from ase.optimize import FIRE2
from built import atoms_under, force_along

import ase_roughcontact as rc
from ase_roughcontact.atoms.calculator import contact_of, problem_of
from ase_roughcontact.atoms.exchange import set_window
from ase_roughcontact.elasticity import love_kernel
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.elasticity.reduced import ReducedHalfSpace
from ase_roughcontact.windows.footprint import Footprint

SHAPE = 9, 7
ROUGH = rc.SelfAffine(0.3, 0.8, 4.0, 16.0, seed=3, domain=64.0)
SPHERE = rc.RoughSphere(60.0, ROUGH)
SOFT = rc.LennardJones93.repulsive(1.0, 1.0)
ADHESIVE = rc.LennardJones93.adhesive(1.0, 1.0, 0.02)


def make_atoms(window=None, wall=SOFT, shape=(24, 24), **options):
    atoms = atoms_under(SPHERE, wall, shape, **options)
    atoms.positions[-1, 2] = contact_of(atoms).first_contact - 0.3
    if window is not None:
        set_window(atoms, window)
    return atoms


def fields(atoms):
    """State of a contact, and the lattice indices of the atoms in contact."""
    state = atoms.calc.state(atoms)
    start = problem_of(atoms)[1].start
    return state, {(i, j) for i, j in (np.argwhere(state.contact) + start).tolist()}


# Half spaces


def test_displacement_agrees_with_a_window_in_its_margin(rng):
    pressure = rng.normal(size=SHAPE)
    found, expected = (
        kind(SHAPE, 0.7, 3.0).displacement(pressure)
        for kind in (ReducedHalfSpace, FreeHalfSpace)
    )
    np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_pressure_of_a_condensed_window_agrees_with_the_dense_matrix(rng):
    displacement = rng.normal(size=SHAPE)
    i, j = np.indices(SHAPE).reshape(2, -1)
    dense = love_kernel(i[:, None] - i, j[:, None] - j, 1.0, 1.0)
    expected = -np.linalg.solve(dense, displacement.ravel())
    found = ReducedHalfSpace(SHAPE, 1.0, 1.0).elastic_pressure(displacement)
    np.testing.assert_allclose(found.ravel(), expected, rtol=1e-9, atol=1e-11)


def test_pressure_that_does_not_converge_or_is_not_finite_is_an_error():
    halfspace = ReducedHalfSpace(SHAPE, 1.0, 1.0)
    halfspace.max_iterations = 1
    with pytest.raises(RuntimeError, match="increase max_iterations"):
        halfspace.elastic_pressure(np.eye(*SHAPE))
    with pytest.raises(ValueError, match="finite"):
        halfspace.elastic_pressure(np.full(SHAPE, np.nan))


# Atoms


@pytest.mark.parametrize("wall", [SOFT, ADHESIVE], ids=["repulsive", "adhesive"])
def test_forces_are_the_slope_of_the_energy(wall, rng):
    window = Box((-5, -4), (11, 9))
    atoms = make_atoms(window, wall)
    atoms.positions[:-1, 2] += 0.05 * rng.normal(size=len(atoms) - 1)
    forces = atoms.get_forces(apply_constraint=False)
    direction = rng.normal(size=(len(atoms), 1)) * [0.0, 0.0, 1.0]
    expected = force_along(atoms, direction, 1e-4)
    assert (forces * direction).sum() == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("wall", [SOFT, ADHESIVE, rc.HardWall()])
def test_relaxed_contact_is_the_same_with_and_without_the_margin(wall):
    optimizer = rc.ActiveSet if isinstance(wall, rc.HardWall) else rc.NewtonKrylov
    whole = make_atoms(wall=wall, shape=(64, 64))
    reach = Footprint(SPHERE, 1.0).box_below(wall.cutoff - whole.positions[-1, 2] + 0.5)
    states = []
    for atoms in (whole, make_atoms(reach, wall)):
        assert optimizer(atoms).run(fmax=1e-12)
        states.append(fields(atoms))
    (one, contact), (other, same) = states
    assert other.normal_force == pytest.approx(one.normal_force, rel=1e-10)
    assert other.energy == pytest.approx(one.energy, rel=1e-10)
    assert contact == same and len(contact) > 5


def test_modes_of_a_condensed_window_agree_with_its_grid():
    window = Box((-6, -6), (13, 12))
    atoms, expected = make_atoms(window), make_atoms(window)
    atoms.positions[:-1, 2] -= 0.01
    modes = rc.FourierModes(atoms)
    assert FIRE2(modes, logfile=None, maxstep=modes.maxstep).run(fmax=1e-8, steps=2000)
    assert rc.NewtonKrylov(expected).run(fmax=1e-10)
    np.testing.assert_allclose(atoms.positions, expected.positions, atol=1e-6)


def test_preconditioner_of_a_condensed_window_is_positive_definite():
    values = np.linalg.eigvalsh(
        rc.HalfSpacePrecon(make_atoms(Box((-3, -3), (5, 4)))).asarray()
    )
    assert values.min() > 0.0


def test_adhesive_window_grows_when_the_surface_bulges():
    wall = rc.LennardJones93.adhesive(1.0, 1.0, 0.003)
    sphere = rc.RoughSphere(1e4, rc.SelfAffine(0.1, 0.8, 4.0, 256.0, seed=0))
    records = []
    for window in ("auto", "fixed"):
        atoms = rc.substrate("Cu", (511, 511), sphere, spacing=1.0)
        atoms.calc = rc.RoughContact(sphere, 1.0, wall)
        path = rc.load_path(atoms, penetrations=[0.0, 0.1], window=window, fmax=1e-10)
        records.append(list(path))
    for one, other in zip(*records, strict=True):
        assert one.normal_force == pytest.approx(other.normal_force, abs=1e-9)
        assert one.attractive_atoms == other.attractive_atoms
