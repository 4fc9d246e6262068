r"""Crystal with a (100) surface, as an ASE calculator describes it.

The Green's function of the surface (see `lattice_greens`) is written as a modulus of
plane waves of pressure,

.. math:: \frac{1}{E^*(q)} = \frac{a_0^2 |q|}{2}\, G_{zz}(q), \qquad
          \tilde u(q) = -\frac{2}{E^*(q) |q|} \tilde p(q) .
"""

from __future__ import annotations

import json
import warnings
from dataclasses import asdict, dataclass, field
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
from ase import Atoms
from ase.data import atomic_numbers
from ase.units import GPa

from ase_roughcontact._util.files import replaced
from ase_roughcontact._util.validation import finite, integer, lookup, positive
from ase_roughcontact.elasticity.crystals.bulk import (
    bulk_below,
    chosen_crystal,
)
from ase_roughcontact.elasticity.crystals.cubic import continuum_kernel
from ase_roughcontact.elasticity.crystals.errors import (
    check_errors,
    modulus_errors,
    modulus_table,
)
from ase_roughcontact.elasticity.crystals.force_constants import (
    force_constants,
    relaxed_slab,
)
from ase_roughcontact.elasticity.crystals.kernel import (
    NODES,
    distant_kernel,
    interpolate,
    long_wave_series,
    near_kernel,
    node_vectors,
)
from ase_roughcontact.elasticity.crystals.lattice_greens import LatticeGreensFunction
from ase_roughcontact.elasticity.crystals.strain import nominal_moduli, stress
from ase_roughcontact.elasticity.greens import ElasticSolid

# Crystal structures of the surfaces whose atoms are a square grid.
_STRUCTURES = {"fcc100": "fcc", "bcc100": "bcc"}
# Distance, in spacings, up to which the kernel of a free half space is tabulated.
_TABLE = 48
# Relative difference of spacings, or of a wave vector to the edge of the zone.
_ROUNDING = 1e-6
# Residual stress, relative to the contact modulus, of which a warning is given.
_STRESSED = 1e-3
# Layers of a slab whose thinner one still has a layer of the bulk between its surfaces.
_LEAST_LAYERS = 9
_FORMAT = "crystal of ase_roughcontact, version 1"


