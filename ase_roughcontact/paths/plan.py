"""What a path will take, before anything is calculated."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import timedelta

import numpy as np
from ase import Atoms

from ase_roughcontact.elasticity.halfspace import (
    FreeHalfSpace,
    HalfSpace,
    PeriodicHalfSpace,
)
from ase_roughcontact.interactions import Interaction
from ase_roughcontact.paths.record import text_of
from ase_roughcontact.paths.step import check_words
from ase_roughcontact.theory import hertz_contact_radius
from ase_roughcontact.windows.memory import available_memory, memory_of, points_of
from ase_roughcontact.windows.policy import AutoWindow

# Exact convolutions that take as long as a step. Measured from a cold start on windows
# of 400 to 1700 atoms along a side: 106 to 197 with a hard wall, 132 to 248 with a
# repulsive one; 218 to 463 along a path with a sticky one, on 100 to 700.
_PAIRS_HARD, _PAIRS_REPULSIVE, _PAIRS_ATTRACTIVE = 150, 180, 320
# Time of a step that has hardly any atoms (s).
_LEAST = 0.05
# Grids up to this many points are measured as they are, larger ones by n log n.
_MEASURED = 1024**2


@dataclass(frozen=True)
class PlannedStep:
    """What a step is expected to take.

    Attributes
    ----------
    target : float
        Load (eV/Å), penetration or height (Å).
    window, grid : str
        Shapes of the window and of the grid of its transforms.
    memory : float
        Bytes.
    seconds : float
        Time.
    problem : str
        Why the step can't be calculated; empty if it can.
    """

    target: float
    window: str = ""
    grid: str = ""
    memory: float = 0.0
    seconds: float = 0.0
    problem: str = ""


@dataclass(frozen=True)
class Plan:
    """What a path is expected to take, and what is left out.

    Attributes
    ----------
    steps : tuple of PlannedStep
    left_out : tuple of str
        What is not calculated, and why that is allowed.
    available : float
        Memory of the machine (bytes).
    """

    steps: tuple[PlannedStep, ...]
    left_out: tuple[str, ...]
    available: float

    @property
    def memory(self) -> float:
        """Most that a step takes (bytes)."""
        return max(step.memory for step in self.steps)

    @property
    def seconds(self) -> float:
        """Time of all steps, right within a factor of about three."""
        return sum(step.seconds for step in self.steps)

    @property
    def fits(self) -> bool:
        """Whether the memory of the machine suffices."""
        return self.memory < self.available

    @property
    def runs(self) -> bool:
        """Whether all steps can be calculated."""
        return self.fits and not any(step.problem for step in self.steps)

    def table(self, heading: str, unit: float) -> str:
        """Plan as text.

        Parameters
        ----------
        heading : str
            What the targets are.
        unit : float
            What they are divided by.

        Returns
        -------
        str
        """
        lines = [f"{heading:>15}      window        grid  memory (GB)  time (s)"]
        lines += [
            f"{step.target / unit:15.5g}{step.window:>12}{step.grid:>12}"
            f"{step.memory / 1e9:13.2f}{step.seconds:10.2g}"
            if not step.problem
            else f"{step.target / unit:15.5g}   CAN'T RUN: {self._told(i)}"
            for i, step in enumerate(self.steps)
        ]
        bad = [i for i, step in enumerate(self.steps) if step.problem]
        if bad:
            lines += [
                "",
                f"{len(bad)} of {len(self.steps)} steps can't run; a run stops at the "
                f"first of them, after {bad[0]}.",
            ]
        whole = timedelta(seconds=math.ceil(self.seconds))
        suffices = "" if self.fits else ": NOT ENOUGH"
        lines += [
            "",
            f"In all about {whole}, and at most {self.memory / 1e9:.2g} GB of the "
            f"{self.available / 1e9:.2g} GB that are free{suffices}.",
            "",
            "Left out:",
        ]
        return "\n".join([*lines, *(f"- {what}" for what in self.left_out)])

    def _told(self, i: int) -> str:
        """Return the problem of a step, in short if the step before had it too."""
        problem = self.steps[i].problem
        return "likewise" if i and self.steps[i - 1].problem == problem else problem


def plan_path(
    atoms: Atoms, control: str, targets: Sequence[float] | np.ndarray, window: str
) -> Plan:
    """Plan a path; see `load_path` for what it is.

    Parameters
    ----------
    atoms : Atoms
        With a `RoughContact` calculator. They stay as they are.
    control : {"penetrations", "heights", "loads"}
    targets : sequence of float
        The path.
    window : {"fixed", "auto"}

    Returns
    -------
    Plan
        Windows of loads are those under Hertz's contact: of a rough sphere they come
        out a little different. Steps that can't be calculated tell why: those at which
        the surface is not known where atoms could touch, and those whose contact, at
        least as wide as that of Hertz, is wider than a fixed free window.

    Raises
    ------
    ValueError
        If the control or the window is not one of these.
    """
    check_words(control, window)
    halfspace = atoms.calc.contact(atoms).halfspace
    wall = atoms.calc.contact(atoms).interaction
    points = points_of(atoms.calc.parameters["indenter"], halfspace.spacing)
    clock = _Clock(halfspace, wall)
    if window == "fixed" or halfspace.periodic:
        steps = _fixed(atoms, control, targets, clock, points)
    else:
        windows = AutoWindow(atoms)
        steps = [
            _auto(windows, control, float(target), clock, points) for target in targets
        ]
    left_out = _left_out(halfspace, wall, window)
    if window == "fixed" and not halfspace.periodic and _misses(atoms):
        left_out.append(
            "THE ATOM THAT IS TOUCHED FIRST: the indenter is lowest outside of the "
            f"window of {text_of(halfspace.shape)} atoms: give a larger shape"
        )
    return Plan(tuple(steps), tuple(left_out), available_memory())


def _fixed(
    atoms: Atoms,
    control: str,
    targets: Sequence[float] | np.ndarray,
    clock: _Clock,
    points: int,
) -> list[PlannedStep]:
    """Plan steps in the window of the atoms."""
    halfspace = atoms.calc.contact(atoms).halfspace
    margin = halfspace.dof_shape != halfspace.shape
    planned = PlannedStep(
        target=math.nan,
        window=text_of(halfspace.shape),
        grid=text_of(halfspace.grid),
        memory=memory_of(halfspace.shape, margin=margin, points=points),
        seconds=clock.step(halfspace.grid),
    )
    return [
        PlannedStep(float(target), problem=told)
        if (told := _too_wide(atoms, control, float(target)))
        else replace(planned, target=float(target))
        for target in targets
    ]


def _misses(atoms: Atoms) -> bool:
    """Whether a window leaves out the atom that the indenter touches first."""
    try:
        lowest = AutoWindow(atoms).footprint.lowest
    except ValueError:  # of an indenter that does not rise out of reach
        return False
    return bool(lowest < atoms.calc.contact(atoms).heights.min())


def _too_wide(atoms: Atoms, control: str, target: float) -> str:
    """Tell if a contact as wide as that of Hertz comes to the edge of a free window."""
    halfspace = atoms.calc.contact(atoms).halfspace
    width = _width(atoms, control, target)
    if halfspace.periodic or width <= min(halfspace.shape) - 1:
        return ""
    return (
        f"the contact is about {width:.0f} atoms wide, the window has "
        f"{text_of(halfspace.shape)}: give a larger shape"
    )


def _width(atoms: Atoms, control: str, target: float) -> float:
    """Width of the contact of the smooth sphere, in atoms; zero if there is none."""
    contact = atoms.calc.contact(atoms)
    halfspace, wall = contact.halfspace, contact.interaction
    radius = getattr(atoms.calc.parameters["indenter"], "radius", 0.0)
    if not 0.0 < radius < math.inf:
        return 0.0
    if control == "loads":
        modulus = halfspace.contact_modulus
        a = float(hertz_contact_radius(max(target, 0.0), radius, modulus))
    else:
        height = target if control == "heights" else contact.first_contact - target
        # of a rough sphere, that of its mean
        a = math.sqrt(radius * max(wall.contact_distance - height, 0.0))
    return 2.0 * a / halfspace.spacing


def _auto(
    windows: AutoWindow, control: str, target: float, clock: _Clock, points: int
) -> PlannedStep:
    """Plan a step in a window of its own."""
    try:
        window = windows.forecast(control, target)
    except ValueError as error:
        return PlannedStep(target, problem=str(error))
    padded = FreeHalfSpace.padded_shape(window.shape)
    memory, seconds = memory_of(window.shape, points=points), clock.step(padded)
    return PlannedStep(target, text_of(window.shape), text_of(padded), memory, seconds)


class _Clock:
    """Time of steps, from a short measurement of this machine's transforms."""

    def __init__(self, halfspace: HalfSpace, wall: Interaction) -> None:
        self._halfspace = halfspace
        self._pairs = _PAIRS_ATTRACTIVE if wall.attractive else _PAIRS_REPULSIVE
        if wall.hard:
            self._pairs = _PAIRS_HARD
        self._known: dict[tuple[int, int], float] = {}

    def step(self, grid: tuple[int, int]) -> float:
        """Time of a step on a grid (s)."""
        points = math.prod(grid)
        part = min(1.0, (_MEASURED / points) ** 0.5)
        measured = max(8, int(grid[0] * part)), max(8, int(grid[1] * part))
        if measured not in self._known:
            self._known[measured] = self._measure(measured)
        size = math.prod(measured)
        larger = points * math.log(points) / (size * math.log(size))
        return _LEAST + self._pairs * larger * self._known[measured]

    def _measure(self, grid: tuple[int, int]) -> float:
        """Time of a convolution (s)."""
        periodic = self._halfspace.periodic
        shape = grid if periodic else (grid[0] // 2, grid[1] // 2)
        trial = self._halfspace.resized(shape, self._halfspace.spacing)
        pressure, times = np.ones(shape), []
        for _ in range(3):
            start = time.perf_counter()
            trial.displacement(pressure)
            times.append(time.perf_counter() - start)
        return min(times)


def _left_out(halfspace: HalfSpace, wall: Interaction, window: str) -> list[str]:
    """Tell what is not calculated, and why that is allowed."""
    told = [
        "displacements along x and y: no friction drives them; that they do not couple "
        "to those along z is exact for a Poisson ratio of 1/2, taken for all solids",
    ]
    if isinstance(halfspace, PeriodicHalfSpace):
        return [*told, "nothing of the cell: it repeats along x and y"]
    told.append(
        "images of the contact: the half space is free, by exact convolution on a grid "
        "of twice the window"
    )
    if window == "fixed":
        told.append(
            "atoms outside of the window: a contact that comes to its edge is an error"
        )
    elif wall.attractive:
        told.append(
            "atoms that the wall does not reach: looked at after every step, and the "
            "window grown until none is missed, to more than is planned where "
            "attraction widens the contact"
        )
    else:
        told.append(
            "atoms that can't touch, since a wall that only pushes lifts none; a large "
            "window is made for the contact alone, and the others are looked at after "
            "the step"
        )
    if math.isfinite(wall.cutoff) and wall.cutoff > wall.contact_distance:
        told.append(
            f"the wall beyond a gap of {wall.cutoff:.4g} Å, where its energy is zero"
        )
    return told
