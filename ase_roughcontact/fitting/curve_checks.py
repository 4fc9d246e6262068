"""Checks of a measured force curve before a fit."""

from __future__ import annotations

import math

import numpy as np

from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import FloatArray
from ase_roughcontact.fitting.force_curve import (
    FORCE_ROUNDING,
    ForceCurve,
    MeasuredBranch,
)

# Smallest reported difference of free forces, relative to the noise.
_MIN_NOISE_RATIO = 5.0
# Smallest reported difference of free forces, relative to the range of the forces.
_MIN_RANGE_RATIO = 0.05
# Smallest number of values of a clipped baseline: fewer are steps of a digital signal.
_MIN_VALUES = 5
# Part of the second differences with another sign than the one before, above which they
# are noise.
_MIN_SIGN_CHANGES = 1.0 / 3.0
# Part of the base of a branch, furthest from the surface, where the tip is free.
_FREE_PART = 0.2
# Largest change of the force of a free tip at the slope of the furthest tenth, relative
# to the range of the forces of the branch.
_MAX_FREE_CHANGE = 0.5
# Smallest force of a tip that is well in contact, relative to the largest force.
_MIN_LOADED_FORCE = 0.5
# Largest slope of the deflection with the base, by a sensitivity that is not too large.
_MAX_DEFLECTION_SLOPE = 1.03
# Smallest number of points to which a slope is fitted.
_MIN_POINTS = 10


def curve_checks(curve: ForceCurve) -> list[str]:
    """Return warnings about a curve, with advice.

    Parameters
    ----------
    curve : ForceCurve

    Returns
    -------
    list of str
        Warnings of saturated deflections, a clipped baseline, free forces that differ
        between the branches or drift, a missing free part, a deflection that changes
        more than the base, and the `doubts` of the curve; empty without any.
    """
    checks = [*curve.doubts, *_saturated(curve)]
    branches = [branch for branch in curve.branches if _count(branch) > _MIN_POINTS]
    for branch in branches:
        checks += _steep_deflection(curve, branch)
        checks += _clipped_baseline(curve, branch)
    missing = [line for branch in branches for line in _not_free(curve, branch)]
    return checks + (missing or _baseline(curve, branches))


def deflection_slope(curve: ForceCurve, branch: MeasuredBranch) -> float:
    """Return the change of the deflection over the change of the base under load.

    It is one on a rigid sample, if the sensitivity is right.

    Parameters
    ----------
    curve : ForceCurve
    branch : MeasuredBranch
        Branch of the curve.

    Returns
    -------
    float
        Slope where the force exceeds half of its largest value; NaN if there are less
        than ten points, or the stiffness of the cantilever is not known.
    """
    base, force = curve.base[branch.points], curve.force[branch.points]
    load = force - curve.far_force
    loaded = load > _MIN_LOADED_FORCE * load.max()
    few = loaded.sum() < _MIN_POINTS or not np.ptp(base[loaded]) > 0.0
    if few or math.isinf(curve.stiffness):
        return math.nan
    return -_slope(base[loaded], force[loaded]) / curve.stiffness


def contact_point(curve: ForceCurve) -> int | None:
    """Return the point of the first branch where the force leaves the baseline.

    Parameters
    ----------
    curve : ForceCurve

    Returns
    -------
    int or None
        Number of the point; None if the force stays within the noise of the free tip.
    """
    branch = curve.branches[0]
    numbers = np.arange(branch.points.start, branch.points.stop)
    inward = numbers if branch.direction < 0.0 else numbers[::-1]
    free = max(int(_FREE_PART * len(inward)), 2)
    base, force = curve.base[inward], curve.force[inward]
    middle = float(base[:free].mean())
    line = np.polyfit(base[:free] - middle, force[:free], 1)
    off = abs(force - np.polyval(line, base - middle)) > _MIN_NOISE_RATIO * curve.noise
    within = np.flatnonzero(~off)
    after = int(within[-1]) + 1 if within.size else 0
    return int(inward[after]) if after < len(inward) else None


def _count(branch: MeasuredBranch) -> int:
    return branch.points.stop - branch.points.start


def _name(branch: MeasuredBranch) -> str:
    return "approach" if branch.direction < 0.0 else "retraction"


def _saturated(curve: ForceCurve) -> list[str]:
    """Return checks of forces that are all equal at their largest or lowest."""
    checks = []
    high = curve.force > 0.5 * (curve.force.max() + curve.force.min())
    for points in (curve.saturated & high, curve.saturated & ~high):
        if points.any():
            level = float(np.median(curve.force[points])) / UNITS["nN"]
            checks.append(
                f"the force is {level:.4g} nN on {points.sum()} points: the photodiode "
                "seems saturated there; fits of an elastic indenter leave them out"
            )
    return checks


