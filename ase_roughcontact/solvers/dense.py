r"""Contact of few atoms with a repulsive wall, by dense matrices.

With the gap :math:`w(q)` at which the wall has the pressure :math:`q`,
:math:`w(q) = Z + h + G q` for the atoms in contact, and :math:`q = 0` elsewhere.
A step of the semismooth Newton method linearises the wall at the pressure :math:`q_0`
and the height :math:`Z_0` and solves

.. math:: (D^{-1} + G) q + Z = w + D^{-1} p - h, \qquad \sum q - s (Z - Z_0) = L

for the pressures in contact and the height, with the exact compliance :math:`G` between
pairs of atoms, pressure :math:`p` and stiffness :math:`D` of the wall at the gap
:math:`w(q_0)`, the stiffness :math:`s` of springs on the indenter per area of an atom
and the required sum :math:`L` of the pressures. The matrix is symmetric and positive
definite. A convolution gives the gaps :math:`g` of all atoms.

In contact are the atoms with :math:`p + \min(D, 1/c) (w - g) > 0`, where :math:`c` is
the self-compliance.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dposv

from ase_roughcontact.contact import Contact
from ase_roughcontact.elasticity.halfspace import HalfSpace

#: Size of matrices up to which no version of OpenBLAS starts threads: they would change
#: the rounding of the result.
SINGLE_THREAD = 63
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
        return max(pressure.shape) <= _LONGEST_SIDE and 0 < atoms <= self._most

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
            Error of pressures and of their sum that may be left.

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
            contact_gap, p, stiffness = wall.inverse(np.maximum(q, 0.0))
            overlap = contact_gap - gap.take(atoms)
            least = np.minimum(stiffness, 1.0 / halfspace.self_compliance)
            held = p + least * overlap > 0.0
            pushed = held * (p + stiffness * overlap)
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


def compliance_matrix(
    halfspace: HalfSpace, atoms: np.ndarray, softness: np.ndarray
) -> np.ndarray:
    """Return ``s + G`` of some atoms of the window, shape (k, k); see `pressures`."""
    pairs, columns = halfspace.pair_compliance, halfspace.shape[1]
    # of a pair of atoms, at the difference of their places in this table
    places = atoms + (atoms // columns) * (columns - 1)
    matrix = pairs.take(np.subtract.outer(places + pairs.size // 2, places))
    matrix.reshape(-1)[:: atoms.size + 1] += softness
    return matrix


def pressures(
    halfspace: HalfSpace, atoms: np.ndarray, softness: np.ndarray, right: np.ndarray
) -> np.ndarray | None:
    """Solve ``(s + G) q = r`` for the pressures on some atoms of the window.

    Parameters
    ----------
    halfspace : HalfSpace
    atoms : ndarray, shape (k,)
        Flat indices of the atoms.
    softness : ndarray, shape (k,)
        ``s`` at least zero; zero with a hard wall (length per pressure).
    right : ndarray, shape (k, m)

    Returns
    -------
    ndarray, shape (k, m), or None
        None if the matrix is singular to rounding errors.
    """
    matrix = compliance_matrix(halfspace, atoms, softness)
    _, solution, info = dposv(matrix.T, right, lower=1, overwrite_a=1)
    return None if info else solution
