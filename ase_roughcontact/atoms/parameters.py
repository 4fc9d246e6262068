"""Parameters of the calculator: checks, and the contact problem that they make."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from ase_roughcontact._util.callers import warn
from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import finite, lookup, positive, surface
from ase_roughcontact.atoms.grid import SurfaceGrid
from ase_roughcontact.contact import Problem
from ase_roughcontact.contact.problem import lattice_offsets
from ase_roughcontact.elasticity.fft import RealFFT2
from ase_roughcontact.elasticity.greens import ElasticSolid, Isotropic
from ase_roughcontact.interactions import Interaction, LennardJones93
from ase_roughcontact.topography import Heterogeneity

# Largest values of any solid, with their units in tables and here: diamond has a
# modulus of 1200 GPa and a hardness of about 100 GPa.
_LARGEST = {
    "contact_modulus": (2000.0, "GPa", "eV/Å^3", "ase.units.GPa"),
    "hardness": (300.0, "GPa", "eV/Å^3", "ase.units.GPa"),
    "work_of_adhesion": (30.0, "J/m^2", "eV/Å^2", "ase.units.J / ase.units.m**2"),
}
_KINDS = {
    "solid": ElasticSolid,
    "interaction": Interaction,
    "heterogeneity": Heterogeneity,
}
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
    if name == "contact_modulus":
        positive(contact_modulus=value)
        _warn_of_units(contact_modulus=value)
        return float(value)
    if name == "indenter":
        surface(indenter=value)
    elif not isinstance(value, _KINDS[name]):
        kind = _KINDS[name].__name__
        raise ValueError(f"{name} must be a {kind}, got {value!r}")
    if name == "interaction":
        work = getattr(value, "work_of_adhesion", 0.0)
        _warn_of_units(hardness=value.hardness, work_of_adhesion=work)
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


def _warn_of_units(**values: float) -> None:
    """Warn of values that may be in the units of tables."""
    for name, value in values.items():
        largest, unit, own, factor = _LARGEST[name]
        usual = value / UNITS[unit]
        if largest < usual < math.inf:
            warn(
                f"{name} = {value:g} {own} is {usual:.3g} {unit}, more than that of "
                f"any solid: multiply a value in {unit} by {factor}"
            )


def problem_for(grid: SurfaceGrid, parameters: Mapping[str, Any]) -> Problem:
    """Return the contact problem of a grid of atoms for parameters of `RoughContact`.

    Raises
    ------
    ValueError
        If a parameter is missing, or some of them do not fit together.
    """
    solid, modulus = parameters["solid"], parameters["contact_modulus"]
    indenter, wall = parameters["indenter"], parameters["interaction"]
    if indenter is None or (solid is None and modulus is None):
        raise ValueError(
            "RoughContact needs an indenter and a contact_modulus or solid"
        )
    if None not in (solid, modulus):
        raise ValueError("give contact_modulus or solid, not both")
    if solid is None:
        solid = Isotropic(modulus)
    if wall is None:
        wall = LennardJones93.repulsive(solid.contact_modulus, grid.spacing)
    return Problem(
        indenter=indenter,
        solid=solid,
        wall=wall,
        spacing=grid.spacing,
        periodic=grid.periodic,
        offset=lattice_offsets(grid.origin, grid.spacing),
        heterogeneity=parameters["heterogeneity"],
        fft=parameters["fft"],
    )
