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

import numpy as np
from scipy.interpolate import CubicSpline

from ase_roughcontact.elasticity.fft import fast_length
from ase_roughcontact.elasticity.greens import ElasticSolid
from ase_roughcontact.elasticity.periodic_field import Component, PeriodicField
from ase_roughcontact.elasticity.subsurface import Tractions

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
            field = PeriodicField.of(solid, self._block * spacing, coarse, grid, {})
            field.loads = [each * _smoothing(grid) for each in field.loads]
            fields.append(field)
        self._near, self._far = fields
        self._far.mean_response = _long_waves

    def at(
        self, depth: float, component: Component, x: np.ndarray, y: np.ndarray
    ) -> np.ndarray:
        """Return the field of the images at points, see `PeriodicField.at`."""
        images = self._near.plane(depth, component)
        images -= self._far.plane(depth, component)
        rows, columns = (
            (each - 0.5 * (self._block - 1)) / self._block + 1.0 for each in (x, y)
        )
        n, m = images.shape[1:]
        return _spline(n, rows) @ images @ _spline(m, columns).T


def _long_waves(
    field: PeriodicField, depth: float, component: Component
) -> list[float]:
    """Return the mean response of long waves in all directions to the mean traction."""
    q = _MEAN_WAVE_NUMBER * 2.0 * np.pi / field.period[0]
    loads = [np.full(_DIRECTIONS.shape, each, complex) for each in field.mean]
    wave = q * np.cos(_DIRECTIONS), q * np.sin(_DIRECTIONS)
    waves = field.solid.subsurface(Tractions(*wave, *loads))
    return [float(each.real.mean()) for each in component(waves, depth)]


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
