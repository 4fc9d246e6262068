r"""Nearly full contact of a periodic surface with a hard wall, by its few open atoms.

With the stiffness :math:`K = G^{-1}`, which has no mean, a gap :math:`g` changes the
pressure of a full contact, :math:`p_f = L/A - K h`, to :math:`p = p_f + K g`, which
carries the same load. The contact is the solution of

.. math:: g \ge 0, \qquad p_f + K g \ge 0, \qquad g (p_f + K g) = 0.

The unknowns are the gaps of the set :math:`O` of open atoms, at first of those under
tension. Repeat

1. *Solve* :math:`p_f + K g = 0` in :math:`O` by conjugate gradients, until 40 % of the
   largest pressure or tension is left.
2. *Exchange*: atoms with a negative gap leave :math:`O`, atoms under tension enter it.
   If none does, continue with 1,

until the set does not change and the pressure is small enough. A step costs one pair of
transforms, that of `active_set` two: a few open atoms need no preconditioner.
"""

from __future__ import annotations

import numpy as np

from ase_roughcontact._util.kernels import dot, least, linear_combination, max_abs
from ase_roughcontact.elasticity.halfspace import HalfSpace
from ase_roughcontact.solvers.options import ActiveSetOptions


def nearly_full_contact(
    halfspace: HalfSpace,
    heights: np.ndarray,
    mean_pressure: float,
    tolerance: float,
    options: ActiveSetOptions,
) -> tuple[np.ndarray | None, int]:
    """Return the pressure of a nearly full contact under a load.

    Parameters
    ----------
    halfspace : HalfSpace
        A periodic one.
    heights : ndarray, shape (n, m)
        Lower surface of the indenter (length).
    mean_pressure : float
        Load over the area of the window.
    tolerance : float
        Pressure or tension that may be left on open atoms.
    options : ActiveSetOptions

    Returns
    -------
    pressure : ndarray, shape (n, m), or None
        Nonnegative; that of the last step if the steps do not suffice. None if the
        pressure of the full contact is positive on too few atoms; see
        `ActiveSetOptions`.
    pairs : int
        Pairs of transforms.
    """
    problem = _OpenAtoms(halfspace, heights, mean_pressure, tolerance)
    if problem.count > (1.0 - options.full_contact) * heights.size:
        return None, problem.pairs
    forcing, steps = options.forcing, options.inner_steps
    for update in range(steps):
        if update >= options.loose_updates:  # so that the set cannot cycle
            forcing *= 0.5
        if not problem.solve(forcing, steps):
            break
    return problem.result(), problem.pairs


class _OpenAtoms:
    """Open atoms, their gaps and the pressure on all atoms."""

    def __init__(
        self,
        halfspace: HalfSpace,
        heights: np.ndarray,
        mean_pressure: float,
        tolerance: float,
    ) -> None:
        self._tolerance = tolerance
        self._transform = halfspace.dof_transform
        self._stiffness = self._transform.multiplier(halfspace.stiffness)
        self._gap = np.zeros(heights.size)
        self._field = np.empty(heights.shape, self._transform.dtype)
        full = self._transform.filter(heights - heights.mean(), self._stiffness)
        self._pressure = np.subtract(mean_pressure, full, dtype=float)
        self._open = np.flatnonzero(self._pressure < 0.0)
        self.pairs = 1

    @property
    def count(self) -> int:
        """Number of open atoms."""
        return self._open.size

    def solve(self, forcing: float, steps: int) -> bool:
        """Release the open atoms until their set changes; return whether it does.

        By conjugate gradients, until `steps` pairs of transforms have been made.
        """
        if not self.count:
            return self._exchange()
        residual = -self._pressure.take(self._open)
        direction, square = residual, dot(residual, residual)
        largest = max(max_abs(residual), -least(self._pressure))
        stage = max(self._tolerance, forcing * largest)
        while self.pairs < steps:
            largest = max_abs(residual)
            if largest <= stage:
                if self._exchange():
                    return True
                if largest <= self._tolerance:
                    return False
                stage = max(self._tolerance, forcing * largest)
            change = self._change(self._open, direction)
            length = square / dot(direction, change.take(self._open))
            self._gap[self._open] += length * direction
            self._add(length, change)
            residual = -self._pressure.take(self._open)
            last, square = square, dot(residual, residual)
            direction = residual + (square / last) * direction
        return False

    def result(self) -> np.ndarray:
        """Return the pressure without tension, zero on open atoms."""
        pressure = np.maximum(self._pressure, 0.0)
        pressure.put(self._open, 0.0)
        return pressure

    def _exchange(self) -> bool:
        """Close atoms with a negative gap, open those under tension; return if any."""
        gap = self._gap[self._open]
        stays = gap > 0.0
        is_open = self._pressure < -self._tolerance
        is_open.put(self._open, stays)
        now_open = np.flatnonzero(is_open)
        if np.array_equal(now_open, self._open):
            return False
        closing = self._open[~stays]
        if closing.size:
            self._add(1.0, self._change(closing, -gap[~stays]))
            self._gap[closing] = 0.0
        self._open = now_open
        return True

    def _change(self, atoms: np.ndarray, gap: np.ndarray) -> np.ndarray:
        """Return the change ``K g`` of the pressure due to gaps of some atoms."""
        self.pairs += 1
        self._field[:] = 0.0
        self._field.put(atoms, gap)
        return self._transform.filter(self._field, self._stiffness, self._field)

    def _add(self, factor: float, change: np.ndarray) -> None:
        terms = [(1.0, self._pressure), (factor, change)]
        linear_combination(terms, out=self._pressure)
