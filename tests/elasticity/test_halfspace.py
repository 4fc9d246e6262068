"""The half space against closed forms, direct sums and multi-precision numbers."""

import math
import pickle
import tracemalloc

import mpmath as mp
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from ase_roughcontact.elasticity import cerruti_kernel, cross_kernel, love_kernel
from ase_roughcontact.elasticity.greens import Isotropic
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace, PeriodicHalfSpace

E, A0 = 2.0, 3.0
SHAPES = [(8, 8), (7, 7), (6, 9), (13, 4), (1, 11), (10, 1), (2, 1), (1, 1), (17, 30)]
both = pytest.mark.parametrize("kind", [PeriodicHalfSpace, FreeHalfSpace])
shapes = pytest.mark.parametrize("shape", SHAPES, ids=lambda n: f"{n[0]}x{n[1]}")


def random_pressure(shape, seed=1):
    return np.random.default_rng(seed).standard_normal(shape)


# Love's kernel


def love_exactly(i, j):
    """Corner sum of Johnson's Eq. (3.25) for a unit cell, in 40 digits."""
    total = mp.mpf(0)
    with mp.workdps(40):
        for s in (1, -1):
            for t in (1, -1):
                x, y = i + mp.mpf(s) / 2, j + mp.mpf(t) / 2
                r = mp.sqrt(x * x + y * y)
                total += s * t * (x * mp.log(y + r) + y * mp.log(x + r))
        return float(total / mp.pi)


FAR = (25, 33, 100, 999, 4096, 8192, 20_000)


@pytest.mark.parametrize(
    "points",
    [
        [(i, j) for i in range(20) for j in range(i + 1)],
        [(i, i - k) for i in range(54, 74) for k in (0, 1)],  # switch to the series
        [point for d in FAR for point in ((d, 0), (0, -d), (-d, d))],
        [(20_000, 1), (7, 19_999), (1234, 15_000), (15, 16), (15, 20_000)],
    ],
    ids=["near", "switch", "axes", "oblique"],
)
def test_kernel_has_thirteen_digits(points):
    i, j = np.array(points).T
    exact = [love_exactly(*point) for point in points]
    assert_allclose(love_kernel(i, j, 1.0, 1.0), exact, rtol=1e-13)


def test_solids_share_the_tables_of_kernels():
    solids = [Isotropic(E + k, poisson=0.3) for k in range(10)]
    cells = np.arange(200)[:, None], np.arange(200), A0
    solids[0].cell_compliance(*cells), solids[0].lateral_cell_compliance(*cells)
    tracemalloc.start()
    for solid in solids:
        solid.cell_compliance(*cells), solid.lateral_cell_compliance(*cells)
    kept = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    assert kept < 1e5


# Displacement by a pressure


def direct_free(pressure):
    """Sum over all pairs of cells."""
    i, j = (index.ravel() for index in np.indices(pressure.shape))
    kernel = love_kernel(i[:, None] - i, j[:, None] - j, A0, E)
    return -(kernel @ pressure.ravel()).reshape(pressure.shape)


def direct_periodic(pressure):
    """Sum over all modes, one cosine for each."""
    n, m = pressure.shape
    i, j = np.indices(pressure.shape)
    response = np.zeros(pressure.shape)
    for k in range(-((n - 1) // 2), n // 2 + 1):
        for ell in range(-((m - 1) // 2), m // 2 + 1):
            q = 2 * np.pi / A0 * math.hypot(k / n, ell / m)
            if q > 0:
                wave = np.cos(2 * np.pi * (k * i / n + ell * j / m))
                response += 2 / (E * q) * wave / (n * m)
    shifted = [
        np.roll(response, (a, b), (0, 1)) * pressure[a, b] for a, b in np.ndindex(n, m)
    ]
    return -np.sum(shifted, axis=0)


@shapes
def test_free_displacement_is_the_sum_over_all_pairs_of_cells(shape):
    pressure = random_pressure(shape)
    expected = direct_free(pressure)
    u = FreeHalfSpace(shape, A0, E).displacement(pressure)
    assert_allclose(u, expected, atol=1e-13 * abs(expected).max())


@shapes
def test_periodic_displacement_is_the_sum_over_all_modes(shape):
    pressure = random_pressure(shape)
    expected = direct_periodic(pressure)
    u = PeriodicHalfSpace(shape, A0, E).displacement(pressure)
    assert_allclose(u, expected, atol=1e-13 * abs(expected).max())


# Structure


@both
@pytest.mark.parametrize("shape", [(9, 12), (8, 5), (1, 7)])
def test_elastic_pressure_inverts_the_displacement_of_the_whole_grid(kind, shape):
    solid = kind(shape, A0, E)
    pressure = random_pressure(shape)
    if solid.periodic:
        pressure -= pressure.mean()
    everywhere = solid.padded_displacement(pressure)
    expected = np.zeros(solid.grid)
    expected[: shape[0], : shape[1]] = pressure
    assert_allclose(solid.elastic_pressure(everywhere), expected, atol=1e-13)
    window = everywhere[: shape[0], : shape[1]]
    assert_allclose(solid.displacement(pressure), window, atol=1e-13 * A0)


# Options of the transforms


@both
def test_pickled_half_space_gives_the_same_answers(kind):
    solid = kind((9, 12), A0, E, dtype=np.float32)
    copy = pickle.loads(pickle.dumps(solid))
    pressure = random_pressure((9, 12))
    assert type(copy) is kind
    assert copy.displacement(pressure).dtype == np.float32
    assert_allclose(
        copy.displacement(pressure), solid.displacement(pressure), atol=1e-5
    )
    assert_array_equal(copy.compliance, solid.compliance)
    assert len(pickle.dumps(solid)) < 1000  # no kernels


@both
def test_single_precision_keeps_six_digits(kind):
    pressure = random_pressure((60, 41))
    exact = kind((60, 41), A0, E).displacement(pressure)
    u = kind((60, 41), A0, E, dtype=np.float32).displacement(pressure)
    assert u.dtype == np.float32
    assert_allclose(u, exact, atol=1e-6 * abs(exact).max())


# Errors


@pytest.mark.parametrize(
    "make, message",
    [
        (lambda: FreeHalfSpace((4, 4), 0.0, E), "spacing"),
        (lambda: FreeHalfSpace((4, 4), A0, "1"), "contact_modulus"),
        (lambda: FreeHalfSpace((2.5, 4), A0, E), "shape"),
        (lambda: love_kernel(1, 0, -1.0, E), "spacing"),
        (lambda: love_kernel(1, 0, A0, 0.0), "contact_modulus"),
        (lambda: cerruti_kernel(1, 0, -1.0, E, 0.3), "spacing"),
        (lambda: cross_kernel(1, 0, -1.0, E, 0.3), "spacing"),
    ],
)
def test_wrong_sizes_are_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_padded_displacement_refuses_a_pressure_of_another_window():
    with pytest.raises(ValueError, match=r"pressure .* \(8, 8\)"):
        FreeHalfSpace((8, 8), A0, E).padded_displacement(np.ones((4, 4)))
