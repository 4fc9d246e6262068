"""Smooth indenter of a simple shape, such as a cone, a pyramid or a punch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ase_roughcontact._util.validation import FloatArray, Point, Shape, window
from ase_roughcontact.theory.indenters import Indenter
from ase_roughcontact.topography.topography import Plane, Topography


@dataclass(frozen=True)
class ShapedIndenter(Topography):
    """Lower side of an indenter of a simple shape.

    Parameters
    ----------
    shape : Indenter
        Cone, pyramid, punch or another shape, with lengths in the unit of the grid.

    Examples
    --------
    >>> import math
    >>> from ase_roughcontact.theory.indenters import Cone
    >>> from ase_roughcontact.topography import ShapedIndenter
    >>> cone = ShapedIndenter(Cone(math.radians(45.0)))
    >>> cone.heights((1, 3), 2.0).round(3).tolist()
    [[0.0, 2.0, 4.0]]
    """

    shape: Indenter

    def heights(
        self, shape: Shape, spacing: float, origin: Point = (0.0, 0.0)
    ) -> FloatArray:
        """Sample the heights on a grid; see `Surface.heights`."""
        shape, spacing, origin = window(shape, spacing, origin)
        x = origin[0] + spacing * np.arange(shape[0], dtype=float)
        y = origin[1] + spacing * np.arange(shape[1], dtype=float)
        return self.shape.profile(x[:, None], y[None, :])

    def reach(self, level: float, spacing: float, origin: Point = (0.0, 0.0)) -> float:
        """Return where the indenter is high enough; see `BoundedSurface.reach`."""
        return self.shape.reach(max(level, 0.0))

    def lowest(self, spacing: float, origin: Point = (0.0, 0.0)) -> float:
        """Return the height of the tip, zero."""
        return 0.0

    @property
    def has_edges(self) -> bool:
        """Whether edges between faces touch."""
        return self.shape.edged

    @property
    def vertical_sides(self) -> bool:
        """Whether the sides are vertical and never touch."""
        return self.shape.vertical

    @property
    def rough(self) -> Topography:
        """Roughness: a plane, as the indenter is smooth."""
        return Plane()

    def band_limited(self, shortest: float) -> ShapedIndenter:
        """Return the indenter itself: it has no waves."""
        return self

    def todict(self) -> dict[str, Any]:
        """Return the name and the dimensions."""
        return {"name": self.shape.name, **_dimensions(self.shape)}


def _dimensions(shape: Indenter) -> dict[str, Any]:
    """Return the dimensions of a shape by their names."""
    return {name: getattr(shape, name) for name in shape.parameters}
