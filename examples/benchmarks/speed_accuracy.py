"""What each setting costs, and what error it makes.

    python speed_accuracy.py                            # all that the table lacks
    python speed_accuracy.py --case rough --size 100    # one part
    python speed_accuracy.py --plot                     # the picture alone
    python speed_accuracy.py --case pull-off --report   # a table of the guide

Lengths are in spacings a0, and the contact modulus is 1. A row of the table is one
setting: its errors against the same case calculated to a force of 1e-12 of the mean on
an atom in contact (the row 1e-11 shows the error of that), and its cost from a
cold start: pairs of transforms, exact, and seconds, as good as the machine is quiet.
"""

import argparse
import csv
import time
import tracemalloc
from dataclasses import asdict, dataclass, replace
from functools import cache
from itertools import product
from pathlib import Path

import numpy as np
from markdown import ends, order
from markdown import table as print_table

from ase_roughcontact import (
    HardWall,
    LennardJones93,
    RoughContact,
    RoughSphere,
    SelfAffine,
    adhesion_loop,
    load_path,
    substrate,
)
from ase_roughcontact._util.threads import threads
from ase_roughcontact.elasticity.fft import RealFFT2, fast_length
from ase_roughcontact.scene import OPTIMIZERS

HERE = Path(__file__).parent
TABLE = HERE / "speed_accuracy.csv"
IMAGE = HERE / "speed_accuracy.png"
SMALL, LARGE = SIZES = 30, 100  # contact radius of a smooth sphere under the load
SMOOTH = ("smooth", "full")
CASES = ("smooth", "rough", "hard", "adhesive", "full", "resolution")
LEVELS = (1e-2, 1e-4, 1e-8)  # relative errors that are allowed
KEY = ("case", "size", "axis", "setting")
# Errors are relative, that of the height to the penetration, and empty where they are
# none; atoms: too many or too few in contact; iterations: of a loop, its states.
FIELDS = (
    *KEY,
    *("force_error", "height_error", "area_error", "atoms", "energy_error"),
    *("pressure_error", "pull_off_error", "pairs", "iterations", "seconds", "bytes"),
    "converged",
)
REPEATS = 3
MARKS = {
    "tolerance": ("o-", "#0072B2"),
    "float32": ("s", "#D55E00"),
    "polished": ("^", "#009E73"),
    "solver": ("D", "#CC79A7"),
    "level": ("x", "#000000"),
}


@dataclass(frozen=True)
class Settings:
    """All that can be chosen, as it is if nothing else is said."""

    tolerance: float | None = 1e-4  # largest force left / mean force in contact
    accuracy: float | None = None  # in place of the tolerance
    dtype: str = "float64"
    polished: bool = False  # relaxed in float32 to 1e-3, then in float64
    optimizer: str | None = None
    spacing: float = 1.0
    short_wavelength: float = 4.0
    core: float = 0.5
    cutoff: float = 100.0
    cell: int = 0  # side of a periodic cell / diameter of the contact; 0: free
    by_load: bool = False  # the load is given, not the height

    def __str__(self):
        usual = asdict(Settings(None))
        changed = {k: v for k, v in asdict(self).items() if v != usual[k]}
        return " ".join(f"{k}={v}" for k, v in changed.items() if k != "by_load")


def radius_of(case, size):
    """Radius of the sphere: the paper's 1000 a0, or of a slimmer one."""
    return 10.0 * size if case in SMOOTH else 1000.0


def surface_of(case, size, settings):
    longest, domain = (128.0, 512.0) if case == "resolution" else (512.0, 4096.0)
    rough = SelfAffine(
        0.1, 0.8, settings.short_wavelength, longest, seed=1, domain=domain
    )
    return RoughSphere(radius_of(case, size), None if case in SMOOTH else rough)


def wall_of(case, settings):
    if case in ("hard", "resolution"):
        return HardWall()
    if case == "full":  # as stiff as the bulk
        return LennardJones93.full(
            distance=1.0,
            work_of_adhesion=1 / 27,
            cutoff=settings.cutoff,
            core=settings.core,
        )
    work = 0.005 if case == "adhesive" else 0.0
    return LennardJones93.adhesive(1.0, 1.0, work, core=settings.core)


