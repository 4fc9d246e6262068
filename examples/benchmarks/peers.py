r"""Our solvers and their peers on the same input, in one run.

    python peers.py --sizes 512 1024 --problems hard repulsive --repeat 3
    python peers.py --sizes 512 --codes ours aspher tamaas --table-only

Peers come with ``pip install ase-roughcontact[bench]``; those that are missing are
skipped. ASPHER is fastest when built for the machine's own processor::

    pip install --no-binary aspher aspher -C cmake.define.ASPHER_NATIVE=ON

Every code solves the problems of `problems.py`, each solution cold; sizes are powers
of two from 64. A row is appended to the CSV file as soon as it is known, and what the
file has is not run again. At the end a table is printed for every problem:

setup, seconds
    least time over the repeats, for what depends on the grid alone and for the
    solution; with one thread that of the processor;
pairs of time
    seconds divided by the time of one of our convolutions, one padded pair of
    transforms, timed just before and after: about the same on any machine;
convolutions
    that the code itself counts, coarse grids of ours by their share; without those of
    a preconditioner for ASPHER;
x ours
    seconds over those of our array-level solver;
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
from problems import WALLS, Answer, Problem, optimality_residuals

COLUMNS = {
    "setup": "9.3f",
    "seconds": "9.3f",
    "x ours": "8.2f",
    "pairs of time": "14.1f",
    "iterations": "11.0f",
    "convolutions": "13.1f",
    "area": "9.0f",
    "height": "10.5f",
    "load error": "11.1e",
    "gap": "9.1e",
    "overlap": "9.1e",
    "tension": "9.1e",
    "plastic": "9.0f",
    "excess": "9.1e",
    "residual": "9.1e",
}
KEY = ("problem", "n", "threads", "code")
FIELDS = [*KEY, *(name for name in COLUMNS if name != "x ours"), "pair seconds"]
WARM_UP = 64


def main() -> None:
    options = arguments()
    pin_threads(options.threads)
    if options.threads == 1:  # other programs may use the machine
        codes.perf_counter = time.process_time
    if not options.table_only:
        for kind in options.problems:
            for n in options.sizes:
                measure(Problem(kind, n), options)
    known = read(options.csv).values()
    rows = [row for row in known if row["code"] in options.codes]
    for kind in options.problems:
        for n in options.sizes:
            key = (kind, str(n), str(options.threads))
            table([row for row in rows if tuple(row[name] for name in KEY[:3]) == key])


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
    parser.add_argument("--csv", type=Path, default=Path("peers.csv"))
    parser.add_argument("--table-only", action="store_true")
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
    with path.open(newline="") as file:
        return {tuple(row[name] for name in KEY): row for row in csv.DictReader(file)}


def write(path: Path, row: dict) -> None:
    new = not path.exists()
    with path.open("a", newline="") as file:
        writer = csv.DictWriter(file, FIELDS)
        if new:
            writer.writeheader()
        writer.writerow(row)


def table(rows: list[dict[str, str]]) -> None:
    """Print the rows of one problem, with the columns that it has."""
    if not rows:
        return
    ours = [float(row["seconds"]) for row in rows if row["code"] == "ours"]
    for row in rows:
        row["x ours"] = str(float(row["seconds"]) / ours[0]) if ours else ""
    shown = {
        name: style for name, style in COLUMNS.items() if any(row[name] for row in rows)
    }
    first = rows[0]
    print(f"\n{first['problem']}, n = {first['n']}, {first['threads']} threads")
    heads = (f"{name:>{style.split('.')[0]}}" for name, style in shown.items())
    print(f"{'code':18}", *heads)
    for row in sorted(rows, key=lambda row: float(row["seconds"])):
        cells = (
            f"{float(row[name]):{style}}" if row[name] else " " * len(f"{0:{style}}")
            for name, style in shown.items()
        )
        print(f"{row['code']:18}", *cells)


if __name__ == "__main__":
    main()
