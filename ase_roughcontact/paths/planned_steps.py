"""Expected windows, memory and time of the steps of a path, as a table."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from ase_roughcontact._util.printing import duration, entries, number, table
from ase_roughcontact._util.summary import Summarized
from ase_roughcontact.elasticity.halfspace import HalfSpace
from ase_roughcontact.interactions import Interaction
from ase_roughcontact.paths.kept_frames import number_of_frames
from ase_roughcontact.results.record import size_of

# Size of a number in a frame (bytes).
_FRAME_NUMBER_SIZE = 4
# Size of a number in a state (bytes).
_STATE_NUMBER_SIZE = 8
# Size of the description of a frame (bytes).
_DESCRIPTION_SIZE = 4_000
# Size of the columns of a step (bytes).
_COLUMNS_SIZE = 2_000
# Size of a frame for viewing (bytes).
_VIEW_SIZE = 120_000
# Largest number of steps that a plan lists; each one represents several of a longer
# path.
_MAX_LISTED = 500

# Time of a step by kind of wall, in units of an exact convolution on the full grid.
_CONVOLUTIONS = {"hard": 150, "soft": 180, "attractive": 320}
# Time of a step with hardly any atoms (s).
_MIN_SECONDS = 0.05
# Side of the largest grid on which convolutions are timed; for larger ones the time is
# extrapolated as n log(n).
_MAX_TIMED_SIDE = 1024


@dataclass(frozen=True)
class PlannedStep(Summarized):
    """Expected window and cost of a step.

    Attributes
    ----------
    target : float
        Load (eV/Å), penetration or height (Å).
    count : int
        Number of steps that it represents, including itself.
    window, grid : str
        Shapes of the window and of the FFT grid.
    memory : float
        Peak memory (bytes).
    seconds : float
        Time (s).
    problem : str
        Reason why the step can't be calculated; empty if it can.
    """

    target: float
    count: int = 1
    window: str = ""
    grid: str = ""
    memory: float = 0.0
    seconds: float = 0.0
    problem: str = ""


@dataclass(frozen=True)
class Plan(Summarized):
    """Expected cost of a path, and the approximations that it makes.

    Attributes
    ----------
    steps : tuple of PlannedStep
        Planned steps, at most 500.
    left_out : tuple of str
        Effects that are not calculated, each with its justification.
    available : float
        Free memory of the machine (bytes).
    advice : str
        Advice on steps that can't be calculated; empty if all can.
    domain : int
        Side of the domain of the roughness that is advised, in spacings of the grid;
        zero without advice.
    repeated_step : bool
        Whether one step represents all steps of a path, as their sizes are not known.
    keep : {"thinned", "all", "last"}
        Frames that the trajectory keeps.
    fields_of_frame, fields_of_state : int
        Numbers of an atom in a frame, and in the state of the restart file.
    """

    steps: tuple[PlannedStep, ...]
    left_out: tuple[str, ...]
    available: float
    advice: str = ""
    domain: int = 0
    repeated_step: bool = False
    keep: str = "thinned"
    fields_of_frame: int = 2
    fields_of_state: int = 4

    def repeated(self, count: int) -> Plan:
        """Return the plan of a path with `count` times as many steps of these sizes."""
        if count == 1:
            return self
        steps = tuple(replace(step, count=count * step.count) for step in self.steps)
        return replace(self, steps=steps, repeated_step=True)

    @property
    def count(self) -> int:
        """Number of steps that can be calculated."""
        return sum(step.count for step in self.steps if step.window)

    @property
    def frames(self) -> float:
        """Largest size of the frames, including the ones for viewing (bytes)."""
        if not self.count:
            return 0.0
        atoms = sum(s.count * size_of(s.window) for s in self.steps if s.window)
        size = _FRAME_NUMBER_SIZE * self.fields_of_frame * atoms / self.count
        size += _DESCRIPTION_SIZE + _VIEW_SIZE
        return number_of_frames(self.keep, self.count) * size

    @property
    def restart(self) -> float:
        """Size of the restart file (bytes)."""
        atoms = max((size_of(s.window) for s in self.steps if s.window), default=0)
        return (
            _STATE_NUMBER_SIZE * self.fields_of_state * atoms
            + _COLUMNS_SIZE * self.count
        )

    @property
    def memory(self) -> float:
        """Peak memory of all steps (bytes)."""
        return max(step.memory for step in self.steps)

    @property
    def seconds(self) -> float:
        """Time of all steps (s), within a factor of about three above 0.05 s a step."""
        return sum(step.count * step.seconds for step in self.steps)

    @property
    def fits(self) -> bool:
        """Whether the free memory suffices."""
        return self.memory < self.available

    @property
    def runs(self) -> bool:
        """Whether all steps can be calculated."""
        return self.fits and not any(step.problem for step in self.steps)

    def printed(self, heading: str, unit: float) -> list[Any]:
        """Return the plan as texts and a table.

        Parameters
        ----------
        heading : str
            Name and unit of the targets.
        unit : float
            Size of the unit of the targets, in ASE's units.

        Returns
        -------
        list
            Entries for `ase_roughcontact._util.printing.show`.
        """
        heads = [heading, "window", "grid", "memory (GB)", "time (s)"]
        rows = []
        for step in self.steps:
            memory, seconds = number(step.memory / 1e9, 2), number(step.seconds, 2)
            window = step.window or "CAN'T RUN"
            rows.append(
                [number(step.target / unit), window, step.grid, memory, seconds]
            )
        total = sum(step.count for step in self.steps)
        bad = sum(step.count for step in self.steps if step.problem)
        parts = [table(heads, rows), ""]
        if total > len(self.steps) and not self.repeated_step:
            parts += [f"These are {len(self.steps)} of {total} steps.", ""]
        if bad:
            reasons = dict.fromkeys(each.problem for each in self.steps if each.problem)
            parts += [f"{bad} of {total} steps can't run:", *reasons]
            parts += [f"To run all, {self.advice}.", ""] if self.advice else [""]
        if bad < total:
            parts += [self._costs("The other steps" if bad else "In all"), ""]
        left_out = [("-", reason) for reason in self.left_out]
        return [*parts, "Left out:", entries(left_out)]

    def _costs(self, steps: str) -> str:
        """Return a sentence on the costs of steps."""
        bound = "about" if self.repeated_step else "at most"
        enough = "" if self.fits else ": NOT ENOUGH"
        return (
            f"{steps} about {duration(max(self.seconds, 1.0))}, about "
            f"{_size(self.frames)} of frames (sweep.traj, view.traj), "
            f"{_size(self.restart)} to resume (sweep.restart.npz), and {bound} "
            f"{self.memory / 1e9:.2g} GB of the {self.available / 1e9:.2g} GB of "
            f"memory that are free{enough}."
        )


def _size(size: float) -> str:
    """Return a size of files as printed."""
    return f"{size / 1e9:.2g} GB" if size >= 1e8 else f"{size / 1e6:.2g} MB"


def thinned(
    targets: Sequence[float] | np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Return at most 500 targets of a path, and the numbers of steps they represent.

    Parameters
    ----------
    targets : sequence of float
        Targets of the whole path.

    Returns
    -------
    targets : ndarray of float
        Listed targets, including the first and the last one.
    counts : ndarray of int
        Number of steps that each of them represents.
    """
    number = len(targets)
    listed = np.linspace(0, number - 1, min(number, _MAX_LISTED)).round().astype(int)
    counts = np.diff(listed, prepend=-1)
    return np.asarray(targets, dtype=float)[listed], counts


def step_timer(
    halfspace: HalfSpace, wall: Interaction
) -> Callable[[tuple[int, int]], float]:
    """Return a function of the shape of an FFT grid: the time of a step on it (s)."""

    @cache
    def convolution(n: int, m: int) -> float:
        shape = (n, m) if halfspace.periodic else (n // 2, m // 2)
        timed = halfspace.resized(shape, halfspace.spacing)
        pressure, times = np.ones(shape), []
        for _ in range(3):
            start = time.perf_counter()
            timed.displacement(pressure)
            times.append(time.perf_counter() - start)
        return min(times)

    def seconds(grid: tuple[int, int]) -> float:
        points = math.prod(grid)
        scale = min(1.0, _MAX_TIMED_SIDE / math.sqrt(points))
        n, m = (max(8, int(side * scale)) for side in grid)
        ratio = points * math.log(points) / (n * m * math.log(n * m))
        return _MIN_SECONDS + _CONVOLUTIONS[wall.family] * ratio * convolution(n, m)

    return seconds
