"""Half spaces without a margin: the same energies and forces from fewer atoms."""

import numpy as np
import pytest
from ase.io import read, write
from ase.optimize import FIRE2, LBFGS

from ase_roughcontact import (
    ActiveSet,
    FourierModes,
    HalfSpacePrecon,
    HardWall,
    LennardJones93,
    NewtonKrylov,
    RoughContact,
    RoughSphere,
    SelfAffine,
    load_path,
    snapshot,
    substrate,
)
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace
from ase_roughcontact.elasticity.lattice import Box, Sites
from ase_roughcontact.elasticity.reduced import ReducedHalfSpace, ScatteredHalfSpace
from ase_roughcontact.windows.exchange import exchange_window
from ase_roughcontact.windows.footprint import Footprint
from ase_roughcontact.windows.policy import window_of

SHAPE = 9, 7
ROUGH = SelfAffine(0.3, 0.8, 4.0, 16.0, seed=3, domain=64.0)
SPHERE = RoughSphere(60.0, ROUGH)
SOFT = LennardJones93.repulsive(1.0, 1.0)
ADHESIVE = LennardJones93.adhesive(1.0, 1.0, 0.02)


def lattice(shape=SHAPE):
    return np.argwhere(np.ones(shape, bool))


def make_atoms(window=None, wall=SOFT, shape=(24, 24), **options):
    atoms = substrate("Cu", shape, SPHERE, spacing=1.0, **options)
    atoms.calc = RoughContact(SPHERE, 1.0, wall)
    atoms.positions[-1, 2] = atoms.calc.contact(atoms).first_contact - 0.3
    if window is not None:
        exchange_window(atoms, window)
    return atoms


def low_sites(count=40):
    return Footprint(SPHERE, 1.0).lowest_sites(count)


def fields(atoms):
    """What a calculator tells of a contact, by place."""
    state = atoms.calc.state(atoms)
    places = window_of(atoms.calc.layout(atoms)).places(state.contact)
    return state, {tuple(place) for place in places.tolist()}


# Half spaces


@pytest.mark.parametrize(
    "halfspace",
    [
        ReducedHalfSpace(SHAPE, 0.7, 3.0),
        ScatteredHalfSpace(lattice(), 0.7, 3.0),
    ],
    ids=["condensed", "scattered"],
)
def test_displacement_is_that_of_a_window_in_its_margin(halfspace, rng):
    pressure = rng.normal(size=SHAPE)
    expected = FreeHalfSpace(SHAPE, 0.7, 3.0).displacement(pressure)
    found = halfspace.displacement(pressure.reshape(halfspace.shape))
    np.testing.assert_allclose(found.reshape(SHAPE), expected, rtol=1e-12)


@pytest.mark.parametrize(
    "halfspace",
    [
        ReducedHalfSpace((31, 20), 0.7, 3.0),
        ScatteredHalfSpace(lattice((31, 20))[::7] * 5, 0.7, 3.0),
    ],
    ids=["condensed", "scattered"],
)
def test_pressure_and_displacement_are_inverse(halfspace, rng):
    pressure = rng.normal(size=halfspace.shape)
    displacement = halfspace.padded_displacement(pressure)
    back = halfspace.elastic_pressure(displacement)
    np.testing.assert_allclose(back, pressure, atol=1e-10)


def test_pressure_of_a_condensed_window_is_that_of_the_dense_matrix(rng):
    displacement = rng.normal(size=SHAPE)
    dense = ScatteredHalfSpace(lattice(), 1.0, 1.0).matrix
    expected = -np.linalg.solve(dense, displacement.ravel())
    found = ReducedHalfSpace(SHAPE, 1.0, 1.0).elastic_pressure(displacement)
    np.testing.assert_allclose(found.ravel(), expected, rtol=1e-9, atol=1e-11)


def test_condensed_pressure_takes_few_transforms(rng):
    halfspace = ReducedHalfSpace((64, 64), 1.0, 1.0)
    halfspace.elastic_pressure(halfspace.displacement(rng.random((64, 64))))
    assert halfspace.pairs < 40


def test_scattered_atoms_tell_of_a_window_of_the_same_solid(rng):
    sites = ScatteredHalfSpace(lattice((2, 2)), 0.7, 3.0, threads=1)
    pressure = rng.uniform(size=(5, 4))
    got = sites.like((5, 4), 0.9).displacement(pressure)
    expected = ReducedHalfSpace((5, 4), 0.9, 3.0).displacement(pressure)
    np.testing.assert_allclose(got, expected, rtol=1e-13)


def test_pressure_that_can_t_be_found_is_an_error(monkeypatch):
    monkeypatch.setattr("ase_roughcontact.elasticity.reduced._STEPS", 1)
    with pytest.raises(RuntimeError, match="no pressure was found"):
        ReducedHalfSpace(SHAPE, 1.0, 1.0).elastic_pressure(np.eye(*SHAPE))


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_displacement_that_is_not_finite_has_no_pressure(bad):
    with pytest.raises(ValueError, match="displacement must be finite"):
        ReducedHalfSpace(SHAPE, 1.0, 1.0).elastic_pressure(np.full(SHAPE, bad))


