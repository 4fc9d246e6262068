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
from ase_roughcontact.results.record import shape_of, size_of, text_of
from ase_roughcontact.windows.memory import (
    DRAWING_BYTES,
    LIBRARY_BYTES,
    figure_memory,
    peak_memory,
)

# Size of a number of an atom in a frame, which is compressed (bytes).
_FRAME_NUMBER_SIZE = 1.3
# Size of the description of a frame (bytes).
_DESCRIPTION_SIZE = 3_000
# Size of a number in a state (bytes).
_STATE_NUMBER_SIZE = 8
# Size of the results of a step in all tables (bytes).
_COLUMNS_SIZE = 1_500
# Size of a frame for viewing, for each surface atom that it shows (bytes).
_VIEW_ATOM_SIZE = 98
# Size of the description of a frame for viewing (bytes).
_VIEW_DESCRIPTION_SIZE = 1_000
# Largest number of rows of atoms in a frame for viewing.
_VIEW_ROWS = 48
# Size of a figure (bytes).
_FIGURE_SIZE = 100_000
# Processor time of start and end of a run with figures, of a figure, of a frame for
# viewing, and of each atom in it, over the time of the start of the program.
_RUN_TIME, _FIGURE_TIME, _VIEW_TIME, _ATOM_TIME = 1.75, 0.22, 0.008, 2e-7
# Longest processor time of the start of a program (s).
_MAX_START_SECONDS = 5.0
# Factor between the ends of the range of the time that is printed, and the time: of a
# trial, and of the times of transforms alone.
_TRIAL_UNCERTAINTY, _UNCERTAINTY = 1.3, 3.0
# Largest number of steps that a plan lists; each one represents several of a longer
# path.
_MAX_LISTED = 500

#: Units of the totals of a plan.
TOTAL_UNITS = {
    "seconds": "s",
    "memory": "bytes",
    "files": "bytes",
    "available": "bytes",
}
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

    def resized(self, ratio: float) -> PlannedStep:
        """Return the step with the number of atoms multiplied by a ratio."""
        scale = math.sqrt(ratio)
        window, grid = (
            tuple(max(round(scale * side), 1) for side in shape_of(each))
            for each in (self.window, self.grid)
        )
        atoms = size_of(text_of(window)) / size_of(self.window)
        memory = LIBRARY_BYTES + atoms * (self.memory - LIBRARY_BYTES)
        return replace(self, window=text_of(window), grid=text_of(grid), memory=memory)


