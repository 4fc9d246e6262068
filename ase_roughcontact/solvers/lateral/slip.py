r"""Lateral tractions if friction depends on slip, and instabilities of weakening.

The bounds r depend on the slip s of the step, which follows from the bounds as in
`friction`: :math:`s = S(r(s))`. The iteration :math:`s \to S(r(s))` starts without
slip. Where friction weakens, it rises to the smallest slip that is in equilibrium, at
which the contact arrives without inertia. The slowest part of the remaining change e
decreases by a factor

.. math:: \rho = \frac{\sum d\, e'}{\sum d\, e}

per iteration, with the change e' of the next one and the decrease d of the bounds by e.
Every second iteration extrapolates by it. It is at most one on a stable branch: if it
is not, the slip grows without further load. A step with such an instability, or one in
which energies do not balance, is divided, until an instability is located. From there
the contact goes to the next equilibrium, and the energy that neither the surface stores
nor friction consumes is released.

References
----------
K. Uenishi, J. R. Rice, J. Geophys. Res. 108, 2042 (2003).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ase_roughcontact.contact.support import LateralSupport
from ase_roughcontact.elasticity.lateral import LateralHalfSpace
from ase_roughcontact.interactions.local_friction import LocalFriction
from ase_roughcontact.solvers.lateral.friction import (
    LARGEST_FRICTION,
    SLIDING,
    FrictionOptions,
    FrictionSolution,
    solve_friction,
)
from ase_roughcontact.solvers.status import CONVERGED, Status, StatusKind

# Largest number of iterations for the slip.
_MAX_ITERATIONS = 400
# Residual of the tractions, relative to the change of the bounds.
_RELATIVE_RESIDUAL = 1e-3
# Part of the extrapolated change.
_EXTRAPOLATED_PART = 0.9
# Smallest change of the bounds that shows an instability by its growth, in units of the
# tolerance.
_SMALLEST_GROWING = 100.0
# Largest imbalance of the energies in a part, relative to the largest one.
_MAX_IMBALANCE = 0.1
# Length of the part of a step in which an instability is located.
_LOCATED = 1e-3

#: The largest number of iterations for the slip was reached.
SLIP_NOT_CONVERGED = StatusKind(
    "the slip has not converged after {iterations} iterations: bounds of friction "
    "change by {change:.2g}",
    "make shorter steps",
)
#: Friction has weakened below the lateral load.
RUNAWAY = StatusKind(
    "the contact slides after an instability: friction weakens by slip below the "
    "lateral load, and there is no further equilibrium",
    "give displacements, or bases and a spring",
)


@dataclass(frozen=True, eq=False)
class Drive:
    """Change of the load of a contact over a step.

    Attributes
    ----------
    imposed : ndarray, shape (2, n, m)
        Change of the displacement of atoms that stick (length).
    supports : (LateralSupport, LateralSupport) or None
        Supports of the indenter before and after the step, None if its displacement is
        given.
    """

    imposed: np.ndarray
    supports: tuple[LateralSupport, LateralSupport] | None = None

    def support(self, part: float, shift: np.ndarray) -> LateralSupport | None:
        """Return the support after a part of the step, at a shifted indenter."""
        if self.supports is None:
            return None
        before, after = (np.array(each.force) for each in self.supports)
        stiffness = self.supports[1].stiffness
        x, y = before + part * (after - before) - stiffness * shift
        return LateralSupport((float(x), float(y)), stiffness)


@dataclass(frozen=True, eq=False)
class SlipStep:
    """Contact after a step, or a part of it.

    Attributes
    ----------
    friction : LocalFriction
        Friction with the histories at the end.
    solution : FrictionSolution
        Solution at the end, with the shift and the FFT pairs of the step.
    lost : float
        Energy consumed by friction (pressure length, summed over cells).
    released : float
        Energy released by instabilities (pressure length, summed over cells).
    instabilities : int
        Number of instabilities.
    imbalance : float
        Imbalance of the energies in the last part, relative to the largest one.
    """

    friction: LocalFriction
    solution: FrictionSolution
    lost: float = 0.0
    released: float = 0.0
    instabilities: int = 0
    imbalance: float = 0.0


def follow_slip(
    halfspace: LateralHalfSpace,
    friction: LocalFriction,
    start: np.ndarray,
    drive: Drive,
    options: FrictionOptions | None = None,
) -> SlipStep:
    """Return a contact after a step, with friction that depends on slip.

    Parameters
    ----------
    halfspace : LateralHalfSpace
        Lateral compliance of the surface.
    friction : LocalFriction
        Friction with the histories at the start.
    start : ndarray, shape (2, n, m)
        Tractions at the start (pressure).
    drive : Drive
        Change of the load.
    options : FrictionOptions, optional
        Options of the solver.

    Returns
    -------
    SlipStep
        The contact, with a status if it has not converged: if there is no equilibrium
        after an instability, with what is known of it before the instability.
    """
    before = halfspace.transformed
    branch = _Branch(halfspace, drive, options or FrictionOptions())
    begun = FrictionSolution(
        start,
        np.zeros(start.shape[1:], bool),
        halfspace.displacement(start),
        np.zeros(2),
        0.0,
        Status(CONVERGED),
    )
    at, done, end, failed = SlipStep(friction, begun), 0.0, 1.0, 1.0
    while done < 1.0:
        found = branch.equilibrium(at, done, end)
        located = end - done <= _LOCATED
        if not found.stable and located:
            found = branch.equilibrium(at, done, end, beyond=True)
            if not found.solution.converged:
                shift = at.solution.shift
                at = replace(at, solution=replace(found.solution, shift=shift))
                break
        moved = branch.moved(at, done, end, found)
        if located or (found.stable and moved.imbalance < _MAX_IMBALANCE):
            at, done = moved, end
            end = failed if failed > done else 1.0
        else:
            end, failed = 0.5 * (done + end), end
    pairs = (halfspace.transformed - before) / math.prod(halfspace.grid)
    return replace(at, solution=replace(at.solution, pairs=pairs))


def slip_at_bounds(
    halfspace: LateralHalfSpace,
    friction: LocalFriction,
    start: np.ndarray,
    change: np.ndarray,
    guess: np.ndarray,
    support: LateralSupport | None = None,
    options: FrictionOptions | None = None,
) -> SlipStep:
    """Return a contact after a step, with friction that does not depend on slip.

    Parameters
    ----------
    halfspace, friction, start, options
        See `follow_slip`.
    change : ndarray, shape (2, n, m)
        Change of the displacement of atoms that stick (length).
    guess : ndarray, shape (2, n, m)
        Tractions from which the solver starts (pressure).
    support : LateralSupport, optional
        Support of the indenter; by default its displacement is given.

    Returns
    -------
    SlipStep
        The contact; without slip if it slides under a force.
    """
    imposed = halfspace.displacement(start) + change
    solution = solve_friction(
        halfspace, friction.bounds(), imposed, guess, support=support, options=options
    )
    slip = imposed + solution.shift[:, None, None] - solution.displacement
    lost = float((solution.tractions * slip).sum())
    if support is not None and not support.stiffness and not solution.converged:
        slip, lost = np.zeros(slip.shape), 0.0  # not known
        solution = replace(solution, shift=np.zeros(2))
    ended = friction.slipped_further(np.hypot(*slip))
    return SlipStep(ended, solution, lost)


@dataclass(frozen=True, eq=False)
class _Equilibrium:
    """Tractions and slip after a part of a step.

    Attributes
    ----------
    solution : FrictionSolution
    slipped : ndarray, shape (n, m)
        Way that each atom has slipped in the part (length).
    stable : bool
        Whether it is reached without an instability.
    """

    solution: FrictionSolution
    slipped: np.ndarray
    stable: bool


@dataclass(frozen=True, eq=False)
class _Branch:
    """Equilibria of a contact over a step."""

    halfspace: LateralHalfSpace
    drive: Drive
    options: FrictionOptions

    def equilibrium(
        self, at: SlipStep, begin: float, end: float, beyond: bool = False
    ) -> _Equilibrium:
        """Return the equilibrium after a part of the step.

        Parameters
        ----------
        at : SlipStep
            The contact before it.
        begin, end : float
            Limits of the part of the step.
        beyond : bool
            Whether to go on after an instability.
        """
        imposed = at.solution.displacement + (end - begin) * self.drive.imposed
        support = self.drive.support(end, at.solution.shift)
        tractions, stable, extrapolated = at.solution.tractions, True, True
        slip, change = np.zeros(tractions.shape[1:]), 1.0
        last_rest = last_drop = slip
        for _ in range(_MAX_ITERATIONS):
            bound = at.friction.bounds(slip)
            residual = max(self.options.tolerance, _RELATIVE_RESIDUAL * change)
            solution = solve_friction(
                self.halfspace,
                bound,
                imposed,
                tractions,
                support=support,
                options=replace(self.options, tolerance=residual),
            )
            if not solution.converged:
                if slip.any() and solution.status.kind in (SLIDING, LARGEST_FRICTION):
                    solution = replace(solution, status=Status(RUNAWAY))
                return _Equilibrium(solution, slip, False)
            tractions = solution.tractions
            opening = imposed + solution.shift[:, None, None] - solution.displacement
            found = np.where(solution.slipping, np.hypot(*opening), 0.0)
            rest, drop = found - slip, bound - at.friction.bounds(found)
            change = float(abs(drop).max(initial=0.0)) / (bound.max() or 1.0)
            if change <= self.options.tolerance:
                if residual <= self.options.tolerance:
                    return _Equilibrium(solution, found, stable)
                slip, extrapolated = found, True
                continue
            further = 0.0
            if not extrapolated:
                size = float((last_drop * last_rest).sum())
                growth = float((last_drop * rest).sum()) / size if size > 0.0 else 0.0
                if growth < 1.0:
                    further = _EXTRAPOLATED_PART * growth / (1.0 - growth)
                elif change > _SMALLEST_GROWING * self.options.tolerance:
                    stable = False
                    if not beyond:
                        return _Equilibrium(solution, found, stable)
            extrapolated = further != 0.0
            slip = np.maximum(found + further * rest, 0.0)
            last_rest, last_drop = rest, drop
        numbers = {"iterations": _MAX_ITERATIONS, "change": change}
        status = Status(SLIP_NOT_CONVERGED, numbers)
        return _Equilibrium(replace(solution, status=status), found, stable)

    def moved(
        self, at: SlipStep, begin: float, end: float, found: _Equilibrium
    ) -> SlipStep:
        """Return the contact in an equilibrium after a part of the step."""
        solution, slipped = found.solution, found.slipped
        lost = float((at.friction.mean_bounds(slipped) * slipped).sum())
        moved = (end - begin) * self.drive.imposed + solution.shift[:, None, None]
        old = at.solution
        work = 0.5 * float(((old.tractions + solution.tractions) * moved).sum())
        before = old.tractions * old.displacement
        after = solution.tractions * solution.displacement
        stored = 0.5 * float(after.sum() - before.sum())
        missing, largest = work - stored - lost, max(abs(work), abs(stored), lost)
        return SlipStep(
            at.friction.slipped_further(slipped),
            replace(solution, shift=old.shift + solution.shift),
            at.lost + lost,
            at.released + (0.0 if found.stable else missing),
            at.instabilities + (not found.stable),
            abs(missing) / largest if largest else 0.0,
        )
