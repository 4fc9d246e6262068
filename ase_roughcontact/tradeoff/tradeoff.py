"""Trade-off between accuracy and cost: the error budget of a scene.

Each choice changes one thing in the scene with the most accurate choices. The areas,
forces or heights of a few steps are compared with the results of this scene, and for
grids with the results on a finer grid than all of them. What is calculated and chosen
depends on counts of grid points and FFT pairs, never on measured times.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import chain, product
from typing import Any, Literal

import numpy as np

from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import FloatArray, integer, lookup, positive
from ase_roughcontact.contact.control import LOAD
from ase_roughcontact.paths.plan import plan_path
from ase_roughcontact.results.record import size_of
from ase_roughcontact.scene.scene import Scene
from ase_roughcontact.tradeoff.result import NUMERICAL, SAFETY, Choice, Tradeoff
from ase_roughcontact.tradeoff.variants import (
    PILOT,
    finest_grid,
    most_accurate,
    of_continuum,
    unseen,
    variants,
    with_one_field,
    with_optimizers,
)

# Numbers of realisations of the choices.
_REALISATIONS = (1, 4, 16, 64)
# Columns of each answer, and of the quantity that its errors are relative to; empty for
# the area, as its column depends on the scene.
_COLUMNS = {
    "area": ("", ""),
    "force": ("normal_force", "normal_force"),
    "height": ("height", "penetration"),
}
# Sources that change the grid: their errors are relative to the finest grid.
_GRID_SOURCES = ("scene", "grid")


@dataclass(frozen=True)
class _Answers:
    """Areas (Å^2), forces (eV/Å) or heights (Å) of steps, and their costs.

    Attributes
    ----------
    values, errors : ndarray, shape (steps,)
        Answers and their estimated errors.
    scale : ndarray, shape (steps,)
        Quantity that errors are relative to: the values, or for heights the
        penetrations.
    cost, seconds, memory : float
        See `Choice`.
    converged : bool
        Whether all steps are converged.
    """

    values: FloatArray
    errors: FloatArray
    scale: FloatArray
    cost: float
    seconds: float
    memory: float
    converged: bool = True

    def error(self, exact: _Answers) -> float:
        """Return the largest relative difference from accurate answers."""
        return exact._relative(self.values - exact.values)

    def choice(
        self,
        source: str,
        label: str,
        error: float,
        settings: dict[str, Any] | None = None,
        is_bound: bool = False,
    ) -> Choice:
        """Return the choice with these costs; see `Choice`."""
        return Choice(
            source,
            label,
            error,
            self.cost,
            self.seconds,
            self.memory,
            settings or {},
            is_bound,
        )

    @property
    def estimate(self) -> float:
        """Largest known relative estimated error; zero if no error is known."""
        return self._relative(np.nan_to_num(self.errors, nan=0.0))

    def _relative(self, differences: FloatArray) -> float:
        """Return the largest magnitude relative to the answers of touching steps."""
        touching = self.scale > 0.0
        if not touching.any():
            raise ValueError("no step is in contact: an error has nothing to refer to")
        return float((abs(differences[touching]) / self.scale[touching]).max())


def tradeoff(
    scene: Scene,
    error: float = 1e-2,
    *,
    of: Literal["area", "force", "height"] = "area",
    steps: int = 3,
    points: int = 2**22,
) -> Tradeoff:
    """Measure the errors and costs of choices, and check the cheapest plan.

    Parameters
    ----------
    scene : Scene
        Scene to be planned.
    error : float
        Wanted total relative error.
    of : {"area", "force", "height"}
        The answer with this error. The error of the height is relative to the
        penetration. The force of a loop is the pull-off force.
    steps : int
        Number of steps of the path to calculate, the first and the last one included.
    points : int
        Largest number of points of an FFT grid. Steps that are planned with more on the
        finest grid are omitted, except for the first one, and choices that need more.

    Returns
    -------
    Tradeoff
        Table and plan, if printed.

    Raises
    ------
    ValueError
        If an argument is out of range, the scene is invalid, no step is in contact, or
        the path prescribes the answer.

    Notes
    -----
    Most of the steps between the calculated ones are skipped. With strong adhesion this
    may lead to other states than the whole path.
    """
    positive(error=error)
    if error >= 1.0:
        raise ValueError(
            f"error must be a relative error below 1, 0.01 for 1 %, got {error:g}"
        )
    integer("steps", steps, 1)
    integer("points", points, 1)
    lookup(of, _COLUMNS, "answer")
    is_loop = scene.path.is_loop
    if is_loop and of != "force":
        raise ValueError(
            f"the answer of a loop is its pull-off force, got the {of}: ask for the "
            "error of the force"
        )
    if not is_loop and (scene.path.in_order or scene.path.count(scene.bodies) is None):
        raise ValueError(_without_steps(scene))
    if not is_loop and _COLUMNS[of][0] in scene.control.prescribed:
        raise ValueError(
            f"the path prescribes the {of}, which has no error: ask for the error of "
            f"the area or of the {'height' if of == 'force' else 'force'}"
        )
    best = most_accurate(scene)
    scene, finest, best = with_one_field(scene, finest_grid(best), best)
    targets, left_out = _targets(finest.planned, steps, points)
    if best.is_continuum and finest == best:
        left_out.append('a grid finer than "high", which needs more memory')
    answers = cache(partial(_answers, targets=targets, of=of))
    exact, truth = answers(best), answers(finest)
    if unknown := int(np.isnan(truth.errors).sum()):
        left_out.append(
            f"the estimated error of the finest grid in {unknown} of {len(targets)} "
            "steps, where it is not known"
        )
    choices = []
    for source, label, settings in [("scene", "as given", {}), *variants(best)]:
        tried = best.with_values(settings) if settings else scene
        problem = _problem(tried, targets, points)
        if problem:
            left_out.append(f"{source} {label}: {problem}")
            continue
        found = answers(tried)
        if not found.converged:
            left_out.append(f"{source} {label}: steps have not converged")
            continue
        difference, bound = found.error(exact), 0.0
        if source in _GRID_SOURCES:
            difference, bound = found.error(truth), truth.estimate
        largest = max(difference, bound)
        choices.append(
            found.choice(source, label, largest, settings, difference < bound)
        )
    model_choices, reasons = _model_choices(best, targets, of, points)
    choices += model_choices
    left_out += reasons
    optimizer_choices, reasons = _optimizer_choices(scene, targets, of)
    choices += optimizer_choices
    left_out += reasons
    if of == "area":
        choices += _theory(best, targets, truth)
    choices += _realisations(scene, targets, of)
    plan = _cheapest(choices, SAFETY * error)
    checked = math.nan
    if plan:
        other, others = unseen(best, targets)
        truth = _answers(finest_grid(other), others, of)
        found = _answers(_planned(other, plan), others, of)
        checked = max(found.error(truth), truth.estimate)
    unit = scene.planned.path.unit
    shown = tuple(f"{target / UNITS[unit]:.4g} {unit}" for target in targets)
    return Tradeoff(error, shown, tuple(choices), plan, checked, of, tuple(left_out))


def _without_steps(scene: Scene) -> str:
    """Return the error for a path of dependent states, with steps to use instead."""
    deepest = scene.planned.path
    targets = np.unique(scene.planned.targets) / UNITS[deepest.unit]
    values = ", ".join(f"{target:.4g}" for target in targets)
    return (
        f'states of kind = "{scene.path.kind}" depend on earlier states: measure the '
        f'deepest state, kind = "steps", control = "{deepest.control}", values = '
        f"[{values}], without relaxation_moduli, relaxation_times and [friction]"
    )


def _targets(finest: Scene, steps: int, points: int) -> tuple[list[float], list[str]]:
    """Choose targets of a path with small enough grids, and name the others."""
    planned = finest.plan().steps
    possible = [step for step in planned if not step.problem]
    if not possible:
        raise ValueError(f"no step can be calculated: {planned[0].problem}")
    small = [step.target for step in possible if size_of(step.grid) <= points]
    small = small or [possible[0].target]
    chosen = np.linspace(0, len(small) - 1, min(steps, len(small))).round().astype(int)
    omitted = len(planned) - len(small)
    left_out = [
        f"{omitted} of {len(planned)} listed steps, which can't be calculated or need "
        f"more than {points:.2g} points of the finest grid"
    ]
    return [small[i] for i in chosen], left_out if omitted else []


def _problem(scene: Scene, targets: Sequence[float], points: int) -> str:
    """Return why a choice is not calculated; empty if it is."""
    try:
        planned = scene.planned
        steps = plan_path(
            planned.problem, planned.start, planned.control, targets, planned.window
        ).steps
    except ValueError as error:
        return str(error)
    if problem := next(filter(None, (step.problem for step in steps)), ""):
        return problem
    largest = max(size_of(step.grid) for step in steps)
    return f"a grid of {largest:.2g} points" if largest > points else ""


def _model_choices(
    best: Scene, targets: Sequence[float], of: str, points: int
) -> tuple[list[Choice], list[str]]:
    """Return the error of counted atoms against the continuum, or why it is unknown."""
    continuum = of_continuum(best)
    if continuum is None:
        return [], []
    label = "atoms / continuum"
    if problem := _problem(continuum, targets, points):
        return [], [f"model {label}: {problem}"]
    counted, truth = (_answers(each, targets, of) for each in (best, continuum))
    difference, bound = counted.error(truth), truth.estimate
    error = max(difference, bound)
    return [counted.choice("model", label, error, is_bound=difference < bound)], []


def _optimizer_choices(
    scene: Scene, targets: Sequence[float], of: str
) -> tuple[list[Choice], list[str]]:
    """Return the choices of an optimizer of ASE, on the grid as given.

    The second list names the choices that have not converged.
    """
    accurate, optimizers = with_optimizers(scene)
    if not optimizers:
        return [], []
    exact, choices, left_out = _answers(accurate, targets, of), [], []
    for label, settings in optimizers:
        found = exact
        if settings["solver.optimizer"] is not None:
            found = _answers(accurate.with_values(settings), targets, of)
        if found.converged:
            error = found.error(exact)
            choices.append(found.choice("optimizer", label, error, settings))
        else:
            left_out.append(f"optimizer {label}: steps have not converged")
    return choices, left_out


def _theory(best: Scene, targets: Sequence[float], exact: _Answers) -> list[Choice]:
    """Return the choice of Eq. (4), or of Hertz for a smooth sphere, under loads."""
    if best.control != LOAD or best.wall.attractive:
        return []
    label = best.bodies.labelled("Hertz" if best.rough is None else "Eq. (4)")
    areas = np.asarray(best.bodies.predicted_area(targets))
    error = replace(exact, values=areas).error(exact)
    return [Choice("theory", label, error, 0.0)]


def _realisations(scene: Scene, targets: Sequence[float], of: str) -> list[Choice]:
    """Return standard errors of the mean answer over numbers of realisations."""
    if scene.roughness is None:
        return []
    first = scene.roughness.seed
    fast = scene.with_values({"solver.accuracy": "fast"})
    found = [
        _answers(fast.with_values({"roughness.seed": seed}), targets, of)
        for seed in range(first, first + PILOT)
    ]
    scale = np.mean([each.scale for each in found], axis=0)
    deviation = np.std([each.values for each in found], axis=0, ddof=1)
    spread = float((deviation[scale > 0.0] / scale[scale > 0.0]).max(initial=0.0))
    cost, time = np.mean([(each.cost, each.seconds) for each in found], axis=0).tolist()
    memory = max(each.memory for each in found)
    return [
        Choice("realisations", str(n), spread / n**0.5, n * cost, n * time, memory)
        for n in _REALISATIONS
    ]


def _cheapest(choices: Sequence[Choice], wanted: float) -> tuple[Choice, ...]:
    """Return the cheapest numerical choices, one of each source, that suffice."""
    groups = ([c for c in choices if c.source == source] for source in NUMERICAL)
    plans = product(*filter(None, groups))
    # each cost is due to one change: the costs relative to the most accurate multiply
    return min(
        (plan for plan in plans if sum(c.error for c in plan) <= wanted),
        key=lambda plan: math.prod(choice.cost for choice in plan),
        default=(),
    )


def _planned(scene: Scene, plan: Sequence[Choice]) -> Scene:
    """Return the scene with the settings of a plan."""
    settings = chain.from_iterable(choice.settings.items() for choice in plan)
    return scene.with_values(dict(settings))


def _answers(scene: Scene, targets: Sequence[float], of: str) -> _Answers:
    """Return answers and costs of the steps of a scene, or of its loop."""
    if scene.path.is_loop:
        return _loop_answers(scene)
    columns = (name or scene.area_column for name in _COLUMNS[of])
    steps = list(scene.relax(targets, validity="ignore", scan_errors=False))
    values, scales, errors = (
        np.array([getattr(step, name) for step in steps])
        for name in (*columns, f"{of}_error")
    )
    return _Answers(
        values,
        errors,
        abs(scales),
        cost=sum(step.pairs * size_of(step.grid) for step in steps),
        seconds=sum(step.seconds for step in steps),
        memory=max(step.memory for step in steps),
        converged=all(step.converged for step in steps),
    )


def _loop_answers(scene: Scene) -> _Answers:
    """Return the pull-off force of a loop, and its cost."""
    steps = list(scene.relax(validity="ignore", scan_errors=False))
    lowest = min(steps, key=lambda step: step.normal_force)
    force = np.array([-lowest.normal_force])
    return _Answers(
        force,
        np.array([lowest.force_error]),
        abs(force),
        cost=sum(step.pairs * size_of(step.grid) for step in steps),
        seconds=sum(step.seconds for step in steps),
        memory=max(step.memory for step in steps),
        converged=all(step.converged for step in steps),
    )
