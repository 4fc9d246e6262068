"""Units in which the columns of a scene are printed and drawn."""

from __future__ import annotations

from ase_roughcontact._util.units import UNITS, printed_unit
from ase_roughcontact.results.record import columns_of
from ase_roughcontact.scene.scene import Scene

# Atomic spacings from which lengths and areas have larger units (Å).
_MIN_SPACINGS = {"Å": ("nm", 20.0), "nm²": ("\u00b5m²", 300.0)}
# Force on one site at a pressure equal to the contact modulus, from which forces have
# a larger unit (eV/Å).
_MIN_FORCE = UNITS["\u00b5N"]


def units_in_print(scene: Scene) -> dict[str, str]:
    """Return the units in which the columns of a scene are printed, by name.

    All steps of a scene have the same units, which follow from the contact modulus and
    the atomic spacing: GPa, nN, nm² and Å for atoms, and for example Pa, nN, µm² and
    nm for a bead on a gel. Rough flats have lengths in nm and nominal pressures in MPa.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    dict of str
    """
    modulus, spacing = scene.contact_modulus, scene.spacing
    larger = {
        usual: unit
        for usual, (unit, least) in _MIN_SPACINGS.items()
        if spacing >= least
    }
    if modulus * spacing**2 >= _MIN_FORCE:
        larger["nN"] = "\u00b5N"
    if scene.is_flat:
        larger["Å"] = "nm"
    units = {}
    for name, column in columns_of(scene.record).items():
        usual = printed_unit(column.unit, modulus)
        units[name] = larger.get(usual, usual)
    if scene.is_flat:
        units["nominal_pressure"] = "MPa"
    return units
