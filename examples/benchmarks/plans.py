"""Plans of runs, ensembles and places against what is then measured.

    OMP_NUM_THREADS=1 python plans.py               # scenes that are not in plans.csv
    OMP_NUM_THREADS=1 python plans.py --again loop  # again those with names like this
    python plans.py --report                        # table of planned over measured

Steps, peak memory of a process (MB), size of all files (MB) and processor time (s). The
times of a plan and of its run are of one thread, one after the other; other programs on
the machine may change each of them. Memory is read from /proc, thus Linux is needed.
"""

import argparse
import csv
import json
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from ase.db import connect

from ase_roughcontact.ensemble import product
from ase_roughcontact.ensemble.ensemble_plan import EnsemblePlan
from ase_roughcontact.ensemble.places import places_of
from ase_roughcontact.paths.planned_steps import StartCosts
from ase_roughcontact.scene import Scene, default_text
from ase_roughcontact.scene.run_plan import run_plan

TABLE = Path(__file__).with_suffix(".csv")
HEADS = ("scene", "quantity", "planned", "measured")
# What stands before a planned number that is a lower bound.
LOWER_BOUND = ">"
# Time between two readings of the memory of processes (s).
INTERVAL = 0.1

SILICA = """
[substrate]
material = "SiO2"
[sphere]
material = "SiO2"
radius = "50 nm"
"""
POLYMER = """
[substrate]
contact_modulus = "3 MPa"
spacing = "{}"
relaxation_moduli = {}
relaxation_times = {}
[sphere]
radius = "{}"
"""
FLAT = """
[substrate]
material = "Cu"
model = "atoms"
periodic = true
[sphere]
radius = inf
[roughness]
rms_slope = {}
short_wavelength = "2 nm"
long_wavelength = "30 nm"
domain = "{} a0"
"""
ROUGH = """
[roughness]
rms_slope = {}
short_wavelength = "{} nm"
long_wavelength = "{} nm"
"""
SCANNED = """
[topography]
file = "scan.txt"
role = "substrate"
margin = "12 nm"
"""
HARD = """
[interaction]
kind = "hard"
"""
REPULSIVE = """
[interaction]
kind = "repulsive"
"""
ADHESIVE = """
[interaction]
kind = "adhesive"
work_of_adhesion = "{} mJ/m^2"
"""
LOADS = """
[path]
loads = {{ first = "{} nN", last = "{} nN", steps = {}, scale = "geometric" }}
"""
SCENES = {
    "adhesive loop": SILICA
    + ROUGH.format(0.1, 2, 20)
    + ADHESIVE.format(50)
    + """
[path]
kind = "loop"
deepest = "0.2 nm"
cantilever_stiffness = "1 N/m"
""",
    "crystal by EMT": """
[substrate]
material = "Cu"
calculator = "emt"
[sphere]
radius = "20 nm"
"""
    + HARD
    + LOADS.format(5, 50, 3),
    "creep": POLYMER.format("10 nm", [0.5], '["1 s"]', "10 um")
    + HARD
    + """
[path]
kind = "time"
loads = ["0 nN", "100 nN"]
rate = "10 uN/s"
dwell = "10 s"
""",
    "layer": """
[substrate]
contact_modulus = "200 GPa"
layer_thickness = "5 nm"
layer_contact_modulus = "5 GPa"
layer_poisson = 0.4
poisson = 0.3
spacing = "0.5 nm"
[sphere]
radius = "100 nm"
"""
    + ROUGH.format(0.05, 4, 40)
    + HARD
    + LOADS.format(1, 500, 7),
    "rough flat": """
[substrate]
contact_modulus = "100 GPa"
spacing = "0.125 nm"
periodic = true
[sphere]
radius = inf
"""
    + ROUGH.format(0.1, 4, 64)
    + 'domain = "128 nm"\n'
    + HARD
    + """
[path]
loads = ["100 MPa", "200 MPa", "500 MPa", "1 GPa"]
""",
    "sliding": SILICA
    + ROUGH.format(0.05, 2, 20)
    + HARD
    + """
[friction]
coefficient = 0.3
[path]
kind = "sliding"
loads = ["160 nN"]
displacements = [0, "0.2 nm", "-0.2 nm", "0.2 nm"]
steps_per_move = 8
""",
    "viscoelastic loop": POLYMER.format("4 nm", [0.3, 0.4], '["10 ms", "1 s"]', "1 um")
    + ADHESIVE.format(30)
    + """
[path]
kind = "loop"
deepest = "20 nm"
rate = "100 nm/s"
""",
    "built-in": default_text(),
    "smooth sphere": """
[substrate]
material = "Si"
[sphere]
radius = "200 nm"
"""
    + HARD
    + LOADS.format(1, 2000, 30),
    "large repulsive": """
[substrate]
material = "Si"
[sphere]
radius = "2 um"
"""
    + ROUGH.format(0.05, 4, 100)
    + REPULSIVE
    + LOADS.format(100, 20000, 5),
    "plastic": """
[substrate]
material = "Au"
model = "atoms"
[sphere]
radius = "100 nm"
"""
    + ROUGH.format(0.05, 2, 40)
    + """
[interaction]
kind = "plastic"
[path]
loads = ["50 nN", "100 nN", "200 nN", "400 nN", "800 nN", "100 nN"]
""",
    "plastic flat": FLAT.format(0.2, 256)
    + """
[interaction]
kind = "plastic"
[path]
values = ["50 MPa", "100 MPa", "200 MPa", "300 MPa", "200 MPa", "50 MPa"]
""",
    "adhesive depths": SILICA
    + ROUGH.format(0.05, 2, 20)
    + ADHESIVE.format(20)
    + """
[path]
penetrations = { first = "-0.2 nm", last = "0.6 nm", steps = 9 }
""",
    "repulsive flat, 512 x 512": FLAT.format(0.1, 512)
    + REPULSIVE
    + """
[path]
loads = ["50 MPa", "200 MPa", "800 MPa"]
""",
    "hard flat, 1024 x 1024": FLAT.format(0.05, 1024)
    + HARD
    + """
[path]
loads = ["50 MPa", "100 MPa", "200 MPa", "400 MPa", "800 MPa"]
""",
    "coupled sliding": """
[substrate]
contact_modulus = "70 GPa"
poisson = 0.2
spacing = "0.25 nm"
[sphere]
radius = "60 nm"
[friction]
coefficient = 0.5
"""
    + HARD
    + """
[path]
kind = "sliding"
loads = ["100 nN"]
displacements = [0, "0.1 nm", 0]
steps_per_move = 10
""",
    "sliding in time": """
[substrate]
contact_modulus = 100.0
poisson = 0.5
spacing = 2.5
[sphere]
radius = "10 nm"
[friction]
kind = "rate-and-state"
coefficient = 0.4
direct_effect = 0.01
evolution_effect = 0.02
distance = "0.2 nm"
velocity = "1 nm/s"
density = 2700.0
shear_modulus = 25.0
"""
    + HARD
    + """
[path]
kind = "sliding-in-time"
values = [10.0]
bases = [0, "20 nm"]
spring = 0.2
rate = "1 nm/s"
""",
    "oscillation": POLYMER.format("8 nm", [0.6], '["0.1 s"]', "5 um")
    + HARD
    + """
[path]
kind = "time"
penetrations = ["0 nm", "30 nm"]
rate = "100 nm/s"
dwell = "1 s"
amplitude = "2 nm"
frequency = 5.0
""",
    "loop on a layer": """
[substrate]
contact_modulus = "100 GPa"
layer_thickness = "20 nm"
layer_contact_modulus = "10 GPa"
layer_poisson = 0.3
poisson = 0.3
spacing = "0.5 nm"
[sphere]
radius = "100 nm"
"""
    + ADHESIVE.format(60)
    + """
[path]
kind = "loop"
deepest = "0.5 nm"
""",
    "scanned tip": """
[substrate]
material = "Si"
model = "atoms"
[sphere]
radius = inf
material = "Si3N4"
[topography]
file = "tip.txt"
role = "indenter"
detrend = "none"
center = "highest"
"""
    + REPULSIVE
    + """
[path]
loads = ["5 nN", "10 nN", "20 nN", "50 nN"]
""",
    "ensemble of loads": SILICA
    + ROUGH.format(0.05, 2, 20)
    + HARD
    + LOADS.format(1, 100, 6),
    "ensemble of loops": SILICA
    + ROUGH.format(0.1, 2, 20)
    + ADHESIVE.format(50)
    + """
[path]
kind = "loop"
deepest = "0.2 nm"
""",
    "ensemble of slides": SILICA
    + ROUGH.format(0.05, 2, 20)
    + HARD
    + """
[friction]
coefficient = 0.3
[path]
kind = "sliding"
values = ["40 nN"]
displacements = [0, "0.2 nm"]
steps = 6
""",
    "places": SILICA + SCANNED + HARD + LOADS.format(1, 50, 4),
    "places of loops": SILICA
    + SCANNED
    + ADHESIVE.format(50)
    + """
[path]
kind = "loop"
deepest = "0.1 nm"
""",
}
# Values of ensembles.
VALUES = {
    "ensemble of loads": {
        "roughness.seed": [0, 1, 2, 3, 4, 5],
        "roughness.rms_slope": [0.05, 0.1],
    },
    "ensemble of loops": {"roughness.seed": [0, 1, 2, 3, 4, 5]},
    "ensemble of slides": {"roughness.seed": [0, 1, 2, 3, 4, 5]},
}
# Number of places along each side.
PLACES = {"places": 4, "places of loops": 2}
WORKERS = 2


