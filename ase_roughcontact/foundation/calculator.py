"""ASE calculator: atoms of a slab on an elastic semi-infinite crystal."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any, Literal

import numpy as np
from ase import Atoms
from ase.calculators.calculator import Calculator, all_changes
from ase.constraints import FixSubsetCom

from ase_roughcontact._util.callers import warn
from ase_roughcontact._util.validation import instance_of, integer, one_of
from ase_roughcontact.foundation.coupling import Coupling
from ase_roughcontact.foundation.seam import SeamStress
from ase_roughcontact.foundation.sites import Sites, cells
from ase_roughcontact.foundation.surface import CrystalSurface

#: Key in `Atoms.info` of the name of the layer that `ElasticFoundation.hold` holds.
HELD_KEY = "held_layer"


class ElasticFoundation(Calculator):
    r"""Calculator of a slab of atoms on the semi-infinite crystal below it.

    The layers below the slab are replaced by their elastic response. With the energy
    :math:`U_\text{calc}` of the user's calculator and the displacement :math:`u_B` of
    the lowest layers from the relaxed crystal, the energy is

    .. math:: U = U_\text{calc}(x) - f_B \cdot u_B + \tfrac12\, u_B \cdot D\, u_B .

    The forces :math:`f_B` cancel the forces that are due to the cut, and the matrix
    :math:`D` makes the Hessian of :math:`U` at rest equal to the Hessian of the
    semi-infinite crystal. The layers above the coupled ones follow the user's
    calculator only: displacements may be larger than in a harmonic crystal, and atoms
    may slip or be added.

    The energy does not change when all atoms are displaced by the same vector. A load
    on the surface must therefore be balanced by `hold`, which `crystal_slab` calls.

    Parameters
    ----------
    calculator : Calculator
        ASE calculator of the energy and forces of the slab.
    surface : CrystalSurface
        Surface of the crystal from the same calculator.
    atoms : Atoms
        Slab, periodic along x and y, with its lowest layers close to their sites; see
        `crystal_slab`. Other atoms may be on top of it.
    layers : int, optional
        Number of complete layers of the crystal; by default the number of atoms over
        the number of cells, rounded down.
    fft : dict, optional
        Options of the transforms, see `RealFFT2`: `dtype`, `engine`, `threads`.

    Attributes
    ----------
    coupled_layers : int
        Number of the lowest layers on which the semi-infinite crystal acts. Their atoms
        must stay near their lattice sites.

    Raises
    ------
    ValueError
        If the atoms are not periodic along x and y, the cell is not a multiple of the
        surface cell, the lowest layers do not fit the crystal, or the surface was
        calculated with another calculator; in a calculation, if an atom of the coupled
        layers has left its site or is another element.

    Warns
    -----
    UserWarning
        Once, if no constraint acts on the layer that is held, or should be held as
        there is an indenter.

    Notes
    -----
    The semi-infinite crystal responds statically: molecular dynamics conserve the
    energy, but waves longer than the thickness of the slab are faster than in the
    crystal, and are not carried away. Stress and free boundaries along the surface are
    not supported.

    The calculator does not get atoms of the number zero (symbol X), such as the
    indenter of `RigidIndenter`.

    References
    ----------
    L. Pastewka, T. A. Sharp, M. O. Robbins, Phys. Rev. B 86, 075459 (2012); C. Campañá,
    M. H. Müser, Phys. Rev. B 74, 075420 (2006).
    """

    implemented_properties = ["energy", "free_energy", "forces"]
    nolabel = True

    def __init__(
        self,
        calculator: Any,
        surface: CrystalSurface,
        atoms: Atoms,
        layers: int | None = None,
        *,
        fft: Mapping[str, Any] | None = None,
    ) -> None:
        super().__init__()
        instance_of(CrystalSurface, surface=surface)
        instance_of(Atoms, atoms=atoms)
        slab = atoms[atoms.numbers > 0]
        shape = cells(slab, surface)
        complete = len(slab) // (shape[0] * shape[1])
        layers = complete if layers is None else layers
        self.calculator = calculator
        self.surface = surface
        self.layers = integer("layers", layers, 1)
        # sites first: their errors are found at once
        coupled = min(layers, surface.constants.reach)
        self.sites = Sites.of(slab, surface, layers, coupled)
        surface.check_calculator(calculator)
        self._slab = slab.copy()
        self._warned = False
        self.coupling = Coupling(surface, calculator, shape, layers, **(fft or {}))

    @property
    def coupled_layers(self) -> int:
        """Number of the lowest layers on which the semi-infinite crystal acts."""
        return self.coupling.layers

    def all_sites(self) -> Sites:
        """Return the sites of all layers of the slab when the foundation was made."""
        return Sites.of(self._slab, self.surface, self.layers, self.layers)

    def hold(
        self, atoms: Atoms, layer: Literal["lowest", "surface"] = "lowest"
    ) -> None:
        """Hold the centre of mass of a layer by a constraint.

        The constraint balances loads on the surface. Heights are relative to the mean
        plane of the held layer. If the lowest layer is held, a load compresses the slab
        uniformly, the more the more layers the slab has. If the surface is held, a load
        at the wave vector zero does not deform the slab, and depths of an indenter do
        not depend on the number of layers: they agree with `RoughContact` on a periodic
        half space. Hold the lowest layer if atoms of the surface slip, as their mean
        plane is then no plane of the crystal.

        ASE does not remove atoms from a slab with this constraint: build the slab
        without it, remove atoms, and then hold the slab. The name of the layer is kept
        in `Atoms.info`. If the constraint gets lost, in files without constraints or by
        `Atoms.set_constraint`, a calculation warns.

        Parameters
        ----------
        atoms : Atoms
            The slab, which is changed in place.
        layer : {"lowest", "surface"}
            Layer that is held.

        Raises
        ------
        ValueError
            If the layer is unknown, or the layers below the surface are not complete.
        """
        one_of(("lowest", "surface"), layer=layer)
        sites = self.sites
        if layer == "surface":
            slab = atoms[atoms.numbers > 0]
            sites = Sites.of(slab, self.surface, self.layers, self.layers)
        held = sites.indices[0 if layer == "surface" else -1].ravel()
        held = np.flatnonzero(atoms.numbers > 0)[held]
        atoms.set_constraint([*atoms.constraints, HeldLayer(held)])
        atoms.info[HELD_KEY] = layer
        self._warned = False

    def seam_stress(self, atoms: Atoms) -> SeamStress:
        """Return the stress on the plane between the slab and the crystal below it.

        It is the force of the crystal below on each cell of the slab, over the area of
        the cell, and needs no stress of single atoms. Waves that are long compared with
        the reach of the forces have the stress of the continuum at this depth, see
        `StressField`.

        Parameters
        ----------
        atoms : Atoms
            Relaxed slab with its calculator. If the lowest layer is held, the mean
            balances the forces on the slab; if the surface is held, it is zero.

        Returns
        -------
        SeamStress
            The attributes `depth` of the plane (Å), `positions` x and y of the cells,
            shape (n, m, 2) (Å), and `stress` xz, yz and zz, shape (3, n, m), tension
            positive (eV/Å^3).

        Raises
        ------
        ValueError
            If an atom of the lowest layers has left its site.
        """
        real = atoms.numbers > 0
        displacement = self.sites.displacement(atoms.positions[real])
        forces = -self.coupling.evaluate(displacement)[1].sum(axis=0)
        if atoms.info.get(HELD_KEY) != "surface":
            loads = atoms.get_forces(apply_constraint=False)[real]
            forces += loads.sum(axis=0) / (forces.shape[0] * forces.shape[1])
        lowest, below = self.surface.column(self.layers + 1).positions[-2:, 2]
        return SeamStress(
            depth=float(-(lowest + below) / 2.0),
            positions=self.sites.positions[-1, :, :, :2],
            stress=np.moveaxis(forces, -1, 0) / self.surface.cell_area,
        )

    @cached_property
    def _surface_layer(self) -> np.ndarray:
        """Indices of the atoms of the surface in the slab."""
        return self.all_sites().indices[0].ravel()

    def calculate(
        self,
        atoms: Atoms | None = None,
        properties: list[str] | None = None,
        system_changes: list[str] = all_changes,
    ) -> None:
        """Calculate energy and forces; see the class."""
        super().calculate(atoms, properties, system_changes)
        real = np.flatnonzero(self.atoms.numbers > 0)
        slab = self.atoms[real]
        slab.set_constraint()  # constraints act on the sum of all forces
        self._check(slab)
        self._warn_if_released()
        displacement = self.sites.displacement(slab.positions)
        energy, coupled = self.coupling.evaluate(displacement)
        slab.calc = self.calculator
        energy += slab.get_potential_energy()
        forces = np.zeros((len(self.atoms), 3))
        forces[real] = slab.get_forces()
        forces[real[self.sites.indices]] += coupled
        self.results = {"energy": energy, "free_energy": energy, "forces": forces}

    def _warn_if_released(self) -> None:
        """Warn once if no constraint acts on the layer that should be held."""
        loaded = (self.atoms.numbers == 0).any() or self.atoms.info.get(HELD_KEY)
        if self._warned or not loaded:
            return
        forces = np.ones((len(self.atoms), 3))
        for constraint in self.atoms.constraints:
            constraint.adjust_forces(self.atoms, forces)
        layer = self.sites.indices[-1].ravel()
        if self.atoms.info.get(HELD_KEY) == "surface":
            layer = self._surface_layer
        if (forces[self.atoms.numbers > 0][layer] == 1.0).all():
            self._warned = True
            warn(
                "nothing holds the slab under a load: the constraint of hold is lost "
                "or missing. Call foundation.hold(atoms), and add constraints by "
                "set_constraint([*atoms.constraints, new])"
            )

    def _check(self, slab: Atoms) -> None:
        if not slab.pbc[:2].all() or slab.pbc[2]:
            cells(slab, self.surface)
        if abs(slab.cell.array[:2] - self.sites.cell[:2]).max() > 0.0:
            raise ValueError(
                "the cell of atoms on an elastic foundation must not change: make "
                "another foundation for this cell"
            )
        if len(slab) <= self.sites.indices.max():
            raise ValueError(
                "atoms of the lowest layers have been removed: make a new foundation, "
                "or remove atoms above them only"
            )
        lowest = set(slab.symbols[self.sites.indices.ravel()])
        if lowest != {self.surface.symbol}:
            raise ValueError(
                f"atoms of the {self.coupled_layers} lowest layers must be "
                f"{self.surface.symbol}, got {', '.join(lowest)}: replace atoms above "
                "them only"
            )


class HeldLayer(FixSubsetCom):
    """Constraint that holds the centre of mass of a layer of atoms.

    It moves the atoms of the layer only, as the force of a constraint does, so that
    dynamics conserve the energy. ASE's `FixSubsetCom` moves all atoms to hold the
    centre of mass of some. Files store the constraint as `FixSubsetCom`.

    Parameters
    ----------
    indices : sequence of int
        Indices of the atoms of the layer, which have the same mass.
    """

    def adjust_positions(self, atoms: Atoms, new: np.ndarray) -> None:
        """Displace the layer so that its centre of mass does not move."""
        new[self.index] += (atoms.positions - new)[self.index].mean(axis=0)

    def copy(self) -> HeldLayer:
        """Return a constraint of the same atoms."""
        return HeldLayer(self.index)

    def todict(self) -> dict[str, Any]:
        """Return the data of ASE's `FixSubsetCom`, for files."""
        return {**super().todict(), "name": "FixSubsetCom"}
