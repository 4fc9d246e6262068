r"""Active-set method for the contact problem of the circulant model.

From a pressure :math:`p` with the exact gap :math:`g`, find the change :math:`x` of the
pressure and, under a load, the change :math:`s` of the height so that with
:math:`g' = g + C x + s` every atom is in one of three states,

.. math:: p + x = 0,\ g' \ge 0; \qquad 0 \le p + x \le H,\ g' = 0; \qquad
          p + x = H,\ g' \le 0:

open, in elastic, or, if the wall has a finite hardness :math:`H`, in plastic contact.
:math:`C` is the model; under a load :math:`\sum x = 0`, on a spring
:math:`s = \kappa \sum x`, else :math:`s = 0`. With the sets :math:`A` of atoms in
elastic and :math:`P` in plastic contact, repeat

1. *Clip*: :math:`x = \max(-p, \min(x, H - p))` in :math:`A`, :math:`x = H - p` in
   :math:`P`, :math:`x = -p` elsewhere. Under a load, move the pressures in :math:`A`
   towards one of their bounds until the total is restored. If they do not suffice, add
   to :math:`A` the atoms with gaps that are closest to a change of sign.
2. *Solve* :math:`g + C x + s = 0` in :math:`A` by conjugate gradients, preconditioned
   by the inverse of the model, until a part of the violation is left.
3. *Exchange*: atoms with pressures beyond the bounds leave :math:`A`, atoms with gaps
   of the wrong sign enter it. No atom changes between open and plastic contact
   directly, as the pressure of many such atoms would overshoot. If no atom changes,
   continue with 2,

until the sets do not change and the violation is small enough. The linear systems are
solved inexactly, since the sets of the first iterations are not final. Sets that still
change after several updates may cycle: each further system is solved twice as exactly
as the last one.

All fields are arrays on the box of the model, in the precision of the model and in
units of the violation; :math:`A` is an array of zeros and ones. Without lists of atoms
a step costs little more than two Fourier transforms. Since the change of the pressure
is the unknown, single precision does not limit the accuracy of the result.

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
    linear_combination,
    rowwise,
    scale,
    total,
)
from ase_roughcontact.elasticity.circulant import CirculantModel
from ase_roughcontact.elasticity.lattice import Box, carried
from ase_roughcontact.solvers.hard.bounds import with_sum

# Violation after conjugate gradients relative to the violation before, at which the
# sets are updated.
_FORCING = 0.4
# Number of updates with this ratio, which is halved for each further update.
_LOOSE_UPDATES = 6
# Largest number of updates and steps of conjugate gradients together.
_MAX_STEPS = 300
# Load that atoms which enter the set together can carry, relative to the missing load.
_LOAD_FACTOR = 2


class ComplementarityProblem:
    """Contact problem of the model, and its present solution.

    Parameters
    ----------
    model : CirculantModel
        Model of the half space; its box contains all atoms under pressure.
    pressure : ndarray, shape (n, m)
        Pressure on the window, between zero and the hardness.
    gap : ndarray, shape (n, m)
        Exact gap of this pressure (length).
    violation : float
        Largest violation of the contact conditions (length), which is the unit of
        length of the fields.
    required_sum : float or None
        Sum of the pressures under a load; None if the height is given.
    hardness : float
        Largest pressure; infinity for an elastic contact.
    yielding : float
        Rise of the indenter on a spring per sum of the pressures (length per pressure);
        zero without a spring.
    """

    def __init__(
        self,
        model: CirculantModel,
        pressure: np.ndarray,
        gap: np.ndarray,
        violation: float,
        required_sum: float | None,
        hardness: float,
        yielding: float,
    ) -> None:
        self._model, self._hardness = model, hardness
        self._yielding = yielding / model.self_compliance
        self._required_sum, self._loaded = required_sum, required_sum is not None
        self._window, self._unit = pressure, violation / model.self_compliance
        self._pressure = self._on_box(pressure, 1.0 / self._unit)
        self._gap = self._on_box(gap, 1.0 / violation)  # g + C x
        contact = self._pressure > self._gap
        self._missing: np.ndarray | float = math.inf  # to the hardness
        self._plastic: np.ndarray | None = None
        if hardness < math.inf:
            self._missing = self._on_box(hardness - pressure, 1.0 / self._unit)
            self._plastic = self._pressure >= self._missing
            self._plastic &= self._gap <= -self._missing
            contact &= ~self._plastic
        self._contact = contact.astype(model.dtype)
        self._height_change = 0.0
        self._forcing, self._steps = _FORCING, _MAX_STEPS  # number of remaining steps

    def solve(self, target: float) -> np.ndarray:
        """Return a pressure that satisfies the conditions of contact for the model.

        Parameters
        ----------
        target : float
            Largest violation at the end, relative to the present violation.

        Returns
        -------
        ndarray, shape (n, m)
            Pressure; the result of the last iteration if the number of steps does not
            suffice.
        """
        # work arrays are shared by residual, direction and results of transforms
        self._change, *self._fields = (np.zeros_like(self._contact) for _ in range(4))
        updates = 0
        while True:
            self._steps -= 1
            updates += 1
            if updates > _LOOSE_UPDATES:
                self._forcing *= 0.5
            self._leave_full_contact()
            self._clip()
            if not self._close_gaps(target) or self._steps <= 0:
                return self._result()

    def _on_box(self, values: np.ndarray, factor: float) -> np.ndarray:
        """Return values on the box of the model times a factor, in its precision."""
        field = np.empty(self._model.box.shape, self._model.dtype)
        scale(field, values[self._model.box.slices], factor)
        return field

    def _leave_full_contact(self) -> None:
        """Shift the pressure to the next bound in a full contact at a fixed height.

        The model of a periodic surface is singular there.
        """
        singular = self._model.singular and not self._yielding
        if self._loaded or not (singular and self._contact.all()):
            return
        pressure, missing = self._pressure + self._change, self._missing - self._change
        if self._plastic is None or self._gap.mean() > 0.0:
            self._change -= pressure.min()
            self._contact[pressure <= pressure.min()] = 0.0
        else:
            self._change += missing.min()
            self._plastic[missing <= missing.min()] = True
            self._contact[self._plastic] = 0.0

    def _clip(self) -> None:
        """Clip the change, and update the gap."""
        clipped = self._clipped()
        difference = np.subtract(clipped, self._change, out=self._change)
        self._change, self._fields[0] = clipped, difference
        if difference.any():
            opening = self._opened(difference, difference)
            linear_combination([(1.0, self._gap), (1.0, opening)], out=self._gap)

    def _opened(self, change: np.ndarray, out: np.ndarray) -> np.ndarray:
        """Return the opening of the gap by a change, with the rise on a spring."""
        raised = self._yielding and self._yielding * total(change)
        opening = self._model.compliance(change, out)
        if raised:
            opening += raised
        return opening

    def _clipped(self, extend: bool = True) -> np.ndarray:
        """Return the change clipped to the bounds, with a sum of zero under a load."""
        clipped = self._within_bounds()
        gained = total(clipped) if self._loaded else 0.0
        if not gained:
            return clipped
        bounded = self._plastic is not None
        available = self._available(clipped, gained)
        capacity = total(available)
        if bounded and abs(gained) > capacity and extend:
            self._extend(gained, abs(gained) - capacity)
            return self._clipped(extend=False)
        if capacity:
            share = max(min(gained / capacity, 1.0), -1.0 if bounded else -math.inf)
            linear_combination([(1.0, clipped), (-share, available)], out=clipped)
        return clipped

    def _within_bounds(self) -> np.ndarray:
        """Return ``x`` within its bounds in ``A``, at one of them elsewhere."""
        clipped, lowest, _ = self._fields
        np.negative(self._pressure, out=lowest)
        np.maximum(self._change, lowest, out=clipped)
        np.copyto(clipped, lowest, where=self._contact == 0.0)
        if self._plastic is not None:
            np.minimum(clipped, self._missing, out=clipped)
            np.copyto(clipped, self._missing, where=self._plastic)
        return clipped

    def _available(self, change: np.ndarray, gained: float) -> np.ndarray:
        """Return the largest decrease of pressures in ``A``, or increase if required.

        Without a hardness, increases are multiples of the pressures.
        """
        available = self._fields[2]
        if gained > 0.0 or self._plastic is None:
            np.add(self._pressure, change, out=available)
        else:
            np.subtract(self._missing, change, out=available)
        if self._plastic is not None:  # otherwise it is zero out of contact
            available *= self._contact
        return available

    def _extend(self, gained: float, missing: float) -> None:
        """Add atoms to ``A`` that can take up a change of the total."""
        assert self._plastic is not None
        if gained > 0.0:
            candidates, order = self._plastic.copy(), -self._gap
        else:
            candidates, order = (self._contact == 0.0) & ~self._plastic, self._gap
        count = _LOAD_FACTOR * int(missing * self._unit / self._hardness) + 1
        gaps = order[candidates]
        if count < gaps.size:
            candidates &= order <= np.partition(gaps, count - 1)[count - 1]
        self._plastic[candidates] = False
        self._contact[candidates] = 1.0

    def _close_gaps(self, target: float) -> bool:
        r"""Close the gaps in contact until a set changes; return whether a set changes.

        Conjugate gradients are used, with the residual :math:`r`, zero out of contact:

        .. math:: z = C^{-1} r, \quad
                  \beta = \frac{z \cdot r}{(z \cdot r)'}, \quad
                  t \leftarrow z + \beta t, \quad
                  \alpha = \frac{z \cdot r}{t \cdot C t}, \quad
                  x \leftarrow x + \alpha t

        Under a load the mean of :math:`z` in contact is subtracted from :math:`z`, and
        :math:`s` makes the mean of :math:`r` zero.
        """
        count = total(self._contact)
        if not count:
            return self._exchange(target)
        residual, direction, buffer = self._fields
        largest, last_work = self._set_residual(count), math.inf
        stage = max(target, self._forcing * largest)
        while True:
            if largest <= stage or self._steps <= 0:
                changed = self._exchange(target)
                if changed or largest <= target or self._steps <= 0:
                    return changed
                stage = max(target, self._forcing * largest)
            z = self._model.stiffness(residual, buffer)
            work, mean = dots([(z, residual), (z, self._contact)])
            if self._loaded:  # the residuals have no mean: the work is the same
                z -= mean / count
            z *= self._contact
            linear_combination([(work / last_work, direction), (1.0, z)], out=direction)
            opening = self._opened(direction, buffer)
            length, last_work = work / dot(direction, opening), work
            for values, change in ((self._change, direction), (self._gap, opening)):
                linear_combination([(1.0, values), (length, change)], out=values)
            largest = self._set_residual(count)
            self._steps -= 1

    def _set_residual(self, count: float) -> float:
        """Set ``r = -(g + C x + s)`` in contact, and ``s``; return ``max |r|``."""
        if self._loaded:
            self._height_change = -dot(self._gap, self._contact) / count
        return _set_residual(
            self._fields[0], self._gap, self._height_change, self._contact
        )

    def _exchange(self, target: float) -> bool:
        """Update the sets; return whether a set has changed."""
        return _exchange(
            self._gap,
            self._height_change,
            self._change,
            self._contact,
            self._plastic,
            self._pressure,
            self._missing,
            target,
        )

    def _result(self) -> np.ndarray:
        """Return the new pressure on the window, with the required sum under a load."""
        box, window = self._model.box, Box((0, 0), self._window.shape)
        change, old = self._clipped(), self._window[box.slices]
        del self._fields, self._change, self._contact  # their memory is needed
        pressure = linear_combination([(1.0, old), (self._unit, change)])
        np.clip(pressure, 0.0, self._hardness, out=pressure)
        pressure *= change > -self._pressure
        if self._plastic is not None:
            np.copyto(pressure, self._hardness, where=self._plastic)
        if box != window:
            pressure = carried(pressure, box, window)
        if self._required_sum is None:
            return pressure
        push = np.zeros(1)
        if self._plastic is not None:
            push = carried(-self._unit * self._gap, box, window)
        return with_sum(pressure, self._required_sum, self._hardness, push)


@rowwise(np.logical_or)
def _exchange(
    gap: np.ndarray,
    height_change: float,
    change: np.ndarray,
    contact: np.ndarray,
    plastic: np.ndarray | None,
    pressure: np.ndarray,
    missing: np.ndarray | float,
    target: float,
) -> bool:
    """Update the sets in elastic and plastic contact; return whether a set changes."""
    inside = contact > 0.0
    wrong = -height_change - gap  # overlaps; gaps of atoms in plastic contact
    if plastic is not None:
        np.negative(wrong, out=wrong, where=plastic)
    enters = wrong > target
    del wrong  # its memory is needed
    elastic = np.where(inside, change >= -pressure, enters)
    if plastic is not None:
        above = inside & (change > missing)
        elastic &= ~above
        plastic &= ~elastic
        plastic |= above
    contact[:] = elastic
    return bool((elastic != inside).any())


@rowwise(np.maximum)
def _set_residual(
    residual: np.ndarray, gap: np.ndarray, height_change: float, contact: np.ndarray
) -> float:
    """Set ``r = -(g + s)`` in contact, zero elsewhere; return ``max |r|``."""
    np.subtract(-height_change, gap, out=residual)
    residual *= contact
    return float(max(residual.max(), -residual.min()))
