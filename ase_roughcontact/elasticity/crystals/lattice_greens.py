r"""Green's function of the surface of a crystal, from its force constants.

For a wave vector q along the surface, the couplings of the layers are dynamical
matrices

.. math:: D_{ll'}(q) = \sum_R \Phi_{ll'}(R)\, e^{i q \cdot R},

which act on displacements :math:`\exp(i q \cdot r)`. In the bulk they depend only on
:math:`l' - l` and on the sublattice of :math:`l`. Principal layers, each of as many
layers as the force constants reach, couple to their neighbours only. Decimation
condenses the bulk onto its first principal layer: each step eliminates every second
principal layer. The layers near the surface are added on top. The Green's function is
the block of the first layer in the inverse.

References
----------
M. P. López Sancho, J. M. López Sancho, J. Rubio, J. Phys. F 15, 851 (1985); C. Campañá,
M. H. Müser, Phys. Rev. B 74, 075420 (2006); L. Pastewka, T. A. Sharp, M. O. Robbins,
Phys. Rev. B 86, 075459 (2012).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple
from itertools import product

import numpy as np

from ase_roughcontact.elasticity.crystals.force_constants import ForceConstants

# Coupling of neighbouring principal layers, relative to their stiffness, at which the
# decimation ends.
_MIN_COUPLING = 1e-15
# Largest number of steps of the decimation.
_MAX_STEPS = 60


class LatticeGreensFunction:
    """Response of the surface atoms of a crystal to forces on them.

    The sum rule and the symmetry under exchange of two atoms are imposed on the force
    constants: the couplings of two atoms are averaged, and the coupling of an atom with
    itself is corrected.

    Parameters
    ----------
    constants : ForceConstants
        Couplings down to the first layer of the bulk.
    layers : int, optional
        Largest number of layers for which `stiffness` is needed.

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
        self.spacing, self.sublattices = constants.spacing, constants.sublattices
        self._bulk, self._reach = constants.bulk, constants.reach
        # layers that are not decimated: all that couple to one above the bulk
        self.layers = max(self._bulk + self._reach, layers)
        self._couplings = astuple(constants)[:4]
        self._itself = np.zeros((self.layers + 2 * self._reach, 3, 3))
        totals = self._matrices(np.zeros((1, 2)))[0].real.sum(axis=1)
        # sums of the last principal layer are incomplete, but not needed
        self._itself = -(totals + totals.swapaxes(1, 2)) / 2

    def __call__(self, q: np.ndarray) -> np.ndarray:
        """Return the Green's function of waves along the surface.

        Parameters
        ----------
        q : ndarray, shape (n, 2)
            Wave vectors, none of them zero (1/length).

        Returns
        -------
        ndarray, shape (n, 3, 3)
            Amplitude of the displacement ``exp(i q.r)`` of the surface atoms per force
            on each (length/force).

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
        """Return the stiffness of the upper layers; the layers below are relaxed.

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
        blocks = self._matrices(q).swapaxes(2, 3)
        matrix = blocks.reshape(len(q), *(2 * [3 * blocks.shape[1]]))
        first, second = 3 * self.layers, 3 * (self.layers + self._reach)
        upper, below = slice(first), slice(first, second)
        surface = _decimated(matrix[:, below, below], matrix[:, below, second:])
        top, coupling = matrix[:, upper, upper], matrix[:, upper, below]
        adjoint = coupling.conj().swapaxes(-1, -2)
        top = top - coupling @ np.linalg.solve(surface, adjoint)
        if number < self.layers:
            n = 3 * number
            relaxed = np.linalg.solve(top[:, n:, n:], top[:, n:, :n])
            top = top[:, :n, :n] - top[:, :n, n:] @ relaxed
        return (top + top.conj().swapaxes(-1, -2)) / 2

    def _matrices(self, q: np.ndarray) -> np.ndarray:
        """Return dynamical matrices of pairs of layers, shape (n, l, l, 3, 3).

        After the layers that are not decimated come two principal layers.
        """
        number, bulk = len(self._itself), self._bulk
        matrices = np.zeros((len(q), number, number, 3, 3), complex)
        given = dynamical_matrices(q, self._couplings)
        for a, b in product(range(number), repeat=2):
            # the layer of the same sublattice that represents the bulk
            source = a if a < bulk else bulk + (a - bulk) % self.sublattices
            matrix = given.get((source, source + b - a))
            # decimated layers are not coupled to layers above the bulk
            beyond = a < bulk and b >= self.layers
            if matrix is None or beyond or b < bulk <= a:
                continue
            # a pair is found from both atoms, unless only one is above the bulk
            half = matrix if a < bulk <= b else matrix / 2
            matrices[:, a, b] += half
            matrices[:, b, a] += half.conj().swapaxes(1, 2)
        each = np.arange(number)
        matrices[:, each, each] += self._itself
        return matrices


def dynamical_matrices(
    q: np.ndarray, couplings: Sequence[np.ndarray]
) -> dict[tuple[int, int], np.ndarray]:
    """Return the dynamical matrices at wave vectors, shape (n, 2), by pairs of layers.

    Each has the shape (n, 3, 3). The couplings are the arrays source, target, offset
    and matrix of `ForceConstants`.
    """
    source, target, offset, matrix = couplings
    matrices = {}
    for a, b in sorted(set(zip(source.tolist(), target.tolist(), strict=True))):
        pair = (source == a) & (target == b)
        phases = np.exp(1j * q @ offset[pair].T)
        matrices[a, b] = np.einsum("qn,nij->qij", phases, matrix[pair])
    return matrices


def _decimated(within: np.ndarray, below: np.ndarray) -> np.ndarray:
    """Return the stiffness of the first principal layer of a semi-infinite crystal."""
    surface = within
    for _ in range(_MAX_STEPS):
        if abs(below).max() <= _MIN_COUPLING * abs(within).max():
            return surface
        above = below.conj().swapaxes(-1, -2)
        to_below, to_above = (np.linalg.solve(within, m) for m in (below, above))
        surface = surface - below @ to_above
        within = within - below @ to_above - above @ to_below
        below = -below @ to_below
        if np.linalg.eigvalsh(surface).min() <= 0.0:
            break
    raise ValueError(
        "the crystal is not stable: its force constants have a negative mode or large "
        "errors: increase displacement or layers (wave vectors must not be zero)"
    )
