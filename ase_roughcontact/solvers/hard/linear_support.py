"""Load or spring on the indenter for the solver of a hard wall, linear in the height.

The loads of a `Support` may be any function of the height. In the equations of
`ActiveSet` the height is eliminated, which needs a constant load or a linear spring.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from ase_roughcontact.contact import Contact
from ase_roughcontact.contact.support import External

# Relative rounding error of a load.
_LOAD_ROUNDING = 1e-9


@dataclass(frozen=True)
class LinearSupport:
    """A height of the indenter, a constant load on it, or a linear spring.

    Attributes
    ----------
    height : float
        Height of the indenter (length). Under a load it is the initial height, with a
        spring the height at which the spring has no force.
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
        """Return the linear support at heights at which the indenter can touch.

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
        if math.isclose(low, high, rel_tol=_LOAD_ROUNDING):
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
        if abs(load - force) > _LOAD_ROUNDING * scale:
            raise ValueError(
                "ActiveSet needs a constant load or a linear spring: at height "
                f"{height:g} the load is {load:g}, but {force:g} is expected from the "
                "height of first contact"
            )
