"""Loads, heights or penetrations as functions of time."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from ase_roughcontact._util.rounding import ROUNDING
from ase_roughcontact._util.validation import FloatArray, finite, integer, positive

# Number of times of a schedule at which results are shown.
_SAMPLES = 30
# Least number of these times in a part.
_MIN_SAMPLES_OF_PART = 3


class Part(NamedTuple):
    """Part of a schedule: linear in time, plus an oscillation.

    Attributes
    ----------
    duration : float
        Duration of the part; zero for a sudden change (time).
    end : float
        Target at its end, without the oscillation.
    amplitude, frequency : float
        Amplitude (unit of the target) and frequency (cycles per time) of the
        oscillation.
    """

    duration: float
    end: float
    amplitude: float = 0.0
    frequency: float = 0.0

    def target(self, start: float, part: float) -> float:
        """Return the target after a part of the duration, from the target at start."""
        if part == 1.0 and not self.amplitude:
            return self.end
        phase = 2.0 * math.pi * self.frequency * self.duration * part
        return start + part * (self.end - start) + self.amplitude * math.sin(phase)


@dataclass(frozen=True)
class Schedule:
    """Targets of a path as a function of time, part by part.

    Each method returns a longer schedule.

    Parameters
    ----------
    first : float
        Target at time zero: penetration or height (length), or load (force).
    parts : sequence of Part
        Parts of the schedule, one after the other.

    Raises
    ------
    ValueError
        If a number is not finite, a duration is negative, or a rate or frequency is not
        positive.

    Examples
    --------
    Approach to 20 Å at 5 Å/s, a dwell of 10 s, and retraction:

    >>> from ase_roughcontact import Schedule
    >>> path = Schedule(0.0).ramp(20.0, rate=5.0).hold(10.0).ramp(0.0, rate=5.0)
    >>> path.duration
    18.0
    >>> path.at(5.0)
    20.0
    """

    first: float
    parts: Sequence[Part] = ()

    def __post_init__(self) -> None:
        finite(first=self.first)
        parts = tuple(Part(*part) for part in self.parts)
        for part in parts:
            finite(duration=part.duration, end=part.end, amplitude=part.amplitude)
            if part.duration < 0.0:
                raise ValueError(f"duration must be at least 0, got {part.duration}")
        object.__setattr__(self, "parts", parts)

    @classmethod
    def through(cls, times: Sequence[float], targets: Sequence[float]) -> Schedule:
        """Return the schedule that is linear between given times.

        Parameters
        ----------
        times : sequence of float
            Times from zero on, not decreasing; two equal ones are a sudden change.
        targets : sequence of float
            Targets at these times.

        Raises
        ------
        ValueError
            If the sequences differ in length, or the times decrease.
        """
        times, targets = list(times), list(targets)
        if len(times) != len(targets) or not times or times[0] != 0.0:
            raise ValueError(
                "times must begin at 0 and be as many as the targets, got "
                f"{len(times)} times and {len(targets)} targets"
            )
        for before, after in pairwise(times):
            if after < before:
                raise ValueError(f"times must not decrease, got {after} after {before}")
        durations = [b - a for a, b in pairwise(times)]
        parts = [Part(*each) for each in zip(durations, targets[1:], strict=True)]
        return cls(targets[0], parts)

    @property
    def last(self) -> float:
        """Target at the end, without an oscillation."""
        return self.parts[-1].end if self.parts else self.first

    @property
    def duration(self) -> float:
        """Time from the beginning to the end."""
        return float(sum(part.duration for part in self.parts))

    def ramp(
        self, target: float, *, rate: float | None = None, time: float | None = None
    ) -> Schedule:
        """Return a schedule that goes on to a target, at a rate or within a time."""
        if (rate is None) == (time is None):
            raise ValueError("give either the rate of a ramp, or its time")
        if time is None:
            positive(rate=rate)
            time = abs(target - self.last) / float(rate or 1.0)
        return self._with(Part(time, target))

    def hold(self, time: float) -> Schedule:
        """Return a schedule that goes on at its last target for a time."""
        positive(time=time)
        return self._with(Part(time, self.last))

    def step(self, target: float) -> Schedule:
        """Return a schedule that changes its target at once."""
        return self._with(Part(0.0, target))

    def oscillate(
        self, amplitude: float, frequency: float, cycles: int = 3
    ) -> Schedule:
        """Return a schedule that goes on with ``amplitude sin(2 pi frequency t)``."""
        positive(amplitude=amplitude, frequency=frequency)
        integer("cycles", cycles, 1)
        return self._with(Part(cycles / frequency, self.last, amplitude, frequency))

    def at(self, time: float) -> float:
        """Return the target at a time; after a sudden change at that time."""
        target = self.first
        for begin, start, part in self.timed_parts():
            if time < begin + part.duration:
                return part.target(start, (time - begin) / part.duration)
            target = part.end
        return target

    def largest(self, sign: float = 1.0) -> tuple[float, float]:
        """Return the largest target, with its oscillation, and the time to get there.

        Parameters
        ----------
        sign : float
            1 for the largest target, -1 for the smallest one.
        """
        found, time = self.first, 0.0
        for begin, _, part in self.timed_parts():
            end = part.end + sign * abs(part.amplitude)
            if sign * end > sign * found:
                found, time = end, begin + part.duration
        return found, time

    def timed_parts(self) -> Iterator[tuple[float, float, Part]]:
        """Yield begin, target at the begin, and each part."""
        begin, start = 0.0, self.first
        for part in self.parts:
            yield begin, start, part
            begin, start = begin + part.duration, part.end

    def sample_times(self) -> FloatArray:
        """Return about thirty times, of which results are shown, even in each part."""
        parts = list(self.timed_parts())
        count = max(_SAMPLES // len(parts), _MIN_SAMPLES_OF_PART) + 1
        times = [np.linspace(t, t + part.duration, count) for t, _, part in parts]
        return np.unique(times)

    def sampled_steps(self, times: Sequence[float]) -> list[int]:
        """Return the numbers of the first steps that reach each of `sample_times`.

        Parameters
        ----------
        times : sequence of float
            Times at the ends of all steps.
        """
        reached = np.array(times) * (1.0 + ROUNDING)
        return np.unique(np.searchsorted(reached, self.sample_times())).tolist()

    def todict(self) -> dict[str, Any]:
        """Return the numbers that identify the schedule in files."""
        return {**asdict(self), "parts": [list(part) for part in self.parts]}

    def _with(self, part: Part) -> Schedule:
        return Schedule(self.first, (*self.parts, part))
