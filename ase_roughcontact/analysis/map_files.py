"""Files of contact maps: NumPy, NetCDF and VTK.

Fields have the names of contact.engineering's NetCDF files: ``pressure``, ``gap``,
``displacement`` (positive into the solid) and ``contacting_points`` (1 in contact). The
first index is along x. Lengths are in nm, pressures in GPa, slip rates in nm/s.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from scipy.io import netcdf_file

from ase_roughcontact._util.files import replaced
from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import lookup
from ase_roughcontact.analysis.contact_map import LATERAL_FIELDS, ContactMap
from ase_roughcontact.analysis.vtk_files import write_image_data
from ase_roughcontact.contact.history import entry_of
from ase_roughcontact.results.record import LoadStep

# Numbers of a map with their units, by name.
_Numbers: TypeAlias = dict[str, tuple[float, str]]

# Units in files, by the unit of ASE.
_FILE_UNITS = {"": "1", "Å": "nm", "Å/s": "nm/s", "eV/Å^3": "GPa"}
#: Units of the fields and coordinates.
UNITS_OF_FIELDS = {
    "pressure": "GPa",
    "gap": "nm",
    "displacement": "nm",
    "plastic_depth": "nm",
    "contacting_points": "1",
    **{name: _FILE_UNITS[entry_of(name).unit] for name in LATERAL_FIELDS},
    "x": "nm",
    "y": "nm",
}


def write_map(
    contact_map: ContactMap, file: str | Path, step: LoadStep | None = None
) -> None:
    """Write a map in the format of the file's suffix.

    Parameters
    ----------
    contact_map : ContactMap
        The map. Gap, displacement, plastic depth and fields of friction are written if
        the map has them.
    file : path
        Name that ends in .npz (arrays of NumPy with their names), .nc (NetCDF 3) or
        .vti (image data of VTK, for ParaView). Positions x and y in the file are
        relative to the axis of the indenter. The normal force (nN) and the contact
        area (nm²) are written, too: as arrays, attributes of the file or field data.
    step : LoadStep, optional
        Step of the map: its number, height and penetration (nm) are written, too.

    Raises
    ------
    ValueError
        If the suffix is unknown.
    OSError
        If the file can't be written.

    Examples
    --------
    ``write_map(ContactMap.from_atoms(atoms), "contact.nc")``
    """
    write = lookup(Path(file).suffix, _WRITERS, "format of a map")
    with replaced(file) as name:
        write(contact_map, Path(name), numbers_of(contact_map, step))


def numbers_of(contact_map: ContactMap, step: LoadStep | None = None) -> _Numbers:
    """Return the numbers that belong to a map, with their units in files.

    Parameters
    ----------
    contact_map : ContactMap
    step : LoadStep, optional
        Step of the map.

    Returns
    -------
    dict of str to (float, str)
        Normal force and contact area; of a step also its number, the height of the
        indenter and the penetration.
    """
    numbers: _Numbers = {
        "normal_force": (contact_map.normal_force / UNITS["nN"], "nN"),
        "contact_area": (contact_map.contact_area / UNITS["nm"] ** 2, "nm^2"),
    }
    if step is not None:
        numbers["step"] = step.step, ""
        numbers["height"] = step.height / UNITS["nm"], "nm"
        numbers["penetration"] = step.penetration / UNITS["nm"], "nm"
    return numbers


def fields_of(contact_map: ContactMap) -> dict[str, np.ndarray]:
    """Return the fields of a map in the units of files.

    Parameters
    ----------
    contact_map : ContactMap
        The map.

    Returns
    -------
    dict of ndarray, shape (n, m)
        Fields by name, in the units of `UNITS_OF_FIELDS`.
    """
    depth = contact_map.displacement
    found = {
        "pressure": contact_map.pressure,
        "gap": contact_map.gap,
        "displacement": None if depth is None else -depth,
        "plastic_depth": contact_map.plastic_depth,
        **contact_map.lateral,
    }
    fields: dict[str, np.ndarray] = {
        "contacting_points": contact_map.contact.astype(np.int8)
    }
    for name, values in found.items():
        if values is not None:
            fields[name] = values / UNITS.get(UNITS_OF_FIELDS[name], 1.0)
    return fields


def _axes(contact_map: ContactMap) -> dict[str, np.ndarray]:
    return {"x": contact_map.x / UNITS["nm"], "y": contact_map.y / UNITS["nm"]}


def _write_npz(contact_map: ContactMap, path: Path, numbers: _Numbers) -> None:
    arrays: dict[str, Any] = {**_axes(contact_map), **fields_of(contact_map)}
    arrays |= {name: value for name, (value, _) in numbers.items()}
    with path.open("wb") as file:  # a name would be extended by .npz
        np.savez_compressed(file, **arrays)


def _write_netcdf(contact_map: ContactMap, path: Path, numbers: _Numbers) -> None:
    axes = _axes(contact_map)
    with netcdf_file(path, "w") as file:
        for name, values in axes.items():
            file.createDimension(name, len(values))
        for name, values in (axes | fields_of(contact_map)).items():
            dimensions = (name,) if name in axes else ("x", "y")
            variable = file.createVariable(name, values.dtype.char, dimensions)
            variable[:] = values
            variable.units = UNITS_OF_FIELDS[name]
        file.length_unit = "nm"
        for name, (value, unit) in numbers.items():
            setattr(file, name, value)
            if unit:
                setattr(file, f"{name}_unit", unit)


def _write_vtk(contact_map: ContactMap, path: Path, numbers: _Numbers) -> None:
    fields = {name: values[None] for name, values in fields_of(contact_map).items()}
    origin = [each / UNITS["nm"] for each in (*contact_map.origin, 0.0)]
    spacing = [contact_map.spacing / UNITS["nm"]] * 3
    write_image_data(
        path, fields, UNITS_OF_FIELDS, "pressure", origin, spacing, numbers
    )


# Functions that write a map, by the suffix of the file.
_WRITERS: dict[str, Callable[[ContactMap, Path, _Numbers], None]] = {
    ".npz": _write_npz,
    ".nc": _write_netcdf,
    ".vti": _write_vtk,
}
