"""Instabilities of an adhesion loop, and the energy that they dissipate.

While a surface stays in its minimum of energy, the work done on the indenter is stored,
``dE = -N dZ``. The energy that is not stored between two states was dissipated when the
surface jumped to another minimum.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from ase_roughcontact._util.rounding import RATIO_ROUNDING
from ase_roughcontact._util.summary import Summarized, short_text
from ase_roughcontact._util.validation import FloatArray, one_of
from ase_roughcontact.analysis.path_values import tension_at_turn
from ase_roughcontact.results.record import LoadStep

#: Points of an interpolated branch between two states.
POINTS = 32
# Largest value of t (1 - t) (1 - 2 t) for t from 0 to 1.
_MAX_ANTISYMMETRIC_PART = np.sqrt(3.0) / 18.0


@dataclass(frozen=True)
class Jump(Summarized):
    """An instability between two neighbouring states.

    Attributes
    ----------
    before, after : LoadStep
        The last state before the jump, and the first one after it.
    """

    before: LoadStep
    after: LoadStep

    def _summary(self) -> dict[str, str]:
        """Return the place of the instability, forces and energy."""
        before, after = self.before.normal_force, self.after.normal_force
        return {
            "height": short_text(self.height, "Å"),
            "force": f"{short_text(before)} to {short_text(after, 'eV/Å')}",
            "dissipated_energy": short_text(self.dissipated_energy, "eV"),
        }

    @property
    def height(self) -> float:
        """Height of the indenter, in the middle between the two states (Å)."""
        return 0.5 * (self.before.height + self.after.height)

    @property
    def dissipated_energy(self) -> float:
        """Energy lost in the jump (eV)."""
        stored = self.after.energy - self.before.energy
        return trapezoidal_work(self.before, self.after) - stored

    @property
    def error(self) -> float:
        """Largest error of the energy, as the height of the jump is not known (eV)."""
        change = self.after.normal_force - self.before.normal_force
        return 0.5 * abs(change * (self.after.height - self.before.height))


@dataclass(frozen=True)
class AdhesionLoop(Summarized):
    """Result of `adhesion_loop`: states and instabilities of approach and retraction.

    Attributes
    ----------
    approach, retraction : tuple of LoadStep
        The states from beyond the range of the wall to the deepest one, and from there
        until nothing acts on the indenter.
    approach_jumps, retraction_jumps : tuple of Jump
        The instabilities on either branch.

    Examples
    --------
    >>> from ase_roughcontact import LennardJones93, RoughContact, RoughSphere
    >>> from ase_roughcontact import adhesion_loop, substrate
    >>> sphere = RoughSphere(radius=20.0)
    >>> atoms = substrate('Cu', (16, 16), sphere, spacing=1.0)
    >>> atoms.calc = RoughContact(sphere, 1.0, LennardJones93.adhesive(1.0, 1.0, 0.05))
    >>> loop = adhesion_loop(atoms, step=0.1, window='auto', validity='ignore')
    >>> print(f'{loop.pull_off_force:.1f} eV/Å, lost {loop.dissipated_energy:.1f} eV')
    5.3 eV/Å, lost 0.2 eV
    >>> len(loop.approach_jumps), loop.approach[-1].converged
    (1, True)
    """

    approach: tuple[LoadStep, ...]
    retraction: tuple[LoadStep, ...]
    approach_jumps: tuple[Jump, ...]
    retraction_jumps: tuple[Jump, ...]

    @classmethod
    def of(cls, states: Sequence[LoadStep], smallest_step: float) -> AdhesionLoop:
        """Return the loop of states that were read from a file.

        Parameters
        ----------
        states : sequence of LoadStep
            States of the whole loop, in order.
        smallest_step : float
            Smallest step of the loop (Å); 1/256 of the largest one by default.

        Returns
        -------
        AdhesionLoop

        Raises
        ------
        ValueError
            If there are no states.
        """
        if not states:
            raise ValueError("a loop needs at least one state, got none")
        deepest = min(range(len(states)), key=lambda i: states[i].height)
        approach, retraction = states[: deepest + 1], states[deepest:]
        return cls(
            tuple(approach),
            tuple(retraction),
            _jumps(approach, smallest_step),
            _jumps(retraction, smallest_step),
        )

    def _summary(self) -> dict[str, str]:
        """Return numbers of states and instabilities, forces and energies."""
        at_least = ">= " if self.turns_in_tension else ""
        return {
            "states": f"{len(self.approach)} + {len(self.retraction)}",
            "jumps": f"{len(self.approach_jumps)} + {len(self.retraction_jumps)}",
            "pull_off_force": at_least + short_text(self.pull_off_force, "eV/Å"),
            "turn_force": short_text(self.turn.normal_force, "eV/Å"),
            "turn_penetration": short_text(self.turn.penetration, "Å"),
            "dissipated_energy": short_text(self.dissipated_energy, "eV"),
        }

    def __str__(self) -> str:
        return (
            f"AdhesionLoop: {len(self.approach)} states and {len(self.approach_jumps)} "
            f"instabilities on approach, {len(self.retraction)} and "
            f"{len(self.retraction_jumps)} on retraction; pull-off force "
            f"{'at least ' * self.turns_in_tension}{self.pull_off_force:.4g} eV/Å, "
            f"turned at {self.turn.normal_force:.4g} eV/Å and a penetration of "
            f"{self.turn.penetration:.4g} Å, dissipated energy "
            f"{self.dissipated_energy:.4g} eV"
        )

    @property
    def turn(self) -> LoadStep:
        """Deepest state, on which the pull-off force of a rough indenter depends."""
        return self.approach[-1]

    @property
    def turns_in_tension(self) -> bool:
        """Whether the indenter is still pulled at the deepest state.

        Then the pull-off force is a lower bound: a deeper loop may find a larger one.
        """
        return len(self.retraction) > 1 and self.turn.normal_force < 0.0

    @property
    def warnings(self) -> tuple[str, ...]:
        """Why the pull-off force is a lower bound, with numbers; empty if it is not."""
        if not self.turns_in_tension:
            return ()
        return (tension_at_turn(self.turn, self.pull_off_force),)

    @property
    def pull_off_force(self) -> float:
        """Largest tension during retraction, zero without any (eV/Å).

        It is a lower bound if the loop `turns_in_tension`, and of a rough indenter it
        depends on the depth of the `turn`. Between the states the force is interpolated
        with their contact stiffness.
        """
        if min(state.normal_force for state in self.retraction) >= 0.0:
            return 0.0
        _, force = self.curve("retraction")
        return -float(force.min())

    def curve(
        self, branch: Literal["approach", "retraction"]
    ) -> tuple[FloatArray, FloatArray]:
        """Return the force as a function of the height, also between the states.

        Parameters
        ----------
        branch : {"approach", "retraction"}

        Returns
        -------
        heights, forces : ndarray, shape (k,)
            Values on cubic polynomials with the forces and contact stiffnesses of the
            states (Å, eV/Å). They have a step at an instability.
        """
        one_of(("approach", "retraction"), branch=branch)
        states, jumps = getattr(self, branch), getattr(self, f"{branch}_jumps")
        heights, forces, _ = interpolated(states, jumps)
        return heights, forces

    @property
    def jumps(self) -> tuple[Jump, ...]:
        """Instabilities of both branches, in order."""
        return (*self.approach_jumps, *self.retraction_jumps)

    @property
    def jump_in(self) -> float | None:
        """Height of the first jump during approach, None without one (Å)."""
        return self.approach_jumps[0].height if self.approach_jumps else None

    @property
    def jump_out(self) -> float | None:
        """Height of the last jump during retraction, None without one (Å)."""
        return self.retraction_jumps[-1].height if self.retraction_jumps else None

    @property
    def dissipated_energy(self) -> float:
        r"""Area of the loop of force against height, :math:`-\oint N\,dZ` (eV)."""
        total = sum(work(*states) for states in self._steps)
        return total + sum(trapezoidal_work(j.before, j.after) for j in self.jumps)

    @property
    def dissipation_error(self) -> float:
        """Residuals of the energy balances and errors of the jumps, added (eV)."""
        residuals = (
            abs(work(before, after) - (after.energy - before.energy))
            for before, after in self._steps
        )
        return sum(residuals) + sum(jump.error for jump in self.jumps)

    @property
    def _steps(self) -> list[tuple[LoadStep, LoadStep]]:
        """Neighbouring states without an instability between them."""
        parts = stable_parts(self.approach, self.approach_jumps)
        parts += stable_parts(self.retraction, self.retraction_jumps)
        steps = list[tuple[LoadStep, LoadStep]]()
        for part in parts:
            steps += pairwise(part)
        return steps

    @property
    def energy_lost_in_jumps(self) -> float:
        """Energy lost in the jumps; all that is dissipated, if none was missed (eV)."""
        return sum(jump.dissipated_energy for jump in self.jumps)


def _jumps(branch: Sequence[LoadStep], smallest_step: float) -> tuple[Jump, ...]:
    """Return the instabilities of a branch, in steps of the smallest size."""
    largest = (1.0 + RATIO_ROUNDING) * smallest_step
    return tuple(
        Jump(before, after)
        for before, after in pairwise(branch)
        if abs(after.height - before.height) <= largest and jumped(before, after)
    )


def balanced(
    before: LoadStep, after: LoadStep, tolerance: float, smallest_force: float
) -> bool:
    r"""Return whether a cubic polynomial describes the force between two states.

    That is, whether the work between them was stored, within a tolerance, and the
    antisymmetric part of the polynomial is small: it does no work, so that the balance
    of energy can close by chance where the polynomial is wrong. Where the force is
    smooth, its relative size is the relative size of the energy to the power 3/4.

    Parameters
    ----------
    before, after : LoadStep
        Neighbouring states.
    tolerance : float
        Tolerance relative to the larger normal force.
    smallest_force : float
        Smallest force to which the tolerance is relative (eV/Å).

    Returns
    -------
    bool
        False also if the second state has not converged.
    """
    force = max(abs(before.normal_force), abs(after.normal_force), smallest_force)
    error, distance = _force_error(before, after), after.height - before.height
    lost = abs((work(before, after) - (after.energy - before.energy)) / distance)
    rise = after.normal_force - before.normal_force
    mean_stiffness = 0.5 * (before.contact_stiffness + after.contact_stiffness)
    skew = np.nan_to_num(
        abs(rise + mean_stiffness * distance) * _MAX_ANTISYMMETRIC_PART
    )
    return bool(
        after.converged
        and lost <= tolerance * force + error
        and skew <= tolerance**0.75 * force + error
    )


def jumped(before: LoadStep, after: LoadStep) -> bool:
    """Return whether more energy was lost than any force between two states explains.

    Parameters
    ----------
    before, after : LoadStep
        Neighbouring states.

    Returns
    -------
    bool
    """
    jump = Jump(before, after)
    error = _force_error(before, after) * abs(after.height - before.height)
    return jump.dissipated_energy > jump.error + error


def trapezoidal_work(before: LoadStep, after: LoadStep) -> float:
    """Return the work done on the indenter, by the trapezoidal rule (eV)."""
    mean_force = 0.5 * (before.normal_force + after.normal_force)
    return mean_force * (before.height - after.height)


def work(before: LoadStep, after: LoadStep) -> float:
    r"""Return the work done on the indenter, with the contact stiffness (eV).

    .. math:: W = \frac{N_1 + N_2}{2} (Z_1 - Z_2) + \frac{k_1 - k_2}{12} (Z_1 - Z_2)^2,

    the integral of the cubic polynomial with the forces and stiffnesses of both states;
    without the second term if a stiffness is not finite.
    """
    change = before.contact_stiffness - after.contact_stiffness
    correction = change * (before.height - after.height) ** 2 / 12.0
    if not np.isfinite(correction):
        correction = 0.0
    return trapezoidal_work(before, after) + correction


def stable_parts(
    states: Sequence[LoadStep], jumps: Sequence[Jump]
) -> list[list[LoadStep]]:
    """Return the states of a branch between its instabilities.

    Parameters
    ----------
    states : sequence of LoadStep
        States of an approach or a retraction, in order.
    jumps : sequence of Jump
        Instabilities of the branch.

    Returns
    -------
    list of list of LoadStep
    """
    unstable = {jump.after.step for jump in jumps}
    parts: list[list[LoadStep]] = [[]]
    for state in states:
        if state.step in unstable:
            parts.append([])
        parts[-1].append(state)
    return parts


def interpolated(
    states: Sequence[LoadStep], jumps: Sequence[Jump] = ()
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return heights, forces and their slopes on a branch, also between its states.

    Parameters
    ----------
    states : sequence of LoadStep
        States of an approach or a retraction, in order.
    jumps : sequence of Jump
        Instabilities of the branch; the forces are not interpolated across them.

    Returns
    -------
    heights, forces, slopes : ndarray, shape (k,)
        Values on cubic polynomials with the forces and contact stiffnesses of the
        states, with differences in place of stiffnesses that are not finite (Å, eV/Å,
        eV/Å^2). Without jumps every `POINTS`-th belongs to a state.
    """
    parts = [_interpolated(part) for part in stable_parts(states, jumps)]
    heights, forces, slopes = np.concatenate(parts, axis=1)
    return heights, forces, slopes


