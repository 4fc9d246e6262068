"""The table of the guide: published results, and what the stored rows give.

    python examples/published/report.py --report

Each script calculates what its own table lacks.
"""

import argparse
import math
import sys
from importlib import import_module
from pathlib import Path

from published import HERE, claims, numbers, read_rows

sys.path.append(str(Path(__file__).resolve().parents[1] / "benchmarks"))
from markdown import table

SCRIPTS = (
    "light_contact",
    "nayak",
    "area_law",
    "challenge",
    "percolation",
    "punches",
    "lateral",
    "uniform_pressure",
    "wavy_sphere",
)


def values(script):
    """Return the values of a script's claims from its stored rows."""
    rows = numbers(read_rows(HERE / f"{script}.csv"))
    return import_module(script).reported(rows)


def with_error(value):
    """Return a number and its standard error, to two digits of the error."""
    if math.isnan(value.error):
        return f"{value.value:.3g}"
    if value.error < 5e-5:
        return f"{value.value:.4f}"
    digits = min(max(1 - math.floor(math.log10(value.error)), 2), 4)
    return f"{value.value:.{digits}f} ± {value.error:.{digits}f}"


def deviation(value, claim):
    """Return the deviation from a published number in %."""
    if math.isnan(claim.number):
        return ""
    return f"{100.0 * (value.value / claim.number - 1.0):+.2g} %"


def report():
    """Print the table."""
    known, lines = claims(), []
    for script in SCRIPTS:
        for key, value in values(script).items():
            claim = known[key]
            agrees = "yes" if value.agrees(claim) else "**no**"
            lines.append(
                (
                    *(claim.quantity, claim.source, claim.published, claim.criterion),
                    *(with_error(value), deviation(value, claim), agrees),
                    f"`{script}.py`",
                )
            )
    head = "quantity | source | published | agrees if"
    table(f"{head} | here | deviation | agrees | script", lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--report", action="store_true", help="print the table")
    parser.parse_args()
    report()
