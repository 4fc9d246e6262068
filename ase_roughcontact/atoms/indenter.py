"""The indenter atom: whether it can move, and which surface it stands for."""

from __future__ import annotations

import numpy as np
from ase import Atoms

from ase_roughcontact.atoms.sticking import Sticking

#: Key of `Atoms.info` under which `substrate` stores the `surface_id` of the indenter.
INDENTER_KEY = "indenter"


def indenter_fixed(atoms: Atoms) -> bool:
    """Return whether a constraint cancels the force on the indenter along z.

    Parameters
    ----------
    atoms : Atoms
        Substrate and indenter.

    Returns
    -------
    bool
    """
    if not atoms.constraints:
        return False
    force = np.zeros((len(atoms), 3))
    force[-1, 2] = 1.0
    for constraint in atoms.constraints:
        # others add a force
        if not hasattr(constraint, "adjust_potential_energy") and not isinstance(
            constraint, Sticking
        ):
            constraint.adjust_forces(atoms, force)
    return bool(force[-1, 2] == 0.0)


def check_surface(atoms: Atoms, identity: str | None) -> None:
    """Raise `ValueError` if atoms were built for another indenter.

    Parameters
    ----------
    atoms : Atoms
        Substrate and indenter.
    identity : str or None
        `surface_id` of the indenter to be used; None is not checked.
    """
    built_for = atoms.info.get(INDENTER_KEY)
    if None not in (built_for, identity) and built_for != identity:
        raise ValueError(
            f"the atoms were built for the indenter {built_for}, got {identity}: give "
            "substrate() and the calculator the same indenter, or delete "
            f"atoms.info[{INDENTER_KEY!r}] to replace the indenter on purpose"
        )
