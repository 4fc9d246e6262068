"""Windows of a free half space that hold the atoms that can touch, and few others.

An atom interacts where the gap ``Z + h - u`` is below the cutoff of the wall. A surface
that is only pushed lies nowhere above its plane, ``u <= 0``, so that only atoms with
heights ``h`` below the level ``cutoff - Z`` can touch: a window that holds these is
exact. Where the wall pulls, the surface bulges. Outside of the atoms that the wall acts
on, the displacement is a harmonic function that falls to zero, so that it is nowhere
higher than on these; this bounds the atoms that have to be looked at.

A window is a box of atoms. A large box is made for
the contact rather than for all that could touch, and checked afterwards.
"""

from __future__ import annotations

import math
from dataclasses import asdict

import numpy as np
from ase import Atoms

from ase_roughcontact.atoms.build import indenter_fixed
from ase_roughcontact.atoms.grid import displacement, set_displacement
from ase_roughcontact.contact import Contact
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.topography import RoughSphere
from ase_roughcontact.windows.adhesion_estimate import AdhesionEstimate
from ase_roughcontact.windows.exchange import carry, exchange_window, window_of
from ase_roughcontact.windows.footprint import Footprint
from ase_roughcontact.windows.memory import check_memory

# A window is kept as long as it has at most this many times the atoms that it needs.
_KEPT = 2.0
# Largest factor by which a window that was too small becomes deeper at once.
_DEEPER = 2.0
# Where the wall only repels there is one state. From flat atoms solvers come to it
# sooner than from a contact in a box of so many times fewer atoms.
_AFRESH = 1.1
# Normal force of a smooth sphere, over E* times penetration times half the side of the
# box that it overlaps: sqrt(8)/3 by Hertz.
_HERTZ = math.sqrt(8.0) / 3.0


# Boxes of more atoms are made for the contact rather than for all that could touch,
# and this much longer.
_LARGE = 256 * 256
_LONGER = 1.03
# The gap beside a Hertz contact of radius a, at a (1 + e), is this times e^(3/2), in
# units of a^2/(pi R).
_OPENING = 8.0 * math.sqrt(2.0) / 3.0


class FixedWindow:
    """The window of the atoms as they are.

    Parameters
    ----------
    atoms : Atoms
        With a `RoughContact` calculator.
    edge : {"raise", "ignore"}
        What to do when the wall acts on an atom at the edge of a free window.
    """

    def __init__(self, atoms: Atoms, edge: str) -> None:
        self._edge = edge
        self._layout = asdict(atoms.calc.layout(atoms))
        self.first_contact = atoms.calc.contact(atoms).first_contact

    def place(self, atoms: Atoms, control: str) -> None:
        """Do nothing before the atoms are relaxed."""

    def system(self) -> dict:
        """Return what tells the window apart from others."""
        return self._layout

    def settle(self, atoms: Atoms) -> None:
        """Do nothing once the atoms are relaxed."""

    def grow(self, atoms: Atoms) -> bool:
        """Raise `RuntimeError` if the wall acts at the edge of a free window."""
        if self._edge == "ignore" or atoms.pbc.any():
            return False
        acts = atoms.calc.state(atoms).pressure != 0.0
        for rows in (acts, acts.T):
            if rows[[0, -1]].any():
                raise RuntimeError(
                    "the contact or its attraction has come to the edge of the window "
                    f"of {acts.shape} atoms: give a larger shape (or edge='ignore' if "
                    "the indenter ends there)"
                )
        return False


