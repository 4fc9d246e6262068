r"""Newton's equations for a small number of atoms in contact, by dense matrices.

On the atoms with a stiffness :math:`D > 0` the changes :math:`x` of the pressure and
:math:`z` of the height solve

.. math:: (D^{-1} + G) x + z = D^{-1} r, \qquad \sum x - s z = t ,

as in `newton_system`, with the exact compliance :math:`G` between pairs of atoms. The
matrix is symmetric and positive definite.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg.lapack import dpotrf, dpotrs

from ase_roughcontact._util.threads import split

# Size of matrices up to which BLAS does not start threads, whose number would change
# the rounding of the result.
_SINGLE_THREAD = 64


class DenseEquations:
    """Newton's equations of a small window.

    Parameters
    ----------
    compliance : ndarray, shape (n, m)
        Opening of the gap by a unit pressure on the first atom of the window, which is
        a function of the distances along x and y.
    """

    def __init__(self, compliance: np.ndarray) -> None:
        n, m = compliance.shape
        rows, columns = abs(np.arange(1 - n, n)), abs(np.arange(1 - m, m))
        # compliance between the atoms i and k, at the place of i - k
        self._pairs = compliance[np.ix_(rows, columns)].reshape(-1)
        self._origin = self._pairs.size // 2
        self._places = np.add.outer(np.arange(n) * columns.size, np.arange(m))

    def solve(
        self,
        stiffness: np.ndarray,
        residual: np.ndarray,
        spring: float | None,
        load: float,
    ) -> tuple[np.ndarray, float] | None:
        """Return the changes of the pressure and the height.

        Parameters
        ----------
        stiffness, residual : ndarray, shape (n, m)
            D, not negative, and r.
        spring : float or None
            s; None if the height is fixed.
        load : float
            t.

        Returns
        -------
        x : ndarray, shape (n, m)
        z : float
            None stands for both if the matrix is singular to rounding errors.
        """
        held = np.flatnonzero(stiffness)
        places, d = self._places.take(held), stiffness.take(held)
        change = np.where(stiffness > 0.0, 0.0, residual)
        right = np.ones((held.size, 2))
        right[:, 0] = residual.take(held) / d
        lost = np.flatnonzero(change)
        if lost.size:
            opening = self._between(places, self._places.take(lost))
            right[:, 0] -= (opening * change.take(lost)).sum(axis=1)
        matrix = self._between(places, places)
        matrix.reshape(-1)[:: held.size + 1] += 1.0 / d
        solution = solve_positive(matrix, right)
        if solution is None:
            return None
        x, response = solution.T
        z = 0.0
        if spring is not None:
            missing = x.sum() + change.sum() - load
            z = float(missing / (response.sum() + spring))
        change.put(held, x - z * response)
        return change, z

    def _between(self, i: np.ndarray, k: np.ndarray) -> np.ndarray:
        """Return the compliances between atoms at two sets of places."""
        return self._pairs.take(np.subtract.outer(i + self._origin, k))


def solve_positive(matrix: np.ndarray, right: np.ndarray) -> np.ndarray | None:
    """Solve a symmetric, positive definite system, with the same bits on any threads.

    Gaussian elimination of blocks that are too small for LAPACK to start threads.

    Parameters
    ----------
    matrix : ndarray, shape (k, k)
        Overwritten.
    right : ndarray, shape (k, l)

    Returns
    -------
    ndarray, shape (k, l), or None
        None if the matrix is not positive definite.
    """
    a, b = matrix, right.copy()
    blocks = split(len(a), _SINGLE_THREAD)
    for i, block in enumerate(blocks):
        factor, info = dpotrf(a[block, block], lower=1)
        if info:
            return None
        b[block] = dpotrs(factor, b[block], lower=1)[0]
        for k, other in enumerate(blocks[i + 1 :], i + 1):
            coupling = a[other, block].copy()
            a[block, other] = dpotrs(factor, coupling.T, lower=1)[0]
            b[other] -= coupling @ b[block]
            for last in blocks[i + 1 : k + 1]:
                a[other, last] -= coupling @ a[block, last]
    for i, block in reversed(list(enumerate(blocks))):
        for other in blocks[i + 1 :]:
            b[block] -= a[block, other] @ b[other]
    return b
