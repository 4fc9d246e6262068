"""Hardness with which the pressures of a path are compared."""

import math

from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import positive
from ase_roughcontact.contact import Problem
from ase_roughcontact.elasticity import Layer
from ase_roughcontact.elasticity.material import HARDNESS, fcc_spacing

# Relative difference of a spacing from that of the crystal of its name.
_SAME_SPACING = 0.02


def hardness_of(symbol: str, spacing: float, hardness: float | None = None) -> float:
    """Return the hardness with which pressures are compared.

    Parameters
    ----------
    symbol : str
        Chemical symbol of the substrate.
    spacing : float
        Å.
    hardness : float, optional
        eV/Å^3; infinity for a solid that is elastic by intent, NaN if it is not known.

    Returns
    -------
    float
        By default that of the element in `HARDNESS` (eV/Å^3). NaN if it is not known,
        or if the spacing is not that of the element's crystal, as in other units.

    Raises
    ------
    ValueError
        If the hardness is not positive.
    """
    if hardness is not None:
        if hardness != math.inf and not math.isnan(hardness):
            positive(hardness=hardness)
        return hardness
    try:
        crystal = fcc_spacing(symbol)
    except ValueError:  # neither fcc nor diamond: any spacing may be meant
        crystal = spacing
    if not math.isclose(spacing, crystal, rel_tol=_SAME_SPACING):
        return math.nan
    return HARDNESS.get(symbol, math.nan) * UNITS["GPa"]


def hardness_for(problem: Problem, symbol: str, hardness: float | None = None) -> float:
    """Return the hardness with which the pressures of a problem are compared.

    It is that of the wall, if it has one; that of a layer is not known. See
    `hardness_of` for the rest.
    """
    if problem.wall.plastic:  # what is plastic is within the model
        return problem.wall.hardness
    if hardness is None and isinstance(problem.solid.elastic, Layer):
        return math.nan
    return hardness_of(symbol, problem.spacing, hardness)