def relaxed(case, size, settings, target, pressure):
    """Relax from a cold start: the record, and the largest pressure.

    The target is a load or a height, `pressure` about the mean one in contact.
    """
    surface, spacing = surface_of(case, size, settings), settings.spacing
    side = (
        fast_length(round(2 * size * settings.cell / spacing)) if settings.cell else 8
    )
    atoms = substrate(
        "Cu",
        (side, side),
        surface,
        spacing=spacing,
        periodic=settings.cell > 0,
        fixed=not settings.by_load,
    )
    first = "float32" if settings.polished else settings.dtype
    atoms.calc = RoughContact(
        surface, 1.0, wall_of(case, settings), fft={"dtype": first}
    )
    options = {
        "loads" if settings.by_load else "heights": [target],
        "optimizer": OPTIMIZERS.get(settings.optimizer),
        "window": "fixed" if settings.cell else "auto",
        "max_steps": 2000,
    }
    unit = pressure * spacing**2
    if settings.accuracy:
        (record,) = load_path(atoms, accuracy=settings.accuracy, **options)
    else:
        to = 1e-3 if settings.polished else settings.tolerance
        (record,) = load_path(atoms, fmax=to * unit, **options)
    if settings.polished:
        atoms.calc.set(fft={"dtype": "float64"})
        (fine,) = load_path(atoms, fmax=settings.tolerance * unit, **options)
        both = ("pairs", "iterations", "seconds")
        spent = {name: getattr(record, name) + getattr(fine, name) for name in both}
        record = replace(fine, **spent)
    return record, float(atoms.calc.state(atoms).pressure.max())


@cache
def reference(case, size, settings):
    """Relax at the load of a smooth contact of this size, or at the height of that."""
    target = 4.0 * size**3 / (3.0 * radius_of(case, size))
    if not settings.by_load:
        under_load = replace(settings, by_load=True)
        target = relaxed(case, size, under_load, target, 0.04)[0].height
    return target, *relaxed(case, size, settings, target, 0.04)


def measured(case, size, axis, settings):
    """Row of a setting."""
    finest = {SMALL: 0.25, LARGE: 0.5}[size] if case == "resolution" else 1.0
    against = Settings(1e-12, spacing=finest, by_load=settings.by_load)
    target, ref, highest = reference(case, size, against)
    arguments = case, size, settings, target, ref.normal_force / ref.contact_area
    record, top = relaxed(*arguments)
    times = [
        relaxed(*arguments)[0].seconds
        for _ in range(REPEATS if record.seconds < 2 else 0)
    ]
    tracemalloc.start()
    relaxed(*arguments)
    memory = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    row = dict(zip(KEY, (case, size, axis, str(settings)), strict=True))
    row["area_error"] = error(record.contact_area, ref.contact_area)
    atoms = (record.contact_area - ref.contact_area) / settings.spacing**2
    row |= {"atoms": round(atoms), "pressure_error": error(top, highest)}
    if not settings.by_load:
        row["force_error"] = error(record.normal_force, ref.normal_force)
        row["energy_error"] = error(record.energy, ref.energy)
    elif case == "resolution":
        row["height_error"] = abs(record.height - ref.height) / abs(ref.penetration)
    row |= {"pairs": round(record.pairs, 1), "iterations": record.iterations}
    row |= {"seconds": min([record.seconds, *times]), "bytes": memory}
    return row | {"converged": record.converged}


def error(value, truth):
    return abs(value / truth - 1.0)


