"""Formats of instruments that afmformats reads: JPK, AFM workshop, NT-MDT, HDF5."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np

from ase_roughcontact._util.extras import imported, silenced
from ase_roughcontact._util.files import PathName
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.fitting.formats.table import (
    ArrayColumn,
    Calibration,
    CurveTable,
    Position,
    Segment,
    chosen_curve,
)

# Columns of afmformats, with units, and whether they increase away from the surface.
_COLUMNS: dict[str, tuple[str, bool | None]] = {
    "force": ("N", None),
    "height (measured)": ("m", True),
    "height (piezo)": ("m", True),
    "time": ("s", None),
}
# Segments by the modality of the measurement, in the order of their numbers.
_SEGMENTS = {
    "force-distance": ("approach", "retraction"),
    "creep-compliance": ("approach", "hold", "retraction"),
    "stress-relaxation": ("hold", "approach", "hold", "retraction"),
}
# Metadata of afmformats that a user can give, with the options for them.
_ADVICE = {
    "spring constant": (
        '--cantilever "0.05 N/m", or for a scene cantilever_stiffness in [path]'
    ),
    "sensitivity": '--sensitivity "50 nm/V"',
}


def read_instrument(
    file: PathName, curve: int | None, calibration: Calibration
) -> CurveTable:
    """Return a curve of a file.

    Parameters
    ----------
    file : path
        File in a format of afmformats.
    curve : int, optional
        Number of the curve, from 1; needed if there are several.
    calibration : Calibration
        Calibration for quantities that the file does not contain.

    Raises
    ------
    ValueError
        If the file can't be read, has several curves, or neither contains a calibration
        nor is one given.
    ImportError
        If afmformats is missing.
    """
    need = f"{file} needs the package afmformats"
    afmformats = imported("afmformats", "curves", need, "; or export the curve as text")
    with _readable(file, afmformats.errors):
        curves = _loaded(afmformats, file, calibration)
    chosen = curves[chosen_curve(file, curve, len(curves))]
    with _readable(file, afmformats.errors):  # columns are read when they are needed
        segments = _segments(chosen)
        stiffness = chosen.metadata.get("spring constant")
        sensitivity = chosen.metadata.get("sensitivity")
        position = _position(chosen.metadata)
    return CurveTable(
        segments,
        stiffness * UNITS["N/m"] if stiffness else None,
        sensitivity * UNITS["m"] if sensitivity else None,
        position,
        len(curves),
    )


@contextmanager
def _readable(file: PathName, errors: Any) -> Iterator[None]:
    """Raise `ValueError` in place of the errors of afmformats, and silence it."""
    try:
        with silenced():
            yield
    except errors.MissingMetaDataError as error:
        raise ValueError(_missing(file, error.meta_keys)) from error
    except (Exception, errors.AFMFileFormatError) as error:  # not an Exception
        raise ValueError(f"cannot read a force curve from {file}: {error}") from error


def _loaded(afmformats: Any, file: PathName, calibration: Calibration) -> list[Any]:
    """Return the curves of a file, with the given calibration where it has none."""
    try:
        curves = afmformats.load_data(file)
    except afmformats.errors.MissingMetaDataError as error:
        given = {}
        if calibration.stiffness:
            given["spring constant"] = calibration.stiffness / UNITS["N/m"]
        if calibration.sensitivity:
            given["sensitivity"] = calibration.sensitivity / UNITS["m"]
        override = {key: given[key] for key in error.meta_keys if key in given}
        curves = afmformats.load_data(file, meta_override=override)
    return list(curves)


def _position(metadata: Mapping[str, Any]) -> Position | None:
    """Return the place of a curve, with its numbers in a grid if there is one."""
    x, y = (metadata.get(f"position {axis}") for axis in "xy")
    if x is None or y is None:
        return None
    numbers = (metadata.get(f"grid index {axis}") for axis in "xy")
    return Position(x * UNITS["m"], y * UNITS["m"], *numbers)


def _missing(file: PathName, keys: list[str]) -> str:
    """Return the message for a file without a calibration."""
    advice = " and ".join(_ADVICE.get(key, key) for key in keys)
    return f"{file} has no {' and no '.join(keys)} of the cantilever: give {advice}"


def _segments(curve: Any) -> list[Segment]:
    """Return the segments of a curve; a single one may hold approach and retraction."""
    names = [name for name in _COLUMNS if name in curve]
    number = np.asarray(curve["segment"])
    # the class of a curve from a file of afmformats does not follow its modality
    kinds = _SEGMENTS[curve.metadata.get("imaging mode", "force-distance")]
    segments = []
    for each in np.unique(number):
        if each >= len(kinds):
            raise ValueError(
                f"segment {each + 1} of the {len(np.unique(number))} is not one of "
                f"{', '.join(kinds)}: export the curve as text"
            )
        columns = [
            ArrayColumn(name, *_COLUMNS[name], np.asarray(curve[name])[number == each])
            for name in names
        ]
        segments.append(Segment(kinds[each], columns))
    if len(segments) == 1:
        return [Segment(None, segments[0].columns)]
    return segments
