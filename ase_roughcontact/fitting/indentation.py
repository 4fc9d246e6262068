r"""Least-squares fit of an indenter of simple shape to a measured force curve.

The tip touches the surface at the depth :math:`d_0` and is pressed with the force
:math:`N(d - d_0) = E^* n(d - d_0)` of `ase_roughcontact.theory.indenters`; before the
contact the force is zero. As the noise is in the deflection of the cantilever, forces
are compared at the measured heights of the base, :math:`D = -d - N/k`. To the force
are added an offset and a slope with the height of the base. All four are fitted; a
scan of the contact point, with the others by linear least squares, gives the first
values.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from ase_roughcontact._util.printing import Printed, number, table
from ase_roughcontact._util.summary import Summarized
from ase_roughcontact._util.units import UNITS, pressure_unit
from ase_roughcontact._util.validation import FloatArray
from ase_roughcontact.fitting.force_curve import ForceCurve
from ase_roughcontact.fitting.residual_runs import (
    standard_errors,
    systematic_residuals,
)
from ase_roughcontact.theory.indenters import Indenter, Paraboloid

# Number of contact points that are tried first.
_TRIED_CONTACTS = 60
# Number of depths at which the model is tabulated.
_TABULATED_DEPTHS = 1000
# Smallest number of points in contact, and before it.
_MIN_POINTS = 5
# Largest number of times that the compared points are chosen anew.
_MAX_SELECTIONS = 10
# Change of parameters for derivatives, relative to their scale.
_DIFFERENCE_STEP = 1e-6
# Smallest range of the forces relative to their noise that shows a contact.
_MIN_FORCE_RANGE = 10.0
# Range before the contact that is drawn, relative to the largest indentation.
_DRAWN_BEFORE_CONTACT = 0.3
# Largest contact radius of a paraboloid, relative to its radius.
_MAX_CONTACT_RADIUS = 0.3


@dataclass(frozen=True, eq=False)
class IndentationFit(Summarized, Printed):
    """Result of `fit_indentation`.

    Attributes
    ----------
    indenter : Indenter
        Fitted indenter, with lengths in Å.
    thickness : float
        Thickness of the layer (Å); infinite for a half space.
    contact_modulus, contact_modulus_error : float
        E* and its standard error by noise (eV/Å^3).
    contact_depth, contact_depth_error : float
        Depth of the tip at the contact point, as in the curve without the baseline, and
        its standard error (Å).
    force_offset, force_slope : float
        Force of a free tip with the base at its highest point (eV/Å), and its slope
        with the height of the base (eV/Å^2).
    curve : ForceCurve
        Measured branch.
    compared : ndarray of bool, shape (k,)
        Points that are compared with the fit.
    fitted : ndarray, shape (k,)
        Forces of the fit, with the baseline (eV/Å).
    noise : float
        Standard deviation of the residuals of the compared points (eV/Å).
    converged : bool
        Whether the least-squares solution has converged.
    warnings : tuple of str
        Reasons to doubt the fit.
    """

    indenter: Indenter
    thickness: float
    contact_modulus: float
    contact_modulus_error: float
    contact_depth: float
    contact_depth_error: float
    force_offset: float
    force_slope: float
    curve: ForceCurve
    compared: np.ndarray
    fitted: FloatArray
    noise: float
    converged: bool
    warnings: tuple[str, ...] = ()

    @property
    def baseline(self) -> FloatArray:
        """Force of a free tip at the points, shape (k,) (eV/Å)."""
        base = self.curve.base
        return self.force_offset + self.force_slope * (base - base.max())

    @property
    def indentation(self) -> FloatArray:
        """Depth below the contact point without the baseline, shape (k,) (Å)."""
        return self.curve.less(self.baseline).depth - self.contact_depth

    @property
    def force(self) -> FloatArray:
        """Measured forces without the baseline, shape (k,) (eV/Å)."""
        return self.curve.force - self.baseline

    def model(self, indentation: FloatArray) -> FloatArray:
        """Return the forces of the fit at indentations, without the baseline.

        Parameters
        ----------
        indentation : ndarray
            Depths below the contact point (Å).

        Returns
        -------
        ndarray
            Normal forces (eV/Å).
        """
        shape = self.indenter.force_on_layer(indentation, self.thickness)
        return self.contact_modulus * shape

    @property
    def drawn_depths(self) -> tuple[float, float]:
        """Lowest and largest indentation to draw (Å)."""
        deepest = float(self.indentation[self.compared].max())
        return -_DRAWN_BEFORE_CONTACT * deepest, deepest

    @property
    def rows(self) -> list[tuple[str, float, float, str]]:
        """Names of parameters, their values and standard errors, and units to print."""
        unit = pressure_unit(self.contact_modulus)
        deepest = float(self.indentation[self.compared].max())
        radius = float(self.indenter.radius(deepest))
        modulus = self.contact_modulus, self.contact_modulus_error
        return [
            ("contact_modulus", *modulus, unit),
            ("contact_depth", self.contact_depth, self.contact_depth_error, "nm"),
            ("force_offset", self.force_offset, math.nan, "nN"),
            ("largest indentation", deepest, math.nan, "nm"),
            ("largest contact radius", radius, math.nan, "nm"),
            ("noise", self.noise, math.nan, "nN"),
        ]

    @property
    def parts(self) -> list[object]:
        """Parameters with standard errors, and warnings."""
        rows = [
            [name, number(value / UNITS[unit], 5), number(error / UNITS[unit], 2), unit]
            for name, value, error, unit in self.rows
        ]
        failed = () if self.converged else ("NOT CONVERGED",)
        heads = [self.indenter.name, "value", "± error", "unit"]
        warned = (f"warning: {warning}" for warning in self.warnings)
        return [*failed, table(heads, rows, left=1), *warned]


def fit_indentation(
    curve: ForceCurve,
    indenter: Indenter,
    thickness: float = math.inf,
    deepest: float = math.inf,
    with_slope: bool = True,
) -> IndentationFit:
    """Fit modulus and contact point of an indenter to one branch of a curve.

    Parameters
    ----------
    curve : ForceCurve
        Curve with the stiffness of the cantilever, infinite if the depth is prescribed.
        If it has two branches, the approach is fitted. Its `saturated` points are not
        compared.
    indenter : Indenter
        Indenter with lengths in Å.
    thickness : float
        Thickness of an incompressible layer that is bonded to a rigid base (Å).
    deepest : float
        Largest indentation that is compared (Å).
    with_slope : bool
        Whether the free force may have a slope with the height of the base.

    Returns
    -------
    IndentationFit

    Raises
    ------
    ValueError
        If there are too few points before the contact or in it, or the theory has no
        formula for the layer.

    Notes
    -----
    Standard errors follow from the linearised problem. Correlated residuals of
    neighbouring points count as fewer points: as many as in white noise with the same
    number of changes of sign.
    """
    part = curve.only("approach" if curve.branches[0].direction < 0.0 else "retraction")
    model = _Model(part, indenter, thickness, with_slope)
    compared = ~part.saturated
    values, converged = model.solve(compared, model.first(compared))
    chosen = ~part.saturated & (model.below(values) <= deepest)
    for _ in range(_MAX_SELECTIONS):
        if np.array_equal(chosen, compared):
            break
        compared = chosen
        values, converged = model.solve(compared, values)
        chosen = ~part.saturated & (model.below(values) <= deepest)
    return model.result(values, compared, converged)


class _Model:
    """Forces of an indenter at the measured heights of the base.

    The unknowns are the contact modulus, the depth at the contact point, offset and
    slope of the force, in ASE's units.
    """

    def __init__(
        self,
        curve: ForceCurve,
        indenter: Indenter,
        thickness: float,
        with_slope: bool,
    ) -> None:
        self._count = 4 if with_slope else 3
        self._curve, self._indenter, self._thickness = curve, indenter, thickness
        self._height = curve.base - curve.base.max()
        self._extent = float(np.ptp(curve.depth))

    def forces(self, values: FloatArray) -> FloatArray:
        """Return the forces for some unknowns."""
        modulus, contact, offset, slope = values
        baseline = offset + slope * self._height
        # where the tip of a straight cantilever would be, below the contact point
        below = -self._curve.base - contact
        largest = max(float(below.max()), 1e-12 * self._extent)
        # closer near the contact, where the force begins
        depth = largest * np.linspace(0.0, 1.0, _TABULATED_DEPTHS) ** 2
        force = modulus * self._indenter.force_on_layer(depth, self._thickness)
        along = depth + force / self._curve.stiffness
        return baseline + np.where(below > 0.0, np.interp(below, along, force), 0.0)

    def first(self, compared: np.ndarray) -> FloatArray:
        """Return first values from a scan of the contact point."""
        depth, force = self._curve.depth[compared], self._curve.force[compared]
        height = self._height[compared]
        order = np.sort(depth)
        if len(order) < 2 * _MIN_POINTS:
            raise ValueError(
                f"an indentation fit needs at least {2 * _MIN_POINTS} points, got "
                f"{len(order)}: give a longer curve, or a larger depth"
            )
        low, high = order[_MIN_POINTS - 1], order[-_MIN_POINTS]
        best, least = None, math.inf
        for contact in np.linspace(low, high, _TRIED_CONTACTS, endpoint=False):
            shape = self._indenter.force_on_layer(depth - contact, self._thickness)
            columns = np.column_stack([shape, np.ones_like(depth), height])
            columns = columns[:, : self._count - 1]
            scales = np.maximum(abs(columns).max(axis=0), 1e-300)
            found, *_ = np.linalg.lstsq(columns / scales, force, rcond=None)
            found = found / scales
            squares = float(np.sum((columns @ found - force) ** 2))
            if found[0] > 0.0 and squares < least:
                best, least = np.insert(found, 1, contact), squares
        rises = np.ptp(force) > _MIN_FORCE_RANGE * self._curve.noise
        if best is None or not rises:
            raise ValueError(
                "no contact is found: the force does not rise with the depth; look at "
                "the curve as it was read, and at its direction"
            )
        best[1] += best[2] / self._curve.stiffness  # without the baseline
        return np.append(best, np.zeros(4 - self._count))

    def below(self, values: FloatArray) -> FloatArray:
        """Return the depths below the contact point for some unknowns."""
        _, contact, offset, slope = values
        baseline = offset + slope * self._height
        return self._curve.less(baseline).depth - contact

    def solve(self, compared: np.ndarray, first: FloatArray) -> tuple[FloatArray, bool]:
        """Return the least-squares values, and whether they have converged."""
        scales = self._scales(first)[1:]
        force = self._curve.force[compared]

        def values(x: FloatArray) -> FloatArray:
            x = np.append(x, np.zeros(4 - self._count))
            return np.append(first[0] * math.exp(x[0]), x[1:] * scales)

        def residuals(x: FloatArray) -> FloatArray:
            return (self.forces(values(x))[compared] - force) / self._curve.noise

        start = np.append(0.0, first[1:] / scales)[: self._count]
        found = least_squares(
            residuals, start, x_scale="jac", diff_step=_DIFFERENCE_STEP
        )
        return values(found.x), bool(found.success)

    def _scales(self, values: FloatArray) -> FloatArray:
        """Return typical sizes of the unknowns."""
        force = float(np.ptp(self._curve.force))
        extent = float(np.ptp(self._height))
        return np.array([values[0], self._extent, force, force / extent])

    def result(
        self, values: FloatArray, compared: np.ndarray, converged: bool
    ) -> IndentationFit:
        """Return the fit of some values of the unknowns."""
        fitted = self.forces(values)
        scales = self._scales(values)
        rows = []
        for i, scale in enumerate(scales[: self._count]):
            change = _DIFFERENCE_STEP * scale * np.eye(len(values))[i]
            slopes = self.forces(values + change) - self.forces(values - change)
            rows.append(slopes[compared] / (2.0 * _DIFFERENCE_STEP))
        residual = (fitted - self._curve.force)[compared]
        degrees = max(len(residual) - self._count, 1)
        noise = math.sqrt(float(residual @ residual) / degrees)
        errors = scales[: self._count] * standard_errors(np.transpose(rows), residual)
        fit = IndentationFit(
            self._indenter,
            self._thickness,
            float(values[0]),
            float(errors[0]),
            float(values[1]),
            float(errors[1]),
            float(values[2]),
            float(values[3]),
            self._curve,
            compared,
            fitted,
            noise,
            converged,
        )
        advice = 'give --indenter "sphere ..."'
        warnings = _few_points(fit) + wide_contact(fit, advice) + fit_warnings(fit)
        return replace(fit, warnings=tuple(warnings))


def _few_points(fit: IndentationFit) -> list[str]:
    """Return a warning if there are few points before the contact or in it."""
    inside = fit.indentation[fit.compared]
    before, within = int(np.sum(inside <= 0.0)), int(np.sum(inside > 0.0))
    if min(before, within) >= _MIN_POINTS:
        return []
    where = "before" if before < within else "in"
    return [
        f"only {min(before, within)} points are {where} contact, so that the contact "
        "point is not determined: measure a longer ramp"
    ]


def wide_contact(fit: IndentationFit, advice: str) -> list[str]:
    """Return a warning, with advice, if a contact is wide for a paraboloid."""
    if not isinstance(fit.indenter, Paraboloid):
        return []
    tip = fit.indenter.tip_radius
    radius = float(fit.indenter.radius(fit.indentation[fit.compared].max()))
    if radius < _MAX_CONTACT_RADIUS * tip:
        return []
    return [
        f"the contact radius is {radius / tip:.2g} of the radius of the paraboloid: "
        f"{advice}"
    ]


def fit_warnings(fit: IndentationFit) -> list[str]:
    """Return reasons to doubt a fit."""
    warnings = []
    if fit.curve.saturated.any():
        warnings.append(
            f"{fit.curve.saturated.sum()} points with a saturated force are not "
            "compared"
        )
    deepest = float(fit.indentation[fit.compared].max())
    if 3.0 * fit.contact_modulus_error > fit.contact_modulus:
        warnings.append("the modulus is not larger than three standard errors")
    length = float(fit.indenter.layer_length(deepest))
    if length > fit.indenter.layer_limit * fit.thickness:
        warnings.append(
            f"the contact reaches {length / fit.thickness:.2g} thicknesses of the "
            f"layer, the formula holds up to {fit.indenter.layer_limit:g}: limit the "
            "depth, or fit a scene with layer_thickness"
        )
    residual = (fit.fitted - fit.curve.force)[fit.compared]
    largest = float(fit.force[fit.compared].max())
    warnings += systematic_residuals(residual, fit.curve.noise, largest)
    return warnings
