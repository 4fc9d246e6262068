"""What a loop of approach and retraction tells: jumps, and the energy they cost.

While a surface stays in its minimum of energy, the work done on the indenter is all
stored, ``dE = -N dZ``. What is not stored between two states was lost in a jump.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ase_roughcontact._util.validation import positive
from ase_roughcontact.paths.record import LoadStep


@dataclass(frozen=True)
class Jump:
    """An instability, between two states at neighbouring heights.

    Attributes
    ----------
    before, after : LoadStep
        The last state on this side of the jump, and the first one beyond.
    """

    before: LoadStep
    after: LoadStep

    @property
    def height(self) -> float:
        """Height of the indenter, the middle of the bracket (Å)."""
        return 0.5 * (self.before.height + self.after.height)

    @property
    def dissipated_energy(self) -> float:
        """Energy that was lost (eV).

        Where in the bracket the force changed is not known: the error is at most half
        of that change times the width of the bracket.
        """
        return lost_energy(self.before, self.after)


@dataclass(frozen=True)
class AdhesionLoop:
    """A contact made and parted.

    Attributes
    ----------
    approach, retraction : tuple of LoadStep
        The states on the way down, from out of reach to the deepest one, and on the way
        up, until nothing acts on the indenter any more.
    approach_jumps, retraction_jumps : tuple of Jump
        The instabilities found on either way.
    """

    approach: tuple[LoadStep, ...]
    retraction: tuple[LoadStep, ...]
    approach_jumps: tuple[Jump, ...]
    retraction_jumps: tuple[Jump, ...]

    @property
    def pull_off_force(self) -> float:
        """Largest tension on the way up, zero without any (eV/Å)."""
        return max(0.0, -min(record.normal_force for record in self.retraction))

    @property
    def jump_in(self) -> float | None:
        """Height of the first jump on the way down, None without one (Å)."""
        return self.approach_jumps[0].height if self.approach_jumps else None

    @property
    def jump_out(self) -> float | None:
        """Height of the last jump on the way up, None without one (Å)."""
        return self.retraction_jumps[-1].height if self.retraction_jumps else None

    @property
    def dissipated_energy(self) -> float:
        r"""Area of the loop of force against height, :math:`-\oint N\,dZ` (eV)."""
        records = (*self.approach, *self.retraction)
        return sum(map(_work, records, records[1:]))

    @property
    def energy_lost_in_jumps(self) -> float:
        """Energy lost in the jumps, which is all of it if none was overlooked (eV)."""
        jumps = (*self.approach_jumps, *self.retraction_jumps)
        return sum(jump.dissipated_energy for jump in jumps)


def zero_load_area(records: Sequence[LoadStep]) -> float:
    """Contact area at zero force, between the states of an approach or a retraction.

    Parameters
    ----------
    records : sequence of LoadStep
        Of one way down or up, in any order.

    Returns
    -------
    float
        Area, interpolated linearly in the force where it falls to zero on the way up
        from the deepest state (Å^2).

    Raises
    ------
    ValueError
        If the force does not change its sign, or does not come down to zero.
    """
    upward = sorted(records, key=lambda record: record.height)
    forces = [record.normal_force for record in upward]
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


def low_load_area(records: Iterable[LoadStep], largest_load: float) -> float:
    """Area A_adh that an adhesive first asperity keeps while the load is low.

    Parameters
    ----------
    records : iterable of LoadStep
        Of one realisation of the roughness, on one way.
    largest_load : float
        End of the low loads (eV/Å).

    Returns
    -------
    float
        Constant nearest, by least squares of the logarithm, to the areas at forces
        above zero and up to `largest_load` (Å^2).

    Raises
    ------
    ValueError
        If `largest_load` is not above zero, or no atom touches at such a force.

    References
    ----------
    L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016): A_adh, Fig. 2(c).
    """
    positive(largest_load=largest_load)
    areas = [
        record.contact_area
        for record in records
        if 0.0 < record.normal_force <= largest_load and record.contact_area > 0.0
    ]
    if not areas:
        raise ValueError(f"no state in contact has a force from 0 to {largest_load:g}")
    return float(np.exp(np.mean(np.log(areas))))


def lost_energy(before: LoadStep, after: LoadStep) -> float:
    """Work between two states that was not stored.

    Parameters
    ----------
    before, after : LoadStep
        In the order in which they were passed.

    Returns
    -------
    float
        Zero but for the error of the trapezoid where nothing jumped (eV).
    """
    return _work(before, after) - (after.energy - before.energy)


def jumped(before: LoadStep, after: LoadStep) -> bool:
    """Whether more was lost than any force between the two states explains.

    Parameters
    ----------
    before, after : LoadStep
        Neighbours, in the order in which they were passed.

    Returns
    -------
    bool
    """
    change = abs(after.normal_force - before.normal_force)
    explained = 0.5 * change + force_error(before, after)
    return lost_energy(before, after) > explained * abs(after.height - before.height)


def force_error(*records: LoadStep) -> float:
    """Error of a normal force while every acting atom may miss its equilibrium.

    Parameters
    ----------
    *records : LoadStep
        States of which the largest error counts.

    Returns
    -------
    float
        Largest force left times the number of atoms that the wall acts on (eV/Å).
    """
    return max(r.max_force * (r.repulsive_atoms + r.attractive_atoms) for r in records)


def _work(before: LoadStep, after: LoadStep) -> float:
    """Work done on the indenter between two states, by the trapezoid."""
    mean_force = 0.5 * (before.normal_force + after.normal_force)
    return mean_force * (before.height - after.height)
