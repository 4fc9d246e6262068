"""Positions of time steps in the parts of a schedule, which they halve and double."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeVar

from ase_roughcontact._util.identity import differences
from ase_roughcontact.paths.path_steps import Position

#: Largest power of two by which the duration of a part is divided.
MAX_LEVEL = 40
# Largest error of a step that is followed by one of twice its duration, relative to the
# tolerance: the error grows eightfold.
_MAX_GROWTH_ERROR = 0.1

AnyPosition = TypeVar("AnyPosition", bound="SchedulePosition")


@dataclass(frozen=True)
class SchedulePosition(Position):
    """Position of the end of a time step in a schedule.

    Attributes
    ----------
    part : int
        Part of the schedule.
    level, done : int
        Steps of the part that are done, in units of ``2**-level`` of its duration.
    may_grow : bool
        Whether the error of the last step allows a longer one.
    """

    part: int = -1
    level: int = 0
    done: int = 0
    may_grow: bool = False

    @property
    def ended(self) -> bool:
        """Whether the part is done."""
        return self.done >= 2**self.level

    @property
    def fractions(self) -> tuple[float, float]:
        """Parts of the duration at which the next step begins and ends."""
        count = 2**self.level
        return self.done / count, (self.done + 1) / count

    def in_part(self: AnyPosition, part: int, level: int) -> AnyPosition:
        """Return the position at the start of a part."""
        return replace(self, part=part, level=level, done=0)

    def grown(self: AnyPosition, least: int) -> AnyPosition:
        """Return the position before a step of twice the duration, if it is allowed.

        Parameters
        ----------
        least : int
            Smallest power of two by which the part is divided.
        """
        if not self.may_grow or self.level <= least or self.done % 2:
            return self
        return replace(self, level=self.level - 1, done=self.done // 2, may_grow=False)

    def halved(self: AnyPosition) -> AnyPosition:
        """Return the position before a step of half the duration."""
        return replace(self, level=self.level + 1, done=2 * self.done, may_grow=False)

    def advanced(self: AnyPosition, error: float, tolerance: float) -> AnyPosition:
        """Return the position after a step, which may grow after a small error."""
        may_grow = error < _MAX_GROWTH_ERROR * tolerance
        return replace(self, done=self.done + 1, may_grow=may_grow)


def changes_of_schedule(
    old: Mapping[str, Any], new: Mapping[str, Any], count: int
) -> list[str]:
    """Return the differences of two specifications with a ``schedule``.

    Only the first parts of the schedules are compared, as a path may have been extended
    at its end.

    Parameters
    ----------
    old, new : mapping
        Specifications as a restart file has them.
    count : int
        Number of parts.
    """
    return differences(_begun(old, count), _begun(new, count))


def _begun(specification: Mapping[str, Any], count: int) -> dict[str, Any]:
    """Return a specification with the first parts of its schedule only."""
    schedule = specification["schedule"]
    parts = list(schedule["parts"])[:count]
    return {**specification, "schedule": {**schedule, "parts": parts}}
