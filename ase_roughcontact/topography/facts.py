"""What is known of an indenter besides its heights, in one place."""

from __future__ import annotations

import hashlib
import json
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ase_roughcontact._util.identity import digest
from ase_roughcontact._util.validation import Point, Shape, check_heights, unmasked
from ase_roughcontact.topography.base import Surface


def _known(name: str, default: Any, part: str = "indenter") -> Any:
    """Return a property: an attribute of the indenter, or of its roughness."""
    return property(lambda facts: getattr(getattr(facts, part), name, default))


@dataclass(frozen=True)
class IndenterFacts:
    """Lengths that describe an indenter, where it knows them.

    Parameters
    ----------
    indenter : Surface

    Attributes
    ----------
    radius : float
        Radius of a sphere; infinity for any other indenter (length).
    profile : str
        Shape of a sphere without its roughness; empty for any other indenter.
    periods : (float, float)
        Periods along x and y; infinity where they are not known (length).
    short_wavelength : float
        Shortest wavelength of the roughness; NaN if it is not known (length).
    pixel : float
        Distance between the points of a scan; NaN if there is none (length).
    side : float
        Side of the domain of a roughness that is synthesised, else zero (length).
    repeats : bool
        Whether the indenter is periodic beyond its extent.
    edge_change : float
        Rms height subtracted to make a scan periodic (length).
    """

    indenter: Any

    radius = _known("radius", math.inf)
    profile = _known("profile", "")
    periods = _known("periods", (math.inf, math.inf))
    repeats = _known("repeats", False)
    short_wavelength = _known("short_wavelength", math.nan, "roughness")
    pixel = _known("pixel", math.nan, "roughness")
    side = _known("side", 0.0, "roughness")
    edge_change = _known("edge_change", 0.0, "roughness")

    @property
    def roughness(self) -> Any:
        """Roughness of a sphere, or None; any other indenter is its own roughness."""
        return getattr(self.indenter, "roughness", self.indenter)

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
    heights = unmasked(indenter.heights(shape, spacing, origin))
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
