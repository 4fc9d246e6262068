"""The elastic half crystal as a preconditioner for ASE's optimizers."""

from __future__ import annotations

import numpy as np
from ase import Atoms
from ase.optimize.precon import Precon

from ase_roughcontact._util.validation import nonnegative
from ase_roughcontact.elasticity.crystals.lattice_greens import LatticeGreensFunction
from ase_roughcontact.foundation.calculator import ElasticFoundation
from ase_roughcontact.foundation.coupling import apply, on_cells


class FoundationPrecon(Precon):
    r"""Stiffness of the explicit layers at rest, on the half crystal below them.

    .. math:: P(q) = H_\text{half crystal}(q) + k_\text{contact}

    is a matrix of the layers for each wave vector, and the second term is that of a
    wall on the first layer. Other atoms are multiplied by a constant. With it, the
    number of steps does not increase with the size of the cell.

    Parameters
    ----------
    atoms : Atoms
        A slab on its foundation, and other atoms.
    foundation : ElasticFoundation
        All layers of the crystal were complete when it was made.
    contact_stiffness : float, optional
        Stiffness of a wall on each atom of the surface (eV/Å^2).

    Raises
    ------
    ValueError
        If the layers of the slab were not complete.

    Examples
    --------
    >>> from ase.calculators.emt import EMT
    >>> from ase.optimize.precon import PreconLBFGS
    >>> from ase_roughcontact import FoundationPrecon, crystal_slab
    >>> atoms, foundation = crystal_slab("Cu", (8, 8), 4, EMT())  # doctest: +SKIP
    >>> precon = FoundationPrecon(atoms, foundation)  # doctest: +SKIP
    >>> PreconLBFGS(atoms, precon=precon).run(fmax=1e-3)  # doctest: +SKIP
    """

    def __init__(
        self,
        atoms: Atoms,
        foundation: ElasticFoundation,
        contact_stiffness: float = 0.0,
    ) -> None:
        nonnegative(contact_stiffness=contact_stiffness)
        surface, layers = foundation.surface, foundation.layers
        sites = foundation.all_sites()
        real = np.flatnonzero(atoms.numbers > 0)
        if len(real) <= sites.indices.max():
            raise ValueError(
                f"the foundation was made for {sites.indices.size} atoms of the "
                f"crystal, got {len(real)} atoms"
            )
        self._indices = real[sites.indices]
        greens = LatticeGreensFunction(surface.constants, layers)
        self._stiffness = on_cells(
            lambda q: greens.stiffness(q, layers),
            surface.column(layers),
            sites.indices.shape[1:],
            surface.constants.spacing,
        )
        # all atoms together move as if held like the softest wave
        waves = self._stiffness.reshape(-1, 3 * layers, 3 * layers)[1:]
        softest = np.linalg.eigvalsh(waves)[:, 0].min(initial=1.0)
        uniform = np.tile(np.eye(3), (layers, 1)) / layers**0.5
        self._stiffness[0, 0] += softest * uniform @ uniform.T
        self._stiffness[:, :, range(3), range(3)] += contact_stiffness
        self._compliance = np.linalg.inv(self._stiffness)
        diagonal = np.einsum("nmii->nmi", self._stiffness).real
        self._other = float(diagonal.mean())

    def make_precon(self, atoms: Atoms, reinitialize: bool | None = None) -> None:
        """Do nothing: the stiffness is that at rest."""

    def Pdot(self, x: np.ndarray) -> np.ndarray:  # noqa: N802
        """Apply P to a vector of shape (3 N,)."""
        return self._apply(x, self._stiffness, self._other)

    def solve(self, x: np.ndarray) -> np.ndarray:
        """Apply the inverse of P to a vector of shape (3 N,)."""
        return self._apply(x, self._compliance, 1.0 / self._other)

    def copy(self) -> FoundationPrecon:
        """Return the preconditioner itself, which has no state."""
        return self

    def asarray(self) -> np.ndarray:
        """Raise an error: P is not stored as a matrix of all atoms."""
        raise NotImplementedError("FoundationPrecon has no matrix of all atoms")

    def _apply(self, x: np.ndarray, matrices: np.ndarray, other: float) -> np.ndarray:
        vectors = x.reshape(-1, 3)
        result = other * vectors
        result[self._indices] = apply(matrices, vectors[self._indices])
        return result.reshape(x.shape)
