"""Stiffness of a contact under a small oscillation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ase_roughcontact._util.validation import positive

# Cycles from which the stiffness follows, and states that they need at least.
_CYCLES, _LEAST_STATES = 2, 8


def dynamic_stiffness(steps: Sequence[Any], frequency: float) -> complex:
    r"""Return the complex stiffness of a contact at the end of a path in time.

    The force responds to an oscillation of the penetration,
    :math:`\delta + \hat\delta e^{i \omega t}`, by :math:`K \hat\delta e^{i \omega t}`.
    Both are fitted over the last two cycles, with a linear drift.

    Parameters
    ----------
    steps : sequence of TimeStep
        That end with at least two cycles of `Schedule.oscillate`.
    frequency : float
        Cycles per time.

    Returns
    -------
    complex
        Storage stiffness plus i times loss stiffness (eV/Å^2).

    Raises
    ------
    ValueError
        If there are too few states in the last two cycles, or the penetration does not
        oscillate.
    """
    positive(frequency=frequency)
    end = steps[-1].time if steps else 0.0
    begin = end - _CYCLES / frequency
    last = [step for step in steps if step.time > begin]
    if begin < -1e-9 * end or len(last) < _LEAST_STATES:
        raise ValueError(
            f"the path must end with {_CYCLES} cycles of {_LEAST_STATES} states or "
            f"more, got {len(last)} states in the time from {begin:.4g} to {end:.4g}"
        )
    time = np.array([step.time for step in last]) - end
    phase = 2.0 * math.pi * frequency * time
    waves = np.stack([np.cos(phase), np.sin(phase), np.ones_like(time), time], axis=1)
    values = [(step.penetration, step.normal_force) for step in last]
    (cosines, sines, *_), *_ = np.linalg.lstsq(waves, np.array(values), rcond=None)
    depth, force = cosines - 1j * sines
    if not abs(depth) > 0.0:
        raise ValueError(f"the penetration does not oscillate at {frequency:g}")
    return complex(force / depth)
