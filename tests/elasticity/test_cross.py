"""Coupling of normal and lateral motion, against integrals, waves and each other."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ase_roughcontact.elasticity import (
    Cubic,
    Isotropic,
    Layer,
    PeriodicHalfSpace,
    Viscoelastic,
    cross_kernel,
)
from ase_roughcontact.elasticity.creep import Creep
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace
from ase_roughcontact.elasticity.lateral import CrossResponse, LateralHalfSpace
from ase_roughcontact.elasticity.named_materials import dundurs_parameter

NU, BETA = 0.3, 0.4 / 1.4
COPPER = (168.4, 121.4, 75.4)


def far_field(x, y, modulus=2.0, nu=NU):
    """Displacement by a unit normal point force, Johnson, Eq. (3.18): towards it."""
    shear = 0.5 * modulus * (1.0 - nu)
    return -(1.0 - 2.0 * nu) / (4.0 * np.pi * shear) * np.array([x, y]) / (x**2 + y**2)


@pytest.mark.parametrize("cell", [(1, 0), (0, -3), (-1, 2), (6, -5), (8, 0), (-20, 7)])
def test_kernel_is_the_integral_over_a_cell(cell):
    x, weights = np.polynomial.legendre.leggauss(40)
    x, y = cell[0] + 0.5 * x[:, None], cell[1] + 0.5 * x
    values = far_field(*np.broadcast_arrays(1.5 * x, 1.5 * y)) * 1.5**2
    expected = weights @ values @ weights / 4.0
    found = cross_kernel(*cell, 1.5, 2.0, BETA)
    assert_allclose(found, expected, rtol=0.0, atol=1e-13 * abs(expected).max())


def test_cell_does_not_move_itself_sideways():
    assert_allclose(cross_kernel(0, 0, 1.0, 1.0, BETA), 0.0, atol=0.0)


@pytest.mark.parametrize("number", [(3, 0), (2, 5), (4, -1)])
def test_waves_are_displaced_a_quarter_of_a_wavelength_away(number):
    n, modulus = 16, 2.0
    half = CrossResponse((n, n), 1.0, Isotropic(modulus, NU), periodic=True)
    x, y = np.indices((n, n))
    q = 2.0 * np.pi / n * np.array(number)
    phase, along = q[0] * x + q[1] * y, q[:, None, None] / (q @ q)
    factor = (1.0 - 2.0 * NU) / (modulus * (1.0 - NU))
    assert_allclose(
        half.lateral(np.cos(phase)), -factor * along * np.sin(phase), atol=1e-14
    )
    tractions = np.array([0.7, 0.2])[:, None, None] * np.cos(phase)
    expected = -factor * (along * [[[0.7]], [[0.2]]]).sum(axis=0) * np.sin(phase)
    assert_allclose(half.normal(tractions), expected, atol=1e-14)


@pytest.mark.parametrize("periodic", [False, True])
@pytest.mark.parametrize("shape", [(7, 5), (6, 8)])
def test_work_of_forces_is_reciprocal(shape, periodic):
    random = np.random.default_rng(1)
    pressure, tractions = random.normal(size=shape), random.normal(size=(2, *shape))
    half = CrossResponse(shape, 1.3, Isotropic(2.0, NU), periodic)
    lateral, normal = half.lateral(pressure), half.normal(tractions)
    # pressure acts downward
    assert (tractions * lateral).sum() == pytest.approx(-(pressure * normal).sum())


@pytest.mark.parametrize("shape", [(7, 5), (6, 8)])
def test_free_response_is_the_dense_matrix(shape):
    i, j = (index.ravel() for index in np.indices(shape))
    dense = cross_kernel(i[:, None] - i, j[:, None] - j, 1.3, 2.0, BETA)
    pressure = np.random.default_rng(2).normal(size=shape)
    found = CrossResponse(shape, 1.3, Isotropic(2.0, NU)).lateral(pressure)
    assert_allclose(found.reshape(2, -1), dense @ pressure.ravel(), atol=1e-14)


@pytest.mark.parametrize("periodic", [False, True])
@pytest.mark.parametrize("poisson", [-0.9, 0.0, 0.4])
def test_elastic_energy_of_all_components_is_positive(poisson, periodic):
    shape, solid = (5, 4), Isotropic(2.0, poisson)
    kind = PeriodicHalfSpace if periodic else FreeHalfSpace
    normal = kind(shape, 1.0, solid)
    lateral = LateralHalfSpace(shape, 1.0, solid, periodic)
    cross, energies = CrossResponse(shape, 1.0, solid, periodic), []
    for unit in np.eye(3 * 20).reshape(-1, 3, *shape):
        t, p = unit[:2], unit[2]
        u = lateral.displacement(t) + cross.lateral(p)
        energies.append([*u, cross.normal(t) + normal.displacement(p)])
    matrix = np.reshape(energies, (60, 60))
    matrix[:, 40:] *= -1.0  # pressure acts downward
    assert_allclose(matrix, matrix.T, atol=1e-13)
    assert np.linalg.eigvalsh(matrix).min() > -1e-9


@pytest.mark.parametrize("periodic", [False, True])
def test_incompressible_solids_are_not_coupled(periodic):
    half = CrossResponse((8, 8), 1.0, Isotropic(1.0, 0.5), periodic)
    assert not half.lateral(np.eye(8)).any()
    assert Isotropic(1.0, 0.5).coupling == 0.0


def test_cubic_solid_is_the_same_in_other_axes():
    c, s = np.cos(np.pi / 4), np.sin(np.pi / 4)
    turn, q = np.array([[c, s], [-s, c]]), np.array([0.3, 0.1])
    expected = turn @ Cubic(*COPPER, "100").cross_wave_compliance(*(turn.T @ q))
    found = Cubic(*COPPER).cross_wave_compliance(*q)
    assert_allclose(found, expected, rtol=1e-12)


@pytest.mark.parametrize("cell", [(2, 1), (0, 3), (-33, 12)])
def test_kernel_of_a_cubic_solid_has_the_displacements_of_its_waves(cell):
    solid, (i, j) = Cubic(*COPPER), cell
    x, weights = np.polynomial.legendre.leggauss(30)
    x, y = np.broadcast_arrays(i + x[:, None] / 2, j + x / 2)
    across = (np.arctan2(y, x) + np.pi / 2)[..., None]
    angle = np.pi / 400 * (np.arange(200) + 0.5)
    first, second = (
        solid.cross_wave_compliance(np.cos(across + a), np.sin(across + a))
        for a in (angle, -angle)
    )  # the inverse Fourier transform: a principal value over all directions
    integral = np.pi / 2 * ((first - second) / np.sin(angle)).mean(axis=-1)
    greens = integral / (2.0 * np.pi**2 * np.hypot(x, y))
    expected = weights @ greens @ weights / 4.0
    found = solid.cross_cell_compliance(*np.array(cell)[:, None], 1.0)[:, 0]
    assert_allclose(found, expected, atol=1e-8 * abs(expected).max())


def test_free_crystal_is_a_large_periodic_one(crystal):
    n, periodic = 60, CrossResponse((400, 400), crystal.spacing, crystal, True)
    pressure = np.zeros((n, n))
    pressure[10, 10], pressure[15, 13] = 1.0, -1.0  # in balance
    expected = periodic.lateral(np.pad(pressure, 170))[:, 170:-170, 170:-170]
    found = CrossResponse((n, n), crystal.spacing, crystal).lateral(pressure)
    difference = found - expected
    difference -= difference.mean(axis=(1, 2), keepdims=True)
    assert abs(difference).max() < 3e-5 * abs(found).max()


def test_crystals_of_earlier_versions_say_what_they_lack(crystal):
    older = replace(crystal, lateral=crystal.lateral[:3])
    assert np.isnan(older.coupling)
    LateralHalfSpace((4, 4), crystal.spacing, older)
    for periodic in (False, True):
        with pytest.raises(NotImplementedError, match="its file is an older one"):
            CrossResponse((4, 4), crystal.spacing, older, periodic)


def test_solids_without_coupled_components_say_so():
    creeping = Viscoelastic(Isotropic(1.0, 0.3), Creep([1.0], [1.0]))
    for solid in (Isotropic(1.0), Layer(1.0, 3.0), creeping):
        for periodic in (False, True):
            with pytest.raises(NotImplementedError, match="which friction needs"):
                CrossResponse((4, 4), 1.0, solid, periodic)


def test_two_equal_bodies_are_not_coupled_and_a_rigid_one_does_not_matter():
    assert dundurs_parameter((80.0, 0.3), (80.0, 0.3)) == 0.0
    found = dundurs_parameter((80.0, 0.3), (1e12, 0.1))
    assert found == pytest.approx(Isotropic(80.0, 0.3).coupling)
    first, second = (100.0, 0.2), (40.0, 0.4)
    both = Isotropic(100.0 * 40.0 / 140.0, 0.3, dundurs_parameter(first, second))
    kernels = [Isotropic(*b).cross_cell_compliance(3, 1, 1.0) for b in (first, second)]
    found = both.cross_cell_compliance(3, 1, 1.0)
    assert_allclose(found, kernels[0] - kernels[1], rtol=1e-12)