def study(case, size):
    """All settings of a case, each with the name of its axis."""
    if (case, size) == ("full", LARGE):
        return  # the reference reaches so far that it takes minutes
    if case == "resolution":  # 2 to 8 atoms per shortest wavelength, against 16 or 8
        for spacing in (2.0, 1.0, 0.5)[: 3 if size == SMALL else 2]:
            yield case, Settings(1e-6, spacing=spacing, by_load=True)
        return
    for exponent in range(1, 12):
        yield "tolerance", Settings(10.0**-exponent)
    for exponent in (1, 2, 3, 4):
        yield "float32", Settings(10.0**-exponent, dtype="float32")
    for exponent in (4, 8):
        yield "polished", Settings(10.0**-exponent, polished=True)
    for level in LEVELS:
        yield "level", Settings(None, level)
    if case != "hard":
        for core in (0.3, 0.7, 0.9):
            yield "core", Settings(1e-8, core=core)
        if size == SMALL and case != "full":
            for name, exponent in product(("LBFGS", "FIRE2"), (2, 4)):
                yield "solver", Settings(10.0**-exponent, optimizer=name)
    if case == "full":
        return
    for cell in (1, 2, 4):
        yield "periodic", Settings(1e-6, cell=cell, by_load=True)
    for coarse, exponent in product((2.0, 4.0), (6, 2)):
        grid = Settings(10.0**-exponent, spacing=coarse, by_load=True)
        filtered = replace(grid, short_wavelength=4.0 * coarse)
        yield ("spacing" if exponent == 6 else "combination"), filtered


