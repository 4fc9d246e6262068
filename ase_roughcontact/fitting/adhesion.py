r"""Least-squares fit of an adhesive sphere to the retraction of a force curve.

In contact the force N at the depth d follows from the theory of Johnson, Kendall and
Roberts (JKR) or of Derjaguin, Muller and Toporov (DMT), with the contact modulus E*,
the work of adhesion w and the radius R of the sphere; see `ase_roughcontact.theory`.
Forces are compared at the measured heights of the base, as in
`ase_roughcontact.fitting.indentation`; after the measured pull-off the tip is free. The
last points before it are not compared, as the force changes there with an infinite
slope. E*, w, the depth at which the surface is touched first, and offset and slope of
the force are fitted.

First values are closed forms. The largest tension gives w. With :math:`P = 6 \pi w R`
and the contact radius :math:`a = a_0 x`, JKR is

.. math:: N = P (x^3 - x^{3/2}), \qquad
          d = \frac{a_0^2}{R} \left(x^2 - \frac{2}{3} x^{1/2}\right), \qquad
          a_0^3 = \frac{9 \pi w R^2}{2 E^*},

so that the depth is linear in a function of the force; DMT is
:math:`d = (3 (N + 2 \pi w R)/(4 E^* \sqrt{R}))^{2/3}`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq, least_squares

from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import FloatArray, lookup, positive
from ase_roughcontact.fitting.force_curve import ForceCurve
from ase_roughcontact.fitting.indentation import (
    IndentationFit,
    fit_indentation,
    fit_warnings,
    wide_contact,
)
from ase_roughcontact.fitting.residual_runs import standard_errors
from ase_roughcontact.theory import DMT, JKR
from ase_roughcontact.theory.indenters import Indenter, Paraboloid, Sphere

#: Theories of adhesive spheres by their names.
THEORIES: dict[str, type[JKR] | type[DMT]] = {"jkr": JKR, "dmt": DMT}
# Range of the attraction for Tabor's parameter (Å), a typical one.
_TYPICAL_RANGE = 1.65
# Tabor's parameter above which DMT, and below which JKR, is doubtful.
_TABOR_TRANSITION = 1.0
# Largest contact radius of the theory, relative to the radius after Hertz.
_MAX_RADIUS_OF_HERTZ = 2.0
# Number of contact radii at which the theory is tabulated.
_TABULATED_RADII = 600
# Relative widening of the ends of an interval, by more than rounding.
_ABOVE_ROUNDING = 1e-9
# Change of the unknowns for differences.
_DIFFERENCE_STEP = 1e-6
# Number of points before the pull-off that are not compared.
_SKIPPED_BEFORE_PULL_OFF = 2
# Least number of points in contact.
_MIN_POINTS = 10


@dataclass(frozen=True, eq=False, kw_only=True)
class AdhesionFit(IndentationFit):
    """Result of `fit_adhesion`; see also `IndentationFit`.

    Attributes
    ----------
    theory : JKR or DMT
        Theory with the fitted parameters.
    work_of_adhesion_error : float
        Standard error of the work of adhesion by noise (eV/Å^2).
    """

    theory: JKR | DMT
    work_of_adhesion_error: float

    @property
    def work_of_adhesion(self) -> float:
        """Work of adhesion w (eV/Å^2)."""
        return self.theory.work_of_adhesion

    def model(self, indentation: FloatArray) -> FloatArray:
        """Return the forces of the fit at indentations; see `IndentationFit.model`."""
        depth, force = _law(self.theory, float(np.max(indentation)), math.inf)
        return np.interp(indentation, depth, force, left=0.0)

    @property
    def drawn_depths(self) -> tuple[float, float]:
        """Lowest and largest indentation to draw (Å), from before the pull-off on."""
        lowest, deepest = super().drawn_depths
        depth, _ = _law(self.theory, deepest, math.inf)
        return min(lowest, 1.5 * float(depth[0])), deepest

    @property
    def rows(self) -> list[tuple[str, float, float, str]]:
        """Names of parameters, their values and standard errors, and units to print."""
        modulus, *others = super().rows
        work = self.work_of_adhesion, self.work_of_adhesion_error
        return [modulus, ("work_of_adhesion", *work, "J/m²"), *others]


def fit_adhesion(
    curve: ForceCurve, radius: float, theory: str = "jkr", with_slope: bool = True
) -> AdhesionFit:
    """Fit modulus and work of adhesion of a sphere to the retraction of a curve.

    Parameters
    ----------
    curve : ForceCurve
        Curve with a retraction, and the stiffness of the cantilever. Its `saturated`
        points are not compared.
    radius : float
        Radius of the sphere (Å).
    theory : {"jkr", "dmt"}
        Soft and large spheres are described by JKR, stiff and small ones by DMT.
    with_slope : bool
        Whether the free force may have a slope with the height of the base.

    Returns
    -------
    AdhesionFit

    Raises
    ------
    ValueError
        If there is no retraction, no tension above the noise, too few points in
        contact, or the force does not rise with the depth.

    Notes
    -----
    Standard errors are calculated as in `fit_indentation`.
    """
    made = lookup(theory, THEORIES, "theory of adhesion")
    positive(radius=radius)
    part = curve.only("retraction")
    if not part.pull_off_force > 0.0:
        raise ValueError(
            "no adhesion is found: the tension on the retraction is within the noise; "
            "fit without --adhesion"
        )
    model = _Model(part, radius, made, with_slope)
    first = model.first()
    found = least_squares(
        lambda x: model.residuals(model.values(first, x)) / part.noise,
        np.zeros(5 if with_slope else 4),
        x_scale="jac",
        diff_step=_DIFFERENCE_STEP,
    )
    return model.result(model.values(first, found.x), bool(found.success))


def fit_shape(
    curve: ForceCurve,
    indenter: Indenter,
    adhesion: str = "",
    thickness: float = math.inf,
    deepest: float = math.inf,
) -> IndentationFit:
    """Fit an indenter by `fit_indentation`, or a sphere by `fit_adhesion`.

    Parameters
    ----------
    curve, thickness, deepest
        See `fit_indentation`.
    indenter : Indenter
        Indenter with lengths in Å.
    adhesion : str
        Theory of adhesion, see `fit_adhesion`; empty for a fit without adhesion.

    Returns
    -------
    IndentationFit or AdhesionFit

    Raises
    ------
    ValueError
        If an adhesive indenter is not a sphere, or a thickness or a largest indentation
        is given for it; see also the two functions.
    """
    if not adhesion:
        return fit_indentation(curve, indenter, thickness, deepest)
    radius = checked_sphere(indenter, adhesion, thickness, deepest)
    return fit_adhesion(curve, radius, adhesion)


def checked_sphere(
    indenter: Indenter, adhesion: str, thickness: float, deepest: float
) -> float:
    """Return the radius of an adhesive sphere (Å).

    Parameters
    ----------
    indenter, adhesion, thickness, deepest
        See `fit_shape`.

    Raises
    ------
    ValueError
        If the indenter is not a sphere, the theory is unknown, or a thickness or a
        largest indentation is given.
    """
    lookup(adhesion, THEORIES, "theory of adhesion")
    if not isinstance(indenter, Paraboloid | Sphere):
        raise ValueError(
            f"a fit of adhesion needs a sphere, got a {indenter.name}: give --indenter "
            '"sphere 5 um", or leave out --adhesion'
        )
    if not math.isinf(thickness + deepest):
        raise ValueError(
            "a fit of adhesion takes the whole retraction on a half space: leave out "
            "--thickness and --deepest"
        )
    return indenter.tip_radius


class _Model:
    """Forces of an adhesive sphere at the measured heights of the base.

    The unknowns are the contact modulus, the work of adhesion, the depth at which the
    surface is touched first, and offset and slope of the force, in ASE's units.
    """

    def __init__(
        self,
        curve: ForceCurve,
        radius: float,
        theory: type[JKR] | type[DMT],
        with_slope: bool,
    ) -> None:
        self._curve, self._radius, self._theory = curve, radius, theory
        self._height = curve.base - curve.base.max()
        self._count = 5 if with_slope else 4
        jump = curve.branches[0].jump
        last = int(np.argmin(curve.force)) if jump is None else jump
        self._in_contact = np.arange(len(curve.force)) <= last
        self.compared = ~curve.saturated
        self.compared[max(last + 1 - _SKIPPED_BEFORE_PULL_OFF, 0) : last + 2] = False
        if last + 1 < _MIN_POINTS:
            raise ValueError(
                f"a fit of adhesion needs at least {_MIN_POINTS} points before the "
                f"pull-off, got {last + 1}: measure more points"
            )

    def values(self, first: FloatArray, x: FloatArray) -> FloatArray:
        """Return the unknowns for changes x of first values, relative to their sizes.

        Modulus and work of adhesion are positive: x has changes of their logarithms.
        """
        x = np.append(x, np.zeros(5 - len(x)))
        scales = self._scales(first)
        return np.append(first[:2] * np.exp(x[:2]), first[2:] + x[2:] * scales[2:])

    def _scales(self, values: FloatArray) -> FloatArray:
        """Return typical sizes of the unknowns."""
        force, extent = float(np.ptp(self._curve.force)), float(np.ptp(self._height))
        return np.array([*values[:2], extent, force, force / extent])

    def theory(self, values: FloatArray) -> JKR | DMT:
        """Return the theory for some unknowns."""
        return self._theory(self._radius, float(values[0]), float(values[1]))

    def forces(self, values: FloatArray) -> FloatArray:
        """Return the forces for some unknowns."""
        _, _, contact, offset, slope = values
        # where the tip of a straight cantilever would be
        below = -self._curve.base - contact
        deepest = max(float(below.max()), _DIFFERENCE_STEP * float(np.ptp(below)))
        stiffness = self._curve.stiffness
        depth, force = _law(self.theory(values), deepest, stiffness)
        pressed = np.interp(below, depth + force / stiffness, force)
        return offset + slope * self._height + np.where(self._in_contact, pressed, 0.0)

    def residuals(self, values: FloatArray) -> FloatArray:
        """Return the residuals of the compared points for some unknowns."""
        return (self.forces(values) - self._curve.force)[self.compared]

    def first(self) -> FloatArray:
        """Return first values by closed forms."""
        curve, R = self._curve, self._radius
        offset = curve.far_force
        known = self._in_contact & ~curve.saturated
        force = curve.force[known] - offset
        depth = curve.depth[known] + offset / curve.stiffness
        tension = curve.pull_off_force
        if self._theory is JKR:
            work = tension / (1.5 * math.pi * R)
            root = np.sqrt(np.maximum(0.25 + force / (4.0 * tension), 0.0))
            x = (0.5 + root) ** (2.0 / 3.0)
            reduced = x**2 - 2.0 / 3.0 * np.sqrt(x)
        else:
            work = tension / (2.0 * math.pi * R)
            reduced = np.maximum(force + tension, 0.0) ** (2.0 / 3.0)
        scale, contact = np.polyfit(reduced, depth, 1)
        if not scale > 0.0:
            raise ValueError(
                "the tip does not go deeper with the force: the sample is too stiff "
                "for this cantilever, or the sensitivity is wrong"
            )
        if self._theory is JKR:
            modulus = 4.5 * math.pi * work * R**2 / (scale * R) ** 1.5
        else:
            modulus = 0.75 / (math.sqrt(R) * scale**1.5)
        return np.array([modulus, work, contact, offset, 0.0])

    def result(self, values: FloatArray, converged: bool) -> AdhesionFit:
        """Return the fit of some values of the unknowns."""
        curve = self._curve
        scales = self._scales(values)[: self._count]
        changes = _DIFFERENCE_STEP * np.diag(self._scales(values))[: self._count]
        residual = self.residuals(values)
        slopes = [
            self.residuals(values + change) - self.residuals(values - change)
            for change in changes
        ]
        jacobian = np.transpose(slopes) / (2.0 * _DIFFERENCE_STEP)
        errors = scales * standard_errors(jacobian, residual)
        degrees = max(len(residual) - self._count, 1)
        fit = AdhesionFit(
            indenter=Paraboloid(self._radius),
            thickness=math.inf,
            contact_modulus=float(values[0]),
            contact_modulus_error=float(errors[0]),
            contact_depth=float(values[2]),
            contact_depth_error=float(errors[2]),
            force_offset=float(values[3]),
            force_slope=float(values[4]),
            curve=curve,
            compared=self.compared,
            fitted=self.forces(values),
            noise=math.sqrt(float(residual @ residual) / degrees),
            converged=converged,
            theory=self.theory(values),
            work_of_adhesion_error=float(errors[1]),
        )
        advice = "JKR and DMT are not exact there, press less"
        warnings = wide_contact(fit, advice) + fit_warnings(fit) + _wrong_theory(fit)
        return replace(fit, warnings=tuple(warnings))


def _law(
    theory: JKR | DMT, deepest: float, stiffness: float
) -> tuple[FloatArray, FloatArray]:
    """Return depths and forces of stable contacts, from the pull-off on.

    The radii are closer near the pull-off, where the force changes as the square root
    of the height of the base.
    """
    least = _pull_off_radius(theory, stiffness)
    largest = _MAX_RADIUS_OF_HERTZ * math.sqrt(theory.radius * max(deepest, 0.0))
    largest += float(theory.contact_radius(0.0))
    radius = least + (largest - least) * np.linspace(0.0, 1.0, _TABULATED_RADII) ** 2
    return theory.penetration(radius), theory.force(radius)


def _pull_off_radius(theory: JKR | DMT, stiffness: float) -> float:
    """Return the contact radius at which d + N/k is least: zero for DMT.

    For JKR it lies between the radii at the pull-off under displacement and load
    control, a^3 = pi w R^2/8E* and nine times as much.
    """
    if isinstance(theory, DMT):
        return 0.0
    E, w, R = theory.contact_modulus, theory.work_of_adhesion, theory.radius
    ends = np.cbrt(np.array([1.0, 9.0]) * math.pi * w * R**2 / (8.0 * E))

    def slope(a: float) -> float:
        depth = 2.0 * a / R - math.sqrt(math.pi * w / (2.0 * E * a))
        force = 4.0 * E * a**2 / R - 3.0 * math.sqrt(2.0 * math.pi * w * E * a)
        return depth + force / stiffness

    low = float(ends[0]) * (1.0 - _ABOVE_ROUNDING)
    high = float(ends[1]) * (1.0 + _ABOVE_ROUNDING)
    return float(brentq(slope, low, high, xtol=1e-12 * high))


def _wrong_theory(fit: AdhesionFit) -> list[str]:
    """Return a warning if Tabor's parameter is in the range of the other theory."""
    theory = fit.theory
    ratio = theory.work_of_adhesion / theory.contact_modulus
    parameter = float(np.cbrt(theory.radius * ratio**2 / _TYPICAL_RANGE**3))
    is_jkr = isinstance(theory, JKR)
    if is_jkr == (parameter > _TABOR_TRANSITION):
        return []
    other = "dmt" if is_jkr else "jkr"
    typical = _TYPICAL_RANGE / UNITS["nm"]
    return [
        f"Tabor's parameter is {parameter:.2g} with a typical range of {typical:.3g} "
        f"nm: --adhesion {other} describes such a contact"
    ]
