r"""Newton's linear system of a soft wall, solved with a cheap model of the half space.

On the atoms in range of the wall, with its stiffness :math:`D`, a change ``x`` of the
pressure and ``z`` of the indenter's height solve

.. math:: x + D (C x + z) = r, \qquad \sum x - s z = t,

the second equation, with the stiffness ``s`` of a spring on the indenter per area, only
where the height is free. :math:`C` is the model. Where the wall is stiff the rows are
divided by :math:`\sqrt{1 + c D}`, with the compliance ``c`` of one atom alone, so that
the size of what is left tells its energy: an atom deep in the wall's core may miss a
pressure a thousand times that of all others, and still be put right by a movement as
small as theirs. With plain rows 12 of 180 cold starts under strong adhesion (w/E* of
0.02 to 0.2 a0) stalled, with these none; rows divided by :math:`1 + c D` took up to
three times the steps for walls a thousand times as stiff as the bulk.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.linalg import solve_triangular

from ase_roughcontact.optimize.models import Circulant, Matrix
from ase_roughcontact.optimize.problem import dot

# Part of what a change of height alone leaves that is worth less than single precision.
_LEAST = 0.01


class System:
    """Newton's system at a state, its rows scaled as in the module's equation.

    Outside, pressures are lists with one number for each atom. Inside, they are fields
    over the box of the model, of its precision and in its units: without lists, a step
    costs little more than its transforms.

    Parameters
    ----------
    model : Circulant or Matrix
        Of the half space.
    shape : (int, int)
        Of the window.
    atoms : ndarray of int, shape (k,)
        Flat indices into the window; the box of the model holds them.
    stiffness : ndarray, shape (k,)
        Of the wall at these atoms (pressure per length).
    """

    def __init__(
        self,
        model: Circulant | Matrix,
        shape: tuple[int, int],
        atoms: np.ndarray,
        stiffness: np.ndarray,
    ) -> None:
        self._model, self._stiffness = model, stiffness
        self._scale = 1.0 / np.sqrt(1.0 + model.local * np.maximum(stiffness, 0.0))
        i, j = np.unravel_index(atoms, shape)
        (first, left), (_, columns) = model.box.start, model.box.shape
        self._where = (i - first) * columns + j - left
        self._d = d = self._field(model.local * stiffness)
        self._stiff = (d > 0.0).astype(d.dtype)
        self._open = 1.0 - self._stiff
        self._weight = 1.0 / np.sqrt(1.0 + d * self._stiff)
        count = float(self._stiff.sum())
        self._relief: np.ndarray | None = None
        if count:
            self._relief = model.relief(dot(d * self._stiff, self._weight**2) / count)

    def rows(self, pressure: np.ndarray) -> np.ndarray:
        """Scale pressures at the atoms as the rows of the equations are."""
        return self._scale * pressure

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
            The rows of the pressures ``r`` that are missing (pressure).
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
        spring, missing = row or (0.0, 0.0)
        unit = max(float(abs(right).max()), abs(missing) / right.size) or 1.0
        spring, missing = spring * self._model.local, missing / unit
        response = (
            self._relieve(self._d * self._weight) if row else np.zeros_like(self._d)
        )
        resistance = float(response.sum()) + spring
        if row and not resistance > 0.0:
            return None

        def carried(x: np.ndarray, missing: float) -> np.ndarray:
            z = (float(x.sum()) - missing) / resistance if row else 0.0
            change = np.empty(x.size + 1, x.dtype)
            np.multiply(response.reshape(-1), -z, out=change[:-1])
            change[:-1] += x.reshape(-1)
            change[-1] = z
            return change

        solution = np.zeros(self._d.size + 1, self._d.dtype)
        rest = full = self._field(right * (1.0 / unit)).reshape(-1)
        if missing:
            solution = carried(np.zeros_like(self._d), missing)
            rest = full - self._image(solution)
        solution += residuals(
            self._image,
            lambda rest: carried(self._relieve(rest.reshape(self._d.shape)), 0.0),
            rest,
            reduction * max(norm(full), _LEAST * norm(rest)),
            most,
        )
        change = np.multiply(solution[self._where], unit, dtype=float)
        return change, float(solution[-1]) * unit * self._model.local

    def image(self, change: np.ndarray, depth: np.ndarray) -> np.ndarray:
        """Rows of the equations for ``(x, z)``, given the depth of the atoms."""
        return self.rows(change[:-1] + self._stiffness * (depth + change[-1]))

    def _image(self, change: np.ndarray) -> np.ndarray:
        """Rows of the equations by the model, flat fields in its units."""
        x = change[:-1].reshape(self._d.shape)
        image = self._model.compliance(x)
        image += change[-1]
        image *= self._d
        image += x
        image *= self._weight
        return image.reshape(-1)

    def _field(self, values: np.ndarray) -> np.ndarray:
        """Field over the box of the values at the atoms."""
        field = np.zeros(self._model.box.shape, self._model.dtype)
        field.reshape(-1)[self._where] = values
        return field

    def _relieve(self, rows: np.ndarray) -> np.ndarray:
        """Apply the approximate inverse; atoms without stiffness stay as they are.

        ``1 + D C = (1 + D) (1 + S (C - 1))``, where ``S = D/(1 + D)``, wall and atom in
        series, varies much less than ``D``: it is taken for its mean.
        """
        if self._relief is None:
            return rows.copy()
        x = self._model.relieve(rows * self._weight * self._stiff, self._relief)
        x *= self._stiff
        x += rows * self._open
        return x


def residuals(
    image: Callable[[np.ndarray], np.ndarray],
    precondition: Callable[[np.ndarray], np.ndarray],
    rest: np.ndarray,
    stop: float,
    most: int,
) -> np.ndarray | float:
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
    ndarray or float
        The change; 0.0 if there is none.

    References
    ----------
    S. C. Eisenstat, H. C. Elman, M. H. Schultz, SIAM J. Numer. Anal. 20, 345 (1983).
    """
    rest = rest.copy()
    changes: list[np.ndarray] = []
    images: list[np.ndarray] = []  # made orthonormal
    triangle, parts = np.zeros((most, most)), np.zeros(most)
    while norm(rest) > stop and len(changes) < most:
        k = len(changes)
        change = precondition(rest)
        new = image(change)
        for i, old in enumerate(images):
            overlap = triangle[i, k] = dot(old, new)
            new -= overlap * old
        size = triangle[k, k] = norm(new)
        if not size > 0.0:
            break
        new *= 1.0 / size
        overlap = parts[k] = dot(new, rest)
        rest -= overlap * new
        changes.append(change)
        images.append(new)
    if not changes:
        return 0.0
    k = len(changes)
    weights = solve_triangular(triangle[:k, :k], parts[:k]).tolist()
    found = weights[0] * changes[0]
    for weight, change in zip(weights[1:], changes[1:], strict=True):
        found += weight * change
    return found


def norm(values: np.ndarray) -> float:
    """Euclidean norm without BLAS."""
    return dot(values, values) ** 0.5
