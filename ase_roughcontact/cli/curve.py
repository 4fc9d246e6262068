"""Command that reads a measured force curve and fits an indenter; help is its doc."""

from __future__ import annotations

import argparse
import math
from dataclasses import replace
from typing import Any

from ase_roughcontact._util.printing import number, show, table, write
from ase_roughcontact._util.units import (
    LENGTHS,
    UNITS,
    WORKS,
    pressure_unit,
    quantity,
)
from ase_roughcontact.cli.common import json_line
from ase_roughcontact.fitting.adhesion import AdhesionFit, fit_shape
from ase_roughcontact.fitting.curve_checks import curve_checks, deflection_slope
from ase_roughcontact.fitting.curve_files import read_curve, read_with_times
from ase_roughcontact.fitting.force_curve import ForceCurve
from ase_roughcontact.fitting.indentation import IndentationFit
from ase_roughcontact.fitting.measurement import given_calibration
from ase_roughcontact.fitting.relaxation import RelaxationFit, fit_relaxation
from ase_roughcontact.fitting.series.listing import curve_at
from ase_roughcontact.fitting.series.one_curve import FitSettings
from ase_roughcontact.theory.indenters import named_indenter

# Names of the work of adhesion and its standard error.
_WORKS = "work_of_adhesion", "work_of_adhesion_error"


def curve(options: argparse.Namespace) -> int:
    """Read and draw a measured force curve; fit an indenter of a simple shape to it.

    Branches, direction, turn, free force, noise and spring constant are printed as they
    were read, with what was left out or changed, and with what makes a fit doubtful: a
    saturated deflection, free forces that drift or differ, no free part, a wrong
    sensitivity or sign. They are printed and drawn also if the fit fails.

    With --indenter the contact modulus, the contact point and the free force are fitted
    to the approach, or the branch that is given, and drawn over the indentation with
    the residuals: a few lines instead of a scene, for elastic contacts without
    adhesion. Indenters are "paraboloid RADIUS", "sphere RADIUS", "punch RADIUS", "cone
    ANGLE", "pyramid ANGLE" (half angles), and "truncated cone ANGLE RADIUS", "rounded
    cone ANGLE RADIUS", and the same of pyramids. --thickness is the thickness of an
    incompressible layer that is bonded to a rigid base.

    With --adhesion jkr or dmt, modulus and work of adhesion of a sphere are fitted to
    the retraction.

    With --relaxation the approach and the hold after it, at constant height or force,
    are fitted over the times in the file, with a number of relaxation times.

    Exit status: 0 the curve was read, and the fit has converged, 1 it has not, 2 the
    file or an option is invalid.
    """
    from ase_roughcontact.plot.files import check_picture  # imports matplotlib

    check_picture(options.picture)
    adhesion, relaxation = options.adhesion, options.relaxation
    thickness = length_of("thickness", options.thickness)
    deepest = length_of("deepest", options.deepest)
    settings = FitSettings(
        options.indenter, adhesion, relaxation, thickness, deepest, options.branch
    )
    settings.check()
    stiffness = stiffness_of(options)
    number, notes = options.curve_number, []
    if options.at:
        calibration = given_calibration(stiffness, options.sensitivity)
        number, place = curve_at(options.curve, options.at, calibration)
        x, y = place.x / UNITS["um"], place.y / UNITS["um"]
        notes = [f"note: curve {number}, measured at {x:.6g} um, {y:.6g} um"]
    given = stiffness, options.sensitivity, options.columns, number
    measured = read_curve(options.curve, options.branch, *given)
    fit: IndentationFit | RelaxationFit | None = None
    if options.indenter:
        shape = named_indenter(options.indenter)
        try:
            if relaxation:
                time, held = read_with_times(options.curve, *given)
                measured = replace(measured, remarks=held.remarks)  # keeps the hold
                fit = fit_relaxation(time, held, shape, relaxation)
            else:
                fit = fit_shape(measured, shape, adhesion, thickness, deepest)
        except ValueError:
            _report(options, measured, notes, None)  # may say why it can't be fitted
            raise
    _report(options, measured, notes, fit)
    return 0 if fit is None or fit.converged else 1


def _report(
    options: argparse.Namespace,
    measured: ForceCurve,
    notes: list[str],
    fit: IndentationFit | RelaxationFit | None,
) -> None:
    """Draw and print a curve as it was read, with its checks, and a fit."""
    from ase_roughcontact.fitting import curve_figures  # imports matplotlib

    if fit is None:
        curve_figures.draw_curve(measured, options.picture)
    elif isinstance(fit, RelaxationFit):
        curve_figures.draw_relaxation(fit, options.picture)
    else:
        curve_figures.draw_indentation(fit, options.picture)
    checks = curve_checks(measured)
    if options.json:
        write(_line(measured, checks, fit))
    elif not options.quiet:
        remarks = [f"note: {remark}" for remark in measured.remarks]
        warned = [f"warning: {check}" for check in checks]
        fitted = [] if fit is None else ["", *fit.parts]
        rows = table(("", "", ""), _rows(measured), left=1)
        show(rows, *notes, *remarks, *warned, *fitted)
        write(str(options.picture))


