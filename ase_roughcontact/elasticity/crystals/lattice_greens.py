r"""Green's function of the surface of a crystal, from its force constants.

For a wave vector q along the surface, the couplings of the layers are dynamical
matrices

.. math:: D_{ll'}(q) = \sum_R \Phi_{ll'}(R)\, e^{i q \cdot R},

which act on displacements :math:`\exp(i q \cdot r)`. Those of the bulk depend on
:math:`l' - l` and the sublattice of :math:`l` alone. Principal layers of as many layers
as the force constants reach couple to their neighbours only. The bulk is condensed onto
its first principal layer by decimation, each step of which eliminates every second one,
and the layers near the surface are added on top. The Green's function is the block of
the first layer of the inverse.

References
----------
M. P. López Sancho, J. M. López Sancho, J. Rubio, J. Phys. F 15, 851 (1985); C. Campañá,
M. H. Müser, Phys. Rev. B 74, 075420 (2006); L. Pastewka, T. A. Sharp, M. O. Robbins,
Phys. Rev. B 86, 075459 (2012).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ase_roughcontact.elasticity.crystals.force_constants import ForceConstants

# Coupling of the remaining principal layers, relative to their stiffness, at which the
# decimation ends, and its largest number of steps.
_DECOUPLED, _MOST_STEPS = 1e-15, 60


class LatticeGreensFunction:
    """Response of the surface atoms of a crystal to forces on them.

    The sum rule and the symmetry under exchange of two atoms are imposed on the force
    constants: couplings are averaged, and those of an atom with itself corrected.

    Parameters
    ----------
    constants : ForceConstants
        Couplings down to the first layer of the bulk.
    layers : int, optional
        Largest number of layers of which `stiffness` is needed.

    Attributes
    ----------
    spacing : float
        Distance of nearest neighbours in the surface (length).
    layers : int
        Number of layers that are not decimated.
    sublattices : int
        Number of sublattices, on alternate layers.
    """

    def __init__(self, constants: ForceConstants, layers: int = 0) -> None:
        self.spacing = constants.spacing
        self._reach, bulk = constants.reach, constants.bulk
        self.sublattices = constants.sublattices
        # layers that are not decimated: all that couple to one above the bulk
        self.layers = max(bulk + self._reach, layers)
        # half of the average over both atoms as sources
        ends = np.stack([constants.source, constants.target])
        source, target = np.concatenate([ends, ends[::-1]], axis=1)
        offset = np.concatenate([constants.offset, -constants.offset])
        matrix = constants.matrix / 2
        # of these, only the upper one of the atoms has been a source
        matrix[(constants.source < bulk) & (constants.target >= bulk)] *= 2
        matrix = np.concatenate([matrix, matrix.swapaxes(1, 2)])
        is_deep = np.tile(constants.source >= bulk, 2)
        top = ~is_deep
        upper = [(source[top], target[top], offset[top], matrix[top])]
        sublattice, shift = source % self.sublattices, target - source
        for layer in range(bulk, self.layers):
            here = is_deep & (sublattice == layer % self.sublattices)
            here &= layer + shift >= bulk
            above = np.full(here.sum(), layer)
            upper.append((above, above + shift[here], offset[here], matrix[here]))
        arrays = [np.concatenate(each) for each in zip(*upper, strict=True)]
        known = arrays[1] < self.layers + self._reach
        self._upper = _with_sum_rule([each[known] for each in arrays], self.layers)
        deep = sublattice, sublattice + shift, offset, matrix
        self._deep = _with_sum_rule([each[is_deep] for each in deep], self.sublattices)

    def __call__(self, q: np.ndarray) -> np.ndarray:
        """Return the Green's function of waves along the surface.

        Parameters
        ----------
        q : ndarray, shape (n, 2)
            Wave vectors, none of them zero (1/length).

        Returns
        -------
        ndarray, shape (n, 3, 3)
            Displacement ``exp(i q.r)`` of the surface atoms per force on each
            (length/force).

        Raises
        ------
        ValueError
            If the surface is not stable.
        """
        top = self.stiffness(q, self.layers)
        if np.linalg.eigvalsh(top).min() <= 0.0:
            raise ValueError(
                "the surface is not stable: its force constants have a negative mode, "
                "and it reconstructs. Describe the solid by elastic constants (Cubic)"
            )
        load = np.zeros((*top.shape[:-1], 3))
        load[:, :3] = np.eye(3)
        return np.linalg.solve(top, load)[:, :3]

    def stiffness(self, q: np.ndarray, number: int) -> np.ndarray:
        """Return the stiffness of the upper layers, the others being relaxed.

        Parameters
        ----------
        q : ndarray, shape (n, 2)
            Wave vectors, none of them zero (1/length).
        number : int
            Number of layers, at most `layers`.

        Returns
        -------
        ndarray, shape (n, 3 number, 3 number)
            Force on waves ``exp(i q.r)`` per displacement, with minus sign
            (force/length).

        Raises
        ------
        ValueError
            If the crystal below is not stable.
        """
        q = np.asarray(q, dtype=float)
        reach, layers = self._reach, self.layers
        bulk = dynamical_matrices(q, self._deep)
        zero = np.zeros_like(bulk[0, 0])
        rows = [(a, (layers + a) % self.sublattices) for a in range(reach)]
        within, below, above = (
            _blocks(
                [
                    [bulk.get((s, s + shift + b - a), zero) for b in range(reach)]
                    for a, s in rows
                ]
            )
            for shift in (0, reach, -reach)
        )
        surface = _decimated(within, below, above)

        matrices = dynamical_matrices(q, self._upper)
        top, coupling = (
            _blocks(
                [[matrices.get((a, b), zero) for b in columns] for a in range(layers)]
            )
            for columns in (range(layers), range(layers, layers + reach))
        )
        adjoint = coupling.conj().swapaxes(-1, -2)
        top = top - coupling @ np.linalg.solve(surface, adjoint)
        if number < layers:
            n = 3 * number
            relaxed = np.linalg.solve(top[:, n:, n:], top[:, n:, :n])
            top = top[:, :n, :n] - top[:, :n, n:] @ relaxed
        return (top + top.conj().swapaxes(-1, -2)) / 2


def _with_sum_rule(couplings: list[np.ndarray], layers: int) -> list[np.ndarray]:
    """Return couplings without a force under a uniform displacement."""
    source, target, offset, matrix = couplings
    for layer in range(layers):
        total = matrix[source == layer].sum(axis=0)
        itself = (source == layer) & (target == layer)
        itself &= abs(offset).max(axis=1) == 0.0
        matrix[np.flatnonzero(itself)[0]] -= (total + total.T) / 2
    return couplings


def dynamical_matrices(
    q: np.ndarray, couplings: Sequence[np.ndarray]
) -> dict[tuple[int, int], np.ndarray]:
    """Return the dynamical matrices at wave vectors, shape (n, 2), by pairs of layers.

    Each has the shape (n, 3, 3). The couplings are source, target, offset and matrix as
    in `ForceConstants`.
    """
    source, target, offset, matrix = couplings
    matrices = {}
    for a, b in sorted(set(zip(source.tolist(), target.tolist(), strict=True))):
        pair = (source == a) & (target == b)
        phases = np.exp(1j * q @ offset[pair].T)
        matrices[a, b] = np.einsum("qn,nij->qij", phases, matrix[pair])
    return matrices


def _blocks(blocks: list[list[np.ndarray]]) -> np.ndarray:
    """Return matrices of blocks, each of shape (n, 3, 3)."""
    return np.concatenate([np.concatenate(row, axis=-1) for row in blocks], axis=-2)


def _decimated(within: np.ndarray, below: np.ndarray, above: np.ndarray) -> np.ndarray:
    """Return the stiffness of the first principal layer of a semi-infinite crystal."""
    surface = within
    for _ in range(_MOST_STEPS):
        if abs(below).max() <= _DECOUPLED * abs(within).max():
            return surface
        to_below, to_above = (np.linalg.solve(within, m) for m in (below, above))
        surface = surface - below @ to_above
        within = within - below @ to_above - above @ to_below
        below, above = -below @ to_below, -above @ to_above
        if np.linalg.eigvalsh(surface).min() <= 0.0:
            break
    raise ValueError(
        "the crystal is not stable: its force constants have a negative mode, or "
        "errors that a larger displacement or more layers reduce (or a wave vector is "
        "zero)"
    )
