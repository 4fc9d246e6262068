"""Relaxed surface of a crystal with its force constants, from an ASE calculator."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from ase import Atoms

from ase_roughcontact._util.summary import Summarized
from ase_roughcontact._util.validation import integer
from ase_roughcontact.elasticity.crystals.calculated import (
    calculated_surface,
    long_wave_compliance,
)
from ase_roughcontact.elasticity.crystals.files import Stored
from ase_roughcontact.elasticity.crystals.force_constants import (
    SURFACES,
    ForceConstants,
    couplings,
)
from ase_roughcontact.elasticity.crystals.lattice_greens import LatticeGreensFunction

# Vacuum on each side of a slab (Å).
_VACUUM = 10.0
# Largest distance of two equal positions (Å).
_POSITION_ERROR = 1e-6
# Largest relative error of the stiffness of a surface atom by the same calculator.
_MAX_STIFFNESS_ERROR = 1e-2
# Largest error of the positions at rest by the same calculator, in spacings.
_MAX_STRAIN = 1e-3


@dataclass(frozen=True, eq=False)
class CrystalSurface(Summarized, Stored):
    """Semi-infinite crystal with a relaxed surface, in the harmonic approximation.

    Objects are made by `from_calculator` or `read`.

    Parameters
    ----------
    symbol : str
        Chemical symbol.
    surface : {"fcc100", "fcc111", "bcc100", "diamond100"}
        Crystal structure and surface.
    lattice_constant : float
        Lattice constant of the cubic crystal (Å).
    heights : ndarray
        Heights of the layers from the surface, at zero, down to the first layer of the
        bulk (Å).
    constants : ForceConstants
        Couplings of these layers.
    size : int
        Number of surface cells along each side of the slabs for the force constants.
    displacement : float
        Displacement for the force constants (Å); 0 for the calculator's Hessian.
    """

    _kind = "crystal surface"

    symbol: str
    surface: str
    lattice_constant: float
    heights: np.ndarray
    constants: ForceConstants
    size: int
    displacement: float

    @classmethod
    def from_calculator(
        cls,
        calculator: Any,
        bulk: Atoms | str,
        surface: str = "fcc100",
        *,
        size: int = 9,
        displacement: float = 1e-3,
        tolerance: float = 1e-3,
        **slab: Any,
    ) -> CrystalSurface:
        """Calculate the surface of a crystal with an ASE calculator.

        See `Crystal.from_calculator` for more about the parameters, the cost and the
        errors raised, which are the same.

        Parameters
        ----------
        calculator : Calculator
            ASE calculator of the energies of bulk crystals and the forces of slabs.
        bulk : Atoms or str
            Chemical symbol, or a crystal of one element.
        surface : {"fcc100", "fcc111", "bcc100", "diamond100"}
            Crystal structure and surface.
        size : int
            Number of surface cells along each side of the slab, odd.
        displacement : float
            Displacement for the force constants (Å); 0 for the calculator's Hessian.
        tolerance : float
            Largest relative error.
        **slab
            The options ``lattice_constant`` and ``layers``.

        Returns
        -------
        CrystalSurface
            The surface; `write` keeps it in a file.
        """
        found = calculated_surface(
            calculator,
            bulk,
            surface,
            size=size,
            displacement=displacement,
            tolerance=tolerance,
            **slab,
        )
        symbol, a, constants = found.symbol, found.lattice_constant, found.constants
        z = found.slab.positions[: constants.bulk + 1, 2]
        return cls(symbol, surface, a, z - z[0], constants, size, displacement)

    @classmethod
    def _of(cls, entries: dict[str, Any]) -> CrystalSurface:
        constants = entries["constants"]
        arrays = {k: np.array(v) for k, v in constants.items() if isinstance(v, list)}
        entries["constants"] = ForceConstants(**constants | arrays)
        entries["heights"] = np.array(entries["heights"])
        return cls(**entries)

    def column(self, layers: int) -> Atoms:
        """Return one surface cell of the upper layers.

        The atoms are ordered from the surface at z = 0 down, and periodic along the
        surface.
        """
        integer("layers", layers, 1)
        build = SURFACES[self.surface]
        # one layer more: ASE needs two to know their distance
        atoms = build(
            self.symbol, (1, 1, layers + 1), a=self.lattice_constant, vacuum=_VACUUM
        )[::-1]
        atoms.positions -= atoms.positions[0]
        # below the first layer of the bulk, all layers have the same distance
        number = np.arange(layers + 1)
        below = np.maximum(number - len(self.heights) + 1, 0)
        heights = self.heights[np.minimum(number, len(self.heights) - 1)]
        atoms.positions[:, 2] = heights + below * np.diff(self.heights)[-1]
        atoms.set_tags(0)
        atoms.info.clear()  # ASE's sites for adsorbates do not hold for these atoms
        return atoms[:layers]

    @property
    def bulk_depth(self) -> int:
        """Number of layers of the thinnest slab with lowest layers that are bulk."""
        return self.constants.bulk + self.constants.reach

    @property
    def cell_area(self) -> float:
        """Area of an atom in the surface (Å^2)."""
        rows = self.column(1).cell.array[:2, :2]
        return float(abs(np.linalg.det(rows)))

    @cached_property
    def contact_modulus(self) -> float:
        """Indentation modulus of long waves, ``1/E* = <1/E*(theta)>`` (eV/Å^3)."""
        greens = LatticeGreensFunction(self.constants)
        return 1.0 / float(long_wave_compliance(greens, self.cell_area).mean())

    def check_calculator(self, calculator: Any) -> None:
        """Raise `ValueError` if the surface was calculated with another calculator.

        The calculator must give no forces on the upper layers of a slab, and the same
        force constants of a surface atom.
        """
        slab = self.column(self.bulk_depth)
        cells = slab.repeat((self.size, self.size, 1))
        cells.calc = calculator
        force = abs(cells.get_forces()[: self.constants.bulk]).max()
        found = _surface_stiffness(
            *couplings(calculator, slab, self.size, [0], self.displacement)
        )
        constants = self.constants
        expected = _surface_stiffness(
            constants.source, constants.target, constants.offset, constants.matrix
        )
        scale = abs(expected).max()
        error = abs(found - expected).max() / scale
        strain = force / (scale * self.constants.spacing)
        if error > _MAX_STIFFNESS_ERROR or strain > _MAX_STRAIN:
            raise ValueError(
                f"the surface {self.surface} {self.symbol} was calculated with another "
                f"{type(calculator).__name__}: forces at rest are up to {force:.2g} "
                f"eV/Å, the stiffness differs by {100 * error:.2g} %. Give the same "
                "calculator, or use CrystalSurface.from_calculator"
            )

    def cut_couplings(
        self, calculator: Any, layers: int, lowest: int
    ) -> tuple[np.ndarray, ...]:
        """Return couplings within the lowest layers of a slab without the bulk below.

        The arrays are source, target, offset and matrix as in `ForceConstants`, but
        layer 0 is the highest of the lowest layers.
        """
        first = layers - lowest
        slab = self.column(layers)
        source, target, offset, matrix = couplings(
            calculator, slab, self.size, range(first, layers), self.displacement
        )
        kept = target >= first
        return source[kept] - first, target[kept] - first, offset[kept], matrix[kept]


def _surface_stiffness(
    source: np.ndarray, target: np.ndarray, offset: np.ndarray, matrix: np.ndarray
) -> np.ndarray:
    """Return the coupling of a surface atom with itself, shape (3, 3)."""
    same_position = (abs(offset) < _POSITION_ERROR).all(axis=1)
    return matrix[(source == 0) & (target == 0) & same_position][0]
