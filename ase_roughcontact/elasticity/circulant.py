"""Circulant approximation of a half space, which is cheap and nearly exact.

The Green's function is wrapped around a box of atoms at the shortest distance, so that
convolutions with it need no padding, and single precision is enough. For a free half
space the spectrum is wrong by up to 30 % for the few longest waves and accurate for all
others; for a periodic half space it is exact. A correction of the pressure that solves
the contact problem of the model removes about nine tenths of an error, on any grid.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property

import numpy as np

from ase_roughcontact.elasticity.fft import RealFFT2, fast_length
from ase_roughcontact.elasticity.halfspace import HalfSpace
from ase_roughcontact.elasticity.lattice import Box

# Largest padding of a box along x and y (atoms). It improves the model at little cost.
_MAX_PADDING = 16
# Largest number of atoms of a window with an exact model (all of its padding): in small
# windows a convolution costs less than the rest of an outer step of a solver.
_MAX_EXACT_ATOMS = 40 * 40
# Largest number of grid points of an exact model in double precision, which saves one
# outer step.
_MAX_DOUBLE_POINTS = 128 * 128


class CirculantModel:
    """Compliance ``C`` of a box of atoms, its inverse and a preconditioner.

    Displacements are in units of `self_compliance` times the unit of pressure.

    Parameters
    ----------
    halfspace : HalfSpace
        The elastic solid.
    box : Box
        Atoms of the window; an exact model covers all of them.

    Attributes
    ----------
    box : Box
        The atoms of the model.
    dtype : dtype
        Single precision; double precision of small exact models.
    self_compliance : float
        Displacement of an atom by a unit pressure on it alone (length per pressure).
    exact : bool
        Whether the model is the half space itself, up to rounding: true for periodic
        half spaces and for small windows, with all of their padding.
    singular : bool
        Whether a uniform pressure has no compliance, as on a periodic half space.
    """

    def __init__(self, halfspace: HalfSpace, box: Box) -> None:
        self.singular = halfspace.periodic
        self.exact = (
            halfspace.periodic or math.prod(halfspace.shape) <= _MAX_EXACT_ATOMS
        )
        self.self_compliance = halfspace.self_compliance
        if self.exact:
            self.box, grid = Box((0, 0), halfspace.shape), halfspace.grid
        else:
            self.box, grid = box, padded_box(box.shape)
        double = self.exact and math.prod(grid) <= _MAX_DOUBLE_POINTS
        self.dtype = np.dtype("float64" if double else "float32")
        self._spectrum = halfspace.spectrum(grid) / self.self_compliance
        if self.exact and halfspace.dtype == self.dtype:
            self._transform = halfspace.window_transform.twin()
        else:
            fft = {**halfspace.fft, "dtype": self.dtype}
            memory = halfspace.window_transform
            self._transform = RealFFT2(self.box.shape, grid, **fft, memory=memory)

    @cached_property
    def _compliance(self) -> np.ndarray:
        return self._transform.multiplier(self._spectrum)

    @cached_property
    def _stiffness(self) -> np.ndarray:
        # the mean of a periodic surface has no compliance: take the largest of a wave
        spectrum = self._spectrum
        largest = max(spectrum.max(), 1.0)
        inverse = 1.0 / np.where(spectrum > 0.0, spectrum, largest)
        return self._transform.multiplier(inverse)

    def compliance(
        self, pressure: np.ndarray, out: np.ndarray | None = None
    ) -> np.ndarray:
        """Return ``C p``, the opening of the gap under a pressure."""
        return self._transform.filter(pressure, self._compliance, out)

    def stiffness(
        self, opening: np.ndarray, out: np.ndarray | None = None
    ) -> np.ndarray:
        """Return a pressure that opens the gap by about `opening`.

        It is linear, symmetric and positive definite in `opening`.
        """
        return self._transform.filter(opening, self._stiffness, out)

    def preconditioner(
        self, wall_share: float
    ) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
        """Return the operator ``(s + (1 - s) C)^-1`` of a uniform wall and the solid.

        The share ``s`` is the compliance of the wall over the compliance of wall and
        atom in series: zero for a hard wall, at most one. The operator is a function
        of a pressure and of an array for the result.
        """
        if wall_share > 0.0:
            series = wall_share + (1.0 - wall_share) * self._spectrum
            multiplier = self._transform.multiplier(1.0 / series)
        else:
            multiplier = self._stiffness
        transform = self._transform
        return lambda pressure, out: transform.filter(pressure, multiplier, out)


def padded_box(shape: tuple[int, int]) -> tuple[int, int]:
    """Return the shape of a box with some padding, rounded up to fast lengths."""
    n, m = (fast_length(min(2 * n, n + _MAX_PADDING)) for n in shape)
    return n, m


def covering_model(halfspace: HalfSpace, box: Box) -> CirculantModel:
    """Return a model of a box; the last model of the half space if it covers the box.

    The model is kept as ``halfspace.model``: steps of a path often need the same one.
    """
    model: CirculantModel | None = halfspace.model
    if model is None or not (model.exact or model.box == box):
        halfspace.model = model = CirculantModel(halfspace, box)
    return model