def test_far_apart_atoms_barely_feel_each_other():
    matrix = ScatteredHalfSpace(np.array([[0, 0], [0, 100_000]]), 1.0, 1.0).matrix
    assert matrix[0, 1] == pytest.approx(1e-5 / np.pi, rel=1e-9)
    assert matrix[0, 0] == pytest.approx(4 * np.log(1 + np.sqrt(2)) / np.pi)


@pytest.mark.parametrize("sites", [np.zeros((0, 2)), np.zeros((3, 3)), np.zeros(4)])
def test_sites_that_are_none_are_refused(sites):
    with pytest.raises(ValueError, match="sites must have the shape"):
        ScatteredHalfSpace(sites, 1.0, 1.0)


# Atoms


@pytest.mark.parametrize("wall", [SOFT, ADHESIVE], ids=["repulsive", "adhesive"])
@pytest.mark.parametrize("kind", ["condensed", "scattered"])
def test_forces_are_the_slope_of_the_energy(kind, wall, rng):
    window = Box((-5, -4), (11, 9)) if kind == "condensed" else low_sites()
    atoms = make_atoms(window, wall)
    atoms.positions[:-1, 2] += 0.05 * rng.normal(size=len(atoms) - 1)
    forces, energy = atoms.get_forces(apply_constraint=False), []
    direction = rng.normal(size=len(atoms))
    start = atoms.positions[:, 2].copy()
    for step in (1e-4, -1e-4):
        atoms.positions[:, 2] = start + step * direction
        energy.append(atoms.get_potential_energy())
    slope = (energy[0] - energy[1]) / 2e-4
    assert slope == pytest.approx(-(forces[:, 2] @ direction), rel=1e-5)


@pytest.mark.parametrize("wall", [SOFT, ADHESIVE, HardWall()])
def test_relaxed_contact_is_the_same_with_and_without_the_margin(wall):
    optimizer = ActiveSet if isinstance(wall, HardWall) else NewtonKrylov
    whole = make_atoms(wall=wall, shape=(64, 64))
    reach = Footprint(SPHERE, 1.0).below(wall.cutoff - whole.positions[-1, 2] + 0.5)
    states = []
    for atoms in (whole, make_atoms(reach, wall)):
        assert optimizer(atoms).run(fmax=1e-12)
        states.append(fields(atoms))
    (one, contact), (other, same) = states
    assert other.normal_force == pytest.approx(one.normal_force, rel=1e-10)
    assert other.energy == pytest.approx(one.energy, rel=1e-10)
    assert contact == same and len(contact) > 5


@pytest.mark.parametrize("wall", [SOFT, HardWall()], ids=["soft", "hard"])
@pytest.mark.parametrize("seed", range(3))
def test_scattered_box_and_margin_agree(wall, seed):
    sphere = RoughSphere(2000.0, SelfAffine(0.2, 0.8, 4.0, 64.0, seed=seed))
    low = Footprint(sphere, 1.0)
    optimizer = ActiveSet if isinstance(wall, HardWall) else NewtonKrylov
    level = low.lowest + 0.4
    count = low.count(level)
    states = []
    for window in (low.below(level), low.lowest_sites(count), None):
        atoms = substrate("Cu", (255, 255), sphere, spacing=1.0)
        atoms.calc = RoughContact(sphere, 1.0, wall)
        atoms.positions[-1, 2] = wall.cutoff - level
        if window is not None:
            exchange_window(atoms, window)
        assert optimizer(atoms).run(fmax=1e-12)
        states.append(fields(atoms))
    assert count > 30
    for state, contact in states[1:]:
        assert contact == states[0][1]
        assert state.normal_force == pytest.approx(states[0][0].normal_force, rel=1e-10)


@pytest.mark.parametrize("kind", ["condensed", "scattered"])
def test_optimizers_of_ase_relax_atoms_without_a_margin(kind):
    window = Box((-6, -6), (13, 12)) if kind == "condensed" else low_sites(60)
    atoms, expected = make_atoms(window), make_atoms(window)
    assert NewtonKrylov(expected).run(fmax=1e-10)
    assert LBFGS(atoms, logfile=None).run(fmax=1e-8, steps=500)
    force = expected.calc.state(expected).normal_force
    assert atoms.calc.state(atoms).normal_force == pytest.approx(force, rel=1e-6)


