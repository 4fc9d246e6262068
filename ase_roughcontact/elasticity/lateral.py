r"""Lateral response of a half space to lateral tractions, periodic or free.

Tractions :math:`t = (t_x, t_y)` displace the surface by :math:`u = G * t`, where G is
the 2 x 2 matrix of the solid (see `greens`), as pressure does in `halfspace`: a
periodic half space multiplies in Fourier space, with the mean displacement set to zero,
and a free one on a grid padded to at least ``2n - 1`` cells.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np
from scipy.fft import fft, ifft, irfft, rfft, rfft2

from ase_roughcontact._util.threads import available_threads
from ase_roughcontact._util.validation import grid_shape, positive
from ase_roughcontact.elasticity.circulant import padded_box
from ase_roughcontact.elasticity.greens import ElasticSolid
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace

# Smallest number of grid points for which several threads are worth their start.
_LEAST_SHARED = 256 * 256
# Compliance of a uniform traction of a periodic half space, which displaces nothing,
# relative to the largest one, so that matrices are definite.
_UNIFORM = 1e-10
# Smallest compliance of a wave in the approximate inverse, relative to the largest one.
_SOFTEST = 1e-6


class LateralHalfSpace:
    """Lateral response of a window of surface cells.

    Parameters
    ----------
    shape : (int, int)
        Window ``(n, m)``: the cells that may carry tractions.
    spacing : float
        Side of a cell (length).
    solid : ElasticSolid
        With lateral components.
    periodic : bool
        Whether the window repeats.

    Attributes
    ----------
    grid : (int, int)
        Grid ``(N, M)`` of the transforms.
    pairs : float
        Forward/inverse FFT pairs of two components so far, normalised to the grid.

    Raises
    ------
    ValueError
        If shape or spacing are not valid.
    NotImplementedError
        If the solid has no lateral components.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        spacing: float,
        solid: ElasticSolid,
        periodic: bool = False,
    ) -> None:
        self.shape = grid_shape(shape)
        positive(spacing=spacing)
        self.spacing, self.solid, self.periodic = float(spacing), solid, periodic
        self.grid = self._wrapped = self.shape
        if not periodic:
            self.grid = FreeHalfSpace.padded_shape(self.shape)
            self._wrapped = padded_box(self.shape)
        self.pairs = 0.0
        self._compliance = self.spectrum(self.grid)

    def spectrum(self, grid: tuple[int, int]) -> np.ndarray:
        """Return the Fourier transform of the Green's function on a grid.

        Parameters
        ----------
        grid : (int, int)
            Shape ``(N, M)``.

        Returns
        -------
        ndarray, shape (3, N, M//2 + 1)
            Components xx, yy and xy, real (length/pressure).
        """
        return self._of_waves(grid) if self.periodic else self._of_cells(grid)

    @cached_property
    def self_compliance(self) -> float:
        """Displacement of a cell by unit traction on it alone (length/pressure)."""
        means = self._compliance[:2].mean(axis=(0, 1))  # over both components
        return float(irfft(means, self.grid[1])[0])

    @property
    def largest_compliance(self) -> float:
        """Upper bound of the compliance of any wave (length/pressure)."""
        xx, yy, xy = self._compliance
        return float((0.5 * (xx + yy) + np.hypot(0.5 * (xx - yy), xy)).max())

    def displacement(self, tractions: np.ndarray) -> np.ndarray:
        """Return the lateral displacement ``G * t``: one FFT pair.

        Parameters
        ----------
        tractions : ndarray, shape (2, n, m)
            Along x and y (pressure).

        Returns
        -------
        ndarray, shape (2, n, m)
            Along x and y (length); its mean is zero if periodic.
        """
        self.pairs += 1.0
        return _filtered(tractions, self._compliance, self.grid)

    def tractions(self, displacement: np.ndarray) -> np.ndarray:
        """Return the tractions that cause a displacement of the grid: one FFT pair.

        Parameters
        ----------
        displacement : ndarray, shape (2, N, M)
            Along x and y, of all cells of the grid (length).

        Returns
        -------
        ndarray, shape (2, N, M)
            Pressure; if periodic their mean is zero, and that of the displacement has
            no effect.
        """
        self.pairs += 1.0
        return _filtered(displacement, self._exact_stiffness, self.grid)

    @cached_property
    def _exact_stiffness(self) -> np.ndarray:
        matrix = _inverse(self._compliance)
        if self.periodic:
            matrix[:, 0, 0] = 0.0
        return matrix

    def relative_displacement(self, tractions: np.ndarray) -> np.ndarray:
        """Return `displacement` over the self-compliance, in single precision."""
        self.pairs += 1.0
        return _filtered(tractions, self._relative_compliance, self.grid)

    def relative_stiffness(self, displacement: np.ndarray) -> np.ndarray:
        """Return approximate tractions that cause a relative displacement.

        The Green's function is wrapped around the window. The operator is linear,
        symmetric and positive definite; it takes and returns arrays (2, n, m) of single
        precision.
        """
        self.pairs += math.prod(self._wrapped) / math.prod(self.grid)
        return _filtered(displacement, self._relative_stiffness, self._wrapped)

    @cached_property
    def _relative_compliance(self) -> np.ndarray:
        return (self._compliance / self.self_compliance).astype(np.float32)

    @cached_property
    def _relative_stiffness(self) -> np.ndarray:
        inverse = _inverse(self.spectrum(self._wrapped) / self.self_compliance)
        return inverse.astype(np.float32)

    def _of_waves(self, grid: tuple[int, int]) -> np.ndarray:
        spectrum = self.solid.lateral_wave_compliance(*wave_vectors(grid, self.spacing))
        least = _UNIFORM * float(spectrum[:2].max())
        spectrum[:, 0, 0] = least, least, 0.0
        return _without_edges(spectrum, grid)

    def _of_cells(self, grid: tuple[int, int]) -> np.ndarray:
        cells = self.solid.lateral_cell_compliance(*cell_vectors(grid), self.spacing)
        return rfft2(_without_edges(cells, grid)).real


