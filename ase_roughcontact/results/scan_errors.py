r"""Errors of results by the scan that is pressed: pixels, noise, edges and filter.

Copies of the scan are pressed at a few targets of the path, on a grid of the accuracy
"fast", when the first error is asked for. Errors at other normal forces are
interpolated, the errors of area and force in units of area and force.

- *Pixels.* With the results :math:`A_1, A_2, A_4` of the scan, of half and of a quarter
  of its pixels, the error is what further halvings of the pixels would change, each a
  part r of the one before:

  .. math:: \frac{r}{1 - r}\, \Delta, \quad
            \Delta = \max\left(|A_1 - A_2|, \tfrac{1}{8} |A_2 - A_4|\right), \quad
            r = \min\left(\frac{\Delta}{|A_2 - A_4|}, \tfrac{1}{2}\right).

  This assumes that the surface has little roughness that the pixels do not resolve:
  waves that were not measured are not known.
- *Noise.* Mean squares of slopes add up, and areas under light loads are in proportion
  to the inverse of the rms slope. With results :math:`A_n` of copies with as much noise
  again, the area without noise is about :math:`(2 A_1^{-2} - \langle A_n^{-2}
  \rangle)^{-1/2}`, taken as four times :math:`A_1` if it would be larger. Forces and
  heights change by as much again. The error is this change and the standard deviation
  of the copies, added in squares.
- *Edges* of a periodic scan that do not fit each other: the change by a copy without a
  `smooth_component`, so that its edges fit.
- *Squares.* A periodic scan with pixels that are no squares is pressed on a grid of
  squares, with distances along y changed by a strain :math:`\epsilon`
  (`SquareGrid`). The cell changes by :math:`\epsilon` and the rms slope by up to
  :math:`\epsilon/2`: area and force by :math:`3\epsilon/2`, heights by
  :math:`\epsilon` times the rms height.
- *Filter.* The area changes in proportion to the part of the rms slope, without noise,
  that it removed.

They add up in squares. examples/benchmarks/scan_errors.py compares them with the
true errors of synthetic scans.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from itertools import count
from typing import Any, TypeAlias

import numpy as np

from ase_roughcontact._util.validation import FloatArray
from ase_roughcontact.contact import Problem
from ase_roughcontact.contact.control import LOAD, Control
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.results.errors import Errors
from ase_roughcontact.results.record import columns_of
from ase_roughcontact.stepping.options import StepOptions
from ase_roughcontact.stepping.relaxed import RelaxedStep
from ase_roughcontact.stepping.retraction import relax_in_contact
from ase_roughcontact.stepping.step import Stepper
from ase_roughcontact.topography.measurement import HALVINGS, NOISY
from ase_roughcontact.windows.footprint import BeyondSurfaceError

_LOGGER = logging.getLogger(__name__)
#: Number of targets at which copies are pressed.
TARGETS = 3
#: Effect that a plan of a path leaves out.
COPIES_LEFT_OUT = (
    f"the time of up to {NOISY + HALVINGS + 1} copies of the scan, which are pressed "
    f"for the errors at {TARGETS} steps, on a grid that is often coarser"
)
# Smallest ratio of the changes by two halvings of the pixels.
_MIN_HALVING_RATIO = 0.125
# Largest ratio of the changes by two halvings of the pixels.
_MAX_HALVING_RATIO = 0.5
# Largest ratio of the areas without and with noise.
_MAX_AREA_RATIO = 4.0
# Relative change of area and force over the strain of distances along y.
_STRAIN_FACTOR = 1.5
# Columns of the results after the area, in the order of `Errors`.
_OTHER_COLUMNS = ("normal_force", "height", "penetration")
# Number of quantities in results and errors.
_COUNT = 1 + len(_OTHER_COLUMNS)
# Number of a scan, and kind of its copies.
_Kind: TypeAlias = tuple[int, str]
# Index of the area in results and errors.
_AREA = 0
# Index of the normal force in results and errors.
_FORCE = 1
# Index of the height in results and errors.
_HEIGHT = 2
# Index of the penetration in results and errors.
_PENETRATION = 3
# Name of the scan, on its grid, in reasons for errors that are not known.
_SCAN = "the scan, on the grid for its errors"
# Names of the kinds of copies in reasons for errors that are not known.
_COPIES = {
    "coarser": "copies of the scan with fewer pixels",
    "noisy": "copies of the scan with more noise",
    "seamless": "a copy of the scan with edges that fit each other",
}
# Reason for unknown errors of a scan out of contact.
_NO_CONTACT = "the scan does not touch at the steps at which its copies are pressed"
# Reason for unknown errors of scans without their own pixels.
_RESAMPLED = "two scans of different sizes or pixels are sampled on a common grid"


@dataclass(frozen=True, eq=False)
class ScanErrors:
    """Errors by a scan, at any normal force of a path.

    Parameters
    ----------
    problem : Problem
        The contact problem, with the scan as roughness of a `RoughSphere`.
    control : Control
    start : Box
        Window of all steps, or of the first one.
    options : StepOptions
        Options of the steps of the path.
    targets : sequence of float
        Penetrations or heights (Å), or loads (eV/Å), of the path.
    """

    problem: Problem
    control: Control
    start: Box
    options: StepOptions
    targets: Sequence[float]

    def todict(self) -> dict[str, Any]:
        """Return the parameters of the errors beside the scan that is pressed."""
        found = [_described(scan) for scan in scans_of(self.problem)]
        return found[0] if len(found) == 1 else {"scans": found}

    def __call__(self, step: RelaxedStep) -> Errors:
        """Return the errors of a relaxed step.

        They are not known if too few copies could be relaxed at the nearest target, or
        if scans are not pressed with their own pixels.
        """
        if not step.touches:
            return Errors(0.0, 0.0, 0.0, 0.0)
        if not scans_of(self.problem):
            return Errors.not_known(_RESAMPLED)
        if not self._at_targets:
            return Errors.not_known(_NO_CONTACT)
        force, area = step.fields.normal_force, step.fields.contact_area
        target = columns_of()[self.control.column].value(step)
        nearest = min(self._at_targets, key=lambda each: abs(each.target - target))
        if nearest.unknown:
            return Errors.not_known(nearest.unknown)
        known = [each for each in self._at_targets if not each.unknown]
        known.sort(key=lambda each: each.force)
        forces = [each.force for each in known]
        area_error, force_error, height_error, penetration_error = (
            float(np.interp(force, forces, [each.errors[quantity] for each in known]))
            for quantity in range(_COUNT)
        )
        return Errors(
            area_error * area,
            force_error * abs(force),
            height_error,
            penetration_error,
        )

    @cached_property
    def _at_targets(self) -> list[_AtTarget]:
        """Errors at the targets at which the scan touches or can't be pressed."""
        rough: Any = self.problem.topography.rough
        chosen = np.linspace(0, len(self.targets) - 1, TARGETS).round().astype(int)
        # a path may have one target only, as one of sliding
        targets = list(dict.fromkeys(np.asarray(self.targets)[chosen].tolist()))
        copies = _copies_of(self.problem)
        total = 1 + sum(len(maps) for maps in copies.values())
        number = count(1)

        def pressed(surface: Any) -> list[_Result]:
            _LOGGER.info("errors of the scan: copy %d of %d", next(number), total)
            return self._results(surface, targets)

        scan_results = pressed(rough)
        copy_results = {
            kind: [pressed(surface) for surface in maps]
            for kind, maps in copies.items()
        }
        errors = []
        for i, target in enumerate(targets):
            if scan_results[i].values[_AREA] == 0.0:
                continue
            of_copies = {
                kind: [results[i] for results in by_copy]
                for kind, by_copy in copy_results.items()
            }
            errors.append(self._errors(target, scan_results[i], of_copies))
        return errors

    def _errors(
        self, target: float, scan: _Result, copies: Mapping[_Kind, Sequence[_Result]]
    ) -> _AtTarget:
        """Return the errors at a target by the results of scan and copies there."""
        given = np.array(scan.values)
        force = target if self.control == LOAD else float(given[_FORCE])
        if scan.failure:
            return _AtTarget(target, force, given, f"{_SCAN}: {scan.failure}")
        errors, unknown = np.zeros(_COUNT), ""
        for (_, kind), results in copies.items():
            if not results:
                continue
            values = np.array([each.values for each in results])
            kind_errors = _CHANGES[kind](given, values)
            if np.isnan(kind_errors).any():
                failures = (each.failure for each in results if each.failure)
                unknown = unknown or f"{_COPIES[kind]}: {next(failures, 'no numbers')}"
            errors = np.hypot(errors, kind_errors)
        errors = np.hypot(errors, self._by_strain(given))
        for i, name in enumerate(_OTHER_COLUMNS, start=1):
            if name in self.control.prescribed:
                errors[i] = 0.0
        scales = abs(given[[_AREA, _FORCE]])
        errors[[_AREA, _FORCE]] /= np.where(scales > 0.0, scales, 1.0)
        errors[_AREA] = np.hypot(errors[_AREA], self._lost_slope)
        return _AtTarget(target, force, errors, unknown)

    @property
    def _lost_slope(self) -> float:
        """Part of the rms slope that filters removed."""
        scans = scans_of(self.problem)
        slopes = [scan.statistics().rms_slope for scan in scans]
        slope = self.problem.topography.rough.statistics().rms_slope
        lost = [
            scan.measurement.lost_slope * (each / slope) ** 2
            for scan, each in zip(scans, slopes, strict=True)
            if scan.measurement.lost_slope
        ]
        return math.hypot(*lost)

    def _by_strain(self, given: FloatArray) -> FloatArray:
        """Return the errors of results by the strain of a grid of squares."""
        errors = np.zeros(_COUNT)
        for scan in scans_of(self.problem):
            scales = _STRAIN_FACTOR * abs(given)
            scales[[_HEIGHT, _PENETRATION]] = scan.statistics().rms_height
            errors = np.hypot(errors, abs(scan.measurement.strain) * scales)
        return errors

    def _results(self, rough: Any, targets: Sequence[float]) -> list[_Result]:
        """Return the results of a map at the targets."""
        indenter: Any = self.problem.indenter
        stepper = Stepper(
            replace(self.problem, indenter=replace(indenter, roughness=rough)),
            self.control,
            self.start,
            replace(self.options, relaxer=None, fmax=None, scan_errors=None),
        )
        results, state = [], stepper.start
        for number, target in enumerate(targets):
            try:
                relaxed = relax_in_contact(stepper, state, target, number)
                results.append(_Result.of(relaxed))
                state = stepper.commit(relaxed).state
            except BeyondSurfaceError as error:
                results.append(_Result(failure=error.problem))
            except (ValueError, RuntimeError) as error:
                results.append(_Result(failure=str(error)))
        return results