def least_force(before: LoadStep, after: LoadStep) -> tuple[float, float]:
    """Return a height between two states, and a bound for the least force there.

    Parameters
    ----------
    before, after : LoadStep
        Neighbouring states.

    Returns
    -------
    height, force : float
        Intersection of both tangents if the force has a minimum between them, which may
        be a kink (Å, eV/Å); else the minimum of a cubic polynomial.
    """
    height, force, slope = _columns([before, after])
    (share,) = _kinks(height, force, slope)
    if 0.0 < share < 1.0:
        bound = force[0] + share * slope[0] * (height[1] - height[0])
        return float(height[0] + share * (height[1] - height[0])), float(bound)
    heights, forces, _ = _polynomial(height, force, slope)
    least = int(np.argmin(forces))
    return float(heights[least]), float(forces[least])


def _columns(states: Sequence[LoadStep]) -> FloatArray:
    """Return heights, forces and their slopes."""
    rows = [(s.height, s.normal_force, -s.contact_stiffness) for s in states]
    return np.array(rows).T


def _kinks(height: FloatArray, force: FloatArray, slope: FloatArray) -> FloatArray:
    """Return where the tangents of neighbouring states intersect in a minimum.

    That is, the part of the way from the first to the second state, which is below 0 or
    above 1 if they do so elsewhere; NaN if they do not.
    """
    distance, rise = np.diff(height), np.diff(force)
    first, last = slope[:-1] * distance, slope[1:] * distance
    share = np.full(len(distance), np.nan)
    minimum = (first < 0.0) & (last > 0.0)
    return np.divide(last - rise, last - first, out=share, where=minimum)


