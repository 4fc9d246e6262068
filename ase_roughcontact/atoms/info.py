"""The `info` of atoms and frames: keys, the indenter, and fields as text."""

from __future__ import annotations

import base64
import zlib

import numpy as np
from ase import Atoms

#: Key of `Atoms.info` under which `substrate` stores the `surface_id` of the indenter.
INDENTER_KEY = "indenter"
#: Key of `Atoms.info` of what decides whether the indenter is fixed, and its value
#: if paths do.
SUPPORT_KEY, BY_PATH = "support", "path"
#: Key in the `info` of a frame of the pressures.
PRESSURE = "pressure"
#: Key in the `info` of a frame of the depth by which its past lowers the surface, by
#: creep or by coupled friction.
PAST_DEPTH = "past_depth"
#: Key in the `info` of a frame of the names of what its surface keeps.
HISTORY = "history"
#: Key in the `info` of a frame of whether its surface has kept the plastic depth.
INDENTED = "indented"
#: Key in the `info` of a frame of the mask of the atoms that touch a hard wall with
#: attraction, which may be under a tension.
TOUCHING = "touching"
#: Key in the `info` of atoms of the lattice from which they are displaced laterally.
LATTICE = "lattice"


def info_of(frame: Atoms) -> dict:
    """Return the `info` of a frame, and the data of a database."""
    return frame.info.get("data", {}) | frame.info


def field_of(frame: Atoms, key: str, shape: tuple[int, int]) -> np.ndarray:
    """Return a field that `snapshot` has compressed, of the shape of the window."""
    raw = zlib.decompress(base64.b64decode(info_of(frame)[key] + "=="))
    return np.frombuffer(raw, "<f8").reshape(shape)


def as_text(field: np.ndarray) -> str:
    """Return a field as text that any file format can hold."""
    raw = np.ascontiguousarray(field, "<f8")
    text = base64.b64encode(zlib.compress(raw.tobytes(), 1)).decode()
    return text.rstrip("=")  # extxyz cannot read a value that ends with it