def _steep_deflection(curve: ForceCurve, branch: MeasuredBranch) -> list[str]:
    """Return a check of a deflection that changes more than the height of the base."""
    ratio = deflection_slope(curve, branch)
    if not ratio >= _MAX_DEFLECTION_SLOPE:
        return []
    return [
        f"on the {_name(branch)} the deflection changes by {ratio:.3g} nm per nm of "
        "the base, more than it can: the sensitivity is too large, the spring constant "
        "too small, or another height was read"
    ]


def _clipped_baseline(curve: ForceCurve, branch: MeasuredBranch) -> list[str]:
    """Return a check of free forces that are equal to their lowest value, by a limit.

    Values of a noisy signal are equal on a whole baseline only by a limit.
    """
    _, free = _furthest(curve, branch, _FREE_PART)
    rounding = FORCE_ROUNDING * float(np.ptp(curve.force))
    equal = free <= free.min() + rounding
    is_partly = np.median(free) == free.min() and len(np.unique(free)) >= _MIN_VALUES
    if not (is_partly or (equal.all() and _is_noisy(curve, branch, rounding))):
        return []
    return [
        f"the free force of the {_name(branch)} has its lowest value, "
        f"{free.min() / UNITS['nN']:.4g} nN, on {equal.sum()} of {len(free)} points: "
        "the baseline seems clipped, so that the contact point is wrong; measure with "
        "another offset"
    ]


def _is_noisy(curve: ForceCurve, branch: MeasuredBranch, rounding: float) -> bool:
    """Return whether second differences of the loaded part change their sign often."""
    order = np.argsort(curve.base[branch.points])
    force = curve.force[branch.points][order]
    lowest, highest = force.min(), force.max()
    loaded = force[force > lowest + _MIN_LOADED_FORCE * (highest - lowest)]
    if len(loaded) < _MIN_POINTS:
        return False
    changes = np.diff(loaded, 2)
    signs = np.sign(np.where(abs(changes) > rounding, changes, 0.0))
    return bool(np.mean(signs[1:] != signs[:-1]) > _MIN_SIGN_CHANGES)


def _not_free(curve: ForceCurve, branch: MeasuredBranch) -> list[str]:
    """Return a check of a branch that is in contact where it is furthest away."""
    base, force = _furthest(curve, branch, 0.5 * _FREE_PART)
    change = abs(_slope(base, force)) * float(np.ptp(curve.base[branch.points]))
    if change < _MAX_FREE_CHANGE * np.ptp(curve.force[branch.points]):
        return []
    return [
        f"the force still changes where the base of the {_name(branch)} is highest: "
        "the curve has no free part; measure a longer ramp"
    ]


def _baseline(curve: ForceCurve, branches: list[MeasuredBranch]) -> list[str]:
    """Return checks of free forces that drift, or differ between the branches."""
    checks, free = [], []
    least = max(
        _MIN_NOISE_RATIO * curve.noise, _MIN_RANGE_RATIO * float(np.ptp(curve.force))
    )
    for branch in branches:
        base, force = _furthest(curve, branch, _FREE_PART)
        free.append(float(np.median(force)))
        whole = float(np.ptp(curve.base[branch.points]))
        change = _slope(base, force) * whole
        if abs(change) > least:
            checks.append(
                f"the free force of the {_name(branch)} changes by "
                f"{change / UNITS['nN']:.3g} nN over the ramp: fits of an elastic "
                "indenter contain this slope; for a scene fit force_slope, too"
            )
    if len(free) == 2 and abs(free[0] - free[1]) > least:
        first, last = (f"{force / UNITS['nN']:.3g}" for force in free)
        checks.append(
            f"the free force is {first} nN on the approach and {last} nN on the "
            "retraction: fit them one by one (--branch)"
        )
    return checks


def _furthest(
    curve: ForceCurve, branch: MeasuredBranch, part: float
) -> tuple[FloatArray, FloatArray]:
    """Return bases and forces of the part of a branch furthest from the surface."""
    base, force = curve.base[branch.points], curve.force[branch.points]
    order = np.argsort(base)[-max(int(part * len(base)), _MIN_POINTS) :]
    return base[order], force[order]


def _slope(base: FloatArray, force: FloatArray) -> float:
    """Return the slope of a straight line; zero for a base at one height."""
    centred = base - base.mean()
    squares = float(centred @ centred)
    return float(centred @ force) / squares if squares > 0.0 else 0.0
