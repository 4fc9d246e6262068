"""Energy of a soft contact as a function of pressure and height.

With the elastic pressure ``q`` on the window, the Green's function ``G`` of the half
space and the gap ``g = Z + h + G q``,

::

    E(q, Z) = a0^2 [ 1/2 sum q (G q) + sum V(g) ] + U(Z)

has the gradient ``a0^2 G (q - p)`` in ``q``, with the wall's pressure ``p = -V'(g)``,
and ``-(a0^2 sum p + F)`` in ``Z``, with the force ``F = -U'`` of load and springs on
the indenter. ``G`` is linear: once the lift ``G x`` of a step is known, energy and
derivatives anywhere along it cost no transform.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ase_roughcontact._util.kernels import (
    by_rows,
    combined,
    dot,
    dots,
    each,
    largest,
    part_dot,
)
from ase_roughcontact.contact import Contact
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.solvers.relaxation import External

# Rounding of an energy, relative to the sum of its terms' magnitudes.
_ROUNDING = 1e-14
# Least curvature, of one, that a combination of steps takes a mode for.
_LEAST_CURVATURE = 0.03
# Steps of the indenter alone, each of which squares what is missing of the load.
_BALANCE = 3
# A line search stops at this part of the first slope.
_SLOPE_LEFT = 0.3


@dataclass(frozen=True)
class State:
    """A point of the contact_energy.

    Attributes
    ----------
    pressure, lift : ndarray, shape (n, m)
        Elastic pressure ``q``, and ``G q`` (length).
    height : float
        Of the indenter (length).
    box : Box
        Around the atoms in range of the wall or under pressure; at least one.
    stiffness, residual : ndarray, shape (n, m)
        The wall's stiffness and ``p - q``.
    load_residual : float
        Upward force on the indenter, zero if it is fixed.
    surface_error : float
        Largest force on any atom of the surface.
    energy, noise : float
        The energy, and how large its rounding may be.
    """

    pressure: np.ndarray
    lift: np.ndarray
    height: float
    box: Box
    stiffness: np.ndarray
    residual: np.ndarray
    load_residual: float
    surface_error: float
    energy: float
    noise: float

    @property
    def error(self) -> float:
        """Largest force on any atom or the indenter."""
        return max(self.surface_error, abs(self.load_residual))


@dataclass(frozen=True)
class Step:
    """Change of pressure, of the lift that goes with it, and of the height."""

    pressure: np.ndarray
    lift: np.ndarray
    height: float

    @classmethod
    def sum(cls, parts: list[float], steps: list[Step]) -> Step:
        """Return the sum of parts of steps."""
        pairs = list(zip(parts, steps, strict=True))
        return cls(
            combined([(part, step.pressure) for part, step in pairs]),
            combined([(part, step.lift) for part, step in pairs]),
            sum(part * step.height for part, step in pairs),
        )


class ContactEnergy:
    """Energy and its derivatives, at states and along steps.

    Parameters
    ----------
    contact : Contact
        With a soft wall.
    external : callable, optional
        Energy and upward force of load and springs on the indenter at a height; by
        default the height is fixed.
    """

    def __init__(self, contact: Contact, external: External | None) -> None:
        self.contact = contact
        self.wall = contact.interaction
        self.area = contact.halfspace.cell_area
        self.loaded = external is not None
        self.external = external or (lambda height: (0.0, 0.0))

    def lift(self, pressure: np.ndarray) -> np.ndarray:
        """Return ``G q``, the opening of the gap by a pressure: one convolution."""
        lift = self.contact.halfspace.displacement(pressure)
        return np.negative(lift, out=lift)

    def spring(self, height: float) -> float:
        """Stiffness of the springs on the indenter, by a difference of forces."""
        if not self.loaded:
            return 0.0
        d = 1e-4 * self.contact.halfspace.spacing
        fall = self.external(height - d)[1] - self.external(height + d)[1]
        return max(fall / (2.0 * d), 0.0)

    def state(self, pressure: np.ndarray, lift: np.ndarray, height: float) -> State:
        """Evaluate the wall, the energy and its gradient."""
        stiffness, residual = np.empty(lift.shape), np.empty(lift.shape)
        near = np.empty(lift.shape, bool)

        def evaluate(rows: slice) -> list[float]:
            gap, here = self._gap(lift, height, rows), near[rows]
            np.less(gap, self.wall.cutoff, out=here)
            here |= pressure[rows] != 0.0
            stiffness[rows] = residual[rows] = 0.0
            if not here.any():
                return [0.0, 0.0, 0.0]
            energies, repulsion, stiffness[rows][here] = self.wall.evaluate(gap[here])
            residual[rows][here] = repulsion
            residual[rows] -= pressure[rows]
            return [float(x.sum()) for x in (energies, abs(energies), repulsion)]

        sums = np.sum(by_rows(evaluate, lift.shape), axis=0)
        stored, magnitude, pushed = (self.area * sums).tolist()
        if self.contact.halfspace.periodic and near.all():
            # an even pressure displaces nothing, and no energy tells how large it is
            shift = float(residual.mean())
            pressure, residual = pressure + shift, residual - shift
        elastic = 0.5 * self.area * dot(pressure, lift)
        outside, force = self.external(height)
        if self.loaded:
            force += pushed
        return State(
            pressure=pressure,
            lift=lift,
            height=height,
            box=self._around(near, lift),
            stiffness=stiffness,
            residual=residual,
            load_residual=force,
            surface_error=self.area * largest(residual),
            energy=elastic + stored + outside,
            noise=_ROUNDING * (elastic + magnitude + abs(outside)),
        )

    def afresh(self, state: State) -> State:
        """Return the same state, its lift convolved anew."""
        return self.state(state.pressure, self.lift(state.pressure), state.height)

    def moved(self, state: State, step: Step, length: float) -> State:
        """Return the state after a step."""
        return self.state(
            combined([(1.0, state.pressure), (length, step.pressure)]),
            combined([(1.0, state.lift), (length, step.lift)]),
            state.height + length * step.height,
        )

    def balanced(self, state: State, tolerance: float) -> State:
        """Move the indenter alone, where only its force is larger than a tolerance.

        Then the wall's stiffness spreads what is missing of the load over the atoms in
        contact: no transform is needed. A contact of 2.4 million atoms, to 2.5e-5 of
        the mean force on each, so took 8 Newton steps at its last spacing instead of
        17. Not under attraction, where the frozen surface may hold an indenter that
        the real one lets go.
        """
        for _ in range(_BALANCE):
            missing = state.load_residual
            only = state.surface_error <= tolerance < abs(missing)
            if self.wall.attractive or not only:
                break
            resistance = self.area * float(state.stiffness.sum())
            resistance += self.spring(state.height)
            if not resistance > 0.0:
                break
            height = state.height + missing / resistance
            moved = self.state(state.pressure, state.lift, height)
            higher = moved.energy > state.energy + state.noise
            if higher or not moved.error < state.error:
                break
            state = moved
        return state

    def resists(self, state: State) -> bool:
        """Whether wall or springs resist a change of the indenter's height."""
        wall = bool((state.stiffness > 0.0).any())
        return wall or self.spring(state.height) > 0.0

    def carrying_height(
        self, lift: np.ndarray | float = 0.0, highest: float = np.inf
    ) -> float | None:
        """Height where the wall on a frozen surface first carries the load, from above.

        Parameters
        ----------
        lift : ndarray, shape (n, m)
            Of the surface (length); by default it is flat.
        highest : float
            Where to begin, if not where the wall does.

        Returns
        -------
        float or None
            None if the indenter is not pulled down, or nowhere held.
        """
        shape = self.contact.heights + lift

        def force(height: float) -> float:
            gap = height + shape[shape < self.wall.cutoff - height]
            repulsion = self.wall.evaluate(gap)[1]
            return self.area * float(repulsion.sum()) + self.external(height)[1]

        high = low = min(float(self.wall.cutoff - shape.min()), highest)
        if force(high) >= 0.0:
            return None
        step = 0.01 * self.contact.halfspace.spacing
        for _ in range(100):
            high, low, step = low, low - step, 1.5 * step
            if force(low) > 0.0:
                break
        else:
            return None
        for _ in range(60):
            middle = (low + high) / 2.0
            low, high = (low, middle) if force(middle) <= 0.0 else (middle, high)
        return low

    def slope(self, state: State, step: Step) -> float:
        """First derivative of the energy along a step."""
        work = dot(state.residual, step.lift)
        return -self.area * work - step.height * state.load_residual

    def curvatures(self, state: State, steps: list[Step]) -> np.ndarray:
        """Second derivatives of the energy along steps.

        Parameters
        ----------
        state : State
        steps : list of Step

        Returns
        -------
        ndarray, shape (number of steps, number of steps)
        """
        pairs = [(i, j) for i in range(len(steps)) for j in range(i + 1)]

        def wall(rows: slice) -> np.ndarray:
            gaps = [step.lift[rows] + step.height for step in steps]
            stressed = [state.stiffness[rows] * gap for gap in gaps]
            return np.array([part_dot(stressed[i], gaps[j]) for i, j in pairs])

        bulk = dots([(steps[i].pressure, steps[j].lift) for i, j in pairs])
        works = bulk + np.sum(by_rows(wall, state.stiffness.shape), axis=0)
        spring = self.spring(state.height)
        result = np.empty((len(steps), len(steps)))
        for (i, j), work in zip(pairs, works.tolist(), strict=True):
            held = spring * steps[i].height * steps[j].height
            result[i, j] = result[j, i] = self.area * work + held
        return result

    def combination(self, state: State, steps: list[Step]) -> Step:
        """Combine steps to the least energy, by the exact Hessian among them.

        Negative curvature is taken for positive: the result always leads downhill.
        """
        slopes = np.array([self.slope(state, step) for step in steps])
        hessian = self.curvatures(state, steps)
        scale = 1.0 / np.sqrt(abs(np.diag(hessian)) + 1e-300)
        values, modes = np.linalg.eigh(scale[:, None] * hessian * scale)
        along = modes.T @ (scale * slopes) / np.maximum(abs(values), _LEAST_CURVATURE)
        parts = -scale * (modes @ along)
        return Step.sum(parts.tolist(), steps)

    def line_search(self, state: State, step: Step) -> float:
        """Length, at most one, where the energy has fallen and most of its slope gone.

        Returns
        -------
        float
            Zero if no length was found at which the energy falls.
        """
        along = self._line(state, step)
        wanted = _SLOPE_LEFT * abs(self.slope(state, step))
        length, low, high = 1.0, 0.0, 1.0
        for _ in range(40):
            energy, slope = along(length)
            falls = energy <= state.noise
            if falls and (abs(slope) <= wanted or (length == 1.0 and slope < 0.0)):
                return length
            if falls and slope < 0.0:
                low = length
            else:
                high = length
            length = (low + high) / 2.0
            if high - low < 0.05 * low:
                break
        return low

    def _gap(self, lift: np.ndarray, height: float, rows: slice) -> np.ndarray:
        """Gap of some rows."""
        gap: np.ndarray = self.contact.heights[rows] + lift[rows]
        gap += height
        return gap

    def _around(self, near: np.ndarray, lift: np.ndarray) -> Box:
        """Box around some atoms, or else of the one of the least gap."""
        box = Box.bounding(near, (0, 0))
        if box is not None:
            return box
        i, j = np.unravel_index((self.contact.heights + lift).argmin(), lift.shape)
        return Box((int(i), int(j)), (1, 1))

    def _line(self, state: State, step: Step) -> Callable[[float], tuple[float, float]]:
        """Change of energy, and slope, as functions of the length of a step."""
        products = (state.pressure, step.lift), (step.pressure, step.lift)
        linear, square = (self.area * dots(list(products))).tolist()
        outside = self.external(state.height)[0]
        reached = self._reached(state, step)

        def along(t: float) -> tuple[float, float]:
            def part(atoms: tuple[np.ndarray, ...]) -> tuple[float, float]:
                gap, change, start = atoms
                energies, repulsion, _ = self.wall.evaluate(gap + t * change)
                rise = float((energies - start).sum())
                return rise, part_dot(repulsion, change)

            found = [(0.0, 0.0), *each(part, reached)]
            rise, work = np.sum(found, axis=0).tolist()
            now, force = self.external(state.height + t * step.height)
            energy = t * linear + 0.5 * t * t * square + now - outside
            slope = linear + t * square - self.area * work - force * step.height
            return energy + self.area * rise, slope

        return along

    def _reached(self, state: State, step: Step) -> list[tuple[np.ndarray, ...]]:
        """Gap, its change and the energy of the atoms in range along a step.

        In parts, as lists.
        """

        def lists(rows: slice) -> tuple[np.ndarray, ...]:
            gap = self._gap(state.lift, state.height, rows)
            change = step.lift[rows] + step.height
            near = gap + np.minimum(change, 0.0) < self.wall.cutoff
            gap, change = gap[near], change[near]
            return gap, change, self.wall.evaluate(gap)[0] if gap.size else gap

        return [atoms for atoms in by_rows(lists, state.lift.shape) if atoms[0].size]
