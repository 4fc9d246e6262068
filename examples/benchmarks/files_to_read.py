"""Files of the package whose functions run in a calculation.

    python files_to_read.py
    python files_to_read.py --list energy

They are what one must read to understand all that a calculation does. Functions are
counted by `sys.setprofile` in the first calculation of a process, after the import of
all modules. Another version of the package is measured by setting PYTHONPATH.
"""

import argparse
import io
import subprocess
import sys
import tempfile
import threading
from contextlib import redirect_stdout
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages

from markdown import table

import ase_roughcontact as rc
from ase_roughcontact.cli import main
from ase_roughcontact.elasticity import Isotropic

ROOT = Path(rc.__file__).parent
SPHERE = rc.RoughSphere(200.0, rc.SelfAffine(0.1, 0.8, 10.0, 40.0, seed=1))
SPACING = 2.5
LOOP = """
[substrate]
material = "Cu"
[sphere]
radius = "5 nm"
[roughness]
unit = "a0"
rms_slope = 0.05
long_wavelength = 16.0
[interaction]
kind = "adhesive"
work_of_adhesion = 0.05
attraction_range = 1.0
[path]
kind = "loop"
deepest = 0.2
step = 0.5
"""


def atoms_under(shape, wall):
    """Return atoms below a rough sphere."""
    atoms = rc.substrate("Cu", shape, SPHERE, spacing=SPACING)
    solid = Isotropic(0.7, poisson=0.3)
    atoms.calc = rc.RoughContact(SPHERE, solid=solid, wall=wall)
    return atoms


def energy(displacement=0.0):
    """Return a function that calculates the energy of a surface."""
    atoms = rc.substrate("Cu", (16, 16), SPHERE, spacing=SPACING)
    atoms.calc = rc.RoughContact(SPHERE, 0.7)
    atoms.positions[:-1, 2] -= displacement * (atoms.positions[:-1, 0] % 7.0)
    return atoms.get_potential_energy


def hard_step():
    """Return a function that presses a hard sphere, in a window of its own."""
    atoms = atoms_under((16, 16), rc.HardWall())
    return lambda: list(rc.load_path(atoms, penetrations=[1.0], window="auto"))


def friction_steps():
    """Return a function that slides a sphere by two steps."""
    atoms, law = atoms_under((32, 32), rc.HardWall()), rc.Coulomb(0.3)
    return lambda: list(
        rc.sliding_path(atoms, law, penetrations=1.0, displacements=[0.2, 0.4])
    )


def adhesive_loop():
    """Return a function that runs a loop by the command."""
    folder = Path(tempfile.mkdtemp())
    file, out = folder / "loop.toml", folder / "out"
    file.write_text(LOOP, "utf-8")
    return lambda: main(["run", str(file), "--out", str(out)])


CASES = {
    "energy": ("`RoughContact`: energy of flat atoms", energy),
    "displaced": ("`RoughContact`: energy of displaced atoms", lambda: energy(0.01)),
    "hard": ("`load_path`: hard wall, one step, automatic window", hard_step),
    "friction": ("`sliding_path`: two steps", friction_steps),
    "loop": ("command: adhesive loop", adhesive_loop),
}


def functions_of(calculation):
    """Return the functions of the package that run, as files and lines."""
    found = set()

    def profile(frame, event, _):
        code = frame.f_code
        if event == "call" and code.co_name != "<module>":
            found.add((code.co_filename, code.co_firstlineno))

    threading.setprofile(profile)
    sys.setprofile(profile)
    try:
        with redirect_stdout(io.StringIO()):
            calculation()
    finally:
        sys.setprofile(None)
        threading.setprofile(None)
    places = [(Path(file), line) for file, line in found]
    return [place for place in places if place[0].is_relative_to(ROOT)]


def measure(case):
    """Return the files, relative to the package, and the number of functions."""
    for module in walk_packages([str(ROOT)], "ase_roughcontact."):
        if not module.name.endswith("__main__"):
            import_module(module.name)
    functions = functions_of(CASES[case][1]())
    return sorted({file.relative_to(ROOT) for file, _ in functions}), len(functions)


def show_counts():
    """Print the table, each case by a process of its own."""
    rows = []
    for case, (title, _) in CASES.items():
        command = [sys.executable, __file__, "--list", case]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        *files, functions = done.stdout.split()
        packages = {Path(file).parts[0] for file in files}
        rows.append((title, len(files), len(packages), functions))
    table("calculation | files | packages | functions", rows)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--list", choices=CASES, help="print the files of a case")
    options = parser.parse_args()
    if options.list:
        files, count = measure(options.list)
        print(*files, count, sep="\n")
    else:
        show_counts()
