r"""Elastic half spaces discretised into square cells, periodic or free.

A pressure :math:`p` displaces the surface by :math:`u = -G * p` (positive upward),
where :math:`G` is the Green's function of the solid (see `greens`). For a periodic half
space this is a product in Fourier space, with the mean displacement set to zero,

.. math:: \tilde u(q) = -G(q)\, \tilde p(q), \qquad \tilde u(0) = 0.

For a free half space it is a convolution with the compliance of single cells. The FFT
is exact for pressure and displacement in a window of n cells, as the grid is padded to
at least ``2n - 1`` cells.

References
----------
R. W. Hockney, Methods Comput. Phys. 9, 135 (1970); H. M. Stanley, T. Kato, J. Tribol.
119, 481 (1997); C. Campana, M. H. Müser, Phys. Rev. B 74, 075420 (2006).
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from functools import cached_property, lru_cache, partial
from typing import Any

import numpy as np

from ase_roughcontact._util.keywords import check_keywords
from ase_roughcontact._util.validation import grid_shape, positive
from ase_roughcontact.elasticity.fft import FFT_OPTIONS, RealFFT2, fast_length
from ase_roughcontact.elasticity.greens import ElasticSolid, Isotropic
from ase_roughcontact.elasticity.spectra import quadrants, wrapped_distance
from ase_roughcontact.elasticity.viscoelastic import Scaled

# Number of spectra that are kept.
_KEPT_SPECTRA = 32
# Largest number of grid points of a spectrum that is kept. All of them take 4 MB.
_MAX_KEPT_POINTS = 256 * 256


class HalfSpace(ABC):
    """Elastic response of a window of surface cells.

    Parameters
    ----------
    shape : (int, int)
        Window ``(n, m)``: the cells that may carry pressure.
    spacing : float
        Side of a cell, the atomic spacing a0 (length).
    solid : ElasticSolid or float
        Solid; a number is the contact modulus of an isotropic solid (pressure).
    **fft
        Options of `RealFFT2`: `dtype`, `engine`, `threads`, `blocking`.

    Attributes
    ----------
    grid : (int, int)
        Grid ``(N, M)`` of the transforms: the window plus the padding of a free half
        space.
    dof_shape : (int, int)
        Shape of the displacement field (the degrees of freedom): the grid, or the
        window if the padding is eliminated.
    fft : dict
        Options of `RealFFT2`.

    Raises
    ------
    ValueError
        If the shape is not two whole numbers, or spacing or modulus are not positive.
    TypeError
        If an option is unknown.
    """

    periodic: bool
    #: Last circulant model of the half space, see `covering_model`.
    model: Any = None

    def __init__(
        self,
        shape: tuple[int, int],
        spacing: float,
        solid: ElasticSolid | float,
        **fft: Any,
    ) -> None:
        check_keywords(type(self).__name__, fft, FFT_OPTIONS)
        self.shape = grid_shape(shape)
        positive(spacing=spacing)
        self.spacing = float(spacing)
        self.solid = solid if isinstance(solid, ElasticSolid) else Isotropic(solid)
        self.grid = self.padded_shape(self.shape)
        self.fft = fft

    def __reduce__(self) -> tuple:
        """Pickle the parameters only: plans and spectra are cheaper to rebuild."""
        return partial(type(self), **self.fft), (self.shape, self.spacing, self.solid)

    def resized(self, shape: tuple[int, int], spacing: float) -> HalfSpace:
        """Return a half space of the same kind and solid on another grid."""
        return type(self)(shape, spacing, self.solid, **self.fft)

    def of(self, solid: ElasticSolid) -> HalfSpace:
        """Return the half space of another solid, which shares the transform."""
        other = type(self)(self.shape, self.spacing, solid, **self.fft)
        other.window_transform = self.window_transform
        return other

    def softened(self, factor: float) -> HalfSpace:
        """Return the half space with a factor of the compliance, and the same plans."""
        solid = self.solid.solid if isinstance(self.solid, Scaled) else self.solid
        return self.of(Scaled(solid, factor))

    def in_single_precision(self) -> HalfSpace:
        """Return the same half space with transforms in single precision."""
        options = {**self.fft, "dtype": np.float32}
        single = type(self)(self.shape, self.spacing, self.solid, **options)
        memory = self.window_transform
        single.window_transform = RealFFT2(
            self.shape, self.grid, **options, memory=memory
        )
        if "_compliance_filter" in vars(self):  # takes less time than a spectrum
            values, scale = self._compliance_filter.real, math.prod(self.grid)
            transform = single.window_transform
            single._compliance_filter = transform.multiplier(values, scale)
        return single

    @property
    def dtype(self) -> np.dtype:
        """Precision of the transforms."""
        return np.dtype(self.fft.get("dtype", float))

    @staticmethod
    @abstractmethod
    def padded_shape(shape: tuple[int, int]) -> tuple[int, int]:
        """Return the shape of the grid for a window of the given shape."""

    def spectrum(self, grid: tuple[int, int]) -> np.ndarray:
        """Return the Fourier transform of the Green's function on a grid.

        Spectra of small grids are kept, and read-only, if the solid is compared by
        value.

        Parameters
        ----------
        grid : (int, int)
            Shape ``(N, M)`` of the padded grid, or of any other grid.

        Returns
        -------
        ndarray, shape (N//2 + 1, M//2 + 1)
            Spectrum, real (length/pressure). The other rows follow, as it is even.
        """
        solid, factor = self.solid, 1.0
        if isinstance(self.solid, Scaled):
            solid, factor = self.solid.solid, self.solid.factor
        kept = math.prod(grid) <= _MAX_KEPT_POINTS and _by_value(solid)
        make = _spectrum if kept else _spectrum.__wrapped__
        spectrum = make(solid, self.spacing, grid, self.periodic)
        return spectrum if factor == 1.0 else factor * spectrum

    @property
    def grid_spectrum(self) -> np.ndarray:
        """Spectrum on the padded grid; see `spectrum`."""
        return self.spectrum(self.grid)

    @property
    def contact_modulus(self) -> float:
        """Contact modulus E* of the solid's far field (pressure)."""
        return self.solid.contact_modulus

    @property
    def cell_area(self) -> float:
        """Area of a surface cell, a0^2."""
        return self.spacing**2

    @property
    def dof_shape(self) -> tuple[int, int]:
        """Shape of the displacement field: the grid with its padding."""
        return self.grid

    @cached_property
    def self_compliance(self) -> float:
        """Depth of a cell under unit pressure on this cell alone (length/pressure).

        The half space is taken as free, also for a periodic cell.
        """
        return self.solid.self_compliance(self.spacing)

    @property
    def compliance(self) -> np.ndarray:
        """Spectrum ``G(q)`` on the grid, shape (N, M//2 + 1) (length/pressure)."""
        return self.grid_spectrum.take(wrapped_distance(self.grid[0]), 0)

    @property
    def stiffness(self) -> np.ndarray:
        """Spectrum ``K(q) = 1/G(q)``, shape (N, M//2 + 1); zero where G is zero."""
        return self._inverse_spectrum.take(wrapped_distance(self.grid[0]), 0)

    @cached_property
    def window_transform(self) -> RealFFT2:
        """Transform of the window on the grid."""
        return RealFFT2(self.shape, self.grid, **self.fft)

    @cached_property
    def grid_transform(self) -> RealFFT2:
        """Transform of the whole grid."""
        if self.grid == self.shape:
            return self.window_transform.twin()
        return RealFFT2(self.grid, **self.fft)

    @property
    def dof_transform(self) -> RealFFT2:
        """Transform of the displacement field."""
        whole = self.dof_shape == self.grid
        return self.grid_transform if whole else self.window_transform

    @property
    def pairs(self) -> int:
        """Number of forward/inverse FFT pairs so far."""
        made = [t for t in ("window_transform", "grid_transform") if t in vars(self)]
        return sum(getattr(self, name).pairs for name in made)

    def displacement(self, pressure: np.ndarray) -> np.ndarray:
        """Return the displacement of the window, ``-G * p``: one FFT pair.

        Parameters
        ----------
        pressure : ndarray, shape (n, m)
            Pressures, positive in compression (pressure).

        Returns
        -------
        ndarray, shape (n, m)
            Displacements, positive upward (length). Their mean is zero if periodic.
        """
        return self.window_transform.filter(pressure, self._compliance_filter)

    def elastic_pressure(self, displacement: np.ndarray) -> np.ndarray:
        """Return the pressure that maintains a displacement, ``-K u``: one FFT pair.

        Parameters
        ----------
        displacement : ndarray, shape `dof_shape`
            Displacement of all degrees of freedom (length).

        Returns
        -------
        ndarray, shape `dof_shape`
            Pressures, positive in compression (pressure).
        """
        return self.grid_transform.filter(displacement, self._stiffness_filter)

    def padded_displacement(self, pressure: np.ndarray) -> np.ndarray:
        """Return the displacement of all degrees of freedom due to a pressure.

        The padding carries no force. Shapes are (n, m) and `dof_shape`.
        """
        if self.dof_shape == self.shape:  # as solvers calculate it, to the last bit
            return self.displacement(pressure)
        return self.grid_displacement(pressure)

    def grid_displacement(self, pressure: np.ndarray) -> np.ndarray:
        """Return the displacement of the whole grid; see `padded_displacement`."""
        if pressure.shape != self.shape:
            raise ValueError(
                f"pressure must have the shape {self.shape}, got {pressure.shape}"
            )
        transform, depth = self.window_transform, [[self.compliance]]
        return -transform.filter_fields(pressure[None], depth, self.grid)[0]

    @cached_property
    def pair_compliance(self) -> np.ndarray:
        """Depth of a cell by unit pressure on another cell (length/pressure).

        The shape is (2n - 1, 2m - 1), with the lattice vector between the cells counted
        from the middle.
        """
        unit = np.zeros(self.shape)
        unit[0, 0] = 1.0
        rows, columns = (abs(np.arange(1 - n, n)) for n in self.shape)
        return -self.displacement(unit)[rows[:, None], columns]

    @property
    def _inverse_spectrum(self) -> np.ndarray:
        """Inverse of the spectrum; zero for the mean of a periodic cell."""
        spectrum, (n, m) = self.grid_spectrum, self.grid
        positive = spectrum > 0
        if positive.size - np.count_nonzero(positive) > self.periodic:
            raise ValueError(
                f"{self.solid} is too stiff at its surface for a grid of {n} x {m}: "
                "relax it with load_path(..., window='auto'), or give a larger window, "
                "such as 20 times the thickness of a stiff layer"
            )
        return np.divide(1.0, spectrum, where=positive, out=np.zeros_like(spectrum))

    @cached_property
    def _compliance_filter(self) -> np.ndarray:
        return self.window_transform.multiplier(self.grid_spectrum, -1.0)

    @cached_property
    def _stiffness_filter(self) -> np.ndarray:
        return self.grid_transform.multiplier(self._inverse_spectrum, -1.0)


class PeriodicHalfSpace(HalfSpace):
    """Half space under a periodic cell.

    Displacements are relative to the mean plane of the surface. See `HalfSpace` for the
    parameters.
    """

    periodic = True

    @staticmethod
    def padded_shape(shape: tuple[int, int]) -> tuple[int, int]:
        """Return the shape itself: a periodic cell needs no padding."""
        return shape

    def displacement(self, pressure: np.ndarray) -> np.ndarray:
        """Return the displacement due to a pressure; see `HalfSpace.displacement`."""
        # without the mean, which displaces nothing, rounding errors are smaller
        values = (pressure - pressure.mean()).astype(self.dtype, copy=False)
        return self.window_transform.filter(values, self._compliance_filter, values)


class FreeHalfSpace(HalfSpace):
    """Half space with a single contact, without periodic images.

    See `HalfSpace` for the parameters.
    """

    periodic = False

    @staticmethod
    def padded_shape(shape: tuple[int, int]) -> tuple[int, int]:
        """Return a fast FFT length of at least ``2n - 1`` in each direction."""
        return fast_length(2 * shape[0] - 1), fast_length(2 * shape[1] - 1)


def _by_value(solid: ElasticSolid) -> bool:
    """Return whether a solid is compared by all of its parameters."""
    if "__hash__" not in vars(type(solid)):  # a base class ignores new parameters
        return False
    try:
        hash(solid)
    except TypeError:  # a parameter is an array or a list
        return False
    return True


@lru_cache(_KEPT_SPECTRA)
def _spectrum(
    solid: ElasticSolid, spacing: float, grid: tuple[int, int], periodic: bool
) -> np.ndarray:
    spectrum = quadrants(solid, spacing, grid, periodic)[0]
    spectrum.flags.writeable = False
    return spectrum
