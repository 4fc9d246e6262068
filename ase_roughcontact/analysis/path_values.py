"""Values that follow from the steps of paths.

Static friction, energies of loops, dynamic stiffness, limit of fine grids, and a
warning of a pull-off force that is a lower bound.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ase_roughcontact._util.units import with_unit
from ase_roughcontact._util.validation import FloatArray, finite_array, positive
from ase_roughcontact.results.record import LoadStep

# Largest distance of the ends of a closed loop, relative to the range of the path.
_MAX_LOOP_OPENING = 1e-3
# Largest relative change of the load during a slide.
_MAX_LOAD_CHANGE = 1e-2
# Number of cycles to which the dynamic stiffness is fitted.
_CYCLES = 2
# Smallest number of states in these cycles.
_MIN_STATES = 8


def static_friction(steps: Sequence[Any]) -> float:
    """Return the largest lateral force of the first slide.

    The first slide begins with the first step in which all atoms in contact slip, and
    ends when the indenter turns back or the load has changed by 1 %. The lateral force
    approaches `largest_friction` from below, as the tractions of atoms that have just
    begun to slip are not yet parallel.

    Parameters
    ----------
    steps : sequence of SlidingStep
        Steps of a sliding path.

    Returns
    -------
    float
        Static friction (eV/Å); NaN if in no step all atoms in contact slip.
    """
    slides = [s.slip_area > 0.0 and s.stick_area == 0.0 for s in steps]
    if not any(slides):
        return float("nan")
    start = end = slides.index(True)
    forces = np.array([[s.lateral_force_x, s.lateral_force_y] for s in steps])
    points = np.array([[s.lateral_x, s.lateral_y] for s in steps])
    onward = np.diff(points, axis=0) @ forces[start] >= 0.0
    loads = np.array([s.normal_force for s in steps])
    same = abs(loads - loads[start]) <= _MAX_LOAD_CHANGE * abs(loads[start])
    while end + 1 < len(steps) and onward[end] and same[end + 1]:
        end += 1
    return float(np.hypot(*forces[: end + 1].T).max())


def friction_coefficients(steps: Sequence[Any]) -> FloatArray:
    """Return lateral over normal force of each step, NaN where nothing is pressed.

    Parameters
    ----------
    steps : sequence of SlidingStep

    Returns
    -------
    ndarray, shape (steps,)
    """
    lateral = [math.hypot(s.lateral_force_x, s.lateral_force_y) for s in steps]
    normal = [s.normal_force if s.normal_force > 0.0 else math.nan for s in steps]
    return np.array(lateral) / np.array(normal)


def loop_energies(steps: Sequence[Any]) -> FloatArray:
    """Return the energies that are dissipated in closed loops of lateral displacement.

    Parameters
    ----------
    steps : sequence of SlidingStep
        Steps of a path back and forth along a line.

    Returns
    -------
    ndarray, shape (loops,)
        Energies from each turning point to the next one at the same displacement (eV).

    Raises
    ------
    ValueError
        If there are no steps.
    """
    if not len(steps):
        raise ValueError("a loop needs the steps of a sliding path, got none")
    points = np.array([[s.lateral_x, s.lateral_y] for s in steps])
    points -= points[0]
    farthest = points[np.hypot(*points.T).argmax()]
    along = points @ farthest / (np.hypot(*farthest) or 1.0)
    ends = turning_points(along)
    closed = _MAX_LOOP_OPENING * np.ptp(along)
    return np.array(
        [
            steps[b].dissipated_energy - steps[a].dissipated_energy
            for a, b in zip(ends, ends[2:], strict=False)
            if abs(along[b] - along[a]) <= closed
        ]
    )


def turning_points(values: FloatArray) -> list[int]:
    """Return the first index, indices where values turn back, and the last index."""
    signs = np.sign(np.diff(values))
    moves = np.flatnonzero(signs).tolist()
    turns = [a + 1 for a, b in pairwise(moves) if signs[a] != signs[b]]
    return [0, *turns, len(values) - 1]


def dynamic_stiffness(steps: Sequence[Any], frequency: float) -> complex:
    r"""Return the complex stiffness of a contact at the end of a path in time.

    The response of the force to an oscillation of the penetration,
    :math:`\delta + \hat\delta e^{i \omega t}`, is :math:`K \hat\delta e^{i \omega t}`.
    Penetration and force are fitted over the last two cycles, with a linear drift.

    Parameters
    ----------
    steps : sequence of TimeStep
        Steps of a path that ends with at least two cycles of `Schedule.oscillate`.
    frequency : float
        Frequency (cycles per time).

    Returns
    -------
    complex
        Stiffness K: storage stiffness plus i times loss stiffness (eV/Å^2).

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
    if begin < -1e-9 * end or len(last) < _MIN_STATES:
        raise ValueError(
            f"the path must end with {_CYCLES} cycles of at least {_MIN_STATES} "
            f"states, got {len(last)} states in the time from {begin:.4g} to {end:.4g}"
        )
    time = np.array([step.time for step in last]) - end
    phase = 2.0 * math.pi * frequency * time
    waves = np.stack([np.cos(phase), np.sin(phase), np.ones_like(time), time], axis=1)
    values = [(step.penetration, step.normal_force) for step in last]
    coefficients = np.linalg.lstsq(waves, np.array(values), rcond=None)[0]
    depth, force = coefficients[0] - 1j * coefficients[1]
    if not abs(depth) > 0.0:
        raise ValueError(f"the penetration does not oscillate at {frequency:g}")
    return complex(force / depth)


