"""Frames as bytes: a description, and compressed fields in single precision."""

from __future__ import annotations

import struct
import zlib
from dataclasses import asdict
from typing import IO, Any

import numpy as np
from ase import Atoms
from ase.calculators.singlepoint import SinglePointCalculator
from ase.constraints import dict2constraint
from ase.io.jsonio import decode, encode
from ase.units import GPa

from ase_roughcontact.atoms.grid import SurfaceGrid
from ase_roughcontact.atoms.info import HISTORY, LATTICE, PRESSURE, as_text
from ase_roughcontact.atoms.marks import TAG_KEPT
from ase_roughcontact.atoms.snapshot import TAG_OPEN, is_in_trajectories
from ase_roughcontact.loading.step_frame import StepFrame

# Format of the size of the description.
_SIZE_FORMAT = struct.Struct("<I")
# Level of compression: masks and empty surroundings of a contact take no space.
_COMPRESSION_LEVEL = 1


class SinglePointEnergy(SinglePointCalculator):
    """Energy of a frame, without a reference of the calculator to itself.

    ASE stores a method of the calculator in the calculator if this one is missing: the
    arrays of a frame would stay in memory until garbage is collected.
    """

    def get_spin_polarized(self) -> bool:
        """Return that there are no spins."""
        return False


def packed(frame: StepFrame) -> bytes:
    """Return the frame of a step as bytes.

    Fields that trajectories do not have are left out; see `HistoryEntry`.
    """
    arrays: dict[str, np.ndarray] = {
        key: field.astype(_type_of(field))
        for key, field in frame.fields.items()
        if is_in_trajectories(key)
    }
    arrays["z"] = frame.displacement.astype(np.float32)
    arrays["tags"] = frame.tags.astype(np.uint8)
    if frame.lateral is not None:
        arrays["lateral"] = frame.lateral.astype(np.float32)
    atoms = frame.atoms
    description = {
        "grid": asdict(frame.grid),
        "number": atoms.number,
        "indenter": [*atoms.axis, frame.height],
        "cell": atoms.cell.tolist(),
        "constraints": atoms.constraints,
        "energy": frame.energy,
        "info": {k: v for k, v in frame.info.items() if _is_storable(v)},
        "arrays": [[k, v.dtype.str, list(v.shape)] for k, v in arrays.items()],
    }
    text = encode(description).encode()
    compressed = [_compressed(each) for each in arrays.values()]
    sizes = np.array([len(each) for each in compressed], "<u8").tobytes()
    return b"".join([_SIZE_FORMAT.pack(len(text)), text, sizes, *compressed])


def described(contents: bytes) -> dict[str, Any]:
    """Return the description of a frame without its fields."""
    (length,) = _SIZE_FORMAT.unpack_from(contents)
    return decode(contents[_SIZE_FORMAT.size : _SIZE_FORMAT.size + length].decode())


def read_description(opened: IO[bytes]) -> bytes:
    """Read the beginning of a frame from a file, up to the end of its description."""
    size = opened.read(_SIZE_FORMAT.size)
    (length,) = _SIZE_FORMAT.unpack(size)
    return size + opened.read(length)


def unpacked(contents: bytes) -> Atoms:
    """Return the frame of bytes; see `packed`."""
    description, arrays = described(contents), _arrays_of(contents)
    grid = SurfaceGrid(**{k: _plain(v) for k, v in description["grid"].items()})
    frame = grid.atoms(description["number"], 0.0)
    frame.info = description["info"]
    axis = frame.info.get(LATTICE, {}).get("axis", description["indenter"][:2])
    frame.positions[:-1, :2] = grid.sites(np.array(axis))
    if "lateral" in arrays:
        frame.positions[:-1, :2] += arrays.pop("lateral").reshape(2, -1).T
    frame.positions[:-1, 2] = arrays.pop("z").ravel()
    frame.positions[-1] = description["indenter"]
    frame.cell = description["cell"]
    indenter = TAG_KEPT if frame.info.get(HISTORY) else TAG_OPEN
    frame.set_tags(np.append(arrays.pop("tags"), indenter))
    pressure = arrays[PRESSURE].astype(float).ravel()
    frame.set_initial_charges(np.append(pressure / GPa, 0.0))
    frame.info |= {key: as_text(field) for key, field in arrays.items()}
    frame.set_constraint([dict2constraint(each) for each in description["constraints"]])
    frame.calc = SinglePointEnergy(frame, energy=description["energy"])
    return frame


def _arrays_of(contents: bytes) -> dict[str, np.ndarray]:
    """Return the fields of a frame by name."""
    (length,) = _SIZE_FORMAT.unpack_from(contents)
    kinds = described(contents)["arrays"]
    start = _SIZE_FORMAT.size + length
    sizes = np.frombuffer(contents, "<u8", len(kinds), start)
    start, arrays = start + sizes.nbytes, {}
    for (name, kind, shape), size in zip(kinds, sizes.tolist(), strict=True):
        compressed = contents[start : start + size]
        arrays[name] = _decompressed(compressed, kind).reshape(shape)
        start += size
    return arrays


def _compressed(field: np.ndarray) -> bytes:
    """Return the compressed bytes of a field: first bytes of all numbers, and so on.

    Neighbours have nearly the same first bytes, which take little space and time.
    """
    by_number = np.ascontiguousarray(field).view(np.uint8).reshape(field.size, -1)
    return zlib.compress(by_number.T.tobytes(), _COMPRESSION_LEVEL)


def _decompressed(compressed: bytes, kind: str) -> np.ndarray:
    """Return the numbers of a field, shape (count,); see `_compressed`."""
    raw = np.frombuffer(zlib.decompress(compressed), np.uint8)
    by_number = raw.reshape(np.dtype(kind).itemsize, -1).T
    return np.ascontiguousarray(by_number).view(kind).ravel()


def _is_storable(value: Any) -> bool:
    """Return whether ASE can write a value; users may store others in `info`."""
    try:
        encode(value)
    except TypeError:
        return False
    return True


def _type_of(field: np.ndarray) -> type:
    """Return the type of a field in files: a byte for masks."""
    is_mask = np.isin(field, (0.0, 1.0)).all()
    return np.uint8 if is_mask else np.float32


def _plain(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value
