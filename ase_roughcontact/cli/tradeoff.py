"""Command that measures the cost of accuracy; its docstring is help."""

from __future__ import annotations

import argparse
from dataclasses import asdict

from ase_roughcontact._util.printing import show, write
from ase_roughcontact.cli.common import checked_scene, json_line
from ase_roughcontact.results.record import units_of
from ase_roughcontact.tradeoff.tradeoff import tradeoff


def measure_tradeoff(options: argparse.Namespace) -> int:
    """Measure the errors and costs of choices on a few steps of a scene.

    The choices are tolerance or grid, free or periodic boundary, wall, theory instead
    of simulation, and number of surfaces. The cheapest numerical settings for a wanted
    error of the area, the force or the height are printed and checked on another
    surface, and error against time is drawn.

    Exit status: 0 the settings have the wanted error, 1 none have, 2 the scene is
    invalid.
    """
    from ase_roughcontact.plot.files import check_picture
    from ase_roughcontact.tradeoff import figures  # imports matplotlib

    check_picture(options.picture)
    study = tradeoff(checked_scene(options), options.error, of=options.error_of)
    figures.draw_tradeoff(study, options.picture)
    if options.json:
        for choice in study.choices:
            values = {
                **asdict(choice),
                "on_front": choice in study.front,
                "in_plan": choice in study.plan,
                "error_of": study.of,
                "error_wanted": study.wanted,
                "error_of_check": study.checked,
            }
            write(json_line(values, units_of()))
    elif not options.quiet:
        show(*study.parts)
        write(str(options.picture))
    return 0 if study.kept else 1
