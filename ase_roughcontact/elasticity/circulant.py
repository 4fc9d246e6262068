"""Cheap models of the half space, on a box of its atoms."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ase_roughcontact.elasticity.fft import RealFFT2, fast_length
from ase_roughcontact.elasticity.halfspace import HalfSpace
from ase_roughcontact.elasticity.lattice import Box

# Atoms added beside the box: it helps the smallest boxes, and costs the large ones
# little.
_MARGIN = 32


class CirculantModel:
    """Compliance of a box of a half space and its inverse, nearly right.

    The Green's function is wrapped around the box, at the shortest distance: without
    padding, and in single precision. For a free half space the spectrum is off by up to
    30 % in the few longest waves, and right in all others; for a periodic one it is
    right. A correction that is found with it leaves about a tenth of an error, on any
    grid.

    The compliance of an atom alone is the unit: if pressures are in units of ``P``,
    depths are in units of ``local P``.

    Parameters
    ----------
    halfspace : HalfSpace
        The elastic solid.
    box : Box
        Atoms, counted from the first of the window. If the half space is periodic, all
        of the window are taken.

    Attributes
    ----------
    box : Box
        The atoms.
    dtype : dtype
        Single precision.
    points : int
        Number of grid points of a transform.
    local : float
        Compliance of an atom alone (length per pressure).
    exact : bool
        Whether it is the half space itself, but for rounding.
    """

    dtype = np.dtype(np.float32)

    def __init__(self, halfspace: HalfSpace, box: Box) -> None:
        self.exact = halfspace.periodic
        self.box = Box((0, 0), halfspace.shape) if halfspace.periodic else box
        n, m = grid = self.box.shape
        if not halfspace.periodic:
            grid = (
                fast_length(min(2 * n, n + _MARGIN)),
                fast_length(min(2 * m, m + _MARGIN)),
            )
        self.points = grid[0] * grid[1]
        self.local = halfspace.self_compliance
        fft = {**halfspace.fft, "dtype": self.dtype, "measure": False}
        self._transform = RealFFT2(self.box.shape, grid, **fft)
        self._symbol = halfspace.spectrum(grid) / self.local

    @property
    def transforms(self) -> int:
        """Number of pairs of transforms so far."""
        return self._transform.pairs

    @cached_property
    def _compliance(self) -> np.ndarray:
        return self._transform.multiplier(self._symbol)

    @cached_property
    def _stiffness(self) -> np.ndarray:
        # the mean of a periodic surface is taken for a long wave
        softest = max(self._symbol.max(), 1.0)
        inverse = 1.0 / np.where(self._symbol > 0.0, self._symbol, softest)
        return self._transform.multiplier(inverse)

    def compliance(
        self, pressure: np.ndarray, out: np.ndarray | None = None
    ) -> np.ndarray:
        """Depth of the atoms under pressures on them.

        Parameters
        ----------
        pressure : ndarray, shape of the box
            In any unit.
        out : ndarray, shape of the box, optional
            Where to put the result.

        Returns
        -------
        ndarray, shape of the box
            In units of `local` times that of the pressure.
        """
        return self._transform.filter(pressure, self._compliance, out)

    def stiffness(self, depth: np.ndarray, out: np.ndarray | None = None) -> np.ndarray:
        """Pressures that bring the atoms about to a depth.

        Parameters
        ----------
        depth : ndarray, shape of the box
            In any unit.
        out : ndarray, shape of the box, optional
            Where to put the result.

        Returns
        -------
        ndarray, shape of the box
            In units of that of the depth over `local`: positive definite in `depth`.
        """
        return self._transform.filter(depth, self._stiffness, out)

    def relief(self, stiffness: float) -> np.ndarray:
        """Prepare for `relieve` the multiplier ``1/(1 + k (C - 1))``.

        Parameters
        ----------
        stiffness : float
            Of the wall, one for the whole box, in units of ``1/local``.
        """
        return self._transform.multiplier(
            1.0 / (1.0 + stiffness * (self._symbol - 1.0))
        )

    def relieve(
        self, pressure: np.ndarray, relief: np.ndarray, out: np.ndarray | None = None
    ) -> np.ndarray:
        """Pressures that are left of those of a wall when the atoms give way."""
        return self._transform.filter(pressure, relief, out)