def test_modes_of_a_condensed_window_are_those_of_its_grid():
    window = Box((-6, -6), (13, 12))
    atoms, expected = make_atoms(window), make_atoms(window)
    atoms.positions[:-1, 2] -= 0.01
    modes = FourierModes(atoms)
    assert FIRE2(modes, logfile=None, maxstep=modes.maxstep).run(fmax=1e-8, steps=2000)
    assert NewtonKrylov(expected).run(fmax=1e-10)
    np.testing.assert_allclose(atoms.positions, expected.positions, atol=1e-6)


def test_preconditioner_of_a_condensed_window_is_positive_definite():
    values = np.linalg.eigvalsh(
        HalfSpacePrecon(make_atoms(Box((-3, -3), (5, 4)))).asarray()
    )
    assert values.min() > 0.0


def test_scattered_atoms_have_no_modes():
    with pytest.raises(ValueError, match="no Fourier modes"):
        FourierModes(make_atoms(low_sites()))


@pytest.mark.parametrize("name", ["atoms.traj", "atoms.extxyz", "atoms.json"])
@pytest.mark.parametrize("kind", ["condensed", "scattered"])
def test_frames_are_good_for_a_calculation_as_they_are(kind, name, tmp_path):
    window = Box((-6, -6), (13, 12)) if kind == "condensed" else low_sites(60)
    atoms = make_atoms(window)
    assert NewtonKrylov(atoms).run(fmax=1e-10)
    write(tmp_path / name, snapshot(atoms))
    back = read(tmp_path / name)
    back.calc = RoughContact(SPHERE, 1.0, SOFT)
    force = atoms.calc.state(atoms).normal_force
    assert back.calc.state(back).normal_force == pytest.approx(force, rel=1e-6)
    assert np.abs(back.get_forces()[:-1]).max() < 1e-6


def test_scattered_atoms_that_are_none_are_refused():
    atoms = make_atoms(low_sites())
    atoms.positions[3, 0] += 0.2
    with pytest.raises(ValueError, match=r"off the lattice by 0\.2"):
        atoms.get_potential_energy()
    atoms.positions[3] = atoms.positions[2]
    with pytest.raises(ValueError, match="several atoms"):
        atoms.get_potential_energy()
    atoms = make_atoms(low_sites())
    atoms.cell[0, 0] += 1.0
    with pytest.raises(ValueError, match="must span the cell"):
        atoms.get_potential_energy()


def test_scattered_atoms_in_a_fixed_window_know_no_edge():
    atoms = make_atoms(low_sites())
    with pytest.raises(RuntimeError, match="no edge"):
        next(load_path(atoms, [0.3]))
    assert next(load_path(atoms, [0.3], edge="ignore")).converged


# Which window


def test_lowest_sites_are_the_lowest():
    heights = SPHERE.heights((64, 64), 1.0, (-32.0, -32.0))
    low = low_sites(100)
    index = tuple((low.all + 32).T)
    np.testing.assert_array_equal(heights[index], np.sort(heights, axis=None)[:100])


def test_places_are_found_in_boxes_and_among_sites():
    places = np.array([[1, 2], [5, 5], [-3, 0]])
    box, sites = Box((0, 1), (6, 4)), Sites(np.array([[5, 5], [-3, 0], [7, 7]]))
    inside, index = box.find(places)
    assert inside.tolist() == [True, False, False] and np.array(index).T.tolist() == [
        [1, 1]
    ]
    inside, index = sites.find(places)
    assert inside.tolist() == [False, True, True]
    assert np.array(index).T.tolist() == [[0, 0], [1, 0]]
    assert sites.box == Box((-3, 0), (11, 8))


def test_few_atoms_far_apart_are_scattered_and_many_are_in_a_box():
    sphere = RoughSphere(1e5, SelfAffine(0.1, 0.8, 4.0, 512.0, seed=1))
    atoms = substrate("Cu", (8, 8), sphere, spacing=1.0, fixed=False)
    atoms.calc = RoughContact(sphere, 1.0, HardWall())
    kinds = []
    for record in load_path(atoms, loads=[0.1, 0.3, 30.0], window="auto"):
        assert record.converged
        kinds.append(type(window_of(atoms.calc.layout(atoms))))
    assert kinds == [Sites, Sites, Box]


def test_adhesive_sites_grow_when_the_surface_bulges():
    wall = LennardJones93.adhesive(1.0, 1.0, 0.003)
    sphere = RoughSphere(1e4, SelfAffine(0.1, 0.8, 4.0, 256.0, seed=0))
    records = []
    for window in ("auto", "fixed"):
        atoms = substrate("Cu", (511, 511), sphere, spacing=1.0)
        atoms.calc = RoughContact(sphere, 1.0, wall)
        path = load_path(atoms, [0.0, 0.1], window=window, fmax=1e-10)
        records.append(list(path))
        if window == "auto":
            assert isinstance(window_of(atoms.calc.layout(atoms)), Sites)
    for one, other in zip(*records, strict=True):
        assert one.normal_force == pytest.approx(other.normal_force, abs=1e-9)
        assert one.attractive_atoms == other.attractive_atoms