@dataclass(frozen=True)
class StartCosts:
    """Costs of a process before its first step.

    Attributes
    ----------
    program : float
        Processor time when the command began (s).
    libraries : float
        Memory when the command began (bytes).
    scene : float
        Processor time in which the scene was read and its solid was made (s).
    memory : float
        Peak memory until then (bytes).
    """

    program: float = 0.0
    libraries: float = 0.0
    scene: float = 0.0
    memory: float = 0.0

    @classmethod
    def now(cls) -> StartCosts:
        """Return the costs of a process in which a command begins."""
        return cls(time.process_time(), peak_memory())

    def with_scene(self) -> StartCosts:
        """Return the costs when the scene was read and its solid was made."""
        seconds = time.process_time() - self.program
        return replace(self, scene=seconds, memory=peak_memory())

    @property
    def program_seconds(self) -> float:
        """Processor time of the start (s), without what else a process has done."""
        return min(self.program, _MAX_START_SECONDS)


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
        Numbers of an atom in a frame, and in the restart file for the last state, which
        has the pressure of the state before in addition.
    run_steps : tuple of PlannedStep
        Steps of the run, as a trial shows them; empty without one.
    basis : str
        What the numbers of these steps follow from.
    at_least : bool
        Whether the trial ended before the path, and all numbers are lower bounds.
    start : StartCosts
        Costs of the process before its first step.
    figures, views : int
        Number of figures, and the largest number of frames for viewing; zero for all.
    inputs : int
        Size of the scene's files, which are copied beside the results (bytes).
    """

    steps: tuple[PlannedStep, ...]
    left_out: tuple[str, ...]
    available: float
    advice: str = ""
    domain: int = 0
    repeated_step: bool = False
    keep: str = "thinned"
    fields_of_frame: int = 2
    fields_of_state: int = 3
    run_steps: tuple[PlannedStep, ...] = ()
    basis: str = ""
    at_least: bool = False
    start: StartCosts = StartCosts()
    figures: int = 0
    views: int = 0
    inputs: int = 0

    def repeated(self, count: int) -> Plan:
        """Return the plan of a path with `count` times as many steps of these sizes."""
        if count == 1:
            return self
        steps = tuple(replace(step, count=count * step.count) for step in self.steps)
        return replace(self, steps=steps, repeated_step=True)

    @property
    def all_steps(self) -> tuple[PlannedStep, ...]:
        """Steps of the run by the trial, or else planned steps with a window."""
        return self.run_steps or tuple(step for step in self.steps if step.window)

    @property
    def count(self) -> int:
        """Number of steps that can be calculated."""
        return sum(step.count for step in self.all_steps)

    @property
    def frames(self) -> float:
        """Size of the frames, including frames for viewing (bytes)."""
        if not self.count:
            return 0.0
        views = 0.0
        for step in self.all_steps:
            side = math.sqrt(size_of(step.window))
            rows = side / math.ceil(side / _VIEW_ROWS)
            views += step.count * rows**2
        size = _FRAME_NUMBER_SIZE * self.fields_of_frame * self._mean_atoms
        view = _VIEW_DESCRIPTION_SIZE + _VIEW_ATOM_SIZE * views / self.count
        frames = number_of_frames(self.keep, self.count)
        return frames * (_DESCRIPTION_SIZE + size) + self._number_of_views * view

    @property
    def _mean_atoms(self) -> float:
        """Mean number of atoms of a step."""
        atoms = sum(step.count * size_of(step.window) for step in self.all_steps)
        return atoms / max(self.count, 1)

    @property
    def _number_of_views(self) -> int:
        """Number of frames for viewing."""
        frames = number_of_frames(self.keep, self.count)
        return min(frames, self.views) if self.views else frames

    @property
    def restart(self) -> float:
        """Size of the restart file and of tables (bytes)."""
        if not self.count:
            return 0.0
        last = self.all_steps[-1]
        before = last if last.count > 1 else self.all_steps[-2:][0]
        numbers = size_of(before.window) + self.fields_of_state * size_of(last.window)
        return _STATE_NUMBER_SIZE * numbers + _COLUMNS_SIZE * self.count

    @property
    def files(self) -> float:
        """Size of all files of the run (bytes)."""
        results = self.frames + self.restart + _FIGURE_SIZE * self.figures
        return results + self.inputs

    @property
    def memory(self) -> float:
        """Peak memory of the process: of its start, a step, or figures (bytes)."""
        steps = self.run_steps or self.steps
        peak = max(step.memory for step in steps)
        if self.figures and self.count:
            largest = max(size_of(step.window) for step in self.all_steps)
            peak = max(peak, figure_memory(largest))
        if self.start.libraries:  # what is assumed for them
            peak += self.start.libraries + DRAWING_BYTES - LIBRARY_BYTES
        return max(peak, self.start.memory)

    @property
    def seconds(self) -> float:
        """Processor time of all steps, the start and the figures (s)."""
        relative = _RUN_TIME + _FIGURE_TIME * self.figures
        view = _VIEW_TIME + _ATOM_TIME * self._mean_atoms
        relative += view * self._number_of_views
        return (
            self.start.scene + relative * self.start.program_seconds + self.step_seconds
        )

    @property
    def step_seconds(self) -> float:
        """Processor time of all steps (s)."""
        steps = self.run_steps or self.steps
        return sum(step.count * step.seconds for step in steps)

    @property
    def uncertainty(self) -> float:
        """Factor by which the time may be larger or smaller."""
        return _TRIAL_UNCERTAINTY if self.run_steps else _UNCERTAINTY

    @property
    def fits(self) -> bool:
        """Whether the free memory suffices."""
        return self.memory < self.available

    @property
    def runs(self) -> bool:
        """Whether all steps can be calculated."""
        return self.fits and not any(step.problem for step in self.steps)

    @property
    def totals(self) -> dict[str, Any]:
        """Numbers of the whole run, with the units of `TOTAL_UNITS`."""
        return {
            "steps": self.count,
            "seconds": self.seconds,
            "memory": self.memory,
            "files": self.files,
            "available": self.available,
            "at_least": self.at_least,
            "basis": self.basis,
        }

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

    def printed_time(self, seconds: float) -> str:
        """Return a range of the time, or its lower bound, as printed."""
        if self.at_least:
            return f"at least {duration(max(seconds, 1.0))}"
        factor = self.uncertainty
        shortest, longest = (
            duration(max(each, 1.0)) for each in (seconds / factor, seconds * factor)
        )
        return f"about {shortest} to {longest}"

    def _costs(self, steps: str) -> str:
        """Return a sentence on the costs of steps."""
        enough = "" if self.fits else ": NOT ENOUGH"
        return (
            f"{steps} {self.printed_time(self.seconds)} of processor "
            f"time for {self.count} steps, {_size(self.files)} of files, of which "
            f"{_size(self.frames)} are frames (sweep.traj, view.traj), and "
            f"{self.memory / 1e9:.2g} GB of the {self.available / 1e9:.2g} GB of "
            f"memory that are free{enough}; by {self.basis or 'times of transforms'}."
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


def pair_timer(halfspace: HalfSpace) -> Callable[[tuple[int, int]], float]:
    """Return a function of the shape of an FFT grid: the time of a pair on it (s).

    It is processor time, of an exact convolution; for large grids it is extrapolated.
    """

    @cache
    def convolution(n: int, m: int) -> float:
        shape = (n, m) if halfspace.periodic else (n // 2, m // 2)
        timed = halfspace.resized(shape, halfspace.spacing)
        pressure, times = np.ones(shape), []
        for _ in range(3):
            start = time.process_time()
            timed.displacement(pressure)
            times.append(time.process_time() - start)
        return min(times)

    def seconds(grid: tuple[int, int]) -> float:
        points = math.prod(grid)
        scale = min(1.0, _MAX_TIMED_SIDE / math.sqrt(points))
        n, m = (max(8, int(side * scale)) for side in grid)
        ratio = points * math.log(points) / (n * m * math.log(n * m))
        return ratio * convolution(n, m)

    return seconds


def step_timer(
    halfspace: HalfSpace, wall: Interaction
) -> Callable[[tuple[int, int]], float]:
    """Return a function of the shape of an FFT grid: the time of a step on it (s)."""
    pair = pair_timer(halfspace)

    def seconds(grid: tuple[int, int]) -> float:
        return _MIN_SECONDS + _CONVOLUTIONS[wall.family] * pair(grid)

    return seconds
