"""A terminal shows what is printed into a pipe; the bar below it leaves nothing."""

import re
from pathlib import Path

import numpy as np
import pytest
from command_cases import printed
from terminal import screen_of, screen_of_process

from ase_roughcontact._util.units import UNITS

SOLID = """
[substrate]
spacing = "1 nm"
contact_modulus = 100.0
hardness = 3.0
"""
SPHERE = """
[sphere]
radius = "30 nm"
[interaction]
kind = "hard"
"""
LOADS = SOLID + SPHERE + "[path]\nvalues = [5.0, 50.0, 500.0, 2000.0]\n"
COARSE = LOADS.replace("1 nm", "2 nm")
CREEP = SOLID + 'relaxation_moduli = [0.5]\nrelaxation_times = ["1 s"]\n' + SPHERE
FLAT = """
[substrate]
spacing = "1 nm"
contact_modulus = 10.0
hardness = inf
[sphere]
radius = inf
[roughness]
short_wavelength = "4 nm"
long_wavelength = "16 nm"
rms_slope = 0.1
[interaction]
kind = "hard"
[path]
values = ["10 MPa", "30 MPa"]
"""
IN_TIME = '[path]\nkind = "time"\ncontrol = "load"\nvalues = [100, 200]\nrate = 100\n'
STEPS = "[path]\nfirst = 5.0\nlast = 500.0\nsteps = 13\n"
# Words of commands, their scene, and how many columns 60 characters are too few for.
COMMANDS = {
    "run": (["run"], LOADS, 1),
    "preview": (["run", "--preview"], SOLID + SPHERE + STEPS, 1),
    "flat": (["run"], FLAT, 3),
    "time": (["run"], CREEP + IN_TIME, 1),
    "ensemble": (
        ["ensemble", "--workers", "1", "--set", "roughness.seed=0,1"],
        FLAT,
        1,
    ),
    "fit": (["fit", "--free", "contact_modulus", "curve.csv"], COARSE, 1),
}
ROW = re.compile(r" *\d[\d./]* +[-\d]|contact_modulus +\d|height_offset +[-\d]")
PROGRESS = re.compile(r"\d+/\d+ (steps|paths)")
NOTE = re.compile(r"Leftoutonascreenof60characters:.*?showall\)\.")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Folder with a force curve of a Hertzian contact; the present one."""
    monkeypatch.chdir(tmp_path)
    depth = np.linspace(-5.0, 10.0, 16)  # Å
    modulus, radius = 95.0 * UNITS["GPa"], 300.0
    force = 4.0 / 3.0 * modulus * radius**0.5 * depth.clip(0.0) ** 1.5 / UNITS["nN"]
    force += np.random.default_rng(0).normal(size=depth.size)
    rows = [f"{d / 10.0:.6f},{f:.6f}" for d, f in zip(depth, force, strict=True)]
    (tmp_path / "curve.csv").write_text("\n".join(["depth (nm),force (nN)", *rows]))
    return tmp_path


def in_pipe(command):
    """Lines of a command printed into a pipe."""
    words, scene, _ = COMMANDS[command]
    Path("scene.toml").write_text(scene)
    lines = printed(*words, "scene.toml").splitlines()
    return [line for line in lines if not PROGRESS.match(line)]


def on_screen(command, columns, monkeypatch):
    """Lines of the same command on a terminal, begun again."""
    for each in Path().glob("roughcontact*"):
        each.rename(f"before-{columns}-{each.name}")
    words = COMMANDS[command][0]
    status, shown = screen_of([*words, "scene.toml"], columns, monkeypatch)
    assert status == 0
    return shown


def without_times(lines):
    """Lines without the wall-clock times of steps."""
    return [re.sub(r"\d+\.\d\d(?=( +\*)?$)", "#.##", line) for line in lines]


def text_and_rows(lines, left_out=0):
    """Text above and below a table, without blanks, and the words of its rows."""
    numbers = [i for i, line in enumerate(lines) if ROW.match(line)]
    rows = [lines[i].split() for i in numbers]
    for row in rows:
        last = len(row) - (row[-1] == "*")
        del row[last - left_out : last]
    first = numbers[0]
    rest = [
        *lines[: max(first - 2, 0)],
        *(k for k in lines[first:] if not ROW.match(k)),
    ]
    return NOTE.sub("", "".join("".join(rest).split())), rows


@pytest.mark.parametrize(
    "command",
    [
        pytest.param(name, marks=pytest.mark.slow) if name == "fit" else name
        for name in COMMANDS
    ],
)
def test_a_screen_shows_what_is_printed_into_a_pipe(command, folder, monkeypatch):
    piped = in_pipe(command)
    wide = on_screen(command, 80, monkeypatch)
    assert without_times(wide) == without_times(piped)
    narrow = on_screen(command, 60, monkeypatch)  # lacks the last columns only
    left_out = COMMANDS[command][2]
    assert text_and_rows(narrow) == text_and_rows(piped, left_out)
    assert bool(NOTE.search("".join("".join(narrow).split()))) == bool(left_out)


def test_a_narrow_screen_keeps_the_marks_of_limits(folder):
    Path("scene.toml").write_text(LOADS)
    _, shown = screen_of_process(["run", "scene.toml"], 60)
    marked = [line.split()[0] for line in shown if ROW.match(line) and line[-1] == "*"]
    assert marked == ["1/3", "2/3", "3/3"]
    names = next(line for line in shown if line.startswith("Left out"))
    assert names == "Left out on a screen of 60 characters: time (64 show all)."


@pytest.mark.parametrize("columns", [60, 80])
def test_a_screen_shows_the_rows_of_a_restored_run(columns, folder, monkeypatch):
    Path("scene.toml").write_text(LOADS)
    printed("run", "scene.toml")
    piped = printed("run", "scene.toml").splitlines()
    _, shown = screen_of(["run", "scene.toml"], columns, monkeypatch)
    left_out = 1 if columns == 60 else 0
    assert text_and_rows(shown) == text_and_rows(piped, left_out)
    assert sum("restored" in line for line in piped) == 4
