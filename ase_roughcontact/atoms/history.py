"""History of the surface as arrays of the atoms: see `State.history`.

The frame of a path has the same fields as text in its `info`, under the same names.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from ase import Atoms

from ase_roughcontact._util.kernels import array_equal
from ase_roughcontact.atoms.grid import (
    SurfaceGrid,
    lateral_displacement,
    on_grid,
    set_lateral_displacement,
)
from ase_roughcontact.atoms.info import (
    HISTORY,
    INDENTED,
    LATTICE,
    field_of,
    info_of,
)
from ase_roughcontact.atoms.marks import marked_fields, set_mark
from ase_roughcontact.atoms.sticking import check_kept, sticking_of
from ase_roughcontact.contact.history import entry_of, is_entry
from ase_roughcontact.contact.state import (
    DISPLACEMENTS,
    PLASTIC_DEPTH,
    SLIPPING,
    TRACTIONS,
)
from ase_roughcontact.elasticity.creep import Creep

#: Key in the `info` of atoms of the creep of their solid.
CREEP = "creep"


def kept_keys(atoms: Atoms) -> list[str]:
    """Return the keys of the history that a surface has kept; see `history_of`."""
    info = info_of(atoms)
    keys = [*filter(is_entry, atoms.arrays), *filter(_in_info, info)]
    if PLASTIC_DEPTH in info and info.get(INDENTED):
        keys.append(PLASTIC_DEPTH)
    if LATTICE in info:
        keys += DISPLACEMENTS
    if sticking_of(atoms) is not None:
        keys += [*TRACTIONS, SLIPPING]
    return list(dict.fromkeys(keys))


def check_history(atoms: Atoms) -> None:
    """Raise `ValueError` if atoms have lost the history of their surface."""
    check_kept(atoms)
    kept = kept_keys(atoms)
    lost = set(info_of(atoms).get(HISTORY, ())) - set(kept)
    if lost or len(kept) < marked_fields(atoms):
        raise ValueError(
            "a file has lost the history of these atoms "
            f"({', '.join(sorted(lost)) or 'plastic shape, creep or friction'}): write "
            "snapshot(atoms), to .db and .json with data=frame.info, or start from new "
            "atoms"
        )


def history_of(atoms: Atoms, grid: SurfaceGrid) -> dict[str, np.ndarray]:
    """Return the history that a surface has kept of earlier steps.

    Parameters
    ----------
    atoms : Atoms
        Surface and indenter, or the frame of a path.
    grid : SurfaceGrid
        Grid of the atoms.

    Returns
    -------
    dict of ndarray, shape (n, m)
        Entries of the history on the window; empty for a new surface.
    """
    n, m = grid.window
    history = {}
    for key, values in _entries_of(atoms).items():
        history[key] = values[:-1].reshape(grid.shape)[:n, :m].copy()
    texts = info_of(atoms).keys() - history.keys()
    for key in texts.intersection(kept_keys(atoms)):
        history[key] = field_of(atoms, key, grid.window)
    moved = lateral_displacement(atoms, grid)
    if moved is not None:
        history |= zip(DISPLACEMENTS, moved[:, :n, :m].copy(), strict=True)
    sticking = sticking_of(atoms)
    if sticking is not None:
        friction = np.zeros((2, len(atoms) - 1))
        friction[:, sticking.index] = sticking.friction(atoms.positions[-1, :2]).T
        tractions = friction.reshape(2, *grid.shape)[:, :n, :m] / grid.spacing**2
        history |= zip(TRACTIONS, tractions, strict=True)
        history[SLIPPING] = np.zeros(grid.window)
    return history


def creep_of(atoms: Atoms) -> Creep | None:
    """Return the creep of the solid in which a surface has crept, None without."""
    parameters = info_of(atoms).get(CREEP)
    return Creep(**parameters) if parameters else None


def set_history(
    atoms: Atoms,
    grid: SurfaceGrid,
    history: Mapping[str, np.ndarray],
    creep: Creep | None = None,
) -> None:
    """Set what a surface has kept, and in which solid, in place of what it had."""
    for key in [INDENTED, HISTORY, CREEP, *filter(_in_info, atoms.info)]:
        atoms.info.pop(key, None)
    if creep:
        atoms.info[CREEP] = creep.todict()
    for key in _entries_of(atoms):
        del atoms.arrays[key]
    moved = None
    if DISPLACEMENTS[0] in history:
        moved = on_grid(np.stack([history[key] for key in DISPLACEMENTS]), grid)
    set_lateral_displacement(atoms, grid, moved)
    for key, values in history.items():
        if key in DISPLACEMENTS:
            continue
        entering = entry_of(key).entering
        atoms.arrays[key] = np.append(on_grid(values, grid, entering), 0.0)
    set_mark(atoms, len(kept_keys(atoms)))


def same_history(a: Atoms, b: Atoms) -> bool:
    """Return whether two surfaces have kept the same arrays."""
    return same_arrays(_entries_of(a), _entries_of(b))


def _entries_of(atoms: Atoms) -> dict[str, np.ndarray]:
    """Return the arrays of atoms that are entries of the history of their surface."""
    return {key: values for key, values in atoms.arrays.items() if is_entry(key)}


def same_arrays(a: Mapping[str, np.ndarray], b: Mapping[str, np.ndarray]) -> bool:
    """Return whether two mappings have the same arrays."""
    return a.keys() == b.keys() and all(array_equal(a[key], b[key]) for key in a)


def _in_info(key: str) -> bool:
    """Return whether an entry of frames is kept by the surface if it is there.

    A frame may have the plastic depth under its pressures, which is not kept.
    """
    return is_entry(key) and key != PLASTIC_DEPTH
