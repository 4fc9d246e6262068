r"""The contact problem of a hard wall with a cheap model of the half space.

From a pressure :math:`p` with the exact gap :math:`g`, find the change :math:`x` with

.. math:: p + x \ge 0, \qquad g + C x + z \ge 0,

one of the two zero at every atom, where :math:`C` is the model, and :math:`z`, a change
of the indenter's height, is zero unless the load is to be kept.

*Inexact active set*: with the present set of atoms in contact the linear system is
solved by conjugate gradients, preconditioned by the model's inverse, to a tenth of the
violation only; then atoms under tension leave and atoms that overlap enter.

All fields are arrays over the model's box, of its precision, in units of the violation:
without lists of atoms a step costs little more than its transforms. It is the change of
the pressure that is carried along, so that single precision does not round the rest.

References
----------
M. Hintermüller, K. Ito, K. Kunisch, SIAM J. Optim. 13, 865 (2002) (active set);
I. A. Polonsky, L. M. Keer, Wear 231, 206 (1999); E. A. H. Vollebregt, J. Comput. Phys.
257, 332 (2014) (preconditioner).
"""

from __future__ import annotations

import math

import numpy as np

from ase_roughcontact.optimize.models import Circulant, Matrix
from ase_roughcontact.optimize.problem import dot

# Part of a violation that the linear systems may leave before the set of atoms in
# contact is looked at again.
_FORCING = 0.1
# Steps of conjugate gradients for one correction.
_BUDGET = 300
# Gap that no atom has, in units of the violation.
_NEVER = 1e30


class ActiveSet:
    """The correction of a pressure, as far as it has come.

    Parameters
    ----------
    model : Circulant or Matrix
        Of the half space; its box holds all atoms under pressure.
    pressure : ndarray, shape (n, m)
        On the window, nowhere negative (pressure).
    gap : ndarray, shape (n, m)
        Of this pressure, exactly (length).
    unit : float
        Size of the violation (length).
    loaded : bool
        Whether the load is to be kept.
    """

    def __init__(
        self,
        model: Circulant | Matrix,
        pressure: np.ndarray,
        gap: np.ndarray,
        unit: float,
        loaded: bool,
    ) -> None:
        box = model.box.slices
        self._model, self._loaded = model, loaded
        self._old, self._unit = pressure, unit / model.local
        self._pressure = _field(pressure[box], self._unit, model)
        self._gap = _field(gap[box], unit, model)
        self._change = np.zeros_like(self._pressure)
        self._touching = self._pressure > self._gap
        self._shift = 0.0
        self._budget = _BUDGET
        # nothing holds the mean of a periodic surface of which all atoms are looked at
        self._floating = model.exact and isinstance(model, Circulant) and not loaded

    def solve(self, target: float) -> np.ndarray:
        """Pressure on the window, to a part of the violation or as far as it gets."""
        while True:
            self._budget -= 1
            self._let_go()
            self._clip()
            self._equilibrate(target)
            leave = self._touching & (self._pressure + self._change < 0.0)
            enter = ~self._touching & (self._gap < -target - self._shift)
            self._touching &= ~leave
            if self._budget <= 0 or not (leave.any() or enter.any()):
                return self._result()
            self._touching |= enter

    def _result(self) -> np.ndarray:
        """Pressure on the window at the end; under a load the same total."""
        change = self._clipped()
        kept = self._pressure + change > 0.0
        new = np.zeros(self._old.shape)
        box = self._model.box.slices
        new[box] = (self._old[box] + self._unit * change).clip(0.0) * kept
        if self._loaded:
            new *= self._old.sum() / new.sum()
        return new

    def _let_go(self) -> None:
        """Open an atom of a periodic surface in full contact: nothing holds it."""
        if self._floating and self._touching.all():
            total = self._pressure + self._change
            self._change -= total.min()
            self._touching[total <= total.min()] = False

    def _clipped(self) -> np.ndarray:
        """Change to a pressure in contact alone and without tension."""
        touching = self._touching.astype(self._change.dtype)
        change = np.maximum(self._change, -self._pressure)
        change *= touching
        change -= (1.0 - touching) * self._pressure
        if self._loaded:
            total = self._pressure + change
            change -= (float(change.sum()) / float(total.sum())) * total
        return change

    def _clip(self) -> None:
        """Clip the pressure, and let the gap follow."""
        clipped = self._clipped()
        moved = clipped - self._change
        if moved.any():
            self._gap += self._model.compliance(moved)
            self._change = clipped

    def _equilibrate(self, target: float) -> None:
        """Close the gap of the atoms in contact by conjugate gradients.

        They end at a tenth of the first violation, at the target or with the budget.
        Under a load their directions carry none.
        """
        touching = self._touching.astype(self._gap.dtype)
        count = int(np.count_nonzero(self._touching))
        if not count:
            return
        residual = self._residual(touching, count)
        overlap = -float((self._gap + _NEVER * touching).min()) - self._shift
        target = max(target, _FORCING * max(_largest(residual), overlap))
        direction = np.zeros_like(residual)
        last, last_work = residual, math.inf
        while _largest(residual) > target and self._budget > 0:
            z = self._model.stiffness(residual)
            if self._loaded:
                z -= dot(z, touching) / count
            z *= touching
            work = dot(z, residual)
            # Polak-Ribiere, restarted when it turns negative
            direction *= max(0.0, (work - dot(z, last)) / last_work)
            direction += z
            last, last_work = residual, work
            sunk = self._model.compliance(direction)
            length = dot(direction, residual) / dot(direction, sunk)
            self._change += length * direction
            self._gap += length * sunk
            residual = self._residual(touching, count)
            self._budget -= 1

    def _residual(self, touching: np.ndarray, count: int) -> np.ndarray:
        """Overlap in contact; under a load without its mean, which is a shift."""
        if self._loaded:
            self._shift = -dot(self._gap, touching) / count
        return -(self._gap + self._shift) * touching


def _field(values: np.ndarray, unit: float, model: Circulant | Matrix) -> np.ndarray:
    """Values in a unit, of the model's precision."""
    return (values * (1.0 / unit)).astype(model.dtype)


def _largest(values: np.ndarray) -> float:
    """Largest magnitude."""
    return max(float(values.max()), -float(values.min()))
