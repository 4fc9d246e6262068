r"""Defect correction for the contact with a hard wall on one grid.

The energy :math:`E(p) = \tfrac12 p \cdot G p + (Z + h) \cdot p` is minimised over
pressures :math:`p \ge 0`, at a height :math:`Z` or under a load :math:`a_0^2 \sum p`.

1. Calculate the gap :math:`g = Z + h + G p` by a convolution. Under a load, :math:`Z`
   makes the smallest and the largest gap in contact opposite. Stop if the violation,
   the largest gap in contact or overlap, is below the tolerance, and the load carried.
2. Solve the contact problem that has the model :math:`C` in place of :math:`G` for the
   correction :math:`x` of the pressure, to 7 % of the violation; see `active_set`.
   The gradient of the model is exact at :math:`p`, so that :math:`E` falls along
   :math:`x`.
3. Calculate :math:`G x` by a convolution, and shorten :math:`x` to the least energy
   along it if it is too long by a factor of two or does not change the set in contact.
4. If the violation had not decreased to 15 % in the step before, minimise the energy
   over the span of this correction and the last one instead, which makes up for the
   errors of the model in the longest waves.

With a hardness :math:`H` the pressures are bounded by it, too, and atoms at this bound
may overlap; see `bounded_set`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ase_roughcontact._util.kernels import (
    dot,
    dots,
    linear_combination,
    rowwise,
    scale,
    total,
)
from ase_roughcontact.contact import Contact
from ase_roughcontact.elasticity.circulant import CirculantModel, covering_model
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.solvers.active_set import ComplementarityProblem
from ase_roughcontact.solvers.bounded_set import BoundedProblem
from ase_roughcontact.solvers.bounds import with_sum
from ase_roughcontact.solvers.dense import DenseContact
from ase_roughcontact.solvers.options import ActiveSetOptions
from ase_roughcontact.solvers.relaxation import precision_advice
from ase_roughcontact.solvers.starting_pressure import initial_pressure, start_factor

# Rounding error of a sum of pressures, relative to it.
_ROUNDING = 1e-14


@dataclass(frozen=True)
class HardWallState:
    """State of the defect correction.

    Attributes
    ----------
    pressure : ndarray, shape (n, m)
        Nonnegative pressure on the window.
    height : float
        Height of the indenter (length).
    energy : float
        Energy of the half space, and work of the plastic flow.
    violation : float
        Largest gap in contact or overlap, or the gap of an atom whose force is the
        difference of normal force and load (length).
    converged : bool
        Whether the violation is below the tolerance.
    message : str
        Why there is no further step; empty while there is one.
    work : float
        Grid points transformed, forward and back, since the last state.
    """

    pressure: np.ndarray
    height: float
    energy: float
    violation: float
    converged: bool
    message: str
    work: float


@dataclass(frozen=True)
class Correction:
    """Change ``x`` of the pressure, and the opening ``G x`` of the gap."""

    pressure: np.ndarray
    opening: np.ndarray


def defect_correction(
    contact: Contact,
    height: float,
    load: float | None,
    start: np.ndarray | None,
    tolerance: float,
    options: ActiveSetOptions,
) -> Iterator[HardWallState]:
    """Solve the contact problem of a hard wall on one grid.

    Parameters
    ----------
    contact : Contact
        The wall counts as hard.
    height : float
        Height of the indenter (length); ignored if there is a load.
    load : float, optional
        Positive load (force).
    start : ndarray, shape (n, m), optional
        Nonnegative initial pressure.
    tolerance : float
        Largest violation that may be left (length).
    options : ActiveSetOptions

    Yields
    ------
    HardWallState
        The start, and the state after each step. The last one is converged, or has a
        message.
    """
    solver = _DefectCorrection(contact, height, load, start, tolerance, options)
    while True:
        state = solver.evaluate()
        yield state
        if state.converged or state.message:
            return
        solver.correct()


class _DefectCorrection:
    """Pressure and opening, and the corrections so far."""

    def __init__(
        self,
        contact: Contact,
        height: float,
        load: float | None,
        start: np.ndarray | None,
        tolerance: float,
        options: ActiveSetOptions,
    ) -> None:
        self._contact, self._halfspace = contact, contact.halfspace
        self._height, self._tolerance = height, tolerance
        self._options = options
        self._work = 0.0
        self._hardness = contact.interaction.hardness
        self._pressure = initial_pressure(contact, load, start)
        self._opening = self._opened(self._pressure)
        if load is None:
            undeformed = contact.heights + height
            factor = start_factor(self._pressure, self._opening, undeformed)
            self._pressure = factor * self._pressure
            self._opening *= factor
        small = math.prod(contact.halfspace.shape) <= options.exact_size
        dense_atoms = options.dense_atoms // (3 if start is None else 1)
        self._most_dense = dense_atoms if small and self._hardness == math.inf else 0
        self._dense = DenseContact(contact, self._most_dense)
        self._total = None if load is None else load / self._halfspace.cell_area
        self._model: CirculantModel | None = None
        self._violations: list[float] = []
        self._corrections: list[Correction] = []  # the last two
        self._length = 1.0

    def evaluate(self) -> HardWallState:
        """Calculate the gap; return the present state."""
        gap = linear_combination([(1.0, self._contact.heights), (1.0, self._opening)])
        highest, minus_lowest, overlap = _extremes(gap, self._pressure, self._hardness)
        if self._total is not None:
            if minus_lowest == -math.inf:  # all atoms are in plastic contact
                minus_lowest = -highest
            self._height = (minus_lowest - highest) / 2.0
        gap += self._height
        self._gap = gap
        # the maximum of NumPy returns NaN if there is one
        gaps = highest + self._height, overlap - self._height
        violation = float(np.max([0.0, *gaps, self._load_violation()]))
        self._violations.append(violation)
        converged = violation <= self._tolerance
        work, self._work = self._work, 0.0
        energy = 0.5 * dot(self._pressure, self._opening)
        if self._hardness < math.inf:
            energy += self._hardness * _flow(gap, self._pressure, self._hardness)
        return HardWallState(
            pressure=self._pressure,
            height=self._height,
            energy=self._halfspace.cell_area * energy,
            violation=violation,
            converged=converged,
            message="" if converged else self._obstacle(),
            work=work,
        )

    def correct(self) -> None:
        """Correct the pressure by the model, so that the energy falls."""
        trial = self._dense_solution()
        if trial is None:
            trial = self._solve_model(self._violations[-1])
        opening = self._opened(trial)
        correction = Correction(
            linear_combination([(1.0, trial), (-1.0, self._pressure)]),
            linear_combination([(1.0, opening), (-1.0, self._opening)]),
        )
        self._corrections = [correction, *self._corrections[:1]]
        if self._is_slow:
            self._length, self._pressure = 1.0, self._combined(trial)
            self._opening = self._opened(self._pressure)
            return
        self._length = _step_length(
            self._pressure, trial, self._gap, correction, self._hardness
        )
        if self._length == 1.0:  # without the rounding errors of a sum
            self._pressure, self._opening = trial, opening
            return
        self._pressure = linear_combination(
            [(1.0, self._pressure), (self._length, correction.pressure)]
        )
        self._opening = linear_combination(
            [(1.0, self._opening), (self._length, correction.opening)]
        )

    def _load_violation(self) -> float:
        """Return the gap of an atom whose force is what the load lacks."""
        if self._total is None:
            return 0.0
        missing = abs(self._total - total(self._pressure)) - _ROUNDING * self._total
        return self._halfspace.self_compliance * max(missing, 0.0)

    @property
    def _is_slow(self) -> bool:
        """Whether the last correction has left too much of the violation."""
        if len(self._violations) < 2:
            return False
        before, now = self._violations[-2:]
        return now > self._options.slow_contraction * before

    def _obstacle(self) -> str:
        """Return why there is no further step; empty if there is one."""
        violation, patience = self._violations[-1], self._options.patience
        if not math.isfinite(violation):
            return "the gap is not finite"
        late, early = self._violations[-patience:], self._violations[:-patience]
        if self._length == 0.0:
            reason = "rounding errors hide any further decrease of the energy"
        elif early and min(late) >= min(early):
            reason = f"no progress in {patience} steps"
        else:
            return ""
        reached = f"the violation is {violation:.3g}, not {self._tolerance:.3g}"
        return f"{reason}: {reached}{precision_advice(self._halfspace)}"

    def _dense_solution(self) -> np.ndarray | None:
        """Return the pressure found by dense matrices; None if they do not find it."""
        if not 0 < np.count_nonzero(self._pressure) <= self._most_dense:
            return None
        halfspace, required = self._halfspace, self._total
        before = halfspace.pairs
        found = self._dense.solve(
            self._pressure,
            self._opening,
            self._height,
            None if required is None else lambda height: (0.0, required),
            0.3 * self._tolerance / halfspace.self_compliance,
        )
        self._work += math.prod(halfspace.grid) * (halfspace.pairs - before)
        if not found.converged:
            return None
        trial = np.maximum(found.pressure, 0.0)
        return trial if required is None else trial * (required / trial.sum())

    def _solve_model(self, violation: float) -> np.ndarray:
        """Return the pressure that the model finds."""
        model = self._covering_model(violation)
        before = model.work
        contraction = self._options.contraction
        if model.exact:  # only rounding errors make another step necessary
            rounding = float(np.finfo(model.dtype).eps)
            contraction = self._options.exact_contraction * rounding
        target = max(0.3 * self._tolerance / violation, contraction)
        parameters = (
            model,
            self._pressure,
            self._gap,
            violation,
            self._total,
            self._options,
        )
        problem = ComplementarityProblem(*parameters)
        if self._hardness < math.inf:
            problem = BoundedProblem(*parameters, self._hardness)
        trial = problem.solve(target)
        self._work += model.work - before
        return trial

    def _covering_model(self, violation: float) -> CirculantModel:
        """Return a model of all atoms that may touch, the last one if it suffices."""
        if self._model is None or _overlaps_outside(self._model.box, self._gap):
            near = (self._pressure > 0.0) | (self._gap < violation)
            box = Box.bounding(near) or Box((0, 0), near.shape)
            box = box.union(self._model.box if self._model else None)
            exact = self._needs_exact_model()
            self._model = covering_model(self._halfspace, box, exact=exact)
        return self._model

    def _needs_exact_model(self) -> bool:
        """Return whether an exact model pays: on small windows and for many atoms.

        Where much of the window is in elastic contact, the errors of a circulant model
        in the longest waves would slow down the convergence.
        """
        size, options = self._pressure.size, self._options
        if size <= options.exact_size:
            return True
        in_contact = np.count_nonzero(self._pressure)
        elastic = self._hardness == math.inf
        return elastic and bool(in_contact >= options.exact_contact * size)

    def _opened(self, pressure: np.ndarray) -> np.ndarray:
        """Return ``G p``, and count its transforms."""
        self._work += math.prod(self._halfspace.grid)
        displacement = self._halfspace.displacement(pressure)
        scale(displacement, displacement, -1.0)
        return displacement

    def _combined(self, trial: np.ndarray) -> np.ndarray:
        """Return the pressure of the least energy in the span of the corrections."""
        corrections = self._corrections
        slopes = dots([(x.pressure, self._gap) for x in corrections])
        pairs = [(x.pressure, y.opening) for x in corrections for y in corrections]
        hessian = np.reshape(dots(pairs), (len(corrections), len(corrections)))
        weights, *_ = np.linalg.lstsq(hessian, -np.array(slopes), rcond=1e-8)
        terms = [(w, x.pressure) for w, x in zip(weights, corrections, strict=True)]
        new = linear_combination([(1.0, self._pressure), *terms])
        _clip(new, trial, self._hardness)
        if self._total is None:
            return new
        if self._hardness == math.inf:
            return new * (self._total / new.sum())
        push = self._gap / -self._halfspace.self_compliance
        return with_sum(new, self._total, self._hardness, push)


def _overlaps_outside(box: Box, gap: np.ndarray) -> bool:
    """Return whether atoms outside of a box overlap with the indenter."""
    overlap = gap < 0.0
    overlap[box.slices] = False
    return bool(overlap.any())


def _step_length(
    old: np.ndarray,
    new: np.ndarray,
    gap: np.ndarray,
    correction: Correction,
    hardness: float,
) -> float:
    """Return the length of a step along a correction.

    That of the least energy; one, if this lowers the energy and the set in contact
    changes: otherwise atoms that leave would keep a part of their pressure forever.
    """
    slope = dot(correction.pressure, gap)
    curvature = dot(correction.pressure, correction.opening)
    if slope >= 0.0:
        return 0.0
    if curvature <= 0.0:  # a shift of the mean of a periodic surface
        return 1.0
    length = -slope / curvature
    if length < 0.5 or _same_contact(old, new, length, correction.pressure, hardness):
        return length
    return 1.0


@rowwise(np.maximum)
def _extremes(
    gap: np.ndarray, pressure: np.ndarray, hardness: float
) -> tuple[float, float, float]:
    """Return the largest gap in contact, and minus the smallest in contact and of all.

    With a hardness, both of these are those of all atoms not in plastic contact.
    """
    gaps = gap[pressure > 0.0]
    highest = float(gaps.max(initial=-math.inf))
    if hardness < math.inf:
        gap = gaps = gap[pressure < hardness]
    lowest, overlap = (float(-g.min(initial=math.inf)) for g in (gaps, gap))
    return highest, lowest, overlap


@rowwise(np.add)
def _flow(gap: np.ndarray, pressure: np.ndarray, hardness: float) -> float:
    """Return the sum of the overlaps in plastic contact."""
    return -float(np.minimum(gap, 0.0).sum(where=pressure >= hardness))


@rowwise(np.logical_and)
def _same_contact(
    old: np.ndarray, new: np.ndarray, length: float, change: np.ndarray, hardness: float
) -> bool:
    """Return whether the same atoms carry pressure before, after and on the way.

    With a hardness: whether the same atoms are in plastic contact, too.
    """
    if ((new > 0.0) != (old > 0.0)).any():
        return False
    if hardness < math.inf and ((new < hardness) != (old < hardness)).any():
        return False
    on_the_way = old + length * change
    return bool(on_the_way.min() >= 0.0 and on_the_way.max() <= hardness)


@rowwise()
def _clip(pressure: np.ndarray, trial: np.ndarray, hardness: float) -> None:
    """Clip pressures to their bounds, and set them to those that the trial is at."""
    pressure *= (pressure > 0.0) & (trial > 0.0)
    if hardness < math.inf:
        np.minimum(pressure, hardness, out=pressure)
        pressure[trial == hardness] = hardness
