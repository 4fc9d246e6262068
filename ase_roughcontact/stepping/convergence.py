r"""Relaxation of a step to the tolerance that it requires, and a check of it.

The tolerance of forces is relative to their mean magnitude in contact,

.. math:: f_\max = \max\left(t \, \frac{\sum_{i \le n} |p_i| a_0^2}{n},\,
          10^{-13} E^* a_0^2\right)

with the relative tolerance :math:`t` and the :math:`n` atoms in contact (some of them
are under tension if a hard wall attracts), or all atoms on which the wall acts if their
mean force is larger.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ase_roughcontact.contact import Contact, ContactState, Problem, State
from ase_roughcontact.contact.support import Support
from ase_roughcontact.solvers.relaxation import (
    FORCE_ROUNDING,
    Run,
    Start,
    largest_error,
)
from ase_roughcontact.solvers.soft.newton import default_relaxer
from ase_roughcontact.solvers.status import Status, StatusKind
from ase_roughcontact.stepping.accuracy import tolerance_for
from ase_roughcontact.stepping.options import StepOptions
from ase_roughcontact.stepping.relaxed import RelaxedStep

# Force on an atom in contact before any is known, in units of E* a0^2: about the force
# on self-affine surfaces of a rms slope of 0.1.
_TYPICAL_FORCE = 0.05
# First tolerance, relative to the one that the mean force in the last state requires:
# the mean force in the next state may be smaller.
_FIRST_TOLERANCE = 0.8
# Reduced tolerance, relative to the required one, so that the next state does not need
# another reduction.
_REDUCED_TOLERANCE = 0.5
# Largest part of a load that rounding may leave uncarried.
_MAX_UNCARRIED_PART = 0.1
# Largest force of a converged step, or force that would close a gap, in units of the
# tolerance.
_MAX_REMAINING_FORCE = 2.0

#: Kinds of a status of a step that is not as required, although its solver converged.
LOAD_LOST = StatusKind(
    "a load of {load:.3g}{force_unit} is below the rounding of forces: "
    "{unbalanced:.3g}{force_unit} of it is not carried"
)
FORCE_LEFT = StatusKind(
    "a force of {left:.3g}{force_unit} remains, more than the {limit:.3g}{force_unit} "
    "that the tolerance and the forces of the wall allow, although the optimizer has "
    "converged",
    "lower fmax",
)


class StepRelaxer:
    """Relaxes steps to a given tolerance, or to the one that the states require.

    Parameters
    ----------
    problem : Problem
    options : StepOptions
    """

    def __init__(self, problem: Problem, options: StepOptions) -> None:
        self._relaxer = options.relaxer or default_relaxer(problem.wall)
        self._given, self._max_steps = options.fmax, options.max_steps
        usual = options.grid_model.tolerance
        self._relative = min(usual, tolerance_for(options.solver_error))
        unit = problem.solid.contact_modulus * problem.spacing**2
        self._typical_force = _TYPICAL_FORCE * unit
        self._smallest_tolerance = FORCE_ROUNDING * unit

    def __call__(
        self,
        contact: Contact,
        state: State,
        support: Support,
        earlier: Run | None = None,
        start: Start | None = None,
    ) -> Run:
        """Relax a contact from a state; the cost includes earlier runs."""
        mean_force = state.mean_force
        if math.isnan(mean_force):
            mean_force = self._typical_force
        # a single atom carries no more than the load
        load = support.load if support.load > 0.0 else math.inf
        tolerance = self._given or self._for(min(_FIRST_TOLERANCE * mean_force, load))
        while True:
            run = self._relaxer(
                contact, state, support, tolerance, self._max_steps, start
            )
            run = earlier = _with_cost_of(earlier, run, tolerance)
            state, required = run.state, self.required(run.fields)
            if run.fields.repulsive_atoms:
                state = replace(state, mean_force=_mean_force(run.fields))
                run = earlier = replace(run, state=state)
            if self._given or not run.converged or tolerance <= required:
                return run
            # at most half of the last tolerance, down to the smallest one
            tolerance = max(_REDUCED_TOLERANCE * required, self._smallest_tolerance)
            start = None

    def required(self, fields: ContactState) -> float:
        """Return the tolerance that the accuracy requires in a state.

        Parameters
        ----------
        fields : ContactState

        Returns
        -------
        float
            Infinity without an atom in contact.
        """
        return self._for(_mean_force(fields)) if fields.repulsive_atoms else math.inf

    def _for(self, mean_force: float) -> float:
        return max(self._relative * mean_force, self._smallest_tolerance)

    def checked(self, relaxed: RelaxedStep, compliance: float) -> RelaxedStep:
        """Return a step, marked if its forces, gaps or load are not as required.

        Parameters
        ----------
        relaxed : RelaxedStep
        compliance : float
            Compliance of the solid over the time step, relative to the compliance
            under a sudden load; 1 if the solid does not creep.

        Returns
        -------
        RelaxedStep
        """
        if self._given is None:
            relaxed = relaxed.marked(_lost_load(relaxed))
        return relaxed.marked(_remaining_force(relaxed, compliance))


def _mean_force(fields: ContactState) -> float:
    """Return the mean force of the wall on an atom in contact, or on all it acts on."""
    # atoms that are about to lose contact carry nothing
    magnitude = abs(fields.pressure)
    mean = float(magnitude.sum()) / max(int(np.count_nonzero(magnitude)), 1)
    return max(fields.contact_pressure, mean) * fields.cell_area


def _with_cost_of(earlier: Run | None, run: Run, tolerance: float) -> Run:
    """Return a run to a tolerance with the cost of an earlier one added."""
    if earlier is None:
        return replace(run, tolerance=tolerance)
    iterations, pairs = run.iterations + earlier.iterations, run.pairs + earlier.pairs
    return replace(run, tolerance=tolerance, iterations=iterations, pairs=pairs)


def _lost_load(relaxed: RelaxedStep) -> Status | None:
    """Return that a load is lost in the rounding of forces; None if it is not."""
    load, unbalanced = abs(relaxed.run.support.load), relaxed.run.unbalanced
    carried = relaxed.run.tolerance <= _MAX_UNCARRIED_PART * load
    if carried or not 0.0 < _MAX_UNCARRIED_PART * load < unbalanced:
        return None
    numbers = {"load": relaxed.run.support.load, "unbalanced": unbalanced}
    return Status(LOAD_LOST, numbers)


def _remaining_force(relaxed: RelaxedStep, compliance: float) -> Status | None:
    """Return that forces or gaps are above the tolerance; None if they are not."""
    halfspace, state = relaxed.halfspace, relaxed.fields
    stiffness = halfspace.cell_area / (compliance * halfspace.self_compliance)
    limit = relaxed.run.tolerance
    if not relaxed.contact.wall.hard and state.pressure.any():
        limit = min(limit, largest_error(relaxed.contact, state.pressure))
    left = max(relaxed.run.max_force, stiffness * relaxed.gap_error)
    rounding = FORCE_ROUNDING * state.total_magnitude
    if left <= _MAX_REMAINING_FORCE * limit + rounding:
        return None
    return Status(FORCE_LEFT, {"left": left, "limit": limit})
