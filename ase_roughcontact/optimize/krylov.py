r"""Newton's linear system of a soft wall, solved with a cheap model of the half space.

On the atoms in range of the wall, with its stiffness :math:`D`, a change ``x`` of the
pressure and ``z`` of the indenter's height solve

.. math:: x + D (C x + z) = r, \qquad \sum x - s z = t,

the second equation, with the stiffness ``s`` of a spring on the indenter per area, only
where the height is free. :math:`C` is the `Circulant`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ase_roughcontact.condensed import ScatteredHalfSpace
from ase_roughcontact.halfspace import HalfSpace
from ase_roughcontact.optimize.circulant import Circulant
from ase_roughcontact.optimize.matrix import Matrix
from ase_roughcontact.optimize.problem import dot


class Patch(Circulant):
    """Model of the half space for lists of atoms that change from step to step.

    Parameters
    ----------
    halfspace : HalfSpace
        The elastic solid.
    atoms : ndarray of int, shape (k,)
        Flat indices of the atoms of the window that are to lie in the box.
    """

    def __init__(self, halfspace: HalfSpace, atoms: np.ndarray) -> None:
        self._columns = halfspace.shape[1]
        first, last = [0, 0], [n - 1 for n in halfspace.shape]
        if not halfspace.periodic:
            for axis, place in enumerate(np.divmod(atoms, self._columns)):
                first[axis], last[axis] = int(place.min()), int(place.max())
        self._first, self._last = first, last
        corners = [i * self._columns + j for i, j in (first, last)]
        super().__init__(halfspace, np.array(corners))

    def covers(self, atoms: np.ndarray) -> bool:
        """Whether all atoms lie in the box."""
        places = np.divmod(atoms, self._columns)
        return all(
            place.min() >= first and place.max() <= last
            for place, first, last in zip(places, self._first, self._last, strict=True)
        )

    def places(self, atoms: np.ndarray) -> np.ndarray:
        """Return the atoms of the box as `depth` and `relieve` want them."""
        i, j = np.divmod(atoms, self._columns)
        width = self._last[1] - self._first[1] + 1
        return (i - self._first[0]) * width + j - self._first[1]

    def depth(self, pressure: np.ndarray, where: np.ndarray) -> np.ndarray:
        """Depth of atoms of the box under pressure on them, ``C x``."""
        units = self.modulus, self.local
        return self._convolve(pressure, where, self._compliance, where, units)

    def relief(self, stiffness: float, local: float) -> np.ndarray:
        """Multiplier of ``1/(1 + k (C - c))``: one stiffness on the whole box."""
        # the multipliers hold the norm of the transform
        symbol = self.points * self._compliance - np.float32(1.0)
        return 1.0 / (self.points * (1.0 + np.float32(stiffness * local) * symbol))

    def relieve(
        self, pressure: np.ndarray, where: np.ndarray, relief: np.ndarray
    ) -> np.ndarray:
        """Pressure that is left on atoms of the box when `relief` is applied."""
        units = self.modulus, 1.0
        return self._convolve(pressure, where, relief, where, units)


def patch_of(halfspace: HalfSpace, atoms: np.ndarray) -> Patch | Matrix:
    """Cheap model of the half space for lists of atoms that change; see `Patch`."""
    if isinstance(halfspace, ScatteredHalfSpace):
        return Matrix(halfspace, atoms)
    return Patch(halfspace, atoms)


class System:
    """Newton's system at a state, its rows scaled as in the module's equation.

    Parameters
    ----------
    patch : Patch or Matrix
        Model of the half space.
    atoms : ndarray of int, shape (k,)
        Flat indices into the window; the patch covers them.
    stiffness : ndarray, shape (k,)
        Of the wall at these atoms (pressure per length).
    """

    def __init__(
        self, patch: Patch | Matrix, atoms: np.ndarray, stiffness: np.ndarray
    ) -> None:
        self._patch, self._where, self._d = patch, patch.places(atoms), stiffness
        self._stiff = np.flatnonzero(stiffness > 0.0)
        if self._stiff.size:
            self._soft = 1.0 + patch.local * stiffness[self._stiff]
            series = stiffness[self._stiff] / self._soft
            self._relief: Any = patch.relief(float(series.mean()), patch.local)

    def solve(
        self,
        right: np.ndarray,
        row: tuple[float, float] | None,
        reduction: float,
        most: int,
    ) -> tuple[np.ndarray, float] | None:
        """Solve by preconditioned generalised conjugate residuals.

        Parameters
        ----------
        right : ndarray, shape (k,)
            The pressures ``r`` that are missing (pressure).
        row : (float, float), optional
            Spring ``s`` and load ``t`` that is missing; by default the height is fixed.
        reduction : float
            Part of `right` that may be left.
        most : int
            Steps at most.

        Returns
        -------
        ndarray, shape (k,), and float
            Changes ``x`` of pressure and ``z`` of height; None if neither wall nor
            spring resist a change of height.
        """
        response, spring, missing = np.zeros(0), 0.0, 0.0
        if row is not None:
            spring, missing = row
            response = self._relieve(self._d)
            if not response.sum() + spring > 0.0:
                return None

        def carried(x: np.ndarray, missing: float) -> np.ndarray:
            if row is None:
                return np.append(x, 0.0)
            z = (x.sum() - missing) / (response.sum() + spring)
            return np.append(x - z * response, z)

        solution, rest = np.zeros(right.size + 1), right
        if missing:
            solution = carried(0.0 * right, missing)
            rest = right - self._image(solution)
        solution += residuals(
            self._image,
            lambda rest: carried(self._relieve(rest), 0.0),
            rest,
            reduction * (norm(right) or norm(rest)),
            most,
        )
        return solution[:-1], float(solution[-1])

    def image(self, change: np.ndarray, depth: np.ndarray) -> np.ndarray:
        """Left side of the equations for ``(x, z)``, given the depth of the atoms."""
        return change[:-1] + self._d * (depth + change[-1])

    def _image(self, change: np.ndarray) -> np.ndarray:
        return self.image(change, self._patch.depth(change[:-1], self._where))

    def _relieve(self, x: np.ndarray) -> np.ndarray:
        """Apply the approximate inverse; atoms without stiffness stay as they are.

        With the compliance ``c`` of one atom alone,
        ``1 + D C = (1 + c D) (1 + S (C - c))``, where ``S = D/(1 + c D)``, wall and
        atom in series, varies much less than ``D``: it is taken for its mean.
        """
        y = x.copy()
        if self._stiff.size:
            where = self._where[self._stiff]
            scaled = x[self._stiff] / self._soft
            y[self._stiff] = self._patch.relieve(scaled, where, self._relief)
        return y


def residuals(
    image: Callable[[np.ndarray], np.ndarray],
    precondition: Callable[[np.ndarray], np.ndarray],
    rest: np.ndarray,
    stop: float,
    most: int,
) -> np.ndarray:
    """Change that makes the rest smaller than `stop`, or as small as it gets.

    Generalised conjugate residuals; the preconditioner may vary.

    Parameters
    ----------
    image : callable
        Linear map of changes to what they take off the rest.
    precondition : callable
        Approximate inverse of it.
    rest : ndarray
        What is to be removed.
    stop : float
        Norm of the rest at which to stop.
    most : int
        Steps at most.

    Returns
    -------
    ndarray
        The change.

    References
    ----------
    S. C. Eisenstat, H. C. Elman, M. H. Schultz, SIAM J. Numer. Anal. 20, 345 (1983).
    """
    found: np.ndarray | float = 0.0
    tried: list[tuple[np.ndarray, np.ndarray]] = []
    while norm(rest) > stop and len(tried) < most:
        change = precondition(rest)
        new = image(change)
        for old_change, old in tried:
            overlap = dot(old, new)
            new -= overlap * old
            change -= overlap * old_change
        size = norm(new)
        if not size > 0.0:
            break
        tried.append((change / size, new / size))
        change, new = tried[-1]
        overlap = dot(new, rest)
        rest = rest - overlap * new
        found = found + overlap * change
    return np.asarray(found)


def norm(values: np.ndarray) -> float:
    """Euclidean norm without BLAS."""
    return dot(values, values) ** 0.5
