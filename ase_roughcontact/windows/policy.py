"""Windows of a free half space that hold the atoms that can touch, and few others.

An atom interacts where the gap ``Z + h - u`` is below the cutoff of the wall. A surface
that is only pushed lies nowhere above its plane, ``u <= 0``, so that only atoms with
heights ``h`` below the level ``cutoff - Z`` can touch: a window that holds these is
exact. Where the wall pulls, the surface bulges. Outside of the atoms that the wall acts
on, the displacement is a harmonic function that falls to zero, so that it is nowhere
higher than on these; this bounds the atoms that have to be looked at.

A window is a box of atoms, or the few `Sites` that can touch. A large box is made for
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
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace, HalfSpace
from ase_roughcontact.elasticity.lattice import Box, Sites
from ase_roughcontact.elasticity.reduced import ScatteredHalfSpace
from ase_roughcontact.topography import RoughSphere
from ase_roughcontact.windows.adhesion_estimate import AdhesionEstimate
from ase_roughcontact.windows.exchange import carry, exchange_window, window_of
from ase_roughcontact.windows.footprint import FEW, Footprint
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


# Squares of the number of scattered atoms that cost as much as one atom of a box.
_PRICE = 16.0
# Counts of scattered atoms are one of few, each this many times the one before.
_RUNG = 1.25
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
        if self._layout["sites"] is not None:
            raise RuntimeError(
                "scattered atoms have no edge that would tell whether others can "
                "touch: give window='auto' (or edge='ignore')"
            )
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
    scatter : bool
        Whether few atoms may be scattered, or have to be in a box as Fourier modes want
        it.

    Attributes
    ----------
    first_contact : float
        Height of the indenter at which the flat substrate begins to repel it (Å).

    Raises
    ------
    ValueError
        If the indenter does not rise out of reach.
    """

    def __init__(self, atoms: Atoms, *, scatter: bool = True) -> None:
        self._few = FEW if scatter else 0
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
        if spread is not None and not _box(needed).holds(spread):
            needed = _box(needed).join(spread)
        large = _cost(window) > _KEPT * _cost(self._roomy(needed))
        if large or not _holds(window, needed):
            self._exchange(atoms, needed)

    def forecast(self, control: str, target: float) -> Box | Sites:
        """Window that a step is likely to have.

        Parameters
        ----------
        control : {"penetrations", "heights", "loads"}
        target : float
            Of the step.

        Returns
        -------
        Box or Sites

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
        return self._roomy(self._window(level, None))

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
            needed = self._window(self._level, _box(window))
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
            self._acting = window.around_those(near)

    def system(self) -> dict:
        """Return what tells the lattice apart from others, whatever the window."""
        spacing = self.footprint.spacing
        offset = [round(x / spacing, 9) for x in self.footprint.offset]
        return {"window": "auto", "spacing": spacing, "offset": offset}

    def _exchange(self, atoms: Atoms, needed: Box | Sites) -> None:
        """Exchange the window, if there is memory for it."""
        window = self._roomy(needed)
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

    def _kept_acting(self, atoms: Atoms, window: Box | Sites) -> Box | None:
        """Atoms that the wall acts on before the step, which attraction may keep."""
        if not self.wall.attractive:
            return None
        displaced = displacement(atoms, atoms.calc.layout(atoms)).any()
        return self._acting or (_box(window) if displaced else None)

    def _window(self, level: float, also: Box | None) -> Box | Sites:
        """Window for a level, which holds some other atoms, too.

        Of a large box only the part that is expected to touch.
        """
        footprint = self.footprint
        box = footprint.known(footprint.below(level)).join(also)
        count = footprint.count(level)
        if also is not None and count <= self._few:
            low = footprint.lowest_sites(FEW).all
            held = np.flatnonzero(also.find(low)[0])
            count = max(count, int(held[-1]) + 1 if held.size else 1)
        if count <= self._few and count**2 < _PRICE * box.size:
            return footprint.lowest_sites(count)
        if box.size > _LARGE:
            part = footprint.below(self._touched(level))
            box = footprint.known(part).join(also)
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

    def _roomy(self, window: Box | Sites) -> Box | Sites:
        """Window of one of few sizes around another."""
        if isinstance(window, Box):
            return self.footprint.roomy(window)
        rungs = math.ceil(math.log(window.size, _RUNG))
        return self.footprint.lowest_sites(min(math.ceil(_RUNG**rungs), FEW))

    def _all_below(self, level: float, window: Box | Sites) -> bool:
        """Whether a window holds all atoms lower than a level."""
        if isinstance(window, Sites):
            return self.footprint.count(level) <= window.size
        return window.holds(self.footprint.known(self.footprint.below(level)))

    def _missing(self, atoms: Atoms, window: Box | Sites) -> Box | Sites | None:
        """Window that holds the atoms outside that the wall reaches; None if none."""
        level = self._level
        self.footprint.check(level)
        if self.wall.attractive:
            lift = float(displacement(atoms, atoms.calc.layout(atoms)).max())
            level += max(lift, 0.0)
        if self._all_below(level, window):
            return None
        self.footprint.check(level)
        count = self.footprint.count(level)
        if isinstance(window, Sites) and count <= FEW:
            wide: Box | Sites = self.footprint.lowest_sites(count)
        else:
            below = self.footprint.known(self.footprint.below(level))
            wide = below.join(_box(window))
        near = self._gap(atoms, window, wide) < self.wall.cutoff
        if isinstance(wide, Sites):
            last = int(np.flatnonzero(near)[-1]) + 1 if near.any() else 0
            return None if last <= window.size else self.footprint.lowest_sites(last)
        reached = wide.around_those(near)
        if isinstance(window, Sites):
            inside = window.find(wide.places(near))[0].all()
            return None if inside else self._window(level, reached)
        needed = window.join(reached)
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

    def _gap(self, atoms: Atoms, window: Box | Sites, wide: Box | Sites) -> np.ndarray:
        """Gap of the atoms of a wider window."""
        contact: Contact = atoms.calc.contact(atoms)
        height = float(atoms.positions[-1, 2])
        if wide is window:
            return contact.gap(displacement(atoms, atoms.calc.layout(atoms)), height)
        pressure = carry(atoms.calc.elastic_pressure(atoms), window, wide)
        spacing, given = self.footprint.spacing, contact.halfspace
        fft = {**given.fft, "measure": False}
        if isinstance(wide, Sites):
            halfspace: HalfSpace = ScatteredHalfSpace(
                wide.all, spacing, self.modulus, **fft
            )
        else:
            halfspace = FreeHalfSpace(wide.shape, spacing, self.modulus, **fft)
        undeformed = height + self.footprint.heights(wide)
        return undeformed - halfspace.displacement(pressure)


def _box(window: Box | Sites) -> Box:
    """Smallest box that holds a window."""
    return window if isinstance(window, Box) else window.box


def _holds(window: Box | Sites, needed: Box | Sites) -> bool:
    """Whether a window holds another of its kind."""
    if isinstance(window, Box) and isinstance(needed, Box):
        return window.holds(needed)
    if isinstance(window, Sites) and isinstance(needed, Sites):
        return bool(window.find(needed.all)[0].all())
    return False


def _cost(window: Box | Sites) -> float:
    """Cost of a convolution, in atoms of a box."""
    return window.size if isinstance(window, Box) else window.size**2 / _PRICE


def _half_side(box: Box) -> float:
    return 0.25 * sum(box.shape)
