r"""Least-squares fit of a path in time to a measured curve: moduli, times and others.

The path of the scene is that of the measurement. Under given depths, heights or heights
of the base the force over time is compared, under given loads the penetration. Every
trial is a whole path, and derivatives are differences of trials.

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

from ase_roughcontact._util.units import FORCES, UNITS
from ase_roughcontact._util.validation import FloatArray, finite_array, lookup
from ase_roughcontact.paths.output import follow
from ase_roughcontact.paths.schedule import Schedule
from ase_roughcontact.paths.time_path import TimeSteps
from ase_roughcontact.scene.fit_parameters import FREE, changed, value_of
from ase_roughcontact.scene.force_curve import noise_of
from ase_roughcontact.scene.least_squares import (
    RANGE_UNCERTAINTY,
    Callback,
    Fit,
    solve,
)
from ase_roughcontact.scene.residuals import on_finer_grid
from ase_roughcontact.scene.scene import Scene
from ase_roughcontact.scene.time import Timed

#: Keys of the series that can be free, and the units of their parameters.
SERIES = {"relaxation_moduli": "", "relaxation_times": "s"}
# Ratio of tolerances by which the error of the time steps is estimated.
_SHORTER = 10.0
# Rounding of times, relative.
_ROUNDING = 1e-12
# Change of the unknowns for differences: what it changes is larger than what another
# choice of the time steps changes.
_CHANGE = 0.02


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
        With the path in time of the measurement, first values of the parameters, and
        all others.
    time : array_like, shape (k,)
        Since the beginning of the path (s).
    measured : array_like, shape (k,)
        Normal forces (eV/Å); of a path with ``control = "load"`` penetrations, whose
        zero is arbitrary (Å).
    free : sequence of str
        Parameters among `SERIES`, of which all moduli or times are free, `FREE`, and
        ``force_offset``, the force that the instrument shows for a free tip. Always
        free is ``height_offset``, by which the indenter is higher than the path says:
        a microscope does not measure where the surface is.
    callback : callable, optional
        Called after each trial with the parameters by name, and the root mean
        square of the residuals relative to the noise.

    Returns
    -------
    Fit
        With errors as those of `fit_curve`: by the noise, the range of the attraction,
        the grid, and by the time steps.

    Raises
    ------
    ValueError
        If a parameter is unknown, there are too few points, or their times are not
        those of the path.
    """
    time, measured = finite_array("time", time), finite_array("measured", measured)
    model = Model(scene, time, measured, free)
    fit, _, _ = solve(model, callback)
    return replace(fit, warnings=(*fit.warnings, *model.doubts))


