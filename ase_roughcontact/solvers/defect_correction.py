r"""The contact problem of a hard wall on one grid.

*Defect correction.* One exact convolution gives the exact gap. Then :math:`G` is
replaced by a cheap model on a box of the atoms that may touch, and the contact problem
of this model is solved for the correction of the pressure (see `activeset`). The
model's gradient is exact at the present pressure, hence its minimum lies in a direction
of descent: a step that overshoots is cut to the least energy
:math:`p \cdot G p/2 + (Z + h) \cdot p` along it, which so never rises. Where the model
is not good enough, the last moves are combined to the least energy among them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ase_roughcontact._util.kernels import by_rows, combined, dot, dots
from ase_roughcontact.contact import Contact
from ase_roughcontact.elasticity.circulant import CirculantModel
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.solvers.active_set import ActiveSetSolver
from ase_roughcontact.solvers.relaxation import precision_advice

# Part of a violation that the model's solution may leave.
_CONTRACTION = 0.1
# The same of a model that is exact, in roundings of its numbers: to less, all of a
# budget was spent on a small periodic cell (604 pairs instead of 56).
_ROUNDINGS = 1000.0
# Moves before the last that are combined with it, where a violation stays above this
# part of the one before: large contacts that fill their window (a contact of 1500 atoms
# across took 82 pairs instead of 127).
_MEMORY = 2
_SLOW = 0.3
# Steps without progress.
_PATIENCE = 10


@dataclass(frozen=True)
class Step:
    """Where the solver has come to.

    Attributes
    ----------
    pressure : ndarray, shape (n, m)
        Nowhere negative (pressure).
    displacement : ndarray, shape (n, m), or None
        ``-G pressure`` (length), if it is known.
    height : float
        Of the indenter (length).
    elastic_energy : float
        Of the half space.
    violation : float
        Largest gap in contact or overlap outside of it (length).
    converged : bool
        Whether the violation is small enough.
    message : str
        Why there is no way on.
    work : float
        Number of grid points transformed (forth and back) since the last step.
    """

    pressure: np.ndarray
    displacement: np.ndarray | None
    height: float
    elastic_energy: float
    violation: float
    converged: bool
    message: str
    work: float


@dataclass(frozen=True)
class Move:
    """Change of the pressure, and of the depth that goes with it."""

    step: np.ndarray
    deepening: np.ndarray


def descend(
    contact: Contact,
    height: float,
    load: float | None,
    start: np.ndarray | None,
    tolerance: float,
) -> Iterator[Step]:
    """Solve the contact problem on the grid as it is.

    Parameters
    ----------
    contact : Contact
        Its wall is taken for hard.
    height : float
        Of the indenter (length); ignored if there is a load.
    load : float, optional
        Positive (force).
    start : ndarray, shape (n, m), optional
        Pressure to start from, nowhere negative.
    tolerance : float
        Largest violation that is left (length).

    Yields
    ------
    Step
        The start, and one for each outer step. The last one is converged, or has a
        message.
    """
    descent = _Descent(contact, height, load, start, tolerance)
    while True:
        step = descent.look()
        yield step
        if step.converged or step.message:
            return
        descent.advance()


class _Descent:
    """Where the solver is, and what it remembers of the way."""

    def __init__(
        self,
        contact: Contact,
        height: float,
        load: float | None,
        start: np.ndarray | None,
        tolerance: float,
    ) -> None:
        self.contact, self.halfspace, self.work = contact, contact.halfspace, 0.0
        self.height, self.load, self.tolerance = height, load, tolerance
        self.pressure = _first(contact, load, start)
        self.displacement = self._displaced(self.pressure)
        if load is None:
            undeformed = contact.heights + height
            share = _share(self.pressure, self.displacement, undeformed)
            self.pressure = combined([(share, self.pressure)])
            self.displacement = combined([(share, self.displacement)])
        self.model: CirculantModel | None = None
        self.violations: list[float] = []
        self.moves: list[Move] = []
        self.part = 1.0

    def look(self) -> Step:
        """Return the present step, and remember its gap."""
        self.gap, self.height = _gap(
            self.contact, self.pressure, self.displacement, self.height, self.load
        )
        violation = _violation(self.pressure, self.gap)
        self.violations.append(violation)
        converged = violation <= self.tolerance
        obstacle = _obstacle(self.violations, self.part, self.tolerance)
        message = obstacle and obstacle + precision_advice(self.halfspace)
        work = dot(self.pressure, self.displacement)
        return Step(
            pressure=self.pressure,
            displacement=self.displacement,
            height=self.height,
            elastic_energy=-0.5 * self.halfspace.cell_area * work,
            violation=violation,
            converged=converged,
            message="" if converged else message,
            work=self.work,
        )

    def advance(self) -> None:
        """Correct the pressure by the model, as far as the energy falls."""
        violation = self.violations[-1]
        trial = self._corrected(violation)
        sunk = self._displaced(trial)
        move = Move(
            combined([(1.0, trial), (-1.0, self.pressure)]),
            combined([(1.0, self.displacement), (-1.0, sunk)]),
        )
        self.moves = [move, *self.moves[:_MEMORY]]
        if len(self.violations) > 1 and violation > _SLOW * self.violations[-2]:
            loaded = self.load is not None
            self.pressure = _combined(self.pressure, self.gap, self.moves, loaded)
            self.displacement, self.part = self._displaced(self.pressure), 1.0
            return
        self.part = _part(self.pressure, trial, self.gap, move)
        if self.part == 1.0:
            self.pressure, self.displacement = trial, sunk
            return
        self.pressure = combined([(1.0, self.pressure), (self.part, move.step)])
        deepened = [(1.0, self.displacement), (-self.part, move.deepening)]
        self.displacement = combined(deepened)

    def _corrected(self, violation: float) -> np.ndarray:
        """Pressure of less violation by the model."""
        model = self._covering(violation)
        before = model.transforms
        # to an exact model there is no need to come back, but for its rounding
        rounding = _ROUNDINGS * float(np.finfo(model.dtype).eps)
        contraction = rounding if model.exact else _CONTRACTION
        target = max(0.3 * self.tolerance / violation, contraction)
        loaded = self.load is not None
        correction = ActiveSetSolver(model, self.pressure, self.gap, violation, loaded)
        trial = correction.solve(target)
        self.work = model.points * (model.transforms - before)
        return trial

    def _covering(self, violation: float) -> CirculantModel:
        """Model whose box holds all atoms that may touch, the last one if it does."""
        if self.model is None or _overlaps_beyond(self.model.box, self.gap):
            near = (self.pressure > 0.0) | (self.gap < violation)
            box = Box.bounding(near, (0, 0)) or Box((0, 0), near.shape)
            box = box.union(self.model.box if self.model else None)
            self.model = CirculantModel(self.halfspace, box)
        return self.model

    def _displaced(self, pressure: np.ndarray) -> np.ndarray:
        self.work += math.prod(self.halfspace.grid)
        return self.halfspace.displacement(pressure)


def _overlaps_beyond(box: Box, gap: np.ndarray) -> bool:
    """Whether there are atoms outside of a box that overlap."""
    overlap = gap < 0.0
    overlap[box.slices] = False
    return bool(overlap.any())


def _first(
    contact: Contact, load: float | None, start: np.ndarray | None
) -> np.ndarray:
    """Pressure to start from, which carries the load."""
    if load is None:
        return np.zeros(contact.heights.shape) if start is None else start
    halfspace = contact.halfspace
    total = load / halfspace.cell_area
    if start is None or not start.any():
        start = _springs(contact.heights, total, 1.0 / halfspace.self_compliance)
    return start * (total / start.sum())


def _share(
    pressure: np.ndarray, displacement: np.ndarray, undeformed: np.ndarray
) -> float:
    """Part of a start to take: less than all if it is much too large for a gap."""
    stored, done = -dot(pressure, displacement), -dot(pressure, undeformed)
    if done >= 0.5 * stored:
        return 1.0
    return done / stored if done > 0.0 else 0.0


def _springs(heights: np.ndarray, total: float, stiffness: float) -> np.ndarray:
    """Pressures of springs without neighbours which add up to a total."""
    above = heights - heights.min()
    h = np.sort(above, axis=None)
    carried = stiffness * (np.arange(1, h.size) * h[1:] - np.cumsum(h[:-1]))
    count = int(np.searchsorted(carried, total)) + 1
    level = (total / stiffness + h[:count].sum()) / count
    return stiffness * np.maximum(level - above, 0.0)


def _gap(
    contact: Contact,
    pressure: np.ndarray,
    displacement: np.ndarray,
    height: float,
    load: float | None,
) -> tuple[np.ndarray, float]:
    """Gap and height; under a load the one at which the gaps in contact balance."""
    gap = combined([(1.0, contact.heights), (-1.0, displacement)])

    def ends(rows: slice) -> tuple[float, float]:
        touching = gap[rows][pressure[rows] > 0.0]
        return (
            float(touching.min(initial=math.inf)),
            float(touching.max(initial=-math.inf)),
        )

    def lift(rows: slice) -> None:
        gap[rows] += height

    if load is not None:
        lowest, highest = zip(*by_rows(ends, gap.shape), strict=True)
        height = -(min(lowest) + max(highest)) / 2.0
    by_rows(lift, gap.shape)
    return gap, height


def _violation(pressure: np.ndarray, gap: np.ndarray) -> float:
    """Largest gap in contact, or overlap anywhere."""

    def ends(rows: slice) -> tuple[float, float]:
        part = gap[rows]
        touching = part.max(where=pressure[rows] > 0.0, initial=0.0)
        return float(touching), -float(part.min())

    return float(np.max(by_rows(ends, gap.shape)))


def _obstacle(violations: list[float], part: float, tolerance: float) -> str:
    """Why there is no way on, or nothing."""
    if not math.isfinite(violations[-1]):
        return "the gap is not finite"
    reached = f"a gap of {violations[-1]:.3g} is left, not {tolerance:.3g}"
    if part == 0.0:
        return f"rounding: the energy can't be lowered, {reached}"
    late, early = violations[-_PATIENCE:], violations[:-_PATIENCE]
    if early and min(late) >= min(early):
        return f"no progress in {_PATIENCE} steps: {reached}"
    return ""


def _part(old: np.ndarray, new: np.ndarray, gap: np.ndarray, move: Move) -> float:
    """Part of the way from the old to the new pressure to go: the least energy.

    The whole way, if that lowers the energy and the set in contact changes: else the
    atoms that leave would keep a part of their pressure for ever.
    """
    slope = dot(move.step, gap)
    curvature = dot(move.step, move.deepening)
    if slope >= 0.0:
        return 0.0
    if curvature <= 0.0:  # the mean of a periodic surface moves at no cost
        return 1.0
    part = -slope / curvature
    if part < 0.5:
        return part

    def stays(rows: slice) -> bool:
        """Whether the same atoms touch, and stay under pressure on the way."""
        before = old[rows]
        if ((new[rows] > 0.0) != (before > 0.0)).any():
            return False
        return bool((before + part * move.step[rows]).min() >= 0.0)

    return part if all(by_rows(stays, old.shape)) else 1.0


def _combined(
    pressure: np.ndarray, gap: np.ndarray, moves: list[Move], loaded: bool
) -> np.ndarray:
    """Pressure of the least energy among moves, the last one and those before.

    Together they make up for the long waves that the model misses.
    """
    slopes = dots([(move.step, gap) for move in moves])
    pairs = [(one.step, other.deepening) for one in moves for other in moves]
    hessian = dots(pairs).reshape(len(moves), len(moves))
    weights, *_ = np.linalg.lstsq(hessian, -slopes, rcond=1e-8)
    terms = zip(weights.tolist(), (move.step for move in moves), strict=True)
    new = combined([(1.0, pressure), *terms])

    def clip(rows: slice) -> None:
        part = new[rows]
        part *= (part > 0.0) & (pressure[rows] + moves[0].step[rows] > 0.0)

    by_rows(clip, new.shape)
    if loaded:
        new *= pressure.sum() / new.sum()
    return new
