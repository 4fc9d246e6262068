"""Least-squares fit of a measured force curve by relaxed states of a scene."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import FloatArray, lookup
from ase_roughcontact.fitting.force_curve import BASELINE, ForceCurve
from ase_roughcontact.fitting.least_squares import FAR_ABOVE, Callback, Fit, solve
from ase_roughcontact.fitting.parameters import FREE
from ase_roughcontact.fitting.residual_runs import MIN_SIGNIFICANCE
from ase_roughcontact.fitting.residuals import Residuals
from ase_roughcontact.scene.scene import Scene

# Changes of signs: columns with another sign, and factors of the heights of the base
# and of the forces.
_SIGN_CHANGES = (
    ("", 1.0, 1.0),
    ("the force", 1.0, -1.0),
    ("the distance", -1.0, 1.0),
    ("force and distance", -1.0, -1.0),
)
# Largest ratio of the mean square residuals after and before a change of sign, at which
# the sign was wrong.
_MAX_RATIO_AFTER_CHANGE = 0.1
# Largest residual of the height of the base at a jump without a warning, less the error
# by the grid, relative to its standard error: 1.7 is half a step of the base.
_MAX_JUMP_RESIDUAL = 4.0
# Largest distance of the points at a jump, relative to other points, that is not a gap.
_MAX_RELATIVE_DISTANCE = 5.0


def fit_curve(
    scene: Scene,
    curve: ForceCurve,
    free: Sequence[str] = ("work_of_adhesion",),
    callback: Callback | None = None,
) -> Fit:
    """Fit parameters of a scene to a measured force curve.

    Parameters
    ----------
    scene : Scene
        Scene with initial values of the free parameters, and the fixed ones. Its path
        is not used, except for the `tolerance`.
    curve : ForceCurve
        Approach, retraction, or both; with the stiffness of the cantilever if the tip
        snaps in or is pulled off.
    free : sequence of str
        Parameters of the scene among `FREE`, and of the measured forces among
        `BASELINE`: ``force_offset``, the force that the instrument shows for a free
        tip with the base at its highest point, and ``force_slope``, the slope of this
        force with the height of the base.
    callback : callable, optional
        Called after each trial with the parameters by name, in the units of the fit,
        and the root mean square of the residuals relative to the noise.

    Returns
    -------
    Fit

    Raises
    ------
    ValueError
        If a parameter is unknown, there are too few points, or the wall of the scene
        has no work of adhesion that could be fitted.

    Notes
    -----
    Standard errors and correlations follow from the linearised problem. The standard
    deviation of the data is estimated by the residuals. Two assumptions of the scene
    add to the errors. The range of the attraction, which a force curve hardly shows,
    has a standard uncertainty of a factor of two. Its effects on either branch, the
    snap-in and the pull-off are added without their signs, as the signs depend on the
    form of the attraction. The error by the grid follows from the change of the forces
    on a grid of half the spacing, for which the last trial is repeated.
    """
    for name in free:
        lookup(name, {**FREE, **BASELINE}, "free parameter")
    if len(curve.depth) < len(free) + 2:
        raise ValueError(
            f"a fit of {len(free) + 1} parameters needs at least {len(free) + 2} "
            f"points, got {len(curve.depth)}"
        )
    if "work_of_adhesion" in free and not scene.wall.attractive:
        raise ValueError(
            "work_of_adhesion can't be fitted, as the wall of the scene only repels: "
            'give [interaction] kind = "adhesive", or other free parameters'
        )
    if curve.doubt_of_sign and (wrong := _wrong_sign(scene, curve, free)):
        advice = f"Change the sign of {wrong}: the first trial is closer"
        raise ValueError(f"{curve.doubt_of_sign} {advice}")
    for doubt in curve.doubts:
        warnings.warn(doubt, stacklevel=2)
    try:
        model = Residuals(scene, curve, free)
        fit, trial, changes = solve(model, callback)
    except (ValueError, RuntimeError) as error:
        if not curve.doubts:
            raise
        message = f"{curve.doubts[0]} The fit ended with: {error}"
        raise ValueError(message) from error
    fit = replace(fit, far_force=curve.far_force, line=model.line(trial))
    size = np.maximum(abs(trial.residuals) - abs(changes["grid"][:, 0]), 0.0)
    jump_residuals = (np.sign(trial.residuals) * size)[-2:]
    doubts = [*fit.warnings, *curve.doubts]
    doubts += _warnings(curve, fit, model.error)
    doubts += _jump_warnings(curve, jump_residuals, trial.compared[-2:])
    return replace(fit, warnings=tuple(doubts))


def _wrong_sign(scene: Scene, curve: ForceCurve, free: Sequence[str]) -> str:
    """Return which columns have the wrong sign, by a trial of each; may be empty."""
    misfits = {}
    for name, base_factor, force_factor in _SIGN_CHANGES:
        base, force = base_factor * curve.base, force_factor * curve.force
        with suppress(ValueError, RuntimeError):
            turned = ForceCurve(-base - force / curve.stiffness, force, curve.stiffness)
            model = Residuals(scene, turned, free)
            trial = model.trial(model.start)
            misfits[name] = float(np.mean(trial.residuals[trial.compared] ** 2))
    best = min(misfits, key=misfits.__getitem__, default="")
    limit = _MAX_RATIO_AFTER_CHANGE * misfits.get("", math.inf)
    return best if best and misfits[best] < limit else ""


def _warnings(curve: ForceCurve, fit: Fit, force_error: float) -> Iterator[str]:
    """Yield warnings of forces outside of the model, and of a missing baseline."""
    nN, nm = UNITS["nN"], UNITS["nm"]
    runs = _systematic(curve, fit.fitted - curve.force, fit.compared)
    mean, points, sigmas = max(runs, key=lambda each: each[2])
    if sigmas > MIN_SIGNIFICANCE and abs(mean) > force_error:
        first, last = sorted(curve.base[points[[0, -1]]] / nm)
        yield (
            f"the fit is {mean / nN:+.3g} nN off on {len(points)} points in a "
            f"row, with the base at {first:.4g} to {last:.4g} nm: fit a baseline "
            "(force_offset, force_slope) or another wall, or leave out other forces, "
            "such as capillary forces; the errors do not contain this"
        )
    error = fit.noise / math.sqrt(len(curve.far))
    is_free = abs(fit.fitted[curve.far]).max() < curve.noise
    is_off = abs(curve.far_force) > FAR_ABOVE * error
    if is_free and is_off and "force_offset" not in fit.names:
        yield (
            f"the free part of the curve is at {curve.far_force / nN:.3g} nN, not "
            "zero: give force_offset in --free, too"
        )


def _systematic(
    curve: ForceCurve, residual: FloatArray, kept: np.ndarray
) -> Iterator[tuple[float, np.ndarray, float]]:
    """Yield mean, points and significance of residuals of one sign in a row."""
    for branch in curve.branches:
        points = np.arange(len(residual))[branch.points][kept[branch.points]]
        changes = np.flatnonzero(np.diff(np.sign(residual[points])))
        for part in np.split(points, changes + 1):
            mean = float(residual[part].mean()) if part.size else 0.0
            yield mean, part, abs(mean) * math.sqrt(part.size) / curve.noise


def _jump_warnings(
    curve: ForceCurve, residuals: FloatArray, compared: np.ndarray
) -> Iterator[str]:
    """Yield warnings of jumps in a gap of the points, or far from the measured jump."""
    for branch, residual, known in zip(
        curve.branches, residuals, compared, strict=False
    ):
        name = "snap-in" if branch.direction < 0.0 else "pull-off"
        base = curve.base[branch.points] / UNITS["nm"]
        steps = abs(np.diff(base))
        if known and steps[branch.jump] > _MAX_RELATIVE_DISTANCE * np.median(steps):
            first, last = sorted(base[branch.jump :][:2])
            yield (
                f"the {name} is in a gap of the measured points, with the base at "
                f"{first:.4g} to {last:.4g} nm: no fit can locate it more precisely"
            )
        if abs(residual) > _MAX_JUMP_RESIDUAL:
            side = "above" if residual > 0.0 else "below"
            instead = ""
            if branch.direction < 0.0 and len(curve.branches) > 1:
                instead = "; or fit the retraction alone: --branch retraction"
            yield (
                f"the {name} of the fit is {abs(residual):.1f} standard errors {side} "
                "the measured one: fit the range of the attraction (--free "
                "attraction_range) or another wall, or leave out a capillary force, "
                "which the work of adhesion would contain; the errors do not contain "
                f"this{instead}"
            )
