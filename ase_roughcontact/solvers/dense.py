r"""Contact of few atoms with a repulsive wall, by dense matrices.

With the gap :math:`w(q)` at which the wall has the pressure :math:`q`, zero for a hard
wall, :math:`w(q) = Z + h + G q` for the atoms in contact, and :math:`q = 0` elsewhere.
A step of the semismooth Newton method linearises the wall at the pressure :math:`q_0`
and the height :math:`Z_0` and solves

.. math:: (D^{-1} + G) q + Z = w + D^{-1} p - h, \qquad \sum q - s (Z - Z_0) = L

for the pressures in contact and the height, with the exact compliance :math:`G` between
pairs of atoms, pressure :math:`p` and stiffness :math:`D` of the wall at the gap
:math:`w(q_0)`, the stiffness :math:`s` of springs on the indenter per area of an atom
and the required sum :math:`L` of the pressures. The matrix is symmetric and positive
definite. A convolution gives the gaps :math:`g` of all atoms.

In contact are the atoms with :math:`p + \min(D, 1/c) (w - g) > 0`, where :math:`c` is
the self-compliance. With a hard wall this is the primal-dual active-set method.

References
----------
M. Hintermüller, K. Ito, K. Kunisch, SIAM J. Optim. 13, 865 (2002).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg.blas import dgemm
from scipy.linalg.lapack import dposv, dpotrf, dtrtri

from ase_roughcontact._util.threads import split
from ase_roughcontact.contact import Contact
from ase_roughcontact.elasticity.halfspace import HalfSpace

# Size of matrices up to which no version of OpenBLAS starts threads, whose number would
# change the rounding of the result: products do above 64, decompositions from 64 on.
_SINGLE_THREAD = 63
# Largest number of steps; most contacts need four to seven.
_STEPS = 12

# Longest side of a window.
_LONGEST_SIDE = 64

#: Stiffness of springs on the indenter per area of an atom, and required sum of the
#: pressures, at a height.
Support = Callable[[float], tuple[float, float]]


@dataclass(frozen=True)
class DenseState:
    """Pressure, opening of the gap and height, and whether they solve the problem."""

    pressure: np.ndarray
    opening: np.ndarray
    height: float
    converged: bool


class DenseContact:
    """Contact of few atoms with a repulsive wall that has an inverse.

    Parameters
    ----------
    contact : Contact
    most_atoms : int
        Largest number of atoms in contact.
    """

    def __init__(self, contact: Contact, most_atoms: int) -> None:
        self._contact, self._most = contact, most_atoms

    def suits(self, pressure: np.ndarray) -> bool:
        """Return whether dense matrices pay for the atoms that are under pressure."""
        atoms = int(np.count_nonzero(pressure))
        small = max(pressure.shape) <= _LONGEST_SIDE and 0 < atoms <= self._most
        return small and not self._contact.interaction.plastic

    def solve(
        self,
        pressure: np.ndarray,
        opening: np.ndarray,
        height: float,
        support: Support | None,
        tolerance: float,
    ) -> DenseState:
        """Solve the contact problem.

        Parameters
        ----------
        pressure, opening : ndarray, shape (n, m)
            Start, and the opening of the gap by it.
        height : float
            Height of the indenter; the initial one with a support.
        support : callable, optional
            By default the height is fixed.
        tolerance : float
            Error of pressures and of their sum that may be left. A gap of a hard wall
            counts as the pressure on its atom that would close it.

        Returns
        -------
        DenseState
            The last one. It has not converged if the steps do not suffice, too many
            atoms come into contact or the matrix is singular to rounding errors.
        """
        wall, halfspace = self._contact.interaction, self._contact.halfspace
        spring = total = 0.0
        for _ in range(_STEPS):
            undeformed = self._contact.heights + height
            gap = undeformed + opening
            near = gap < wall.cutoff
            near |= pressure != 0.0
            atoms = near.ravel().nonzero()[0]
            q = pressure.take(atoms)
            # with a hard wall only the tension of an atom decides that it leaves
            pushes = q if wall.hard else np.maximum(q, 0.0)
            contact_gap, p, stiffness = wall.inverse(pushes)
            overlap = contact_gap - gap.take(atoms)
            least = np.minimum(stiffness, 1.0 / halfspace.self_compliance)
            held = p + least * overlap > 0.0
            pushed = held * (p + (least if wall.hard else stiffness) * overlap)
            error = abs(pushed - q).max(initial=0.0)
            if support is not None:
                spring, total = support(height)
                error = max(error, abs(pushed.sum() - total))
            if error <= tolerance:
                return DenseState(pressure, opening, height, converged=True)
            atoms, softness = atoms[held], 1.0 / stiffness[held]
            right = np.ones((atoms.size, 2))
            right[:, 0] = contact_gap[held] + softness * p[held]
            right[:, 0] -= undeformed.take(atoms)
            solution = None
            if 0 < atoms.size <= self._most:
                solution = pressures(halfspace, atoms, softness, right)
            if solution is None:
                break
            q, response = solution.T
            if support is not None:
                rise = (q.sum() - total) / (response.sum() + spring)
                q = q - rise * response
                height += float(rise)
            pressure = np.zeros(pressure.shape)
            pressure.put(atoms, q)
            opening = -halfspace.displacement(pressure)
        return DenseState(pressure, opening, height, converged=False)


def pressures(
    halfspace: HalfSpace, atoms: np.ndarray, softness: np.ndarray, right: np.ndarray
) -> np.ndarray | None:
    """Solve ``(s + G) q = r`` for the pressures on some atoms of the window.

    Parameters
    ----------
    halfspace : HalfSpace
    atoms : ndarray of int, shape (k,)
        Indices of the atoms in the flat window.
    softness : ndarray, shape (k,)
        Negative entries come last (length/pressure).
    right : ndarray, shape (k, l)

    Returns
    -------
    ndarray, shape (k, l), or None
        None if the matrix is singular to rounding errors, or has fewer negative
        eigenvalues than there are negative entries of s: then the state is no minimum
        of the energy.
    """
    pairs, columns = halfspace.pair_compliance, halfspace.shape[1]
    # of a pair of atoms, at the difference of their places in this table
    places = atoms + (atoms // columns) * (columns - 1)
    matrix = pairs.take(np.subtract.outer(places + pairs.size // 2, places))
    matrix.reshape(-1)[:: atoms.size + 1] += softness
    return solve_positive(matrix, right, int(np.count_nonzero(softness < 0.0)))


def solve_positive(
    matrix: np.ndarray, right: np.ndarray, negative: int = 0
) -> np.ndarray | None:
    """Solve a symmetric, positive definite system, with the same bits on any threads.

    Cholesky decomposition by blocks that are too small for BLAS to start threads.

    Parameters
    ----------
    matrix : ndarray, shape (k, k)
        Overwritten.
    right : ndarray, shape (k, l)
    negative : int
        Number of the last rows whose Schur complement is negative definite instead.

    Returns
    -------
    ndarray, shape (k, l), or None
        None if the matrix is not as definite.
    """
    if negative == len(matrix):
        matrix, right, negative = -matrix, -right, 0
    if len(matrix) <= _SINGLE_THREAD and not negative:
        _, solution, info = dposv(matrix.T, right, lower=1, overwrite_a=1)
        return None if info else solution
    first = min(_SINGLE_THREAD, len(matrix) - negative)
    if not negative:
        first = min(first, len(matrix) // 2)
    factor, info = dpotrf(matrix[:first, :first].T, lower=1)
    if info:
        return None
    inverse = dtrtri(factor, lower=1)[0]
    rest, known = matrix[first:, first:], inverse @ right[:first]
    pieces = split(len(rest), _SINGLE_THREAD)
    couplings = [inverse @ matrix[:first, first:][:, piece] for piece in pieces]
    for i, a in zip(pieces, couplings, strict=True):
        for k, b in zip(pieces, couplings, strict=True):
            rest[i, k] -= dgemm(1.0, a.T, b.T, trans_b=1)  # a.T @ a may start threads
    missing = right[first:].copy()
    for i, a in zip(pieces, couplings, strict=True):
        missing[i] -= a.T @ known
    solution = solve_positive(rest, missing, negative)
    if solution is None:
        return None
    for i, a in zip(pieces, couplings, strict=True):
        known -= a @ solution[i]
    return np.concatenate((inverse.T @ known, solution))