def scans_of(problem: Problem) -> list[Any]:
    """Return the scans of the bodies, with their measurements."""
    parts: Any = problem.topography.rough.parts
    return [part for part in parts if getattr(part, "measurement", None)]


def _described(scan: Any) -> dict[str, Any]:
    """Return noise and filter of a scan."""
    measurement = scan.measurement
    return {"noise": asdict(measurement.noise), "filter": measurement.cutoff}


def _copies_of(problem: Problem) -> dict[_Kind, list[Any]]:
    """Return the roughness with copies of a scan, by the scan and kind of copies."""
    rough: Any = problem.topography.rough
    found = {}
    for number, scan in enumerate(scans_of(problem)):
        for kind, maps in scan.copies().items():
            copies = [rough.replaced(scan, each) for each in maps]
            found[number, kind] = copies
    return found


@dataclass(frozen=True)
class _Result:
    """Area, force, height and penetration of a relaxed step, as in `Errors`.

    `failure` is the reason why they are NaN, or empty.
    """

    values: tuple[float, ...] = (math.nan,) * _COUNT
    failure: str = ""

    @classmethod
    def of(cls, step: RelaxedStep) -> _Result:
        if not step.run.converged:
            return cls(failure=f"not converged: {step.run.message}")
        names, columns = (step.grid_model.area_column, *_OTHER_COLUMNS), columns_of()
        return cls(tuple(columns[name].value(step) for name in names))


