"""Energy, forces and Hessian of atoms on a semi-infinite crystal."""

import numpy as np
import pytest
from ase import Atom
from built import force_along
from pair_crystal import pair_potential, slab
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from ase_roughcontact.foundation import CrystalSurface

SURFACES = ["surface", "hexagonal_surface", "diamond_surface"]


def rattled(surface, layers=3):
    """Atoms displaced at random, and their calculator."""
    atoms = slab(surface, layers, held=False)
    atoms.rattle(0.05, seed=1)
    return atoms


@pytest.mark.parametrize("layers", [1, 2, 3, 9])
def test_no_force_at_rest_and_under_a_uniform_shift(surface, layers):
    atoms = slab(surface, layers, held=False)
    energy = atoms.get_potential_energy()
    assert abs(atoms.get_forces()).max() < 2e-6
    atoms.positions += [0.7, -40.0, 3.0]
    assert abs(atoms.get_forces()).max() < 2e-6
    assert atoms.get_potential_energy() == pytest.approx(energy, abs=1e-10)


@pytest.mark.parametrize("name", ["surface", "hexagonal_surface"])
def test_forces_are_minus_the_gradient_and_have_no_resultant(request, name):
    atoms = rattled(request.getfixturevalue(name))
    atoms.append("Cu")
    atoms.positions[-1] = atoms.positions[-2] + [1.2, 1.1, 1.8]
    forces = atoms.get_forces()
    np.testing.assert_allclose(forces.sum(axis=0), 0.0, atol=1e-11)
    direction = np.random.default_rng(2).normal(size=forces.shape)
    expected = force_along(atoms, direction)
    assert np.sum(forces * direction) == pytest.approx(expected, rel=1e-6)


def on_the_surface(atoms, hessian, depth=0.0):
    """Hessian with all atoms relaxed except at the surface, or above a depth."""
    top = atoms.positions[:, 2] > -depth - 0.1
    kept, relaxed = (np.flatnonzero(np.repeat(mask, 3)) for mask in (top, ~top))
    hessian = csc_matrix(hessian)
    if not relaxed.size:
        return hessian.toarray()
    coupling = hessian[relaxed][:, kept].toarray()
    solved = splu(hessian[relaxed][:, relaxed]).solve(coupling)
    return hessian[kept][:, kept].toarray() - coupling.T @ solved


def hessian_of_calculator(atoms):
    calculator, atoms = atoms.calc.calculator, atoms.copy()
    atoms.calc = calculator
    atoms.get_potential_energy()
    return atoms.calc.get_hessian(atoms, "sparse").toarray()


def hessian_with_foundation(atoms):
    hessian = hessian_of_calculator(atoms)
    coupling, sites = atoms.calc.coupling, atoms.calc.sites
    rows = (3 * sites.indices.reshape(-1, 1) + np.arange(3)).ravel()
    unit = np.eye(rows.size).reshape(-1, *sites.positions.shape)
    rest = coupling.evaluate(0 * unit[0])[1]
    added = [rest - coupling.evaluate(one)[1] for one in unit]
    hessian[np.ix_(rows, rows)] += np.reshape(added, (rows.size, rows.size))
    return hessian


@pytest.mark.parametrize("name", SURFACES)
def test_the_hessian_on_the_surface_agrees_with_a_thick_slab(request, name):
    surface = request.getfixturevalue(name)
    thick = slab(surface, 41, held=False)
    whole = hessian_of_calculator(thick)
    for layers in (1, 2, 3, surface.bulk_depth + 1):
        atoms = slab(surface, layers, held=False)
        depth = -atoms.positions[:, 2].min() if layers > 3 else 0.0
        expected = on_the_surface(thick, whole, depth)
        found = on_the_surface(atoms, hessian_with_foundation(atoms), depth)
        np.testing.assert_allclose(found, expected, atol=1e-6 * abs(expected).max())


def test_the_half_crystal_acts_on_the_layers_that_forces_reach_from_below(surface):
    atoms = slab(surface, 9, (3, 3))
    # the cutoff is 2.6 distances of layers, and the third layer feels the cut
    assert atoms.calc.coupled_layers == 2
    assert sorted(atoms.calc.sites.indices.ravel()) == list(range(2 * 9))


def test_the_result_does_not_depend_on_the_order_and_the_images_of_the_atoms(surface):
    atoms, moved = slab(surface, 3, held=False), rattled(surface)
    random = np.random.default_rng(3)
    order = random.permutation(len(atoms))
    mixed = atoms[order]
    mixed.calc = type(atoms.calc)(pair_potential(), surface, mixed)
    images = np.rint(random.uniform(-2, 2, (len(atoms), 2)))
    mixed.positions = moved.positions[order] + images @ np.array(atoms.cell[:2])
    assert mixed.get_potential_energy() == pytest.approx(moved.get_potential_energy())
    np.testing.assert_allclose(mixed.get_forces(), moved.get_forces()[order], atol=1e-9)


def test_atoms_without_a_number_are_not_given_to_the_calculator(surface):
    atoms = rattled(surface, 2)
    atoms.calc.hold(atoms)
    expected = atoms.get_forces()
    atoms.append(Atom("X", (1.0, 2.0, 3.0)))
    np.testing.assert_allclose(atoms.get_forces()[:-1], expected, atol=1e-12)
    np.testing.assert_array_equal(atoms.get_forces()[-1], 0.0)


def test_a_surface_from_a_file_is_the_same(surface, tmp_path):
    file = tmp_path / "copper.json"
    surface.write(file)
    expected, found = slab(surface, 3), slab(CrystalSurface.read(file), 3)
    np.testing.assert_array_equal(found.positions, expected.positions)
    for atoms in (expected, found):
        atoms.positions[4] += [0.1, 0.2, -0.1]
    np.testing.assert_array_equal(found.get_forces(), expected.get_forces())
