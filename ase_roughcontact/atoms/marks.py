"""The mark of atoms in the tag of the indenter, which all formats of ASE keep.

ASE writes neither `Atoms.info` nor arrays of other names to .json and .db, and no such
arrays to .traj. From the tag of the indenter, atoms that have lost them are recognised:
it says how many fields the surface keeps of earlier steps, for which indenter the atoms
were built, and whether it was fixed. It is the sum of

- 2^30, by which it differs from the tags of users,
- 2^29 if the indenter is fixed,
- 2^24 times the number of fields of `State.history`, at most 31, and
- 24 bits of a CRC-32 of the `surface_id` of the indenter, zero if it has none.

Frames of `snapshot` have small tags, as viewers colour atoms by their range. A frame
with fields of earlier steps has initial charges, and the tag 6 on the indenter alone.
"""

from __future__ import annotations

import zlib

import numpy as np
from ase import Atoms

from ase_roughcontact.atoms.info import INDENTER_KEY, info_of
from ase_roughcontact.atoms.sticking import indenter_fixed

#: Tag of the indenter in a frame with a surface that keeps fields of earlier steps.
TAG_KEPT = 6

# Part of a tag that says that it is a mark.
_MARK_FLAG = 2**30
# Part of a mark that says that the indenter is fixed.
_FIXED_FLAG = 2**29
# Part of a mark for each field that the surface keeps; smaller parts are a digest.
_FIELD_UNIT = 2**24
# Largest number of fields in a mark.
_MAX_FIELDS = 31


def set_mark(atoms: Atoms, fields: int) -> None:
    """Mark atoms, in place.

    Parameters
    ----------
    atoms : Atoms
        Their `info` has the `surface_id` of the indenter, if it has one.
    fields : int
        Number of fields that the surface keeps of earlier steps.
    """
    mark = _MARK_FLAG + _FIELD_UNIT * min(fields, _MAX_FIELDS)
    mark += _digest(info_of(atoms).get(INDENTER_KEY))
    if indenter_fixed(atoms):
        mark += _FIXED_FLAG
    if not atoms.has("tags"):
        atoms.new_array("tags", np.zeros(len(atoms), np.int32))
    atoms.arrays["tags"][-1] = mark


def was_fixed(atoms: Atoms) -> bool:
    """Return whether the indenter was fixed, or atoms do not say how they were built.

    The latter have neither tags nor the name of the indenter, as from a NetCDF file.
    """
    mark = _mark_of(atoms)
    if mark:
        return bool(mark & _FIXED_FLAG)
    return not atoms.has("tags") and INDENTER_KEY not in info_of(atoms)


def check_indenter(atoms: Atoms, identity: str | None) -> None:
    """Raise `ValueError` if atoms were built for another indenter.

    Parameters
    ----------
    atoms : Atoms
        Substrate and indenter.
    identity : str or None
        `surface_id` of the indenter to be used; None is not checked.
    """
    built_for = info_of(atoms).get(INDENTER_KEY)
    same = True
    if None not in (built_for, identity):
        same = built_for == identity
    elif identity is not None:
        digest = _mark_of(atoms) % _FIELD_UNIT
        same = digest in (0, _digest(identity))
    if not same:
        raise ValueError(
            f"the atoms were built for {_named(built_for)}, got {identity}: give "
            "substrate() and the calculator the same indenter, or replace it by "
            f"atoms.info.pop({INDENTER_KEY!r}, None) and atoms.set_tags(0)"
        )


def marked_fields(atoms: Atoms) -> int:
    """Return how many fields a surface keeps, at least, also in a frame."""
    if _is_frame(atoms):
        return 1
    return _mark_of(atoms) % _FIXED_FLAG // _FIELD_UNIT


def _named(identity: str | None) -> str:
    return "another indenter" if identity is None else f"the indenter {identity}"


def _digest(identity: str | None) -> int:
    return zlib.crc32(identity.encode()) % _FIELD_UNIT if identity else 0


def _mark_of(atoms: Atoms) -> int:
    """Return the mark of atoms, zero without."""
    tag = _tag_of(atoms)
    return tag if tag >= _MARK_FLAG else 0


def _is_frame(atoms: Atoms) -> bool:
    """Return whether atoms are a frame with fields of earlier steps."""
    if not (atoms.has("tags") and atoms.has("initial_charges")):
        return False
    last = len(atoms) - 1
    return np.flatnonzero(atoms.arrays["tags"] == TAG_KEPT).tolist() == [last]


def _tag_of(atoms: Atoms) -> int:
    return int(atoms.arrays["tags"][-1]) if atoms.has("tags") else 0
