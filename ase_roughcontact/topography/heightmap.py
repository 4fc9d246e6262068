"""An indenter given by its heights on a grid, such as a measured one."""

from __future__ import annotations

import hashlib
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline, make_interp_spline

from ase_roughcontact._util.validation import FloatArray, height_array, positive, window

# Steps of the map by which rounding may move a grid point off a point of the map.
_ROUNDING = 1e-9


class HeightMap:
    """A surface given by its heights on a grid.

    Where a grid point falls on a point of the map it gets that very height, elsewhere
    the cubic spline through the map (not-a-knot at the edges, or periodic).

    Parameters
    ----------
    heights : array_like, shape (n, m)
        Heights, length. Element (n//2, m//2) lies on the axis of the indenter.
    spacing : float
        Distance between the points of the map, length.
    periodic : bool
        Whether the map repeats itself with period (n, m) * spacing.

    Raises
    ------
    ValueError
        If the heights are not a real, finite, two-dimensional array.
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
            A .npy file, or text: one row (constant x) a line, columns separated by
            blanks or commas, comments after #.
        spacing : float
            Distance between the points of the map, length.
        periodic : bool
            Whether the map repeats itself.

        Returns
        -------
        HeightMap
            The map.

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
            Distance between grid points, which may differ from that of the map.
        origin : tuple of float
            Position (x, y) of grid point (0, 0) relative to the centre of the map.

        Returns
        -------
        ndarray, shape (n, m)
            Heights, length.

        Raises
        ------
        ValueError
            If the window reaches beyond the map, or exceeds its period.
        """
        shape, spacing, origin = window(shape, spacing, origin)
        values = self._values
        for axis, name in enumerate("xy"):
            steps = (origin[axis] + spacing * np.arange(shape[axis])) / self.spacing
            if self.periodic:
                self._check_period(name, shape[axis] * spacing, values.shape[axis])
            else:
                self._check_inside(name, steps, values.shape[axis])
            places = values.shape[axis] // 2 + steps
            values = _interpolate(values, places, axis, self.periodic)
        return np.ascontiguousarray(values)

    @property
    def extent(self) -> float:
        """Distance from the axis, along x and y, up to which the map is known once."""
        n = min(self._values.shape)
        return self.spacing * (n / 2 if self.periodic else (n - 1) // 2)

    @property
    def repeats(self) -> bool:
        """Whether the map goes on beyond its extent."""
        return self.periodic

    def lowest(self, spacing: float, origin: tuple[float, float] = (0.0, 0.0)) -> float:
        """Lower bound of the heights on a grid.

        Parameters
        ----------
        spacing : float
            Distance between grid points.
        origin : tuple of float
            Position (x, y) of one of them relative to the centre of the map.

        Returns
        -------
        float
            The map's lowest height if all of them are points of the map; else that of
            the control points of its spline, above which the spline lies.
        """
        steps = np.array([spacing, *origin]) / self.spacing
        if np.abs(steps - np.rint(steps)).max() <= _ROUNDING:
            return float(self._values.min())
        return self._lowest_control

    @cached_property
    def _lowest_control(self) -> float:
        control = self._values
        for axis in (0, 1):
            _check_points(control.shape[axis])
            if self.periodic:
                control = np.concatenate([control, control.take([0], axis)], axis)
            ends = "periodic" if self.periodic else "not-a-knot"
            points = np.arange(control.shape[axis])
            control = make_interp_spline(points, control, 3, axis=axis, bc_type=ends).c
        return float(control.min())

    def todict(self) -> dict[str, Any]:
        """Return the name and the parameters, with a digest in place of heights."""
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

    def __eq__(self, other: object) -> bool:
        """Tell whether two maps describe the same surface."""
        return isinstance(other, HeightMap) and self.todict() == other.todict()

    def __hash__(self) -> int:
        """Hash the heights."""
        return hash(self._digest)

    def _check_period(self, name: str, extent: float, n: int) -> None:
        period = n * self.spacing
        if extent > period * (1 + _ROUNDING):
            raise ValueError(
                f"a window of {extent:g} along {name} exceeds the period of the "
                f"map, {period:g}, and would see the same heights twice"
            )

    def _check_inside(self, name: str, steps: NDArray[Any], n: int) -> None:
        first, last = -(n // 2), n - 1 - n // 2
        if steps[0] < first - _ROUNDING or steps[-1] > last + _ROUNDING:
            start, stop, left, right = (
                self.spacing * step for step in (steps[0], steps[-1], first, last)
            )
            raise ValueError(
                f"the window spans {name} = {start:g} to {stop:g}, beyond "
                f"the map, which spans {left:g} to {right:g}"
            )


def _interpolate(
    values: FloatArray, places: NDArray[Any], axis: int, periodic: bool
) -> FloatArray:
    """Values at places between the indices of one axis; as they are on the indices."""
    n = values.shape[axis]
    whole = np.rint(places)
    if np.abs(places - whole).max() <= _ROUNDING:
        return values.take(whole.astype(int) % n, axis)
    _check_points(n)
    if periodic:
        values = np.concatenate([values, values.take([0], axis)], axis)
        spline = CubicSpline(np.arange(n + 1), values, axis, bc_type="periodic")
        return spline(places % n)
    return CubicSpline(np.arange(n), values, axis)(places.clip(0, n - 1))


def _check_points(n: int) -> None:
    if n < 4:
        raise ValueError(
            f"interpolation needs at least 4 points a side, got a map with {n}"
        )


def _load_text(path: Path) -> FloatArray:
    """Read rows of numbers, separated by commas if the first row has any."""
    with path.open(encoding="utf-8") as lines:
        rows = [row for line in lines if (row := line.split("#")[0].strip())]
    if not rows:
        raise ValueError("the file holds no numbers")
    return np.loadtxt(rows, delimiter="," if "," in rows[0] else None, ndmin=2)
