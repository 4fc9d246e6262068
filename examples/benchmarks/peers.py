r"""Our solvers and their peers on the same input, in one run.

    python peers.py --sizes 512 1024 --problems hard repulsive --repeat 3
    python peers.py --report    # the table of the guide, from peers.csv

Peers come with ``pip install ase-roughcontact[bench]``; those that are missing are
skipped. ASPHER is fastest when built for the machine's own processor::

    pip install --no-binary aspher aspher -C cmake.define.ASPHER_NATIVE=ON

Every code solves the problems of `problems.py`, each solution cold; sizes are powers
of two from 64. A row is appended to the CSV file as soon as it is known, and what the
file has is not run again. Its columns:

setup, seconds
    least time over the repeats, for what depends on the grid alone and for the
    solution; with one thread that of the processor;
pairs of time
    seconds divided by the time of one of our convolutions, one padded pair of
    transforms, timed just before and after: about the same on any machine;
convolutions
    that the code itself counts, coarse grids of ours by their share; without those of
    a preconditioner for ASPHER;
area, height, load error, gap, overlap, tension, residual
    atoms in contact and height, relative error of the load, and from one judge
    (`problems.optimality_residuals`): largest gap in contact, deepest overlap, most
    negative pressure, atoms at the hardness and largest excess over it; for soft walls
    the largest force left on an atom. Adhesion may find different minima: compare area
    and load before times.
"""

from __future__ import annotations

import argparse
import csv
import os
import sys
import time
from pathlib import Path

import codes
import numpy as np
from codes import SOLVERS, Solver, timed
from markdown import order, table
from problems import WALLS, Answer, Problem, optimality_residuals

KEY = ("problem", "n", "threads", "code")
FIELDS = (
    *KEY,
    *(
        "setup",
        "seconds",
        "pairs of time",
        "iterations",
        "convolutions",
        "area",
        "height",
    ),
    *("load error", "gap", "overlap", "tension", "plastic", "excess", "residual"),
    "pair seconds",
)
TITLES = {
    "hard": "hard, sphere",
    "periodic": "hard, flat",
    "plastic": "plastic, sphere",
    "plastic-periodic": "plastic, flat",
    "repulsive": "repulsive, as stiff as the solid, sphere",
    "exponential": "exponential attraction, sphere",
    "exponential-periodic": "exponential attraction, flat",
    "dugdale-periodic": "Dugdale's attraction, flat",
    "adhesive-0.0005": "9-3, w/E* = 0.0005 a0, sphere",
    "adhesive-0.005": "9-3, w/E* = 0.005 a0, sphere",
}
NAMES = {
    "aspher": "ASPHER",
    "aspher-nested": "ASPHER, nested",
    "contactmechanics": "ContactMechanics",
    "tamaas": "Tamaas",
    "tamaas-adhesion": "Tamaas, Rey's method",
    "adhesion-scipy": "Adhesion, L-BFGS of SciPy",
    "adhesion-numpi": "Adhesion, L-BFGS of NuMPI",
    "adhesion-newton": "Adhesion, trust-region Newton",
    "adhesion-bounded": "Adhesion, bounded L-BFGS",
}
WARM_UP = 64


def main() -> None:
    options = arguments()
    pin_threads(options.threads)
    if options.threads == 1:  # other programs may use the machine
        codes.perf_counter = time.process_time
    for kind in () if options.report else options.problems:
        for n in options.sizes:
            measure(Problem(kind, n), options)
    rows = read(options.csv).values()
    report(
        sorted(
            rows, key=lambda row: (list(TITLES).index(row["problem"]), int(row["n"]))
        )
    )


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    names = list({name: None for solvers in SOLVERS.values() for name in solvers})
    parser.add_argument("--sizes", type=int, nargs="+", default=[512, 1024])
    parser.add_argument("--problems", nargs="+", choices=WALLS, default=list(WALLS))
    parser.add_argument("--codes", nargs="+", choices=names, default=names)
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument(
        "--patience", type=float, default=60, help="seconds after which not to repeat"
    )
    parser.add_argument(
        "--threads",
        type=int,
        default=os.environ.get("OMP_NUM_THREADS", 2),
        help="default: OMP_NUM_THREADS, else 2",
    )
    parser.add_argument("--csv", type=Path, default=Path(__file__).with_suffix(".csv"))
    parser.add_argument("--report", action="store_true", help="only print the table")
    return parser.parse_args()


