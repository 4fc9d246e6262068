r"""Response of a half space to lateral tractions, and its coupling to pressure.

Tractions :math:`t = (t_x, t_y)` displace the surface by :math:`u = G * t` with the 2 x
2 matrix G of the solid (see `greens`). The convolution is calculated as in `halfspace`:
for a periodic half space as a product in Fourier space, with the mean displacement set
to zero, and for a free one on a grid padded to at least ``2n - 1`` cells. Pressure p
also displaces the surface laterally, and tractions displace it upward,

.. math:: u_a = C_a * p, \qquad u_z = \sum_a C_a * t_a ,

with the same odd functions :math:`C_a`, which follow from the elastic energy
:math:`\tfrac12 t \cdot G * t + t \cdot C * p + \tfrac12 p\, G_{zz} * p`.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import Any

import numpy as np

from ase_roughcontact._util.keywords import check_keywords
from ase_roughcontact._util.validation import grid_shape, positive
from ase_roughcontact.elasticity.circulant import padded_box
from ase_roughcontact.elasticity.fft import FFT_OPTIONS, RealFFT2
from ase_roughcontact.elasticity.greens import ElasticSolid
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace
from ase_roughcontact.elasticity.spectra import (
    CROSS,
    LATERAL,
    half_planes,
    quadrants,
)

# Compliance of a periodic half space for a uniform traction, relative to the largest
# compliance. It replaces zero, so that matrices are definite.
_UNIFORM_COMPLIANCE = 1e-10
# Smallest compliance of a wave in the approximate inverse, relative to the largest one.
_MIN_COMPLIANCE = 1e-6


class _Response:
    """Response of a window of cells; see `LateralHalfSpace` for the parameters."""

    #: Components of the Green's function, see `spectra`.
    _kind: str

    def __init__(
        self,
        shape: tuple[int, int],
        spacing: float,
        solid: ElasticSolid,
        periodic: bool = False,
        **fft: Any,
    ) -> None:
        check_keywords(type(self).__name__, fft, FFT_OPTIONS)
        self.shape = grid_shape(shape)
        positive(spacing=spacing)
        self.spacing, self.solid, self.periodic = float(spacing), solid, periodic
        self.grid = self.shape if periodic else FreeHalfSpace.padded_shape(self.shape)
        self.fft = fft
        self._compliance = self.spectrum(self.grid)

    @cached_property
    def transform(self) -> RealFFT2:
        """Transform of the window on the grid."""
        return RealFFT2(self.shape, self.grid, **self.fft)

    def spectrum(self, grid: tuple[int, int]) -> np.ndarray:
        """Return the Fourier transform of the Green's function on a grid.

        Parameters
        ----------
        grid : (int, int)
            Shape ``(N, M)`` of the grid.

        Returns
        -------
        ndarray, shape (components, N, M//2 + 1)
            Spectra, real (length/pressure).
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
        Solid with lateral components.
    periodic : bool
        Whether boundaries are periodic, or free.
    **fft
        Options of `RealFFT2`.

    Attributes
    ----------
    grid : (int, int)
        Grid ``(N, M)`` of the transforms.
    transformed : int
        Number of grid points of all FFT pairs of two components so far.

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
            spectrum[:2, 0, 0] = _UNIFORM_COMPLIANCE * largest
        return spectrum

    @cached_property
    def self_compliance(self) -> float:
        """Displacement of a cell by unit traction on it alone (length/pressure)."""
        means = self._compliance[:2].mean(axis=(0, 1))  # over both components
        weights = np.full(means.size, 2.0)  # waves in both directions
        weights[0] = 1.0
        if self.grid[1] % 2 == 0:
            weights[-1] = 1.0
        return float((weights * means).sum()) / self.grid[1]

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
            Tractions along x and y (pressure).

        Returns
        -------
        ndarray, shape (2, n, m)
            Displacements along x and y (length). Their mean is zero if periodic.
        """
        return self._multiplied(self._compliance, tractions, self.transform)

    def tractions(self, displacement: np.ndarray) -> np.ndarray:
        """Return the tractions that cause a displacement of the grid: one FFT pair.

        Parameters
        ----------
        displacement : ndarray, shape (2, N, M)
            Displacements of all cells of the grid along x and y (length).

        Returns
        -------
        ndarray, shape (2, N, M)
            Tractions along x and y (pressure). For a periodic half space their mean is
            zero, and the mean displacement has no effect.
        """
        return self._multiplied(self._stiffness, displacement, self.transform)

    def relative_displacement(self, tractions: np.ndarray) -> np.ndarray:
        """Return `displacement` over the self-compliance, in single precision."""
        transform = self._single_transform
        return self._multiplied(self._relative_compliance, tractions, transform)

    def relative_stiffness(self, displacement: np.ndarray) -> np.ndarray:
        """Return approximate tractions that cause a relative displacement.

        The Green's function is wrapped around the window. The operator is linear,
        symmetric and positive definite; it takes and returns arrays (2, n, m) of single
        precision.
        """
        transform = self._wrapped_transform
        return self._multiplied(self._relative_stiffness, displacement, transform)

    @cached_property
    def _single_transform(self) -> RealFFT2:
        """Transform of the window on the grid in single precision."""
        if self.transform.dtype == np.float32:
            return self.transform
        options = {**self.fft, "dtype": np.float32}
        return RealFFT2(self.shape, self.grid, **options)

    @cached_property
    def _wrapped_transform(self) -> RealFFT2:
        """Transform of the window on a smaller grid in single precision."""
        wrapped = self.shape if self.periodic else padded_box(self.shape)
        if wrapped == self.grid:
            return self._single_transform
        options = {**self.fft, "dtype": np.float32}
        return RealFFT2(self.shape, wrapped, **options)

    @cached_property
    def _stiffness(self) -> np.ndarray:
        matrix = _inverse(self._compliance)
        if self.periodic:
            matrix[:, 0, 0] = 0.0
        return matrix

    @cached_property
    def _relative_compliance(self) -> np.ndarray:
        factors = self._single_transform.factor_type
        return (self._compliance / self.self_compliance).astype(factors)

    @cached_property
    def _relative_stiffness(self) -> np.ndarray:
        spectrum = self.spectrum(self._wrapped_transform.grid)
        inverse = _inverse(spectrum / self.self_compliance)
        return inverse.astype(self._wrapped_transform.factor_type)

    def _multiplied(
        self, matrix: np.ndarray, values: np.ndarray, transform: RealFFT2
    ) -> np.ndarray:
        """Multiply the spectra of two fields by symmetric matrices."""
        xx, yy, xy = matrix
        self.transformed += math.prod(transform.grid)
        return transform.filter_fields(values, [[xx, xy], [xy, yy]])


class CrossResponse(_Response):
    """Lateral displacement by pressure, and normal displacement by tractions.

    Parameters
    ----------
    shape, spacing, solid, periodic, **fft
        See `LateralHalfSpace`. The solid needs `cross_wave_compliance` for periodic,
        and `cross_cell_compliance` for free boundaries.

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
            Pressures (pressure).

        Returns
        -------
        ndarray, shape (2, n, m)
            Displacements along x and y (length).
        """
        x, y = self._compliance
        fields = pressure[None]
        return self.transform.filter_fields(fields, [[x], [y]], imaginary=True)

    def normal(self, tractions: np.ndarray) -> np.ndarray:
        """Return the upward displacement by tractions along x and y.

        Parameters
        ----------
        tractions : ndarray, shape (2, n, m)
            Tractions on the surface (pressure).

        Returns
        -------
        ndarray, shape (n, m)
            Displacements (length), positive upward.
        """
        matrix = [list(self._compliance)]
        return self.transform.filter_fields(tractions, matrix, imaginary=True)[0]


def _inverse(spectrum: np.ndarray) -> np.ndarray:
    """Return the inverse of symmetric matrices, made positive definite."""
    xx, yy, xy = spectrum
    mean = 0.5 * (xx + yy)
    least = mean - np.hypot(0.5 * (xx - yy), xy)  # eigenvalue
    uniform = least[0, 0] < _MIN_COMPLIANCE * mean.max()
    # the mean of a periodic surface has no compliance: take the largest of a wave
    shift = np.maximum(_MIN_COMPLIANCE * mean.max() - least, 0.0)
    shift[0, 0] = mean.max() if uniform else 0.0
    xx, yy = xx + shift, yy + shift
    return np.stack([yy, xx, -xy]) / (xx * yy - xy * xy)
