"""A crystal and its relaxed surface as an ASE calculator describes them, checked."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from ase import Atoms
from ase.units import GPa

from ase_roughcontact._util.validation import integer, lookup, positive
from ase_roughcontact.elasticity.crystals.bulk import bulk_below, chosen_crystal
from ase_roughcontact.elasticity.crystals.errors import (
    check_errors,
    long_wave_compliance,
    surface_errors,
)
from ase_roughcontact.elasticity.crystals.force_constants import (
    SUBLATTICES,
    SURFACES,
    ForceConstants,
    force_constants,
    relaxed_slab,
)
from ase_roughcontact.elasticity.crystals.lattice_greens import LatticeGreensFunction
from ase_roughcontact.elasticity.crystals.strain import nominal_moduli, stress

# Residual stress, relative to the contact modulus, of which a warning is given.
_STRESSED = 1e-3
# Layers of a slab whose thinner one still has a layer of the bulk between its surfaces.
_LEAST_LAYERS = 9


@dataclass(frozen=True, eq=False)
class CalculatedSurface:
    """Crystal with a relaxed surface, from an ASE calculator.

    Attributes
    ----------
    symbol : str
        Chemical symbol.
    lattice_constant : float
        Of the cubic crystal (Å).
    slab : Atoms
        One surface cell of the relaxed slab, ordered from the surface down.
    constants : ForceConstants
        With the figures of `surface_errors`, too.
    greens : LatticeGreensFunction
        Of the force constants.
    stress : float
        Stress of the crystal below the surface along x and y (eV/Å^3).
    """

    symbol: str
    lattice_constant: float
    slab: Atoms
    constants: ForceConstants
    greens: LatticeGreensFunction
    stress: float

    @classmethod
    def of(
        cls,
        calculator: Any,
        bulk: Atoms | str,
        surface: str,
        *,
        tolerance: float,
        lattice_constant: float | None = None,
        layers: int = 15,
        size: int = 9,
        displacement: float = 1e-3,
    ) -> CalculatedSurface:
        """Calculate a surface, and raise `ValueError` if it has too large errors.

        See `Crystal.from_calculator` for the parameters.
        """
        lookup(surface, SURFACES, "surface")
        positive(tolerance=tolerance)
        integer("layers", layers, _LEAST_LAYERS)
        symbol, a = chosen_crystal(calculator, bulk, surface[:-3], lattice_constant)
        below = bulk_below(calculator, symbol, surface, a)
        slabs = [
            relaxed_slab(calculator, symbol, surface, a, number)
            for number in (layers, layers - 4)
        ]
        thick, thin = (
            force_constants(calculator, slab, size, displacement, SUBLATTICES[surface])
            for slab in slabs
        )
        name = f"{surface} {symbol} with {type(calculator).__name__}"
        check_errors(thick.figures, tolerance, name)
        greens = LatticeGreensFunction(thick)
        area = float(np.linalg.norm(np.cross(*slabs[0].cell.array[:2])))
        moduli = nominal_moduli(calculator, below, thick.sublattices)
        errors = surface_errors(greens, LatticeGreensFunction(thin), area, moduli)
        check_errors(errors, tolerance, name)
        residual = stress(calculator, below, (0, 1))
        if abs(residual) * long_wave_compliance(greens, area).mean() > _STRESSED:
            warnings.warn(
                f"{name} is under a stress of {residual / GPa:.3g} GPa along the "
                f"surface at the lattice constant {a:g} Å, which changes its moduli: "
                "omit lattice_constant to relax it",
                stacklevel=3,
            )
        constants = replace(thick, figures=thick.figures | errors)
        return cls(symbol, a, slabs[0], constants, greens, residual)
