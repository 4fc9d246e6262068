"""Specification of a sliding path in time: schedule, friction, spring and tolerance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ase_roughcontact._util.validation import finite, lookup, positive
from ase_roughcontact.interactions.rate_and_state import RateFriction, check_rate
from ase_roughcontact.path_kinds.sliding.specification import (
    LATERAL_CONTROLS,
    LATERAL_DISPLACEMENT,
    check_spring,
)
from ase_roughcontact.paths.schedule import Schedule


@dataclass(frozen=True, eq=False)
class TimedSlidingSpecification:
    """Schedule, friction and options of a sliding path in time.

    Attributes
    ----------
    target : float
        Normal target of all steps.
    friction : RateFriction
        Law that depends on the slip rate, such as `RateAndState`.
    schedule : Schedule
        Lateral targets as a function of time, without sudden changes.
    control : LateralControl
        Quantity of the lateral targets, which may be given by its name; see
        `SlidingSpecification`.
    spring : float or None
        Stiffness of the spring, for bases (force/length).
    direction : (float, float)
        Unit vector along which the indenter moves.
    tolerance : float
        Largest error of a time step, relative to the friction.

    Raises
    ------
    ValueError
        If a number is not finite, a name is unknown, the spring is missing, or the
        schedule has a sudden change or takes no time.
    TypeError
        If the friction does not depend on the slip rate, or the targets are not a
        `Schedule`.
    """

    target: float
    friction: RateFriction
    schedule: Schedule
    control: Any = LATERAL_DISPLACEMENT
    spring: float | None = None
    direction: tuple[float, float] = (1.0, 0.0)
    tolerance: float = 1e-4

    def __post_init__(self) -> None:
        """Check all."""
        if isinstance(self.control, str):
            control = lookup(self.control, LATERAL_CONTROLS, "control")
            object.__setattr__(self, "control", control)
        check_rate(self.friction)
        if not isinstance(self.schedule, Schedule):
            raise TypeError(
                "lateral targets in time must be a Schedule, such as "
                f"Schedule(0.0).ramp(1.0, rate=2.0), got {self.schedule!r}"
            )
        if not self.schedule.duration or not all(
            part.duration for part in self.schedule.parts
        ):
            raise ValueError(
                f"{self.control.name} must change in a time, at a finite rate: give a "
                "ramp for each change"
            )
        check_spring(self.control, self.spring)
        finite(target=self.target)
        positive(tolerance=self.tolerance)

    @property
    def towards(self) -> np.ndarray:
        """Unit vector along which the indenter moves."""
        return np.array(self.direction)

    @property
    def parameters(self) -> dict[str, Any]:
        """Friction, spring and direction, on which a state depends."""
        return {
            "friction": self.friction.todict(),
            "spring": self.spring or 0.0,
            "direction": list(self.direction),
        }
