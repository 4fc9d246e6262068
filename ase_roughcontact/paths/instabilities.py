"""Instabilities of an adhesion loop, and the energy that they dissipate.

While a surface stays in its minimum of energy, the work done on the indenter is stored,
``dE = -N dZ``. The energy that is not stored between two states was dissipated when the
surface jumped to another minimum.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ase_roughcontact._util.validation import FloatArray
from ase_roughcontact.paths.record import LoadStep

# Relative rounding of a step.
_ROUNDING = 1e-6
# Points of an interpolated branch between two states.
_POINTS = 32


@dataclass(frozen=True)
class Jump:
    """An instability between two neighbouring states.

    Attributes
    ----------
    before, after : LoadStep
        The last state before the jump, and the first one after it.
    """

    before: LoadStep
    after: LoadStep

    @property
    def height(self) -> float:
        """Height of the indenter, in the middle between the two states (Å)."""
        return 0.5 * (self.before.height + self.after.height)

    @property
    def dissipated_energy(self) -> float:
        """Energy lost in the jump (eV).

        Its error is at most half the change of the force times that of the height, as
        the exact height of the jump is not known.
        """
        return _lost_energy(self.before, self.after, trapezoidal_work)


@dataclass(frozen=True)
class AdhesionLoop:
    """Result of `adhesion_loop`: states and instabilities of approach and retraction.

    Attributes
    ----------
    approach, retraction : tuple of LoadStep
        The states from beyond the range of the wall to the deepest one, and from there
        until nothing acts on the indenter.
    approach_jumps, retraction_jumps : tuple of Jump
        The instabilities on either branch.
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
            Of the whole loop, in order.
        smallest_step : float
            Of the loop (Å); 1/256 of the largest one by default.

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
        branches = tuple(states[: deepest + 1]), tuple(states[deepest:])
        widest = (1.0 + _ROUNDING) * smallest_step
        jumps = (
            tuple(
                Jump(before, after)
                for before, after in pairwise(branch)
                if abs(after.height - before.height) <= widest and jumped(before, after)
            )
            for branch in branches
        )
        return cls(*branches, *jumps)

    @property
    def pull_off_force(self) -> float:
        """Largest tension during retraction, zero without any (eV/Å).

        Between the states the force is interpolated with their contact stiffness.
        """
        if min(state.normal_force for state in self.retraction) >= 0.0:
            return 0.0
        _, force = interpolated(self.retraction, self.retraction_jumps)
        return -float(force.min())

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
        branches = (
            (self.approach, self.approach_jumps),
            (self.retraction, self.retraction_jumps),
        )
        total = 0.0
        for states, jumps in branches:
            unstable = {jump.after.step for jump in jumps}
            for before, after in pairwise(states):
                jump = after.step in unstable
                total += (trapezoidal_work if jump else work)(before, after)
        return total

    @property
    def energy_lost_in_jumps(self) -> float:
        """Energy lost in the jumps; all that is dissipated, if none was missed (eV)."""
        jumps = (*self.approach_jumps, *self.retraction_jumps)
        return sum(jump.dissipated_energy for jump in jumps)


def balanced(
    before: LoadStep, after: LoadStep, tolerance: float, smallest_force: float
) -> bool:
    """Return whether the work between two states was stored, within a tolerance.

    Parameters
    ----------
    before, after : LoadStep
        Neighbouring states.
    tolerance : float
        Relative to the larger normal force.
    smallest_force : float
        To which the tolerance is relative where the normal force is smaller (eV/Å).

    Returns
    -------
    bool
        False also if the second state has not converged.
    """
    force = max(abs(before.normal_force), abs(after.normal_force), smallest_force)
    allowed = tolerance * force + _force_error(before, after)
    distance = abs(after.height - before.height)
    return after.converged and abs(_lost_energy(before, after)) <= allowed * distance


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
    change = abs(after.normal_force - before.normal_force)
    explained = 0.5 * change + _force_error(before, after)
    lost = _lost_energy(before, after, trapezoidal_work)
    return lost > explained * abs(after.height - before.height)


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
    return trapezoidal_work(before, after) + (
        correction if np.isfinite(correction) else 0.0
    )


def interpolated(
    states: Sequence[LoadStep], jumps: Sequence[Jump]
) -> tuple[FloatArray, FloatArray]:
    """Return heights and forces on a branch, also between its states.

    Parameters
    ----------
    states : sequence of LoadStep
        Of an approach or a retraction, in order.
    jumps : sequence of Jump
        Its instabilities, across which nothing is interpolated.

    Returns
    -------
    heights, forces : ndarray, shape (k,)
        On cubic polynomials with the forces and contact stiffnesses of the states;
        straight lines where a stiffness is not finite (Å, eV/Å).
    """
    unstable = {jump.after.step for jump in jumps}
    t = np.arange(1, _POINTS + 1) / _POINTS
    heights = [np.array([states[0].height])]
    forces = [np.array([states[0].normal_force])]
    for before, after in pairwise(states):
        if after.step in unstable:
            heights.append(np.array([after.height]))
            forces.append(np.array([after.normal_force]))
            continue
        step = after.height - before.height
        rise = after.normal_force - before.normal_force
        slopes = np.array([before.contact_stiffness, after.contact_stiffness]) * -step
        first, last = slopes if np.isfinite(slopes).all() else (rise, rise)
        heights.append(before.height + step * t)
        bend = t * (1 - t) * ((first - rise) * (1 - t) - (last - rise) * t)
        forces.append(before.normal_force + rise * t + bend)
    return np.concatenate(heights), np.concatenate(forces)


def _lost_energy(
    before: LoadStep,
    after: LoadStep,
    work: Callable[[LoadStep, LoadStep], float] = work,
) -> float:
    """Return the work that was not stored; without a jump, an error of integration."""
    return work(before, after) - (after.energy - before.energy)


def _force_error(*states: LoadStep) -> float:
    """Return the error of the normal force due to the remaining forces on atoms."""
    return max(s.max_force * (s.repulsive_atoms + s.attractive_atoms) for s in states)
