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

from ase_roughcontact._util.kernels import by_rows, combined, dot, largest, part_dot
from ase_roughcontact.elasticity.circulant import CirculantModel
from ase_roughcontact.elasticity.lattice import Box

# Part of what a change of height alone leaves that is worth less than single precision.
_LEAST = 0.01


class System:
    """Newton's system at a state, its rows scaled as in the module's equation.

    Outside, changes of the pressure are flat arrays over a box of atoms, and the change
    of height is their last number. Inside, they are the same over the box of the model,
    of its precision and in its units.

    Parameters
    ----------
    model : CirculantModel
        Of the half space.
    box : Box
        The atoms; the box of the model holds it.
    stiffness : ndarray, shape of the box
        Of the wall (pressure per length).
    """

    def __init__(
        self,
        model: CirculantModel,
        box: Box,
        stiffness: np.ndarray,
    ) -> None:
        self._model, self._stiffness = model, stiffness
        self._where = box.slices_in(model.box)
        self._d, self._weight, self._stiff = (self._field() for _ in range(3))
        d, weight, stiff = self._d, self._weight, self._stiff
        self._fill(d, stiffness, model.local)

        def prepare(part: slice) -> tuple[float, float]:
            np.greater(d[part], 0.0, out=stiff[part])
            held = d[part] * stiff[part]
            weight[part] = 1.0 / np.sqrt(1.0 + held)
            return float(stiff[part].sum()), part_dot(held * weight[part], weight[part])

        count, series = np.sum(by_rows(prepare, d.shape), axis=0).tolist()
        self._relief = model.relief(series / count) if count else None

    def rows(self, pressure: np.ndarray) -> np.ndarray:
        """Scale pressures over the box as the rows of the equations are, and flatten.

        Parameters
        ----------
        pressure : ndarray, shape of the box

        Returns
        -------
        ndarray, shape (k,)
        """
        scaled = np.empty(pressure.shape)

        def scale(rows: slice) -> None:
            self._scale(pressure[rows], rows, scaled[rows])

        by_rows(scale, scaled.shape)
        return scaled.reshape(-1)

    def solve(
        self,
        right: np.ndarray,
        row: tuple[float, float] | None,
        reduction: float,
        most: int,
    ) -> np.ndarray | None:
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
        ndarray, shape (k + 1,)
            Changes ``x`` of pressure and ``z`` of height; None if neither wall nor
            spring resist a change of height.
        """
        spring, missing = row or (0.0, 0.0)
        unit = max(largest(right), abs(missing) / right.size) or 1.0
        spring, missing = spring * self._model.local, missing / unit
        response, resistance = self._response(row is not None)
        resistance += spring
        if row and not resistance > 0.0:
            return None

        def carry(change: np.ndarray, missing: float) -> np.ndarray:
            """Move the indenter until the load that is missing is all."""
            x = change[:-1]
            z = 0.0
            if row:
                total = sum(by_rows(lambda part: float(x[part].sum()), x.shape))
                z = (total - missing) / resistance
                combined([(1.0, x), (-z, response)], out=x)
            change[-1] = z
            return change

        def precondition(rest: np.ndarray) -> np.ndarray:
            change = self._change()
            self._relieve(rest, change[:-1])
            return carry(change, 0.0)

        solution = self._change()
        solution[:] = 0.0
        rest = self._field()
        self._fill(rest, right.reshape(self._stiffness.shape), 1.0 / unit)
        full = norm(rest)
        if missing:
            carry(solution, missing)
            combined([(1.0, rest), (-1.0, self._image(solution))], out=rest)
        solution += residuals(
            self._image,
            precondition,
            rest,
            reduction * max(full, _LEAST * norm(rest)),
            most,
        )
        change = np.empty(right.size + 1)
        x = solution[:-1].reshape(self._model.box.shape)[self._where]
        np.multiply(x, unit, out=change[:-1].reshape(x.shape))
        change[-1] = float(solution[-1]) * unit * self._model.local
        return change

    def image(self, change: np.ndarray, depth: np.ndarray) -> np.ndarray:
        """Rows of the equations for ``(x, z)``, given the depth of the atoms.

        Parameters
        ----------
        change : ndarray, shape (k + 1,)
        depth : ndarray, shape of the box

        Returns
        -------
        ndarray, shape (k,)
        """
        image, x = np.empty(depth.shape), change[:-1].reshape(depth.shape)

        def scale(rows: slice) -> None:
            part = np.add(depth[rows], change[-1], out=image[rows])
            part *= self._stiffness[rows]
            part += x[rows]
            self._scale(part, rows, part)

        by_rows(scale, image.shape)
        return image.reshape(-1)

    def _scale(self, values: np.ndarray, rows: slice, out: np.ndarray) -> None:
        """Scale some rows of the box."""
        soft = np.maximum(self._stiffness[rows], 0.0)
        soft *= self._model.local
        soft += 1.0
        np.divide(values, np.sqrt(soft, out=soft), out=out)

    def _image(self, change: np.ndarray) -> np.ndarray:
        """Rows of the equations by the model, flat and in its units."""
        x, z, shape = change[:-1], change[-1], self._model.box.shape
        image = self._field()
        self._model.compliance(x.reshape(shape), image.reshape(shape))

        def complete(part: slice) -> None:
            some = image[part]
            some += z
            some *= self._d[part]
            some += x[part]
            some *= self._weight[part]

        by_rows(complete, image.shape)
        return image

    def _change(self) -> np.ndarray:
        """Array for the pressures in the box of the model and the height."""
        return np.empty(self._model.box.size + 1, self._model.dtype)

    def _field(self) -> np.ndarray:
        """Array over the box of the model, flat."""
        return self._change()[:-1]  # of one size for all

    def _fill(self, field: np.ndarray, values: np.ndarray, factor: float) -> None:
        """Set a field to values in the box times a factor, and zero elsewhere."""
        field[:] = 0.0
        inside = field.reshape(self._model.box.shape)[self._where]

        def fill(rows: slice) -> None:
            np.multiply(values[rows], factor, out=inside[rows], casting="same_kind")

        by_rows(fill, values.shape)

    def _response(self, free: bool) -> tuple[np.ndarray, float]:
        """Pressures by which the wall resists a change of height, and their sum."""
        response = self._field()
        if not free:
            return response, 0.0
        self._relieve(self._d * self._weight, response)
        return response, float(response.sum())

    def _relieve(self, rows: np.ndarray, out: np.ndarray) -> None:
        """Apply the approximate inverse; atoms without stiffness stay as they are.

        ``1 + D C = (1 + D) (1 + S (C - 1))``, where ``S = D/(1 + D)``, wall and atom in
        series, varies much less than ``D``: it is taken for its mean.
        """
        if self._relief is None:
            out[:] = rows
            return
        weight, stiff = self._weight, self._stiff

        def enter(part: slice) -> None:
            np.multiply(rows[part], weight[part], out=out[part])
            out[part] *= stiff[part]

        def leave(part: slice) -> None:
            out[part] *= stiff[part]
            out[part] += rows[part] * (1.0 - stiff[part])

        by_rows(enter, out.shape)
        field = out.reshape(self._model.box.shape)
        self._model.relieve(field, self._relief, field)
        by_rows(leave, out.shape)


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
        Linear map of changes to what they take off the rest: new arrays, which are
        overwritten here.
    precondition : callable
        Approximate inverse of it.
    rest : ndarray
        What is to be removed; overwritten.
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
    changes: list[np.ndarray] = []
    images: list[np.ndarray] = []  # made orthonormal
    triangle, steps = np.zeros((most, most)), np.zeros(most)
    left = norm(rest)
    while left > stop and len(changes) < most:
        k = len(changes)
        change = precondition(rest)
        new = image(change)
        others = [*images, new]
        overlap = dot(new, others[0])
        for i, old in enumerate(images):
            triangle[i, k] = overlap
            overlap = _taken_off(new, overlap, old, others[i + 1])
        size = triangle[k, k] = overlap**0.5
        if not size > 0.0:
            break
        combined([(1.0 / size, new)], out=new)
        steps[k] = dot(new, rest)
        left = _taken_off(rest, float(steps[k]), new, rest) ** 0.5
        changes.append(change)
        images.append(new)
    if not changes:
        return 0.0
    k = len(changes)
    weights = solve_triangular(triangle[:k, :k], steps[:k]).tolist()
    return combined(list(zip(weights, changes, strict=True)))


def _taken_off(
    values: np.ndarray, factor: float, other: np.ndarray, third: np.ndarray
) -> float:
    """Take a multiple of another array off, then return the product with a third."""

    def take(rows: slice) -> float:
        part = values[rows]
        part -= factor * other[rows]
        return part_dot(part, third[rows])

    return sum(by_rows(take, values.shape))


def norm(values: np.ndarray) -> float:
    """Euclidean norm without BLAS."""
    return dot(values, values) ** 0.5
