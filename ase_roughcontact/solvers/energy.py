r"""Energy of a contact with a soft wall, as a function of pressure and height.

With the elastic pressure :math:`q` on the window, the Green's function :math:`G` of the
half space, the height :math:`Z` of the indenter, its surface :math:`h` and the gap
:math:`g = Z + h + G q`,

.. math:: E(q, Z) = a_0^2 \left[\tfrac12 \sum q\, G q + \sum V(g)\right] + U(Z)

has the gradient :math:`-a_0^2 G r` in :math:`q`, with the residual :math:`r = p - q`
and the pressure :math:`p = -V'(g)` of the wall, and :math:`-(a_0^2 \sum p + F)` in
:math:`Z`, with the force :math:`F = -U'` of load and springs on the indenter. For
derivatives along increments see `increments`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ase_roughcontact._util.kernels import dot, scale
from ase_roughcontact.contact import Contact
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.solvers.local_wall import LocalWall
from ase_roughcontact.solvers.relaxation import External

# Rounding error of an energy, relative to the sum of the magnitudes of its terms.
_ROUNDING = 1e-14


@dataclass(frozen=True)
class EnergyState:
    """Energy and gradient at a pressure and a height.

    Attributes
    ----------
    pressure, opening : ndarray, shape (n, m)
        Elastic pressure ``q`` and the opening ``G q`` of the gap (length).
    height : float
        Height of the indenter (length).
    box : Box
        Bounding box of the atoms in range of the wall or under pressure; at least one
        atom.
    stiffness, residual : ndarray, shape (n, m)
        Stiffness ``V''`` of the wall and residual ``p - q``.
    load_residual : float
        Upward force on the indenter; zero if the height is fixed.
    surface_error : float
        Largest force on an atom of the surface.
    energy, rounding : float
        Energy and an estimate of its rounding error.
    exact : bool
        Whether the opening comes from a convolution of this pressure.
    residual_norm : float
        Norm of the scaled residual if the wall is linearised at the gaps at which it
        has the pressures ``q``; infinite if it is linearised at the present gaps.
    """

    pressure: np.ndarray
    opening: np.ndarray
    height: float
    box: Box
    stiffness: np.ndarray
    residual: np.ndarray
    load_residual: float
    surface_error: float
    energy: float
    rounding: float
    exact: bool
    residual_norm: float

    @property
    def by_pressure(self) -> bool:
        """Whether the wall is linearised at the gaps at which it has the pressures."""
        return self.residual_norm < math.inf

    @property
    def error(self) -> float:
        """Largest force on an atom or the indenter."""
        return max(self.surface_error, abs(self.load_residual))


class ContactEnergy:
    """Energy of a contact and its derivatives, at states and along increments.

    Parameters
    ----------
    contact : Contact
        Contact with a soft wall, or a hard one with attraction.
    external : callable, optional
        Energy and upward force of load and springs on the indenter at a height; by
        default the height is fixed.
    wall : LocalWall, optional
        Wall of the contact with a reaction; by default without.
    """

    def __init__(
        self,
        contact: Contact,
        external: External | None,
        wall: LocalWall | None = None,
    ) -> None:
        self.contact = contact
        self.wall = wall or LocalWall.of(contact)
        self.area = contact.halfspace.cell_area
        self.attractive = contact.interaction.attractive
        self.invertible = contact.interaction.invertible
        self.loaded = external is not None
        self.external = external or (lambda height: (0.0, 0.0))

    def on(self, contact: Contact, wall: LocalWall | None = None) -> ContactEnergy:
        """Return the energy of a contact or wall with the same load and springs."""
        return ContactEnergy(contact, self.external if self.loaded else None, wall)

    def opening(self, pressure: np.ndarray) -> np.ndarray:
        """Return ``G q``, the opening of the gap by a pressure: one convolution."""
        displacement = self.contact.halfspace.displacement(pressure)
        scale(displacement, displacement, -1.0)
        return displacement

    def state(
        self,
        pressure: np.ndarray,
        height: float,
        opening: np.ndarray | None = None,
        *,
        exact: bool = False,
        by_pressure: bool = False,
    ) -> EnergyState:
        """Evaluate the energy and its gradient.

        Parameters
        ----------
        pressure : ndarray, shape (n, m)
        height : float
        opening : ndarray, shape (n, m), optional
            That of `opening`; by default it is calculated.
        exact : bool
            Whether a given opening comes from a convolution.
        by_pressure : bool
            Whether to linearise the wall, which must have an inverse, at the gaps at
            which it has the given pressures; by default at the present gaps.

        Returns
        -------
        EnergyState
        """
        if opening is None:
            opening, exact = self.opening(pressure), True
        linearise = self.wall.at_pressures if by_pressure else self.wall.at_gaps
        wall = linearise(pressure, opening, height)
        residual = wall.residual
        if self.contact.halfspace.periodic and wall.active.all() and not by_pressure:
            # the energy does not depend on the mean of q: set it to that of p
            shift = float(residual.mean())
            pressure, residual = pressure + shift, residual - shift
        elastic = 0.5 * self.area * dot(pressure, opening)
        outside, force = self.external(height)
        magnitudes = elastic + self.area * wall.magnitude + abs(outside)
        return EnergyState(
            pressure=pressure,
            opening=opening,
            height=height,
            box=Box.bounding(wall.active) or self._lowest_gap(opening),
            stiffness=wall.stiffness,
            residual=residual,
            load_residual=force + self.area * wall.force if self.loaded else 0.0,
            surface_error=self.area * wall.error,
            energy=elastic + self.area * wall.energy + outside,
            rounding=_ROUNDING * magnitudes,
            exact=exact,
            residual_norm=wall.norm,
        )

    def with_reaction(self, state: EnergyState) -> ContactEnergy:
        """Return the energy with the reaction of a hard wall from the pressure."""
        wall = self.wall.with_reaction(state.pressure, state.opening, state.height)
        return self.on(self.contact, wall)

    def updated(self, state: EnergyState) -> tuple[ContactEnergy, float]:
        """Return the energy with an updated reaction of a hard wall.

        Returns
        -------
        energy : ContactEnergy
        violation : float
            Largest violation of the constraint: overlap, or gap of an atom under a
            reaction; zero without reactions (length).
        """
        if self.wall.reaction is None:
            return self, 0.0
        wall, violation = self.wall.updated(state.opening, state.height)
        return self.on(self.contact, wall), violation

    def stiffer(self, factor: float) -> ContactEnergy:
        """Return the energy with a stiffer augmented Lagrangian of a hard wall."""
        wall = replace(self.wall, stiffness=factor * self.wall.stiffness)
        return self.on(self.contact, wall)

    def recomputed(self, state: EnergyState) -> EnergyState:
        """Return the same state with its opening from a new convolution."""
        return self.state(state.pressure, state.height)

    def reevaluated(
        self,
        state: EnergyState,
        height: float | None = None,
        *,
        by_pressure: bool = False,
    ) -> EnergyState:
        """Return the state of the same surface, without a convolution.

        The height, the reaction of the wall or its linearisation may have changed.
        """
        return self.state(
            state.pressure,
            state.height if height is None else height,
            state.opening,
            exact=state.exact,
            by_pressure=by_pressure,
        )

    def spring_stiffness(self, height: float) -> float:
        """Return the stiffness of the springs, by a difference of forces."""
        if not self.loaded:
            return 0.0
        d = 1e-4 * self.contact.halfspace.spacing
        difference = self.external(height - d)[1] - self.external(height + d)[1]
        return max(difference / (2.0 * d), 0.0)

    def _lowest_gap(self, opening: np.ndarray) -> Box:
        """Return a box with the atom of the smallest gap."""
        gap = self.contact.heights + opening
        i, j = np.unravel_index(gap.argmin(), gap.shape)
        return Box((int(i), int(j)), (1, 1))
