"""Lateral displacements by lateral tractions, against integrals and dense matrices."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ase_roughcontact.elasticity import (
    Crystal,
    Cubic,
    Isotropic,
    Layer,
    Viscoelastic,
    cerruti_kernel,
)
from ase_roughcontact.elasticity.creep import Creep
from ase_roughcontact.elasticity.lateral import LateralHalfSpace


@pytest.mark.parametrize(
    "cell", [(1, 0), (3, -2), (-20, 7), (159, 60), (160, 159), (170, 30)]
)
def test_kernel_is_the_integral_over_a_cell(cell):
    nu, (i, j) = 0.3, cell

    def integral(numerator):  # by Gauss's formula
        x, weights = np.polynomial.legendre.leggauss(40)
        x, y = i + 0.5 * x[:, None], j + 0.5 * x
        values = numerator(x, y) / np.hypot(x, y) ** 3
        return float(weights @ values @ weights) / 4.0

    xx, yy, xy = (
        integral(f)
        for f in (lambda x, y: x * x, lambda x, y: y * y, lambda x, y: x * y)
    )
    expected = np.array([xx + (1 - nu) * yy, (1 - nu) * xx + yy, nu * xy])
    expected *= 1.5 / (np.pi * 2.0 * (1 - nu))
    found = cerruti_kernel(i, j, 1.5, 2.0, nu)
    assert_allclose(found, expected, rtol=1e-10, atol=1e-13 * expected.max())


@pytest.mark.parametrize("shape", [(7, 5), (6, 8)])
def test_free_half_space_is_the_dense_matrix(shape):
    solid, (n, m) = Isotropic(2.0, 0.3), shape
    i, j = (index.ravel() for index in np.indices(shape))
    xx, yy, xy = cerruti_kernel(i[:, None] - i, j[:, None] - j, 1.3, 2.0, 0.3)
    dense = np.block([[xx, xy], [xy, yy]])
    tractions = np.random.default_rng(1).normal(size=(2, n, m))
    found = LateralHalfSpace(shape, 1.3, solid).displacement(tractions)
    assert_allclose(found.ravel(), dense @ tractions.ravel(), atol=1e-12)


@pytest.mark.parametrize("periodic", [False, True])
@pytest.mark.parametrize("shape", [(7, 5), (6, 8)])
def test_tractions_of_the_whole_grid_cause_its_displacement(shape, periodic):
    half = LateralHalfSpace(shape, 1.3, Isotropic(2.0, 0.3), periodic)
    tractions = np.random.default_rng(1).normal(size=(2, *half.grid))
    if periodic:
        tractions -= tractions.mean(axis=(1, 2), keepdims=True)
    displacement = half.displacement(tractions)
    assert_allclose(half.tractions(displacement), tractions, atol=1e-12)
    if periodic:  # a uniform displacement costs nothing
        assert_allclose(half.tractions(displacement + 1.0), tractions, atol=1e-12)


@pytest.mark.parametrize("number", [(3, 0), (2, 5), (4, -1)])
def test_periodic_waves_have_the_compliances_along_and_across(number):
    n, modulus, nu = 16, 2.0, 0.3
    half = LateralHalfSpace((n, n), 1.0, Isotropic(modulus, nu), periodic=True)
    x, y = np.indices((n, n))
    qx, qy = 2.0 * np.pi / n * np.array(number)
    q, wave = np.hypot(qx, qy), np.cos(qx * x + qy * y)
    along = np.array([qx, qy])[:, None, None] / q * wave
    across = np.array([-qy, qx])[:, None, None] / q * wave
    assert_allclose(half.displacement(along), 2.0 / (modulus * q) * along, atol=1e-9)
    expected = 2.0 / (modulus * (1.0 - nu) * q) * across
    assert_allclose(half.displacement(across), expected, atol=1e-9)


COPPER = (168.4, 121.4, 75.4)


@pytest.mark.parametrize("cell", [(2, 1), (0, 3), (-33, 12)])
def test_kernel_of_a_cubic_solid_is_the_integral_of_its_greens_function(cell):
    x, weights = np.polynomial.legendre.leggauss(30)
    x, y = cell[0] + 0.5 * x[:, None], cell[1] + 0.5 * x
    solid, i, j = Cubic(*COPPER), *np.array(cell)[:, None]
    r2 = x**2 + y**2  # |q| times the compliance of the wave across the distance
    greens = solid.lateral_wave_compliance(-y / r2, x / r2) / (2.0 * np.pi * r2)
    expected = weights @ greens @ weights / 4.0
    found = solid.lateral_cell_compliance(i, j, 1.0)[:, 0]
    assert_allclose(found, expected, atol=1e-8 * expected[0])


def test_cubic_solid_is_the_same_in_other_axes():
    c, s = np.cos(np.pi / 4), np.sin(np.pi / 4)
    turn, q = np.array([[c, s], [-s, c]]), np.array([0.3, 0.1])
    xx, yy, xy = Cubic(*COPPER, "100").lateral_wave_compliance(*(turn.T @ q))
    expected = turn @ [[xx, xy], [xy, yy]] @ turn.T
    xx, yy, xy = Cubic(*COPPER).lateral_wave_compliance(*q)
    assert_allclose([[xx, xy], [xy, yy]], expected, rtol=1e-12)


def test_free_crystal_is_a_large_periodic_one(crystal):
    n, periodic = 60, LateralHalfSpace((400, 400), crystal.spacing, crystal, True)
    tractions = np.zeros((2, n, n))
    tractions[:, 10, 10], tractions[:, 15, 13] = 1.0, -1.0  # in balance
    padded = np.pad(tractions, ((0, 0), (170, 170), (170, 170)))
    expected = periodic.displacement(padded)[:, 170:-170, 170:-170]
    found = LateralHalfSpace((n, n), crystal.spacing, crystal).displacement(tractions)
    difference = found - expected
    difference -= difference.mean(axis=(1, 2), keepdims=True)
    assert abs(difference).max() < 3e-5 * abs(found).max()


def test_lateral_components_of_a_crystal_are_in_its_file(crystal, tmp_path):
    crystal.write(tmp_path / "springs.json")
    found = Crystal.read(tmp_path / "springs.json")
    assert_allclose(found.lateral, crystal.lateral, rtol=0.0)
    with pytest.raises(NotImplementedError, match="lateral components"):
        LateralHalfSpace((4, 4), crystal.spacing, replace(crystal, lateral=None))


def test_solids_without_lateral_components_say_so():
    for solid in (Isotropic(1.0), Layer(1.0, 3.0)):
        for periodic in (False, True):
            with pytest.raises(NotImplementedError, match="which friction needs"):
                LateralHalfSpace((4, 4), 1.0, solid, periodic)
    creeping = Viscoelastic(Isotropic(1.0, 0.3), Creep([1.0], [1.0]))
    with pytest.raises(NotImplementedError, match="which friction needs"):
        LateralHalfSpace((4, 4), 1.0, creeping)
