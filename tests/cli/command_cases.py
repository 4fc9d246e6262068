"""Runs of small scenes from the command line, with what they print, write and draw."""

import io
from contextlib import redirect_stdout
from pathlib import Path
from typing import NamedTuple
from unittest.mock import patch

import numpy as np
from ase.io import read
from matplotlib.figure import Figure

from ase_roughcontact._util.files import table_rows
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.cli import main

RADIUS, MODULUS, WORK = 150.0, 100.0 * UNITS["GPa"], 0.5 * UNITS["J/m^2"]
SCENE = """
[substrate]
model = "atoms"
spacing = {length}
contact_modulus = {modulus}
[sphere]
unit = "a0"
radius = 60.0
[interaction]
{wall}
[path]
control = "{control}"
values = {values}
"""
ROUGH = "[roughness]\nunit = 'a0'\nlong_wavelength = 16.0\n"
WALLS = {
    "hard": 'kind = "hard"',
    "repulsive": 'kind = "repulsive"',
    "sticky": 'kind = "adhesive"\nwork_of_adhesion = 0.5',
}
# Wall, values and roughness of the runs, by what they control.
CASES = {
    "load": ("repulsive", [2.0, 30.0], ROUGH),
    "penetration": ("hard", [1.0, 2.5], ""),
    "height": ("sticky", [1.5, -1.0, 1.0], ""),
}


class Case(NamedTuple):
    """Wall, control, scene file, printed output, table, frames and figures of a run."""

    wall: str
    control: str
    file: Path
    text: str
    records: list
    frames: list
    figures: dict

    def column(self, name):
        return np.array([float(record[name]) for record in self.records])


def text_of(wall, control, values, more="", length=2.5, modulus=100.0):
    given = {"wall": WALLS[wall], "control": control, "values": values}
    return SCENE.format(length=length, modulus=modulus, **given) + more


def hertz_area(force):
    return np.pi * (0.75 * RADIUS * force / MODULUS) ** (2.0 / 3.0)


def printed(*arguments):
    """Run the command and return its output."""
    with redirect_stdout(io.StringIO()) as out:
        assert main(list(map(str, arguments))) == 0
    return out.getvalue()


def keep_figure(figures):
    """Function that keeps a figure by its name in place of writing it."""

    def saved(figure, file, **_):
        figures[Path(file).name.removesuffix(".new")] = figure
        Path(file).touch()

    return saved


def run_case(folder, control):
    """Return the results of a run in a folder."""
    wall, values, more = CASES[control]
    file, out, figures = folder / "scene.toml", folder / "out", {}
    file.write_text(text_of(wall, control, values, more))
    with patch.object(Figure, "savefig", keep_figure(figures)):
        text = printed("run", file, "--out", out)
    records = list(table_rows((out / "curve.csv").read_text().splitlines()))
    frames = read(out / "sweep.traj", ":")
    return Case(wall, control, file, text, records, frames, figures)
