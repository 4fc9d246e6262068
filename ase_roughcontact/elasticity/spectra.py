"""Fourier transforms of Green's functions on a grid, periodic or free.

A periodic surface has the compliances of its waves, and no mean displacement; a free
one the transform of the compliances of cells, wrapped around the grid. Components are
even or odd along x and y, so that one quadrant determines them.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.fft import dct, rfft

from ase_roughcontact._util.threads import available_threads, split, thread_map
from ase_roughcontact.elasticity.greens import ElasticSolid

#: Beginning of the names of the methods of a solid for its components, and whether
#: these are odd along x and along y: zz; xx, yy and xy; zx and zy.
NORMAL, LATERAL, CROSS = "", "lateral_", "cross_"
_EVEN = False, False
_ODD = {
    NORMAL: [_EVEN],
    LATERAL: [_EVEN, _EVEN, (True, True)],
    CROSS: [(True, False), (False, True)],
}
# Smallest number of grid points for which several threads are worth their start.
_LEAST_SHARED = 256 * 256
# Rows of a kernel that are evaluated at once, so that temporaries stay in the cache.
_KERNEL_ROWS = 128


def _workers(points: int) -> int:
    """Return the number of threads for transforms of scipy: one for small grids."""
    return available_threads() if points >= _LEAST_SHARED else 1


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
    spacing : float
        Side of a cell (length).
    grid : (int, int)
        Shape ``(N, M)``.
    periodic : bool
    kind : {`NORMAL`, `LATERAL`, `CROSS`}

    Returns
    -------
    ndarray, shape (components, N//2 + 1, M//2 + 1)
        Real; of components that are odd in one direction the imaginary parts
        (length/pressure).
    """
    if periodic:
        qx, qy = (2.0 * np.pi * np.fft.rfftfreq(n, spacing) for n in grid)
        qx, qy = np.meshgrid(qx, qy, indexing="ij")
        qx[0, 0] = 1.0 / spacing  # any finite wave: the mean is set to zero below
        spectra = getattr(solid, f"{kind}wave_compliance")(qx, qy)
        spectra[..., 0, 0] = 0.0
        return spectra.reshape(-1, *qx.shape)
    (n, m), compliance = grid, getattr(solid, f"{kind}cell_compliance")
    rows, columns = np.arange(n // 2 + 1)[:, None], np.arange(m // 2 + 1)
    kernels = np.empty((len(_ODD[kind]), rows.size, columns.size))

    def calculate(block: slice) -> None:
        kernels[:, block] = compliance(rows[block], columns, spacing)

    threads = _workers(rows.size * columns.size)
    thread_map(calculate, split(rows.size, _KERNEL_ROWS), threads)
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

    Of odd ones it is minus the imaginary part.
    """
    options: dict[str, Any] = {"axis": axis, "workers": _workers(half.size)}
    if not odd and n % 2 == 0:
        return dct(half, 1, overwrite_x=True, **options)
    ring = half.take(wrapped_distance(n), axis)
    if not odd:
        return rfft(ring, **options).real
    ring *= _sign(n)[:, None] if axis == 0 else _sign(n)
    return -rfft(ring, **options).imag
