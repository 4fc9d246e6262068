"""Specification of a path in time: schedule, controlled quantity and tolerance."""

from __future__ import annotations

from dataclasses import dataclass

from ase_roughcontact._util.validation import positive
from ase_roughcontact.contact.control import BASE, Control
from ase_roughcontact.paths.schedule import Schedule


@dataclass(frozen=True)
class TimeSpecification:
    """Schedule and tolerance of a path in time.

    Attributes
    ----------
    schedule : Schedule
        Targets as a function of time.
    tolerance : float
        Largest error of a time step, relative to the largest force of the path so far,
        and of its energy balance; see `time_path`.

    Raises
    ------
    TypeError
        If the schedule is of another class.
    ValueError
        If the tolerance is not positive.
    """

    schedule: Schedule
    tolerance: float = 1e-3

    def __post_init__(self) -> None:
        """Check schedule and tolerance."""
        if not isinstance(self.schedule, Schedule):
            raise TypeError(
                "the path must be a Schedule, such as Schedule(0.0).ramp(1.0, "
                f"rate=2.0), got {self.schedule!r}"
            )
        positive(tolerance=self.tolerance)


def check_cantilever(control: Control, cantilever: float | None) -> None:
    """Raise an error unless a path that moves the base, and only it, has a cantilever.

    Parameters
    ----------
    control : Control
    cantilever : float or None
        Stiffness, None if it is not given (force per length).

    Raises
    ------
    ValueError
    """
    if control == BASE and cantilever is None:
        raise ValueError("heights of the base need a cantilever: give its stiffness")
    if control != BASE and cantilever is not None:
        raise ValueError(
            "a cantilever needs heights of its base as targets, got "
            f"{control.plural}: give bases, or leave out its stiffness"
        )
    if cantilever is not None:
        positive(cantilever=cantilever)