@dataclass(frozen=True, eq=False)
class Crystal(ElasticSolid):
    """Half space of a crystal with a square grid of surface atoms.

    It is made by `from_calculator` or `read`.

    Parameters
    ----------
    symbol : str
        Chemical symbol.
    surface : {"fcc100", "bcc100"}
        The surface; x and y are along its rows of nearest neighbours.
    calculator : str
        Name of the calculator.
    spacing : float
        Distance a0 of nearest neighbours in the surface (Å), the only spacing at which
        the solid can be used.
    table : ndarray
        Coefficients of ``1/E*``, see `interpolation_table` (1/pressure).
    stress : float
        Stress of the crystal below the surface along x and y, positive under tension;
        along z it is zero (eV/Å^3).
    figures : dict
        Relative errors. Those of the force constants are described in
        `ForceConstants`, those of E* are "thickness" (change from a slab with four
        layers less), "square" (difference of directions that a square grid does not
        distinguish), "interpolation", and "long_waves" (difference of long waves from
        an elastic continuum with the moduli of the strained bulk).

    Attributes
    ----------
    contact_modulus : float
        Indentation modulus of long waves, ``1/E* = <1/E*(theta)>`` (pressure).
    """

    symbol: str
    surface: str
    calculator: str
    spacing: float
    table: np.ndarray = field(repr=False)
    stress: float = 0.0
    figures: dict[str, float] = field(default_factory=dict, repr=False)

    def __post_init__(self) -> None:
        lookup(self.symbol, atomic_numbers, "element")
        lookup(self.surface, _STRUCTURES, "square surface")
        positive(spacing=self.spacing)
        finite(stress=self.stress)
        # one memory layout, so that a crystal from a file is the same to the last digit
        table = np.ascontiguousarray(self.table, dtype=float)
        if table.shape != NODES or not np.isfinite(table).all():
            raise ValueError(f"the table must be finite numbers of the shape {NODES}")
        if interpolate(table, *node_vectors().T).min() <= 0.0:
            raise ValueError("the moduli of the table must be positive")
        object.__setattr__(self, "table", table)

    @classmethod
    def from_calculator(
        cls,
        calculator: Any,
        bulk: Atoms | str,
        surface: str = "fcc100",
        *,
        lattice_constant: float | None = None,
        layers: int = 15,
        size: int = 9,
        displacement: float = 1e-3,
        tolerance: float = 1e-3,
    ) -> Crystal:
        """Return the crystal of an ASE calculator.

        A slab is relaxed, and its force constants are calculated down to its middle:
        about ``3 layers`` calculations of forces for ``size^2 layers`` atoms, repeated
        with four layers less. Energies of some 200 strained bulk cells check them.

        Parameters
        ----------
        calculator : Calculator
            Gives energies of bulk crystals and forces of slabs.
        bulk : Atoms or str
            Chemical symbol, or a crystal of one element, whose volume is the first
            guess of the lattice constant.
        surface : {"fcc100", "bcc100"}
            Crystal structure and surface.
        lattice_constant : float, optional
            In place of that at which the crystal has no stress (Å). Along z, the
            crystal is relaxed all the same. A stress along x and y above 1e-3 of the
            contact modulus is reported by a warning.
        layers : int
            Layers of the slab, odd and at least 9.
        size : int
            Surface cells along each side of the slab, odd.
        displacement : float
            Displacement for the force constants (Å); 0 to use the Hessian of the
            calculator, which must have the method `get_hessian` of matscipy.
        tolerance : float
            Largest relative error of the force constants and of E*.

        Returns
        -------
        Crystal

        Raises
        ------
        ValueError
            If the surface is not a square grid, the calculator gives no forces for a
            slab or returns others when asked again, its forces have a resultant or
            reach beyond the slab, the slab is another crystal than the bulk or too
            thin, or the surface is not stable.

        Examples
        --------
        >>> from ase.calculators.emt import EMT
        >>> from ase_roughcontact.elasticity import Crystal
        >>> copper = Crystal.from_calculator(EMT(), "Cu")  # doctest: +SKIP
        >>> copper.write("copper.json")  # doctest: +SKIP
        """
        structure = lookup(surface, _STRUCTURES, "square surface")
        positive(tolerance=tolerance)
        integer("layers", layers, _LEAST_LAYERS)
        symbol, a = chosen_crystal(calculator, bulk, structure, lattice_constant)
        below = bulk_below(calculator, symbol, surface, a)
        thick, thin = (
            force_constants(
                calculator,
                relaxed_slab(calculator, symbol, surface, a, number),
                size,
                displacement,
            )
            for number in (layers, layers - 4)
        )
        name = f"{surface} {symbol} with {type(calculator).__name__}"
        check_errors(thick.figures, tolerance, name)
        greens = LatticeGreensFunction(thick)
        table = modulus_table(greens)
        errors = modulus_errors(
            table,
            greens,
            LatticeGreensFunction(thin),
            nominal_moduli(calculator, below),
        )
        check_errors(errors, tolerance, name)
        crystal = cls(
            symbol,
            surface,
            type(calculator).__name__,
            thick.spacing,
            table,
            stress(calculator, below, (0, 1)),
            thick.figures | errors,
        )
        if abs(crystal.stress) > _STRESSED * crystal.contact_modulus:
            warnings.warn(
                f"{name} is under a stress of {crystal.stress / GPa:.3g} GPa along the "
                f"surface at the lattice constant {a:g} Å, which changes its moduli: "
                "omit lattice_constant to relax it",
                stacklevel=2,
            )
        return crystal

    @classmethod
    def read(cls, file: str | Path) -> Crystal:
        """Read a crystal from a file.

        Parameters
        ----------
        file : str or Path
            Written by `write`.

        Returns
        -------
        Crystal

        Raises
        ------
        ValueError
            If the file is another one.
        """
        try:
            entries = json.loads(Path(file).read_text())
            if entries.pop("format") != _FORMAT:
                raise ValueError("its format is another one")
            entries["table"] = np.array(entries["table"])
            return cls(**entries)
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            raise ValueError(f"{file} is not a crystal: {error}") from error

    def write(self, file: str | Path) -> None:
        """Write the crystal to a file (JSON).

        Parameters
        ----------
        file : str or Path
        """
        entries = {"format": _FORMAT, **asdict(self), "table": self.table.tolist()}
        lines = (f"{json.dumps(k)}: {json.dumps(v)}" for k, v in entries.items())
        with replaced(file) as name:
            Path(name).write_text("{\n" + ",\n".join(lines) + "\n}\n")

    @property
    def contact_modulus(self) -> float:  # type: ignore[override]
        """Indentation modulus (pressure)."""
        return 1.0 / float(self._series[0][0])

    def check(self, spacing: float) -> None:
        """Raise an error if the grid has another spacing; see `ElasticSolid.check`."""
        if abs(spacing / self.spacing - 1.0) > _ROUNDING:
            raise ValueError(
                f"the atoms of {self.surface} {self.symbol} with {self.calculator} "
                f"have a spacing of {self.spacing:.6f}, the grid {spacing:.6f}: build "
                f"it with spacing=solid.spacing"
            )
        super().check(spacing)

    def wave_compliance(self, qx: np.ndarray, qy: np.ndarray) -> np.ndarray:
        """Return ``2/(E*(q) |q|)``; see `ElasticSolid`.

        Raises
        ------
        ValueError
            If a wave vector is not in the Brillouin zone: the grid has another spacing.
        """
        x, y = np.multiply(qx, self.spacing), np.multiply(qy, self.spacing)
        if max(abs(x).max(), abs(y).max()) > np.pi * (1.0 + _ROUNDING):
            raise ValueError(
                f"the atoms of the crystal have a spacing of {self.spacing:.6g}, and a "
                "smaller one was asked for"
            )
        return 2.0 * interpolate(self.table, x, y) / np.hypot(qx, qy)

    def cell_compliance(
        self, i: np.ndarray, j: np.ndarray, spacing: float
    ) -> np.ndarray:
        """Return the depth under unit pressure on an atom; see `ElasticSolid`.

        At another spacing, as on the coarse grids of the solvers, the response is that
        of long waves.
        """
        if abs(spacing / self.spacing - 1.0) > _ROUNDING:
            return continuum_kernel(i, j, spacing, self._series[0])
        i, j = np.broadcast_arrays(abs(np.asarray(i)), abs(np.asarray(j)))
        kernel = distant_kernel(i, j, self._series)
        near = np.maximum(i, j) < _TABLE
        kernel[near] = self._near_kernel[i[near], j[near]]
        kernel *= spacing
        return kernel

    def todict(self) -> dict[str, Any]:
        """Return what identifies the solid in files, the table by its hash."""
        return {
            "name": "Crystal",
            "symbol": self.symbol,
            "surface": self.surface,
            "calculator": self.calculator,
            "spacing": self.spacing,
            "contact_modulus": self.contact_modulus,
            "table": sha256(self.table.tobytes()).hexdigest()[:16],
        }

    @cached_property
    def _series(self) -> list[np.ndarray]:
        return long_wave_series(self.table)

    @cached_property
    def _near_kernel(self) -> np.ndarray:
        return near_kernel(_TABLE, self.table, self._series)
