"""A work of adhesion that varies over the surface."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ase_roughcontact._util.validation import (
    FloatArray,
    Point,
    Shape,
    finite_array,
    positive,
    window,
)
from ase_roughcontact.topography.random_waves import RandomWaves
from ase_roughcontact.topography.topography import topography_of


@dataclass(frozen=True)
class Heterogeneity:
    r"""Local work of adhesion, relative to the work of adhesion of the wall.

    .. math:: w(x, y)/w = \max(1 + f(x, y), 0)

    The pattern f is a map, a function, or a random field. It is fixed to the substrate,
    with its origin on the axis of the indenter, and part of an infinite surface: a
    window cuts it out.

    Parameters
    ----------
    pattern : Surface or callable
        The relative deviation f: `HeightMap` of an array; a function of the positions x
        and y from the axis, arrays which broadcast (length); or `SelfAffine` for a
        random field with a spectrum and a seed.
    rms : float, optional
        Root mean square of f, to which a map less its mean or a random field is
        scaled, so that the mean work of adhesion is the wall's; required for a random
        field. By default the pattern is f itself, with its mean.

    Raises
    ------
    ValueError
        If `rms` is not positive, or missing or given where it must not be, or the map
        is flat.

    Notes
    -----
    Where f is below -1, w is zero: its mean is then larger than the mean of 1 + f.

    Examples
    --------
    >>> import numpy as np
    >>> from ase_roughcontact import Heterogeneity, SelfAffine
    >>> stripes = Heterogeneity(lambda x, y: 0.3 * np.sign(np.sin(x / 5.0)) + 0.0 * y)
    >>> field = SelfAffine(1.0, 0.5, short_wavelength=8.0, long_wavelength=32.0, seed=1)
    >>> patches = Heterogeneity(field, rms=0.3)
    >>> values = patches.factors((128, 128), 1.0)
    >>> round(float(values.mean()), 3), round(float(values.std()), 3)
    (1.0, 0.3)
    """

    pattern: Any
    rms: float | None = None

    def __post_init__(self) -> None:
        """Check the parameters."""
        if not (self._is_surface or callable(self.pattern)):
            raise ValueError(
                "pattern must be a HeightMap, a SelfAffine or a function of x and y, "
                f"got {self.pattern!r}"
            )
        if self.rms is not None:
            positive(rms=self.rms)
            if not self._is_surface or math.isnan(self._rms_of_pattern):
                raise ValueError("rms is for maps and random fields: omit it")
            if self._rms_of_pattern == 0.0:
                raise ValueError("a map that is scaled to rms must not be flat")
        elif isinstance(self.pattern, RandomWaves):
            raise ValueError("a random field needs rms, its root mean square")

    def factors(
        self, shape: Shape, spacing: float, origin: Point = (0.0, 0.0)
    ) -> FloatArray:
        """Sample the relative work of adhesion, ``w(x, y)/w >= 0``, on a grid.

        See `Surface.heights` for the grid.

        Raises
        ------
        ValueError
            If a map, or the period of a pattern, is smaller than the window, or a
            function does not return finite numbers.
        """
        shape, spacing, origin = window(shape, spacing, origin)
        if self._is_surface:
            try:
                values = self.pattern.heights(shape, spacing, origin)
            except ValueError as error:  # in the words of surfaces, as of roughness
                raise ValueError(f"work of adhesion: {error}") from error
            if self.rms is not None:
                mean = topography_of(self.pattern).mean_height
                values = self.rms / self._rms_of_pattern * (values - mean)
        else:
            x = origin[0] + spacing * np.arange(shape[0])
            y = origin[1] + spacing * np.arange(shape[1])
            values = finite_array("pattern", self.pattern(x[:, None], y[None, :]))
            values = np.broadcast_to(values, shape)
        return np.maximum(1.0 + values, 0.0)

    def todict(self) -> dict[str, Any]:
        """Return the parameters of pattern and field; of a function the name only."""
        pattern = self.pattern
        if self._is_surface:
            return {"pattern": pattern.todict(), "rms": self.rms}
        return {"pattern": getattr(pattern, "__qualname__", type(pattern).__name__)}

    @property
    def _rms_of_pattern(self) -> float:
        return topography_of(self.pattern).statistics().rms_height

    @property
    def _is_surface(self) -> bool:
        return hasattr(self.pattern, "heights")
