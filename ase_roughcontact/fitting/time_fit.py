r"""Least-squares fit of a path in time to a measured curve: moduli, times and others.

The scene follows the path of the measurement. Under given depths, heights or heights of
the base the force over time is compared, under given loads the penetration. Every trial
is a whole path, and derivatives are differences of trials.

Relaxation moduli are :math:`g_k = y_k/(1 + \sum_j y_j)`, with positive unknown ratios
:math:`y_k` of the moduli to the relaxed one, so that each trial is a solid.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.interpolate import PchipInterpolator

from ase_roughcontact._util.rounding import ROUNDING
from ase_roughcontact._util.units import FORCES, UNITS
from ase_roughcontact._util.validation import FloatArray, finite_array, lookup
from ase_roughcontact.contact.control import LOAD
from ase_roughcontact.fitting.force_curve import noise_of
from ase_roughcontact.fitting.least_squares import (
    RANGE_UNCERTAINTY,
    Callback,
    Fit,
    Trial,
    solve,
)
from ase_roughcontact.fitting.parameters import (
    FREE,
    FREE_UNITS,
    SERIES,
    changed,
    value_of,
)
from ase_roughcontact.fitting.residuals import on_finer_grid
from ase_roughcontact.path_kinds.time.scene import Timed
from ase_roughcontact.path_kinds.time.specification import TimeSpecification
from ase_roughcontact.path_kinds.time.steps import TimeSteps
from ase_roughcontact.paths.follow import follow
from ase_roughcontact.paths.schedule import Schedule
from ase_roughcontact.scene.scene import Scene

# Ratio of tolerances by which the error of the time steps is estimated.
_TOLERANCE_RATIO = 10.0
# Change of the unknowns for differences: its effect is larger than the effect of
# another choice of the time steps.
_DIFFERENCE_STEP = 0.02


def fit_in_time(
    scene: Scene,
    time: FloatArray,
    measured: FloatArray,
    free: Sequence[str] = ("relaxation_moduli", "relaxation_times"),
    callback: Callback | None = None,
) -> Fit:
    """Fit parameters of a viscoelastic scene to a curve measured over time.

    Parameters
    ----------
    scene : Scene
        Scene with the path in time of the measurement, first values of the free
        parameters, and the fixed ones.
    time : array_like, shape (k,)
        Times since the beginning of the path (s).
    measured : array_like, shape (k,)
        Normal forces (eV/Å); for a path with ``control = "load"`` penetrations (Å) with
        an arbitrary zero.
    free : sequence of str
        Parameters among `SERIES` (all moduli or times are free then), `FREE`, and
        ``force_offset``, the force that the instrument shows for a free tip. Always
        free is ``height_offset``, the height of the indenter above the height on the
        path: a microscope does not measure where the surface is.
    callback : callable, optional
        Called after each trial with the parameters by name, and the root mean
        square of the residuals relative to the noise.

    Returns
    -------
    Fit
        Fit with errors by the noise, the range of the attraction and the grid, as in
        `fit_curve`, and by the time steps.

    Raises
    ------
    ValueError
        If a parameter is unknown, there are too few points, or their times are not on
        the path.
    """
    time, measured = finite_array("time", time), finite_array("measured", measured)
    model = TimeModel(scene, time, measured, free)
    fit, *_ = solve(model, callback)
    return replace(fit, warnings=(*fit.warnings, *model.doubts))


class TimeModel:
    """Curve of a scene at given times; the unknowns are logarithms and offsets.

    Parameters
    ----------
    scene : Scene
        Scene with the path in time of the measurement.
    time, measured : ndarray, shape (k,)
        Times (s), and forces (eV/Å) or penetrations (Å).
    free : sequence of str
        See `fit_in_time`.

    Attributes
    ----------
    doubts : list of str
        Steps that did not converge.
    """

    reasons = "the path is not the measured one, or the solid needs more terms"
    bounds = -np.inf, np.inf
    abscissa, ordinate = ("time", "s"), ("normal force $N$", "nN")

    def __init__(
        self,
        scene: Scene,
        time: FloatArray,
        measured: FloatArray,
        free: Sequence[str],
    ) -> None:
        path: Any = scene.path
        if not isinstance(path, Timed):
            raise ValueError(
                f'a fit over time needs [path] kind = "time", got "{path.kind}"'
            )
        schedule = path.schedule(scene.bodies)
        if time.min(initial=0.0) < 0.0 or time.max(initial=0.0) > schedule.duration:
            raise ValueError(
                f"the curve lasts from {time.min():.4g} to {time.max():.4g} s, but the "
                f"path from 0 to {schedule.duration:.4g} s: give the path of the "
                "measurement, or shift the times"
            )
        self._scene, self.measured, self.doubts = scene, (time, measured), list[str]()
        self._tolerance: float = path.tolerance
        self._by_load = path.unit in FORCES
        if self._by_load:
            self.ordinate, offsets = ("penetration", "nm"), {"height_offset": 1.0}
        else:
            targets = [schedule.first, *(part.end for part in schedule.parts)]
            extent = float(np.ptp(targets)) / UNITS["nm"]
            offsets = {"force_offset": 1.0, "height_offset": extent}
        for name in free:
            lookup(name, SERIES | FREE | offsets, "free parameter")
        # first values of the parameters of the scene, and units of the offsets
        first = {
            name: _first_values(scene, name) for name in free if name not in offsets
        }
        self._positive = sum(len(values) for values in first.values())
        for name, scale in offsets.items():
            if name in free or name == "height_offset":
                first[name] = np.array([scale])
        names, units = list[str](), list[str]()
        for name, values in first.items():
            names += _heads(name, len(values))
            units += [FREE_UNITS[name]] * len(values)
        self._first, self.names, self.units = first, tuple(names), tuple(units)
        if time.shape != measured.shape or len(time) < len(self.names) + 2:
            raise ValueError(
                f"a fit of {len(self.names)} parameters needs at least "
                f"{len(self.names) + 2} points, each with a time, got {time.size} "
                f"times and {measured.size} values"
            )
        self.start = np.ones(len(self.names))
        self.noise = noise_of(measured)
        self.error = self._tolerance * float(np.ptp(measured))

    def values(self, x: FloatArray) -> FloatArray:
        """Return the parameters in their units."""
        return np.concatenate(list(self._given(x).values()))

    def trial(self, x: FloatArray) -> Trial:
        """Return the trial for some unknowns."""
        curve = self._curve(x)
        others = [
            self._curve(x + change) for change in _DIFFERENCE_STEP * np.eye(len(x))
        ]
        slopes = np.transpose([other - curve for other in others]) / _DIFFERENCE_STEP
        residuals = (curve - self.measured[1]) / self.noise
        compared = np.ones(len(curve), bool)
        return Trial(x, residuals, slopes / self.noise, compared, curve)

    def changes(self, trial: Trial) -> dict[str, FloatArray]:
        """Return changes of the residuals by range of the wall, grid and time steps."""

        def wider(scene: Scene) -> Scene:
            name = "attraction_range"
            return changed(
                scene, {name: (1.0 + _DIFFERENCE_STEP) * value_of(scene, name)}
            )

        def finer(scene: Scene) -> Scene:
            return on_finer_grid(scene)[0]

        def shorter(scene: Scene) -> Scene:
            return scene.with_values(
                {"path.tolerance": self._tolerance / _TOLERANCE_RATIO}
            )

        variants = dict[str, tuple[Callable[[Scene], Scene], float]]()
        if self._scene.wall.attractive and "attraction_range" not in self._first:
            variants["range"] = wider, RANGE_UNCERTAINTY / math.log1p(_DIFFERENCE_STEP)
        if not self._scene.substrate.of_atoms:
            variants["grid"] = finer, on_finer_grid(self._scene)[1]
        variants["time steps"] = shorter, 1.0
        changes = dict[str, FloatArray]()
        for name, (change, factor) in variants.items():
            difference = self._curve(trial.unknowns, change) - trial.fitted
            changes[name] = factor / self.noise * difference[:, None]
        return changes

    def _given(self, x: FloatArray) -> dict[str, FloatArray]:
        """Return the values of each parameter by its name."""
        positive = np.arange(len(x)) < self._positive
        scales = np.concatenate(list(self._first.values()))
        values = np.where(positive, np.exp(x - 1.0), x - 1.0) * scales
        ends = np.cumsum([len(each) for each in self._first.values()])[:-1]
        given = dict(zip(self._first, np.split(values, ends), strict=True))
        if "relaxation_moduli" in given:
            given["relaxation_moduli"] /= 1.0 + given["relaxation_moduli"].sum()
        return given

    def _curve(
        self, x: FloatArray, change: Callable[[Scene], Scene] | None = None
    ) -> FloatArray:
        """Return the values of the curve, with a change of the scene."""
        given = self._given(x)
        shift = UNITS["nm"] * given.pop("height_offset")[0]
        offset = UNITS["nN"] * given.pop("force_offset", np.zeros(1))[0]
        scene = changed(self._scene, given)
        curve = self._followed(change(scene) if change else scene, shift)
        return curve - shift if self._by_load else curve + offset

    def _followed(self, scene: Scene, shift: float) -> FloatArray:
        """Return the curve of a scene with heights shifted by a distance (Å)."""
        path: Any = scene.path
        shift *= 0.0 if scene.control == LOAD else -scene.control.deeper
        given = path.schedule(scene.bodies)
        parts = [part._replace(end=part.end + shift) for part in given.parts]
        schedule = Schedule(given.first + shift, parts)
        stepper = scene.stepper(scene.frames())
        specification = TimeSpecification(schedule, path.tolerance)
        shifted = TimeSteps(stepper, specification)
        steps = list(follow(shifted, validity="ignore"))
        if not all(step.converged for step in steps) and not self.doubts:
            self.doubts.append("steps of a trial did not converge")
        time = self.measured[0]
        column = "penetration" if self._by_load else "normal_force"
        times, values = np.transpose([(s.time, getattr(s, column)) for s in steps])
        curve = np.full_like(time, values[0])
        for begin, _, part in given.timed_parts():  # with kinks and jumps between them
            end = begin + part.duration
            first = np.searchsorted(times, begin * (1.0 + ROUNDING), "right") - 1
            last = np.searchsorted(times, end * (1.0 - ROUNDING), "left") + 1
            inside = (time >= begin) & (time <= end)
            if part.duration:
                piece = slice(first, last)
                smooth = PchipInterpolator(times[piece], values[piece])
                curve[inside] = smooth(time[inside])
        return curve


def _first_values(scene: Scene, name: str) -> FloatArray:
    """Return first values of the positive unknowns of a parameter."""
    if name in FREE:
        return np.array([value_of(scene, name)])
    values = np.array(getattr(scene.substrate, name))
    if name != "relaxation_moduli":
        return values
    if not values.sum() < 1.0:
        raise ValueError(
            "relaxation_moduli of a fluid can't be free: their sum must be below "
            f"1, got {values.sum():g}"
        )
    return values / (1.0 - values.sum())


def _heads(name: str, count: int) -> list[str]:
    """Return the names of the values of a parameter."""
    return [f"{name}[{i}]" for i in range(count)] if name in SERIES else [name]
