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

from ase_roughcontact._util.kernels import by_rows, dot, dots
from ase_roughcontact.elasticity.circulant import CirculantModel

# Part of a violation that the linear systems may leave before the set of atoms in
# contact is looked at again.
_FORCING = 0.1
# Steps of conjugate gradients for one correction.
_BUDGET = 300


class ActiveSetSolver:
    """The correction of a pressure, as far as it has come.

    Parameters
    ----------
    model : CirculantModel
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
        model: CirculantModel,
        pressure: np.ndarray,
        gap: np.ndarray,
        unit: float,
        loaded: bool,
    ) -> None:
        self._model, self._loaded = model, loaded
        self._old, self._unit = pressure, unit / model.local
        self._pressure = self._field(pressure, self._unit)
        self._gap = self._field(gap, unit)
        self._touching: np.ndarray = (self._pressure > self._gap).astype(model.dtype)
        self._change = np.zeros(self._pressure.shape, model.dtype)
        # of the conjugate gradients
        self._residual, self._last, self._z, self._direction = (
            np.empty(self._pressure.shape, model.dtype) for _ in range(4)
        )
        self._shift = 0.0
        self._budget = _BUDGET
        # nothing holds the mean of a periodic surface of which all atoms are looked at
        self._floating = model.exact and not loaded

    def solve(self, target: float) -> np.ndarray:
        """Pressure on the window, to a part of the violation or as far as it gets."""
        while True:
            self._budget -= 1
            self._let_go()
            self._clip()
            self._equilibrate(target)
            if not self._exchanged(target) or self._budget <= 0:
                return self._result()

    def _field(self, values: np.ndarray, unit: float) -> np.ndarray:
        """Values on the box in a unit, of the model's precision."""
        box = self._model.box
        inside, field = values[box.slices], np.empty(box.shape, self._model.dtype)

        def fill(rows: slice) -> None:
            np.multiply(inside[rows], 1.0 / unit, out=field[rows], casting="same_kind")

        by_rows(fill, field.shape)
        return field

    def _result(self) -> np.ndarray:
        """Pressure on the window at the end; under a load the same total."""
        clipped = self._clipped()
        new = np.zeros(self._old.shape)
        inside, old = (values[self._model.box.slices] for values in (new, self._old))

        def put(rows: slice) -> float:
            change = clipped[rows]
            result = old[rows] + self._unit * change
            result *= result > 0.0
            result *= self._pressure[rows] + change > 0.0
            inside[rows] = result
            return float(result.sum())

        total = sum(by_rows(put, inside.shape))
        if self._loaded:
            new *= self._old.sum() / total
        return new

    def _let_go(self) -> None:
        """Open an atom of a periodic surface in full contact: nothing holds it."""
        if self._floating and self._touching.all():
            total = self._pressure + self._change
            self._change -= total.min()
            self._touching[total <= total.min()] = 0.0

    def _exchanged(self, target: float) -> bool:
        """Let atoms under tension leave and those that overlap enter."""

        def exchange(rows: slice) -> bool:
            touching = self._touching[rows]
            total = self._pressure[rows] + self._change[rows]
            stays = (touching > 0.0) & (total >= 0.0)
            enters = (touching == 0.0) & (self._gap[rows] < -target - self._shift)
            now = (stays | enters).astype(touching.dtype)
            changed = bool((now != touching).any())
            touching[:] = now
            return changed

        return any(by_rows(exchange, self._gap.shape))

    def _clipped(self) -> np.ndarray:
        """Change to a pressure in contact alone and without tension.

        Under a load, to one of the same total.
        """
        clipped = self._z

        def clip(rows: slice) -> tuple[float, float]:
            pressure, touching = self._pressure[rows], self._touching[rows]
            part = np.maximum(self._change[rows], -pressure, out=clipped[rows])
            part *= touching
            part -= (1.0 - touching) * pressure
            return float(part.sum()), float((pressure + part).sum())

        def balance(rows: slice) -> None:
            part = clipped[rows]
            part -= excess * (self._pressure[rows] + part)

        gained, total = np.sum(by_rows(clip, clipped.shape), axis=0).tolist()
        if self._loaded:
            excess = gained / total
            by_rows(balance, clipped.shape)
        return clipped

    def _clip(self) -> None:
        """Clip the change, and let the gap follow."""
        clipped = self._clipped()

        def move(rows: slice) -> bool:
            moved = clipped[rows] - self._change[rows]
            self._change[rows] = clipped[rows]
            clipped[rows] = moved
            return bool(moved.any())

        if any(by_rows(move, clipped.shape)):
            self._gap += self._model.compliance(clipped, clipped)

    def _equilibrate(self, target: float) -> None:
        """Close the gap of the atoms in contact by conjugate gradients.

        They end at a tenth of the first violation, at the target or with the budget.
        Under a load their directions carry none.
        """
        count = int(np.count_nonzero(self._touching))
        if not count:
            return
        left = self._look(count)
        target = max(target, _FORCING * max(left, self._overlap()))
        self._direction[:] = 0.0
        self._last[:] = self._residual
        last_work = math.inf
        while left > target and self._budget > 0:
            last_work = self._turn(count, last_work)
            self._advance()
            left = self._look(count)
            self._budget -= 1

    def _turn(self, count: int, last_work: float) -> float:
        """Choose the next direction, return the work of the residual along the way."""
        z, direction = self._model.stiffness(self._residual, self._z), self._direction
        fields = self._residual, self._last, self._touching
        work, overlap, total = dots([(z, field) for field in fields]).tolist()
        # the residuals have no mean: it does not matter to the work
        mean = total / count if self._loaded else 0.0
        # Polak-Ribiere, restarted when it turns negative
        kept = max(0.0, (work - overlap) / last_work)

        def turn(rows: slice) -> None:
            part = direction[rows]
            part *= kept
            part += (z[rows] - mean) * self._touching[rows]

        by_rows(turn, z.shape)
        return work

    def _advance(self) -> None:
        """Go along the direction to the least energy."""
        direction, change, gap = self._direction, self._change, self._gap
        sunk = self._model.compliance(direction, self._z)
        length = dot(direction, self._residual) / dot(direction, sunk)

        def advance(rows: slice) -> None:
            change[rows] += length * direction[rows]
            gap[rows] += length * sunk[rows]

        by_rows(advance, gap.shape)

    def _look(self, count: int) -> float:
        """Keep the last residual, and return the largest of the new one.

        It is the overlap in contact; under a load without its mean, which is a shift.
        """
        gap, touching = self._gap, self._touching
        if self._loaded:
            self._shift = -dot(gap, touching) / count
        self._last, self._residual = self._residual, self._last

        def overlap(rows: slice) -> tuple[float, float]:
            part = np.add(gap[rows], self._shift, out=self._residual[rows])
            part *= touching[rows]
            np.negative(part, out=part)
            return float(part.max()), -float(part.min())

        return float(np.max(by_rows(overlap, gap.shape)))

    def _overlap(self) -> float:
        """Deepest overlap of an atom out of contact."""

        def deepest(rows: slice) -> float:
            away = self._touching[rows] == 0.0
            return float(self._gap[rows].min(where=away, initial=math.inf))

        return -min(by_rows(deepest, self._gap.shape)) - self._shift
