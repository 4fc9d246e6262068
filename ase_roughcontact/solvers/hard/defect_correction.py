r"""Defect correction for the contact with a hard wall on one grid.

The energy :math:`E(p) = \tfrac12 p \cdot G p + (Z + h) \cdot p` is minimised over
pressures :math:`p \ge 0`, at a height :math:`Z` or under a load :math:`a_0^2 \sum p`.
A spring of stiffness k is a uniform compliance in addition to :math:`G`: it has no
force at the height Z, and a force raises the indenter by :math:`a_0^2 \sum p / k`.

1. Calculate the gap :math:`g = Z + h + G p` by a convolution. Under a load, :math:`Z`
   makes the smallest and the largest gap in contact opposite. Stop if the violation,
   the largest gap in contact or overlap, is below the tolerance, and the load is
   carried.
2. Solve the contact problem with the model :math:`C` in place of :math:`G` for the
   correction :math:`x` of the pressure, to 7 % of the violation; see `complementarity`.
3. Calculate :math:`G x` by a convolution. If the violation did not decrease to 15 % in
   the step before, minimise the energy over the span of this correction and the last
   one instead, which reduces errors of the model in the longest waves.

With a hardness :math:`H` the pressures are bounded by it, too, and atoms at this bound
may overlap.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from ase_roughcontact._util.kernels import (
    dot,
    dots,
    linear_combination,
    scale,
    total,
)
from ase_roughcontact.contact import Contact
from ase_roughcontact.elasticity.circulant import CirculantModel, covering_model
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.solvers.hard.bounds import PRESSURE_ROUNDING, with_sum
from ase_roughcontact.solvers.hard.complementarity import ComplementarityProblem
from ase_roughcontact.solvers.hard.linear_support import LinearSupport
from ase_roughcontact.solvers.hard.starting_pressure import initial_pressure
from ase_roughcontact.solvers.options import ActiveSetOptions
from ase_roughcontact.solvers.relaxation import (
    Relaxation,
    force_per_gap,
    precision_advice,
)
from ase_roughcontact.solvers.status import CONVERGED, UNFINISHED, Status, StatusKind

# Largest violation by the solution for an exact model, in units of the rounding error
# of the model: only rounding errors make another step necessary.
_EXACT_CONTRACTION = 1000.0
# Number of steps that must reduce the violation.
_CHECKED_STEPS = 10
# Largest ratio of the violations after and before these steps, which bounds the number
# of steps.
_MAX_VIOLATION_RATIO = 0.99

#: The pressure or the heights are not finite.
GAP_NOT_FINITE = StatusKind("the gap is not finite")
#: The violation does not decrease.
NO_PROGRESS = StatusKind(
    "no progress in {steps} steps: the violation is {violation:.3g}{length_unit}, not "
    "{tolerance:.3g}{length_unit}",
    "allow a larger gap",
)


def defect_correction(
    contact: Contact,
    support: LinearSupport,
    start: np.ndarray | None,
    tolerance: float,
    options: ActiveSetOptions,
) -> Iterator[Relaxation]:
    """Solve the contact problem of a hard wall on one grid.

    Parameters
    ----------
    contact : Contact
        Contact; the wall counts as hard.
    support : LinearSupport
        Height of the indenter, load on it, or spring; the height is ignored if there is
        a load.
    start : ndarray, shape (n, m), optional
        Initial pressure, not negative.
    tolerance : float
        Largest violation that may be left (length).
    options : ActiveSetOptions
        Options of the solver.

    Yields
    ------
    Relaxation
        The start, and the state after each step. The last one is converged, or has a
        message.
    """
    solver = _DefectCorrection(contact, support, start, tolerance, options)
    del start  # its memory is needed
    while True:
        state = solver.evaluate()
        yield state
        if state.status.final:
            return
        solver.correct()


class _DefectCorrection:
    """Pressure, opening and last correction, in as few arrays as possible."""

    def __init__(
        self,
        contact: Contact,
        support: LinearSupport,
        start: np.ndarray | None,
        tolerance: float,
        options: ActiveSetOptions,
    ) -> None:
        self._contact, self._halfspace = contact, contact.halfspace
        self._height, self._tolerance = support.height, tolerance
        self._options = options
        self._hardness = contact.wall.hardness
        area = self._halfspace.cell_area
        self._total = None if support.load is None else support.load / area
        # compliance of a spring to the sum of pressures
        self._yielding = support.compliance * area
        self._pressure = initial_pressure(contact, support.load, start)
        self._opening = self._opened(self._pressure)
        self._model: CirculantModel | None = None
        self._violations: list[float] = []
        self._last: np.ndarray | None = None  # correction, in single precision
        self._last_curvature = 0.0  # product of this correction and its opening

    def evaluate(self) -> Relaxation:
        """Calculate the gap; return the present state."""
        gap = self._contact.heights + self._opening
        touching = self._pressure > 0.0
        # atoms that must not overlap: not under the hardness (NaN must not, either)
        rigid = ~(self._pressure >= self._hardness)
        highest = float(gap.max(where=touching, initial=-math.inf))
        lowest = float(gap.min(where=rigid, initial=math.inf))
        if self._total is not None:
            among = touching if self._hardness == math.inf else rigid
            lower = float(gap.min(where=among, initial=math.inf))
            self._height = -(highest + min(lower, highest)) / 2.0
        gap += self._height
        # NumPy's maximum is NaN if an error is NaN
        errors = highest + self._height, -lowest - self._height, self._load_violation()
        violation = float(np.max([0.0, *errors]))
        self._violations.append(violation)
        rise = self._yielding * total(self._pressure)
        energy = 0.5 * (
            dot(self._pressure, self._opening) - rise * total(self._pressure)
        )
        if self._hardness < math.inf:
            flowed = gap[self._pressure >= self._hardness]
            energy -= self._hardness * float(np.minimum(flowed, 0.0).sum())
        return Relaxation(
            pressure=self._pressure,
            height=self._height + rise,
            energy=self._halfspace.cell_area * energy,
            error=violation * force_per_gap(self._halfspace),
            status=self._status(),
        )

    def correct(self) -> None:
        """Correct the pressure by the model, so that the energy falls."""
        trial = self._solve_model(self._violations[-1])
        opening = self._opened(trial)
        opening -= self._opening
        x = np.empty(trial.shape, np.float32)
        np.subtract(trial, self._pressure, out=x, casting="same_kind")
        slope, curvature = dots([(x, self._gap), (x, opening)])
        last, last_curvature = self._last, self._last_curvature
        self._last, self._last_curvature = x, curvature
        if last is None or not self._is_slow:
            opening += self._opening
            self._pressure, self._opening = trial, opening
            return
        slope_of_last, mixed = dots([(last, self._gap), (last, opening)])
        del opening  # its memory is needed
        hessian = [[curvature, mixed], [mixed, last_curvature]]
        gradient = np.array([slope, slope_of_last])
        (a, b), *_ = np.linalg.lstsq(hessian, -gradient, rcond=1e-8)
        combined = linear_combination([(1.0, self._pressure), (a, x), (b, last)])
        self._pressure = self._bounded(combined, trial)
        del combined, trial, last
        self._opening = self._opened(self._pressure)

    @property
    def _gap(self) -> np.ndarray:
        gap = self._contact.heights + self._opening
        gap += self._height
        return gap

    def _load_violation(self) -> float:
        """Return the gap of an atom that the missing load would close."""
        if self._total is None:
            return 0.0
        missing = abs(self._total - total(self._pressure))
        missing -= PRESSURE_ROUNDING * self._total
        return self._halfspace.self_compliance * max(missing, 0.0)

    @property
    def _is_slow(self) -> bool:
        """Whether the last correction has hardly decreased the violation."""
        before, after = self._violations[-2:]
        return after > self._options.slow_contraction * before

    def _status(self) -> Status:
        """Return whether the state is converged, or why there is no further step."""
        violation = self._violations[-1]
        if not math.isfinite(violation):
            return Status(GAP_NOT_FINITE)
        if violation <= self._tolerance:
            return Status(CONVERGED)
        early = self._violations[:-_CHECKED_STEPS]
        late = self._violations[-_CHECKED_STEPS:]
        if not early or min(late) < _MAX_VIOLATION_RATIO * min(early):
            return Status(UNFINISHED)
        numbers = {
            "steps": _CHECKED_STEPS,
            "violation": violation,
            "tolerance": self._tolerance,
        }
        return Status(NO_PROGRESS, numbers, precision_advice(self._halfspace))

    def _solve_model(self, violation: float) -> np.ndarray:
        """Return the pressure that solves the contact problem of the model."""
        gap = self._gap
        model = self._covering_model(gap, violation)
        contraction = self._options.contraction
        if model.exact:
            contraction = _EXACT_CONTRACTION * float(np.finfo(model.dtype).eps)
        problem = ComplementarityProblem(
            model,
            self._pressure,
            gap,
            violation,
            self._total,
            self._hardness,
            self._yielding,
        )
        del gap  # its memory is needed
        return problem.solve(max(0.3 * self._tolerance / violation, contraction))

    def _covering_model(self, gap: np.ndarray, violation: float) -> CirculantModel:
        """Return a model of all atoms that may touch; the last one if it suffices."""
        if self._model is None or _overlaps_outside(self._model.box, gap):
            near = (self._pressure > 0.0) | (gap < violation)
            box = Box.bounding(near) or Box((0, 0), near.shape)
            box = box.union(self._model.box if self._model else None)
            self._model = covering_model(self._halfspace, box)
        return self._model

    def _opened(self, pressure: np.ndarray) -> np.ndarray:
        """Return ``G p`` plus the rise of the indenter on a spring."""
        opening = self._halfspace.displacement(pressure)
        scale(opening, opening, -1.0)
        if self._yielding:
            opening += self._yielding * total(pressure)
        return opening

    def _bounded(self, new: np.ndarray, trial: np.ndarray) -> np.ndarray:
        """Return a pressure between its bounds, at a bound where the trial is."""
        np.clip(new, 0.0, self._hardness, out=new)
        new *= trial > 0.0
        new[trial == self._hardness] = self._hardness
        if self._total is None:
            return new
        push = self._gap / -self._halfspace.self_compliance
        return with_sum(new, self._total, self._hardness, push)


def _overlaps_outside(box: Box, gap: np.ndarray) -> bool:
    """Return whether atoms outside of a box overlap with the indenter."""
    overlap = gap < 0.0
    overlap[box.slices] = False
    return bool(overlap.any())
