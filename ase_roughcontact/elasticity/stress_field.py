"""Stress and displacement below a loaded window of the surface, plane by plane.

Between grid points the tractions are interpolated by their waves, and not constant on
cells, where the shear stress would be infinite at the edges.

A periodic cell keeps its size: its mean pressure causes the stress of uniaxial strain.
A free window is padded to one and a half times its size, and the field of its periodic
images is subtracted, see `window_images`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ase_roughcontact._util.validation import finite_array, nonnegative, positive
from ase_roughcontact.elasticity.fft import fast_length
from ase_roughcontact.elasticity.greens import ElasticSolid
from ase_roughcontact.elasticity.periodic_field import (
    Component,
    PeriodicField,
    displacement_waves,
    held_cell,
    stress_waves,
)
from ase_roughcontact.elasticity.window_images import WindowImages

# Product of wave number and depth above which waves have decayed.
_DECAYED = 14.0


class StressField:
    """Stress and displacement below a window of the surface.

    Parameters
    ----------
    solid : ElasticSolid
        The solid, with stresses below its surface, `ElasticSolid.has_subsurface`.
    spacing : float
        Distance of grid points (length).
    pressure : ndarray, shape (n, m)
        Pressure on the surface, positive in compression (pressure).
    tractions : ndarray, shape (2, n, m), optional
        Lateral tractions along x and y on the surface, as of friction (pressure).
    periodic : bool
        Whether the window repeats; otherwise nothing acts outside of it.
    **fft
        Options of `RealFFT2`. Single precision, ``dtype="float32"``, takes about half
        the time, and is accurate to about 1e-6 of the largest pressure.

    Attributes
    ----------
    shape : (int, int)
        Shape of the window.
    pairs : float
        Number of FFT pairs so far, in pairs of the padded grid.

    Raises
    ------
    ValueError
        If an array has another shape or is not finite, or the spacing not positive.
    NotImplementedError
        If the stress in the solid is not known.

    Examples
    --------
    The von Mises stress below a uniform pressure on a square:

    >>> import numpy as np
    >>> from ase_roughcontact.elasticity import Isotropic, StressField
    >>> pressure = np.zeros((64, 64))
    >>> pressure[16:48, 16:48] = 1.0
    >>> field = StressField(Isotropic(1.0, poisson=0.3), 1.0, pressure)
    >>> field.stress(8.0).shape
    (6, 64, 64)
    """

    def __init__(
        self,
        solid: ElasticSolid,
        spacing: float,
        pressure: np.ndarray,
        tractions: np.ndarray | None = None,
        periodic: bool = False,
        **fft: Any,
    ) -> None:
        positive(spacing=spacing)
        loads = [-finite_array("pressure", pressure)]
        if tractions is not None and np.any(tractions):
            loads += [*finite_array("tractions", tractions)]
        if loads[0].ndim != 2 or any(each.shape != loads[0].shape for each in loads):
            shapes = [each.shape for each in loads]
            raise ValueError(
                "pressure must have a shape (n, m), and tractions (2, n, m), got "
                f"{shapes}"
            )
        self.solid, self.spacing, self.periodic = solid, float(spacing), periodic
        self._loads, self._fft = loads, fft
        self.shape = loads[0].shape
        self._images = None
        if not periodic:
            self._images = WindowImages(solid, self.spacing, loads, fft)
        grid = self.shape if self._images is None else self._images.padded
        self._waves = PeriodicField.of(solid, self.spacing, loads, grid, fft)
        if periodic:
            self._waves.mean_response = held_cell
        self._coarser = {grid: self._waves}

    @property
    def pairs(self) -> float:
        """Number of FFT pairs so far, in pairs of the padded grid."""
        points = sum(each.points for each in self._coarser.values())
        return points / math.prod(self._waves.grid)

    def stress(self, depth: float, out: np.ndarray | None = None) -> np.ndarray:
        """Return the stress on the points of the window at a depth.

        Parameters
        ----------
        depth : float
            Depth below the surface (length). From one or two spacings on the stress is
            the stress of the continuum.
        out : ndarray, shape (6, n, m), optional
            Array for the result, such as the result for another depth.

        Returns
        -------
        ndarray, shape (6, n, m)
            Components xx, yy, zz, yz, xz and xy, tension positive, with z upward
            (pressure).
        """
        return self._plane(depth, stress_waves, self._waves, out)

    def displacement(self, depth: float) -> np.ndarray:
        """Return the displacement on the points of the window at a depth.

        Parameters
        ----------
        depth : float
            Depth below the surface (length).

        Returns
        -------
        ndarray, shape (3, n, m)
            Components x, y and z, positive upward; in a periodic cell relative to the
            mean plane of the surface (length).

        Raises
        ------
        ValueError
            If the solid is viscoelastic: its displacement depends on the past.
        """
        if self.solid.creep is not None:
            raise ValueError(
                "the displacement of a viscoelastic solid depends on the past, and is "
                "known at its surface alone; its stress is known at any depth"
            )
        return self._plane(depth, displacement_waves, self._waves)

    def coarse_stress(
        self, depth: float, resolution: float
    ) -> tuple[np.ndarray, tuple[float, float]]:
        """Return the stress on fewer points, with waves longer than two of their steps.

        Parameters
        ----------
        depth : float
            Depth below the surface (length).
        resolution : float
            Largest distance of the points (length).

        Returns
        -------
        stress : ndarray, shape (6, k, l)
            Components, see `stress`, on a grid with the same first point.
        steps : (float, float)
            Distances of the points along x and y, in units of the spacing.
        """
        waves = self._coarse(resolution)
        return self._plane(depth, stress_waves, waves), waves.steps

    def stress_at(self, x: np.ndarray, y: np.ndarray, depth: float) -> np.ndarray:
        """Return the stress at the points of a rectangle at a depth, without an FFT.

        Parameters
        ----------
        x, y : array_like, shapes (k,) and (l,)
            Positions from the first point of the window, in units of the spacing.
        depth : float
            Depth below the surface (length).

        Returns
        -------
        ndarray, shape (6, k, l)
            Components, see `stress` (pressure).

        Raises
        ------
        ValueError
            If the depth is negative, or a point outside of a window that does not
            repeat.
        """
        nonnegative(depth=depth)
        x, y = (
            self._inside(*each) for each in zip("xy", (x, y), self.shape, strict=True)
        )
        waves = self._coarse(math.pi * depth / _DECAYED)
        values = waves.at(depth, stress_waves, x, y)
        if self._images is not None:
            values -= self._images.at(depth, stress_waves, x, y)
        return values

    def around(
        self, x: float, y: float, side: int
    ) -> tuple[StressField, tuple[int, int]]:
        """Return the field of the tractions on a square around a point alone.

        Parameters
        ----------
        x, y : float
            Position from the first point of the window, in units of the spacing.
        side : int
            Number of points along the sides of the square.

        Returns
        -------
        field : StressField
            Field of a window that does not repeat.
        place : (int, int)
            Position of its first point.
        """
        corner, points = [], []
        for middle, count in zip((x, y), self.shape, strict=True):
            length = min(side, count)
            first = round(middle) - length // 2
            if not self.periodic:
                first = min(max(first, 0), count - length)
            corner.append(first)
            points.append(np.arange(first, first + length) % count)
        normal, *lateral = (each[np.ix_(*points)] for each in self._loads)
        tractions = np.stack(lateral) if lateral else None
        field = StressField(self.solid, self.spacing, -normal, tractions, **self._fft)
        return field, (corner[0], corner[1])

    def _inside(self, name: str, points: np.ndarray, count: int) -> np.ndarray:
        """Return positions along an axis, which must be in a window of `count`."""
        points = np.atleast_1d(finite_array(name, points))
        if not self.periodic and (points.min() < 0.0 or points.max() > count - 1):
            raise ValueError(
                f"{name} must be from 0 to {count - 1} in a window that does not "
                f"repeat, got {points.min():g} to {points.max():g}: use a larger window"
            )
        return points

    def _coarse(self, resolution: float) -> PeriodicField:
        """Return the waves longer than twice a distance, on a grid of their own."""
        factor = max(resolution / self.spacing, 1.0)
        factor = 2.0 ** (math.floor(2.0 * math.log2(factor)) / 2.0)
        n, m = self._waves.grid
        grid = _shorter(n, factor), _shorter(m, factor)
        if grid not in self._coarser:
            self._coarser[grid] = self._waves.coarse(grid)
        return self._coarser[grid]

    def _plane(
        self,
        depth: float,
        component: Component,
        waves: PeriodicField,
        out: np.ndarray | None = None,
    ) -> np.ndarray:
        nonnegative(depth=depth)
        values = waves.plane(depth, component, out)
        if self._images is not None:
            x, y = (
                step * np.arange(n)
                for step, n in zip(waves.steps, values.shape[1:], strict=True)
            )
            values -= self._images.at(depth, component, x, y)
        return values


def _shorter(length: int, factor: float) -> int:
    """Return a length with a fast FFT, divided by a factor of at least one."""
    return min(fast_length(math.ceil(length / factor)), length)
