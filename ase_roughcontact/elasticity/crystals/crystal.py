r"""Half space of a crystal with a (100) surface, from an ASE calculator.

The Green's function of the surface (see `lattice_greens`) gives a modulus of plane
waves of pressure,

.. math:: \frac{1}{E^*(q)} = \frac{a_0^2 |q|}{2}\, G_{zz}(q), \qquad
          \tilde u(q) = -\frac{2}{E^*(q) |q|} \tilde p(q) .
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from ase import Atoms
from ase.data import atomic_numbers

from ase_roughcontact._util.identity import digest
from ase_roughcontact._util.summary import Summarized
from ase_roughcontact._util.validation import finite, lookup, positive
from ase_roughcontact.elasticity.crystals import calculated
from ase_roughcontact.elasticity.crystals.files import Stored
from ase_roughcontact.elasticity.crystals.kernel import (
    NODES,
    LatticeComponent,
    interpolate,
    node_vectors,
)
from ase_roughcontact.elasticity.crystals.subsurface import (
    AnisotropicWaves,
    anisotropic_uniform,
)
from ase_roughcontact.elasticity.greens import ComponentSolid
from ase_roughcontact.elasticity.harmonics import Harmonics
from ase_roughcontact.elasticity.subsurface import Tractions, UniformResponse

# Surfaces with atoms on a square grid.
_SURFACES = dict.fromkeys(("fcc100", "bcc100", "diamond100"))
# Names of the components in the order of `ComponentSolid`.
_COMPONENTS = "zz", "xx", "yy", "xy", "zx", "zy"
# Largest relative difference of two spacings that are the same.
_SPACING_TOLERANCE = 1e-6


@dataclass(frozen=True, eq=False)
class Crystal(Summarized, Stored, ComponentSolid):
    """Half space of a crystal with a square grid of surface atoms.

    Objects are made by `from_calculator` or `read`.

    Parameters
    ----------
    symbol : str
        Chemical symbol.
    surface : {"fcc100", "bcc100", "diamond100"}
        The surface; x and y are along its rows of nearest neighbours. In diamond100 the
        bonds of its atoms are along x, and waves along x and y differ.
    calculator : str
        Name of the ASE calculator.
    spacing : float
        Distance a0 of nearest neighbours in the surface (Å), the only spacing with
        which the solid can be used.
    table : ndarray, shape (28, 20) or (2, 28, 20)
        Coefficients of ``1/E*``, see `interpolate` (1/pressure).
    stress : float
        Stress of the crystal below the surface along x and y, positive under tension
        (eV/Å^3); the stress along z is zero.
    lateral : ndarray, shape (5, 2, 28, 20) or (3, 2, 28, 20), optional
        Coefficients of ``|q| a0^2/2`` times components of the Green's function, see
        `interpolate` (1/pressure): xx, yy and, over ``sin(2 theta)``, xy; then, unless
        the coupling is not known, the imaginary parts of zx over ``cos(theta)``, and of
        zy over ``sin(theta)`` with x and y exchanged.
    moduli : ndarray, shape (3, 3, 3, 3), optional
        Elastic constants of the crystal below the surface, in the axes of the surface,
        for stresses there (pressure). Crystals in files of earlier versions have none.
    figures : dict
        Relative errors. Errors of the force constants are described in
        `ForceConstants`. Errors of E* are "thickness" (change from a slab with four
        layers less), "square" (difference of directions that are equivalent on the
        surface), "interpolation", and "long_waves" (difference of long waves from
        an elastic continuum with the moduli of the strained bulk).

    Attributes
    ----------
    contact_modulus : float
        Indentation modulus of long waves, ``1/E* = <1/E*(theta)>`` (pressure).
    """

    _kind = "crystal"
    _missing = "such lateral components (they are not in its file)"

    symbol: str
    surface: str
    calculator: str
    spacing: float
    table: np.ndarray = field(repr=False)
    stress: float = 0.0
    figures: dict[str, float] = field(default_factory=dict, repr=False)
    lateral: np.ndarray | None = field(default=None, repr=False)
    moduli: np.ndarray | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        lookup(self.symbol, atomic_numbers, "element")
        lookup(self.surface, _SURFACES, "square surface")
        positive(spacing=self.spacing)
        finite(stress=self.stress)
        # one memory layout, so that a crystal from a file gives the same last digits
        table = np.ascontiguousarray(self.table, dtype=float)
        if table.shape not in (NODES, (2, *NODES)) or not np.isfinite(table).all():
            shapes = f"{NODES} or {(2, *NODES)}"
            raise ValueError(f"the table must be finite numbers of the shape {shapes}")
        if interpolate(table, *node_vectors().T).min() <= 0.0:
            raise ValueError("the moduli of the table must be positive")
        object.__setattr__(self, "table", table)
        if self.lateral is not None:
            lateral = np.ascontiguousarray(self.lateral, dtype=float)
            valid_shape = lateral.shape in ((5, 2, *NODES), (3, 2, *NODES))
            if not valid_shape or not np.isfinite(lateral).all():
                raise ValueError(
                    f"lateral must be finite numbers of the shape {(5, 2, *NODES)}"
                )
            object.__setattr__(self, "lateral", lateral)
        if self.moduli is not None:
            moduli = np.ascontiguousarray(self.moduli, dtype=float)
            if moduli.shape != (3, 3, 3, 3) or not np.isfinite(moduli).all():
                raise ValueError("moduli must be finite, of the shape (3, 3, 3, 3)")
            object.__setattr__(self, "moduli", moduli)

    @classmethod
    def from_calculator(
        cls,
        calculator: Any,
        bulk: Atoms | str,
        surface: str = "fcc100",
        *,
        tolerance: float = 1e-3,
        **slab: Any,
    ) -> Crystal:
        """Return the crystal of an ASE calculator.

        A slab is relaxed, and its force constants are calculated down to its middle:
        about ``3 layers`` calculations of forces for ``size^2 layers`` atoms, repeated
        with four layers less. Energies of some 200 strained bulk cells check them.

        Parameters
        ----------
        calculator : Calculator
            ASE calculator of the energies of bulk crystals and the forces of slabs.
        bulk : Atoms or str
            Chemical symbol, or a crystal of one element with about the right lattice
            constant.
        surface : {"fcc100", "bcc100", "diamond100"}
            Crystal structure and surface.
        tolerance : float
            Largest relative error of the force constants and of E*.
        **slab
            ``lattice_constant``, by default the one without stress (Å). With a given
            one the crystal is still relaxed along z, and a warning reports a stress
            along x and y above 1e-3 of the contact modulus. ``layers``, the number of
            layers of the slab, odd and at least 9 (15). ``size``, the number of surface
            cells along each side of the slab, odd (9). ``displacement`` for the force
            constants (1e-3 Å); 0 to use the Hessian of the calculator, which must have
            the method `get_hessian` of matscipy.

        Returns
        -------
        Crystal
            The crystal; `write` keeps it in a file.

        Raises
        ------
        ValueError
            If the surface is not a square grid or not stable, the calculator gives no
            forces for a slab, or an error in `figures` is above the tolerance.

        Examples
        --------
        >>> from ase.calculators.emt import EMT
        >>> from ase_roughcontact.elasticity import Crystal
        >>> copper = Crystal.from_calculator(EMT(), "Cu")  # doctest: +SKIP
        >>> copper.write("copper.json")  # doctest: +SKIP
        """
        lookup(surface, _SURFACES, "square surface")
        found = calculated.calculated_surface(
            calculator, bulk, surface, tolerance=tolerance, **slab
        )
        table, lateral, errors = calculated.tables(found.greens)
        name = type(calculator).__name__
        calculated.check_errors(
            errors, tolerance, f"{surface} {found.symbol} with {name}"
        )
        figures, spacing = found.constants.figures | errors, found.constants.spacing
        return cls(
            found.symbol,
            surface,
            name,
            spacing,
            table,
            found.stress,
            figures,
            lateral,
            found.moduli,
        )

    @property
    def has_subsurface(self) -> bool:
        """Whether the elastic constants of the crystal are known."""
        return self.moduli is not None

    def subsurface(self, tractions: Tractions) -> AnisotropicWaves:
        """Return the stress of the continuum below the surface; see `ElasticSolid`.

        It differs from the stress between atoms within a few spacings of the surface.
        """
        if self.moduli is None:
            raise self._no_stress()
        return AnisotropicWaves(tractions, self.moduli)

    def uniform_response(self, depth: float) -> UniformResponse:
        """Return the response to a uniform traction; see `ElasticSolid`."""
        if self.moduli is None:
            raise self._no_stress()
        return anisotropic_uniform(self.moduli, depth)

    @property
    def contact_modulus(self) -> float:  # type: ignore[override]
        """Indentation modulus (pressure)."""
        return 1.0 / float(self._components[0].series[0][0].real)

    def check(self, spacing: float) -> None:
        """Raise an error if the grid has another spacing; see `ElasticSolid.check`."""
        if not self._has_spacing(spacing):
            raise ValueError(
                f"the atoms of {self.surface} {self.symbol} with {self.calculator} "
                f"have a spacing of {self.spacing:.6f}, the grid {spacing:.6f}: build "
                f"it with spacing=solid.spacing"
            )
        super().check(spacing)

    def _has_spacing(self, spacing: float) -> bool:
        return abs(spacing / self.spacing - 1.0) <= _SPACING_TOLERANCE

    @cached_property
    def _components(self) -> list[LatticeComponent]:
        tables = [self.table]
        if self.lateral is not None:
            tables.extend(self.lateral)
        return [
            LatticeComponent(table, name)
            for table, name in zip(tables, _COMPONENTS, strict=False)
        ]

    def cell_compliance(
        self, i: np.ndarray, j: np.ndarray, spacing: float
    ) -> np.ndarray:
        """Return the depth under unit pressure on an atom; see `ElasticSolid`.

        At another spacing, as on the coarse grids of the solvers, it is the response to
        long waves.
        """
        if not self._has_spacing(spacing):
            return spacing * Harmonics(self._components[0].series[0]).cells(i, j)
        return super().cell_compliance(i, j, spacing)

    def _in_zone(self, qx: np.ndarray, qy: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return wave vectors times the spacing.

        Raises
        ------
        ValueError
            If a wave vector is outside of the Brillouin zone, as on a finer grid.
        """
        x, y = np.multiply(qx, self.spacing), np.multiply(qy, self.spacing)
        if max(abs(x).max(), abs(y).max()) > np.pi * (1.0 + _SPACING_TOLERANCE):
            raise ValueError(
                f"the atoms of the crystal have a spacing of {self.spacing:.6g}, the "
                "grid a smaller one: build it with spacing=solid.spacing"
            )
        return x, y

    def _cells(
        self, part: slice, i: np.ndarray, j: np.ndarray, spacing: float
    ) -> np.ndarray:
        self.check(spacing)
        return super()._cells(part, i, j, spacing)

    def todict(self) -> dict[str, Any]:
        """Return name and parameters, which identify the solid in files.

        The table is replaced by its hash.
        """
        return {
            "name": "Crystal",
            "symbol": self.symbol,
            "surface": self.surface,
            "calculator": self.calculator,
            "spacing": self.spacing,
            "contact_modulus": self.contact_modulus,
            "table": digest(self.table.tobytes()),
        }
