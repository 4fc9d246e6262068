"""Trade-off between accuracy and cost, measured on a few steps of a scene.

The steps are calculated with several settings, and compared with a reference that is
far more accurate.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ase_roughcontact._util.text import cell
from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import FloatArray, integer, positive
from ase_roughcontact.paths.record import LoadStep
from ase_roughcontact.scene.grid_trials import GridTrial, grid_table, grid_trials
from ase_roughcontact.scene.scene import Scene

#: Fraction of the requested error that the measured error of a recommended setting may
#: reach, as the error of the other steps may be larger.
SAFETY_FACTOR = 0.3
# Accuracies of the trials.
_ACCURACIES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-6)
# Accuracy of the reference, and of the calculation from which its error is estimated.
_REFERENCE, _CHECK = 1e-10, 1e-9
# Smallest ratio of the requested error to that of the reference.
_MARGIN = 10.0
# Cutoffs of the trials, and that of the reference, in units of the spacing.
_CUTOFFS, _REFERENCE_CUTOFF = (3.0, 5.0, 10.0, 20.0), 30.0
# Accuracy of the trials of cutoffs.
_CUTOFF_ACCURACY = 1e-6
# Part of the work of the scene's settings below which others are recommended.
_GAIN = 0.9
# Width of the column of errors of force or penetration.
_WIDTH = 20
# Mean pressure in contact, in units of E*, that is typical of rough surfaces.
_TYPICAL_PRESSURE = 0.05


@dataclass(frozen=True)
class Trial:
    """Cost and error of some settings.

    Attributes
    ----------
    settings : dict
        Values by key of the scene file, such as ``{"solver.accuracy": 1e-3}``.
    nominal_error : float
        Relative error that the accuracy allows; zero if a tolerance replaces it.
    compared : {"force", "penetration"}
        The result that the path does not prescribe: the penetration under load control.
    response_error : float
        Its largest relative error: of the force, relative to a pressure of 0.05 E* on
        the atoms in contact if it is smaller than that; of the penetration, relative to
        the spacing.
    area_error : float
        Largest relative error of the contact area.
    atoms : int
        Largest error of the number of atoms in contact.
    pairs : float
        Number of FFT pairs.
    work : float
        Number of FFT pairs times the number of points of their grids.
    seconds : float
        Wall-clock time (s).
    memory : float
        Estimated peak memory (bytes).
    converged : bool
        Whether all steps converged.
    """

    settings: dict[str, Any]
    nominal_error: float
    compared: str
    response_error: float
    area_error: float
    atoms: int
    pairs: float
    work: float
    seconds: float
    memory: float
    converged: bool

    @property
    def error(self) -> float:
        """Larger error of response and area, infinite if a step did not converge."""
        if not self.converged:
            return math.inf
        return max(self.response_error, self.area_error)

    @property
    def label(self) -> str:
        """The settings in short."""
        return ", ".join(f"{key.split('.')[1]} {v}" for key, v in self.settings.items())

    @property
    def toml(self) -> str:
        """The settings as sections of a scene file."""
        sections: dict[str, list[str]] = {}
        for key, value in self.settings.items():
            title, name = key.split(".")
            lines = sections.setdefault(title, [f"[{title}]"])
            lines.append(f"{name} = {json.dumps(value)}")
        return "\n\n".join("\n".join(lines) for lines in sections.values())


@dataclass(frozen=True)
class Tradeoff:
    """Trials of a scene and the recommended settings; printed as a table.

    Attributes
    ----------
    requested : float
        Requested relative error.
    steps : tuple of str
        Targets of the calculated steps.
    omitted : int
        Number of steps that were too slow to be calculated.
    trials : tuple of Trial
        That of the scene's own settings, then the others.
    reference_error : float
        Estimated error of the reference; it counts as an error of every trial.
    grids : tuple of GridTrial
        Grids for the continuum; empty if the scene asks for the model of atoms.
    """

    requested: float
    steps: tuple[str, ...]
    omitted: int
    trials: tuple[Trial, ...]
    reference_error: float
    grids: tuple[GridTrial, ...] = ()

    @property
    def best(self) -> Trial | None:
        """Cheapest trial of sufficient nominal and measured accuracy, or None.

        The settings of the scene if no other trial has less than 0.9 of their work.
        """
        limit = SAFETY_FACTOR * self.requested - self.reference_error
        sufficient = [
            trial
            for trial in self.trials
            if trial.nominal_error <= self.requested and trial.error <= limit
        ]
        # in contrast to the time, the work does not depend on the load of the machine
        best = min(sufficient, key=lambda trial: trial.work, default=None)
        own = self.trials[0]
        gains = best is not None and best.work < _GAIN * own.work
        return best if gains or own not in sufficient else own

    def __str__(self) -> str:
        if not self.grids:
            return self._table
        return f"{self._table}\n\n{grid_table(self.grids, self.requested)}"

    @property
    def _table(self) -> str:
        """Trials of the numerical settings, and the recommendation."""
        width = max(len(trial.label) for trial in self.trials)
        heading = f"{self.trials[0].compared} error"
        lines = [
            f"{'setting':<{width}}{heading:>{_WIDTH}}    area error  atoms    pairs"
            "  time (s)  memory (GB)"
        ]
        lines += [
            f"{t.label:<{width}}{t.response_error:{_WIDTH}.1e}{t.area_error:14.1e}"
            f"{cell(t.atoms, 7)}{cell(t.pairs, 9, '.0f')}{cell(t.seconds, 10, '.2g')}"
            f"{cell(t.memory / UNITS['GB'], 13, '.2f')}"
            + ("" if t.converged else "   NOT CONVERGED")
            for t in self.trials
        ]
        omitted = f" ({self.omitted} slow steps omitted)" if self.omitted else ""
        lines += [
            "",
            "First line: settings of the scene. Errors: largest relative error of any "
            "step; atoms: largest error of the number in contact; pairs: "
            "forward/inverse FFT pairs.",
            f"Steps: {', '.join(self.steps)}{omitted}.",
            f"Estimated error of the reference: {self.reference_error:.0e}.",
            "",
        ]
        if self.best is self.trials[0]:
            lines.append(
                f"The settings of the scene suffice for an error of {self.requested:g} "
                f"and no others save {1.0 - _GAIN:.0%} of the work."
            )
            return "\n".join(lines)
        if self.best:
            lines += [f"Recommended for an error of {self.requested:g}:", ""]
            return "\n".join([*lines, self.best.toml])
        smallest = min(self.trials, key=lambda trial: trial.error)
        lines.append(
            f"No setting is safe for an error of {self.requested:g}: its accuracy must "
            f"allow no more, and its measured error at most {SAFETY_FACTOR:g} of it. "
            f"The smallest measured error was {smallest.error:.1e} ({smallest.label})."
        )
        return "\n".join(lines)


def tradeoff(
    scene: Scene, error: float = 1e-3, *, steps: int = 3, seconds: float = 120.0
) -> Tradeoff:
    """Measure the cost of accuracy in a scene, and recommend settings.

    Parameters
    ----------
    scene : Scene
        Scene whose settings are compared with others.
    error : float
        Requested relative error of force and area.
    steps : int
        Number of steps of the path to calculate: the first, the last, and some between,
        each after its predecessor.
    seconds : float
        Time for all trials (s). Steps that are too slow for it are omitted, except for
        the first one.

    Returns
    -------
    Tradeoff
        Table and recommendation, if printed.

    Raises
    ------
    ValueError
        If an argument is out of range, or the scene is invalid.
    RuntimeError
        If the reference does not converge to a tenth of `error`.

    Notes
    -----
    Most of the steps between the calculated ones are skipped. With strong adhesion this
    may lead to other states than the whole path.
    """
    positive(error=error, seconds=seconds)
    integer("steps", steps, 1)
    scene = scene.with_grid(scene.grids.change) if scene.is_continuum else scene
    default = scene.with_values({"solver.optimizer": None, "solver.fmax": None})
    reference: dict[str, Any] = {"solver.accuracy": _REFERENCE}
    cutoffs: list[dict[str, Any]] = []
    wall: dict[str, Any] = {}
    wall_entries = scene.interaction.entries()
    if "cutoff" in scene.wall.parameters and "cutoff" not in wall_entries:
        reference["interaction.cutoff"] = _REFERENCE_CUTOFF
        cutoffs = [{"interaction.cutoff": cutoff} for cutoff in _CUTOFFS]
    runs = len(cutoffs) + len(_ACCURACIES) + 4
    targets, omitted = _targets(default.with_values(reference), steps, seconds / runs)
    exact = list(default.with_values(reference).relax(targets, validity="ignore"))

    def trial(settings: Mapping[str, Any], of: Scene = default) -> Trial:
        return _trial(of.with_values(settings), settings, targets, exact)

    stalled = [step.max_force / step.tolerance for step in exact if not step.converged]
    reached = _REFERENCE * max(stalled, default=0.0)
    if reached > error / _MARGIN:
        raise RuntimeError(
            f"no reference is {_MARGIN:g} times more accurate than {error:g}: the best "
            f"one stalls at {reached:.1e}"
        )
    check = trial(reference | {"solver.accuracy": max(_CHECK, 10.0 * reached)})

    solver = scene.solver
    own = {"solver.accuracy": solver.accuracy, "solver.optimizer": solver.optimizer}
    if solver.fmax is not None:
        own = {"solver.fmax": solver.fmax, "solver.optimizer": solver.optimizer}
    trials = [trial(own, scene)]
    if cutoffs:
        tried = [trial({"solver.accuracy": _CUTOFF_ACCURACY} | c) for c in cutoffs]
        safe = [i for i, t in enumerate(tried) if t.error <= SAFETY_FACTOR * error]
        wall = cutoffs[safe[0] if safe else -1]
        trials += tried
    requested = {error} if _MARGIN * _REFERENCE <= error < 1.0 else set()
    accuracies = sorted({*_ACCURACIES, *requested}, reverse=True)
    trials += [trial({"solver.accuracy": accuracy} | wall) for accuracy in accuracies]
    unit = scene.path.unit
    return Tradeoff(
        requested=error,
        steps=tuple(f"{target / UNITS[unit]:.4g} {unit}" for target in targets),
        omitted=omitted,
        trials=tuple(trials),
        reference_error=max(reached, check.response_error, check.area_error),
        grids=grid_trials(default, targets, seconds) if scene.is_continuum else (),
    )


def _targets(scene: Scene, steps: int, seconds: float) -> tuple[list[float], int]:
    """Choose targets of a path, and count the steps that are too slow for a trial."""
    plan = scene.plan()
    planned = [step for step in plan.steps if not step.problem]
    if not planned:
        raise ValueError(f"no step can be calculated: {plan.steps[0].problem}")
    fast = [step.target for step in planned if step.seconds <= seconds / (2 * steps)]
    fast = fast or [planned[0].target]
    chosen = np.linspace(0, len(fast) - 1, min(steps, len(fast))).round().astype(int)
    chosen = np.union1d(chosen, chosen[1:] - 1)  # each after its predecessor
    return [fast[i] for i in chosen], len(planned) - len(fast)


def _trial(
    scene: Scene,
    settings: Mapping[str, Any],
    targets: list[float],
    exact: list[LoadStep],
) -> Trial:
    """Calculate some steps of a scene that has the given settings."""
    steps = list(scene.relax(targets, validity="ignore"))
    pairs = _column(steps, "pairs")
    points = [math.prod(map(int, step.grid.split("x"))) for step in steps]
    atoms, exact_atoms = (_column(s, "repulsive_atoms") for s in (steps, exact))
    difference = abs(atoms - exact_atoms)
    return Trial(
        settings={k: v for k, v in settings.items() if v is not None},
        nominal_error=scene.accuracy.error if scene.fmax is None else 0.0,
        compared="penetration" if scene.path.control == "load" else "force",
        response_error=_response_error(scene, steps, exact),
        area_error=float((difference / np.maximum(1, exact_atoms)).max()),
        atoms=int(difference.max()),
        pairs=pairs.sum(),
        work=float(pairs @ points),
        seconds=_column(steps, "seconds").sum(),
        memory=_column(steps, "memory").max(),
        converged=all(step.converged for step in steps),
    )


def _response_error(
    scene: Scene, steps: list[LoadStep], exact: list[LoadStep]
) -> float:
    """Return the largest relative error of the force, or of the penetration."""
    if scene.path.control == "load":
        name = "penetration"
        scale: FloatArray | float = scene.spacing
    else:
        # a small force may be the difference of large repulsive and attractive ones
        name = "normal_force"
        pressure = _TYPICAL_PRESSURE * scene.contact_modulus
        scale = pressure * _column(exact, "contact_area")
    value, exact_value = (_column(each, name) for each in (steps, exact))
    scale = np.maximum(abs(exact_value), scale)
    return float((abs(value - exact_value) / np.where(scale > 0.0, scale, 1.0)).max())


def _column(steps: list[LoadStep], name: str) -> FloatArray:
    return np.array([getattr(step, name) for step in steps], dtype=float)
