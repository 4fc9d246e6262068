"""Command that fits a scene to a measured force curve; its docstring is help."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Mapping
from typing import Any

from ase_roughcontact._util.printing import show, write, write_error
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.cli.common import checked_scene, json_line, prints_text
from ase_roughcontact.contact.control import LOAD
from ase_roughcontact.fitting.curve_checks import curve_checks
from ase_roughcontact.fitting.curve_files import read_curve, read_in_time
from ase_roughcontact.fitting.fit import fit_curve
from ase_roughcontact.fitting.force_curve import BASELINE
from ase_roughcontact.fitting.least_squares import Fit
from ase_roughcontact.fitting.parameters import SERIES
from ase_roughcontact.fitting.smooth_fit import SmoothFit, smooth_fit
from ase_roughcontact.fitting.time_fit import fit_in_time


def fit(options: argparse.Namespace) -> int:
    """Fit parameters of a scene to a measured force curve by least squares.

    The derivatives follow from the relaxed states. Data, fit and residuals are drawn.
    The curve is a table with the columns "distance (nm)" of the base, positive away
    from the surface, and "force (nN)" or "deflection (nm)" of the cantilever, negative
    in tension; or "force (nN)" and "depth (nm)" = -(distance + deflection); or a file
    of NanoScope, JPK or another instrument. The zero of the depth is fitted. With
    force_offset among the free parameters the zero of the force is fitted, too, and
    with force_slope a drift that is linear in the height of the base. Beside it, the
    work of adhesion of a smooth sphere is fitted by the theory (DMT, JKR,
    Maugis-Dugdale) that applies.

    Errors contain the noise, the range of the attraction, to a factor of two, and the
    grid; they are printed one by one, too. It warns of residuals far above the noise or
    of one sign over a part of the curve, of a snap-in or a pull-off at another height
    of the base, of a free part that is not at zero force, of parameters that can't both
    be determined, and, before the first trial, of what seems a wrong sign. Each trial,
    in which the scene is pressed in and pulled off again, prints a line on the error
    output: the residuals relative to the noise, and the parameters.

    With a path in time the columns are "time (s)" and "force (nN)", under given loads
    "depth (nm)", and the path is the measured one. relaxation_moduli and
    relaxation_times may be free, too, all of a series at once.

    Exit status: 0 the fit has converged, 1 it has not, 2 the scene or the table is
    invalid.
    """
    from ase_roughcontact.fitting import figures  # imports matplotlib
    from ase_roughcontact.plot.files import check_picture

    check_picture(options.picture)
    scene, smooth = checked_scene(options), None
    trials = _print_trial if prints_text(options) else None
    default = ",".join(SERIES) if scene.solid.creep else "work_of_adhesion"
    free = [name.strip() for name in (options.free or default).split(",")]
    given = (
        options.branch,
        scene.cantilever,
        options.sensitivity,
        options.columns,
        options.curve_number,
    )
    remarks: tuple[str, ...] = ()
    if scene.solid.creep:
        kind = "depth" if scene.control == LOAD else "force"
        curve_in_time = read_in_time(options.curve, kind, *given)
        found = fit_in_time(scene, *curve_in_time, free, trials)
    else:
        curve = read_curve(options.curve, *given)
        remarks = curve.remarks
        if trials is not None:
            for remark in (*remarks, *curve_checks(curve)):
                write_error(f"note: {remark}")
        found = fit_curve(scene, curve, free, trials)
        if scene.wall.attractive and scene.bodies.shape is None:
            lines = [name for name in free if name in BASELINE]
            smooth = smooth_fit(scene, curve, lines)
    figures.draw_fit(found, smooth, options.picture)
    if options.json:
        write(_fit_line(found, smooth, remarks))
    elif not options.quiet:
        show(*found.parts)
        if smooth:
            show(str(smooth))
        write(str(options.picture))
    return 0 if found.converged else 1


def _print_trial(values: Mapping[str, float], residual: float) -> None:
    """Print a trial of a fit as a line on the error output."""
    parameters = ", ".join(f"{name} {value:.5g}" for name, value in values.items())
    write_error(f"residual/noise {residual:.4g}: {parameters}")


def _fit_line(found: Fit, smooth: SmoothFit | None, remarks: tuple[str, ...]) -> str:
    """Return a fit as a line of JSON."""

    def named(values: Iterable) -> dict[str, Any]:
        return dict(zip(found.names, values, strict=True))

    parts = found.contributions.items()
    return json_line(
        {
            **named(found.values.tolist()),
            "errors": named(found.errors.tolist()),
            "error_contributions": {k: named(each.tolist()) for k, each in parts},
            "correlation": found.correlation.tolist(),
            "noise": found.noise / UNITS[found.ordinate[1]],
            "smooth_sphere": smooth and smooth.work_of_adhesion,
            "theory": smooth and smooth.theory,
            "converged": found.converged,
            "warnings": found.warnings,
            "remarks": remarks,
        },
        {**named(found.units), "noise": found.ordinate[1], "smooth_sphere": "J/m²"},
    )
