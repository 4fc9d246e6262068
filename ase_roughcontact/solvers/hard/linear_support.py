"""What holds the indenter, as the solver of a hard wall needs it: linear in the height.

The loads of a `Support` may be any function of the height. `ActiveSet` has the height
eliminated from its equations, for which they must be constant or those of one linear
spring where the indenter touches the surface.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from ase_roughcontact.contact import Contact
from ase_roughcontact.contact.support import External

# Relative difference of loads that counts as rounding.
_ROUNDING = 1e-9


@dataclass(frozen=True)
class LinearSupport:
    """A height of the indenter, a constant load on it, or a linear spring.

    Attributes
    ----------
    height : float
        Height of the indenter; with a load its initial one, with a spring the height at
        which the spring is without force (length).
    load : float or None
        Positive constant load (force).
    compliance : float
        Inverse of the stiffness of the spring; zero without a spring (length/force).
    """

    height: float
    load: float | None = None
    compliance: float = 0.0

    @classmethod
    def of(
        cls, contact: Contact, height: float, external: External | None
    ) -> LinearSupport:
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
        compliance = spacing / (high - low)
        if not 0.0 < compliance < math.inf:
            raise ValueError(
                f"the load must not decrease with the height, but it is {low:g} at "
                f"height {first:g} and {high:g} at {first + spacing:g}"
            )
        return cls(first - compliance * low, compliance=compliance)

    def check(self, external: External, height: float, force: float) -> None:
        """Raise `ValueError` if the load at a height is not the expected force."""
        load = -external(height)[1]
        scale = max(abs(load), abs(force))
        if self.compliance:
            scale += (abs(height) + abs(self.height)) / self.compliance
        if abs(load - force) > _ROUNDING * scale:
            raise ValueError(
                "ActiveSet needs a load that is constant or that of a linear spring: "
                f"at height {height:g} it is {load:g}, but {force:g} is expected from "
                "the load where the indenter touches the surface first"
            )
