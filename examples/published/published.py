"""What papers report, `papers/claims.csv`, and the rows that scripts calculate for it.

A script has the names of its columns `FIELDS`, those that tell its cases apart first,
`CASES`, `calculate(*case)`, which yields rows, and `reported(rows)`, which returns a
`Value` for each of its claims. Without arguments it calculates the cases that its table
lacks.
"""

import csv
import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent


@dataclass(frozen=True)
class Claim:
    """A published result, and the range of numbers that agree with it.

    `number` is the published one, NaN where that is a range or a tendency.
    """

    key: str
    quantity: str
    source: str
    published: str
    number: float
    least: float
    most: float
    criterion: str


@dataclass(frozen=True)
class Value:
    """A calculated number, its standard error, and the number that a claim is put to.

    By default that is the number itself.
    """

    value: float
    error: float = math.nan
    tested: float = math.nan

    def agrees(self, claim: Claim) -> bool:
        """Whether the number lies within the range of a claim."""
        tested = self.value if math.isnan(self.tested) else self.tested
        return claim.least <= tested <= claim.most

    @classmethod
    def mean(cls, values: Iterable[float]) -> "Value":
        """Return the mean of independent values and its standard error."""
        array = np.array(list(values), dtype=float)
        if len(array) < 2:
            return cls(float(array.mean()))
        return cls(float(array.mean()), float(array.std(ddof=1) / len(array) ** 0.5))


def claims() -> dict[str, Claim]:
    """Return the claims by their keys."""
    found = {}
    for row in read_rows(HERE / "papers" / "claims.csv"):
        values = {name: float(row[name]) for name in ("number", "least", "most")}
        found[row["key"]] = Claim(**(row | values))
    return found


def read_rows(file: Path) -> list[dict]:
    """Return the rows of a table, as texts by the names of the columns."""
    with file.open(encoding="utf-8", newline="") as lines:
        return list(csv.DictReader(lines))


def numbers(rows: Iterable[dict]) -> list[dict[str, float]]:
    """Return rows with numbers in place of texts."""
    return [{name: float(value) for name, value in row.items()} for row in rows]


def rows_of(fields: tuple[str, ...], rows: Iterable[tuple]) -> list[dict[str, float]]:
    """Return calculated rows as they are read from a table."""
    return [dict(zip(fields, map(float, row), strict=True)) for row in rows]


def by(rows: Iterable[dict], *names: str) -> dict[tuple, list[dict]]:
    """Return rows in groups of the same values of some columns."""
    groups: dict[tuple, list[dict]] = {}
    for row in rows:
        groups.setdefault(tuple(row[name] for name in names), []).append(row)
    return groups


def finest(rows: Iterable[dict]) -> list[dict]:
    """Return the rows with the most points of each seed."""
    kept = []
    for steps in by(rows, "seed").values():
        most = max(step["points"] for step in steps)
        kept += [step for step in steps if step["points"] == most]
    return kept


def run(
    script: str,
    fields: tuple[str, ...],
    cases: Iterable[tuple],
    calculate: Callable[..., Iterator[tuple]],
) -> None:
    """Calculate the cases that the table beside a script lacks."""
    table = Path(script).with_suffix(".csv")
    if not table.exists():
        table.write_text(",".join(fields) + "\n", "utf-8")
    known = {tuple(row.values()) for row in read_rows(table)}
    for case in map(tuple, cases):
        if any(row[: len(case)] == tuple(map(str, case)) for row in known):
            continue
        rows = [tuple(f"{v:.8g}" for v in row[len(case) :]) for row in calculate(*case)]
        with table.open("a", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerows((*case, *row) for row in rows)
