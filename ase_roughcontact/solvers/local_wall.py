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

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ase_roughcontact._util.kernels import dot, max_abs
from ase_roughcontact.contact import Contact
from ase_roughcontact.interactions import Interaction, scaled_attraction
from ase_roughcontact.interactions.base import Profile

# Stiffness D of the augmented Lagrangian times the self-compliance of an atom.
_STIFFNESS = 5.0
# The same at least in units of the negative stiffness of the attraction at contact,
# without which the constrained minimum would not be one of the augmented Lagrangian.
_CURVATURES = 3.0


@dataclass(frozen=True, eq=False)
class LinearWall:
    """Wall at a pressure ``q`` and gaps ``g``, and its stiffness there.

    Attributes
    ----------
    active : ndarray of bool, shape (n, m)
        Where the wall is in range or the pressure is not zero.
    residual, stiffness : ndarray, shape (n, m)
        ``p - q`` with the pressure p of the wall, and ``V''``.
    energy, magnitude : float
        Sums of ``V`` and of the magnitudes of its terms.
    force : float
        Sum of the pressures ``p(g)``.
    error : float
        Largest ``|p(g) - q|``.
    norm : float
        Norm of the scaled residual; infinite if the wall is linearised at the gaps.
    """

    active: np.ndarray
    residual: np.ndarray
    stiffness: np.ndarray
    energy: float
    magnitude: float
    force: float
    error: float
    norm: float = math.inf


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
    compliance : float
        Self-compliance of an atom (length per pressure).
    stiffness : float
        D of a hard wall (pressure per length); zero for others.
    reaction : ndarray, shape (n, m), or None
        lambda (pressure); None stands for zero.
    """

    interaction: Interaction
    heights: np.ndarray
    adhesion: np.ndarray | None
    compliance: float
    stiffness: float
    reaction: np.ndarray | None = None

    @classmethod
    def of(cls, contact: Contact) -> LocalWall:
        """Return the wall of a contact."""
        wall, compliance = contact.interaction, contact.halfspace.self_compliance
        stiffness = 0.0
        if wall.hard:
            factor = 1.0 if contact.adhesion is None else float(contact.adhesion.max())
            curvature = -factor * float(wall.evaluate(np.zeros(1))[2][0])
            stiffness = max(_STIFFNESS / compliance, _CURVATURES * curvature)
        return cls(wall, contact.heights, contact.adhesion, compliance, stiffness)

    def with_reaction(
        self, pressure: np.ndarray, opening: np.ndarray, height: float
    ) -> LocalWall:
        """Return the hard wall whose reaction balances a pressure.

        That is ``max(q - p_a, 0)``, with the attraction ``p_a`` at ``max(g, 0)``.

        Parameters
        ----------
        pressure : ndarray, shape (n, m)
            Elastic pressure.
        opening : ndarray, shape (n, m)
            Opening of the gap that it causes.
        height : float
            Of the indenter.
        """
        gap = np.maximum(self._gap(opening, height), 0.0)
        attraction = scaled_attraction(self.interaction, gap, self.adhesion)[1]
        return replace(self, reaction=np.maximum(pressure - attraction, 0.0))

    def updated(self, opening: np.ndarray, height: float) -> tuple[LocalWall, float]:
        """Update the reaction to ``max(lambda - D g, 0)``.

        Returns
        -------
        wall : LocalWall
        violation : float
            Largest overlap, or gap of an atom under a reaction (length).
        """
        assert self.reaction is not None
        reaction = self.reaction - self.stiffness * self._gap(opening, height)
        np.maximum(reaction, 0.0, out=reaction)
        change = max_abs(reaction - self.reaction)
        return replace(self, reaction=reaction), change / self.stiffness

    def at_gaps(
        self, pressure: np.ndarray, opening: np.ndarray, height: float
    ) -> LinearWall:
        """Return the wall, linearised at the gaps."""
        active, near, gap = self._near(pressure, opening, height)
        energy, repulsion, local = self._profile(gap, *self._fields(near))
        residual, stiffness = np.zeros((2, *active.shape))
        residual.put(near, repulsion - pressure.take(near))
        stiffness.put(near, local)
        return LinearWall(
            active,
            residual,
            stiffness,
            energy=float(energy.sum()) + self._constant,
            magnitude=float(abs(energy).sum()) - self._constant,
            force=float(repulsion.sum()),
            error=max_abs(residual),
        )

    def at_pressures(
        self, pressure: np.ndarray, opening: np.ndarray, height: float
    ) -> LinearWall:
        """Return the wall, linearised at the gaps w at which ``p = max(q, 0)``.

        The residual is ``p + D (w - g) - q``. Where ``p + min(D, 1/c) (w - g) < 0``,
        with the self-compliance c, the wall loses contact: ``r = -q`` and ``D = 0``.
        The norm is that of ``r / sqrt(1 + c D)``.
        """
        active, near, g = self._near(pressure, opening, height)
        q = pressure.take(near)
        energy, now, _ = self._profile(g, None, None)
        w, r, d = self.interaction.inverse(np.maximum(q, 0.0))
        w -= g
        held = r + np.minimum(d, 1.0 / self.compliance) * w > 0.0
        d *= held
        r += w * d
        r *= held
        r -= q
        residual, stiffness = np.zeros((2, *active.shape))
        residual.put(near, r)
        stiffness.put(near, d)
        stored = float(energy.sum())
        return LinearWall(
            active,
            residual,
            stiffness,
            energy=stored,
            magnitude=stored,
            force=float(now.sum()),
            error=float(abs(now - q).max(initial=0.0)),
            norm=dot(r / (1.0 + self.compliance * d), r) ** 0.5,
        )

    def force(self, shape: np.ndarray, height: float) -> float:
        """Return the sum of ``p`` at the gaps ``Z + shape``."""
        near = np.flatnonzero(shape < self.interaction.cutoff - height)
        gap = height + shape.take(near)
        return float(self._profile(gap, *self._fields(near))[1].sum())

    @cached_property
    def _constant(self) -> float:
        """Part of the energy that does not depend on gaps, minus sum lambda^2/2D."""
        if self.reaction is None:
            return 0.0
        return -dot(self.reaction, self.reaction) / (2.0 * self.stiffness)

    def _gap(self, opening: np.ndarray, height: float) -> np.ndarray:
        gap = self.heights + opening
        gap += height
        return gap

    def _near(
        self, pressure: np.ndarray, opening: np.ndarray, height: float
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return where the wall is in range or the pressure is not zero.

        Returns
        -------
        active : ndarray of bool, shape (n, m)
        near : ndarray of int, shape (k,)
            Indices of these atoms in the flat window.
        gap : ndarray, shape (k,)
        """
        gap = self._gap(opening, height)
        active = gap < self.interaction.cutoff
        active |= pressure != 0.0
        near = np.flatnonzero(active)
        return active, near, gap.take(near)

    def _fields(self, atoms: np.ndarray) -> list[np.ndarray | None]:
        """Return local adhesion and reaction of some atoms."""
        fields = self.adhesion, self.reaction
        return [None if field is None else field.take(atoms) for field in fields]

    def _profile(
        self, gap: np.ndarray, adhesion: np.ndarray | None, reaction: np.ndarray | None
    ) -> Profile:
        """Return energy, without its constant, pressure and stiffness at atoms."""
        if not gap.size:
            return gap, gap, gap
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
