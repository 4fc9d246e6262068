r"""Force curves of a tip on a cantilever, as an atomic force microscope records them.

The base of the cantilever is at height D, where the tip would be without a force,
counted from where the flat substrate begins to repel it, as the penetration
:math:`\delta`. The tip is deflected by :math:`d = -\delta - D`, and a cantilever of
stiffness k is in equilibrium with the contact if :math:`N = k d`. So each state of an
adhesion loop, for which the tip is held, is an equilibrium for the base at

.. math:: D = -\delta - N(\delta)/k .

Where D rises while the tip goes down, :math:`-dN/d\delta > k`, the cantilever is too
soft to hold the tip: it jumps, at constant D, to the next equilibrium. The surface
relaxes much faster than the cantilever moves, so that it follows the states of the loop
meanwhile.

A loop that turns by itself holds every cantilever: its last force on approach is larger
than all before, so that the base was never lower.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import trapezoid

from ase_roughcontact._util.summary import Summarized
from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import FloatArray, positive
from ase_roughcontact.path_kinds.loop.instabilities import (
    AdhesionLoop,
    Jump,
)


@dataclass(frozen=True)
class CantileverJump:
    """Instability of a tip on a cantilever.

    Attributes
    ----------
    distance : float
        Height of the base above first contact (Å).
    force_before, force_after : float
        Normal forces (eV/Å).
    """

    distance: float
    force_before: float
    force_after: float


@dataclass(frozen=True, eq=False)
class CantileverBranch(Summarized):
    """Approach or retraction of a cantilever.

    Attributes
    ----------
    distance : ndarray, shape (k,)
        Height of the base above first contact, monotonic, from or to where the tip is
        free; twice the same at a jump (Å). With the deflection it is the negative
        penetration.
    force : ndarray, shape (k,)
        Normal force (eV/Å).
    deflection : ndarray, shape (k,)
        Deflection of the cantilever, positive upward (Å).
    jumps : tuple of CantileverJump
        Jumps of the tip on this branch, in order.
    """

    distance: FloatArray
    force: FloatArray
    deflection: FloatArray
    jumps: tuple[CantileverJump, ...]


@dataclass(frozen=True, eq=False)
class CantileverCurve(Summarized):
    """Force curve of a cantilever.

    Attributes
    ----------
    stiffness : float
        Stiffness k of the cantilever (eV/Å^2).
    approach, retraction : CantileverBranch
    """

    stiffness: float
    approach: CantileverBranch
    retraction: CantileverBranch

    @property
    def pull_off_force(self) -> float:
        """Largest tension during retraction, zero without any (eV/Å).

        A lower bound if the `turn_force` is negative.
        """
        return max(0.0, -float(self.retraction.force.min()))

    @property
    def turn_force(self) -> float:
        """Normal force where the retraction begins (eV/Å)."""
        return float(self.retraction.force[0])

    @property
    def turn_penetration(self) -> float:
        """Penetration where the retraction begins (Å)."""
        branch = self.retraction
        return -float(branch.distance[0] + branch.deflection[0])

    @property
    def snap_in(self) -> CantileverJump | None:
        """Largest jump during approach, None without one."""
        return _largest(self.approach.jumps)

    @property
    def pull_off(self) -> CantileverJump | None:
        """Largest jump during retraction, None without one."""
        return _largest(self.retraction.jumps)

    @property
    def dissipated_energy(self) -> float:
        r"""Area of the curve, :math:`-\oint N\,dD` (eV)."""
        branches = self.approach, self.retraction
        return -sum(float(trapezoid(b.force, b.distance)) for b in branches)


def cantilever_curve(loop: AdhesionLoop, stiffness: float) -> CantileverCurve:
    """Return the force curve of a cantilever from a loop of heights.

    Parameters
    ----------
    loop : AdhesionLoop
    stiffness : float
        Stiffness k of the cantilever (eV/Å^2); 1 N/m is 0.0624 eV/Å^2.

    Returns
    -------
    CantileverCurve

    Raises
    ------
    ValueError
        If the stiffness is not positive, or the cantilever is so soft that the tip
        jumps in beyond the deepest state of the loop.

    Notes
    -----
    The tip has no inertia: it does not oscillate after a jump.
    """
    positive(stiffness=stiffness)
    first, down = loop.curve("approach")
    last, up = loop.curve("retraction")
    # beyond the loop the tip is free; a soft cantilever may snap in from farther away
    free = max(first[0], last[-1]) + 1.1 * max(0.0, -up.min()) / stiffness
    first, down = np.append(free, first), np.append(0.0, down)
    last, up = np.append(last, free), np.append(up, 0.0)
    deepest = loop.retraction[0]
    zero = deepest.height + deepest.penetration
    approach = _followed(first, down, zero, loop.approach_jumps, stiffness, -1.0)
    turn = deepest.height - zero - deepest.normal_force / stiffness
    if approach.distance[-1] != turn:
        raise ValueError(
            f"the tip on a cantilever of {stiffness / UNITS['J/m^2']:.4g} N/m jumps in "
            "beyond the deepest state of the loop, at a penetration of "
            f"{deepest.penetration / UNITS['nm']:.4g} nm: choose a deeper one or none, "
            "or a stiffer cantilever"
        )
    retraction = _followed(last, up, zero, loop.retraction_jumps, stiffness, 1.0)
    return CantileverCurve(stiffness, approach, retraction)


def _followed(
    height: FloatArray,
    force: FloatArray,
    zero: float,
    unstable: tuple[Jump, ...],
    stiffness: float,
    direction: float,
) -> CantileverBranch:
    """Return the curve that a base follows while it moves in one direction."""
    after = {(jump.after.height, jump.after.normal_force) for jump in unstable}
    ends = [
        i for i, state in enumerate(zip(height, force, strict=True)) if state in after
    ]
    along = direction * (height - zero - force / stiffness)
    distance, columns, last, landed = follow(along, force[:, None], np.array(ends, int))
    jumps = [
        CantileverJump(float(direction * along[i]), float(force[i]), float(end))
        for i, end in zip(last, landed[:, 0], strict=True)
    ]
    followed = columns[:, 0]
    return CantileverBranch(
        direction * distance, followed, followed / stiffness, tuple(jumps)
    )


def follow(
    along: FloatArray, columns: FloatArray, ends: np.ndarray
) -> tuple[FloatArray, FloatArray, np.ndarray, FloatArray]:
    """Return the points of a curve that a base reaches, and its jumps.

    Parameters
    ----------
    along : ndarray, shape (n,)
        Height of the base at equilibria in the order of the states, times the direction
        in which it moves (length).
    columns : ndarray, shape (n, c)
        Further quantities of the equilibria.
    ends : ndarray of int
        Numbers of the first points after jumps of the surface.

    Returns
    -------
    along, columns : ndarray, shapes (m,) and (m, c)
        Values at the points that are reached; at a jump before and after it.
    last : ndarray of int, shape (j,)
        Points before the jumps.
    landed : ndarray, shape (j, c)
        Columns after the jumps.
    """
    reached = np.flatnonzero(along >= np.maximum.accumulate(along))
    (at,) = np.nonzero((np.diff(reached) > 1) | np.isin(reached[1:], ends))
    last, next_ = reached[at], reached[at + 1]
    # the tip lands at the same height of the base, before the next point
    length = np.where(np.isin(next_, ends), 0.0, along[next_] - along[next_ - 1])
    part = along[last] - along[next_ - 1]
    share = np.divide(part, length, out=np.ones(len(at)), where=length > 0.0)[:, None]
    landed = columns[next_ - 1] * (1.0 - share) + columns[next_] * share
    return (
        np.insert(along[reached], at + 1, along[last]),
        np.insert(columns[reached], at + 1, landed, axis=0),
        last,
        landed,
    )


def _largest(jumps: tuple[CantileverJump, ...]) -> CantileverJump | None:
    return max(
        jumps, key=lambda jump: abs(jump.force_after - jump.force_before), default=None
    )
