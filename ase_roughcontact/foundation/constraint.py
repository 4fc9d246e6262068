"""Constraint that balances the load on a slab."""

from __future__ import annotations

from typing import Any

import numpy as np
from ase import Atoms
from ase.constraints import FixSubsetCom


class HeldLayer(FixSubsetCom):
    """Hold the centre of mass of a layer of atoms.

    Unlike ASE's `FixSubsetCom`, which moves all atoms so that the centre of mass of
    some does not move, it moves those of the layer, as the force of a constraint does:
    dynamics conserve the energy. Files store it as `FixSubsetCom`.

    Parameters
    ----------
    indices : sequence of int
        Atoms of the layer, all of the same mass.
    """

    def adjust_positions(self, atoms: Atoms, new: np.ndarray) -> None:
        """Shift the layer back."""
        new[self.index] += (atoms.positions - new)[self.index].mean(axis=0)

    def copy(self) -> HeldLayer:
        """Return a constraint of the same atoms."""
        return HeldLayer(self.index)

    def todict(self) -> dict[str, Any]:
        """Return the constraint as that of ASE, for files."""
        return {**super().todict(), "name": "FixSubsetCom"}
