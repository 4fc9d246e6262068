"""Instabilities of an adhesion loop, and the energy that they dissipate.

While a surface stays in its minimum of energy, the work done on the indenter is stored,
``dE = -N dZ``. The energy that is not stored between two states was dissipated when the
surface jumped to another minimum.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ase_roughcontact.paths.record import LoadStep


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
        return _lost_energy(self.before, self.after)


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

    @property
    def pull_off_force(self) -> float:
        """Largest tension during retraction, zero without any (eV/Å)."""
        return max(0.0, -min(state.normal_force for state in self.retraction))

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
        states = (*self.approach, *self.retraction)
        return sum(map(_work, states, states[1:]))

    @property
    def energy_lost_in_jumps(self) -> float:
        """Energy lost in the jumps; all that is dissipated, if none was missed (eV)."""
        jumps = (*self.approach_jumps, *self.retraction_jumps)
        return sum(jump.dissipated_energy for jump in jumps)


def zero_load_area(records: Sequence[LoadStep]) -> float:
    """Interpolate the contact area at zero force of an approach or a retraction.

    Parameters
    ----------
    records : sequence of LoadStep
        The states of one branch, in any order.

    Returns
    -------
    float
        Area where the force, from the deepest state upwards, first falls to zero (Å^2).
        It is linear in the force between the states.

    Raises
    ------
    ValueError
        If the force does not change its sign, or is not positive at the deepest state.
    """
    upward = sorted(records, key=lambda state: state.height)
    forces = [state.normal_force for state in upward]
    first = next((i for i, force in enumerate(forces) if force <= 0.0), None)
    if not first:
        raise ValueError(
            "the area at zero force needs states on both sides of it, got forces "
            f"from {min(forces, default=np.nan):g} to {max(forces, default=np.nan):g} "
            f"and {forces[0] if forces else np.nan:g} at the lowest height"
        )
    below, above = upward[first - 1], upward[first]
    share = below.normal_force / (below.normal_force - above.normal_force)
    return below.contact_area + share * (above.contact_area - below.contact_area)


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
    return _lost_energy(before, after) > explained * abs(after.height - before.height)


def _lost_energy(before: LoadStep, after: LoadStep) -> float:
    """Return the work that was not stored; without a jump, an error of integration."""
    return _work(before, after) - (after.energy - before.energy)


def _work(before: LoadStep, after: LoadStep) -> float:
    """Return the work done on the indenter, by the trapezoidal rule."""
    mean_force = 0.5 * (before.normal_force + after.normal_force)
    return mean_force * (before.height - after.height)


def _force_error(*states: LoadStep) -> float:
    """Return the error of the normal force due to the remaining forces on atoms."""
    return max(s.max_force * (s.repulsive_atoms + s.attractive_atoms) for s in states)