def scan(points, pixel, height, curvature=0.0):
    """Return a scan with waves of 5 to 24 nm, as the text of a file; lengths in nm."""
    rng = np.random.default_rng(8)
    x = pixel * (np.arange(points) - 0.5 * (points - 1))
    q = np.fft.fftfreq(points, pixel)
    q = np.hypot(q[:, None], q)
    wave = (q > 1 / 24) & (q < 1 / 5)
    amplitude = np.where(wave, np.where(wave, q, 1.0) ** -1.8, 0.0)
    rough = np.fft.ifft2(amplitude * np.fft.fft2(rng.normal(size=q.shape))).real
    heights = height * rough / rough.std() - 0.5 * curvature * (x[:, None] ** 2 + x**2)
    side = pixel * points
    lines = [" ".join(f"{each:.3f}" for each in row) for row in heights - heights.min()]
    head = f"# Channel: Height\n# Width: {side:g} nm\n# Height: {side:g} nm\n"
    return head + "# Value units: nm\n" + "\n".join(lines) + "\n"


def write_scene(name, folder):
    """Write scene and scans of a name into a folder; return the file."""
    (folder / "tip.txt").write_text(scan(64, 0.75, 0.25, 1 / 25), "utf-8")
    (folder / "scan.txt").write_text(scan(128, 0.5, 0.15), "utf-8")
    file = folder / "scene.toml"
    file.write_text(SCENES[name], "utf-8")
    return file


