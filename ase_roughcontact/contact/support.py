"""Support of the indenter: a given height, or a load, and springs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

#: Energy and upward force on the indenter at a height: of springs, or of load and
#: springs.
External: TypeAlias = Callable[[float], tuple[float, float]]


@dataclass(frozen=True)
class Support:
    """Support of the indenter along z: a fixed height, or a load, and springs.

    Attributes
    ----------
    fixed : bool
        Whether the height is given.
    load : float
        Force that presses the indenter down, unless its height is given.
    springs : callable, optional
        Energy and upward force of springs at a height.
    """

    fixed: bool
    load: float = 0.0
    springs: External | None = None

    @classmethod
    def of(cls, external: External | None) -> Support:
        """Return the support of a solver's argument; None stands for a fixed height."""
        return cls(external is None, springs=external)

    def external(self, height: float) -> tuple[float, float]:
        """Return energy and upward force of load and springs at a height."""
        load = 0.0 if self.fixed else self.load
        energy, force = self.springs(height) if self.springs else (0.0, 0.0)
        return load * height + energy, force - load


@dataclass(frozen=True)
class Spring:
    """Linear spring between the indenter and a base.

    Attributes
    ----------
    stiffness : float
        Stiffness of the spring (force/length).
    base : float
        Height of the indenter at which the spring is without force (length).
    """

    stiffness: float
    base: float

    def __call__(self, height: float) -> tuple[float, float]:
        """Return the energy of the spring at a height, and its upward force."""
        extension = self.base - height
        return 0.5 * self.stiffness * extension**2, self.stiffness * extension


@dataclass(frozen=True)
class LateralSupport:
    """Support of the indenter along x and y, unless its displacement is given.

    It is not part of `Support`, as friction is solved after the normal contact, for
    tractions in units of pressure.

    Attributes
    ----------
    force : (float, float)
        Sums of the tractions along x and y at no displacement (pressure).
    stiffness : float
        Decrease of these sums per displacement (pressure/length); zero under a constant
        force.
    """

    force: tuple[float, float]
    stiffness: float = 0.0

    def excess(self, bound: np.ndarray) -> float:
        """Return the part of a constant force that friction does not carry.

        It is negative below the largest friction, and minus infinity with a spring, or
        without a force.
        """
        size, largest = float(np.hypot(*self.force)), float(bound.sum())
        return 1.0 - largest / size if size and not self.stiffness else -np.inf
