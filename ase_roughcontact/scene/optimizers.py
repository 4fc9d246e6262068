"""Optimizers by the names used in scene files.

One more is an entry: ``OPTIMIZERS["BFGS"] = on_modes(BFGS)``.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ase import Atoms
from ase.optimize import FIRE, FIRE2, LBFGS, BFGSLineSearch

from ase_roughcontact.optimize import ActiveSet, FourierModes, NewtonKrylov


def on_modes(
    optimizer: type, limit_steps: bool = False, **options: Any
) -> Callable[..., Any]:
    """Return a function that applies an optimizer of ASE to `FourierModes` of atoms.

    Parameters
    ----------
    optimizer : type
        Optimizer class of ASE.
    limit_steps : bool
        Whether to set the option ``maxstep`` to that of the modes.
    **options
        Further options of the optimizer.

    Returns
    -------
    callable
        Called with atoms and further options, as the optimizer would be.
    """

    def on_modes_of(atoms: Atoms, **others: Any) -> Any:
        modes = FourierModes(atoms)
        limit = {"maxstep": modes.maxstep} if limit_steps else {}
        return optimizer(modes, **options, **limit, **others)

    return on_modes_of


OPTIMIZERS: dict[str, Callable[..., Any]] = {
    "NewtonKrylov": NewtonKrylov,
    "ActiveSet": ActiveSet,
    "LBFGS": on_modes(LBFGS, alpha=1.0, memory=20),
    "FIRE": on_modes(FIRE, limit_steps=True),
    "FIRE2": on_modes(FIRE2, limit_steps=True),
    "BFGSLineSearch": on_modes(BFGSLineSearch),
}
