"""Field of periodic tractions below the surface, on planes and at points.

The tractions are a sum of waves, and each wave has a stress at each depth, see
`subsurface`. One inverse transform for each component gives a plane.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import cached_property
from typing import Any

import numpy as np

from ase_roughcontact._util.threads import split
from ase_roughcontact.elasticity.fft import RealFFT2
from ase_roughcontact.elasticity.greens import ElasticSolid
from ase_roughcontact.elasticity.subsurface import ALL, SubsurfaceWaves, Tractions

# Amplitudes of the components of a field at a depth, from some rows of waves.
Component = Callable[[SubsurfaceWaves, float, slice], Iterator[np.ndarray]]
# Number of waves in a block of rows, which fits into the cache of a processor.
_BLOCK_SIZE = 16384


class PeriodicField:
    """Field of periodic tractions, given by their waves.

    Parameters
    ----------
    solid : ElasticSolid
        The solid.
    period : (float, float)
        Sides of the periodic cell (length).
    loads : list of ndarray, shape (N, M//2 + 1)
        Amplitudes of the tractions z, x and y, without x and y if these are zero.
    window : (int, int)
        Number of points in the result.
    grid : (int, int)
        Shape (N, M) of the grid.
    fft : dict
        Options of `RealFFT2`.
    steps : (float, float)
        Distances of the points of the grid, in spacings of the window.

    Attributes
    ----------
    points : float
        Number of grid points of all FFT pairs so far.
    mean_response : callable
        Returns the response to the mean of the tractions; by default it is zero.
    """

    def __init__(
        self,
        solid: ElasticSolid,
        period: tuple[float, float],
        loads: list[np.ndarray],
        window: tuple[int, int],
        grid: tuple[int, int],
        fft: dict[str, Any],
        steps: tuple[float, float] = (1.0, 1.0),
    ) -> None:
        self.solid, self.period, self.loads = solid, period, loads
        self.window, self.grid, self.fft, self.steps = window, grid, fft, steps
        self.mean = [float(each[0, 0].real) for each in loads]
        self.points = 0.0
        self.mean_response: Callable[..., list[float]] = _without_mean

    @classmethod
    def of(
        cls,
        solid: ElasticSolid,
        spacing: float,
        loads: list[np.ndarray],
        grid: tuple[int, int],
        fft: dict[str, Any],
    ) -> PeriodicField:
        """Return the field of tractions on a window of a grid."""
        transform = RealFFT2(loads[0].shape, grid, **fft)
        amplitudes = [transform.forward(each) / math.prod(grid) for each in loads]
        _remove_shortest(amplitudes, grid)
        period = spacing * grid[0], spacing * grid[1]
        field = cls(solid, period, amplitudes, loads[0].shape, grid, fft)
        field.transform = transform
        field.points = 0.5 * len(loads) * math.prod(grid)
        return field

    @cached_property
    def transform(self) -> RealFFT2:
        """Transform of the window on the grid."""
        return RealFFT2(self.window, self.grid, **self.fft)

    def coarse(self, grid: tuple[int, int]) -> PeriodicField:
        """Return the field of the waves that a smaller grid resolves."""
        rows = _wave_numbers(grid[0])
        kept = [each[rows, : grid[1] // 2 + 1] for each in self.loads]
        _remove_shortest(kept, grid)
        steps = self.grid[0] / grid[0], self.grid[1] / grid[1]
        n, m = (int((k - 1) / step) for k, step in zip(self.window, steps, strict=True))
        field = PeriodicField(
            self.solid, self.period, kept, (n + 1, m + 1), grid, self.fft, steps
        )
        field.mean_response = self.mean_response
        return field

    @cached_property
    def waves(self) -> SubsurfaceWaves:
        """Field below the surface for each wave."""
        (n, m), (length, width) = self.grid, self.period
        qx = 2.0 * np.pi / length * _wave_numbers(n)[:, None]
        qy = 2.0 * np.pi / width * np.arange(m // 2 + 1)
        precision = self.loads[0].real.dtype
        qx, qy = (each.astype(precision) for each in np.broadcast_arrays(qx, qy))
        qy[0, 0] = 1.0 / self.period[1]  # any wave number: the mean is replaced
        return self.solid.subsurface(Tractions(qx, qy, *self.loads))

    def _amplitudes(
        self, depth: float, component: Component
    ) -> Iterator[tuple[slice, list[np.ndarray]]]:
        """Yield blocks of rows, and the amplitudes of the components in these rows."""
        means = self.mean_response(self, depth, component)
        for rows in split(self.grid[0], _BLOCK_SIZE // (self.grid[1] // 2 + 1)):
            parts = list(component(self.waves, depth, rows))
            if rows.start == 0:
                for each, mean in zip(parts, means, strict=False):
                    each[0, 0] = mean
            yield rows, parts

    def plane(
        self, depth: float, component: Component, out: np.ndarray | None = None
    ) -> np.ndarray:
        """Return the components of a field on the window at a depth."""
        number = _NUMBERS[component]
        if out is None:
            out = np.empty((number, *self.window), self.transform.dtype)
        spectra = np.empty((number, *self.loads[0].shape), self.loads[0].dtype)
        for rows, parts in self._amplitudes(depth, component):
            for spectrum, each in zip(spectra, parts, strict=True):
                spectrum[rows] = each
        for spectrum, values in zip(spectra, out, strict=True):
            self.transform.inverse(values, spectrum)
            self.points += 0.5 * math.prod(self.grid)
        return out

    def at(
        self, depth: float, component: Component, x: np.ndarray, y: np.ndarray
    ) -> np.ndarray:
        """Return the components of a field at points x, y, in spacings of the window.

        The points are the rectangle of all pairs of x and y.
        """
        (n, m), steps = self.grid, self.steps
        along_x = np.exp(2j * np.pi / (n * steps[0]) * np.outer(x, _wave_numbers(n)))
        along_y = np.exp(
            2j * np.pi / (m * steps[1]) * np.outer(np.arange(m // 2 + 1), y)
        )
        along_y[1:] *= 2.0  # waves in both directions
        along_x, along_y = (x.astype(self.loads[0].dtype) for x in (along_x, along_y))
        total = np.zeros((_NUMBERS[component], len(x), len(y)))
        for rows, parts in self._amplitudes(depth, component):
            for values, each in zip(total, parts, strict=True):
                values += np.linalg.multi_dot([along_x[:, rows], each, along_y]).real
        return total


def _remove_shortest(waves: list[np.ndarray], grid: tuple[int, int]) -> None:
    """Set waves of two grid points to zero: they have no direction."""
    for each in waves:
        if grid[0] % 2 == 0:
            each[grid[0] // 2] = 0.0
        if grid[1] % 2 == 0:
            each[:, -1] = 0.0


def _wave_numbers(n: int) -> np.ndarray:
    """Return the wave numbers of a transform of n points, in periods."""
    return (np.fft.fftfreq(n) * n).round().astype(int)


def stress_waves(
    waves: SubsurfaceWaves, depth: float, rows: slice = ALL
) -> Iterator[np.ndarray]:
    """Yield the amplitudes of the six components of stress."""
    return waves.stress(depth, rows)


def displacement_waves(
    waves: SubsurfaceWaves, depth: float, rows: slice = ALL
) -> Iterator[np.ndarray]:
    """Yield the amplitudes of the three components of displacement."""
    return waves.displacement(depth, rows)


# Number of components of a field.
_NUMBERS: dict[Component, int] = {stress_waves: 6, displacement_waves: 3}


def _without_mean(
    field: PeriodicField, depth: float, component: Component
) -> list[float]:
    """Return no response to the mean of the tractions."""
    return [0.0] * 6


def held_cell(field: PeriodicField, depth: float, component: Component) -> list[float]:
    """Return the response to the mean in a periodic cell that keeps its size."""
    response = field.solid.uniform_response(depth)
    matrix = response.stress if component is stress_waves else response.displacement
    normal, *lateral = field.mean
    return list(matrix @ np.array([*(lateral or (0.0, 0.0)), normal]))
