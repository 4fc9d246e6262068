r"""The elastic half space under a grid of square cells, by its Green's function.

A pressure :math:`p` displaces the surface by :math:`u = -G * p` (positive upward).
In a periodic cell, with contact modulus :math:`E^*`,

.. math:: \tilde u(q) = -\frac{2}{E^* |q|} \tilde p(q), \qquad \tilde u(0) = 0.

For a free half space :math:`G` is the displacement by a uniform pressure on one cell,
and the convolution is done by FFT on a grid padded to at least ``2n - 1`` cells for n,
which is exact for pressure and displacement inside the window.

References
----------
K. L. Johnson, Contact Mechanics (1985), Sec. 3.3; A. E. H. Love, Phil. Trans. R. Soc. A
228, 377 (1929); R. W. Hockney, Methods Comput. Phys. 9, 135 (1970); H. M. Stanley,
T. Kato, J. Tribol. 119, 481 (1997); C. Campana, M. H. Müser, Phys. Rev. B 74, 075420
(2006).
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from functools import cached_property, partial
from itertools import product
from typing import Any

import numpy as np
from numpy.polynomial.legendre import leggauss
from scipy.fft import dct, irfft2, rfft, rfft2

from ase_roughcontact._util.kernels import available_threads
from ase_roughcontact._util.validation import grid_shape, positive
from ase_roughcontact.elasticity.fft import RealFFT2, fast_length

# Distances in cells up to which the closed form loses fewer than four digits, and from
# which the series leaves a relative error below 1e-13; between, Gauss points in each
# direction, and their weights.
_NEAR, _FAR = 16, 50
_GAUSS = [(x / 2, w / 2) for x, w in np.transpose(leggauss(4)).tolist()]
# Rows of the kernel that are calculated at once.
_ROWS = 32


class HalfSpace(ABC):
    """Elastic response of a window of surface cells.

    Parameters
    ----------
    shape : (int, int)
        Window ``(n, m)``: the cells that may carry pressure.
    spacing : float
        Side of a cell, the atomic spacing a0 (length).
    contact_modulus : float
        ``E* = E/(1 - nu^2)`` (pressure).
    **fft
        Options of `RealFFT2`: `dtype`, `engine`, `threads`, `measure`.

    Attributes
    ----------
    grid : (int, int)
        Grid ``(N, M)`` of the transforms: the window, and padding where it is free.
    fft : dict
        The options of `RealFFT2`.

    Raises
    ------
    ValueError
        If the shape is not two whole numbers, or spacing or modulus are not positive.
    """

    periodic: bool

    def __init__(
        self,
        shape: tuple[int, int],
        spacing: float,
        contact_modulus: float,
        **fft: Any,
    ) -> None:
        self.shape = grid_shape(shape)
        positive(spacing=spacing, contact_modulus=contact_modulus)
        self.spacing = float(spacing)
        self.contact_modulus = float(contact_modulus)
        self.grid = self.padded_shape(self.shape)
        self.fft = fft

    def __reduce__(self) -> tuple:
        """Rebuild from the parameters: plans and kernels are not worth storing."""
        args = (self.shape, self.spacing, self.contact_modulus)
        return partial(type(self), **self.fft), args

    def resized(self, shape: tuple[int, int], spacing: float) -> HalfSpace:
        """Half space of the same solid and kind under another grid, for a short use."""
        fft = {**self.fft, "measure": False}
        return type(self)(shape, spacing, self.contact_modulus, **fft)

    @staticmethod
    @abstractmethod
    def padded_shape(shape: tuple[int, int]) -> tuple[int, int]:
        """Shape of the grid for a window of the given shape."""

    @abstractmethod
    def spectrum(self, grid: tuple[int, int]) -> np.ndarray:
        """Spectrum of the Green's function, wrapped around a grid of this spacing.

        Parameters
        ----------
        grid : (int, int)
            Shape ``(N, M)``, that of the padded grid or any other.

        Returns
        -------
        ndarray, shape (N//2 + 1, M//2 + 1)
            Length per pressure; even, so that half of the rows are enough.
        """

    @property
    def dof_shape(self) -> tuple[int, int]:
        """Shape of the atoms that are displaced: the grid, its padding included."""
        return self.grid

    @property
    def self_compliance(self) -> float:
        """Depth of an atom under unit pressure on it alone (length per pressure).

        That of a free half space, and of a periodic cell that is large.
        """
        here = np.zeros(1)
        return float(love_kernel(here, here, self.spacing, self.contact_modulus)[0])

    @cached_property
    def compliance(self) -> np.ndarray:
        """Spectrum ``G(q)`` on the grid, shape (N, M//2 + 1) (length per pressure)."""
        return self._own_spectrum.take(_mirrored(self.grid[0]), 0)

    @cached_property
    def stiffness(self) -> np.ndarray:
        """Spectrum ``K(q) = 1/G(q)``, shape (N, M//2 + 1); zero where G is."""
        return self._own_inverse.take(_mirrored(self.grid[0]), 0)

    @cached_property
    def window_transform(self) -> RealFFT2:
        """Transform of the window on the grid; counts the convolutions."""
        return RealFFT2(self.shape, self.grid, **self.fft)

    @cached_property
    def grid_transform(self) -> RealFFT2:
        """Transform of the whole grid, made when it is first needed."""
        return RealFFT2(self.grid, **self.fft)

    @property
    def dof_transform(self) -> RealFFT2:
        """Transform of all atoms that are displaced."""
        return self.grid_transform

    @cached_property
    def _own_spectrum(self) -> np.ndarray:
        return self.spectrum(self.grid)

    @property
    def _own_inverse(self) -> np.ndarray:
        symbol = self._own_spectrum
        return np.divide(1.0, symbol, where=symbol > 0.0, out=np.zeros_like(symbol))

    @cached_property
    def _compliance_filter(self) -> np.ndarray:
        return self.window_transform.multiplier(-self._own_spectrum)

    @cached_property
    def _stiffness_filter(self) -> np.ndarray:
        return self.grid_transform.multiplier(-self._own_inverse)

    @property
    def pairs(self) -> int:
        """Number of pairs of transforms so far."""
        made = [t for t in ("window_transform", "grid_transform") if t in vars(self)]
        return sum(getattr(self, name).pairs for name in made)

    @property
    def cell_area(self) -> float:
        """Area of a surface cell, a0^2."""
        return self.spacing**2

    def displacement(self, pressure: np.ndarray) -> np.ndarray:
        """Displacement of the window by a pressure on it: one pair of transforms.

        Parameters
        ----------
        pressure : ndarray, shape (n, m)
            Positive in compression (pressure).

        Returns
        -------
        ndarray, shape (n, m)
            Positive upward (length); without its mean if periodic.
        """
        return self.window_transform.filter(pressure, self._compliance_filter)

    def elastic_pressure(self, displacement: np.ndarray) -> np.ndarray:
        """Pressure that holds all atoms at a displacement, ``-K u``.

        Parameters
        ----------
        displacement : ndarray, shape of the layer
            Of every atom, those of the padding included (length).

        Returns
        -------
        ndarray, shape of the layer
            Positive in compression (pressure).
        """
        return self.grid_transform.filter(displacement, self._stiffness_filter)

    def padded_displacement(self, pressure: np.ndarray) -> np.ndarray:
        """Displacement of all atoms, those of the padding included, by a pressure.

        Parameters
        ----------
        pressure : ndarray, shape (n, m)
            On the window (pressure).

        Returns
        -------
        ndarray, shape of the layer
            With this displacement the padding carries no force: the state in which it
            is relaxed.
        """
        return self.grid_displacement(pressure)

    def grid_displacement(self, pressure: np.ndarray) -> np.ndarray:
        """Displacement of the whole grid, shape (N, M); see `padded_displacement`."""
        if pressure.shape != self.shape:
            raise ValueError(f"expected the shape {self.shape}, got {pressure.shape}")
        # once in a while: not worth a plan
        workers = available_threads()
        spectrum = rfft2(pressure, self.grid, workers=workers)
        return irfft2(-self.compliance * spectrum, self.grid, workers=workers)


class PeriodicHalfSpace(HalfSpace):
    """Half space below a periodic cell; the mean plane is the reference.

    See `HalfSpace` for the parameters.
    """

    periodic = True

    @staticmethod
    def padded_shape(shape: tuple[int, int]) -> tuple[int, int]:
        """No padding: the grid is the window."""
        return shape

    def spectrum(self, grid: tuple[int, int]) -> np.ndarray:
        """``2/(E* |q|)``, zero for the mean; see `HalfSpace.spectrum`."""
        n, m = grid
        qx = 2 * np.pi * np.fft.rfftfreq(n, self.spacing)
        qy = 2 * np.pi * np.fft.rfftfreq(m, self.spacing)
        q = np.hypot(qx[:, None], qy[None, :])
        q[0, 0] = np.inf
        return 2.0 / (self.contact_modulus * q)

    def displacement(self, pressure: np.ndarray) -> np.ndarray:
        """Displacement by a pressure; see `HalfSpace.displacement`."""
        # the mean displaces nothing, but its rounding would
        return super().displacement(pressure - pressure.mean())


class FreeHalfSpace(HalfSpace):
    """Half space without any image of the contact.

    See `HalfSpace` for the parameters.
    """

    periodic = False

    @staticmethod
    def padded_shape(shape: tuple[int, int]) -> tuple[int, int]:
        """At least ``2n - 1`` cells in each direction, a fast length for the FFT."""
        return fast_length(2 * shape[0] - 1), fast_length(2 * shape[1] - 1)

    def spectrum(self, grid: tuple[int, int]) -> np.ndarray:
        """Of Love's kernel at the shortest distance; see `HalfSpace.spectrum`."""
        n, m = grid
        rows, columns = np.arange(n // 2 + 1), np.arange(m // 2 + 1)
        given = self.spacing, self.contact_modulus
        values = np.empty((rows.size, columns.size))
        for some in np.array_split(rows, math.ceil(rows.size / _ROWS)):  # in the cache
            values[some] = love_kernel(some[:, None], columns, *given)
        # real and even in both directions: a quarter of it is enough
        return _even_spectrum(_even_spectrum(values, m, 1), n, 0)


def _mirrored(n: int) -> np.ndarray:
    """Distances from the first of n points to all of them around a circle."""
    return np.minimum(np.arange(n), n - np.arange(n))


def _even_spectrum(half: np.ndarray, n: int, axis: int) -> np.ndarray:
    """First half of the spectrum of n values, even about the first, given by half."""
    options: dict[str, Any] = {"axis": axis, "workers": available_threads()}
    if n % 2 == 0:
        return dct(half, 1, overwrite_x=True, **options)
    return rfft(half.take(_mirrored(n), axis), **options).real


def love_kernel(
    i: np.ndarray, j: np.ndarray, spacing: float, contact_modulus: float
) -> np.ndarray:
    r"""Depth of the surface at a cell's centre under unit pressure on another cell.

    With :math:`b` half the spacing :math:`a_0` and corners
    :math:`X_\pm = x \pm b`, :math:`Y_\pm = y \pm b`,

    .. math:: G(x, y) = \frac{1}{\pi E^*} \sum_{s,t=\pm} s t \left[
              X_s \operatorname{arsinh}\frac{Y_t}{|X_s|}
              + Y_t \operatorname{arsinh}\frac{X_s}{|Y_t|}\right],

    at the origin :math:`4 \ln(1 + \sqrt 2) a_0/(\pi E^*)`. Far away these terms cancel;
    there the integral of :math:`1/(\pi E^* r)` over the cell is done with Gauss points,
    and farther by Taylor's series about its centre, lengths in spacings,

    .. math:: \frac{1}{r} + \frac{1}{24 r^3}
              + \frac{7}{1920 r^5}\left(\frac{20 x^2 y^2}{r^4} - 1\right).

    Relative error below 1e-12 at any distance.

    Parameters
    ----------
    i, j : ndarray of int
        Distances in cells along the two directions, broadcast together.
    spacing : float
        Side of the cell (length).
    contact_modulus : float
        E* (pressure).

    Returns
    -------
    ndarray, shape of the broadcast
        Displacement per pressure (length/pressure), positive.

    References
    ----------
    A. E. H. Love, Phil. Trans. R. Soc. A 228, 377 (1929); K. L. Johnson, Contact
    Mechanics (1985), Eq. (3.25).
    """
    x, y = (np.abs(distance).astype(float) for distance in (i, j))
    kernel = np.asarray(_cell_series(x, y))
    distance = np.maximum(x, y)
    near, between = distance < _NEAR, (distance >= _NEAR) & (distance < _FAR)
    x, y = np.broadcast_arrays(x, y)
    kernel[near] = _cell_integral(x[near], y[near])
    kernel[between] = _cell_quadrature(x[between], y[between])
    kernel *= spacing / (np.pi * contact_modulus)
    return kernel


def _cell_integral(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Integral of 1/r over the unit cell at (x, y), closed form."""
    total = np.zeros(x.shape)
    for s in (0.5, -0.5):
        for t in (0.5, -0.5):
            cx, cy = x + s, y + t
            corner = cx * np.arcsinh(cy / np.abs(cx)) + cy * np.arcsinh(cx / np.abs(cy))
            total += corner if s == t else -corner
    return total


def _cell_quadrature(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Integral of 1/r over the unit cell at (x, y), Gauss points in each direction."""
    total = np.zeros(x.shape)
    for (px, wx), (py, wy) in product(_GAUSS, repeat=2):
        total += wx * wy / np.sqrt((x + px) ** 2 + (y + py) ** 2)
    return total


def _cell_series(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Integral of 1/r over the unit cell at (x, y), far away."""
    x2, y2 = x * x, y * y
    inverse = 1.0 / np.maximum(x2 + y2, 1.0)  # the origin is not far away
    mixed = x2 * y2 * inverse * inverse
    series = 1.0 + inverse * (
        1.0 / 24.0 + inverse * (7.0 / 1920.0) * (20.0 * mixed - 1.0)
    )
    return np.sqrt(inverse) * series
