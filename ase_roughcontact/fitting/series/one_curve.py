"""Reading and fit of one of many force curves; an error becomes a message."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from ase_roughcontact.fitting.adhesion import AdhesionFit, checked_sphere, fit_shape
from ase_roughcontact.fitting.curve_checks import curve_checks
from ase_roughcontact.fitting.curve_files import read_curve, read_with_times
from ase_roughcontact.fitting.force_curve import ForceCurve, noise_of
from ase_roughcontact.fitting.indentation import IndentationFit
from ase_roughcontact.fitting.relaxation import RelaxationFit, fit_relaxation
from ase_roughcontact.fitting.series.listing import CurveName
from ase_roughcontact.fitting.series.row import SEPARATOR, FittedCurve
from ase_roughcontact.theory.indenters import named_indenter


@dataclass(frozen=True)
class FitSettings:
    """How each of many curves is read and fitted.

    Attributes
    ----------
    indenter : str
        Shape and dimensions, see `named_indenter`; empty if nothing is fitted.
    thickness, deepest : float
        Thickness of a layer, and largest indentation that is compared (Å).
    adhesion : str
        Theory of adhesion, see `fit_adhesion`; empty for a fit without adhesion.
    relaxation : int
        Number of relaxation times of a fit of approach and hold; 0 for an elastic fit.
    branch : str or None
        Branch that is fitted, by default the approach, with adhesion the retraction.
    stiffness, sensitivity, heads
        See `read_curve`.
    """

    indenter: str = ""
    adhesion: str = ""
    relaxation: int = 0
    thickness: float = math.inf
    deepest: float = math.inf
    branch: str | None = None
    stiffness: float | None = None
    sensitivity: str = ""
    heads: tuple[str, ...] = ()

    def check(self) -> None:
        """Raise `ValueError` for settings with which no curve can be fitted."""
        bounded = min(self.thickness, self.deepest) < math.inf
        if not self.indenter:
            if self.adhesion or self.relaxation or bounded:
                raise ValueError(
                    "--adhesion, --relaxation, --thickness and --deepest need the "
                    'shape: --indenter "sphere 5 um"'
                )
            return
        indenter = named_indenter(self.indenter)
        indenter.force_on_layer(0.0, self.thickness)
        if self.adhesion:
            checked_sphere(indenter, self.adhesion, self.thickness, self.deepest)
        if self.adhesion and self.relaxation:
            raise ValueError(
                "adhesion and relaxation are not fitted together: leave out --adhesion "
                "or --relaxation"
            )
        if self.relaxation and (bounded or self.branch is not None):
            raise ValueError(
                "relaxation is fitted to the whole approach and hold on a half space: "
                "leave out --thickness, --deepest and --branch, or --relaxation"
            )


def fitted_curve(settings: FitSettings, name: CurveName) -> FittedCurve:
    """Return the result of a curve; an error becomes its message.

    Parameters
    ----------
    settings : FitSettings
    name : CurveName

    Returns
    -------
    FittedCurve

    Raises
    ------
    ImportError
        If the package that reads the format is missing.
    """
    result = FittedCurve(name.file, name.member, name.number)
    given = settings.stiffness, settings.sensitivity, settings.heads, name.number
    try:
        curve = read_curve(name.file, None, *given)
        result = _measured(result, curve)
        if settings.relaxation:
            time, held = read_with_times(name.file, *given)
            shape = named_indenter(settings.indenter)
            relaxed = fit_relaxation(time, held, shape, settings.relaxation)
            result = _with_relaxation(result, relaxed)
        elif settings.indenter:
            fit = fit_shape(
                curve if settings.branch is None else curve.only(settings.branch),
                named_indenter(settings.indenter),
                settings.adhesion,
                settings.thickness,
                settings.deepest,
            )
            result = _with_fit(result, fit)
    except ImportError:  # no curve of this format can be read
        raise
    except Exception as error:
        # the name of the file is in other columns
        message = str(error).removeprefix(name.file).lstrip(",:/ ")
        message = message.removeprefix(name.member).lstrip(",: ")
        message = message.removeprefix(f"curve {name.number}").lstrip(": ")
        return replace(result, message=message or type(error).__name__)
    return result


def _measured(result: FittedCurve, curve: ForceCurve) -> FittedCurve:
    """Return a result with what is known without a fit."""
    if (place := curve.position) is not None:
        column = -1 if place.column is None else place.column
        row = -1 if place.row is None else place.row
        result = replace(result, x=place.x, y=place.y, column=column, row=row)
    return replace(
        result,
        points=len(curve.force),
        pull_off_force=curve.pull_off_force,
        noise=curve.noise,
        doubts=SEPARATOR.join(curve_checks(curve)),
    )


def _with_relaxation(result: FittedCurve, fit: RelaxationFit) -> FittedCurve:
    """Return a result with the fit of a viscoelastic solid.

    The fit compares averages of neighbouring points, which have less noise.
    """
    doubts = [each for each in (result.doubts, *fit.warnings) if each]
    return replace(
        result,
        contact_modulus=fit.contact_modulus,
        contact_modulus_error=fit.contact_modulus_error,
        instantaneous_modulus=fit.instantaneous_modulus,
        relaxation_moduli=tuple(fit.relaxation_moduli.tolist()),
        relaxation_times=tuple(fit.relaxation_times.tolist()),
        relaxation_times_errors=tuple(fit.relaxation_times_errors.tolist()),
        contact_height=-fit.contact_depth,
        force_offset=fit.force_offset,
        residual=fit.noise,
        noise=noise_of(fit.force),
        converged=fit.converged,
        doubts=SEPARATOR.join(doubts),
    )


def _with_fit(result: FittedCurve, fit: IndentationFit) -> FittedCurve:
    """Return a result with the fit of an indenter."""
    doubts = [each for each in (result.doubts, *fit.warnings) if each]
    if isinstance(fit, AdhesionFit):
        result = replace(
            result,
            work_of_adhesion=fit.work_of_adhesion,
            work_of_adhesion_error=fit.work_of_adhesion_error,
        )
    return replace(
        result,
        contact_modulus=fit.contact_modulus,
        contact_modulus_error=fit.contact_modulus_error,
        contact_height=-fit.contact_depth,
        contact_height_error=fit.contact_depth_error,
        largest_indentation=float(fit.indentation[fit.compared].max()),
        force_offset=fit.force_offset,
        residual=fit.noise,
        converged=fit.converged,
        doubts=SEPARATOR.join(doubts),
    )
