r"""Active-set method for the contact problem of the circulant model.

From a pressure :math:`p` with the exact gap :math:`g`, find the change :math:`x` of the
pressure and, under a load, the change :math:`s` of the height with

.. math:: p + x \ge 0, \qquad g + C x + s \ge 0, \qquad (p + x)(g + C x + s) = 0,

and :math:`\sum x = 0` under a load, :math:`s = 0` at a fixed height. :math:`C` is the
model. With the set :math:`A` of atoms in contact, repeat

1. *Clip*: :math:`x = \max(x, -p)` in :math:`A`, :math:`x = -p` outside.
2. *Solve* :math:`g + C x + s = 0` in :math:`A` by conjugate gradients, preconditioned
   by the inverse of the model, until 40 % of the violation is left.
3. *Exchange*: atoms under tension leave :math:`A`, atoms that overlap enter it. If none
   does, continue with 2,

until the set does not change and the violation is small enough. The linear systems are
solved inexactly, since the sets of the first iterations are wrong anyway. A set that
still changes after several updates may cycle: from then on each system is solved twice
as exactly as the last one.

All fields are arrays on the box of the model, in its precision and in units of the
violation; the set is an array of zeros and ones. Without lists of atoms a step costs
little more than its two Fourier transforms. Since the change of the pressure is the
unknown, single precision does not limit the accuracy of the result.

References
----------
M. Hintermüller, K. Ito, K. Kunisch, SIAM J. Optim. 13, 865 (2002) (active set);
I. A. Polonsky, L. M. Keer, Wear 231, 206 (1999); E. A. H. Vollebregt, J. Comput. Phys.
257, 332 (2014) (preconditioner).
"""

from __future__ import annotations

import math

import numpy as np

from ase_roughcontact._util.kernels import (
    dot,
    dots,
    inner,
    least,
    linear_combination,
    rowwise,
    scale,
    total,
)
from ase_roughcontact.elasticity.circulant import CirculantModel
from ase_roughcontact.solvers.options import ActiveSetOptions


