"""Fourier transforms of Green's functions on a grid, periodic or free.

The spectrum of a periodic surface is the compliance of its waves, and zero for the
mean displacement. The spectrum of a free surface is the transform of the compliances of
cells, wrapped around the grid. Components are even or odd along x and y, so that one
quadrant determines them.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.fft import dct, rfft

from ase_roughcontact._util.threads import available_threads, split, thread_map
from ase_roughcontact.elasticity.greens import ElasticSolid

#: Prefix of the methods of a solid for the component zz.
NORMAL = ""
#: Prefix of the methods of a solid for the components xx, yy and xy.
LATERAL = "lateral_"
#: Prefix of the methods of a solid for the components zx and zy.
CROSS = "cross_"
# Whether each of these components is odd along x and along y.
_ODD = {
    NORMAL: [(False, False)],
    LATERAL: [(False, False), (False, False), (True, True)],
    CROSS: [(True, False), (False, True)],
}
# Smallest number of grid points for which several threads are worth their start.
_MIN_THREADED_POINTS = 256 * 256
# Number of rows of a kernel that are evaluated at once, so that temporary arrays stay
# in the cache.
_ROWS_AT_ONCE = 128


def _workers(points: int) -> int:
    """Return the number of threads for transforms of scipy: one for small grids."""
    return available_threads() if points >= _MIN_THREADED_POINTS else 1


def quadrants(
    solid: ElasticSolid,
    spacing: float,
    grid: tuple[int, int],
    periodic: bool,
    kind: str = NORMAL,
) -> np.ndarray:
    """Return a quadrant of the spectrum of each component of a Green's function.

    Parameters
    ----------
    solid : ElasticSolid
        The solid.
    spacing : float
        Side of a cell (length).
    grid : (int, int)
        Shape ``(N, M)`` of the grid.
    periodic : bool
        Whether the boundaries are periodic, or free.
    kind : {`NORMAL`, `LATERAL`, `CROSS`}
        Components of the Green's function.

    Returns
    -------
    ndarray, shape (components, N//2 + 1, M//2 + 1)
        Real parts of the spectra, or imaginary parts for components that are odd in one
        direction (length/pressure).
    """
    if periodic:
        qx, qy = (2.0 * np.pi * np.fft.rfftfreq(n, spacing) for n in grid)
        qx, qy = np.meshgrid(qx, qy, indexing="ij")
        qx[0, 0] = 1.0 / spacing  # any wave number: the mean is set to zero below
        spectra = getattr(solid, f"{kind}wave_compliance")(qx, qy)
        spectra[..., 0, 0] = 0.0
        return spectra.reshape(-1, *qx.shape)
    n, m = grid
    compliance = getattr(solid, f"{kind}cell_compliance")
    rows, columns = np.arange(n // 2 + 1)[:, None], np.arange(m // 2 + 1)
    kernels = np.empty((len(_ODD[kind]), rows.size, columns.size))

    def calculate(block: slice) -> None:
        kernels[:, block] = compliance(rows[block], columns, spacing)

    threads = _workers(rows.size * columns.size)
    thread_map(calculate, split(rows.size, _ROWS_AT_ONCE), threads)
    for kernel, (odd_x, odd_y) in zip(kernels, _ODD[kind], strict=True):
        spectrum = _transformed(_transformed(kernel, m, 1, odd_y), n, 0, odd_x)
        if not np.may_share_memory(spectrum, kernel):  # transformed in place
            kernel[:] = spectrum
        if odd_x or odd_y:
            np.negative(kernel, out=kernel)
    return kernels


def half_planes(quadrants: np.ndarray, kind: str, grid: tuple[int, int]) -> np.ndarray:
    """Return all rows of spectra, shape (components, N, M//2 + 1)."""
    n, m = grid
    spectra = quadrants.take(wrapped_distance(n), 1)
    for spectrum, (odd_x, odd_y) in zip(spectra, _ODD[kind], strict=True):
        if odd_x:
            spectrum *= _sign(n)[:, None]
        if odd_y:
            spectrum *= _sign(m)[: m // 2 + 1]
    return spectra


def wrapped_distance(n: int) -> np.ndarray:
    """Return the distances from point 0 to n points on a ring."""
    return np.minimum(np.arange(n), n - np.arange(n))


def _sign(n: int) -> np.ndarray:
    """Return the signs of n points on a ring, zero where they meet."""
    k = np.arange(n)
    return np.sign(k * (n - 2 * k))


def _transformed(half: np.ndarray, n: int, axis: int, odd: bool) -> np.ndarray:
    """Transform n values that are even or odd on a ring, given the first half.

    The transform of odd values is imaginary: its negative imaginary part is returned.
    """
    options: dict[str, Any] = {"axis": axis, "workers": _workers(half.size)}
    if not odd and n % 2 == 0:
        return dct(half, 1, overwrite_x=True, **options)
    ring = half.take(wrapped_distance(n), axis)
    if not odd:
        return rfft(ring, **options).real
    ring *= _sign(n)[:, None] if axis == 0 else _sign(n)
    return -rfft(ring, **options).imag