class Model:
    """Curve of a scene at given times; the unknowns are logarithms and offsets.

    See `solve`; all points are compared. `doubts` are steps that did not converge.
    """

    bounds = -np.inf, np.inf
    reasons = "the path is not that of the measurement, or the solid needs more terms"

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
        self._scene, self._time, self.doubts = scene, time, list[str]()
        self._tolerance: float = path.tolerance
        self._by_load = path.unit in FORCES
        if self._by_load:
            self.ordinate, offsets = ("penetration", "nm"), {"height_offset": 1.0}
        else:
            self.ordinate = "normal force $N$", "nN"
            targets = [schedule.first, *(part.end for part in schedule.parts)]
            extent = float(np.ptp(targets)) / UNITS["nm"]
            offsets = {"force_offset": 1.0, "height_offset": extent}
        units = {**SERIES, **{k: unit for k, (_, unit) in FREE.items()}}
        units |= {name: "nN" if name == "force_offset" else "nm" for name in offsets}
        found = list[tuple[str, str, float]]()  # names, units and scales
        self._parts: dict[str, slice] = {}
        for name in free:
            lookup(name, units, "free parameter")
            if name not in offsets:
                heads, values = _first_values(scene, name)
                self._parts[name] = slice(len(found), len(found) + len(values))
                each = zip(heads, values, strict=True)
                found += [(head, units[name], value) for head, value in each]
        self._positive = len(found)
        found += [
            (name, units[name], scale)
            for name, scale in offsets.items()
            if name in (*free, "height_offset")
        ]
        names, self.units, self._scale = zip(*found, strict=True)
        self.names = names
        if time.shape != measured.shape or len(time) < len(names) + 2:
            raise ValueError(
                f"a fit of {len(names)} parameters needs at least {len(names) + 2} "
                f"points, each with a time, got {time.size} times and {measured.size} "
                "values"
            )
        self.start = np.ones(len(names))
        self._measured, self.noise = measured, noise_of(measured)
        self.error = self._tolerance * float(np.ptp(measured))
        self._known: tuple[bytes, tuple] = b"", ()

    def values(self, x: FloatArray) -> FloatArray:
        """Return the parameters in their units."""
        positive = np.arange(len(x)) < self._positive
        values = np.where(positive, np.exp(x - 1.0), x - 1.0) * self._scale
        ratios = values[self._parts.get("relaxation_moduli", slice(0))]
        ratios /= 1.0 + ratios.sum()
        return values

    def of(self, x: FloatArray) -> tuple[FloatArray, FloatArray, np.ndarray]:
        """Return residuals, their derivatives, and that all are compared."""
        if self._known[0] != x.tobytes():
            curve = self._curve(x)
            others = [self._curve(x + change) for change in _CHANGE * np.eye(len(x))]
            slopes = np.transpose([other - curve for other in others]) / _CHANGE
            residuals = (curve - self._measured) / self.noise
            compared = np.ones(len(curve), bool)
            self._known = x.tobytes(), (residuals, slopes / self.noise, compared)
        return self._known[1]

    def curves(self, x: FloatArray) -> dict[str, Any]:
        """Return measured and fitted curve, as attributes of `Fit`."""
        residuals, _, compared = self.of(x)
        return {
            "distance": self._time,
            "force": self._measured,
            "fitted": self._measured + self.noise * residuals,
            "compared": compared,
            "abscissa": ("time", "s"),
            "ordinate": self.ordinate,
        }

    def scales(self, x: FloatArray) -> FloatArray:
        """Return the derivatives of the parameters to the unknowns."""
        steps = 1e-6 * np.eye(len(x))
        rows = [(self.values(x + h) - self.values(x - h)) / 2e-6 for h in steps]
        return np.transpose(rows)

    def _curve(
        self, x: FloatArray, change: Callable[[Scene], Scene] | None = None
    ) -> FloatArray:
        """Return the values of the curve, with a change of the scene."""
        values = self.values(x)
        given = {name: values[part] for name, part in self._parts.items()}
        single = {name: float(each[0]) for name, each in given.items() if name in FREE}
        series = {name: each.tolist() for name, each in given.items() if name in SERIES}
        scene = changed(self._scene, single).with_values(
            {f"substrate.{name}": each for name, each in series.items()}
        )
        offsets = dict(zip(self.names, values, strict=True))
        offset = UNITS["nN"] * offsets.get("force_offset", 0.0)
        shift = UNITS["nm"] * offsets["height_offset"]
        curve = self._followed(change(scene) if change else scene, shift)
        return curve - shift if self._by_load else curve + offset

    def changes(self, x: FloatArray) -> dict[str, FloatArray]:
        """Return changes of the residuals by range of the wall, grid and time steps."""
        curve = self._measured + self.noise * self.of(x)[0]
        found = {}
        if self._scene.wall.attractive and "attraction_range" not in self._parts:

            def wider(scene: Scene) -> Scene:
                name = "attraction_range"
                return changed(scene, {name: (1.0 + _CHANGE) * value_of(scene, name)})

            change = (self._curve(x, wider) - curve) / math.log1p(_CHANGE)
            found["range"] = RANGE_UNCERTAINTY * change
        if not self._scene.substrate.of_atoms:
            part = on_finer_grid(self._scene)[1]
            finer = self._curve(x, lambda scene: on_finer_grid(scene)[0])
            found["grid"] = part * (finer - curve)
        shorter = {"path.tolerance": self._tolerance / _SHORTER}
        found["time steps"] = (
            self._curve(x, lambda scene: scene.with_values(shorter)) - curve
        )
        return {name: each[:, None] / self.noise for name, each in found.items()}

    def _followed(self, scene: Scene, shift: float) -> FloatArray:
        """Return the curve of a scene whose heights are shifted."""
        path: Any = scene.path
        signs = {"load": 0.0, "penetration": -1.0}
        shift *= signs.get(path.control, 1.0)
        given = path.schedule(scene.bodies)
        parts = [part._replace(end=part.end + shift) for part in given.parts]
        schedule = Schedule(given.first + shift, parts)
        stepper = scene.stepper(scene.frames())
        shifted = TimeSteps(stepper, schedule, path.tolerance)
        steps = list(follow(shifted, validity="ignore"))
        if not all(step.converged for step in steps) and not self.doubts:
            self.doubts.append("steps of a trial did not converge")
        column = "penetration" if self._by_load else "normal_force"
        times, values = np.transpose([(s.time, getattr(s, column)) for s in steps])
        curve = np.full_like(self._time, values[0])
        for begin, _, part in given.timed_parts():  # with kinks and jumps between them
            end = begin + part.duration
            first = np.searchsorted(times, begin * (1.0 + _ROUNDING), "right") - 1
            last = np.searchsorted(times, end * (1.0 - _ROUNDING), "left") + 1
            inside = (self._time >= begin) & (self._time <= end)
            if part.duration:
                piece = slice(first, last)
                smooth = PchipInterpolator(times[piece], values[piece])
                curve[inside] = smooth(self._time[inside])
        return curve


def _first_values(scene: Scene, name: str) -> tuple[list[str], list[float]]:
    """Return names and first values of the positive unknowns of a parameter."""
    if name in FREE:
        return [name], [value_of(scene, name)]
    values = np.array(getattr(scene.substrate, name))
    if name == "relaxation_moduli":
        if not values.sum() < 1.0:
            raise ValueError(
                "relaxation_moduli of a fluid can't be free: their sum must be below "
                f"1, got {values.sum():g}"
            )
        values = values / (1.0 - values.sum())
    return [f"{name}[{i}]" for i in range(len(values))], values.tolist()
