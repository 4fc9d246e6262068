"""Relaxed surface of a crystal with its force constants, from an ASE calculator."""

from __future__ import annotations

from dataclasses import astuple, dataclass
from functools import cached_property
from typing import Any

import numpy as np
from ase import Atoms

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

_VACUUM = 10.0  # on both sides of a slab (Å)
_SAME = 1e-6  # largest distance of two equal places (Å)
# Errors above which a calculator is another one than that of the surface: of the
# stiffness of a surface atom, and of positions at rest, in spacings.
_STIFFNESS = 1e-2
_STRAIN = 1e-3


@dataclass(frozen=True, eq=False)
class CrystalSurface(Stored):
    """Semi-infinite crystal with a relaxed surface, in the harmonic approximation.

    It is made by `from_calculator` or `read`.

    Parameters
    ----------
    symbol : str
        Chemical symbol.
    surface : {"fcc100", "fcc111", "bcc100", "diamond100"}
    lattice_constant : float
        Of the cubic crystal (Å).
    heights : ndarray
        z of the layers from the surface down to the first layer of the bulk, that of
        the surface being zero (Å).
    constants : ForceConstants
        Couplings of these layers.
    size : int
        Number of surface cells along each side of the slabs whose forces were
        calculated.
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
        """Return the surface of a crystal as an ASE calculator describes it.

        See `Crystal.from_calculator`, whose parameters, cost and errors are the same.

        Parameters
        ----------
        calculator : Calculator
        bulk : Atoms or str
        surface : {"fcc100", "fcc111", "bcc100", "diamond100"}
            Crystal structure and surface.
        size, displacement, tolerance
            Of the slab and its force constants.
        **slab
            ``lattice_constant`` and ``layers``.

        Returns
        -------
        CrystalSurface
        """
        slab |= {"size": size, "displacement": displacement, "tolerance": tolerance}
        found = calculated_surface(calculator, bulk, surface, **slab)
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

        It is ordered from the surface down, the surface at z = 0, and periodic along
        it.
        """
        integer("layers", layers, 1)
        build = SURFACES[self.surface]
        # two layers or more, between which ASE knows the distance
        atoms = build(
            self.symbol, (1, 1, layers + 1), a=self.lattice_constant, vacuum=_VACUUM
        )[::-1]
        atoms.positions -= atoms.positions[0]
        # the layers below those of the surface have the distance of the last ones
        number = np.arange(layers + 1)
        deep = np.maximum(number - len(self.heights) + 1, 0)
        known = self.heights[np.minimum(number, len(self.heights) - 1)]
        atoms.positions[:, 2] = known + deep * np.diff(self.heights)[-1]
        atoms.set_tags(0)
        atoms.info.clear()  # the sites for adsorbates are not those of these atoms
        return atoms[:layers]

    @property
    def bulk_depth(self) -> int:
        """Number of layers of the thinnest slab whose lowest layers are bulk."""
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

        It must give no forces on the upper layers of a slab, and the force constants of
        a surface atom.
        """
        slab = self.column(self.bulk_depth)
        cells = slab.repeat((self.size, self.size, 1))
        cells.calc = calculator
        force = abs(cells.get_forces()[: self.constants.bulk]).max()
        found, expected = (
            matrix[(target == 0) & (abs(offset) < _SAME).all(axis=1) & (source == 0)][0]
            for source, target, offset, matrix in (
                couplings(calculator, slab, self.size, [0], self.displacement),
                astuple(self.constants)[:4],
            )
        )
        scale = abs(expected).max()
        error = abs(found - expected).max() / scale
        strain = force / (scale * self.constants.spacing)
        if error > _STIFFNESS or strain > _STRAIN:
            raise ValueError(
                f"the surface {self.surface} {self.symbol} was not calculated with "
                f"this {type(calculator).__name__}: its atoms are under forces of up to"
                f" {force:.2g} eV/Å at rest, and the stiffness of a surface atom "
                f"differs by {100 * error:.2g} %. Give the calculator of the surface, "
                "or make another surface with CrystalSurface.from_calculator"
            )

    def cut_couplings(
        self, calculator: Any, layers: int, lowest: int
    ) -> tuple[np.ndarray, ...]:
        """Return couplings within the lowest layers of a slab cut off from the rest.

        They are source, target, offset and matrix as in `ForceConstants`, layer 0 being
        the first of the lowest ones.
        """
        first = layers - lowest
        slab = self.column(layers)
        source, target, offset, matrix = couplings(
            calculator, slab, self.size, range(first, layers), self.displacement
        )
        kept = target >= first
        return source[kept] - first, target[kept] - first, offset[kept], matrix[kept]