def command_of(name, file):
    """Return the command that calculates a scene, without the place of its results."""
    if name in PLACES:
        grid = f"{PLACES[name]}x{PLACES[name]}"
        return ["places", str(file), "--grid", grid, "--workers", str(WORKERS)]
    if name not in VALUES:
        return ["run", str(file)]
    command = ["ensemble", str(file), "--workers", str(WORKERS)]
    for key, values in VALUES[name].items():
        command += ["--set", f"{key}={','.join(map(str, values))}"]
    return command


def planned(name, folder):
    """Return steps, memory, files and time of the plan, by a process of its own."""
    line = [sys.executable, __file__, "--plan-of", name, "--folder", str(folder)]
    output = subprocess.run(line, check=True, capture_output=True, text=True).stdout
    return json.loads(output)


def print_plan(name, folder):
    """Print the plan of a scene as JSON, with the costs of its own start."""
    start = StartCosts.now()
    scene = Scene.read(write_scene(name, folder))
    scene.check()
    if name in VALUES:
        plan = EnsemblePlan.of(product(scene, VALUES[name]), WORKERS, start)
    elif name in PLACES:
        scenes = places_of(scene, (PLACES[name], PLACES[name]))
        plan = EnsemblePlan.of(scenes, WORKERS, start, places=True)
    else:
        plan = run_plan(scene, start.with_scene())
    totals = plan.totals
    found = {
        "steps": totals["steps"],
        "memory": totals["memory"] / 1e6,
        "files": totals["files"] / 1e6,
        "time": totals["seconds"],
        "at_least": totals["at_least"],
    }
    print(json.dumps(found))


