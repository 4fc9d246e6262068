"""Relaxation of a step to the tolerance that it requires, and a check of it."""

from __future__ import annotations

from ase_roughcontact.contact import Contact, Problem, State
from ase_roughcontact.paths.accuracy import ForceTolerance, accuracy_of
from ase_roughcontact.paths.relaxed import RelaxedStep, SolverStatistics
from ase_roughcontact.paths.step_options import StepOptions
from ase_roughcontact.solvers.default import default_relaxer
from ase_roughcontact.solvers.relaxation import Run, Start, Support, largest_error

# A load counts as not carried if rounding leaves more than this part of it.
_UNCARRIED_PART = 0.1
# A step has not converged if a force, or the force that would close a gap, is above the
# first times the tolerance plus the second, for rounding, times all forces of the wall.
_EXCESS, _ROUNDING = 2.0, 1e-13


class StepRelaxer:
    """Relaxes steps to a given tolerance, or to that which the states require.

    Parameters
    ----------
    problem : Problem
    options : StepOptions
    """

    def __init__(self, problem: Problem, options: StepOptions) -> None:
        self._relaxer = options.relaxer or default_relaxer(problem.wall)
        self._given, self._max_steps = options.fmax, options.max_steps
        self._tolerance = ForceTolerance(
            accuracy_of(options.accuracy, options.continuum).tolerance,
            problem.solid.contact_modulus * problem.spacing**2,
        )

    def __call__(
        self,
        contact: Contact,
        state: State,
        support: Support,
        statistics: SolverStatistics,
        start: Start | None = None,
    ) -> Run:
        """Relax a contact from a state, and add its cost to the statistics."""
        expected = self._given or self._tolerance.expected(support.load)
        tolerance: float | None = expected
        while tolerance is not None:
            run = self._relaxer(
                contact, state, support, tolerance, self._max_steps, start
            )
            statistics.add(run, tolerance)
            state, start = run.state, None
            reduced = self._tolerance.reduced(tolerance, run.fields)
            tolerance = None if self._given or not run.converged else reduced
        return run

    def check(self, relaxed: RelaxedStep, softness: float = 1.0) -> None:
        """Mark a step as not converged whose forces, gaps or load are not as required.

        Over a time step the solid is softer than between steps.
        """
        statistics = relaxed.statistics
        if statistics.converged and self._given is None:
            statistics.mark(_lost_load(relaxed))
        if statistics.converged:
            statistics.mark(_remaining_force(relaxed, softness))


def _lost_load(relaxed: RelaxedStep) -> str:
    """Return that a load is lost in the rounding of forces; empty if it is not."""
    load, unbalanced = abs(relaxed.run.support.load), relaxed.run.unbalanced
    carried = relaxed.statistics.tolerance <= _UNCARRIED_PART * load
    if carried or not 0.0 < _UNCARRIED_PART * load < unbalanced:
        return ""
    return (
        f"a load of {relaxed.run.support.load:.3g} is below the rounding of forces: "
        f"{unbalanced:.3g} of it is not carried"
    )


def _remaining_force(relaxed: RelaxedStep, softness: float) -> str:
    """Return that forces or gaps are above the tolerance; empty if they are not."""
    halfspace, state = relaxed.halfspace, relaxed.fields
    stiffness = halfspace.cell_area / (softness * halfspace.self_compliance)
    limit = relaxed.statistics.tolerance
    if not relaxed.contact.interaction.hard and state.pressure.any():
        limit = min(limit, largest_error(relaxed.contact, state.pressure))
    left = max(relaxed.run.max_force, stiffness * relaxed.gap_error)
    rounding = _ROUNDING * state.cell_area * float(abs(state.pressure).sum())
    if left <= _EXCESS * limit + rounding:
        return ""
    return (
        f"a force of {left:.3g} remains, more than the {limit:.3g} that the tolerance "
        "and the forces of the wall allow, although the optimizer has converged: lower "
        "fmax"
    )
