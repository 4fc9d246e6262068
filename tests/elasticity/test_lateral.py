"""Responses to lateral tractions, and the coupling of lateral and normal motion."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss
from numpy.testing import assert_allclose

from ase_roughcontact.elasticity import (
    Isotropic,
    Layer,
    Viscoelastic,
    cerruti_kernel,
    cross_kernel,
)
from ase_roughcontact.elasticity.creep import Creep
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace, PeriodicHalfSpace
from ase_roughcontact.elasticity.lateral import CrossResponse, LateralHalfSpace
from ase_roughcontact.elasticity.named_materials import dundurs_parameter

NU, BETA = 0.3, 0.4 / 1.4
ISOTROPIC = Isotropic(2.0, NU)
shapes = pytest.mark.parametrize("shape", [(7, 5), (6, 8)])


def integral(cell, function):
    """Integral over a unit cell, by Gauss's formula."""
    x, weights = leggauss(40)
    x, y = np.broadcast_arrays(cell[0] + 0.5 * x[:, None], cell[1] + 0.5 * x)
    return weights @ function(x, y) @ weights / 4.0


@pytest.mark.parametrize(
    "cell", [(1, 0), (0, -3), (3, -2), (-20, 7), (159, 60), (160, 159), (170, 30)]
)
def test_kernels_are_integrals_over_a_cell(cell):
    xx, yy, xy = integral(
        cell, lambda x, y: np.array([x * x, y * y, x * y]) / np.hypot(x, y) ** 3
    )
    expected = np.array([xx + (1 - NU) * yy, (1 - NU) * xx + yy, NU * xy])
    expected *= 1.5 / (np.pi * 2.0 * (1 - NU))
    found = cerruti_kernel(*cell, 1.5, 2.0, NU)
    assert_allclose(found, expected, rtol=1e-10, atol=1e-13 * expected.max())
    shear = 0.5 * 2.0 * (1.0 - NU)  # Johnson, Eq. (3.18): towards the force
    factor = -1.5 * (1.0 - 2.0 * NU) / (4.0 * np.pi * shear)
    expected = factor * integral(cell, lambda x, y: np.array([x, y]) / (x**2 + y**2))
    found = cross_kernel(*cell, 1.5, 2.0, BETA)
    assert_allclose(found, expected, rtol=0.0, atol=2e-13 * abs(expected).max())
    assert not cross_kernel(0, 0, 1.0, 1.0, BETA).any()


@shapes
def test_free_responses_are_dense_matrices(shape):
    (n, m), (i, j) = shape, (index.ravel() for index in np.indices(shape))
    cells = i[:, None] - i, j[:, None] - j
    xx, yy, xy = cerruti_kernel(*cells, 1.3, 2.0, NU)
    t, p = np.random.default_rng(1).normal(size=(2, n, m)), np.eye(n, m)
    found = LateralHalfSpace(shape, 1.3, ISOTROPIC).displacement(t)
    dense = np.block([[xx, xy], [xy, yy]])
    assert_allclose(found.ravel(), dense @ t.ravel(), atol=1e-12)
    found = CrossResponse(shape, 1.3, ISOTROPIC).lateral(p).reshape(2, -1)
    dense = cross_kernel(*cells, 1.3, 2.0, BETA)
    assert_allclose(found, dense @ p.ravel(), atol=1e-14)


@shapes
def test_tractions_of_the_whole_grid_cause_its_displacement(shape, periodic):
    half = LateralHalfSpace(shape, 1.3, ISOTROPIC, periodic)
    tractions = np.random.default_rng(1).normal(size=(2, *half.grid))
    if periodic:
        tractions -= tractions.mean(axis=(1, 2), keepdims=True)
    displacement = half.displacement(tractions)
    assert_allclose(half.tractions(displacement), tractions, atol=1e-12)
    if periodic:  # a uniform displacement costs nothing
        assert_allclose(half.tractions(displacement + 1.0), tractions, atol=1e-12)


def test_approximate_tractions_of_a_uniform_displacement_agree_with_a_long_wave():
    # without a compliance of its own they would have no bound, or be useless
    n, spacing = 16, 1.3
    half = LateralHalfSpace((n, n), spacing, ISOTROPIC, periodic=True)
    q = 2.0 * np.pi / (n * spacing)
    across, along = 2.0 / (2.0 * (1.0 - NU) * q), 2.0 / (2.0 * q)
    moved = np.ones((2, n, n), np.float32)
    expected = half.self_compliance / (0.5 * (across + along))
    assert_allclose(half.relative_stiffness(moved), expected, rtol=1e-5)


def test_a_single_periodic_atom_is_not_displaced():
    lateral = LateralHalfSpace((1, 1), 2.0, Isotropic(3.0, 0.3), periodic=True)
    tractions = np.ones((2, 1, 1), np.float32)
    assert_allclose(lateral.displacement(tractions), 0.0, atol=1e-9)
    for operator in (lateral.relative_displacement, lateral.relative_stiffness):
        assert operator(tractions).min() > 0.0  # definite


