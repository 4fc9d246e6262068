"""Figures: each function draws into given axes of matplotlib.

::

    with style():
        figure, axes = pyplot.subplots()
        plot_loop(axes, loop, {"JKR": JKR(radius, modulus, work).pull_off_force})
        figure.savefig("loop.pdf")

Arguments are in ASE's units unless noted otherwise. Figures are in nm, nN and GPa;
heights and penetrations in Å.
"""

from typing import TYPE_CHECKING, Any

from ase_roughcontact._util.parts import import_shown, shown_by
from ase_roughcontact.plot.curves import (
    plot_area,
    plot_convergence,
    plot_curve,
    plot_force,
)
from ase_roughcontact.plot.files import draw_file
from ase_roughcontact.plot.flats import (
    plot_flat_area,
    plot_flat_conductance,
    plot_flat_gap,
)
from ase_roughcontact.plot.moduli import plot_moduli
from ase_roughcontact.plot.optimizers import plot_optimizers
from ase_roughcontact.plot.stresses import (
    plot_stress_map,
    plot_stress_over_depth,
    plot_stress_section,
)
from ase_roughcontact.plot.style import BLUE, COLOURS, GREY, ORANGE, letter, style
from ase_roughcontact.plot.surfaces import (
    plot_contact,
    plot_pressure,
    scale_bar,
    show_as_scanned,
)

__all__ = [
    "BLUE",
    "COLOURS",
    "GREY",
    "ORANGE",
    "draw_file",
    "letter",
    "plot_area",
    "plot_contact",
    "plot_convergence",
    "plot_curve",
    "plot_flat_area",
    "plot_flat_conductance",
    "plot_flat_gap",
    "plot_force",
    "plot_moduli",
    "plot_optimizers",
    "plot_pressure",
    "plot_stress_map",
    "plot_stress_over_depth",
    "plot_stress_section",
    "scale_bar",
    "show_as_scanned",
    "style",
]

if TYPE_CHECKING:
    from ase_roughcontact.path_kinds.loop.figures import plot_cantilever, plot_loop
    from ase_roughcontact.path_kinds.sliding.figures import (
        draw_friction,
        draw_tractions,
        plot_friction_loop,
        plot_slip_areas,
        plot_tractions,
    )
    from ase_roughcontact.path_kinds.sliding.timed_figures import (
        draw_sliding_in_time,
        plot_friction_over_time,
        plot_slip_rate,
    )
    from ase_roughcontact.path_kinds.time.figures import (
        draw_cantilever_path,
        draw_time_path,
        plot_over_depth,
        plot_over_time,
    )
    from ase_roughcontact.tradeoff.figures import plot_tradeoff

    __all__ += [
        "draw_cantilever_path",
        "draw_friction",
        "draw_sliding_in_time",
        "draw_time_path",
        "draw_tractions",
        "plot_cantilever",
        "plot_friction_loop",
        "plot_friction_over_time",
        "plot_loop",
        "plot_over_depth",
        "plot_over_time",
        "plot_slip_areas",
        "plot_slip_rate",
        "plot_tractions",
        "plot_tradeoff",
    ]
else:
    __all__ += shown_by("plot")

    def __getattr__(name: str) -> Any:
        """Import a figure of a package that can be left out when it is used."""
        return import_shown("plot", name)
