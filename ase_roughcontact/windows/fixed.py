"""Fixed windows: never exchanged, but their edge is checked."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np
from ase import Atoms

from ase_roughcontact.atoms.calculator import contact_of, grid_of
from ase_roughcontact.topography import RoughSphere


class FixedWindow:
    """Window that stays; it has the methods of `AutoWindow`.

    Parameters
    ----------
    atoms : Atoms
        With a `RoughContact` calculator.
    edge : {"raise", "ignore"}
        What to do if the wall acts on an atom at the edge of the window of a free half
        space.

    Attributes
    ----------
    first_contact : float
        Height at which the indenter begins to repel the flat substrate (Å).
    """

    def __init__(self, atoms: Atoms, edge: str) -> None:
        self._edge = edge
        self._grid = asdict(grid_of(atoms))
        self.first_contact = contact_of(atoms).first_contact

    def choose(self, atoms: Atoms, control: str) -> None:
        """Keep the window."""

    def accept(self, atoms: Atoms) -> None:
        """Keep the window."""

    def enlarge_if_needed(self, atoms: Atoms) -> bool:
        """Return False; raise `RuntimeError` if the wall acts at the edge."""
        if self._edge == "ignore" or atoms.pbc.any():
            return False
        acts = atoms.calc.state(atoms).pressure != 0.0
        if at_edge(acts):
            advice = "give a larger shape or 'auto'"
            if not isinstance(atoms.calc.parameters["indenter"], RoughSphere):
                advice += " (or edge='ignore' if the indenter ends there)"
            raise RuntimeError(
                "the contact or its attraction has reached the edge of the window of "
                f"{acts.shape} atoms: {advice}"
            )
        return False

    def describe_lattice(self) -> dict[str, Any]:
        """Return what distinguishes the atoms from others, for resuming a path."""
        return self._grid


def at_edge(mask: np.ndarray) -> bool:
    """Return whether a mask of the atoms of a window is true at its edge."""
    return bool(mask[[0, -1]].any() or mask[:, [0, -1]].any())
