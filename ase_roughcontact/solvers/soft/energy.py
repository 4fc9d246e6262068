r"""Energy of a contact with a soft wall, as a function of pressure and height.

With the elastic pressure :math:`q` on the window, the Green's function :math:`G` of the
half space, the height :math:`Z` of the indenter, its surface :math:`h` and the gap
:math:`g = Z + h + G q`,

.. math:: E(q, Z) = a_0^2 \left[\tfrac12 \sum q\, G q + \sum V(g)\right] + U(Z)

has the gradient :math:`-a_0^2 G r` in :math:`q`, with the residual :math:`r = p - q`
and the pressure :math:`p = -V'(g)` of the wall, and :math:`-(a_0^2 \sum p + F)` in
:math:`Z`, with the force :math:`F = -U'` of load and springs on the indenter.

A hard wall with attraction is a constraint, :math:`g \ge 0`, on top of the function
:math:`V(g)` of its attraction. The constraint is treated by an augmented Lagrangian:
with the reaction :math:`\lambda` at every atom and a stiffness :math:`D`,

.. math:: V(g) + \frac{\max(\lambda - D g, 0)^2 - \lambda^2}{2 D}

replaces :math:`V`; the pressure is :math:`-V' + \max(\lambda - D g, 0)`. The minimum
solves the constrained problem if :math:`\lambda = \max(\lambda - D g, 0)`. By the same
equation :math:`\lambda` is updated after a minimisation (method of multipliers).

References
----------
D. P. Bertsekas, Constrained Optimization and Lagrange Multiplier Methods (1982), Ch. 3.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ase_roughcontact._util.kernels import (
    dot,
    dots,
    linear_combination,
    max_abs,
    scale,
    total,
)
from ase_roughcontact.contact import Contact
from ase_roughcontact.contact.support import Support
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.interactions import Interaction, scaled_attraction
from ase_roughcontact.interactions.base import Profile

# Rounding error of an energy, relative to the sum of the magnitudes of its terms.
_ENERGY_ROUNDING = 1e-14
# Stiffness D of the augmented Lagrangian times the self-compliance of an atom.
_RELATIVE_STIFFNESS = 5.0
# Smallest stiffness D, in units of the negative stiffness of the attraction at contact,
# for which the constrained minimum is also a minimum of the augmented Lagrangian.
_MIN_STIFFNESS_RATIO = 3.0


@dataclass(frozen=True, eq=False)
class ContactEnergy:
    """Energy of a contact and its gradient.

    Attributes
    ----------
    contact : Contact
        Contact with a soft wall, or a hard one with attraction.
    support : Support
        Load and springs on the indenter.
    stiffness : float
        Stiffness D for a hard wall (pressure per length); zero for other walls.
    reaction : ndarray, shape (n, m), or None
        Reaction lambda (pressure); None stands for zero.
    inverse : bool
        Whether the wall, which must have an inverse, is linearised at the gaps at which
        it has the pressures ``q``; by default it is linearised at the present gaps.
    """

    contact: Contact
    support: Support
    stiffness: float = 0.0
    reaction: np.ndarray | None = None
    inverse: bool = False

    @classmethod
    def of(cls, contact: Contact, support: Support) -> ContactEnergy:
        """Return the energy without a reaction, with the wall's inverse if known."""
        wall, stiffness = contact.wall, 0.0
        if wall.hard:
            factor = 1.0 if contact.adhesion is None else float(contact.adhesion.max())
            curvature = -factor * float(wall.evaluate(np.zeros(1))[2][0])
            least = _RELATIVE_STIFFNESS / contact.halfspace.self_compliance
            stiffness = max(least, _MIN_STIFFNESS_RATIO * curvature)
        return cls(contact, support, stiffness, inverse=wall.invertible)

    @property
    def wall(self) -> Interaction:
        """Wall of the contact."""
        return self.contact.wall

    @cached_property
    def area(self) -> float:
        """Area of an atom."""
        return self.contact.halfspace.cell_area

    def external(self, height: float) -> tuple[float, float]:
        """Return energy and upward force of load and springs on a free indenter."""
        return (0.0, 0.0) if self.support.fixed else self.support.external(height)

    def opening(self, pressure: np.ndarray) -> np.ndarray:
        """Return ``G q``, the opening of the gap by a pressure: one convolution."""
        displacement = self.contact.halfspace.displacement(pressure)
        scale(displacement, displacement, -1.0)
        return displacement

    def with_reaction(self, state: EnergyState) -> ContactEnergy:
        """Return the energy with the reaction of a hard wall that balances a pressure.

        The reaction is ``max(q - p_a, 0)`` with the attraction ``p_a`` at
        ``max(g, 0)``.
        """
        gap = np.maximum(state.gap(), 0.0)
        attraction = scaled_attraction(self.wall, gap, self.contact.adhesion)[1]
        return replace(self, reaction=np.maximum(state.pressure - attraction, 0.0))

    def updated(self, state: EnergyState) -> tuple[ContactEnergy, float]:
        """Return the energy with the reaction of a hard wall ``max(lambda - D g, 0)``.

        Returns
        -------
        energy : ContactEnergy
            Energy with the updated reaction.
        violation : float
            Largest violation of the constraint (length): overlap, or gap of an atom
            under a reaction; zero without reactions.
        """
        if self.reaction is None:
            return self, 0.0
        reaction = np.maximum(self.reaction - self.stiffness * state.gap(), 0.0)
        change = max_abs(reaction - self.reaction)
        return replace(self, reaction=reaction), change / self.stiffness

    def wall_force(self, shape: np.ndarray, height: float) -> float:
        """Return the force of the wall at the gaps ``Z + shape``."""
        near = np.flatnonzero(shape < self.wall.cutoff - height)
        pressure = self.profile(height + shape.take(near), near)[1]
        return self.area * float(pressure.sum())

    def spring_stiffness(self, height: float) -> float:
        """Return the stiffness of the springs, by a difference of forces."""
        d = 1e-4 * self.contact.halfspace.spacing
        difference = self.external(height - d)[1] - self.external(height + d)[1]
        return max(difference / (2.0 * d), 0.0)

    @cached_property
    def constant(self) -> float:
        """Sum of ``lambda^2/2D`` over all atoms."""
        if self.reaction is None:
            return 0.0
        return dot(self.reaction, self.reaction) / (2.0 * self.stiffness)

    def profile(self, gap: np.ndarray, atoms: np.ndarray) -> Profile:
        """Return energy, without its constant, pressure and stiffness of some atoms."""
        if not gap.size:
            return gap, gap, gap
        adhesion = self.contact.adhesion
        factor = None if adhesion is None else adhesion.take(atoms)
        profile = scaled_attraction(self.wall, gap, factor)
        if not self.wall.hard:
            return profile
        energy, pressure, stiffness = profile
        core = -self.stiffness * gap
        if self.reaction is not None:
            core += self.reaction.take(atoms)
        np.maximum(core, 0.0, out=core)
        return (
            energy + core**2 / (2.0 * self.stiffness),
            pressure + core,
            np.where(core > 0.0, self.stiffness, stiffness),
        )

    def linearised_at(
        self, q: np.ndarray, g: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, float]:
        """Return residual, stiffness and norm of a wall linearised at its pressures.

        With the gaps w at which ``p = max(q, 0)``, the residual is
        ``p + D (w - g) - q``. Where ``p + min(D, 1/c) (w - g) < 0``, with the
        self-compliance c, the wall loses contact: ``r = -q`` and ``D = 0``. The norm is
        the norm of ``r / sqrt(1 + c D)``.
        """
        compliance = self.contact.halfspace.self_compliance
        w, r, d = self.wall.inverse(np.maximum(q, 0.0))
        w -= g
        held = r + np.minimum(d, 1.0 / compliance) * w > 0.0
        d *= held
        r += w * d
        r *= held
        r -= q
        return r, d, dot(r / (1.0 + compliance * d), r) ** 0.5


