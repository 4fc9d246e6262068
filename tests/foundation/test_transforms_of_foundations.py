"""Fourier transforms of explicit atoms on a crystal: engine and precision."""

import numpy as np
import pytest
from numpy_transform import NumpyTransform, with_numpy
from pair_crystal import slab

from ase_roughcontact.foundation import FoundationPrecon


@pytest.fixture(autouse=True)
def known():
    with with_numpy():
        yield


def rattled(surface, **fft):
    atoms = slab(surface, 3, fft=fft)
    atoms.rattle(0.05, seed=1)
    return atoms


def test_foundations_are_the_same_with_a_transform_of_ones_own(surface):
    usual, own = rattled(surface), rattled(surface, engine="numpy")
    energy, forces = usual.get_potential_energy(), usual.get_forces()
    assert NumpyTransform.forward == 0
    assert own.get_potential_energy() == pytest.approx(energy, abs=1e-12)
    np.testing.assert_allclose(own.get_forces(), forces, atol=1e-12)
    # three components of each coupled layer
    components = 3 * own.calc.coupled_layers
    assert NumpyTransform.forward == NumpyTransform.inverse == components
    vectors = np.random.default_rng(1).normal(size=(len(own), 3))
    solved = [
        FoundationPrecon(atoms, atoms.calc).solve(vectors) for atoms in (usual, own)
    ]
    np.testing.assert_allclose(solved[1], solved[0], atol=1e-12)
    assert NumpyTransform.forward > components


def test_foundations_have_the_precision_of_the_transforms(surface):
    double, single = rattled(surface), rattled(surface, dtype="float32", engine="numpy")
    forces = double.get_forces()
    largest = abs(forces).max()
    np.testing.assert_allclose(single.get_forces(), forces, atol=1e-5 * largest)
    assert NumpyTransform.precisions == {"float32"}
