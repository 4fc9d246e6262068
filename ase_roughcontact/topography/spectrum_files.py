"""Power spectra from text files, with the convention of their normalisation.

Read are tables with a head such as ``q (1/nm), C2D (nm^4)``, and the files .csv and
.txt of contact.engineering, which have one data series after the other.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from unicodedata import normalize

import numpy as np

from ase_roughcontact._util.callers import warn
from ase_roughcontact._util.rounding import RATIO_ROUNDING
from ase_roughcontact._util.units import LENGTHS
from ase_roughcontact._util.validation import FloatArray, lookup
from ase_roughcontact.topography.profile_spectrum import isotropic_density

#: Names of conventions: how the mean square height follows from the density.
CONVENTIONS = {
    "C2D": "<h^2> = 1/(4 pi^2) int C2D d^2q = 1/(2 pi) int q C2D dq",
    "q/pi C2D": "C2D times q/pi, <h^2> = 1/2 int (q/pi C2D) dq",
    "C1D": "<h^2> = 1/pi int C1D dq, over q > 0 of profiles",
    "C1D+": "<h^2> = 1/(2 pi) int C1D+ dq, over q > 0 of profiles",
}
# Power of length of the density of each convention.
_POWERS = {"C2D": 4, "q/pi C2D": 3, "C1D": 3, "C1D+": 3}
# Series of contact.engineering, the preferred one first, and their conventions.
_SERIES = {"q/\u03c0 \u00d7 2D PSD": "q/pi C2D", "1D PSD along x": "C1D"}
_SERIES |= {"1D PSD along y": "C1D"}
# Least number of rows of a table.
_MIN_ROWS = 3
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|nan|[-+]?inf", re.I)
# A name of a column with its unit in brackets.
_HEAD = re.compile(r"([^,;\t()\[\]]+?)\s*[(\[]([^)\]]*)[)\]]")
_UNIT = re.compile(r"(?P<inverse>1?/)?(?P<name>[^\W\d]+)(?P<power>-?\d)?")


@dataclass(frozen=True, eq=False)
class Series:
    """Table of a file: a name, heads with units of two columns, and rows."""

    name: str
    heads: tuple[tuple[str, str], ...]
    rows: FloatArray

    @property
    def convention(self) -> str:
        """Convention that the name of the series or of a column says; or empty."""
        for name in (self.name, *(head for head, _ in self.heads)):
            if found := _SERIES.get(name, name if name in CONVENTIONS else ""):
                return found
        return ""


def read_spectrum(
    file: str, convention: str = "", series: str = "", unit: str = ""
) -> tuple[FloatArray, FloatArray]:
    """Return wave numbers (1/Å) and the isotropic power spectrum C2D (Å^4) of a file.

    Parameters
    ----------
    file : str
        Text file.
    convention : {"C2D", "q/pi C2D", "C1D", "C1D+"}
        Normalisation; see `CONVENTIONS`. By default as the file says.
    series : str
        Name of the data series of a file of contact.engineering; by default the
        two-dimensional one, if there is one, else profiles along x.
    unit : str
        Unit of length of a table without units.

    Rows with the same wave number are averaged.

    Raises
    ------
    ValueError
        If the file can't be read, has a negative or infinite density or no positive
        ones, or convention, unit or series are not known.
    """
    found = _chosen(_tables(file), file, series)
    named = found.convention
    if not (convention or named):
        choices = ", ".join(f'"{each}"' for each in CONVENTIONS)
        raise ValueError(
            f"{file!r} does not say how its spectrum is normalised: give convention, "
            f"one of {choices}"
        )
    convention = convention or named
    lookup(convention, CONVENTIONS, "convention")
    if named and convention != named:
        raise ValueError(
            f"{file!r} has a spectrum {named}, got convention = {convention!r}: omit it"
        )
    units = [text for _, text in found.heads] or ["", ""]
    scales = [
        _scale(text, power, unit, file)
        for text, power in zip(units, (-1, _POWERS[convention]), strict=False)
    ]
    q, density = (found.rows * scales).T
    wrong = (density < 0.0) | np.isinf(density)
    if wrong.any():
        row = found.rows[wrong][0]
        raise ValueError(
            f"{file!r} has the density {row[1]:g} at q = {row[0]:g}: leave out rows "
            "without a positive density"
        )
    kept = (q > 0.0) & (density > 0.0)  # NaN and empty bins are left out
    q, density = _averaged(q[kept], density[kept], file)
    if len(q) < _MIN_ROWS:
        raise ValueError(
            f"{file!r} has {len(q)} rows with a positive wave number and density: a "
            f"spectrum needs {_MIN_ROWS} or more"
        )
    return q, two_dimensional(q, density, convention)


def _averaged(
    q: FloatArray, density: FloatArray, file: str
) -> tuple[FloatArray, FloatArray]:
    """Return increasing wave numbers, and the mean density of rows with the same one.

    Warns of such rows, unless their densities are equal.
    """
    numbers, row, counts = np.unique(q, return_inverse=True, return_counts=True)
    mean = np.bincount(row, density) / counts
    differ = ~np.isclose(density, mean[row], rtol=RATIO_ROUNDING, atol=0.0)
    if differ.any():
        repeated = np.unique(row[differ]).size
        warn(
            f"{file!r} has {repeated} wave numbers more than once, with different "
            "densities, which are averaged: are these several spectra?"
        )
    return numbers, mean


def two_dimensional(
    q: FloatArray, density: FloatArray, convention: str = "C2D"
) -> FloatArray:
    """Return C2D of an isotropic surface from a spectrum of some convention."""
    if convention == "C2D":
        return density
    if convention == "q/pi C2D":
        return np.pi / q * density
    half = 0.5 if convention == "C1D+" else 1.0
    return isotropic_density(q, half * density)


def _tables(file: str) -> list[Series]:
    try:
        text = Path(file).read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise ValueError(f"cannot read a spectrum from {file!r}: {error}") from error
    lines = normalize("NFC", text).splitlines()
    if lines and "Data series" in lines[0]:
        return list(_columns_of_service(lines))
    return list(_blocks(lines))


def _columns_of_service(lines: Sequence[str]) -> Iterator[Series]:
    """Yield the data series of a file .csv of contact.engineering."""
    rows = list(csv.DictReader(lines, delimiter=";"))
    first = list(rows[0]) if rows else []
    start = first.index("Function name") + 2 if "Function name" in first else 0
    columns = first[start : start + 2]
    heads = tuple(match for column in columns for match in _HEAD.findall(column))
    for name in dict.fromkeys(
        (row["Subject name"], row["Data series"]) for row in rows
    ):
        values = [
            [float(row[column] or "nan") for column in columns]
            for row in rows
            if (row["Subject name"], row["Data series"]) == name
        ]
        yield Series(name[1], heads, np.array(values))


def _blocks(lines: Sequence[str]) -> Iterator[Series]:
    """Yield tables: two columns of numbers below lines of text."""
    name, heads, rows = "", tuple[tuple[str, str], ...](), list[list[float]]()
    for line in [*lines, "#"]:
        words = re.split(r"[,;\s]+", line.strip().strip(",;"))
        if all(_NUMBER.fullmatch(word) for word in words) and len(words) > 1:
            rows.append([float(word) for word in words[:2]])
            continue
        if not line.strip():
            continue
        if rows:
            yield Series(name, heads, np.array(rows))
            rows = []
        text = line.lstrip("# \t").rstrip()
        found = _HEAD.findall(text.removeprefix("Columns:"))
        if len(found) > 1:
            heads = tuple((head.strip(), unit) for head, unit in found[:2])
        elif text in _SERIES:
            name = text


def _chosen(tables: Sequence[Series], file: str, series: str) -> Series:
    """Return the table with a name, by default the first of `_SERIES`."""
    if not tables:
        raise ValueError(
            f"{file!r} has no table of two columns, wave number and density, below a "
            "head such as: q (1/nm), C2D (nm^4)"
        )
    names = [each.name for each in tables]
    if not series:
        series = next((name for name in _SERIES if name in names), names[0])
    found = [each for each in tables if each.name == series]
    if not found:
        lookup(series, dict.fromkeys(names), "series")
    if len(found) > 1:
        raise ValueError(
            f"{file!r} has the spectra of {len(found)} measurements: give a file of one"
        )
    return found[0]


def _scale(text: str, power: int, unit: str, file: str) -> float:
    """Return a unit, such as "1/nm" or "nm³", in Å to the power that it must have."""
    plain = normalize("NFKC", text).replace("\u2212", "-")
    for each in ("^", "*", "{", "}", " "):
        plain = plain.replace(each, "")
    found = _UNIT.fullmatch(plain or unit)
    name = found["name"] if found else ""
    if name not in LENGTHS:
        raise ValueError(
            f"unit {text or unit!r} of {file!r} is not known: give a head such as "
            "q (1/nm), C2D (nm^4), or unit"
        )
    given = int(found["power"] or 1) * (-1 if found["inverse"] else 1)  # type: ignore[index]
    if plain and given != power:
        raise ValueError(
            f"{file!r} has the unit {text}, and needs length to the power {power}: is "
            "the convention right?"
        )
    return float(LENGTHS[name] ** power)
