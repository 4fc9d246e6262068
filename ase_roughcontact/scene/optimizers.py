"""Optimizers by the names that a scene file gives them."""

from __future__ import annotations

from functools import partial
from typing import Any

from ase import Atoms
from ase.optimize import FIRE, FIRE2, LBFGS, BFGSLineSearch

from ase_roughcontact.optimize import ActiveSet, FourierModes, NewtonKrylov


def _on_modes(cls: type, atoms: Atoms, **options: Any) -> Any:
    """Optimizer of ASE on the scaled modes of the half space."""
    modes = FourierModes(atoms)
    if cls in (FIRE, FIRE2):
        options["maxstep"] = modes.maxstep
    if cls is LBFGS:
        options |= {"alpha": 1.0, "memory": 20}
    return cls(modes, **options)


OPTIMIZERS: dict[str, Any] = {
    "NewtonKrylov": NewtonKrylov,
    "ActiveSet": ActiveSet,
    **{
        cls.__name__: partial(_on_modes, cls)
        for cls in (LBFGS, FIRE, FIRE2, BFGSLineSearch)
    },
}
