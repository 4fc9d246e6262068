r"""Steps of a contact with friction that depends on slip, and their instabilities.

A step is divided into parts. Its end is a stable state, see `weakening`, and mostly the
state that the contact reaches without inertia. If friction weakens by slip, the slip
may also grow without further load, from the end of a stable branch to another
equilibrium. Elastic tractions fall linearly then, from the bounds at most, and the
energy that neither the surface stores nor friction consumes is released,

.. math:: R \le \sum \left[\tfrac{1}{2} (r_0 + r_1) s - \int_0^s r \, ds\right]

for the bounds before and after the slip s. A part in which R may exceed 1 % of the work
is divided, until it is so short that the load hardly changes. If energies do not
balance in it, it has an instability. The contact goes on at the next equilibrium, if
there is one.

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
    FrictionOptions,
    FrictionSolution,
    solve_friction,
)
from ase_roughcontact.solvers.lateral.weakening import solve_weakening
from ase_roughcontact.solvers.status import CONVERGED, Status

# Largest energy that may be released in a part without an instability, relative to the
# work of the part.
_MAX_RELEASED = 0.01
# Length of the part of a step in which an instability is located.
_LOCATED = 1e-3


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
    """

    friction: LocalFriction
    solution: FrictionSolution
    lost: float = 0.0
    released: float = 0.0
    instabilities: int = 0


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
    path = _SlipPath(halfspace, drive, options or FrictionOptions())
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
        moved, uncertain = path.moved(at, done, end)
        located = end - done <= _LOCATED
        if located and not moved.solution.converged:
            moved, _ = path.moved(at, done, end, beyond=True)
            if not moved.solution.converged:
                status = moved.solution.status
                at = replace(at, solution=replace(at.solution, status=status))
                break
        if located or (moved.solution.converged and not uncertain):
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
class _SlipPath:
    """States of a contact over a step."""

    halfspace: LateralHalfSpace
    drive: Drive
    options: FrictionOptions

    def moved(
        self, at: SlipStep, begin: float, end: float, beyond: bool = False
    ) -> tuple[SlipStep, bool]:
        """Return the contact after a part of the step, and whether it may be unstable.

        Energies balance in short parts only: elsewhere its instabilities do not count.

        Parameters
        ----------
        at : SlipStep
            The contact before it.
        begin, end : float
            Limits of the part.
        beyond : bool
            Whether to go on across an instability.
        """
        old, imposed = at.solution, (end - begin) * self.drive.imposed
        found = solve_weakening(
            self.halfspace,
            at.friction,
            old.displacement + imposed,
            old.tractions,
            support=self.drive.support(end, old.shift),
            options=self.options,
            beyond=beyond,
        )
        new, slipped = found.solution, found.slipped
        lost = float((at.friction.mean_bounds(slipped) * slipped).sum())
        moved = imposed + new.shift[:, None, None]
        work = 0.5 * float(((old.tractions + new.tractions) * moved).sum())
        before = float((old.tractions * old.displacement).sum())
        after = float((new.tractions * new.displacement).sum())
        missing = work - 0.5 * (after - before) - lost
        sums = at.friction.bounds() + at.friction.bounds(slipped)
        limit = _MAX_RELEASED * max(abs(work), lost)
        uncertain = 0.5 * float((sums * slipped).sum()) - lost > limit
        unstable = uncertain and missing > limit
        step = SlipStep(
            at.friction.slipped_further(slipped),
            replace(new, shift=old.shift + new.shift),
            at.lost + lost,
            at.released + (missing if unstable else 0.0),
            at.instabilities + unstable,
        )
        return step, uncertain