def measured(name, folder):
    """Run a scene; return steps, peak memory, files and time."""
    arguments = command_of(name, write_scene(name, folder))
    out = folder / "out"
    out.mkdir()
    if arguments[0] == "ensemble":
        arguments += ["--database", str(out / "spheres.db")]
    else:
        arguments += ["--out", str(out), "--quiet"]
    line = [sys.executable, "-m", "ase_roughcontact", *arguments]
    before = os.times()
    process = subprocess.Popen(line, stdout=subprocess.DEVNULL, cwd=folder)
    workers = arguments[0] != "run"
    peak = 0
    while process.poll() is None:
        for number in children(process.pid) if workers else [process.pid]:
            peak = max(peak, peak_memory(number))
        time.sleep(INTERVAL)
    after = os.times()
    files = [each for each in out.rglob("*") if each.is_file()]
    return {
        "steps": steps_of(out, arguments[0]),
        "memory": peak / 1e6,
        "files": sum(each.stat().st_size for each in files) / 1e6,
        "time": sum(after[2:4]) - sum(before[2:4]),
    }


def children(parent):
    """Return the processes that another one has started."""
    found = Path(f"/proc/{parent}/task/{parent}/children")
    try:
        return [int(each) for each in found.read_text(encoding="utf-8").split()]
    except OSError:  # it has ended
        return []


def peak_memory(number):
    """Return the peak of the resident memory of a process (bytes); zero if it ended."""
    try:
        text = Path(f"/proc/{number}/status").read_text(encoding="utf-8")
    except OSError:
        return 0
    found = re.search(r"VmHWM:\s+(\d+) kB", text)
    return 1024 * int(found[1]) if found else 0


def steps_of(folder, command):
    """Return the number of steps that a run has written; None for places."""
    if command == "run":
        return len((folder / "curve.csv").read_text("utf-8").splitlines()) - 1
    if command == "places":
        return None
    with connect(folder / "spheres.db") as database:
        return database.count("step>=0")


def rounded(value):
    """Return a number as text with three digits; empty for None."""
    if value is None:
        return ""
    return f"{value:.0f}" if value >= 100 else f"{value:.3g}"


def stored():
    """Return the stored numbers: (planned, measured) by scene and quantity."""
    if not TABLE.exists():
        return {}
    with TABLE.open() as file:
        return {
            (row["scene"], row["quantity"]): (row["planned"], row["measured"])
            for row in csv.DictReader(file)
        }


def write(rows):
    """Write the table."""
    with TABLE.open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(HEADS)
        for key, values in rows.items():
            table.writerow((*key, *values))


def report(rows):
    """Print what was planned and measured for each scene, and how many are close."""
    quantities = "steps", "memory", "files", "time"
    close = total = 0
    print("| scene | steps | memory (MB) | files (MB) | time (s) |")
    print("|---|---|---|---|---|")
    for name in SCENES:
        cells = []
        for quantity in quantities:
            plan, run = rows.get((name, quantity), ("", ""))
            if not run:
                cells.append("")
                continue
            least = plan.startswith(LOWER_BOUND)
            ratio = float(plan.removeprefix(LOWER_BOUND)) / float(run)
            is_close = 1 / 1.3 <= ratio <= 1.3
            total += not least
            close += is_close and not least
            mark = "" if is_close or least else " *"
            cells.append(f"{plan} / {run}{mark}")
        if any(cells):
            print(f"| {name} | {' | '.join(cells)} |")
    print(
        f"\n{close} of {total} numbers are within a factor of 1.3, others have a star."
    )


def main():
    """Run the command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--again", help="names of scenes, or their beginnings")
    parser.add_argument("--report", action="store_true")
    parser.add_argument("--plan-of", help=argparse.SUPPRESS)
    parser.add_argument("--folder", type=Path, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.plan_of:
        print_plan(options.plan_of, options.folder)
        return
    rows = stored()
    for name in [] if options.report else SCENES:
        again = options.again is not None and name.startswith(options.again)
        if not again and (options.again is not None or (name, "steps") in rows):
            continue
        with tempfile.TemporaryDirectory() as folder:
            plan = planned(name, Path(folder))
            run = measured(name, Path(folder))
        for quantity, value in run.items():
            bound = LOWER_BOUND if plan["at_least"] and quantity != "memory" else ""
            texts = [f"{bound}{rounded(plan[quantity])}", rounded(value)]
            rows[name, quantity] = texts
        print(name, plan, run, flush=True)
        write(rows)
    report(rows)


if __name__ == "__main__":
    main()
