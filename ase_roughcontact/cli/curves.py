"""Command that fits many force curves, a map or a series; its docstring is help."""

from __future__ import annotations

import argparse
from dataclasses import fields
from pathlib import Path

from ase_roughcontact._util.files import replaced
from ase_roughcontact._util.printing import show, write
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.cli.common import json_line, progress_bar
from ase_roughcontact.cli.curve import length_of, stiffness_of
from ase_roughcontact.fitting.series.row import CURVE_UNITS, FittedCurve
from ase_roughcontact.fitting.series.run import fit_curves
from ase_roughcontact.fitting.series.summary import SeriesSummary, is_good


def curves(options: argparse.Namespace) -> int:
    """Fit an indenter to many force curves: a map, an archive, or a series of files.

    Contact modulus, contact point and free force are fitted to each approach, as by the
    command curve, in parallel; pull-off forces follow from the retractions. With
    --adhesion modulus and work of adhesion are fitted to the retractions, with
    --relaxation moduli and relaxation times to approaches and holds. Without --indenter
    nothing is fitted. A curve that can't be read or fitted does not stop the others.

    DIR/curves.csv has a row for each curve: file and number, place, parameters with
    standard errors, residuals, doubts, and the reason if there is no fit. Medians,
    quartiles, and how many curves failed and why are printed. Maps of modulus, pull-off
    force, contact point and misfit are in DIR/maps.png, or these quantities over the
    number of the curve in DIR/series.png, if all were measured at one place; a
    histogram of the moduli is in DIR/histogram.png. DIR/curves.html is a page with
    all of it, on which any column is drawn over another one and maps show the value
    under the pointer. An interrupted run is resumed by running it again.

    Exit status: 0 all curves were read and fitted, 1 some were not, 2 an option or the
    folder is invalid.
    """
    # import matplotlib and jinja2
    from ase_roughcontact.cli.curves_page import page_of_curves
    from ase_roughcontact.fitting.series.figures import draw_series

    fitted = fit_curves(
        options.files,
        options.indenter,
        options.out,
        adhesion=options.adhesion,
        relaxation=options.relaxation,
        thickness=length_of("thickness", options.thickness),
        deepest=length_of("deepest", options.deepest),
        branch=options.branch,
        stiffness=stiffness_of(options),
        sensitivity=options.sensitivity,
        heads=options.columns,
        workers=options.workers,
    )
    found: list[FittedCurve] = []
    with progress_bar(options):  # of what is logged
        for curve in fitted:
            found.append(curve)
            if options.json:
                write(_line(curve))
    files = [options.out / "curves.csv", *draw_series(found, options.out)]
    files.append(options.out / "curves.html")
    with replaced(files[-1]) as name:
        Path(name).write_text(page_of_curves(found, options.out), encoding="utf-8")
    if not (options.quiet or options.json):
        show(*SeriesSummary(found).parts)
        write("\n".join(map(str, files)))
    return 0 if all(map(is_good, found)) else 1


def _line(curve: FittedCurve) -> str:
    """Return the result of a curve as a line of JSON."""
    values = {each.name: getattr(curve, each.name) for each in fields(curve)}
    for name, unit in CURVE_UNITS.items():
        values[name] /= UNITS[unit]
    return json_line(values | {"misfit": curve.misfit}, CURVE_UNITS)
