r"""Field of the periodic images of a free window below the surface.

The field is smooth. A coarse grid gives it as the difference of two periodic fields:
one with the period of the padded grid, the other with a period eight times as long, in
which the mean traction has the mean response of long waves over all directions. Closed
forms for a loaded cell (Love 1929) are known for isotropic solids only; these sums take
little time and serve all solids.

References
----------
A. E. H. Love, Phil. Trans. R. Soc. A 228, 377 (1929).
"""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from ase_roughcontact.elasticity.fft import fast_length
from ase_roughcontact.elasticity.greens import ElasticSolid
from ase_roughcontact.elasticity.periodic_field import Component, PeriodicField
from ase_roughcontact.elasticity.subsurface import ALL, SubsurfaceWaves, Tractions

# Side of the padded grid, in sides of the window.
_PADDING = 1.5
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


class WindowImages:
    """Field of the periodic images of a window in a padded grid.

    Parameters
    ----------
    solid : ElasticSolid
        The solid.
    spacing : float
        Distance of grid points (length).
    loads : list of ndarray, shape (n, m)
        Tractions, see `PeriodicField`.
    fft : dict
        Options of `RealFFT2`.

    Attributes
    ----------
    padded : (int, int)
        Shape of the padded grid.
    """

    def __init__(
        self,
        solid: ElasticSolid,
        spacing: float,
        loads: list[np.ndarray],
        fft: dict[str, Any],
    ) -> None:
        self._block, (n, m) = _padded_blocks(loads[0].shape)
        self.padded = self._block * n, self._block * m
        coarse = [_framed(block_means(each, self._block)) for each in loads]
        side = fast_length(_PERIODS * max(n, m))
        fields = []
        for grid in ((n, m), (side, side)):
            field = PeriodicField.of(solid, self._block * spacing, coarse, grid, fft)
            for each in field.loads:
                each *= _smoothing(grid)
            fields.append(field)
        self._near, self._far = fields
        self._far.mean_response = partial(_long_waves, self._far_long_waves())
        # cubic splines of the matrices that interpolate along x and y
        self._splines = [
            CubicSpline(np.arange(k), np.eye(k)) for k in self._near.window
        ]

    def _far_long_waves(self) -> SubsurfaceWaves:
        """Return long waves in all directions with the mean traction as amplitude."""
        q = _MEAN_WAVE_NUMBER * 2.0 * np.pi / self._far.period[0]
        loads = [np.full(_DIRECTIONS.shape, each, complex) for each in self._far.mean]
        wave = q * np.cos(_DIRECTIONS), q * np.sin(_DIRECTIONS)
        return self._far.solid.subsurface(Tractions(*wave, *loads))

    def at(
        self, depth: float, component: Component, x: np.ndarray, y: np.ndarray
    ) -> np.ndarray:
        """Return the field of the images at points, see `PeriodicField.at`."""
        images = self._near.plane(depth, component)
        images -= self._far.plane(depth, component)
        rows, columns = (
            (each - 0.5 * (self._block - 1)) / self._block + 1.0 for each in (x, y)
        )
        across, along = self._splines
        return across(rows) @ images @ along(columns).T


def _long_waves(
    waves: SubsurfaceWaves, field: PeriodicField, depth: float, component: Component
) -> list[float]:
    """Return the mean over the directions of long waves."""
    return [float(each.real.mean()) for each in component(waves, depth, ALL)]


def _padded_blocks(shape: tuple[int, int]) -> tuple[int, tuple[int, int]]:
    """Return the side of blocks, and the numbers of blocks in a padded grid.

    Of several numbers of blocks the one is taken that pads least.
    """
    longest = math.ceil(_PADDING * max(shape))
    sides = [fast_length(math.ceil(longest / blocks)) for blocks in _PADDED_BLOCKS]
    padded = [side * blocks for side, blocks in zip(sides, _PADDED_BLOCKS, strict=True)]
    block = sides[padded.index(min(padded))]
    # the frame of the window needs two blocks, and the spline four
    numbers = [
        fast_length(max(math.ceil(_PADDING * n / block), math.ceil(n / block) + 2, 4))
        for n in shape
    ]
    return block, (numbers[0], numbers[1])


def block_means(values: np.ndarray, block: int) -> np.ndarray:
    """Return the means of square blocks; beyond the last row and column are zeros."""
    n, m = (math.ceil(k / block) for k in values.shape)
    whole = np.zeros((n * block, m * block))
    whole[: values.shape[0], : values.shape[1]] = values
    return whole.reshape(n, block, m, block).mean(axis=(1, 3))


def _framed(values: np.ndarray) -> np.ndarray:
    """Return values in a frame of zeros, at least four in each direction.

    The spline needs four.
    """
    return np.pad(values, [(1, max(1, 3 - k)) for k in values.shape])


def _smoothing(grid: tuple[int, int]) -> np.ndarray:
    """Return factors of waves that remove the shortest, and undo the means of blocks.

    Long waves keep their amplitudes up to the fourth power of the wave number.
    """
    qx = 2.0 * np.pi * np.fft.fftfreq(grid[0])[:, None]
    qy = 2.0 * np.pi * np.fft.rfftfreq(grid[1])
    means = np.sinc(qx / (2.0 * np.pi)) * np.sinc(qy / (2.0 * np.pi))
    return np.exp(-((qx**2 + qy**2) ** 2) / 16.0) / means