@dataclass(frozen=True, eq=False)
class _AtTarget:
    """Errors at a target of the path.

    Attributes
    ----------
    target : float
        Penetration, height or load.
    force : float
        Normal force of the scan; NaN if it is not known (eV/Å).
    errors : ndarray, shape (4,)
        Relative errors of area and force; errors of height and penetration (Å).
    unknown : str
        Reason why some errors are not known; else empty.
    """

    target: float
    force: float
    errors: FloatArray
    unknown: str


def _pixels(given: FloatArray, coarser: FloatArray) -> FloatArray:
    """Return the errors by pixels, from results with all and with fewer pixels.

    Without a result of a quarter of the pixels the ratio is 1/2. Without a result of
    half of the pixels it is 1/2, too, and the error a third of the other change.
    """
    half = coarser[0]
    quarter = coarser[1] if len(coarser) > 1 else np.full_like(half, np.nan)
    before = abs(half - quarter)
    last = np.fmax(abs(given - half), _MIN_HALVING_RATIO * before)
    last = np.where(np.isnan(half), abs(given - quarter) / 3.0, last)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.fmin(last / before, _MAX_HALVING_RATIO)
    return last * ratio / (1.0 - ratio)


def _noise(given: FloatArray, noisy: FloatArray) -> FloatArray:
    """Return the errors by noise, from results of the scan and of noisy copies.

    They are NaN if fewer than two copies have results.
    """
    noisy = noisy[~np.isnan(noisy).any(axis=1)]
    if len(noisy) < 2:
        return np.full_like(given, np.nan)
    change = noisy.mean(axis=0) - given
    with np.errstate(divide="ignore"):
        square = given[_AREA] ** -2.0
        without = 2.0 * square - np.mean(noisy[:, _AREA] ** -2.0)
        without = max(without, square / _MAX_AREA_RATIO**2)
        change[_AREA] = without**-0.5 - given[_AREA]
    return np.hypot(change, noisy.std(axis=0, ddof=1))


def _edges(given: FloatArray, seamless: FloatArray) -> FloatArray:
    """Return the errors by edges that do not fit, from results with and without."""
    return abs(seamless[0] - given)


# Functions that estimate the errors from the results of each kind of copies.
_CHANGES = {"coarser": _pixels, "noisy": _noise, "seamless": _edges}
