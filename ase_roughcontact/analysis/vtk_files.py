"""Fields on grids in the XML formats of VTK, which ParaView and OVITO read.

They are written without a library: pyevtk leaves out the units of fields, meshio has no
grids but unstructured meshes, eight indices for each cell, and VTK itself is larger
than all other packages that are required.

References
----------
VTK File Formats, https://docs.vtk.org/en/latest/vtk_file_formats/index.html
"""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

# Types of numbers in the files.
_TYPES = {"f4": "Float32", "f8": "Float64", "i1": "Int8"}


def write_image_data(
    path: Path,
    fields: Mapping[str, np.ndarray],
    units: Mapping[str, str],
    shown: str,
    origin: Sequence[float],
    spacing: Sequence[float],
    numbers: Mapping[str, tuple[float, str]] | None = None,
) -> None:
    """Write fields on a uniform grid (.vti).

    Parameters
    ----------
    path : path
    fields : mapping of str to ndarray, shape (k, n, m)
        Fields by name, with indices along z, x and y.
    units : mapping of str to str
        Units of the fields.
    shown : str
        Name of the field that is shown at first.
    origin, spacing : (float, float, float)
        First point and distances of points along x, y and z.
    numbers : mapping of str to (float, str), optional
        Numbers with their units, which are written as field data.
    """
    place = f'Origin="{_listed(origin)}" Spacing="{_listed(spacing)}"'
    data = [
        _data_array(name, np.array([value], dtype=float), unit, 'NumberOfTuples="1" ')
        for name, (value, unit) in (numbers or {}).items()
    ]
    about = f"<FieldData>{''.join(data)}</FieldData>" if data else ""
    _write(path, "ImageData", fields, units, shown, place, about=about)


def write_rectilinear_grid(
    path: Path,
    fields: Mapping[str, np.ndarray],
    units: Mapping[str, str],
    shown: str,
    axes: Mapping[str, np.ndarray],
) -> None:
    """Write fields on a grid of points at any distances (.vtr).

    Parameters
    ----------
    path, fields, units, shown
        See `write_image_data`.
    axes : mapping of str to ndarray
        Positions of the points along x, y and z; `units` has their units, too.
    """
    arrays = [_data_array(name, axes[name], units[name]) for name in ("x", "y", "z")]
    coordinates = f"<Coordinates>{''.join(arrays)}</Coordinates>"
    _write(path, "RectilinearGrid", fields, units, shown, coordinates=coordinates)


def _write(
    path: Path,
    kind: str,
    fields: Mapping[str, np.ndarray],
    units: Mapping[str, str],
    shown: str,
    place: str = "",
    coordinates: str = "",
    about: str = "",
) -> None:
    """Write a file of one piece."""
    layers, n, m = fields[shown].shape
    extent = f"0 {n - 1} 0 {m - 1} 0 {layers - 1}"
    lines = [
        f'<VTKFile type="{kind}" version="1.0" byte_order="LittleEndian" '
        'header_type="UInt64">',
        f'<{kind} WholeExtent="{extent}" {place}>{about}',
        f'<Piece Extent="{extent}"><PointData Scalars="{shown}">',
    ]
    for name, values in fields.items():  # x varies fastest
        lines.append(_data_array(name, values.transpose(0, 2, 1), units[name]))
    lines.append(f"</PointData>{coordinates}</Piece></{kind}></VTKFile>")
    path.write_text("\n".join(lines), encoding="ascii")


def _data_array(name: str, values: np.ndarray, unit: str, options: str = "") -> str:
    """Return numbers with their name and unit as an element of a file."""
    kind = f"{values.dtype.kind}{values.dtype.itemsize}"
    data = values.astype(f"<{kind}").tobytes()
    size = np.uint64(len(data)).astype("<u8").tobytes()
    text = base64.b64encode(size + data).decode("ascii")
    key = 'name="UNITS_LABEL" location="vtkDataArray"'
    about = f'type="{_TYPES[kind]}" Name="{name}" {options}format="binary"'
    return (
        f"<DataArray {about}>{text}"
        f"<InformationKey {key}>{unit}</InformationKey></DataArray>"
    )


def _listed(values: Sequence[float]) -> str:
    return " ".join(repr(float(value)) for value in values)