def length_of(name: str, text: str) -> float:
    """Return the length of an option (Å), infinite if it is not given."""
    return quantity(name, text, LENGTHS, "500 nm") if text else math.inf


def stiffness_of(options: argparse.Namespace) -> float | None:
    """Return the given spring constant of the cantilever (eV/Å^2), or None."""
    if not options.cantilever:
        return None
    return quantity("cantilever", options.cantilever, WORKS, "0.05 N/m")


def _rows(measured: ForceCurve) -> list[tuple[str, str, str]]:
    """Return names, values and units of the properties of a measured curve."""
    nm, nN = UNITS["nm"], UNITS["nN"]
    rows = []
    for branch in measured.branches:
        name = "approach" if branch.direction < 0.0 else "retraction"
        base = measured.base[branch.points] / nm
        ends = f"{number(base[0], 5)} to {number(base[-1], 5)}"
        rows.append((f"{name}, {len(base)} points: base from", ends, "nm"))
    turn = measured.base.argmin()
    for name, force in (
        ("force at the turn", measured.force[turn]),
        ("largest force", measured.force.max()),
        ("lowest force", measured.force.min()),
        ("free force", measured.far_force),
        ("noise of the force", measured.noise),
    ):
        rows.append((name, number(float(force) / nN), "nN"))
    stiffness = measured.stiffness / UNITS["N/m"]
    rows.append(("spring constant", number(stiffness), "N/m"))
    slope = deflection_slope(measured, measured.branches[0])
    rows.append(("deflection per base, loaded", number(slope, 3), "(rigid sample: 1)"))
    return rows


def _line(
    measured: ForceCurve,
    checks: list[str],
    fit: IndentationFit | RelaxationFit | None,
) -> str:
    """Return the measured curve, and a fit, as a line of JSON."""
    nN = UNITS["nN"]
    values: dict[str, Any] = {
        "points": len(measured.force),
        "largest_force": float(measured.force.max()) / nN,
        "lowest_force": float(measured.force.min()) / nN,
        "free_force": measured.far_force / nN,
        "noise": measured.noise / nN,
        "spring_constant": measured.stiffness / UNITS["N/m"],
        "deflection_slope": deflection_slope(measured, measured.branches[0]),
        "remarks": measured.remarks,
        "warnings": checks,
    }
    units = {
        "largest_force": "nN",
        "lowest_force": "nN",
        "free_force": "nN",
        "noise": "nN",
        "spring_constant": "N/m",
    }
    if fit is not None:
        values["indenter"] = fit.indenter.name
        values["converged"] = fit.converged
        values["warnings"] = [*checks, *fit.warnings]
        read_fit: Any = _relaxed if isinstance(fit, RelaxationFit) else _indented
        fitted, fitted_units = read_fit(fit)
        values.update(fitted)
        units.update(fitted_units)
    return json_line(values, units)


def _moduli(fit: IndentationFit | RelaxationFit) -> tuple[dict, dict[str, str]]:
    """Return the contact modulus, its error, contact depth and residual, and units."""
    unit = pressure_unit(fit.contact_modulus)
    values = {
        "contact_modulus": fit.contact_modulus / UNITS[unit],
        "contact_modulus_error": fit.contact_modulus_error / UNITS[unit],
        "contact_depth": fit.contact_depth / UNITS["nm"],
        "residual": fit.noise / UNITS["nN"],
    }
    units = {
        "contact_modulus": unit,
        "contact_modulus_error": unit,
        "contact_depth": "nm",
        "residual": "nN",
    }
    return values, units


def _indented(fit: IndentationFit) -> tuple[dict, dict[str, str]]:
    """Return the results of an indentation fit, and their units."""
    values, units = _moduli(fit)
    deepest = float(fit.indentation[fit.compared].max())
    values["contact_depth_error"] = fit.contact_depth_error / UNITS["nm"]
    values["largest_indentation"] = deepest / UNITS["nm"]
    units["contact_depth_error"] = units["largest_indentation"] = "nm"
    if isinstance(fit, AdhesionFit):
        work = fit.work_of_adhesion, fit.work_of_adhesion_error
        for name, value in zip(_WORKS, work, strict=True):
            values[name], units[name] = value / UNITS["J/m²"], "J/m²"
    return values, units


def _relaxed(fit: RelaxationFit) -> tuple[dict, dict[str, str]]:
    """Return the results of a fit over time, and their units."""
    values, units = _moduli(fit)
    unit = units["contact_modulus"]
    values["instantaneous_modulus"] = fit.instantaneous_modulus / UNITS[unit]
    values["relaxation_moduli"] = fit.relaxation_moduli.tolist()
    values["relaxation_times"] = fit.relaxation_times.tolist()
    values["relaxation_times_errors"] = fit.relaxation_times_errors.tolist()
    units["instantaneous_modulus"] = unit
    units["relaxation_times"] = units["relaxation_times_errors"] = "s"
    return values, units
