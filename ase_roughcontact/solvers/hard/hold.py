"""What holds the indenter in a contact with a hard wall."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ase_roughcontact.contact import Contact
from ase_roughcontact.solvers.relaxation import External

# Relative difference of loads that counts as rounding.
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Hold:
    """A height of the indenter, a load on it, or a spring.

    Attributes
    ----------
    height : float
        Height of the indenter; with a load its initial one, with a spring that at which
        the spring is without force (length).
    load : float or None
        Positive constant load (force).
    softness : float
        Of the spring, one over its stiffness; zero without (length per force).
    """

    height: float
    load: float | None = None
    softness: float = 0.0

    @classmethod
    def of(cls, contact: Contact, height: float, external: External | None) -> Hold:
        """Return what holds the indenter where it can touch the surface.

        Raises
        ------
        ValueError
            If a constant load is negative or not finite, or a spring pushes.
        """
        if external is None:
            return cls(height)
        first = 0.0 - float(contact.heights.min())  # not -0
        spacing = contact.halfspace.spacing
        low, high = (-external(z)[1] for z in (first, first + spacing))
        if math.isclose(low, high, rel_tol=_ROUNDING):
            if not 0.0 <= low < math.inf:
                raise ValueError(
                    "a hard wall carries no tension: load must be finite and >= 0, "
                    f"got {low:g}"
                )
            return cls(height, low)
        softness = spacing / (high - low)
        if not 0.0 < softness < math.inf:
            raise ValueError(
                f"the load must not decrease with the height, but it is {low:g} at "
                f"height {first:g} and {high:g} at {first + spacing:g}"
            )
        return cls(first - softness * low, softness=softness)

    def check(self, external: External, height: float, force: float) -> None:
        """Raise `ValueError` if the force at a height is not that of the load there."""
        load = -external(height)[1]
        scale = max(abs(load), abs(force))
        if self.softness:
            scale += (abs(height) + abs(self.height)) / self.softness
        if abs(load - force) > _ROUNDING * scale:
            raise ValueError(
                "ActiveSet needs a load that is constant or that of a linear spring: "
                f"at height {height:g} it is {load:g}, but {force:g} is expected from "
                "the load where the indenter touches the surface first"
            )
