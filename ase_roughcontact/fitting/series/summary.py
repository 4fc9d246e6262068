"""Summary of the fits of many curves: medians, quartiles, reasons of failures."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from itertools import chain

import numpy as np

from ase_roughcontact._util.printing import Printed, number, table
from ase_roughcontact._util.units import UNITS, pressure_unit
from ase_roughcontact._util.validation import FloatArray
from ase_roughcontact.fitting.series.row import SEPARATOR, FittedCurve

# Quantities with quartiles, and their units; the modulus has a unit by its size.
_SHOWN = {
    "contact_modulus": "",
    "relaxation_time": "s",
    "work_of_adhesion": "J/m²",
    "pull_off_force": "nN",
    "residual": "nN",
    "misfit": "",
}
# Numbers in messages, by which the same reason differs between curves.
_NUMBER = re.compile(r"[-+]?\d[\d.]*(?:[eE][-+]?\d+)?")


class SeriesSummary(Printed):
    """Medians and quartiles of the fits of many curves, and reasons of failures.

    Parameters
    ----------
    curves : sequence of FittedCurve
    """

    def __init__(self, curves: Sequence[FittedCurve]) -> None:
        self._curves = curves

    @property
    def failures(self) -> list[tuple[int, str]]:
        """Numbers of curves that failed, and the reason with the numbers of the first.

        The most frequent reasons come first. A fit that did not converge has failed.
        """
        reasons = [each.message or _unconverged(each) for each in self._curves]
        return _counted(reasons)

    @property
    def doubts(self) -> list[tuple[int, str]]:
        """Numbers of curves with a doubt, and the doubt with the numbers of the first.

        The most frequent doubts come first.
        """
        doubts = [each.doubts.split(SEPARATOR) for each in self._curves]
        return _counted(list(chain.from_iterable(doubts)))

    @property
    def quartiles(self) -> dict[str, FloatArray]:
        """Quartiles of the curves that did not fail, shape (3,), in ASE's units."""
        return {
            name: np.percentile(values, (25.0, 50.0, 75.0))
            for name in _SHOWN
            if (values := known_values(self._curves, name)).size
        }

    @property
    def parts(self) -> list[object]:
        """Table of the quartiles, and lines on failures and doubts.

        If some curves have a doubt, lines also have the medians of the others.
        """
        rows, certain = [], []
        good = [each for each in self._curves if is_good(each)]
        without = [each for each in good if not each.doubts]
        for name, quartiles in self.quartiles.items():
            unit = _SHOWN[name]
            if name == "contact_modulus":
                unit = pressure_unit(float(quartiles[1]))
            low, middle, high = quartiles / UNITS.get(unit, 1.0)
            count = known_values(self._curves, name).size
            rows.append([name, *map(number, (middle, low, high)), unit, str(count)])
            known = known_values(without, name) / UNITS.get(unit, 1.0)
            if len(without) < len(good) and known.size:
                text = f"{number(float(np.median(known)))} {unit}".strip()
                certain.append(f"  {name}: {text} ({known.size} curves)")
        heads = ["", "median", "lower quartile", "upper quartile", "unit", "curves"]
        shown: list[object] = [table(heads, rows, left=1)] if rows else []
        failed = sum(count for count, _ in self.failures)
        lines = [f"{failed} of {len(self._curves)} curves failed"]
        lines += [f"  {count}: {reason}" for count, reason in self.failures]
        lines += [f"doubt of {count}: {doubt}" for count, doubt in self.doubts]
        if certain:
            lines += ["medians of curves without a doubt:", *certain]
        return [*shown, *lines]


def known_values(curves: Sequence[FittedCurve], name: str) -> FloatArray:
    """Return an attribute of the curves that did not fail, where it is known.

    Parameters
    ----------
    curves : sequence of FittedCurve
    name : str
        Name of the attribute.

    Returns
    -------
    ndarray, shape (k,)
        Values in ASE's units.
    """
    values = np.array([getattr(each, name) for each in curves if is_good(each)], float)
    return values[np.isfinite(values)]


def is_good(curve: FittedCurve) -> bool:
    """Return whether a curve was read, and its fit, if there is one, has converged."""
    return not curve.message and not _unconverged(curve)


def _unconverged(curve: FittedCurve) -> str:
    """Return that a fit has not converged; empty if it has, or if there is no fit."""
    is_fitted = np.isfinite(curve.contact_modulus)
    return "the fit has not converged" if is_fitted and not curve.converged else ""


def _counted(texts: Sequence[str]) -> list[tuple[int, str]]:
    """Return how often texts occur that differ in numbers only, and the first ones."""
    first: dict[str, str] = {}
    counts: Counter[str] = Counter()
    for text in filter(None, texts):
        kind = _NUMBER.sub("#", text)
        first.setdefault(kind, text)
        counts[kind] += 1
    return [(count, first[kind]) for kind, count in counts.most_common()]
