"""Adhesion loops on the command line: table, characteristic values, force curves."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from ase_roughcontact._util.files import replaced
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.paths.cantilever import CantileverCurve, CantileverJump
from ase_roughcontact.paths.instabilities import AdhesionLoop
from ase_roughcontact.paths.record import LoadStep

NN, NM = UNITS["nN"], UNITS["nm"]
_STIFFNESS = UNITS["J/m^2"]  # N/m
#: Header of the table of states.
HEADER = (
    "\nstate   depth (Å)   force (nN)   error (nN)   stiffness (N/m)   area (nm²)"
    "   error (nm²)"
)


def row(state: LoadStep) -> str:
    """Return the row of a state in the table.

    Parameters
    ----------
    state : LoadStep

    Returns
    -------
    str
    """
    text = (
        f"{state.step:5d}{state.penetration:12.4f}{state.normal_force / NN:13.4g}"
        f"{state.force_error / NN:13.2g}"
        f"{state.contact_stiffness / _STIFFNESS:18.4g}"
        f"{state.contact_area / UNITS['nm²']:13.4g}"
        f"{state.area_error / UNITS['nm²']:14.2g}"
    )
    return text if state.converged else f"{text}   NOT CONVERGED: {state.message}"


def summary(loop: AdhesionLoop, curve: CantileverCurve | None) -> str:
    """Return the characteristic values of a loop, one on each line.

    Parameters
    ----------
    loop : AdhesionLoop
    curve : CantileverCurve, optional
        Its force curve with a cantilever.

    Returns
    -------
    str
    """
    states = len(loop.approach) + len(loop.retraction) - 1
    count = len(loop.approach_jumps), len(loop.retraction_jumps)
    lines = [
        "",
        f"States: {states}; instabilities: {count[0]} on approach, {count[1]} on "
        "retraction",
        f"Pull-off force of the simulation: {-loop.pull_off_force / NN:.4g} nN",
        f"Dissipated energy: {loop.dissipated_energy:.4g} eV",
    ]
    if curve is not None:
        lines += [
            f"With a cantilever of {curve.stiffness / _STIFFNESS:.4g} N/m:",
            f"  snap-in: {_jump(curve.snap_in)}",
            f"  pull-off: {_jump(curve.pull_off)}",
            f"  dissipated energy: {curve.dissipated_energy:.4g} eV",
        ]
    return "\n".join(lines)


def write_curve(curve: CantileverCurve, file: Path) -> None:
    """Write a force curve as CSV: branch, distance, deflection (nm), force (nN).

    Parameters
    ----------
    curve : CantileverCurve
    file : path
    """
    with replaced(file) as name, open(name, "w", newline="") as table:
        rows = csv.writer(table)
        rows.writerow(["branch", "distance (nm)", "deflection (nm)", "force (nN)"])
        for way in ("approach", "retraction"):
            branch = getattr(curve, way)
            columns = branch.distance / NM, branch.deflection / NM, branch.force / NN
            rows.writerows(
                [way, *(f"{value:.8g}" for value in values)]
                for values in np.transpose(columns)
            )


def _jump(jump: CantileverJump | None) -> str:
    if jump is None:
        return "none"
    return (
        f"from {jump.force_before / NN:.4g} to {jump.force_after / NN:.4g} nN with the "
        f"base at {jump.distance / NM:.4g} nm"
    )
