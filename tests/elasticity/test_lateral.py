"""Lateral displacements by lateral tractions, against integrals and dense matrices."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ase_roughcontact.elasticity import Cubic, Isotropic, Viscoelastic, cerruti_kernel
from ase_roughcontact.elasticity.creep import Creep
from ase_roughcontact.elasticity.lateral import LateralHalfSpace


@pytest.mark.parametrize("cell", [(1, 0), (3, -2), (-20, 7), (170, 30)])
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


def test_series_continue_the_closed_form():
    distances = np.array([159, 160])  # on both sides of the change
    for j in (0, 1, 60, 159):
        near, far = cerruti_kernel(distances, j, 1.0, 1.0, 0.4).T
        r = np.hypot(distances, j)
        slope = far[0] * r[1] / (near[0] * r[0])
        assert slope == pytest.approx(1.0, abs=1e-2)


@pytest.mark.parametrize("shape", [(7, 5), (6, 8)])
def test_free_half_space_is_the_dense_matrix(shape):
    solid, (n, m) = Isotropic(2.0, 0.3), shape
    i, j = (index.ravel() for index in np.indices(shape))
    xx, yy, xy = cerruti_kernel(i[:, None] - i, j[:, None] - j, 1.3, 2.0, 0.3)
    dense = np.block([[xx, xy], [xy, yy]])
    tractions = np.random.default_rng(1).normal(size=(2, n, m))
    found = LateralHalfSpace(shape, 1.3, solid).displacement(tractions)
    assert_allclose(found.ravel(), dense @ tractions.ravel(), atol=1e-12)


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


def test_solids_without_lateral_components_say_so():
    for solid in (Isotropic(1.0), Cubic(3.0, 1.0, 1.0)):
        for periodic in (False, True):
            with pytest.raises(NotImplementedError, match="which friction needs"):
                LateralHalfSpace((4, 4), 1.0, solid, periodic)
    creeping = Viscoelastic(Isotropic(1.0, 0.3), Creep([1.0], [1.0]))
    with pytest.raises(NotImplementedError, match="which friction needs"):
        LateralHalfSpace((4, 4), 1.0, creeping)