class ComplementarityProblem:
    """Contact problem of the model, and its solution so far.

    Parameters
    ----------
    model : CirculantModel
        Model of the half space; its box contains all atoms under pressure.
    pressure : ndarray, shape (n, m)
        Nonnegative pressure on the window.
    gap : ndarray, shape (n, m)
        Exact gap of this pressure (length).
    violation : float
        Largest gap in contact or overlap (length), the unit of length here.
    required_sum : float or None
        Sum of the pressures under a load; None if the height is given.
    options : ActiveSetOptions
    """

    def __init__(
        self,
        model: CirculantModel,
        pressure: np.ndarray,
        gap: np.ndarray,
        violation: float,
        required_sum: float | None,
        options: ActiveSetOptions,
    ) -> None:
        self._model, self._options = model, options
        self._required_sum, self._loaded = required_sum, required_sum is not None
        self._window, self._unit = pressure, violation / model.self_compliance
        self._pressure = self._on_box(pressure, 1.0 / self._unit)
        self._total = total(self._pressure)
        self._gap = self._on_box(gap, 1.0 / violation)  # g + C x
        self._contact = (self._pressure > self._gap).astype(model.dtype)
        self._change = np.zeros_like(self._pressure)
        self._residual = np.empty_like(self._pressure)
        self._direction = np.empty_like(self._pressure)
        self._scratch = np.empty_like(self._pressure)
        self._height_change = 0.0
        self._forcing = options.forcing
        self._loose = options.loose_updates  # that are left
        self._steps = options.inner_steps  # that are left
        # the model of a periodic surface in full contact is singular at a fixed height
        self._may_be_singular = model.singular and not self._loaded

    def solve(self, target: float) -> np.ndarray:
        """Return a pressure that satisfies the conditions of contact for the model.

        Parameters
        ----------
        target : float
            Violation that may be left, relative to the present one.

        Returns
        -------
        ndarray, shape (n, m)
            The result of the last iteration, also if the steps do not suffice.
        """
        while True:
            self._steps -= 1
            self._loose -= 1
            if self._loose < 0:
                self._forcing *= 0.5
            self._open_lowest_pressure()
            self._clip()
            if not self._close_gaps(target) or self._steps <= 0:
                return self._result()

    def _exchange(self, target: float) -> bool:
        """Update the set; return whether it has changed."""
        return _exchange(
            self._contact,
            self._pressure,
            self._change,
            self._gap,
            -target - self._height_change,
        )

    def _on_box(self, values: np.ndarray, factor: float) -> np.ndarray:
        """Return values on the box of the model times a factor, in its precision."""
        field = np.empty(self._model.box.shape, self._model.dtype)
        scale(field, values[self._model.box.slices], factor)
        return field

    def _result(self) -> np.ndarray:
        """Return the new pressure on the window; under a load of its total."""
        old, new = self._window, np.zeros(self._window.shape)
        inside = self._model.box.slices
        reached = _add_change(
            new[inside], old[inside], self._unit, self._clipped(), self._pressure
        )
        if self._required_sum is not None:
            scale(new, new, self._required_sum / reached)
        return new

    def _open_lowest_pressure(self) -> None:
        """In a singular full contact, reduce the pressures until one is zero."""
        if self._may_be_singular and self._contact.all():
            pressure = self._pressure + self._change
            self._change -= pressure.min()
            self._contact[pressure <= pressure.min()] = 0.0

    def _clipped(self) -> np.ndarray:
        """Return the change clipped to pressures >= 0; under a load, of no total."""
        clipped = self._scratch
        gained = _clip(clipped, self._change, self._pressure, self._contact)
        if self._loaded:
            _rescale(clipped, gained / (self._total + gained), self._pressure)
        return clipped

    def _clip(self) -> None:
        """Clip the change, and update the gap."""
        clipped, difference = self._clipped(), self._change
        self._change, self._scratch = clipped, difference
        if _subtract_from(difference, clipped):
            opening = self._model.compliance(difference, difference)
            linear_combination([(1.0, self._gap), (1.0, opening)], out=self._gap)

    def _close_gaps(self, target: float) -> bool:
        r"""Close the gaps in contact until the set changes; return whether it does.

        By conjugate gradients, with the residual :math:`r`, zero out of contact:

        .. math:: z = C^{-1} r, \quad
                  \beta = \frac{z \cdot r}{(z \cdot r)'}, \quad
                  t \leftarrow z + \beta t, \quad
                  \alpha = \frac{z \cdot r}{t \cdot C t}, \quad
                  x \leftarrow x + \alpha t

        Under a load the mean of :math:`z` in contact is subtracted from it.
        """
        count = int(total(self._contact))
        if not count:
            return self._exchange(target)
        opened = dot(self._gap, self._contact) if self._loaded else 0.0
        largest = self._update_residual(opened / count)
        stage = max(target, self._forcing * max(largest, self._overlap()))
        last_work = math.inf
        while self._steps > 0:
            if largest <= stage:
                if self._exchange(target):
                    return True
                if largest <= target:
                    return False
                stage = max(target, self._forcing * largest)
            last_work, opened = self._advance(count, last_work)
            largest = self._update_residual(opened / count)
            self._steps -= 1
        return self._exchange(target)

    def _overlap(self) -> float:
        """Return the largest overlap."""
        return -least(self._gap) - self._height_change

    def _update_residual(self, mean_gap: float) -> float:
        """Set ``r = -(g + C x + s)`` in contact; return its largest magnitude."""
        if self._loaded:
            self._height_change = -mean_gap
        return _set_residual(
            self._residual, self._gap, self._height_change, self._contact
        )

    def _advance(self, count: int, last_work: float) -> tuple[float, float]:
        """Make a step of conjugate gradients.

        Returns
        -------
        work, opened : float
            ``z . r``, and the sum of the gaps in contact.
        """
        z = self._model.stiffness(self._residual, self._scratch)
        work, mean = dots([(z, self._residual), (z, self._contact)])
        # under a load the residuals have no mean: that of z does not change the work
        mean = mean / count if self._loaded else 0.0
        _set_direction(self._direction, work / last_work, z, mean, self._contact)
        opening = self._model.compliance(self._direction, self._scratch)
        length = work / dot(self._direction, opening)
        opened = _advance(
            self._change, self._gap, length, self._direction, opening, self._contact
        )
        return work, opened


