"""Names of the optimizers of this package, and of ASE's on atoms and on modes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import ase.optimize
import ase.optimize.precon
import ase.optimize.sciopt

from ase_roughcontact._util.validation import unknown
from ase_roughcontact.optimize.optimizers import ActiveSet, NewtonKrylov
from ase_roughcontact.optimize.settings import on_modes

# Ending of names of optimizers on the modes.
_ON_MODES = " on modes"


def optimizer_names() -> list[str]:
    """Return the names of all optimizers; names of ASE's also with " on modes"."""
    ours = [NewtonKrylov.__name__, ActiveSet.__name__]
    of_ase = list(_of_ase())
    return ours + of_ase + [name + _ON_MODES for name in of_ase]


def _of_ase() -> dict[str, type]:
    """Return the classes of ASE's optimizers by name."""
    found: dict[str, type] = {}
    for module in (ase.optimize, ase.optimize.precon, ase.optimize.sciopt):
        for name, each in vars(module).items():
            if not (isinstance(each, type) and each.__module__.startswith("ase.")):
                continue
            if issubclass(each, ase.optimize.optimize.Optimizer) and name[0].isupper():
                found[name] = each
    bases = "Optimizer", "SciPyOptimizer", "SciPyGradientlessOptimizer", "QuasiNewton"
    return {name: found[name] for name in sorted(found) if name not in bases}


def optimizer_class(name: str) -> type:
    """Return the class of an optimizer by its name, with or without " on modes".

    Raises
    ------
    ValueError
        If the name is unknown.
    """
    if name not in optimizer_names():
        raise ValueError(unknown(name, optimizer_names(), "optimizer"))
    ours = {each.__name__: each for each in (NewtonKrylov, ActiveSet)}
    kinds: dict[str, type] = ours | _of_ase()
    return kinds[name.removesuffix(_ON_MODES)]


def optimizer_of(name: str) -> Callable[..., Any]:
    """Return a function that makes an optimizer, by name; see `optimizer_class`."""
    kind = optimizer_class(name)
    return on_modes(kind) if name.endswith(_ON_MODES) else kind