class EnergyState:
    """Energy and gradient at a pressure and a height.

    Parameters
    ----------
    function : ContactEnergy
        Energy as a function of pressure and height.
    pressure : ndarray, shape (n, m)
        Elastic pressure ``q`` (pressure).
    height : float
        Height of the indenter (length).
    opening : ndarray, shape (n, m), optional
        Opening ``G q`` (length), see `ContactEnergy.opening`; by default it is
        calculated.
    exact : bool
        Whether a given opening comes from a convolution of this pressure.

    Attributes
    ----------
    pressure, opening : ndarray, shape (n, m)
        Elastic pressure ``q`` and the opening ``G q`` of the gap (length).
    height : float
        Height of the indenter (length).
    exact : bool
        Whether the opening comes from a convolution of this pressure.
    box : Box
        Bounding box of the atoms in range of the wall or under pressure, with at least
        one atom.
    stiffness, residual : ndarray, shape (n, m)
        Stiffness ``V''`` of the wall and residual ``p - q``.
    load_residual : float
        Upward force on the indenter; zero if the height is fixed.
    linear_load_residual : float
        Upward force on the indenter with the pressure ``q + r`` of the wall as it is
        linearised; see `ContactEnergy.inverse`. It is `load_residual` without the
        inverse of a wall.
    surface_error : float
        Largest force on an atom of the surface.
    error : float
        Largest force on an atom or the indenter.
    energy, rounding : float
        Energy and an estimate of its rounding error.
    residual_norm : float
        Norm of the scaled residual by the inverse of the wall; infinity without an
        inverse.
    """

    def __init__(
        self,
        function: ContactEnergy,
        pressure: np.ndarray,
        height: float,
        opening: np.ndarray | None = None,
        exact: bool = False,
    ) -> None:
        self.function, self.height = function, height
        self.exact = exact or opening is None
        self.opening = function.opening(pressure) if opening is None else opening
        area, gap = function.area, self.gap()
        active = gap >= function.wall.cutoff
        np.logical_not(active, out=active)  # where the gap is NaN, too
        active |= pressure != 0.0
        near = np.flatnonzero(active)
        g, q = gap.take(near), pressure.take(near)
        energies, r, d = function.profile(g, near)
        stored = area * (float(energies.sum()) - function.constant)
        magnitude = area * (float(abs(energies).sum()) + function.constant)
        outside, force = function.external(height)
        unbalanced = force + area * float(r.sum())
        self.load_residual = 0.0 if function.support.fixed else unbalanced
        r = r - q  # a wall may return one array as pressure and stiffness
        self.surface_error = area * float(abs(r).max(initial=0.0))
        del energies  # frees memory, as further down
        self.residual_norm = math.inf
        if function.inverse:
            del r, d
            r, d, self.residual_norm = function.linearised_at(q, g)
            unbalanced = force + area * float(r.sum() + q.sum())
        self.linear_load_residual = 0.0 if function.support.fixed else unbalanced
        self.box = Box.bounding(active) or Box(
            divmod(int(gap.argmin()), gap.shape[1]), (1, 1)
        )
        del g, q, gap
        self.residual, self.stiffness = np.zeros((2, *pressure.shape))
        self.residual.put(near, r)
        self.stiffness.put(near, d)
        periodic = function.contact.halfspace.periodic
        if periodic and not function.inverse and active.all():
            # the energy does not depend on the mean of q: set it to the mean of p
            shift = float(self.residual.mean())
            pressure, self.residual = pressure + shift, self.residual - shift
        self.pressure = pressure
        elastic = 0.5 * area * dot(pressure, self.opening)
        self.energy = elastic + stored + outside
        self.rounding = _ENERGY_ROUNDING * (elastic + magnitude + abs(outside))
        self.error = max(self.surface_error, abs(self.load_residual))

    def gap(self) -> np.ndarray:
        """Return the gap ``Z + h + G q``."""
        gap = self.function.contact.heights + self.opening
        gap += self.height
        return gap

    def again(
        self,
        function: ContactEnergy | None = None,
        height: float | None = None,
    ) -> EnergyState:
        """Return a state of the same surface, evaluated without a convolution."""
        return EnergyState(
            function or self.function,
            self.pressure,
            self.height if height is None else height,
            self.opening,
            self.exact,
        )

    def moved(self, increment: Increment, length: float) -> EnergyState:
        """Return the state after an increment times a length."""
        return EnergyState(
            self.function,
            linear_combination([(1.0, self.pressure), (length, increment.pressure)]),
            self.height + length * increment.height,
            linear_combination([(1.0, self.opening), (length, increment.opening)]),
        )

    def slope(self, increment: Increment) -> float:
        """Return the first derivative of the energy along an increment.

        With `hessian` it is a quadratic model of the energy of the linearised wall.
        """
        work = self.function.area * dot(self.residual, increment.opening)
        return -work - increment.height * self.linear_load_residual

    def hessian(self, increments: list[Increment]) -> np.ndarray:
        """Return the second derivatives along increments, shape (k, k)."""
        area = self.function.area
        spring = self.function.spring_stiffness(self.height)
        result = np.empty((len(increments), len(increments)))
        for i, one in enumerate(increments):
            stressed = self.stiffness * (one.opening + one.height)
            force = total(stressed) + spring * one.height / area
            before = increments[: i + 1]
            elastic = dots([(one.pressure, other.opening) for other in before])
            wall = dots([(stressed, other.opening) for other in before])
            for j, other in enumerate(before):
                curvature = elastic[j] + wall[j] + force * other.height
                result[i, j] = result[j, i] = area * curvature
        return result

    def on_window(self, change: np.ndarray) -> np.ndarray:
        """Return the pressures of a change on the box as an array, shape (n, m)."""
        pressure = np.zeros(self.pressure.shape)
        pressure[self.box.slices] = change[:-1].reshape(self.box.shape)
        return pressure


@dataclass(frozen=True)
class Increment:
    """Changes of the pressure, of the opening by the pressure, and of the height."""

    pressure: np.ndarray
    opening: np.ndarray
    height: float

    @classmethod
    def of(cls, state: EnergyState, change: np.ndarray) -> Increment:
        """Return the increment of a change from `NewtonEquations`: one convolution."""
        pressure = state.on_window(change)
        return cls(pressure, state.function.opening(pressure), float(change[-1]))

    @classmethod
    def between(
        cls,
        state: EnergyState,
        pressure: np.ndarray,
        opening: np.ndarray,
        height: float,
    ) -> Increment:
        """Return the increment from a state to another one, in single precision."""
        change = np.empty((2, *pressure.shape), np.float32)
        np.subtract(pressure, state.pressure, out=change[0], casting="same_kind")
        np.subtract(opening, state.opening, out=change[1], casting="same_kind")
        return cls(change[0], change[1], height - state.height)