def transforms(size):
    """Planning and 40 pairs, as many as a step takes, on the grid of a contact."""
    side = fast_length(5 * size // 2)
    values = np.ones((side, side))
    for engine, count in product(("ducc0", "pyfftw"), (1, 2)):
        times = []
        for _ in range(REPEATS):
            start = time.perf_counter()
            options = {"engine": engine, "threads": count}
            fft = RealFFT2((side, side), (2 * side, 2 * side), **options)
            weights = fft.multiplier(np.ones(fft.spectrum.shape))
            for _ in range(40):
                fft.filter(values, weights)
            times.append(time.perf_counter() - start)
        name = f"{engine}, {count} threads"
        for when, seconds in ("first", times[0]), ("later", min(times)):
            row = dict(zip(KEY, ("transforms", size, when, name), strict=True))
            yield row | {"pairs": 40, "seconds": seconds}


def pull_offs(size):
    """Loops of smooth spheres on an adhesive wall, by the steps of the path."""
    radius = {SMALL: 50.0, LARGE: 200.0}[size]
    truth = pull_off(radius, 0.05, 1e-4, "high")[0]
    for step, tolerance, level in product(
        (0.1, 0.2, 0.4, 0.8), (1e-4, 1e-3, 1e-2), LEVELS[:2]
    ):
        start = time.perf_counter()
        force, records = pull_off(radius, step, tolerance, level)
        row = ("pull-off", size, "path", f"{step=} {tolerance=} {level=}")
        yield dict(zip(KEY, row, strict=True)) | {
            "pull_off_error": error(force, truth),
            "pairs": round(sum(record.pairs for record in records)),
            "iterations": len(records),
            "seconds": time.perf_counter() - start,
        }


def pull_off(radius, step, tolerance, level):
    """Pull-off force, and the states of the loop."""
    ball = RoughSphere(radius)
    atoms = substrate("Cu", (8, 8), ball, spacing=1.0)
    atoms.calc = RoughContact(ball, 1.0, LennardJones93.adhesive(1.0, 1.0, 0.05))
    loop = adhesion_loop(
        atoms,
        deepest=1.0,
        step=step,
        tolerance=tolerance,
        accuracy=level,
        window="auto",
    )
    return loop.pull_off_force, (*loop.approach, *loop.retraction[1:])


def rows(case, size, done):
    """Rows of a case that are not done yet."""
    if case in CASES:
        for axis, settings in study(case, size):
            if (case, str(size), axis, str(settings)) not in done:
                yield measured(case, size, axis, settings)
    elif not any(row[:2] == (case, str(size)) for row in done):
        yield from {"pull-off": pull_offs, "transforms": transforms}[case](size)


def read(file):
    if not file.exists():
        return []
    with open(file, encoding="utf-8", newline="") as text:
        return list(csv.DictReader(text))


def draw(table, file):
    """Error against cost: what is left and below is better."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 5.5), layout="constrained")
    panels = figure.subplots(2, 4, sharey=True, sharex="col")
    for (row, size), (column, case) in product(enumerate(SIZES), enumerate(CASES[:4])):
        panel = panels[row, column]
        for axis, (mark, colour) in MARKS.items():
            mine = [
                (float(line["pairs"]), max(float(line["force_error"]), 1e-14))
                for line in table
                if (line["case"], line["size"], line["axis"]) == (case, f"{size}", axis)
                and line["converged"] == "True"
            ]
            if mine:
                panel.loglog(*zip(*mine, strict=True), mark, color=colour, label=axis)
        panel.set_title(f"{case}, {size} atoms", fontsize=10)
        panel.set(xlim=(15, 900), xticks=(20, 50, 100, 200, 500))
        panel.xaxis.set_major_formatter("{x:g}")
        panel.xaxis.set_minor_formatter("")
    for panel in panels[1]:
        panel.set_xlabel("pairs of transforms")
    for panel in panels[:, 0]:
        panel.set_ylabel("relative error of the force")
    panels[0, 0].legend(frameon=False, fontsize=8)
    figure.savefig(file, dpi=120)


def report_pull_off(lines):
    """Print the error of the pull-off force against the tolerance of the path."""
    rows = []
    for tolerance in (1e-2, 1e-3, 1e-4):
        mine = [row for row in lines if f" tolerance={tolerance} " in row["setting"]]
        errors = [
            ends([float(row["pull_off_error"]) for row in mine if row["size"] == size])
            for size in map(str, SIZES)
        ]
        cost = [
            ends([int(row[name]) for row in mine], str)
            for name in ("iterations", "pairs")
        ]
        rows.append((order(tolerance), *errors, *cost))
    print_table("tolerance | R = 50 $a_0$ | R = 200 $a_0$ | states | FFT pairs", rows)


def report_cells(lines):
    """Print the error of the area in periodic cells."""
    found = {(row["case"], row["size"], row["setting"]): row for row in lines}
    cases = [(case, str(size)) for case in ("smooth", "rough") for size in SIZES]
    rows = []
    for cell in (1, 2, 4):
        mine = [found[(*case, str(Settings(1e-6, cell=cell)))] for case in cases]
        errors = [f"{100 * float(row['area_error']):.2g} %" for row in mine]
        rows.append((cell, *errors, f"{float(mine[1]['bytes']) / 1e6:.0f} MB"))
    free = found["smooth", "100", str(Settings(1e-6))]
    rows.append(("free boundary", *[0] * 4, f"{float(free['bytes']) / 1e6:.0f} MB"))
    heads = [f"{case}, {size}" for case, size in cases]
    print_table(
        f"cell / diameter of the contact | {' | '.join(heads)} | memory, smooth, 100",
        rows,
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    every = (*CASES, "pull-off", "transforms")
    parser.add_argument("--case", nargs="*", choices=every, default=every)
    parser.add_argument("--size", nargs="*", type=int, choices=SIZES, default=SIZES)
    parser.add_argument("--table", type=Path, default=TABLE)
    parser.add_argument("--plot", action="store_true", help="only draw")
    parser.add_argument("--report", action="store_true", help="print a table")
    options = parser.parse_args()
    if options.report:
        lines = [row for row in read(options.table) if row["case"] in options.case]
        (report_pull_off if "pull-off" in options.case else report_cells)(lines)
        return
    done = {tuple(row[name] for name in KEY) for row in read(options.table)}
    with open(options.table, "a", encoding="utf-8", newline="") as file, threads(1):
        writer = csv.DictWriter(file, FIELDS)
        if not done:
            writer.writeheader()
        for size, case in product(options.size, options.case):
            for row in () if options.plot else rows(case, size, done):
                rounded = {
                    k: f"{v:.3g}" if isinstance(v, float) else v for k, v in row.items()
                }
                writer.writerow(rounded)
                file.flush()
                print(*rounded.values(), flush=True)
    own = options.table != TABLE
    draw(read(options.table), options.table.with_suffix(".png") if own else IMAGE)


if __name__ == "__main__":
    main()
