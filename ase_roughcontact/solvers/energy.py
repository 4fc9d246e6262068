r"""Energy of a contact with a soft wall, as a function of pressure and height.

With the elastic pressure :math:`q` on the window, the Green's function :math:`G` of the
half space, the height :math:`Z` of the indenter, its surface :math:`h` and the gap
:math:`g = Z + h + G q`,

.. math:: E(q, Z) = a_0^2 \left[\tfrac12 \sum q\, G q + \sum V(g)\right] + U(Z)

has the gradient :math:`-a_0^2 G r` in :math:`q`, with the residual :math:`r = p - q`
and the pressure :math:`p = -V'(g)` of the wall, and :math:`-(a_0^2 \sum p + F)` in
:math:`Z`, with the force :math:`F = -U'` of load and springs on the indenter. An
increment :math:`(x, G x, z)` contains the opening :math:`G x` of the gap: energy and
derivatives along it cost no further convolution.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from ase_roughcontact._util.kernels import (
    dot,
    dots,
    inner,
    linear_combination,
    max_abs,
    rowwise,
)
from ase_roughcontact.contact import Contact
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.solvers.local_wall import LocalWall
from ase_roughcontact.solvers.relaxation import External

# Rounding error of an energy, relative to the sum of the magnitudes of its terms.
_ROUNDING = 1e-14
# Search for the height that carries the load: first step in spacings, growth of the
# steps, and their number, which covers any height.
_FIRST_STEP = 0.01
_GROWTH = 1.5
_SEARCH_STEPS = 100


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

    @property
    def error(self) -> float:
        """Largest force on an atom or the indenter."""
        return max(self.surface_error, abs(self.load_residual))


@dataclass(frozen=True)
class Increment:
    """Change of the pressure, the opening that it causes, and change of the height."""

    pressure: np.ndarray
    opening: np.ndarray
    height: float

    @classmethod
    def combination(
        cls, weights: list[float], increments: list[Increment]
    ) -> Increment:
        """Return the sum of increments times weights."""
        pairs = list(zip(weights, increments, strict=True))
        return cls(
            linear_combination([(w, increment.pressure) for w, increment in pairs]),
            linear_combination([(w, increment.opening) for w, increment in pairs]),
            sum(w * increment.height for w, increment in pairs),
        )


class ContactEnergy:
    """Energy of a contact and its derivatives, at states and along increments.

    Parameters
    ----------
    contact : Contact
        Contact with a soft wall.
    external : callable, optional
        Energy and upward force of load and springs on the indenter at a height; by
        default the height is fixed.
    """

    def __init__(self, contact: Contact, external: External | None) -> None:
        self.contact = contact
        self.wall = LocalWall.of(contact)
        self.area = contact.halfspace.cell_area
        self.loaded = external is not None
        self.external = external or (lambda height: (0.0, 0.0))

    def on(self, contact: Contact) -> ContactEnergy:
        """Return the energy of another contact with the same load and springs."""
        return ContactEnergy(contact, self.external if self.loaded else None)

    def opening(self, pressure: np.ndarray) -> np.ndarray:
        """Return ``G q``, the opening of the gap by a pressure: one convolution."""
        displacement = self.contact.halfspace.displacement(pressure)
        return np.negative(displacement, out=displacement)

    def state(
        self, pressure: np.ndarray, height: float, opening: np.ndarray | None = None
    ) -> EnergyState:
        """Evaluate the energy and its gradient.

        Parameters
        ----------
        pressure : ndarray, shape (n, m)
        height : float
        opening : ndarray, shape (n, m), optional
            That of `opening`; by default it is calculated.

        Returns
        -------
        EnergyState
        """
        if opening is None:
            opening = self.opening(pressure)
        residual, stiffness = np.empty(opening.shape), np.empty(opening.shape)
        active = np.empty(opening.shape, bool)
        stored, magnitude, pushed = self.wall.evaluate(
            residual, stiffness, active, pressure, opening, height
        )
        if self.contact.halfspace.periodic and active.all():
            # the energy does not depend on the mean of q: set it to that of p
            shift = float(residual.mean())
            pressure, residual = pressure + shift, residual - shift
        elastic = 0.5 * self.area * dot(pressure, opening)
        outside, force = self.external(height)
        if self.loaded:
            force += self.area * pushed
        magnitudes = elastic + self.area * magnitude + abs(outside)
        return EnergyState(
            pressure=pressure,
            opening=opening,
            height=height,
            box=Box.bounding(active) or self._lowest_gap(opening),
            stiffness=stiffness,
            residual=residual,
            load_residual=force,
            surface_error=self.area * max_abs(residual),
            energy=elastic + self.area * stored + outside,
            rounding=_ROUNDING * magnitudes,
        )

    def set_reaction(self, state: EnergyState) -> EnergyState:
        """Set the reaction of a hard wall from the pressure; return the state with it.

        Nothing changes if the wall is not hard.
        """
        if not self.contact.interaction.hard:
            return state
        self.wall = self.wall.with_reaction(state.pressure, state.opening, state.height)
        return self.state(state.pressure, state.height, state.opening)

    def update_reaction(self, state: EnergyState) -> float:
        """Update the reaction of a hard wall.

        Returns
        -------
        float
            Largest violation of the constraint: overlap, or gap of an atom under a
            reaction; zero without reactions (length).
        """
        if self.wall.reaction is None:
            return 0.0
        self.wall, violation = self.wall.updated(state.opening, state.height)
        return violation

    def stiffen_wall(self, factor: float) -> None:
        """Multiply the stiffness of a hard wall's augmented Lagrangian."""
        self.wall = replace(self.wall, stiffness=factor * self.wall.stiffness)

    def recomputed(self, state: EnergyState) -> EnergyState:
        """Return the same state with its opening from a new convolution."""
        return self.state(state.pressure, state.height)

    def moved(
        self, state: EnergyState, increment: Increment, length: float
    ) -> EnergyState:
        """Return the state after an increment times a length."""
        return self.state(
            linear_combination([(1.0, state.pressure), (length, increment.pressure)]),
            state.height + length * increment.height,
            linear_combination([(1.0, state.opening), (length, increment.opening)]),
        )

    def spring_stiffness(self, height: float) -> float:
        """Return the stiffness of the springs, by a difference of forces."""
        if not self.loaded:
            return 0.0
        d = 1e-4 * self.contact.halfspace.spacing
        difference = self.external(height - d)[1] - self.external(height + d)[1]
        return max(difference / (2.0 * d), 0.0)

    def height_stiffness(self, state: EnergyState) -> float:
        """Return the stiffness ``a0^2 sum V'' + U''`` against a change of height."""
        wall = self.area * float(state.stiffness.sum())
        return wall + self.spring_stiffness(state.height)

    def supports_indenter(self, state: EnergyState) -> bool:
        """Return whether the wall or a spring resists a change of height."""
        repulsive = bool((state.stiffness > 0.0).any())
        return repulsive or self.spring_stiffness(state.height) > 0.0

    def carrying_height(
        self, opening: np.ndarray | float = 0.0, highest: float = np.inf
    ) -> float | None:
        """Return the largest height at which the wall carries the load.

        The surface is held fixed.

        Parameters
        ----------
        opening : ndarray, shape (n, m)
            Opening of the gap by the displacement of the surface (length); by default
            the surface is flat.
        highest : float
            Upper bound to the height; by default the one at which the wall is just in
            range.

        Returns
        -------
        float or None
            None if the indenter is not pulled down, or no height carries the load.
        """
        shape = self.contact.heights + opening

        def force(height: float) -> float:
            pushed = self.area * self.wall.force(shape, height)
            return pushed + self.external(height)[1]

        high = low = min(float(self.wall.cutoff - shape.min()), highest)
        if force(high) >= 0.0:
            return None
        spacing = self.contact.halfspace.spacing
        for k in range(_SEARCH_STEPS):
            high, low = low, low - _FIRST_STEP * spacing * _GROWTH**k
            if force(low) > 0.0:
                root = float(brentq(force, low, high, xtol=1e-16 * spacing))
                while force(root) <= 0.0:  # rounding errors: the wall may not reach
                    root = math.nextafter(root, low)
                return root
        return None

    def slope(self, state: EnergyState, increment: Increment) -> float:
        """Return the first derivative of the energy along an increment."""
        work = dot(state.residual, increment.opening)
        return -self.area * work - increment.height * state.load_residual

    def hessian(self, state: EnergyState, increments: list[Increment]) -> np.ndarray:
        r"""Return the second derivatives of the energy along increments.

        .. math:: H_{ij} = a_0^2 \left[\sum x_i\, G x_j
                  + \sum V'' (G x_i + z_i)(G x_j + z_j)\right] + U'' z_i z_j

        Parameters
        ----------
        state : EnergyState
        increments : list of Increment

        Returns
        -------
        ndarray, shape (k, k)
        """
        pairs = [(i, j) for i in range(len(increments)) for j in range(i + 1)]
        openings = [increment.opening for increment in increments]
        heights = [increment.height for increment in increments]
        bulk = dots([(increments[i].pressure, openings[j]) for i, j in pairs])
        wall = _wall_hessian(state.stiffness, openings, heights, pairs)
        spring = self.spring_stiffness(state.height)
        result = np.empty((len(increments), len(increments)))
        for (i, j), elastic, stressed in zip(pairs, bulk, wall, strict=True):
            held = spring * heights[i] * heights[j]
            result[i, j] = result[j, i] = self.area * (elastic + stressed) + held
        return result

    def along(
        self, state: EnergyState, increment: Increment
    ) -> Callable[[float], tuple[float, float]]:
        """Return change of energy and slope as a function of the length of a step."""
        products = [(state.pressure, increment.opening)]
        products += [(increment.pressure, increment.opening)]
        linear, square = (self.area * product for product in dots(products))
        outside = self.external(state.height)[0]
        wall_along = self.wall.along(
            state.opening, state.height, increment.opening, increment.height
        )

        def energy_and_slope(t: float) -> tuple[float, float]:
            rise, work = wall_along(t)
            now, force = self.external(state.height + t * increment.height)
            energy = t * linear + 0.5 * t * t * square + now - outside
            slope = linear + t * square - self.area * work - force * increment.height
            return energy + self.area * rise, slope

        return energy_and_slope

    def _lowest_gap(self, opening: np.ndarray) -> Box:
        """Return a box with the atom of the smallest gap."""
        i, j = np.unravel_index(
            (self.contact.heights + opening).argmin(), opening.shape
        )
        return Box((int(i), int(j)), (1, 1))


@rowwise(np.add)
def _wall_hessian(
    stiffness: np.ndarray,
    openings: list[np.ndarray],
    heights: list[float],
    pairs: list[tuple[int, int]],
) -> tuple[float, ...]:
    """Return ``sum V'' (G x_i + z_i)(G x_j + z_j)`` for pairs of increments."""
    gaps = [opening + z for opening, z in zip(openings, heights, strict=True)]
    stressed = [stiffness * gap for gap in gaps]
    return tuple(inner(stressed[i], gaps[j]) for i, j in pairs)
