"""Files of the stress below a contact: NumPy, NetCDF and VTK.

Components are named ``stress_xx`` to ``stress_xy``, with tension positive and z upward;
``von_mises`` is the von Mises stress. Lengths are in nm, stresses in GPa.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from scipy.io import netcdf_file

from ase_roughcontact._util.files import replaced
from ase_roughcontact._util.rounding import LENGTH_ROUNDING
from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import lookup
from ase_roughcontact.analysis.contact_map import ContactMap
from ase_roughcontact.analysis.stresses import stress_planes
from ase_roughcontact.analysis.vtk_files import (
    write_image_data,
    write_rectilinear_grid,
)
from ase_roughcontact.elasticity.greens import ElasticSolid
from ase_roughcontact.elasticity.largest_stress import von_mises
from ase_roughcontact.elasticity.subsurface import STRESS_COMPONENTS

# Names of the fields.
_FIELDS = (*(f"stress_{name}" for name in STRESS_COMPONENTS), "von_mises")
# Names of the axes of each field, in order.
_AXES = "z", "x", "y"
# Units of fields and axes.
_UNITS = dict.fromkeys(_FIELDS, "GPa") | dict.fromkeys(_AXES, "nm")


def write_stress(
    contact_map: ContactMap,
    solid: ElasticSolid,
    depths: Sequence[float],
    file: str | Path,
) -> None:
    """Write the stress below a contact in the format of the file's suffix.

    Parameters
    ----------
    contact_map : ContactMap
        The map.
    solid : ElasticSolid
        The solid, see `stress_field`.
    depths : sequence of float
        Depths below the surface (Å).
    file : path
        Name that ends in .npz (arrays of NumPy with their names), .nc (NetCDF 3), .vti
        (uniform grid of VTK, for ParaView and OVITO, if depths are equally spaced) or
        .vtr (rectilinear grid of VTK, for ParaView). Fields have the shape (depths, n,
        m), in single precision, from the deepest plane upward; z is minus the depth.
        Positions x and y are relative to the axis of the indenter.

    Raises
    ------
    ValueError
        If the suffix is unknown, there are no depths, or depths in a file .vti are not
        equally spaced.
    NotImplementedError
        If the stress in the solid is not known.
    OSError
        If the file can't be written.

    Examples
    --------
    ``write_stress(ContactMap.from_atoms(atoms), solid, [5.0, 10.0], "stress.vtr")``
    """
    write = lookup(Path(file).suffix, _WRITERS, "format of stresses")
    downward = sorted(set(map(float, depths)), reverse=True)
    if not downward:
        raise ValueError("depths must have at least one number")
    shape = len(downward), *contact_map.pressure.shape
    fields = {name: np.empty(shape, np.float32) for name in _FIELDS}
    for number, plane in enumerate(stress_planes(contact_map, solid, downward)):
        values = (*plane.stress, von_mises(plane.stress))
        for field, value in zip(fields.values(), values, strict=True):
            field[number] = value / UNITS["GPa"]
    axes = {
        "z": -np.array(downward) / UNITS["nm"],
        "x": contact_map.x / UNITS["nm"],
        "y": contact_map.y / UNITS["nm"],
    }
    with replaced(file) as name:
        write(axes, fields, Path(name))


def _write_npz(
    axes: dict[str, np.ndarray], fields: dict[str, np.ndarray], path: Path
) -> None:
    with path.open("wb") as file:  # a name would be extended by .npz
        np.savez_compressed(file, **axes, **fields)  # type: ignore[arg-type]


def _write_netcdf(
    axes: dict[str, np.ndarray], fields: dict[str, np.ndarray], path: Path
) -> None:
    with netcdf_file(path, "w") as file:
        for name, values in axes.items():
            file.createDimension(name, len(values))
        for name, values in (axes | fields).items():
            dimensions = (name,) if name in axes else _AXES
            variable = file.createVariable(name, values.dtype.char, dimensions)
            variable[:] = values
            variable.units = _UNITS[name]


def _write_vti(
    axes: dict[str, np.ndarray], fields: dict[str, np.ndarray], path: Path
) -> None:
    if not equally_spaced(axes["z"]):
        raise ValueError(
            "a file .vti needs at least two equally spaced depths; .vtr takes any"
        )
    names = "x", "y", "z"
    origin = [axes[name][0] for name in names]
    spacing = [np.ptp(axes[name]) / (len(axes[name]) - 1) for name in names]
    write_image_data(path, fields, _UNITS, "von_mises", origin, spacing)


def _write_vtr(
    axes: dict[str, np.ndarray], fields: dict[str, np.ndarray], path: Path
) -> None:
    write_rectilinear_grid(path, fields, _UNITS, "von_mises", axes)


def equally_spaced(depths: Sequence[float] | np.ndarray) -> bool:
    """Return whether two or more depths in order have equal distances."""
    steps = np.diff(depths)
    return steps.size > 0 and bool(
        np.allclose(steps, steps[0], rtol=LENGTH_ROUNDING, atol=0.0)
    )


# Functions that write stresses, by the suffix of the file.
_WRITERS: dict[
    str, Callable[[dict[str, np.ndarray], dict[str, np.ndarray], Path], None]
] = {
    ".npz": _write_npz,
    ".nc": _write_netcdf,
    ".vti": _write_vti,
    ".vtr": _write_vtr,
}
