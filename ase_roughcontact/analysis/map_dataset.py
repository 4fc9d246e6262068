"""Contact maps as data sets of xarray, with coordinates and units."""

from __future__ import annotations

from typing import Any

from ase_roughcontact._util.extras import imported
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.analysis.contact_map import ContactMap
from ase_roughcontact.analysis.map_files import UNITS_OF_FIELDS, fields_of, numbers_of
from ase_roughcontact.results.record import LoadStep


def map_dataset(contact_map: ContactMap, step: LoadStep | None = None) -> Any:
    """Return a map as a data set of xarray.

    Parameters
    ----------
    contact_map : ContactMap
    step : LoadStep, optional
        Step of the map.

    Returns
    -------
    xarray.Dataset
        Fields in the units of `write_map`, which are their attribute "units", on the
        coordinates x and y relative to the axis of the indenter (nm), with the normal
        force (nN), the contact area (nm²) and numbers of the step as attributes.

    Raises
    ------
    ImportError
        If xarray is not installed.
    """
    xarray = imported("xarray", "tables", "a data set needs xarray")
    nm = UNITS["nm"]
    fields = {
        name: (("x", "y"), values, {"units": UNITS_OF_FIELDS[name]})
        for name, values in fields_of(contact_map).items()
    }
    axes = {
        "x": ("x", contact_map.x / nm, {"units": "nm"}),
        "y": ("y", contact_map.y / nm, {"units": "nm"}),
    }
    attributes: dict[str, Any] = {}
    for name, (value, unit) in numbers_of(contact_map, step).items():
        attributes[name] = value
        if unit:
            attributes[f"{name}_unit"] = unit
    return xarray.Dataset(fields, axes, attributes)