def wave_vectors(
    grid: tuple[int, int], spacing: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return qx and qy of the waves of a grid; any finite wave in place of zero."""
    qx = 2 * np.pi * np.fft.fftfreq(grid[0], spacing)[:, None]
    qy = 2 * np.pi * np.fft.rfftfreq(grid[1], spacing) + 0.0 * qx
    qy[0, 0] = 1.0 / spacing
    return qx, qy


def cell_vectors(grid: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Return the lattice vectors (i, j) of the cells of a grid from the first one."""
    i, j = (np.fft.fftfreq(n, 1.0 / n).round() for n in grid)
    return i[:, None], j


def workers_of(grid: tuple[int, int]) -> int:
    """Return the number of threads of a transform."""
    return available_threads() if math.prod(grid) >= _LEAST_SHARED else 1


def _without_edges(values: np.ndarray, grid: tuple[int, int]) -> np.ndarray:
    """Set the odd component to zero where the signs of both ends of a period meet."""
    for axis, n in enumerate(grid):
        if n % 2 == 0:
            values[2].swapaxes(0, axis)[n // 2] = 0.0
    return values


def _inverse(spectrum: np.ndarray) -> np.ndarray:
    """Return the inverse of symmetric matrices, made positive definite."""
    xx, yy, xy = spectrum
    mean = 0.5 * (xx + yy)
    least = mean - np.hypot(0.5 * (xx - yy), xy)  # eigenvalue
    uniform = least[0, 0] < _SOFTEST * mean.max()
    # the mean of a periodic surface has no compliance: that of a long wave instead
    shift = np.maximum(_SOFTEST * mean.max() - least, 0.0)
    shift[0, 0] = mean.max() if uniform else 0.0
    xx, yy = xx + shift, yy + shift
    return np.stack([yy, xx, -xy]) / (xx * yy - xy * xy)


def _filtered(
    values: np.ndarray, matrix: np.ndarray, grid: tuple[int, int]
) -> np.ndarray:
    """Multiply two fields on a window of a grid by a 2 x 2 matrix of their spectra."""
    _, n, m = values.shape
    workers = workers_of(grid)
    # rows first: those of the padding are zero
    spectra = fft(rfft(values, grid[1], workers=workers), grid[0], 1, workers=workers)
    x, y = spectra
    xx, yy, xy = matrix
    products = np.empty_like(spectra)
    np.multiply(xx, x, out=products[0])
    np.multiply(yy, y, out=products[1])
    spectra *= xy
    products += spectra[::-1]
    rows = ifft(products, axis=1, workers=workers, overwrite_x=True)[:, :n]
    return irfft(rows, grid[1], workers=workers)[:, :, :m]
