"""Automatic windows of a free half space: all atoms that can touch, and few others.

An atom interacts where the gap ``Z + h - u`` is below the cutoff of the wall. A
repulsive wall lifts no atom, ``u <= 0``: only atoms at heights ``h`` below the level
``cutoff - Z``, where the rigid indenter overlaps the range of the wall, can interact. A
window that contains them is exact. An attractive wall lifts atoms. Outside the atoms
that it acts on, the displacement is a harmonic function that falls to zero, so that it
is largest on these: only atoms below the level ``cutoff - Z + max(u)`` can interact.
A solid that bulges around the contact is treated in the same way.

Large windows are made for the expected contact, which is smaller than the overlap. In
any case the gap of the atoms outside the window is checked after a step, and the
window is enlarged if the wall reaches one of them.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from ase import Atoms

from ase_roughcontact._util.kernels import max_abs
from ase_roughcontact.atoms.calculator import contact_of, elastic_pressure, grid_of
from ase_roughcontact.atoms.grid import displacement, set_displacement
from ase_roughcontact.atoms.indenter import indenter_fixed
from ase_roughcontact.atoms.plastic_shape import kept_depth
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.topography import RoughSphere
from ase_roughcontact.windows.adhesion_estimate import AdhesionEstimate
from ase_roughcontact.windows.exchange import carry, exchange_window, window_of
from ase_roughcontact.windows.expected import ExpectedContact
from ase_roughcontact.windows.footprint import Footprint, centred_box
from ase_roughcontact.windows.memory import check_memory
from ase_roughcontact.windows.options import WindowOptions
from ase_roughcontact.windows.prediction import DepthPrediction, contact_level

# A window is kept for the next step while it has at most this many times the atoms that
# are needed.
_LARGEST_EXCESS = 2.0
# Largest factor by which the depth of the overlap, for which a window is made, grows
# at once when a window was too small.
_LARGEST_DEEPENING = 2.0
# With a repulsive wall, a step starts from flat atoms if this many times more atoms
# overlap than at the last one.
_RESTART_GROWTH = 1.1
# Smallest depth of a window that is to be made deeper, in units of the spacing.
_LEAST_DEPTH = 1e-3
# Upper bound to the rounding error of a displacement in single precision, relative to
# the largest one.
_ROUNDING = 1e-6


class AutoWindow:
    """Window that follows the contact along a path.

    Parameters
    ----------
    atoms : Atoms
        Of a free half space, with a `RoughContact` calculator.
    options : WindowOptions, optional

    Attributes
    ----------
    first_contact : float
        Height at which the indenter begins to repel the flat substrate (Å).
    footprint : Footprint
        Of the indenter.

    Raises
    ------
    ValueError
        If the indenter is not bounded.
    """

    def __init__(self, atoms: Atoms, options: WindowOptions | None = None) -> None:
        self._options = options or WindowOptions()
        spacing = grid_of(atoms).spacing
        contact = contact_of(atoms)
        indenter = atoms.calc.parameters["indenter"]
        solid = contact.halfspace.solid
        self._wall = contact.interaction
        self.footprint = Footprint(indenter, spacing, grid_of(atoms).origin)
        self.first_contact = self._wall.contact_distance - self.footprint.lowest
        # whether the surface rises above its plane somewhere
        self._rises = self._wall.attractive or solid.bulges
        self._adhesion: AdhesionEstimate | None = None
        radius = getattr(indenter, "radius", math.inf)
        if self._wall.attractive and radius < math.inf:
            self._adhesion = AdhesionEstimate(indenter, self._wall, solid, spacing)
        self._plastic = self._wall.hardness < math.inf
        self._expected: ExpectedContact | None = None
        if isinstance(indenter, RoughSphere):
            self._expected = ExpectedContact(indenter, self._wall, solid, spacing)
        self._prediction = DepthPrediction(
            self.footprint, self._wall, solid, self._options.load_factor
        )
        self._level = -np.inf  # for which the window was made
        # of the state relaxed last: atoms in the range of the wall, and in the overlap
        self._in_range: Box | None = None
        self._overlap_size = math.inf
        self._largest_load = 0.0

    def choose(self, atoms: Atoms, control: str) -> None:
        """Choose the window of a step.

        Parameters
        ----------
        atoms : Atoms
            At the target of the step, displaced as at the last one; changed in place.
        control : str
            With "loads" the height is predicted.

        Raises
        ------
        ValueError
            If an atom could touch where the surface is not defined.
        MemoryError
            If a window does not fit into the free memory.
        """
        height = float(atoms.positions[-1, 2])
        load = atoms.calc.parameters["load"] if control == "loads" else None
        adhesive_contact = self._adhesive_contact(atoms, load)
        if self._expected:  # before the roughness is searched for the atoms in reach
            target = ("heights", height) if load is None else ("loads", load)
            self._expected.check_surface(*target)
            self._expected.check_memory(*target)
        if load is not None:
            height = self._predicted_height(load, height)
        self._level = self._wall.cutoff - height
        if control != "loads":
            self.footprint.check(self._level)
        overlap = self.footprint.overlap(self._level)
        window = window_of(grid_of(atoms))
        if (
            not self._wall.attractive
            and overlap.size > _RESTART_GROWTH * self._overlap_size
        ):
            self._flatten(atoms)
        needed = self._needed(self._level, self._box_in_range(atoms, window))
        needed = needed.union(adhesive_contact).union(self._indented(atoms, window))
        usual = self.footprint.standard_size(needed)
        excessive = window.size > _LARGEST_EXCESS * usual.size
        if excessive or not window.contains(needed):
            self._exchange(atoms, needed)

    def enlarge_if_needed(self, atoms: Atoms) -> bool:
        """Enlarge the window if an atom outside could interact with the wall.

        Parameters
        ----------
        atoms : Atoms
            Relaxed; changed in place.

        Returns
        -------
        bool
            Whether the window was enlarged, so that the atoms must be relaxed again.

        Raises
        ------
        ValueError
            If an atom could touch where the surface is not defined.
        """
        level = self._wall.cutoff - float(atoms.positions[-1, 2])
        window, lowest = window_of(grid_of(atoms)), self.footprint.lowest
        depth = max(self._level - lowest, _LEAST_DEPTH * self.footprint.spacing)
        deepest = _LARGEST_DEEPENING * depth
        if level - lowest > deepest and not window.contains(
            self.footprint.overlap(level)
        ):
            # under a load, the indenter sinks in too deep if the window is too small
            self._level = lowest + deepest
            if not self._wall.attractive:
                self._flatten(atoms)
            self._exchange(atoms, self._needed(self._level, window))
            return True
        self._level = level
        needed = window.union(self._reached(atoms, window))
        if needed == window:
            self.accept(atoms)
            return False
        self._exchange(atoms, needed)
        return True

    def accept(self, atoms: Atoms) -> None:
        """Keep what the choice of the next window needs to know of relaxed atoms."""
        load = atoms.calc.parameters["load"]
        height = float(atoms.positions[-1, 2])
        depth = self.first_contact - height
        overlap = self.footprint.box_below(self._wall.cutoff - height)
        self._overlap_size = overlap.size
        if self._rises:
            grid = grid_of(atoms)
            gap = contact_of(atoms).gap(displacement(atoms, grid), height)
            near = gap < self._wall.cutoff
            self._in_range = Box.bounding(near, window_of(grid).start)
        # a surface that unloads is deeper than one that has not flowed yet
        unloads = self._wall.permanent and load < self._largest_load
        self._largest_load = max(load, self._largest_load)
        if not (self._wall.attractive or unloads) and load > 0.0 and depth > 0.0:
            self._prediction.adjust(load, depth, overlap)

    def forecast(self, control: str, target: float) -> Box:
        """Return the window that a step probably will have.

        Parameters
        ----------
        control : {"penetrations", "heights", "loads"}
        target : float
            Of the step.

        Returns
        -------
        Box

        Raises
        ------
        ValueError
            If an atom could touch where the surface is not defined.
        """
        height = target
        if control == "loads":
            height = self._predicted_height(target, self.first_contact)
        elif control == "penetrations":
            height = self.first_contact - target
        level = self._wall.cutoff - height
        self.footprint.check(level)
        return self.footprint.standard_size(self._needed(level, None))

    def describe_lattice(self) -> dict[str, Any]:
        """Return what distinguishes the lattice from others, for resuming a path."""
        spacing = self.footprint.spacing
        offset = [round(x / spacing, 9) for x in self.footprint.offset]
        return {"window": "auto", "spacing": spacing, "offset": offset}

    def _predicted_height(self, load: float, default: float) -> float:
        if load <= 0.0:
            return default
        return self.first_contact - self._prediction.depth(load)

    def _needed(self, level: float, also: Box | None) -> Box:
        """Return the box of atoms that a window for a level must contain."""
        box = self.footprint.overlap(level).union(also)
        if box.size <= self._options.contact_window_size or self._plastic:
            return box  # plastic contact fills the overlap
        scale = self._options.contact_window_scale
        level = contact_level(level, self.footprint.lowest, self._wall, scale)
        return self.footprint.overlap(level).union(also)

    def _box_in_range(self, atoms: Atoms, window: Box) -> Box | None:
        """Return the atoms that may stay in the range of the wall above the plane."""
        if not self._rises:
            return None
        return self._in_range or (window if _displaced(atoms) else None)

    def _indented(self, atoms: Atoms, window: Box) -> Box | None:
        """Return the atoms whose plastic shape must not be lost."""
        depth = kept_depth(atoms, grid_of(atoms))
        return None if depth is None else Box.bounding(depth > 0.0, window.start)

    def _adhesive_contact(self, atoms: Atoms, load: float | None) -> Box | None:
        """Return the atoms that adhesion draws into contact with a flat surface.

        Windows chosen by the overlap would be filled one after another.
        """
        height = float(atoms.positions[-1, 2])
        touches = height <= self.first_contact if load is None else load > 0.0
        if self._adhesion is None or not touches or _displaced(atoms):
            return None
        depth = self._wall.contact_distance - height
        radius = self._adhesion.radius(depth, load)
        if not radius:
            return None
        half_side = math.ceil(radius / self.footprint.spacing)
        return self.footprint.clip(centred_box(half_side))

    def _reached(self, atoms: Atoms, window: Box) -> Box | None:
        """Return a box of the atoms, also outside the window, that the wall reaches."""
        level = self._level
        self.footprint.check(level)
        if self._rises:
            level += max(self._highest(atoms, window), 0.0)
        if window.contains(self.footprint.overlap(level)):
            return None
        self.footprint.check(level)
        wide = self.footprint.overlap(level).union(window)
        near = self._gap(atoms, window, wide) < self._wall.cutoff
        return Box.bounding(near, wide.start)

    def _highest(self, atoms: Atoms, window: Box) -> float:
        """Return the largest displacement, that of a bulge around the window, too."""
        if not contact_of(atoms).halfspace.solid.bulges:
            return float(_displacement(atoms).max())
        n, m = window.shape
        start = window.start[0] - n // 2, window.start[1] - m // 2
        return float(
            self._displacement_on(atoms, window, Box(start, (2 * n, 2 * m))).max()
        )

    def _gap(self, atoms: Atoms, window: Box, wide: Box) -> np.ndarray:
        """Return a lower bound to the gap of the atoms of a wider window."""
        undeformed = float(atoms.positions[-1, 2]) + self.footprint.heights(wide)
        return undeformed - self._displacement_on(atoms, window, wide)

    def _displacement_on(self, atoms: Atoms, window: Box, wide: Box) -> np.ndarray:
        """Return an upper bound to the displacement of the atoms of a wider window."""
        pressure = carry(elastic_pressure(atoms), window, wide)
        halfspace = contact_of(atoms).halfspace
        wider = halfspace.resized(wide.shape, self.footprint.spacing)
        displacement = wider.in_single_precision().displacement(pressure)
        displacement += _ROUNDING * max_abs(displacement)
        return displacement

    def _exchange(self, atoms: Atoms, needed: Box) -> None:
        window = self.footprint.standard_size(needed)
        check_memory(window.shape)
        exchange_window(atoms, window)

    def _flatten(self, atoms: Atoms) -> None:
        """Set the displacement to zero, and the height of a free indenter back."""
        set_displacement(atoms, np.zeros(len(atoms) - 1))
        if not indenter_fixed(atoms):
            atoms.positions[-1, 2] = self.first_contact


def _displacement(atoms: Atoms) -> np.ndarray:
    return displacement(atoms, grid_of(atoms))


def _displaced(atoms: Atoms) -> bool:
    return bool(_displacement(atoms).any())
