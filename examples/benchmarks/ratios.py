r"""Time of ASPHER in units of ours, over sizes and contact areas.

    OMP_NUM_THREADS=1 python ratios.py --sizes 128 256 512 1024 2048 --csv ratios.csv

The indenters are those of `problems.py`: a rough paraboloid on a free half space and a
rough flat surface on a periodic one, under loads at which some 1 to 99 % of the atoms
are in contact. Each code solves each problem cold. The tolerance of ASPHER is the
loosest one of a series at which the largest gap in contact or overlap, by the judge of
all codes (`problems.optimality_residuals`), is at most that asked of ours. Times are
those of the processor, the least of several runs in turns: they may be taken while
other programs use the machine.

A row is written as soon as it is known, and what the file has is not run again. The
tolerances of ASPHER may be those of an earlier file:

    python ratios.py --sizes 1024 --tolerances ratios.csv --csv again.csv

At the end the table of the README is printed: the times of the faster way of ASPHER
over those of our arrays and of our ASE atoms. ``--sizes`` without numbers runs nothing
else.
"""

import argparse
import csv
import time
from dataclasses import dataclass
from pathlib import Path

import codes
import numpy as np
from markdown import table
from problems import TOLERANCE, Problem, optimality_residuals
from scipy.special import erfinv

WAYS = {"aspher": codes.solve_aspher, "aspher-nested": codes.solve_aspher_nested}
OURS = {"arrays": codes.solve_ours, "ase": codes.solve_ours_ase}
SERIES = 10.0 ** -np.arange(5.0, 9.5, 0.5)  # tolerances of ASPHER
# Mean pressure on the window, in units of E*, for the part of it in contact.
PARTS = (0.3, 0.01, 0.99, 0.1, 0.6, 0.9)
FREE = dict(zip(PARTS, (1.6e-2, 4e-4, 0.18, 4.5e-3, 3.8e-2, 8.8e-2), strict=True))
FIELDS = [
    *("boundary", "n", "part", "contact", "residual ours", "arrays", "ase"),
    *(f"{name} {what}" for name in WAYS for what in ("seconds", "tol", "residual")),
]
KEY = ("boundary", "n", "part")
KINDS = {"free": "hard", "periodic": "periodic"}


@dataclass(frozen=True)
class Pressed(Problem):
    """Problem under a load at which about a part of the window is in contact."""

    part: float = 0.3

    @property
    def load(self) -> float:
        """Force on the indenter."""
        # periodic: Persson's theory for the rms slope of 0.1
        persson = 0.1 * erfinv(self.part) / 2**0.5
        return self.n**2 * (persson if self.periodic else FREE[self.part])


def residual(problem, answer):
    found = optimality_residuals(problem, answer)
    return max(found["gap"], found["overlap"])


def matched(solve, problem, first):
    """Return the loosest tolerance that is tight enough, and its residual."""
    found = {}
    k = first
    while k not in found:
        codes._ASPHER = float(SERIES[k])
        found[k] = residual(problem, solve(problem))
        if found[k] > TOLERANCE and k + 1 < len(SERIES):
            k += 1
        elif found[k] <= TOLERANCE and k > 0 and found.get(k - 1, 0.0) <= TOLERANCE:
            k -= 1
    k = min((j for j in found if found[j] <= TOLERANCE), default=len(SERIES) - 1)
    return k, found[k]


def measure(problem, guess, patience, earlier=None):
    """Return the row of a problem; `guess` keeps the tolerances of the last one."""
    row, best, spent = {}, {}, 0.0
    for name, solve in WAYS.items():
        if earlier is not None:
            row[f"{name} tol"] = float(earlier[f"{name} tol"])
            continue
        guess[name], _ = matched(solve, problem, guess.get(name, 4))
        row[f"{name} tol"] = float(SERIES[guess[name]])
    while spent < patience:
        for name, solve in {**OURS, **WAYS}.items():
            if name in WAYS:
                codes._ASPHER = row[f"{name} tol"]
            answer = solve(problem)
            first = name not in best
            best[name] = min(best.get(name, np.inf), answer.seconds)
            spent += answer.setup + answer.seconds
            if first and name in WAYS:
                row[f"{name} residual"] = residual(problem, answer)
            elif first and name == "arrays":
                row["residual ours"] = residual(problem, answer)
                row["contact"] = np.count_nonzero(answer.pressure) / problem.n**2
    for name, seconds in best.items():
        row[name if name in OURS else f"{name} seconds"] = seconds
    return row


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--sizes", type=int, nargs="*", default=[128, 256, 512])
    parser.add_argument("--parts", type=float, nargs="+", default=PARTS)
    parser.add_argument("--patience", type=float, default=10.0, help="seconds a row")
    parser.add_argument("--boundaries", nargs="+", choices=KINDS, default=list(KINDS))
    parser.add_argument("--tolerances", type=Path, help="CSV file of an earlier run")
    parser.add_argument("--csv", type=Path, default=Path("ratios.csv"))
    parser.add_argument("--report", action="store_true", help="print the stored table")
    options = parser.parse_args()
    if options.report:
        report(read(Path(__file__).with_suffix(".csv")))
        return
    codes.perf_counter = time.process_time
    known = read(options.csv)
    earlier = read(options.tolerances) if options.tolerances else {}
    guess = {}
    for n in options.sizes:
        for boundary in options.boundaries:
            for part in options.parts:
                key = (boundary, str(n), str(part))
                if key in known:
                    continue
                problem = Pressed(KINDS[boundary], n, part=part)
                row = dict(zip(KEY, key, strict=True))
                row |= measure(problem, guess, options.patience, earlier.get(key))
                with options.csv.open("a", newline="") as file:
                    writer = csv.DictWriter(file, FIELDS)
                    if not known:
                        writer.writeheader()
                    writer.writerow(row)
                known[key] = row
                show(row)
    report(known)


def read(path):
    """Return the rows of a file by boundary, size and part in contact."""
    if not path.exists():
        return {}
    with path.open(newline="") as file:
        return {tuple(row[name] for name in KEY): row for row in csv.DictReader(file)}


def show(row):
    ours = [float(row[name]) for name in OURS]
    peers = [float(row[f"{name} seconds"]) for name in WAYS]
    ratios = " ".join(f"{peer / mine:6.2f}" for peer in peers for mine in ours)
    print(
        f"{row['boundary']:9}{row['n']:>5} {100 * float(row['contact']):6.1f} %  "
        f"{ours[0]:8.3f} s  {ratios}  residuals {float(row['residual ours']):.1e} "
        + " ".join(f"{float(row[f'{name} residual']):.1e}" for name in WAYS),
        flush=True,
    )


def report(rows):
    """Print the ratios of the faster way of ASPHER, of all sizes and parts."""
    parts = sorted(PARTS)
    table(
        " | ".join(("boundary", "n", *(f"{100 * part:.0f} %" for part in parts))),
        (
            (boundary, n, *(cell(rows.get((boundary, str(n), str(p)))) for p in parts))
            for boundary in KINDS
            for n in sorted({int(key[1]) for key in rows if key[0] == boundary})
        ),
    )


def cell(row):
    if row is None:
        return ""
    peer = min(float(row[f"{name} seconds"]) for name in WAYS)
    return " / ".join(f"{peer / float(row[name]):#.3g}" for name in OURS)


if __name__ == "__main__":
    main()
