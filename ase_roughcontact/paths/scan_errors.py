r"""Errors of results by the scan that is pressed: pixels, noise, edges and filter.

Copies of the scan are pressed at a few targets of the path, on a grid of the accuracy
"fast", when the first error is asked for. Errors at other normal forces are
interpolated, those of area and force relative to them.

- *Pixels.* With the results :math:`A_1, A_2, A_4` of the scan, of half and of a quarter
  of its pixels, the error is what further halvings of the pixels would change, each a
  part r of the one before:

  .. math:: \frac{r}{1 - r}\, \Delta, \quad
            \Delta = \max\left(|A_1 - A_2|, \tfrac{1}{8} |A_2 - A_4|\right), \quad
            r = \min\left(\frac{\Delta}{|A_2 - A_4|}, \tfrac{1}{2}\right).

  This assumes that the surface has little roughness beyond that at the pixels: waves
  that were not measured are not known.
- *Noise.* Mean squares of slopes add up, and areas under light loads are in proportion
  to the inverse of the rms slope. With results :math:`A_n` of copies with as much noise
  again, the area without noise is about :math:`(2 A_1^{-2} - \langle A_n^{-2}
  \rangle)^{-1/2}`, taken as four times :math:`A_1` if it would be larger. Forces and
  heights change by as much again. The error is this change and the standard deviation
  of the copies, added in squares.
- *Edges* of a periodic scan that do not fit each other: the change by a copy whose
  edges do, without a `smooth_component`.
- *Filter.* The area changes in proportion to the part of the rms slope, without noise,
  that it removed.

They add up in squares. examples/benchmarks/scan_errors.py compares them with the
true errors of synthetic scans.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import count
from typing import Any

import numpy as np

from ase_roughcontact._util.validation import FloatArray
from ase_roughcontact.contact import Problem
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.paths.errors import Errors
from ase_roughcontact.paths.record import columns_of
from ase_roughcontact.paths.relaxed import RelaxedStep
from ase_roughcontact.paths.step import Stepper
from ase_roughcontact.paths.step_options import StepOptions
from ase_roughcontact.topography.measurement import HALVINGS, NOISY

_LOGGER = logging.getLogger(__name__)
#: Number of targets at which copies are pressed, and what a plan says of them.
TARGETS = 3
COPIES_LEFT_OUT = (
    f"the time of up to {NOISY + HALVINGS + 1} copies of the scan, which are pressed "
    f"for the errors at {TARGETS} steps, on a grid that is often coarser"
)
# Smallest and largest ratio of the changes by two halvings of the pixels.
_LEAST_RATIO, _LARGEST_RATIO = 0.125, 0.5
# Largest area without noise over that with it.
_LARGEST_AREA = 4.0
# Index of the area in a result, and errors that are not known.
_AREA, _UNKNOWN = 0, Errors(math.nan, math.nan, math.nan, math.nan)
# Quantities, in the order of `Errors`, that a path prescribes and that have no error.
_PRESCRIBED = {"loads": [1], "heights": [2], "penetrations": [2, 3]}


@dataclass(frozen=True, eq=False)
class ScanErrors:
    """Errors by a scan, at any normal force of a path.

    Parameters
    ----------
    problem : Problem
        With the scan as roughness of a `RoughSphere`.
    control : {"penetrations", "heights", "loads"}
    start : Box
        Window of all steps, or of the first one.
    options : StepOptions
        Of the path.
    targets : sequence of float
        Of the path.
    """

    problem: Problem
    control: str
    start: Box
    options: StepOptions
    targets: Sequence[float]

    def __call__(self, step: RelaxedStep) -> Errors:
        """Return the errors of a relaxed step; NaN if no copy could be relaxed."""
        if not step.touches:
            return Errors(0.0, 0.0, 0.0, 0.0)
        forces, errors = self._at_targets
        if not forces.size:
            return _UNKNOWN
        force, area = step.fields.normal_force, step.fields.contact_area
        found = [float(np.interp(force, forces, each)) for each in errors.T]
        scales = area, abs(force), 1.0, 1.0
        return Errors(*np.multiply(found, scales).tolist())

    @cached_property
    def _at_targets(self) -> tuple[FloatArray, FloatArray]:
        """Normal forces of the targets, in this order, and errors, one row each."""
        rough = self.problem.facts.roughness
        chosen = np.linspace(0, len(self.targets) - 1, TARGETS).round().astype(int)
        # a path may have one target only, as one of sliding
        targets = list(dict.fromkeys(np.asarray(self.targets)[chosen].tolist()))
        groups = [rough], *rough.copies().values()
        number, total = count(1), sum(map(len, groups))
        results: list[list[FloatArray]] = []
        for maps in groups:
            results.append([])
            for each in maps:
                _LOGGER.info("errors of the scan: copy %d of %d", next(number), total)
                results[-1].append(self._results(each, targets))
        given, *others = map(np.array, results)
        forces, errors = given[0, :, 1], np.zeros_like(given[0])
        for change, found in zip((_pixels, _noise, _edges), others, strict=True):
            if found.size:
                errors = np.hypot(errors, change(given[0], found))
        errors[:, _PRESCRIBED[self.control]] = 0.0
        with np.errstate(divide="ignore", invalid="ignore"):
            errors[:, :2] /= abs(given[0, :, :2])
        errors[:, _AREA] = np.hypot(errors[:, _AREA], rough.measurement.lost_slope)
        order = np.argsort(forces)
        known = order[np.isfinite(errors[order]).all(axis=1)]
        return forces[known], errors[known]

    def _results(self, rough: Any, targets: Sequence[float]) -> FloatArray:
        """Return the results of a map at targets, one row each; NaN where it fails."""
        indenter: Any = self.problem.indenter
        record: Any = _Result
        stepper = Stepper(
            replace(self.problem, indenter=replace(indenter, roughness=rough)),
            self.control,
            self.start,
            replace(self.options, relaxer=None, fmax=None, scan_errors=None),
        )
        results = np.full((len(targets), len(_UNKNOWN)), np.nan)
        for number, target in enumerate(targets):
            try:
                results[number] = stepper.step(number, target, record)
            except (ValueError, RuntimeError):  # it may touch beyond the scan
                break
        return results


class _Result(list):
    """Area and others of a relaxed step, in the order of `Errors`."""

    @classmethod
    def of(cls, step: RelaxedStep) -> Any:
        if not step.run.converged:
            return cls(_UNKNOWN)
        area = "continuum_area" if step.options.continuum else "contact_area"
        names, columns = (area, "normal_force", "height", "penetration"), columns_of()
        return cls(columns[name].value(step) for name in names)


def _pixels(given: FloatArray, coarser: FloatArray) -> FloatArray:
    """Return the errors by pixels of results, and those of fewer pixels.

    Where a quarter of the pixels does not reach far enough, NaN, the ratio is 1/2.
    """
    half = coarser[0]
    quarter = coarser[1] if len(coarser) > 1 else np.full_like(half, np.nan)
    before = abs(half - quarter)
    last = np.fmax(abs(given - half), _LEAST_RATIO * before)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.fmin(last / before, _LARGEST_RATIO)
    return last * ratio / (1.0 - ratio)


def _noise(given: FloatArray, noisy: FloatArray) -> FloatArray:
    """Return the errors by noise of results, and those of noisy copies."""
    change = noisy.mean(axis=0) - given
    with np.errstate(divide="ignore", invalid="ignore"):
        square = given[:, _AREA] ** -2.0
        without = 2.0 * square - np.mean(noisy[:, :, _AREA] ** -2.0, axis=0)
        without = np.maximum(without, square / _LARGEST_AREA**2)
        change[:, _AREA] = without**-0.5 - given[:, _AREA]
    return np.hypot(change, noisy.std(axis=0, ddof=1))


def _edges(given: FloatArray, seamless: FloatArray) -> FloatArray:
    """Return the errors by edges that do not fit of results, and those without."""
    return abs(seamless[0] - given)