@pytest.mark.parametrize("number", [(3, 0), (2, 5), (4, -1)])
def test_periodic_waves_have_the_compliances_along_and_across(number):
    n = 16
    half = LateralHalfSpace((n, n), 1.0, ISOTROPIC, periodic=True)
    x, y = np.indices((n, n))
    qx, qy = 2.0 * np.pi / n * np.array(number)
    q, wave = np.hypot(qx, qy), np.cos(qx * x + qy * y)
    along = np.array([qx, qy])[:, None, None] / q * wave
    across = np.array([-qy, qx])[:, None, None] / q * wave
    assert_allclose(half.displacement(along), 1.0 / q * along, atol=1e-9)
    expected = 1.0 / ((1.0 - NU) * q) * across
    assert_allclose(half.displacement(across), expected, atol=1e-9)


@pytest.mark.parametrize("number", [(3, 0), (2, 5), (4, -1)])
def test_waves_are_displaced_a_quarter_of_a_wavelength_away(number):
    n = 16
    half = CrossResponse((n, n), 1.0, ISOTROPIC, periodic=True)
    x, y = np.indices((n, n))
    q = 2.0 * np.pi / n * np.array(number)
    phase, along = q[0] * x + q[1] * y, q[:, None, None] / (q @ q)
    factor = (1.0 - 2.0 * NU) / (2.0 * (1.0 - NU))
    assert_allclose(
        half.lateral(np.cos(phase)), -factor * along * np.sin(phase), atol=1e-14
    )
    tractions = np.array([0.7, 0.2])[:, None, None] * np.cos(phase)
    expected = -factor * (along * [[[0.7]], [[0.2]]]).sum(axis=0) * np.sin(phase)
    assert_allclose(half.normal(tractions), expected, atol=1e-14)


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


def test_incompressible_solids_are_not_coupled(periodic):
    half = CrossResponse((8, 8), 1.0, Isotropic(1.0, 0.5), periodic)
    assert not half.lateral(np.eye(8)).any()
    assert Isotropic(1.0, 0.5).coupling == 0.0


@pytest.mark.parametrize("kind", [LateralHalfSpace, CrossResponse])
def test_free_crystal_is_a_large_periodic_one(crystal, kind):
    tractions = np.zeros((2, 60, 60))
    tractions[:, 10, 10], tractions[:, 15, 13] = 1.0, -1.0  # in balance
    padded = np.pad(tractions, ((0, 0), (170, 170), (170, 170)))
    responses = []
    for values, periodic in ((tractions, False), (padded, True)):
        half = kind(values.shape[1:], crystal.spacing, crystal, periodic)
        if kind is CrossResponse:
            responses.append(half.lateral(values[0]))
        else:
            responses.append(half.displacement(values))
    found, expected = responses[0], responses[1][:, 170:-170, 170:-170]
    difference = found - expected
    difference -= difference.mean(axis=(1, 2), keepdims=True)
    assert abs(difference).max() < 3e-5 * abs(found).max()


@pytest.mark.parametrize("kind", [LateralHalfSpace, CrossResponse])
def test_solids_and_crystals_without_lateral_components_have_no_friction(
    kind, crystal, periodic
):
    creeping = Viscoelastic(Isotropic(1.0), Creep([1.0], [1.0]))
    for solid in (Isotropic(1.0), Layer(1.0, 3.0), creeping):
        with pytest.raises(NotImplementedError, match=r"poisson=0.3"):
            kind((4, 4), 1.0, solid, periodic)
    uncoupled = replace(crystal, lateral=crystal.lateral[:3])
    assert np.isnan(uncoupled.coupling)
    if kind is LateralHalfSpace:
        kind((4, 4), crystal.spacing, uncoupled, periodic)
        uncoupled = replace(crystal, lateral=None)
    with pytest.raises(NotImplementedError, match="from_calculator"):
        kind((4, 4), crystal.spacing, uncoupled, periodic)


def test_two_equal_bodies_are_not_coupled_and_a_rigid_one_does_not_matter():
    assert dundurs_parameter((80.0, 0.3), (80.0, 0.3)) == 0.0
    found = dundurs_parameter((80.0, 0.3), (1e12, 0.1))
    assert found == pytest.approx(Isotropic(80.0, 0.3).coupling)
    first, second = (100.0, 0.2), (40.0, 0.4)
    both = Isotropic(100.0 * 40.0 / 140.0, 0.3, dundurs_parameter(first, second))
    kernels = [Isotropic(*b).cross_cell_compliance(3, 1, 1.0) for b in (first, second)]
    found = both.cross_cell_compliance(3, 1, 1.0)
    assert_allclose(found, kernels[0] - kernels[1], rtol=1e-12)
