r"""The wall at every atom of a window, with the constraint of a hard wall.

A hard wall with attraction is a constraint, :math:`g \ge 0`, on top of the function
:math:`V(g)` of its attraction. The constraint is treated by an augmented Lagrangian:
with the reaction :math:`\lambda` at every atom and a stiffness :math:`D`, the energy

.. math:: V(g) + \frac{\max(\lambda - D g, 0)^2 - \lambda^2}{2 D}

is a function of the gap with the pressure :math:`-V' + \max(\lambda - D g, 0)`. Its
minimum is that of the constrained problem if
:math:`\lambda = \max(\lambda - D g, 0)`, which is also how :math:`\lambda` is updated
after a minimisation (method of multipliers).

References
----------
D. P. Bertsekas, Constrained Optimization and Lagrange Multiplier Methods (1982), Ch. 3.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ase_roughcontact._util.kernels import concatenate, dot, inner, rowwise
from ase_roughcontact.contact import Contact
from ase_roughcontact.interactions import Interaction, scaled_attraction
from ase_roughcontact.interactions.base import Profile

# Stiffness D of the augmented Lagrangian times the self-compliance of an atom.
_STIFFNESS = 5.0
# The same at least in units of the negative stiffness of the attraction at contact,
# without which the constrained minimum would not be one of the augmented Lagrangian.
_CURVATURES = 3.0


@dataclass(frozen=True, eq=False)
class LocalWall:
    """Wall at every atom of a window.

    Attributes
    ----------
    interaction : Interaction
    heights : ndarray, shape (n, m)
        Of the indenter.
    adhesion : ndarray, shape (n, m), or None
        Local work of adhesion relative to that of the wall.
    stiffness : float
        D of a hard wall (pressure per length); zero for others.
    reaction : ndarray, shape (n, m), or None
        lambda (pressure); None stands for zero.
    """

    interaction: Interaction
    heights: np.ndarray
    adhesion: np.ndarray | None
    stiffness: float
    reaction: np.ndarray | None = None

    @classmethod
    def of(cls, contact: Contact) -> LocalWall:
        """Return the wall of a contact."""
        wall = contact.interaction
        stiffness = 0.0
        if wall.hard:
            factor = 1.0 if contact.adhesion is None else float(contact.adhesion.max())
            curvature = -factor * float(wall.evaluate(np.zeros(1))[2][0])
            stiffness = _STIFFNESS / contact.halfspace.self_compliance
            stiffness = max(stiffness, _CURVATURES * curvature)
        return cls(wall, contact.heights, contact.adhesion, stiffness)

    @property
    def attractive(self) -> bool:
        """Whether the wall is attractive at any gap."""
        return self.interaction.attractive

    @property
    def cutoff(self) -> float:
        """Gap beyond which the wall is zero."""
        return self.interaction.cutoff

    def with_reaction(
        self, pressure: np.ndarray, opening: np.ndarray, height: float
    ) -> LocalWall:
        """Return the hard wall whose reaction balances a pressure.

        Parameters
        ----------
        pressure : ndarray, shape (n, m)
            Elastic pressure.
        opening : ndarray, shape (n, m)
            Opening of the gap that it causes.
        height : float
            Of the indenter.
        """
        reaction = np.empty(opening.shape)
        _set_reaction(
            reaction, pressure, opening, self.heights, height, self.adhesion, self
        )
        return replace(self, reaction=reaction)

    def updated(self, opening: np.ndarray, height: float) -> tuple[LocalWall, float]:
        """Update the reaction.

        Returns
        -------
        wall : LocalWall
        violation : float
            Largest overlap, or gap of an atom under a reaction (length).
        """
        assert self.reaction is not None
        reaction = np.empty(opening.shape)
        change = _update(
            reaction, self.reaction, opening, self.heights, height, self.stiffness
        )
        return replace(self, reaction=reaction), change / self.stiffness

    @cached_property
    def _constant(self) -> float:
        """Part of the energy that does not depend on gaps, minus sum lambda^2/2D."""
        if self.reaction is None:
            return 0.0
        return -dot(self.reaction, self.reaction) / (2.0 * self.stiffness)

    def evaluate(
        self,
        residual: np.ndarray,
        stiffness: np.ndarray,
        active: np.ndarray,
        pressure: np.ndarray,
        opening: np.ndarray,
        height: float,
    ) -> tuple[float, float, float]:
        """Set ``r = p - q`` and ``V''``; return the sums of ``V``, ``|V|`` and ``p``.

        `active` is set where the wall is in range or the pressure is not zero.
        """
        stored, magnitude, pushed = _evaluate(
            residual,
            stiffness,
            active,
            pressure,
            opening,
            self.heights,
            self.adhesion,
            self.reaction,
            height,
            self,
        )
        return stored + self._constant, magnitude - self._constant, pushed

    def force(self, shape: np.ndarray, height: float) -> float:
        """Return the sum of ``p`` at the gaps ``Z + shape``."""
        near = shape < self.cutoff - height
        adhesion, reaction = _selected(self.adhesion, self.reaction, near)
        return float(self._local(height + shape[near], adhesion, reaction)[1].sum())

    def along(
        self,
        opening: np.ndarray,
        height: float,
        change: np.ndarray,
        height_change: float,
    ) -> Callable[[float], tuple[float, float]]:
        """Return ``sum V(g + t dg) - V(g)`` and ``sum p(g + t dg) dg`` of t."""
        gap, gap_change, adhesion, reaction, start = _reached_atoms(
            opening,
            self.heights,
            self.adhesion,
            self.reaction,
            height,
            change,
            height_change,
            self,
        )
        local = None if self.adhesion is None else adhesion
        core = None if self.reaction is None else reaction

        def rise_and_work(t: float) -> tuple[float, float]:
            return _along(gap, gap_change, local, core, start, t, self)

        return rise_and_work

    def _local(
        self, gap: np.ndarray, adhesion: np.ndarray | None, reaction: np.ndarray | None
    ) -> Profile:
        """Return energy, without its constant, pressure and stiffness at atoms."""
        profile = scaled_attraction(self.interaction, gap, adhesion)
        if not self.stiffness:
            return profile
        energy, pressure, stiffness = profile
        core = -self.stiffness * gap
        if reaction is not None:
            core += reaction
        np.maximum(core, 0.0, out=core)
        return (
            energy + core**2 / (2.0 * self.stiffness),
            pressure + core,
            np.where(core > 0.0, self.stiffness, stiffness),
        )


def _selected(
    adhesion: np.ndarray | None, reaction: np.ndarray | None, mask: np.ndarray
) -> list[np.ndarray | None]:
    return [None if field is None else field[mask] for field in (adhesion, reaction)]


@rowwise(np.add)
def _evaluate(
    residual: np.ndarray,
    stiffness: np.ndarray,
    active: np.ndarray,
    pressure: np.ndarray,
    opening: np.ndarray,
    heights: np.ndarray,
    adhesion: np.ndarray | None,
    reaction: np.ndarray | None,
    height: float,
    wall: LocalWall,
) -> tuple[float, float, float]:
    """See `LocalWall.evaluate`."""
    gap = heights + opening
    gap += height
    np.less(gap, wall.cutoff, out=active)
    active |= pressure != 0.0
    residual[:] = stiffness[:] = 0.0
    if not active.any():
        return 0.0, 0.0, 0.0
    energy, repulsion, stiffness[active] = wall._local(
        gap[active], *_selected(adhesion, reaction, active)
    )
    residual[active] = repulsion
    residual -= pressure
    return float(energy.sum()), float(abs(energy).sum()), float(repulsion.sum())


@rowwise(concatenate)
def _reached_atoms(
    opening: np.ndarray,
    heights: np.ndarray,
    adhesion: np.ndarray | None,
    reaction: np.ndarray | None,
    height: float,
    change: np.ndarray,
    height_change: float,
    wall: LocalWall,
) -> tuple[np.ndarray, ...]:
    """Return fields and ``V(g)`` of the atoms that are in range on the way."""
    gap = heights + opening
    gap += height
    gap_change = change + height_change
    reached = gap + np.minimum(gap_change, 0.0) < wall.cutoff
    gap, gap_change = gap[reached], gap_change[reached]
    fields = _selected(adhesion, reaction, reached)
    energy = wall._local(gap, *fields)[0] if gap.size else gap
    local, core = (gap if field is None else field for field in fields)
    return gap, gap_change, local, core, energy


@rowwise(np.add)
def _along(
    gap: np.ndarray,
    change: np.ndarray,
    adhesion: np.ndarray | None,
    reaction: np.ndarray | None,
    start: np.ndarray,
    t: float,
    wall: LocalWall,
) -> tuple[float, float]:
    """See `LocalWall.along`."""
    if not gap.size:
        return 0.0, 0.0
    energy, repulsion, _ = wall._local(gap + t * change, adhesion, reaction)
    return float((energy - start).sum()), inner(repulsion, change)


@rowwise()
def _set_reaction(
    reaction: np.ndarray,
    pressure: np.ndarray,
    opening: np.ndarray,
    heights: np.ndarray,
    height: float,
    adhesion: np.ndarray | None,
    wall: LocalWall,
) -> None:
    """Set ``lambda = max(q - p_a(max(g, 0)), 0)``, p_a the attraction."""
    gap = heights + opening
    gap += height
    np.maximum(gap, 0.0, out=gap)
    attraction = scaled_attraction(wall.interaction, gap, adhesion)[1]
    np.maximum(pressure - attraction, 0.0, out=reaction)


@rowwise(np.maximum)
def _update(
    new: np.ndarray,
    old: np.ndarray,
    opening: np.ndarray,
    heights: np.ndarray,
    height: float,
    stiffness: float,
) -> float:
    """Set ``lambda = max(lambda - D g, 0)``; return the largest change."""
    gap = heights + opening
    gap += height
    np.maximum(old - stiffness * gap, 0.0, out=new)
    return float(abs(new - old).max())