class AutoWindow:
    """A window that follows the contact.

    Parameters
    ----------
    atoms : Atoms
        Of a free half space, with a `RoughContact` calculator.

    Attributes
    ----------
    first_contact : float
        Height of the indenter at which the flat substrate begins to repel it (Å).

    Raises
    ------
    ValueError
        If the indenter does not rise out of reach.
    """

    def __init__(self, atoms: Atoms) -> None:
        layout, contact = atoms.calc.layout(atoms), atoms.calc.contact(atoms)
        indenter = atoms.calc.parameters["indenter"]
        self.footprint = Footprint(indenter, layout.spacing, layout.origin)
        self.wall = contact.interaction
        self.modulus = contact.halfspace.contact_modulus
        self.first_contact = self.wall.contact_distance - self.footprint.lowest
        self._spreading: AdhesionEstimate | None = None
        if self.wall.attractive and isinstance(indenter, RoughSphere):
            spacing = layout.spacing
            self._spreading = AdhesionEstimate(
                indenter, self.wall, self.modulus, spacing
            )
        self._filled = _HERTZ
        self._level = -np.inf
        self._acting: Box | None = None
        self._settled = math.inf

    def place(self, atoms: Atoms, control: str) -> None:
        """Choose the window before the atoms are relaxed.

        Parameters
        ----------
        atoms : Atoms
            At the height of the step, or under its load, and displaced as they were;
            changed in place.
        control : str
            Under "loads" the height is not known yet, and guessed.

        Raises
        ------
        ValueError
            If an atom could touch at which the surface is not known.
        MemoryError
            If attraction spreads the contact over more atoms than the memory holds.
        """
        height = float(atoms.positions[-1, 2])
        load = atoms.calc.parameters["load"] if control == "loads" else None
        spread = self._spread(atoms, load)
        if load is not None:
            height = self._expected(load, height)
        self._level = self.wall.cutoff - height
        if control != "loads":
            self.footprint.check(self._level)
        box = self.footprint.known(self.footprint.below(self._level))
        window = window_of(atoms.calc.layout(atoms))
        if not self.wall.attractive and box.size > _AFRESH * self._settled:
            self._flatten(atoms)
        needed = self._window(self._level, self._kept_acting(atoms, window))
        if spread is not None and not needed.contains(spread):
            needed = needed.union(spread)
        large = window.size > _KEPT * self.footprint.roomy(needed).size
        if large or not window.contains(needed):
            self._exchange(atoms, needed)

    def forecast(self, control: str, target: float) -> Box:
        """Window that a step is likely to have.

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
            If an atom could touch at which the surface is not known.
        """
        height = target
        if control == "loads":
            height = self._expected(target, self.first_contact)
        elif control == "penetrations":
            height = self.first_contact - target
        level = self.wall.cutoff - height
        self.footprint.check(level)
        return self.footprint.roomy(self._window(level, None))

    def grow(self, atoms: Atoms) -> bool:
        """Grow the window if an atom outside could feel the wall.

        Parameters
        ----------
        atoms : Atoms
            Relaxed; changed in place.

        Returns
        -------
        bool
            Whether it has grown, so that the atoms must be relaxed again.

        Raises
        ------
        ValueError
            If an atom could touch at which the surface is not known.
        """
        level = self.wall.cutoff - float(atoms.positions[-1, 2])
        window, lowest = window_of(atoms.calc.layout(atoms)), self.footprint.lowest
        depth = max(self._level - lowest, 1e-3 * self.footprint.spacing)
        if level - lowest > _DEEPER * depth and not self._all_below(level, window):
            # under load, an indenter comes out too deep in too small a window
            self._level = lowest + _DEEPER * depth
            needed = self._window(self._level, window)
            if not self.wall.attractive:
                self._flatten(atoms)
        else:
            self._level = level
            missing = self._missing(atoms, window)
            if missing is None:
                self.settle(atoms)
                return False
            needed = missing
        self._exchange(atoms, needed)
        return True

    def settle(self, atoms: Atoms) -> None:
        """Remember a relaxed state, from which the next step is guessed."""
        layout, height = atoms.calc.layout(atoms), float(atoms.positions[-1, 2])
        window = window_of(layout)
        box = self.footprint.below(self.wall.cutoff - height)
        self._settled = box.size
        load, depth = atoms.calc.parameters["load"], self.first_contact - height
        if load > 0.0 and depth > 0.0 and not self.wall.attractive:
            self._filled *= load / self._carried(depth, _half_side(box))
        if self.wall.attractive:
            near = self._gap(atoms, window, window) < self.wall.cutoff
            self._acting = Box.bounding(near, window.start)

    def system(self) -> dict:
        """Return what tells the lattice apart from others, whatever the window."""
        spacing = self.footprint.spacing
        offset = [round(x / spacing, 9) for x in self.footprint.offset]
        return {"window": "auto", "spacing": spacing, "offset": offset}

    def _exchange(self, atoms: Atoms, needed: Box) -> None:
        """Exchange the window, if there is memory for it."""
        window = self.footprint.roomy(needed)
        check_memory(window.shape)
        exchange_window(atoms, window)

    def _spread(self, atoms: Atoms, load: float | None) -> Box | None:
        """Atoms over which a contact of flat atoms spreads by itself, if it does.

        From smaller windows it would fill one after the other.
        """
        if self._spreading is None:
            return None
        height = float(atoms.positions[-1, 2])
        touches = height <= self.first_contact if load is None else load > 0.0
        if not touches or displacement(atoms, atoms.calc.layout(atoms)).any():
            return None
        radius = self._spreading.checked(self.wall.contact_distance - height, load)
        if not radius:
            return None
        half = math.ceil(radius / self.footprint.spacing)
        return self.footprint.known(Box((-half, -half), (2 * half + 1,) * 2))

    def _kept_acting(self, atoms: Atoms, window: Box) -> Box | None:
        """Atoms that the wall acts on before the step, which attraction may keep."""
        if not self.wall.attractive:
            return None
        displaced = displacement(atoms, atoms.calc.layout(atoms)).any()
        return self._acting or (window if displaced else None)

    def _window(self, level: float, also: Box | None) -> Box:
        """Window for a level, which holds some other atoms, too.

        Of a large box only the part that is expected to touch.
        """
        footprint = self.footprint
        box = footprint.known(footprint.below(level)).union(also)
        if box.size > _LARGE:
            part = footprint.below(self._touched(level))
            box = footprint.known(part).union(also)
        return box

    def _touched(self, level: float) -> float:
        """Level below which are the atoms that are expected to touch.

        The surface gives way: beside a smooth sphere's contact its gap is Hertz's, and
        atoms touch where this is less than the roughness is deep, and the wall reaches.
        In a paraboloid's box the side goes with the root of the depth.
        """
        lowest, wall = self.footprint.lowest, self.wall
        rough = max(-lowest, 0.0) + wall.cutoff - wall.contact_distance
        depth = level - lowest
        smooth = depth - rough
        if smooth <= 0.0:
            return level
        beside = (math.pi * rough / (_OPENING * smooth)) ** (2.0 / 3.0)
        part = _LONGER * (1.0 + beside) * math.sqrt(smooth / (2.0 * depth))
        return lowest + depth * min(part, 1.0) ** 2

    def _all_below(self, level: float, window: Box) -> bool:
        """Whether a window holds all atoms lower than a level."""
        return window.contains(self.footprint.known(self.footprint.below(level)))

    def _missing(self, atoms: Atoms, window: Box) -> Box | None:
        """Window that holds the atoms outside that the wall reaches; None if none."""
        level = self._level
        self.footprint.check(level)
        if self.wall.attractive:
            lift = float(displacement(atoms, atoms.calc.layout(atoms)).max())
            level += max(lift, 0.0)
        if self._all_below(level, window):
            return None
        self.footprint.check(level)
        wide = self.footprint.known(self.footprint.below(level)).union(window)
        near = self._gap(atoms, window, wide) < self.wall.cutoff
        needed = window.union(Box.bounding(near, wide.start))
        return None if needed == window else needed

    def _flatten(self, atoms: Atoms) -> None:
        """Forget the displacement, and under a load the height."""
        set_displacement(atoms, np.zeros(len(atoms) - 1))
        if not indenter_fixed(atoms):
            atoms.positions[-1, 2] = self.first_contact

    def _expected(self, load: float, height: float) -> float:
        """Height at which the overlap is as large as the load needs, or as before."""
        if load <= 0.0:
            return height
        depth = 1e-3 * self.footprint.spacing
        most = load / self._carried(1.0, 0.5)
        while depth < most:
            level = self.wall.cutoff - self.first_contact + depth
            box = self.footprint.below(level)
            if self._carried(depth, _half_side(box)) > load:
                break
            if self.footprint.known(box) != box:
                break
            depth *= 1.2
        return self.first_contact - min(depth, most)

    def _carried(self, depth: float, half: float) -> float:
        """Load at a depth with a box of a half side in spacings, as last time."""
        return self._filled * self.modulus * depth * half * self.footprint.spacing

    def _gap(self, atoms: Atoms, window: Box, wide: Box) -> np.ndarray:
        """Gap of the atoms of a wider window."""
        contact: Contact = atoms.calc.contact(atoms)
        height = float(atoms.positions[-1, 2])
        if wide is window:
            return contact.gap(displacement(atoms, atoms.calc.layout(atoms)), height)
        pressure = carry(atoms.calc.elastic_pressure(atoms), window, wide)
        halfspace = contact.halfspace.resized(wide.shape, self.footprint.spacing)
        undeformed = height + self.footprint.heights(wide)
        return undeformed - halfspace.displacement(pressure)


def _half_side(box: Box) -> float:
    return 0.25 * sum(box.shape)
