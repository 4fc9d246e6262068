"""Height maps, such as measured topographies."""

from __future__ import annotations

import hashlib
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline, make_interp_spline

from ase_roughcontact._util.validation import FloatArray, height_array, positive, window

# Distance, in steps of the map, within which a grid point counts as a point of the map.
_ROUNDING = 1e-9


class HeightMap:
    """Surface given by its heights on a grid.

    Between the points of the map heights are interpolated by a cubic spline, with
    not-a-knot or periodic boundary conditions.

    Parameters
    ----------
    heights : array_like, shape (n, m)
        Heights (length). Element (n//2, m//2) is on the axis of the indenter.
    spacing : float
        Distance between the points of the map (length).
    periodic : bool
        Whether the map is periodic, with the periods n and m times the spacing.

    Raises
    ------
    ValueError
        If the heights are not a real, finite, two-dimensional array, or the spacing is
        not positive.
    """

    def __init__(
        self, heights: ArrayLike, spacing: float, periodic: bool = False
    ) -> None:
        self._values = height_array(heights)
        positive(spacing=spacing)
        self.spacing = float(spacing)
        self.periodic = bool(periodic)

    @classmethod
    def read(
        cls, file: str | Path, spacing: float, periodic: bool = False
    ) -> HeightMap:
        """Read a map from a file.

        Parameters
        ----------
        file : str or Path
            A .npy file, or a text file with one row (constant x) per line, columns
            separated by blanks or commas, and comments after #.
        spacing : float
            Distance between the points of the map (length).
        periodic : bool
            Whether the map is periodic.

        Returns
        -------
        HeightMap

        Raises
        ------
        ValueError
            If the file cannot be read as a map.
        """
        path = Path(file)
        try:
            values = np.load(path) if path.suffix == ".npy" else _load_text(path)
            return cls(values, spacing, periodic)
        except (OSError, EOFError, ValueError) as error:
            raise ValueError(
                f"cannot read a height map from {str(file)!r}: {error}"
            ) from error

    def heights(
        self,
        shape: tuple[int, int],
        spacing: float,
        origin: tuple[float, float] = (0.0, 0.0),
    ) -> FloatArray:
        """Sample the map on a grid.

        Parameters
        ----------
        shape : tuple of int
            Grid points (n, m) along x and y.
        spacing : float
            Distance between grid points (length), which may differ from that of the
            map.
        origin : tuple of float
            Position (x, y) of grid point (0, 0) relative to the centre of the map
            (length).

        Returns
        -------
        ndarray, shape (n, m)
            Heights (length).

        Raises
        ------
        ValueError
            If the window extends beyond the map, or exceeds its period.
        """
        shape, spacing, origin = window(shape, spacing, origin)
        values = self._values
        for axis, name in enumerate("xy"):
            steps = (origin[axis] + spacing * np.arange(shape[axis])) / self.spacing
            if self.periodic:
                self._check_period(name, shape[axis] * spacing, values.shape[axis])
            else:
                self._check_inside(name, steps, values.shape[axis])
            indices = values.shape[axis] // 2 + steps
            values = _interpolate(values, indices, axis, self.periodic)
        return np.ascontiguousarray(values)

    @property
    def extent(self) -> float:
        """Distance from the axis up to which heights are known; half of a period."""
        n = min(self._values.shape)
        return self.spacing * (n / 2 if self.periodic else (n - 1) // 2)

    @property
    def repeats(self) -> bool:
        """Whether the map is periodic."""
        return self.periodic

    def lowest(self, spacing: float, origin: tuple[float, float] = (0.0, 0.0)) -> float:
        """Return a lower bound of the heights on a grid.

        Parameters
        ----------
        spacing : float
            Distance between grid points (length).
        origin : tuple of float
            Position (x, y) of one of them relative to the centre of the map (length).

        Returns
        -------
        float
            Lowest height of the map if all grid points are points of the map, else
            lowest B-spline coefficient, which is a lower bound of the spline (length).
        """
        steps = np.array([spacing, *origin]) / self.spacing
        if np.abs(steps - np.rint(steps)).max() <= _ROUNDING:
            return float(self._values.min())
        return self._lowest_coefficient

    @cached_property
    def _lowest_coefficient(self) -> float:
        c = self._values
        for axis in (0, 1):
            _check_points(c.shape[axis])
            if self.periodic:
                c = np.concatenate([c, c.take([0], axis)], axis)
            ends = "periodic" if self.periodic else "not-a-knot"
            points = np.arange(c.shape[axis])
            c = make_interp_spline(points, c, 3, axis=axis, bc_type=ends).c
        return float(c.min())

    def todict(self) -> dict[str, Any]:
        """Return the name and the parameters, with a digest instead of the heights.

        Returns
        -------
        dict
        """
        return {
            "name": "HeightMap",
            "shape": self._values.shape,
            "spacing": self.spacing,
            "periodic": self.periodic,
            "sha256": self._digest,
        }

    @cached_property
    def _digest(self) -> str:
        return hashlib.sha256(self._values.tobytes()).hexdigest()[:16]

    def __repr__(self) -> str:
        """Return shape, spacing and periodicity."""
        n, m = self._values.shape
        return f"HeightMap({n} x {m}, {self.spacing:g}, periodic={self.periodic})"

    def __eq__(self, other: object) -> bool:
        """Return whether two maps describe the same surface."""
        return isinstance(other, HeightMap) and self.todict() == other.todict()

    def __hash__(self) -> int:
        """Return a hash of the heights."""
        return hash(self._digest)

    def _check_period(self, name: str, extent: float, n: int) -> None:
        period = n * self.spacing
        if extent > period * (1 + _ROUNDING):
            raise ValueError(
                f"a window of {extent:g} along {name} exceeds the period {period:g} of "
                "the map, so that heights would be repeated: choose a smaller window"
            )

    def _check_inside(self, name: str, steps: NDArray[Any], n: int) -> None:
        first, last = -(n // 2), n - 1 - n // 2
        if steps[0] < first - _ROUNDING or steps[-1] > last + _ROUNDING:
            start, stop, left, right = (
                self.spacing * step for step in (steps[0], steps[-1], first, last)
            )
            raise ValueError(
                f"the window spans {name} = {start:g} to {stop:g}, but the map only "
                f"{left:g} to {right:g}: choose a smaller window or another origin"
            )


def _interpolate(
    values: FloatArray, indices: NDArray[Any], axis: int, periodic: bool
) -> FloatArray:
    """Return values at fractional indices of one axis; exact at whole ones."""
    n = values.shape[axis]
    whole = np.rint(indices)
    if np.abs(indices - whole).max() <= _ROUNDING:
        return values.take(whole.astype(int) % n, axis)
    _check_points(n)
    if periodic:
        values = np.concatenate([values, values.take([0], axis)], axis)
        spline = CubicSpline(np.arange(n + 1), values, axis, bc_type="periodic")
        return spline(indices % n)
    return CubicSpline(np.arange(n), values, axis)(indices.clip(0, n - 1))


def _check_points(n: int) -> None:
    if n < 4:
        raise ValueError(
            f"interpolation needs a map of at least 4 x 4 points, got {n} along a side"
        )


def _load_text(path: Path) -> FloatArray:
    """Read rows of numbers, separated by commas if the first row contains commas."""
    with path.open(encoding="utf-8") as lines:
        rows = [row for line in lines if (row := line.split("#")[0].strip())]
    if not rows:
        raise ValueError("the file contains no numbers")
    return np.loadtxt(rows, delimiter="," if "," in rows[0] else None, ndmin=2)
