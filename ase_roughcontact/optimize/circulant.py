"""A cheap model of the half space below a few of its atoms."""

from __future__ import annotations

import numpy as np

from ase_roughcontact.fourier import RealFFT2, fast_length
from ase_roughcontact.halfspace import HalfSpace

# Atoms added beside the box of the atoms: it helps the smallest boxes, and costs the
# large ones little.
_MARGIN = 32


class Circulant:
    """Compliance of some atoms of a half space and its inverse, nearly right.

    The Green's function is wrapped around the bounding box of the atoms, at the
    shortest distance: without padding, and in single precision. For a free half space
    the spectrum is off by up to 30 % in the few longest waves, and right in all others;
    for a periodic one it is right. A correction that is found with it leaves about a
    tenth of an error, on any grid.

    All vectors hold one number per atom, or per member where ``members`` are positions
    in the list of atoms.

    Parameters
    ----------
    halfspace : HalfSpace
        The elastic solid.
    atoms : ndarray of int, shape (k,)
        Flat indices of atoms of the window.

    Attributes
    ----------
    atoms : ndarray of int, shape (k,)
        The same.
    points : int
        Number of grid points of a transform.
    local : float
        Compliance of an atom alone (length per pressure).
    modulus : float
        Contact modulus (pressure).
    exact : bool
        Whether it is the half space itself, but for rounding.
    """

    def __init__(self, halfspace: HalfSpace, atoms: np.ndarray) -> None:
        self.atoms = atoms
        self.local = halfspace.atom_compliance
        self.modulus = halfspace.contact_modulus
        self.exact = halfspace.periodic
        i, j = np.divmod(atoms, halfspace.shape[1])
        window = grid = halfspace.shape
        if not halfspace.periodic:
            i, j = i - i.min(), j - j.min()
            window = int(i.max()) + 1, int(j.max()) + 1
            n, m = (fast_length(min(2 * n, n + _MARGIN)) for n in window)
            grid = n, m
        self.points = grid[0] * grid[1]
        self._where = i * window[1] + j
        self._field = np.zeros(window, np.float32)
        fft = {**halfspace.fft, "dtype": np.float32, "measure": False}
        self._transform = RealFFT2(window, grid, **fft)
        # in units of an atom's own: single precision has no room for units of length
        symbol = halfspace.symbol(grid) / self.local
        self._compliance = self._transform.multiplier(symbol)
        # the mean of a periodic surface is taken for a long wave
        softest = max(symbol.max(), 1.0)
        inverse = 1.0 / np.where(symbol > 0.0, symbol, softest)
        self._stiffness = self._transform.multiplier(inverse)

    @property
    def transforms(self) -> int:
        """Number of pairs of transforms so far."""
        return self._transform.pairs

    def compliance(self, pressure: np.ndarray, members: np.ndarray) -> np.ndarray:
        """Depth of all atoms under pressure on the members.

        Parameters
        ----------
        pressure : ndarray, shape (number of members,)
            Pressure.
        members : ndarray of int
            Positions in the list of atoms.

        Returns
        -------
        ndarray, shape (k,)
            Length.
        """
        source = self._where[members]
        units = self.modulus, self.local
        return self._convolve(pressure, source, self._compliance, self._where, units)

    def stiffness(self, depth: np.ndarray, members: np.ndarray) -> np.ndarray:
        """Pressure on the members that brings them about to a depth.

        Parameters
        ----------
        depth : ndarray, shape (number of members,)
            Length.
        members : ndarray of int
            Positions in the list of atoms.

        Returns
        -------
        ndarray, shape (number of members,)
            Pressure: positive definite in `depth`.
        """
        source = self._where[members]
        units = self.local * self.modulus, 1.0 / self.local
        return self._convolve(depth, source, self._stiffness, source, units)

    def _convolve(
        self,
        values: np.ndarray,
        source: np.ndarray,
        multiplier: np.ndarray,
        target: np.ndarray,
        units: tuple[float, float],
    ) -> np.ndarray:
        """Convolve values in a unit, and multiply the result by another."""
        unit, factor = units
        flat = self._field.reshape(-1)
        flat[source] = values * (1.0 / unit)
        result = self._transform.filter(self._field, multiplier)
        flat[source] = 0.0
        return np.multiply(result.reshape(-1)[target], unit * factor, dtype=float)
