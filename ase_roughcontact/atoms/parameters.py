"""Checks of the parameters of the calculator."""

from __future__ import annotations

import math
from typing import Any

from ase_roughcontact._util.callers import warn
from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import finite, lookup, positive, surface
from ase_roughcontact.elasticity.fft import RealFFT2
from ase_roughcontact.elasticity.greens import ElasticSolid
from ase_roughcontact.interactions import Interaction
from ase_roughcontact.topography import Heterogeneity

# Modulus above that of any solid; diamond has 1200 GPa (eV/Å^3).
_LARGEST_MODULUS = 2000.0 * UNITS["GPa"]
# Work of adhesion above that of any pair of solids (eV/Å^2).
_LARGEST_WORK = 30.0 * UNITS["J/m^2"]
# Hardness above that of any solid; diamond has about 100 GPa (eV/Å^3).
_LARGEST_HARDNESS = 300.0 * UNITS["GPa"]
_FFT_OPTIONS = dict.fromkeys(("dtype", "engine", "threads"))


def checked(name: str, value: Any) -> Any:
    """Return a parameter of `RoughContact` as it is stored.

    Parameters
    ----------
    name : str
    value : object
        As the user gives it.

    Returns
    -------
    object

    Raises
    ------
    ValueError
        If it is not valid.
    """
    if name == "load":
        finite(load=value)
        return float(value)
    if name == "fft":
        return _checked_fft(value)
    if value is None:
        return None
    if name == "solid" and not isinstance(value, ElasticSolid):
        raise ValueError(f"solid must be an ElasticSolid, got {value!r}")
    if name == "contact_modulus":
        positive(contact_modulus=value)
        if value > _LARGEST_MODULUS:
            warn(
                f"contact_modulus = {value:g} eV/Å^3 is {value / UNITS['GPa']:.3g} "
                "GPa, more than that of any solid: multiply a value in GPa by "
                "ase.units.GPa"
            )
        return float(value)
    if name == "interaction" and not isinstance(value, Interaction):
        raise ValueError(f"interaction must be an Interaction, got {value!r}")
    if name == "interaction":
        _warn_of_units(value)
    if name == "heterogeneity" and not isinstance(value, Heterogeneity):
        raise ValueError(f"heterogeneity must be a Heterogeneity, got {value!r}")
    if name == "indenter":
        surface(indenter=value)
    return value


def _checked_fft(options: Any) -> dict:
    if not isinstance(options, dict):
        raise ValueError(f"fft must be a dict of options, got {options!r}")
    options = dict(options)
    for key in options:
        lookup(key, _FFT_OPTIONS, "option of fft")
    # fails now, and not at the first calculation, if an option is wrong
    trial = RealFFT2((1, 1), **options)
    if "dtype" in options:
        options["dtype"] = trial.dtype.name
    return options


def _warn_of_units(wall: Interaction) -> None:
    """Warn of a work of adhesion in J/m^2, or of a hardness in GPa."""
    if _LARGEST_HARDNESS < wall.hardness < math.inf:
        warn(
            f"hardness = {wall.hardness:g} eV/Å^3 is "
            f"{wall.hardness / UNITS['GPa']:.3g} GPa, more than that of any solid: "
            "multiply a value in GPa by ase.units.GPa"
        )
    work = getattr(wall, "work_of_adhesion", 0.0)
    if work > _LARGEST_WORK:
        warn(
            f"work_of_adhesion = {work:g} eV/Å^2 is {work / UNITS['J/m^2']:.3g} J/m^2, "
            "more than that of any solids: multiply a value in J/m^2 by "
            "ase.units.J / ase.units.m**2"
        )
