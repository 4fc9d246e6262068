"""Automatic windows of a free half space: all atoms that can touch, and few others.

An atom interacts where the gap ``Z + h - u`` is below the cutoff of the wall. A
repulsive wall lifts no atom, ``u <= 0``: only atoms at heights ``h`` below the level
``cutoff - Z``, where the rigid indenter overlaps the range of the wall, can interact. A
window that contains them is exact. An attractive wall lifts atoms. Outside the atoms
that it acts on, the displacement is a harmonic function that falls to zero, so that it
is largest on these: only atoms below the level ``cutoff - Z + max(u)`` can interact.
A solid that bulges around the contact is treated in the same way, and one that
tractions of friction lift: this displacement is harmonic in the plane outside them.

Large windows are made for the expected contact, which is smaller than the overlap. In
any case the gap of the atoms outside the window is checked after a step, and the
window is enlarged if the wall reaches one of them.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ase_roughcontact._util.kernels import max_abs
from ase_roughcontact.contact import Contact, Problem, State
from ase_roughcontact.contact.control import HEIGHT, LOAD, Control
from ase_roughcontact.contact.history import entry_of
from ase_roughcontact.contact.state import without_rounding
from ase_roughcontact.contact.support import Support
from ase_roughcontact.elasticity.fft import RealFFT2
from ase_roughcontact.elasticity.lattice import Box, carried
from ase_roughcontact.solvers.relaxation import Run
from ase_roughcontact.topography import RoughSphere
from ase_roughcontact.windows.adhesion_estimate import AdhesionEstimate
from ase_roughcontact.windows.expected import (
    ExpectedContact,
    contact_level,
    predicted_depth,
)
from ase_roughcontact.windows.fixed import WindowedState
from ase_roughcontact.windows.footprint import Footprint, centred_box
from ase_roughcontact.windows.memory import check_memory

# Largest ratio of the atoms of a window to the atoms that the next step needs, at which
# the window is kept.
_MAX_EXCESS = 2.0
# Largest factor by which the depth of the overlap, for which a window is made, grows
# at once when a window was too small.
_MAX_DEPTH_GROWTH = 2.0
# Growth of the number of atoms that overlap with a repulsive wall, above which a step
# starts from flat atoms: 30 % fewer transforms in four decades of 13 loads.
_RESTART_GROWTH = 1.1
#: Number of atoms above which a window is made for the expected contact only, not for
#: all atoms that the rigid indenter overlaps.
CONTACT_WINDOW_SIZE = 256 * 256
#: Side of a window for the expected contact over the diameter of this contact.
CONTACT_WINDOW_SCALE = 1.03
# Smallest depth of a window that is to be made deeper, in units of the spacing.
_MIN_DEPTH = 1e-3
# Upper bound to the rounding error of a displacement in single precision, relative to
# the largest displacement.
_SINGLE_ROUNDING = 1e-6


class AutoWindow:
    """Window that follows the contact along a path.

    Parameters
    ----------
    problem : Problem
        The contact problem, on a free half space.
    contact_window_size : int
        Number of atoms above which a window is made for the expected contact only, not
        for all atoms that the rigid indenter overlaps.

    Attributes
    ----------
    first_contact : float
        Height at which the indenter begins to repel the flat substrate (length).
    footprint : Footprint
        The footprint of the indenter.

    Raises
    ------
    ValueError
        If the indenter is not bounded.
    """

    def __init__(
        self, problem: Problem, contact_window_size: int | None = None
    ) -> None:
        self._contact_window_size = contact_window_size or CONTACT_WINDOW_SIZE
        indenter: Any = problem.indenter
        solid, spacing = problem.solid, problem.spacing
        self._wall, self._solid = problem.wall, solid
        self.footprint = Footprint(indenter, spacing, problem.offset)
        self.first_contact = self._wall.contact_distance - self.footprint.lowest
        # whether the surface rises above its plane somewhere
        self._rises = self._wall.attractive or solid.bulges
        self._adhesion: AdhesionEstimate | None = None
        if self._wall.attractive and problem.topography.apex_radius < math.inf:
            self._adhesion = AdhesionEstimate(indenter, self._wall, solid, spacing)
        self._expected: ExpectedContact | None = None
        if isinstance(indenter, RoughSphere):
            self._expected = ExpectedContact(problem)
        # last load, and the number of factors at which the search for its depth ended
        self._searched_load, self._searched_power = 0.0, 0

    def choose(self, state: State, support: Support, last: float) -> WindowedState:
        """Return the state from which a step starts, on the window of the step.

        Parameters
        ----------
        state : State
            Displaced as at the last step, at the height of the step if it is given.
        support : Support
            With a load the height is predicted.
        last : float
            Height of the last step (length).

        Returns
        -------
        WindowedState

        Raises
        ------
        ValueError
            If an atom could touch where the surface is not defined.
        MemoryError
            If a window does not fit into the free memory.
        """
        height, load = state.height, None if support.fixed else support.load
        adhesive_contact = self._adhesive_contact(state, load)
        if self._expected:  # before the roughness is searched for the atoms in reach
            if load is None:
                self._expected.check(HEIGHT, height)
            else:
                self._expected.check(LOAD, load)
        if load is not None:
            height = self._predicted_height(load, height)
        level = self._wall.cutoff - height
        if load is None:
            self.footprint.check(level)
        if not self._wall.attractive and state.displaced:
            before = self.footprint.box_below(self._wall.cutoff - last).size
            overlap = self.footprint.overlap(level).size
            if overlap > _RESTART_GROWTH * before:
                start = height if support.fixed else self.first_contact
                state = state.flattened(start)
        needed = self._needed(level, self._box_in_range(state))
        needed = needed.union(adhesive_contact).union(_box_of_history(state))
        usual = self.footprint.standard_size(needed)
        excessive = state.window.size > _MAX_EXCESS * usual.size
        if excessive or not state.window.contains(needed):
            state = self._on_window(state, needed)
        return WindowedState(state, level)

    def enlarged(
        self, run: Run, contact: Contact, window_level: float
    ) -> WindowedState | None:
        """Return the state on a larger window if the wall could act outside of this.

        Parameters
        ----------
        run : Run
            The relaxation of a state.
        contact : Contact
            The contact on the window of the state.
        window_level : float
            Level for which the window was made (length).

        Returns
        -------
        WindowedState or None
            To be relaxed again; None if the window suffices.

        Raises
        ------
        ValueError
            If an atom could touch where the surface is not defined.
        """
        state = run.state
        level = self._wall.cutoff - state.height
        window, lowest = state.window, self.footprint.lowest
        depth = max(window_level - lowest, _MIN_DEPTH * self.footprint.spacing)
        deepest = _MAX_DEPTH_GROWTH * depth
        if level - lowest > deepest and not window.contains(
            self.footprint.overlap(level)
        ):
            # under a load, the indenter sinks in too deep if the window is too small
            level = lowest + deepest
            needed = self._needed(level, window)
            return WindowedState(self._on_window(state, needed), level)
        needed = self._widened(state, contact, level)
        if needed != window:
            return WindowedState(self._on_window(state, needed), level)
        return None

    def forecast(self, control: Control, target: float) -> Box:
        """Return the window that a step probably will have.

        Parameters
        ----------
        control : Control
        target : float
            Penetration or height (length), or load (force), of the step.

        Returns
        -------
        Box

        Raises
        ------
        ValueError
            If an atom could touch where the surface is not defined.
        """
        if control == LOAD:
            height = self._predicted_height(target, self.first_contact)
        else:
            height = control.height(target, self.first_contact)
        self.check(height)
        level = self._wall.cutoff - height
        return self.footprint.standard_size(self._needed(level, None))

    def check(self, height: float) -> None:
        """Raise an error if a state at a height certainly has no window.

        Raises
        ------
        ValueError
            If an atom could touch where the surface is not defined.
        """
        self.footprint.check(self._wall.cutoff - height)

    def describe_lattice(self) -> dict[str, Any]:
        """Return a description of the lattice, for resuming a path."""
        spacing = self.footprint.spacing
        offset = [round(x / spacing, 9) for x in self.footprint.offset]
        return {"window": "auto", "spacing": spacing, "offset": offset}

    def _predicted_height(self, load: float, default: float) -> float:
        if load <= 0.0:
            return default
        power = self._searched_power if load >= self._searched_load else 0
        depth, power = predicted_depth(
            load, self.footprint, self._wall, self._solid, power
        )
        self._searched_load, self._searched_power = load, power
        return self.first_contact - depth

    def _needed(self, level: float, included: Box | None) -> Box:
        """Return the box of atoms that a window for a level must contain."""
        box = self.footprint.overlap(level).union(included)
        if box.size <= self._contact_window_size or self._wall.plastic:
            return box  # plastic contact fills the overlap
        lowest = self.footprint.lowest
        level = contact_level(level, lowest, self._wall, CONTACT_WINDOW_SCALE)
        return self.footprint.overlap(level).union(included)

    def _box_in_range(self, state: State) -> Box | None:
        """Return the atoms that may stay in the range of the wall above the plane."""
        if not self._rises:
            return None
        acts = without_rounding(state.pressure) != 0.0
        return Box.bounding(acts, state.window.start)

    def _adhesive_contact(self, state: State, load: float | None) -> Box | None:
        """Return the atoms that adhesion draws into contact with a flat surface.

        Windows chosen by the overlap would be filled one after another.
        """
        height = state.height
        touches = height <= self.first_contact if load is None else load > 0.0
        if self._adhesion is None or not touches or state.displaced:
            return None
        depth = self._wall.contact_distance - height
        radius = self._adhesion.radius(depth, load)
        if not radius:
            return None
        half_side = math.ceil(radius / self.footprint.spacing)
        return self.footprint.clip(centred_box(half_side))

    def _widened(self, state: State, contact: Contact, level: float) -> Box:
        """Return the window, widened to the atoms outside that the wall reaches."""
        window = state.window
        self.footprint.check(level)
        if self._rises or contact.past_depth is not None:
            level += max(self._highest(state, contact), 0.0)
        if window.contains(self.footprint.overlap(level)):
            return window
        self.footprint.check(level)
        wide = self.footprint.overlap(level).union(window)
        displacement = self._displacement_on(state, contact, wide)
        reached = window
        for tile in self.footprint.tiles(wide):
            if not window.contains(tile):
                # a lower bound to the gap
                gap = state.height + self.footprint.heights(tile)
                gap -= displacement[tile.slices_in(wide)]
                near = Box.bounding(gap < self._wall.cutoff, tile.start)
                reached = reached.union(near)
        return reached

    def _highest(self, state: State, contact: Contact) -> float:
        """Return the largest displacement, also in a bulge around the window."""
        if not contact.halfspace.solid.bulges and state.displacement is not None:
            displacement = state.displacement
            if contact.past_depth is not None:
                displacement = displacement - contact.past_depth
            return float(displacement.max())
        (n, m), (i, j) = state.window.shape, state.window.start
        wide = Box((i - n // 2, j - m // 2), (2 * n, 2 * m))
        return float(self._displacement_on(state, contact, wide).max())

    def _displacement_on(self, state: State, contact: Contact, wide: Box) -> np.ndarray:
        """Return an upper bound to the displacement of the atoms of a wider window."""
        pressure = state.pressure
        if contact.creep_pressure is not None:
            softer = contact.halfspace.contact_modulus / self._solid.contact_modulus
            pressure = pressure + softer * contact.creep_pressure
        loaded = Box.bounding(pressure != 0.0, state.window.start) or wide
        pressure = carried(pressure, state.window, wide)
        # the largest distances between atoms under pressure and others
        n, m = (
            max(
                wide.stop[axis] - loaded.start[axis],
                loaded.stop[axis] - wide.start[axis],
            )
            for axis in (0, 1)
        )
        halfspace = contact.halfspace.resized((n, m), self.footprint.spacing)
        options = {**halfspace.fft, "dtype": np.float32}
        transform = RealFFT2(wide.shape, halfspace.grid, **options)
        spectrum = transform.multiplier(halfspace.grid_spectrum, -1.0)
        displacement = transform.filter(pressure, spectrum)
        displacement += _SINGLE_ROUNDING * max_abs(displacement)
        if contact.past_depth is not None:  # tractions lift most at the edge
            depth = contact.past_depth
            edges = (depth[0], depth[-1], depth[:, 0], depth[:, -1])
            lowest = min(edge.min() for edge in edges)
            displacement -= min(lowest, 0.0)
        return displacement

    def _on_window(self, state: State, needed: Box) -> State:
        """Return the state on a window of a standard size."""
        window = self.footprint.standard_size(needed)
        check_memory(window.shape, self._wall, self._solid)
        return state.on(window)


def _box_of_history(state: State) -> Box | None:
    """Return the box of the atoms with a history, which must not be lost."""
    box = None
    for name, values in state.history.items():
        each = Box.bounding(values != entry_of(name).entering, state.window.start)
        box = each if box is None else box.union(each)
    return box
