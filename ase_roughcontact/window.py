"""Windows of a free half space that hold the atoms that can touch, and few others.

An atom interacts where the gap ``Z + h - u`` is below the cutoff of the wall. A surface
that is only pushed lies nowhere above its plane, ``u <= 0``, so that only atoms with
heights ``h`` below the level ``cutoff - Z`` can touch: a window that holds these is
exact. Where the wall pulls, the surface bulges. Outside of the atoms that the wall acts
on, the displacement is a harmonic function that falls to zero, so that it is nowhere
higher than on these; this bounds the atoms that have to be looked at.
"""

from __future__ import annotations

import math
from copy import copy
from dataclasses import asdict
from typing import Any

import numpy as np
from ase import Atoms

from ase_roughcontact.contact import Contact
from ase_roughcontact.optimize.problem import without_rounding
from ase_roughcontact.silhouette import Box, Silhouette, rest_of
from ase_roughcontact.substrate import (
    Layout,
    displacement,
    indenter_fixed,
    set_displacement,
)

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
        self.silhouette = Silhouette(indenter, layout.spacing, layout.origin)
        self.wall = contact.interaction
        self.modulus = contact.halfspace.contact_modulus
        self.first_contact = self.wall.contact_distance - self.silhouette.lowest
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
        """
        height = float(atoms.positions[-1, 2])
        if control == "loads":
            height = self._expected(atoms.calc.parameters["load"], height)
        self._level = self.wall.cutoff - height
        box = self.silhouette.below(self._level)
        if control != "loads":
            self.silhouette.check(self._level)
        box = self.silhouette.known(box)
        window = box_of(atoms.calc.layout(atoms))
        if self.wall.attractive:
            displaced = displacement(atoms, atoms.calc.layout(atoms)).any()
            box = box.join(self._acting or (window if displaced else None))
        elif box.size > _AFRESH * self._settled:
            self._flatten(atoms)
        enough = _KEPT * self.silhouette.roomy(box).size
        if not window.holds(box) or window.size > enough:
            rewindow(atoms, self.silhouette.roomy(box))

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
        height = float(atoms.positions[-1, 2])
        window, silhouette = box_of(atoms.calc.layout(atoms)), self.silhouette
        box = self._deeper(window, self.wall.cutoff - height)
        if window.holds(box):
            silhouette.check(self.wall.cutoff - height)
            if self.wall.attractive:
                box = self._lifted(atoms, window)
        if not window.holds(box):
            if not self.wall.attractive:
                self._flatten(atoms)
            rewindow(atoms, silhouette.roomy(box.join(window)))
            return True
        self.settle(atoms)
        return False

    def settle(self, atoms: Atoms) -> None:
        """Remember a relaxed state, from which the next step is guessed."""
        layout, height = atoms.calc.layout(atoms), float(atoms.positions[-1, 2])
        window = box_of(layout)
        box = self.silhouette.below(self.wall.cutoff - height)
        self._settled = box.size
        load, depth = atoms.calc.parameters["load"], self.first_contact - height
        if load > 0.0 and depth > 0.0:
            self._filled *= load / self._carried(depth, _half_side(box))
        if self.wall.attractive:
            near = self._gap(atoms, window, window) < self.wall.cutoff
            self._acting = Box.around(near, window.start)

    def system(self) -> dict:
        """Return what tells the lattice apart from others, whatever the window."""
        spacing = self.silhouette.spacing
        offset = [round(x / spacing, 9) for x in self.silhouette.offset]
        return {"window": "auto", "spacing": spacing, "offset": offset}

    def _flatten(self, atoms: Atoms) -> None:
        """Forget the displacement, and under a load the height."""
        set_displacement(atoms, np.zeros(len(atoms) - 1))
        if not indenter_fixed(atoms):
            atoms.positions[-1, 2] = self.first_contact

    def _expected(self, load: float, height: float) -> float:
        """Height at which the overlap is as large as the load needs, or as before."""
        if load <= 0.0:
            return height
        depth = 1e-3 * self.silhouette.spacing
        most = load / self._carried(1.0, 0.5)
        while depth < most:
            level = self.wall.cutoff - self.first_contact + depth
            box = self.silhouette.below(level)
            if self._carried(depth, _half_side(box)) > load:
                break
            if self.silhouette.known(box) != box:
                break
            depth *= 1.2
        return self.first_contact - min(depth, most)

    def _carried(self, depth: float, half: float) -> float:
        """Load at a depth with a box of a half side in spacings, as last time."""
        return self._filled * self.modulus * depth * half * self.silhouette.spacing

    def _deeper(self, window: Box, level: float) -> Box:
        """Box of a level, or of one on the way to it that the window does not hold.

        In too small a window an indenter under load comes out too deep.
        """
        lowest = self.silhouette.lowest
        while True:
            depth = max(self._level - lowest, 1e-3 * self.silhouette.spacing)
            self._level = min(level, lowest + _DEEPER * depth)
            box = self.silhouette.known(self.silhouette.below(self._level))
            if self._level == level or not window.holds(box):
                return box

    def _lifted(self, atoms: Atoms, window: Box) -> Box:
        """Window and the atoms outside which the wall reaches since they bulge."""
        n, m = window.shape
        inside = displacement(atoms, atoms.calc.layout(atoms))[:n, :m]
        level = self.wall.cutoff - float(atoms.positions[-1, 2])
        level += max(float(inside.max()), 0.0)
        box = self.silhouette.below(level)
        if window.holds(box):
            return window
        self.silhouette.check(level)
        wide = window.join(box)
        near = self._gap(atoms, window, wide) < self.wall.cutoff
        return window.join(Box.around(near, wide.start))

    def _gap(self, atoms: Atoms, window: Box, wide: Box) -> np.ndarray:
        """Gap of the atoms in a box around the window."""
        contact: Contact = atoms.calc.contact(atoms)
        height = float(atoms.positions[-1, 2])
        if wide == window:
            return contact.gap(displacement(atoms, atoms.calc.layout(atoms)), height)
        halfspace = contact.halfspace.like(wide.shape, self.silhouette.spacing)
        pressure = _carry(_pressure(atoms), window, wide)
        return height + self.silhouette.heights(wide) - halfspace.displacement(pressure)


def box_of(layout: Layout) -> Box:
    """Window of a layout."""
    i, j = (round(x / layout.spacing) for x in layout.origin)
    return Box((i, j), layout.window)


def rewindow(atoms: Atoms, box: Box) -> None:
    """Exchange the window of a free half space for another, in place.

    The atoms that are in both windows keep their pressure, and all are displaced by
    it. Constraints on the indenter and the calculator stay.

    Parameters
    ----------
    atoms : Atoms
        Of a free half space, with a `RoughContact` calculator.
    box : Box
        The new window; its first atom comes to the origin, as `substrate` has it.

    Raises
    ------
    ValueError
        If the boundary is periodic, or there are constraints on surface atoms.
    """
    if atoms.pbc.any():
        raise ValueError(
            "the window of a periodic half space is its cell: it must stay"
        )
    layout = atoms.calc.layout(atoms)
    old = box_of(layout)
    if old == box:
        return
    carried = _carry(_pressure(atoms), old, box)
    spacing, symbol = layout.spacing, atoms.numbers[0]
    axis = [
        -spacing * i - rest_of(x, spacing)
        for i, x in zip(box.start, layout.origin, strict=True)
    ]
    grid = Layout.grid_for(box.shape, False)
    positions = np.zeros((math.prod(grid) + 1, 3))
    positions[:-1, :2] = spacing * np.indices(grid).reshape(2, -1).T
    positions[-1] = *axis, atoms.positions[-1, 2]
    shift = positions[-1] - atoms.positions[-1]  # along x and y
    constraints = [
        _moved(c, atoms, len(positions) - 1, shift) for c in atoms.constraints
    ]

    atoms.set_constraint()
    atoms.arrays = {
        "numbers": np.append(np.full(len(positions) - 1, symbol), 0),
        "positions": positions,
    }
    n, m = box.shape
    atoms.cell[:] = np.diag([n * spacing, m * spacing, max(n, m) * spacing])
    atoms.set_constraint(constraints)
    if carried.any():
        halfspace = atoms.calc.contact(atoms).halfspace
        set_displacement(atoms, halfspace.surroundings(carried))


def _pressure(atoms: Atoms) -> np.ndarray:
    """Pressure on the window that holds the atoms where they are."""
    layout = atoms.calc.layout(atoms)
    n, m = layout.window
    values = displacement(atoms, layout)
    if not values.any():
        return np.zeros((n, m))
    elastic = atoms.calc.contact(atoms).halfspace.elastic_pressure(values)
    return without_rounding(elastic[:n, :m])


def _carry(values: np.ndarray, old: Box, new: Box) -> np.ndarray:
    """Values on a box, taken from another one, zero outside of it."""
    carried = np.zeros(new.shape)
    common = old.meet(new)
    if min(common.shape) > 0:
        carried[new.index(common)] = values[old.index(common)]
    return carried


def _moved(constraint: object, atoms: Atoms, last: int, shift: np.ndarray) -> object:
    """Constraint of the indenter with its new index and place."""
    index = np.arange(len(atoms))[getattr(constraint, "index", [])]
    if set(np.ravel(index)) != {len(atoms) - 1}:
        raise ValueError(
            f"{constraint} acts on atoms other than the indenter, or is not understood "
            "here: give a fixed window"
        )
    moved: Any = copy(constraint)
    moved.index = last if np.ndim(index) == 0 else np.array([last])
    if getattr(moved, "_type", None) == "point":
        moved.origin = moved.origin + shift
    return moved


def _half_side(box: Box) -> float:
    return 0.25 * sum(box.shape)