def _interpolated(states: Sequence[LoadStep]) -> FloatArray:
    """Return heights, forces and slopes between states without an instability.

    The force is not below the tangents at two states and their intersection, as the
    polynomial is where the force has a kink.
    """
    height, force, slope = _columns(states)
    columns = _polynomial(height, force, slope)
    share = np.clip(_kinks(height, force, slope), 0.0, 1.0)
    least = np.nan_to_num(
        force[:-1] + share * slope[:-1] * np.diff(height), nan=-np.inf
    )
    columns[1, :-1] = np.maximum(columns[1, :-1], np.repeat(least, POINTS))
    columns[1, ::POINTS] = force  # without rounding
    return columns


def _polynomial(height: FloatArray, force: FloatArray, slope: FloatArray) -> FloatArray:
    """Return heights, forces and slopes on cubic polynomials."""
    if len(height) == 1:
        return np.array([height, force, np.nan_to_num(slope)])
    slope = np.where(np.isfinite(slope), slope, np.gradient(force, height))
    upward = np.argsort(height)
    curve = CubicHermiteSpline(height[upward], force[upward], slope[upward])
    number = np.arange(len(height))
    between = np.interp(np.arange(POINTS * number[-1] + 1) / POINTS, number, height)
    return np.array([between, curve(between), curve(between, 1)])


def _force_error(*states: LoadStep) -> float:
    """Return the error of the normal force due to the remaining forces on atoms."""
    return max(s.max_force * (s.repulsive_atoms + s.attractive_atoms) for s in states)