def pin_threads(count: int) -> None:
    """Start again with threads for transforms and peers, and one for BLAS.

    Threads of BLAS would fight with all others, and cost SciPy's L-BFGS the most.
    """
    threads = {"OMP_NUM_THREADS": str(count), "OPENBLAS_NUM_THREADS": "1"}
    if not threads.items() <= os.environ.items():
        os.execve(sys.executable, [sys.executable, *sys.argv], os.environ | threads)


def measure(problem: Problem, options: argparse.Namespace) -> None:
    """Run the codes that the file does not have yet."""
    for code, solve in SOLVERS[problem.solvers].items():
        key = (problem.kind, str(problem.n), str(options.threads), code)
        if code not in options.codes or key in read(options.csv):
            continue
        try:
            solve(Problem(problem.kind, WARM_UP))
        except ImportError as missing:
            print(f"{code}: skipped, {missing}", flush=True)
            continue
        row = dict(zip(KEY, key, strict=True)) | measured(problem, solve, options)
        write(options.csv, row)
        print(f"{problem.kind} {problem.n} {code}: {row['seconds']:.3f} s", flush=True)


def measured(
    problem: Problem, solve: Solver, options: argparse.Namespace
) -> dict[str, float | None]:
    """Row of one code: least times, and the optimality_residuals of the last answer."""
    pair = pair_seconds(problem)
    answers: list[Answer] = []
    spent = 0.0
    while len(answers) < options.repeat and spent < options.patience:
        answers.append(solve(problem))
        spent += answers[-1].setup + answers[-1].seconds
    pair = min(pair, pair_seconds(problem))
    seconds = min(answer.seconds for answer in answers)
    last = answers[-1]
    return {
        "setup": min(answer.setup for answer in answers),
        "seconds": seconds,
        "pair seconds": pair,
        "pairs of time": seconds / pair,
        "iterations": last.iterations,
        "convolutions": last.convolutions,
    } | optimality_residuals(problem, last)


def pair_seconds(problem: Problem, repeat: int = 10) -> float:
    """Least time of one convolution, a padded pair of transforms."""
    halfspace = problem.contact().halfspace
    pressure = np.ones(problem.shape)
    return min(timed(halfspace.displacement, pressure)[0] for _ in range(repeat))


def read(path: Path) -> dict[tuple, dict[str, str]]:
    """Rows of the file by their keys."""
    if not path.exists():
        return {}
    with path.open(encoding="utf-8", newline="") as file:
        return {tuple(row[name] for name in KEY): row for row in csv.DictReader(file)}


def write(path: Path, row: dict) -> None:
    new = not path.exists()
    with path.open("a", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, FIELDS)
        if new:
            writer.writeheader()
        writer.writerow(row)


def report(rows: list[dict[str, str]]) -> None:
    """Print the times of other codes in units of ours, and what each left."""
    ours = {tuple(row[name] for name in KEY): row for row in rows}
    lines = []
    for row in rows:
        *key, code = (row[name] for name in KEY)
        if code.startswith("ours"):
            continue
        arrays, atoms = (ours[(*key, name)] for name in ("ours", "ours-ase"))
        times = [
            float(row["seconds"]) / float(one["seconds"]) for one in (arrays, atoms)
        ]
        lines.append(
            (
                TITLES[row["problem"]],
                row["n"],
                NAMES.get(code, code),
                *(f"{time:.2g}" if time < 10 else f"{time:.0f}" for time in times),
                *(order(left(one)) for one in (arrays, row)),
            )
        )
    heads = "wall and indenter | n | other code | over arrays | over atoms"
    table(f"{heads} | left by arrays | by the other", lines)


def left(row: dict[str, str]) -> float:
    """Return the largest gap, overlap, excess over the hardness or force."""
    names = ("gap", "overlap", "excess", "residual")
    return max(float(row[name]) for name in names if row[name])


if __name__ == "__main__":
    main()