class GridLimit(NamedTuple):
    """Values on an infinitely fine grid.

    Attributes
    ----------
    value : ndarray
        Extrapolated values.
    error : ndarray
        Estimated errors of the values.
    """

    value: FloatArray
    error: FloatArray


def extrapolate(
    spacings: Sequence[float], values: ArrayLike, order: float = 1.0
) -> GridLimit:
    r"""Return the limit of values on two or three grids, with an estimate of its error.

    .. math:: L = f_1 + \frac{f_1 - f_2}{(h_2/h_1)^p - 1}

    with the values :math:`f_1` and :math:`f_2` on the two finest grids of spacing
    :math:`h_1 < h_2`. The error from two grids is :math:`|L - f_1|`. The error from
    three grids is the change of the limit from the two coarser grids to the two finer
    ones, and at least :math:`|L - f_1| / 2`.

    Parameters
    ----------
    spacings : sequence of float
        Two or three different spacings, in any order (length).
    values : array_like, shape (grids, ...)
        Values on each grid, such as the `contact_area` of all steps of a path.
    order : float
        Power p of the spacing to which the error is proportional, 1 for the contact
        area.

    Returns
    -------
    GridLimit
        Limit and error, arrays of shape (...).

    Raises
    ------
    ValueError
        If there are not two or three different positive spacings with values each, or a
        number is not finite.

    Notes
    -----
    Under a hard wall extrapolate `contact_area`, where the error is proportional to the
    spacing, rather than `continuum_area`, where the error is smaller, but less regular.

    References
    ----------
    L. F. Richardson, Phil. Trans. R. Soc. A 210, 307 (1911).

    Examples
    --------
    >>> limit = extrapolate([1.0, 0.5, 0.25], [1.4, 1.2, 1.1])
    >>> round(float(limit.value), 9), round(float(limit.error), 9)
    (1.0, 0.05)
    """
    h, f = finite_array("spacings", spacings), finite_array("values", values)
    if h.shape not in ((2,), (3,)) or f.shape[:1] != h.shape:
        raise ValueError(
            "give two or three spacings and as many rows of values, got shapes "
            f"{h.shape} and {f.shape}"
        )
    finest_first = np.argsort(h)
    h, f = h[finest_first], f[finest_first]
    positive(order=order, spacing=h[0])
    if not np.diff(h).all():
        raise ValueError(f"spacings must differ, got {spacings}")
    limits = [
        f[i] + (f[i] - f[i + 1]) / ((h[i + 1] / h[i]) ** order - 1.0)
        for i in range(len(h) - 1)
    ]
    error = abs(limits[0] - f[0])
    if len(limits) == 2:
        error = np.maximum(abs(limits[0] - limits[1]), error / 2.0)
    return GridLimit(limits[0], error)


def tension_at_turn(turn: LoadStep, pull_off_force: float) -> str:
    """Return a warning about an indenter that is pulled where its retraction begins.

    Parameters
    ----------
    turn : LoadStep
        Step at which the retraction begins, with a negative force.
    pull_off_force : float
        Largest tension during the retraction (eV/Å).

    Returns
    -------
    str
        The warning.
    """
    return (
        f"the pull-off force of {with_unit(pull_off_force, 'nN')} is a lower bound, as "
        f"the tip is pulled by {with_unit(-turn.normal_force, 'nN')} at the turn, at a "
        f"penetration of {with_unit(turn.penetration, 'Å')}: go deeper before the "
        "retraction"
    )
