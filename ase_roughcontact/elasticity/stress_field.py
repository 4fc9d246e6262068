r"""Stress and displacement below a loaded window of the surface, plane by plane.

The tractions are a sum of waves, and each wave has a stress at each depth, see
`subsurface`. One inverse transform for each component gives a plane. Between grid
points the tractions are interpolated by their waves, and not constant on cells, where
the shear stress would be infinite at the edges.

A periodic cell keeps its size: its mean pressure causes the stress of uniaxial strain.
A free window is padded to at least twice its size, and the field of its periodic images
is subtracted. The field of the images is smooth. A coarse grid gives it as the
difference of two periodic fields: one with the period of the padded grid, the other
with a period eight times as long, in which the mean traction has the mean response of
long waves over all directions. Closed forms for a loaded cell (Love 1929) are known for
isotropic solids only; these sums take little time and serve all solids.

References
----------
A. E. H. Love, Phil. Trans. R. Soc. A 228, 377 (1929).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import cached_property
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from ase_roughcontact._util.validation import finite_array, nonnegative, positive
from ase_roughcontact.elasticity.fft import RealFFT2, fast_length
from ase_roughcontact.elasticity.greens import ElasticSolid
from ase_roughcontact.elasticity.subsurface import SubsurfaceWaves, Tractions

# Numbers of coarse cells along the longer side of a padded grid, for the field of the
# images: with few prime factors.
_PADDED_BLOCKS = 24, 25, 27, 28, 30, 32
# Period of the grid that stands for no images, in periods of the padded grid.
_PERIODS = 8
# Response to the mean traction of a single contact: the mean over the directions of
# waves of this number, in units of 2 pi over the period. It corrects the sum over waves
# to the integral, exactly if the response is proportional to 1/|q|: the inverse of
# -4 zeta(1/2) beta(1/2), the sum of 1/|k| over a square lattice.
_MEAN_WAVE_NUMBER = 1.0 / 3.9002649200019558
# Directions over which this mean is taken (rad).
_DIRECTIONS = 2.0 * np.pi * (np.arange(32) + 0.5) / 32
# Product of wave number and depth above which waves have decayed.
_DECAYED = 14.0

#: Amplitudes of the components of a field at a depth, from waves.
_Component = Callable[[SubsurfaceWaves, float], Iterator[np.ndarray]]


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
        Options of `RealFFT2`.

    Attributes
    ----------
    shape : (int, int)
        Shape of the window.
    pairs : float
        Number of FFT pairs of the padded grid so far.

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
        self.shape = loads[0].shape
        self._images = None if periodic else _Images(solid, self.spacing, loads)
        grid = self.shape if self._images is None else self._images.padded
        self._waves = _PeriodicField.of(solid, self.spacing, loads, grid, fft)
        if periodic:
            self._waves.mean_response = _held
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
        return self._plane(depth, _stress, self._waves, out)

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
        return self._plane(depth, _displacement, self._waves)

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
        return self._plane(depth, _stress, waves), waves.steps

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
        values = waves.at(depth, _stress, x, y)
        if self._images is not None:
            values -= self._images.at(depth, _stress, x, y)
        return values

    def _inside(self, name: str, points: np.ndarray, count: int) -> np.ndarray:
        """Return positions along an axis, which must be in a window of `count`."""
        points = np.atleast_1d(finite_array(name, points))
        if not self.periodic and (points.min() < 0.0 or points.max() > count - 1):
            raise ValueError(
                f"{name} must be from 0 to {count - 1} in a window that does not "
                f"repeat, got {points.min():g} to {points.max():g}: use a larger window"
            )
        return points

    def _coarse(self, resolution: float) -> _PeriodicField:
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
        component: _Component,
        waves: _PeriodicField,
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


class _PeriodicField:
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
        Returns the response to the mean of the tractions; by default there is none.
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
    ) -> _PeriodicField:
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

    def coarse(self, grid: tuple[int, int]) -> _PeriodicField:
        """Return the field of the waves that a smaller grid resolves."""
        rows = _wave_numbers(grid[0])
        kept = [each[rows, : grid[1] // 2 + 1] for each in self.loads]
        _remove_shortest(kept, grid)
        steps = self.grid[0] / grid[0], self.grid[1] / grid[1]
        n, m = (int((k - 1) / step) for k, step in zip(self.window, steps, strict=True))
        field = _PeriodicField(
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
        qx, qy = np.broadcast_arrays(qx, qy)
        qy = qy.copy()
        qy[0, 0] = 1.0 / self.period[1]  # any wave number: the mean is replaced
        return self.solid.subsurface(Tractions(qx, qy, *self.loads))

    def _amplitudes(self, depth: float, component: _Component) -> Iterator[np.ndarray]:
        means = self.mean_response(self, depth, component)
        for each, mean in zip(component(self.waves, depth), means, strict=False):
            each[0, 0] = mean
            yield each

    def plane(
        self, depth: float, component: _Component, out: np.ndarray | None = None
    ) -> np.ndarray:
        """Return the components of a field on the window at a depth."""
        if out is None:
            number = 6 if component is _stress else 3
            out = np.empty((number, *self.window), self.transform.dtype)
        amplitudes = self._amplitudes(depth, component)
        for each, values in zip(amplitudes, out, strict=True):
            self.transform.spectrum[:] = each
            self.transform.inverse(values)
            self.points += 0.5 * math.prod(self.grid)
        return out

    def at(
        self, depth: float, component: _Component, x: np.ndarray, y: np.ndarray
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
        return np.stack(
            [
                (along_x @ (each @ along_y)).real
                if len(x) > len(y)
                else ((along_x @ each) @ along_y).real
                for each in self._amplitudes(depth, component)
            ]
        )


def _remove_shortest(waves: list[np.ndarray], grid: tuple[int, int]) -> None:
    """Set waves of two grid points to zero: they have no direction."""
    for each in waves:
        if grid[0] % 2 == 0:
            each[grid[0] // 2] = 0.0
        if grid[1] % 2 == 0:
            each[:, -1] = 0.0


def _shorter(length: int, factor: float) -> int:
    """Return a length with a fast FFT, divided by a factor of at least one."""
    return min(fast_length(math.ceil(length / factor)), length)


def _wave_numbers(n: int) -> np.ndarray:
    """Return the wave numbers of a transform of n points, in periods."""
    return (np.fft.fftfreq(n) * n).round().astype(int)


def _stress(waves: SubsurfaceWaves, depth: float) -> Iterator[np.ndarray]:
    return waves.stress(depth)


def _displacement(waves: SubsurfaceWaves, depth: float) -> Iterator[np.ndarray]:
    return waves.displacement(depth)


def _without_mean(
    field: _PeriodicField, depth: float, component: _Component
) -> list[float]:
    """Return no response to the mean of the tractions."""
    return [0.0] * 6


def _held(field: _PeriodicField, depth: float, component: _Component) -> list[float]:
    """Return the response to the mean in a periodic cell that keeps its size."""
    response = field.solid.uniform_response(depth)
    matrix = response.stress if component is _stress else response.displacement
    normal, *lateral = field.mean
    return list(matrix @ np.array([*(lateral or (0.0, 0.0)), normal]))


def _long_waves(
    field: _PeriodicField, depth: float, component: _Component
) -> list[float]:
    """Return the mean response of long waves in all directions to the mean traction."""
    q = _MEAN_WAVE_NUMBER * 2.0 * np.pi / field.period[0]
    loads = [np.full(_DIRECTIONS.shape, each, complex) for each in field.mean]
    wave = q * np.cos(_DIRECTIONS), q * np.sin(_DIRECTIONS)
    waves = field.solid.subsurface(Tractions(*wave, *loads))
    return [float(each.real.mean()) for each in component(waves, depth)]


class _Images:
    """Field of the periodic images of a window in a padded grid.

    Parameters
    ----------
    solid : ElasticSolid
        The solid.
    spacing : float
        Distance of grid points (length).
    loads : list of ndarray, shape (n, m)
        Tractions, see `_PeriodicField`.

    Attributes
    ----------
    padded : (int, int)
        Shape of the padded grid.
    """

    def __init__(
        self, solid: ElasticSolid, spacing: float, loads: list[np.ndarray]
    ) -> None:
        self._block, (n, m) = _padded_blocks(loads[0].shape)
        self.padded = self._block * n, self._block * m
        coarse = [_block_means(each, self._block) for each in loads]
        side = fast_length(_PERIODS * max(n, m))
        fields = []
        for grid in ((n, m), (side, side)):
            field = _PeriodicField.of(solid, self._block * spacing, coarse, grid, {})
            field.loads = [each * _smoothing(grid) for each in field.loads]
            fields.append(field)
        self._near, self._far = fields
        self._far.mean_response = _long_waves

    def at(
        self, depth: float, component: _Component, x: np.ndarray, y: np.ndarray
    ) -> np.ndarray:
        """Return the field of the images at points, see `_PeriodicField.at`."""
        images = self._near.plane(depth, component)
        images -= self._far.plane(depth, component)
        rows, columns = (
            (each - 0.5 * (self._block - 1)) / self._block + 1.0 for each in (x, y)
        )
        n, m = images.shape[1:]
        return _spline(n, rows) @ images @ _spline(m, columns).T


def _spline(n: int, x: np.ndarray) -> np.ndarray:
    """Return the matrix that interpolates n values at positions, by a cubic spline."""
    return CubicSpline(np.arange(n), np.eye(n))(x)


def _padded_blocks(shape: tuple[int, int]) -> tuple[int, tuple[int, int]]:
    """Return the side of blocks, and the numbers of blocks in a padded grid.

    Of several numbers of blocks the one is taken that pads least.
    """
    longest = 2 * max(shape) - 1
    sides = [fast_length(math.ceil(longest / blocks)) for blocks in _PADDED_BLOCKS]
    padded = [side * blocks for side, blocks in zip(sides, _PADDED_BLOCKS, strict=True)]
    block = sides[padded.index(min(padded))]
    # the frame of the window needs two blocks, and the spline four
    numbers = [
        fast_length(max(math.ceil((2 * n - 1) / block), math.ceil(n / block) + 2, 4))
        for n in shape
    ]
    return block, (numbers[0], numbers[1])


def _block_means(values: np.ndarray, block: int) -> np.ndarray:
    """Return the means of square blocks, in a frame of one block of zeros."""
    n, m = (math.ceil(k / block) for k in values.shape)
    whole = np.zeros((n * block, m * block))
    whole[: values.shape[0], : values.shape[1]] = values
    means = whole.reshape(n, block, m, block).mean(axis=(1, 3))
    # at least four in each direction, as the spline needs
    frame = [(1, max(1, 3 - k)) for k in (n, m)]
    return np.pad(means, frame)


def _smoothing(grid: tuple[int, int]) -> np.ndarray:
    """Return factors of waves that remove the shortest, and undo the means of blocks.

    Long waves keep their amplitudes up to the fourth power of the wave number.
    """
    qx = 2.0 * np.pi * np.fft.fftfreq(grid[0])[:, None]
    qy = 2.0 * np.pi * np.fft.rfftfreq(grid[1])
    means = np.sinc(qx / (2.0 * np.pi)) * np.sinc(qy / (2.0 * np.pi))
    return np.exp(-((qx**2 + qy**2) ** 2) / 16.0) / means
