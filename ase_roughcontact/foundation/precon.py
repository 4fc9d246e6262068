"""The elastic semi-infinite crystal as a preconditioner for ASE's optimizers."""

from __future__ import annotations

import numpy as np
from ase import Atoms

from ase_roughcontact._util.precon import ConstantPrecon
from ase_roughcontact._util.validation import instance_of
from ase_roughcontact.elasticity.crystals.lattice_greens import LatticeGreensFunction
from ase_roughcontact.foundation.calculator import ElasticFoundation
from ase_roughcontact.foundation.coupling import apply, on_cells

# Stiffness against a displacement of all atoms, relative to the mean of the layers.
_RELATIVE_STIFFNESS = 1e3


class FoundationPrecon(ConstantPrecon):
    """Preconditioner: stiffness of the explicit layers on the crystal below, at rest.

    For each wave vector the stiffness is a matrix of the layers; for other atoms it is
    a constant. The number of steps does then not increase with the size of the cell.

    Parameters
    ----------
    atoms : Atoms
        Slab on its foundation, and other atoms.
    foundation : ElasticFoundation
        Foundation of a slab where all layers were complete when it was made.

    Raises
    ------
    ValueError
        If the layers of the slab were not complete.
    TypeError
        If an argument has the wrong type.

    Examples
    --------
    >>> from ase.calculators.emt import EMT
    >>> from ase.optimize.precon import PreconLBFGS
    >>> from ase_roughcontact.foundation import FoundationPrecon, crystal_slab
    >>> atoms, foundation = crystal_slab("Cu", (8, 8), 4, EMT())  # doctest: +SKIP
    >>> precon = FoundationPrecon(atoms, foundation)  # doctest: +SKIP
    >>> optimizer = PreconLBFGS(atoms, precon=precon)  # doctest: +SKIP
    >>> optimizer.run(fmax=1e-3)  # doctest: +SKIP
    """

    def __init__(self, atoms: Atoms, foundation: ElasticFoundation) -> None:
        instance_of(Atoms, atoms=atoms)
        instance_of(ElasticFoundation, foundation=foundation)
        surface, layers = foundation.surface, foundation.layers
        sites = foundation.all_sites()
        real = np.flatnonzero(atoms.numbers > 0)
        if len(real) <= sites.indices.max():
            raise ValueError(
                f"the foundation was made for {sites.indices.size} atoms of the "
                f"crystal, got {len(real)} atoms"
            )
        super().__init__(len(atoms))
        self._indices = real[sites.indices]
        greens = LatticeGreensFunction(surface.constants, layers)
        self._stiffness = on_cells(
            lambda q: greens.stiffness(q, layers),
            surface.column(layers),
            sites.indices.shape[1:],
            surface.constants.spacing,
        )
        diagonal = np.einsum("nmii->nmi", self._stiffness).real
        self._other = float(diagonal.mean())
        # all layers move relative to the lowest one, with a mean that is nearly held
        mean, lowest = self._stiffness[0, 0], slice(-3, None)
        mean[lowest] = mean[:, lowest] = 0.0
        mean[lowest, lowest] = np.eye(3) * self._other * _RELATIVE_STIFFNESS
        self._compliance = np.linalg.inv(self._stiffness)
        self._transform = foundation.coupling.transform

    def _applied(self, vectors: np.ndarray, inverse: bool) -> np.ndarray:
        matrices = self._compliance if inverse else self._stiffness
        result = vectors / self._other if inverse else vectors * self._other
        moved = vectors[self._indices]
        result[self._indices] = apply(matrices, moved, self._transform)
        return result
