r"""Active-set method with an upper bound to the pressure, for plastic contact.

The problem of `active_set` with the hardness :math:`H`: find :math:`x` and, under a
load, :math:`s` so that every atom is in one of three states,

.. math:: p + x = 0,\ g' \ge 0; \qquad 0 \le p + x \le H,\ g' = 0; \qquad
          p + x = H,\ g' \le 0,

with :math:`g' = g + C x + s`: open, in elastic, or in plastic contact. The set
:math:`A` holds the atoms in elastic contact, and :math:`P` those in plastic contact.
Atoms leave :math:`A` if their pressure is beyond one of the bounds, and enter it if
their gap has the wrong sign; none changes between open and plastic contact directly,
since the pressure of many such atoms would overshoot.

Under a load, clipping changes the total of the pressure. The pressures in :math:`A` are
moved towards one of the bounds until the load is restored. If they do not suffice, the
atoms out of :math:`A` whose gaps are closest to changing sign are added.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ase_roughcontact._util.kernels import rowwise
from ase_roughcontact.elasticity.circulant import CirculantModel
from ase_roughcontact.solvers.active_set import ComplementarityProblem
from ase_roughcontact.solvers.bounds import with_sum
from ase_roughcontact.solvers.options import ActiveSetOptions

# Of a start, atoms are in plastic contact from this ratio of their pressure to what is
# missing to the hardness.
_FLOW = 9.0
# Atoms that enter the set together carry at most the change of load times this factor.
_MARGIN = 2


class BoundedProblem(ComplementarityProblem):
    """Contact problem of the model with pressures between zero and the hardness.

    Parameters
    ----------
    model, pressure, gap, violation, required_sum, options
        See `ComplementarityProblem`.
    hardness : float
        Finite (pressure).
    """

    def __init__(
        self,
        model: CirculantModel,
        pressure: np.ndarray,
        gap: np.ndarray,
        violation: float,
        required_sum: float | None,
        options: ActiveSetOptions,
        hardness: float,
    ) -> None:
        options = replace(options, forcing=options.plastic_forcing)
        super().__init__(model, pressure, gap, violation, required_sum, options)
        self._hardness = hardness
        # what the pressure lacks to the hardness
        self._missing = self._on_box(hardness - pressure, 1.0 / self._unit)
        # far from the solution many gaps are wrong, more than many pressures
        flows = (self._gap <= -self._missing) & (
            self._pressure >= _FLOW * self._missing
        )
        self._plastic = flows.astype(model.dtype)
        self._contact *= 1.0 - self._plastic

    def _exchange(self, target: float) -> bool:
        return _exchange(
            self._contact,
            self._plastic,
            self._pressure,
            self._missing,
            self._change,
            self._gap,
            self._height_change,
            target,
        )

    def _overlap(self) -> float:
        return _largest_violation(
            self._gap, self._contact, self._plastic, self._height_change
        )

    def _open_lowest_pressure(self) -> None:
        """In a singular full contact, shift the pressure until one is at a bound."""
        if not (self._may_be_singular and self._contact.all()):
            return
        pressure, missing = self._pressure + self._change, self._missing - self._change
        if self._gap.mean() > 0.0:
            self._change -= pressure.min()
            self._contact[pressure <= pressure.min()] = 0.0
        else:
            self._change += missing.min()
            self._plastic[missing <= missing.min()] = 1.0
            self._contact[missing <= missing.min()] = 0.0

    def _clipped(self) -> np.ndarray:
        """Return the change clipped to the bounds; under a load, of no total."""
        clipped = self._scratch
        gained, pressure, missing = self._clip_to_bounds()
        if not self._loaded:
            return clipped
        lacking = gained - pressure if gained > 0.0 else -gained - missing
        if lacking > 0.0:
            self._extend(gained, lacking)
            gained, pressure, missing = self._clip_to_bounds()
        available = pressure if gained > 0.0 else missing
        if available:
            share = max(min(gained / available, 1.0), -1.0)
            _rescale(clipped, share, self._pressure, self._missing, self._contact)
        return clipped

    def _clip_to_bounds(self) -> tuple[float, float, float]:
        return _clip(
            self._scratch,
            self._change,
            self._pressure,
            self._missing,
            self._contact,
            self._plastic,
        )

    def _extend(self, gained: float, lacking: float) -> None:
        """Add atoms to ``A`` that can take up a change of the total."""
        if gained > 0.0:
            candidates, order = self._plastic > 0.0, -self._gap
        else:
            candidates, order = (self._plastic + self._contact) == 0.0, self._gap
        limit = self._hardness / self._unit
        count = _MARGIN * int(lacking / limit) + 1
        gaps = order[candidates]
        if count < gaps.size:
            candidates &= order <= np.partition(gaps, count - 1)[count - 1]
        self._plastic[candidates] = 0.0
        self._contact[candidates] = 1.0

    def _result(self) -> np.ndarray:
        """Return the new pressure on the window; under a load of its total."""
        old, new = self._window, np.zeros(self._window.shape)
        inside = self._model.box.slices
        _add_change(
            new[inside],
            old[inside],
            self._unit,
            self._clipped(),
            self._pressure,
            self._plastic,
            self._hardness,
        )
        if self._required_sum is not None:
            push = np.zeros(new.shape)
            push[inside] = -self._unit * self._gap
            new = with_sum(new, self._required_sum, self._hardness, push)
        return new


@rowwise(np.logical_or)
def _exchange(
    contact: np.ndarray,
    plastic: np.ndarray,
    pressure: np.ndarray,
    missing: np.ndarray,
    change: np.ndarray,
    gap: np.ndarray,
    height_change: float,
    target: float,
) -> bool:
    """Update the sets ``A`` and ``P``; return whether one has changed."""
    elastic, full = contact > 0.0, plastic > 0.0
    overlap = -gap
    overlap -= height_change
    below, above = change < -pressure, change > missing
    releases = full & (overlap < -target)
    enters = releases | (~elastic & ~full & (overlap > target))
    new = (elastic & ~below & ~above) | enters
    new_full = (full & ~releases) | (elastic & above)
    changed = bool((new != elastic).any() or (new_full != full).any())
    contact[:] = new
    plastic[:] = new_full
    return changed


@rowwise(np.maximum)
def _largest_violation(
    gap: np.ndarray, contact: np.ndarray, plastic: np.ndarray, height_change: float
) -> float:
    """Return the largest overlap of open atoms, or gap of those in plastic contact."""
    gap = gap + height_change
    gap *= 2.0 * plastic - 1.0
    gap *= 1.0 - contact
    return float(gap.max())


@rowwise(np.add)
def _clip(
    clipped: np.ndarray,
    change: np.ndarray,
    pressure: np.ndarray,
    missing: np.ndarray,
    contact: np.ndarray,
    plastic: np.ndarray,
) -> tuple[float, float, float]:
    """Clip ``p + x`` to the bounds in ``A``; set it to H in ``P``, to zero elsewhere.

    Returns the sums of ``x``, and of ``p + x`` and ``H - p - x`` in ``A``.
    """
    np.clip(change, -pressure, missing, out=clipped)
    clipped *= contact
    clipped += plastic * missing
    clipped -= (1.0 - contact - plastic) * pressure
    return (
        float(clipped.sum()),
        float(((pressure + clipped) * contact).sum()),
        float(((missing - clipped) * contact).sum()),
    )


@rowwise()
def _rescale(
    change: np.ndarray,
    share: float,
    pressure: np.ndarray,
    missing: np.ndarray,
    contact: np.ndarray,
) -> None:
    """Reduce ``p + x`` in ``A`` by a share, or ``H - p - x`` if it is negative."""
    if share > 0.0:
        change -= share * contact * (pressure + change)
    else:
        change -= share * contact * (missing - change)


@rowwise()
def _add_change(
    new: np.ndarray,
    old: np.ndarray,
    unit: float,
    change: np.ndarray,
    pressure: np.ndarray,
    plastic: np.ndarray,
    hardness: float,
) -> None:
    """Set the new pressure: the hardness in ``P``, zero where ``p + x`` is."""
    result = old + unit * change
    np.clip(result, 0.0, hardness, out=result)
    result *= pressure + change > 0.0
    result[plastic > 0.0] = hardness
    new[:] = result