@rowwise(np.logical_or)
def _exchange(
    contact: np.ndarray,
    pressure: np.ndarray,
    change: np.ndarray,
    gap: np.ndarray,
    least_gap: float,
) -> bool:
    """Update the set: keep ``p + x >= 0``, add gaps below `least_gap`.

    Returns whether it has changed.
    """
    inside = contact > 0.0
    new = inside & (change >= -pressure)
    new |= ~inside & (gap < least_gap)
    contact[:] = new
    return bool((new != inside).any())


@rowwise(np.add)
def _clip(
    clipped: np.ndarray, change: np.ndarray, pressure: np.ndarray, contact: np.ndarray
) -> float:
    """Clip ``x`` to ``max(x, -p)`` in contact, ``-p`` elsewhere; return its sum."""
    lowest = -pressure
    np.maximum(change, lowest, out=clipped)
    clipped *= contact
    lowest *= 1.0 - contact
    clipped += lowest
    return float(clipped.sum())


@rowwise()
def _rescale(change: np.ndarray, excess: float, pressure: np.ndarray) -> None:
    """Set ``x -= excess (p + x)``."""
    change -= excess * (pressure + change)


@rowwise(np.logical_or)
def _subtract_from(change: np.ndarray, new: np.ndarray) -> bool:
    """Set a change to its difference to a new one; return whether it is not zero."""
    np.subtract(new, change, out=change)
    return bool(change.any())


@rowwise(np.maximum)
def _set_residual(
    residual: np.ndarray, gap: np.ndarray, height_change: float, contact: np.ndarray
) -> float:
    """Set ``r = -(g + s)`` in contact, zero elsewhere; return ``max |r|``."""
    np.subtract(-height_change, gap, out=residual)
    residual *= contact
    return float(max(residual.max(), -residual.min()))


@rowwise()
def _set_direction(
    direction: np.ndarray, beta: float, z: np.ndarray, mean: float, contact: np.ndarray
) -> None:
    """Set ``t = beta t + z - mean`` in contact, zero elsewhere; overwrite ``z``."""
    z -= mean
    if not beta:  # the first direction
        np.multiply(z, contact, out=direction)
        return
    z *= contact
    direction *= beta
    direction += z


@rowwise(np.add)
def _advance(
    change: np.ndarray,
    gap: np.ndarray,
    length: float,
    direction: np.ndarray,
    opening: np.ndarray,
    contact: np.ndarray,
) -> float:
    """Set ``x += length t`` and ``g += length C t``; overwrite ``C t``.

    Returns the sum of the gaps in contact.
    """
    opening *= length
    gap += opening
    np.multiply(direction, length, out=opening)
    change += opening
    return inner(gap, contact)


@rowwise(np.add)
def _add_change(
    new: np.ndarray,
    old: np.ndarray,
    unit: float,
    change: np.ndarray,
    pressure: np.ndarray,
) -> float:
    """Set the new pressure ``max(old + unit x, 0)``, zero where ``p + x`` is.

    Returns its sum.
    """
    # in an array of its own: operations on parts of rows take much longer
    result = np.multiply(change, unit, dtype=new.dtype)
    result += old
    np.maximum(result, 0.0, out=result)
    result *= change > -pressure
    new[:] = result
    return float(result.sum())
