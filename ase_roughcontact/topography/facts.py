"""What is known of an indenter besides its heights, in one place."""

from __future__ import annotations

import hashlib
import json
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ase_roughcontact._util.identity import digest
from ase_roughcontact._util.validation import Point, Shape, check_heights
from ase_roughcontact.topography.base import Surface


@dataclass(frozen=True)
class IndenterFacts:
    """Lengths that describe an indenter, where it knows them.

    The properties are attributes of the indenter of the same names.

    Parameters
    ----------
    indenter : Surface
    """

    indenter: Any

    @property
    def radius(self) -> float:
        """Radius of a sphere; infinity for any other indenter (length)."""
        return getattr(self.indenter, "radius", math.inf)

    @property
    def profile(self) -> str:
        """Shape of a sphere without its roughness; empty for any other indenter."""
        return getattr(self.indenter, "profile", "")

    @property
    def roughness(self) -> Any:
        """Roughness of a sphere, or None; any other indenter is its own roughness."""
        return getattr(self.indenter, "roughness", self.indenter)

    @property
    def periods(self) -> Point:
        """Periods along x and y; infinity where they are not known (length)."""
        return getattr(self.indenter, "periods", (math.inf, math.inf))

    @property
    def short_wavelength(self) -> float:
        """Shortest wavelength of the roughness; NaN if it is not known (length)."""
        return getattr(self.roughness, "short_wavelength", math.nan)

    @property
    def pixel(self) -> float:
        """Distance between the points of a scan; NaN if there is none (length)."""
        return getattr(self.roughness, "pixel", math.nan)

    @property
    def side(self) -> float:
        """Side of the domain of a roughness that is synthesised, else zero (length)."""
        return getattr(self.roughness, "side", 0.0)

    @property
    def edge_change(self) -> float:
        """Rms height subtracted to make a scan periodic (length)."""
        return getattr(self.roughness, "edge_change", 0.0)

    def part_of_period(self, sides: np.ndarray) -> float:
        """Return the smaller ratio of a side of a cell, shape (2,), and the period.

        It is one, but for rounding, if the indenter continues across the edges of a
        periodic cell, as no cell is larger than a period; NaN without a period.
        """
        known = np.isfinite(self.periods)
        ratios = np.where(known, np.divide(sides, self.periods), np.nan)
        return float(np.round(ratios.min(), 9))

    def points(self, spacing: float) -> int:
        """Return the number of points on which the roughness is synthesised."""
        return round(self.side / spacing) ** 2


def sampled_heights(
    indenter: Surface, shape: Shape, spacing: float, origin: Point
) -> np.ndarray:
    """Return the heights of an indenter; see `Surface.heights`.

    Raises
    ------
    ValueError
        If they are not a matrix of finite real numbers.
    """
    heights = np.asarray(indenter.heights(shape, spacing, origin))
    check_heights(heights)
    return heights


def surface_id(surface: Surface | None) -> str | None:
    """Return a name that is the same for the same surface only.

    It is the name of the class and a digest of ``surface.todict()``; None if the
    surface does not have this method, or returns something that JSON cannot represent.
    """
    try:
        text = json.dumps(surface.todict(), default=_plain)  # type: ignore[union-attr]
    except (AttributeError, TypeError, ValueError):
        return None
    # 10 and 10.0 are the same radius
    numbers = json.dumps(json.loads(text, parse_int=float), sort_keys=True)
    return f"{type(surface).__name__}-{digest(numbers.encode())}"


def _plain(value: Any) -> Any:
    """Return what JSON can represent in place of NumPy's types."""
    if isinstance(value, np.ndarray):
        return [value.shape, hashlib.sha256(value.tobytes()).hexdigest()]
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"{type(value).__name__} is not supported")
