r"""Response of a half space to lateral tractions, and its coupling to pressure.

Tractions :math:`t = (t_x, t_y)` displace the surface by :math:`u = G * t`, where G is
the 2 x 2 matrix of the solid (see `greens`), as pressure does in `halfspace`: a
periodic half space multiplies in Fourier space, with the mean displacement set to zero,
and a free one on a grid padded to at least ``2n - 1`` cells. Pressure p displaces the
surface sideways, too, and tractions displace it upward,

.. math:: u_a = C_a * p, \qquad u_z = \sum_a C_a * t_a ,

with the same odd functions :math:`C_a`, as an elastic energy
:math:`\tfrac12 t \cdot G * t + t \cdot C * p + \tfrac12 p\, G_{zz} * p` has it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property

import numpy as np
from scipy.fft import fft, ifft, irfft, rfft

from ase_roughcontact._util.validation import grid_shape, positive
from ase_roughcontact.elasticity.circulant import padded_box
from ase_roughcontact.elasticity.greens import ElasticSolid
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace
from ase_roughcontact.elasticity.spectra import (
    CROSS,
    LATERAL,
    half_planes,
    quadrants,
    workers,
)

# Compliance of a uniform traction of a periodic half space, which displaces nothing,
# relative to the largest one, so that matrices are definite.
_UNIFORM = 1e-10
# Smallest compliance of a wave in the approximate inverse, relative to the largest one.
_SOFTEST = 1e-6


class _Response:
    """Response of a window of surface cells; the parameters of `LateralHalfSpace`."""

    _kind: str

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
        self.grid = self.shape if periodic else FreeHalfSpace.padded_shape(self.shape)
        self._compliance = self.spectrum(self.grid)

    def spectrum(self, grid: tuple[int, int]) -> np.ndarray:
        """Return the Fourier transform of the Green's function on a grid.

        Parameters
        ----------
        grid : (int, int)
            Shape ``(N, M)``.

        Returns
        -------
        ndarray, shape (components, N, M//2 + 1)
            Real (length/pressure).
        """
        parts = quadrants(self.solid, self.spacing, grid, self.periodic, self._kind)
        return half_planes(parts, self._kind, grid)


class LateralHalfSpace(_Response):
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
    transformed : int
        Points of all forward/inverse FFT pairs of two components so far.

    Raises
    ------
    ValueError
        If shape or spacing are not valid.
    NotImplementedError
        If the solid has no lateral components.
    """

    _kind = LATERAL
    transformed = 0

    def spectrum(self, grid: tuple[int, int]) -> np.ndarray:
        """Return the Fourier transform of the Green's function; its mean is small."""
        spectrum = super().spectrum(grid)
        if self.periodic:
            # a single atom has no waves
            largest = spectrum[:2].max() or self.spacing / self.solid.contact_modulus
            spectrum[:2, 0, 0] = _UNIFORM * largest
        return spectrum

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
        return self._multiplied(self._compliance, tractions, self.grid)

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
        return self._multiplied(self._stiffness, displacement, self.grid)

    def relative_displacement(self, tractions: np.ndarray) -> np.ndarray:
        """Return `displacement` over the self-compliance, in single precision."""
        return self._multiplied(self._relative_compliance, tractions, self.grid)

    def relative_stiffness(self, displacement: np.ndarray) -> np.ndarray:
        """Return approximate tractions that cause a relative displacement.

        The Green's function is wrapped around the window. The operator is linear,
        symmetric and positive definite; it takes and returns arrays (2, n, m) of single
        precision.
        """
        return self._multiplied(self._relative_stiffness, displacement, self._wrapped)

    @property
    def _wrapped(self) -> tuple[int, int]:
        return self.shape if self.periodic else padded_box(self.shape)

    @cached_property
    def _stiffness(self) -> np.ndarray:
        matrix = _inverse(self._compliance)
        if self.periodic:
            matrix[:, 0, 0] = 0.0
        return matrix

    @cached_property
    def _relative_compliance(self) -> np.ndarray:
        return (self._compliance / self.self_compliance).astype(np.float32)

    @cached_property
    def _relative_stiffness(self) -> np.ndarray:
        inverse = _inverse(self.spectrum(self._wrapped) / self.self_compliance)
        return inverse.astype(np.float32)

    def _multiplied(
        self, matrix: np.ndarray, values: np.ndarray, grid: tuple[int, int]
    ) -> np.ndarray:
        """Multiply two fields by symmetric matrices of their spectra on a grid."""
        xx, yy, xy = matrix
        self.transformed += math.prod(grid)
        return _filtered([[xx, xy], [xy, yy]], values, grid)


class CrossResponse(_Response):
    """Lateral displacement by pressure, and normal displacement by tractions.

    Parameters
    ----------
    shape, spacing, solid, periodic
        See `LateralHalfSpace`; the solid needs `cross_wave_compliance` if periodic, and
        else `cross_cell_compliance`.

    Raises
    ------
    ValueError
        If shape or spacing are not valid.
    NotImplementedError
        If the solid has no coupled components.
    """

    _kind = CROSS

    def lateral(self, pressure: np.ndarray) -> np.ndarray:
        """Return the displacement along x and y by a pressure.

        Parameters
        ----------
        pressure : ndarray, shape (n, m)

        Returns
        -------
        ndarray, shape (2, n, m)
        """
        x, y = self._compliance
        return _filtered([[x], [y]], pressure[None], self.grid, 1j)

    def normal(self, tractions: np.ndarray) -> np.ndarray:
        """Return the upward displacement by tractions along x and y.

        Parameters
        ----------
        tractions : ndarray, shape (2, n, m)
            On the surface (pressure).

        Returns
        -------
        ndarray, shape (n, m)
        """
        return _filtered([list(self._compliance)], tractions, self.grid, 1j)[0]


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
    matrix: Sequence[Sequence[np.ndarray]],
    values: np.ndarray,
    grid: tuple[int, int],
    factor: complex = 1.0,
) -> np.ndarray:
    """Multiply the spectra of fields on a window of a grid by a matrix and a factor."""
    (n, m), threads = values.shape[-2:], workers(math.prod(grid))
    # rows first: those of the padding are zero
    spectra = rfft(values, grid[1], workers=threads)
    spectra = fft(spectra, grid[0], -2, workers=threads)
    products = np.empty((len(matrix), *spectra.shape[1:]), spectra.dtype)
    for product, (first, *others) in zip(products, matrix, strict=True):
        np.multiply(first, spectra[0], out=product)
        for entry, spectrum in zip(others, spectra[1:], strict=True):
            product += entry * spectrum
    if factor != 1.0:
        products *= factor
    rows = ifft(products, axis=-2, workers=threads, overwrite_x=True)[..., :n, :]
    return irfft(rows, grid[1], workers=threads)[..., :m]
