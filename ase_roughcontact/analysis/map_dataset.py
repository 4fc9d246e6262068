"""Contact maps as data sets of xarray, with coordinates and units."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ase_roughcontact._util.extras import imported
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.analysis.contact_map import ContactMap
from ase_roughcontact.analysis.map_files import UNITS_OF_FIELDS, fields_of


def map_dataset(
    contact_map: ContactMap, attributes: Mapping[str, Any] | None = None
) -> Any:
    """Return a map as a data set of xarray.

    Parameters
    ----------
    contact_map : ContactMap
    attributes : mapping, optional
        Attributes of the data set, such as the number of the step.

    Returns
    -------
    xarray.Dataset
        Fields in the units of `write_map`, which are their attribute "units", on the
        coordinates x and y relative to the axis of the indenter (nm), with the load
        (nN) and the contact area (nm²) as attributes.

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
    own = {
        "normal_force": contact_map.normal_force / UNITS["nN"],
        "normal_force_unit": "nN",
        "contact_area": contact_map.contact_area / UNITS["nm²"],
        "contact_area_unit": "nm²",
    }
    return xarray.Dataset(fields, axes, own | dict(attributes or {}))
