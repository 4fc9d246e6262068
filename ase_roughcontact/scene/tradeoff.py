"""Trade-off between accuracy and cost: the error budget of a scene.

Each choice changes one thing in a scene whose other choices are the most accurate ones.
The areas, forces or heights of a few steps are compared with those of that scene.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain, product
from typing import Any

import numpy as np

from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import FloatArray, integer, lookup, positive
from ase_roughcontact.paths.accuracy import LEVELS, OF_ATOMS
from ase_roughcontact.paths.plan import plan_path
from ase_roughcontact.paths.record import LoadStep
from ase_roughcontact.scene.choices import Choice, Tradeoff
from ase_roughcontact.scene.config import InteractionConfig
from ase_roughcontact.scene.scene import Scene
from ase_roughcontact.topography import SelfAffine

# Numbers of realisations, and those from which their spread is estimated.
_COUNTS, _PILOT = (1, 4, 16, 64), 4
# Sides of periodic cells in diameters of a smooth contact, as multiples of atoms that
# any grid divides.
_CELLS, _MULTIPLE = (2, 4), 16
# Loose and tight tolerance of the model of atoms.
_LOOSE, _TIGHT = 1e-1, 1e-8
# Cutoffs of the 9-3 wall in units of the spacing, and that of the most accurate scene.
_CUTOFFS, _LARGEST_CUTOFF = (3.0, 5.0, 10.0), 30.0
# Sources of errors that are numerical, which a plan may combine.
_NUMERICAL = ("tolerance", "grid", "cutoff", "boundary")
# Number of choices among which the time is divided.
_RUNS = 16
# Number of plans that are calculated as a whole: times that multiply are right within a
# factor of two or three.
_TRIED = 3
# Part of the wanted error that a plan may have on the steps it is made for.
_SAFETY = 0.7
# Columns of the answers, that of the area is the scene's, and of what their errors are
# relative to.
_COLUMNS = {
    "area": ("", ""),
    "force": ("normal_force", "normal_force"),
    "height": ("height", "penetration"),
}
# Answers that a path prescribes.
_PRESCRIBED = {"loads": "force", "heights": "height", "penetrations": "height"}


@dataclass(frozen=True)
class _Answers:
    """Areas (Å^2), forces (eV/Å) or heights (Å) of steps, and their costs.

    Attributes
    ----------
    values, errors : ndarray, shape (steps,)
        With the estimated errors.
    scale : ndarray, shape (steps,)
        That errors are relative to: the values, or for heights the penetrations.
    seconds : float
        Wall-clock time (s).
    memory : float
        Estimated peak memory (bytes).
    """

    values: FloatArray
    errors: FloatArray
    scale: FloatArray
    seconds: float
    memory: float

    def error(self, exact: _Answers, estimated: bool = False) -> float:
        """Return the largest relative error, with that estimated or without."""
        differences = abs(self.values - exact.values) + estimated * self.errors
        touching = exact.scale > 0.0
        return float((differences[touching] / exact.scale[touching]).max())


def tradeoff(
    scene: Scene,
    error: float = 1e-2,
    *,
    of: str = "area",
    steps: int = 3,
    seconds: float = 120.0,
) -> Tradeoff:
    """Measure the errors and costs of choices, and check the cheapest plan.

    Parameters
    ----------
    scene : Scene
    error : float
        Total relative error that is wanted.
    of : {"area", "force", "height"}
        The answer that has this error. The error of the height is relative to the
        penetration.
    steps : int
        Number of steps of the path to calculate, the first and the last one included.
    seconds : float
        Planned time of all choices (s). Steps that are too slow for it are omitted,
        except for the first one, and choices that are too slow.

    Returns
    -------
    Tradeoff
        Table and plan, if printed.

    Raises
    ------
    ValueError
        If an argument is out of range, the scene is invalid, or its path prescribes
        the answer.

    Notes
    -----
    Most of the steps between the calculated ones are skipped. With strong adhesion this
    may lead to other states than the whole path.
    """
    positive(error=error, seconds=seconds)
    integer("steps", steps, 1)
    lookup(of, _COLUMNS, "answer")
    if of == _PRESCRIBED[scene.control]:
        raise ValueError(
            f"the path prescribes the {of}, which has no error: ask for that of the "
            f"area or the {'height' if of == 'force' else 'force'}"
        )
    scene, best = _with_one_field(scene, _best(scene))
    targets = _targets(best, steps, seconds / _RUNS)
    exact = _answers(best, targets, of)
    variants = [("scene", "as given", {}), *_variants(best)]
    choices = []
    for source, label, settings in variants:
        tried = best.with_values(settings) if settings else scene
        found = _measured(tried, targets, of, seconds / _RUNS)
        if found:
            # the most accurate scene has the error that it estimates
            error_found = found.error(exact, estimated=tried == best)
            cost = found.seconds, found.memory
            choices.append(Choice(source, label, error_found, *cost, settings))
    if of == "area":
        choices += _theory(best, targets, exact)
    choices += _realisations(scene, targets, of)
    plan = _fastest(best, _cheapest(choices, _SAFETY * error), targets)
    unit = scene.path.unit
    shown = tuple(f"{target / UNITS[unit]:.4g} {unit}" for target in targets)
    if not plan:
        return Tradeoff(error, shown, tuple(choices), of=of)
    other, others = _unseen(best, targets)
    truth = _answers(other, others, of)
    checked = _answers(_planned(other, plan), others, of).error(truth)
    return Tradeoff(error, shown, tuple(choices), plan, checked, of)


def _targets(scene: Scene, steps: int, seconds: float) -> list[float]:
    """Choose targets of a path that are fast enough for a choice."""
    planned = [step for step in scene.plan().steps if not step.problem]
    if not planned:
        raise ValueError(f"no step can be calculated: {scene.plan().steps[0].problem}")
    fast = [step.target for step in planned if step.seconds <= seconds / steps]
    fast = fast or [planned[0].target]
    chosen = np.linspace(0, len(fast) - 1, min(steps, len(fast))).round().astype(int)
    return [fast[i] for i in chosen]


def _best(scene: Scene) -> Scene:
    """Return the scene with the most accurate numerical choices."""
    values: dict[str, Any] = {
        "solver.optimizer": None,
        "solver.fmax": None,
        "solver.accuracy": "high" if scene.is_continuum else _TIGHT,
    }
    if scene.is_continuum:
        values |= {"substrate.refine": None, "substrate.coarsen": None}
        if scene.given_grid is not None and isinstance(scene.substrate.spacing, str):
            values["substrate.spacing"] = None
    is_given = "cutoff" in scene.interaction.entries()
    if "cutoff" in scene.wall.parameters and not is_given:
        values["interaction.cutoff"] = _LARGEST_CUTOFF
    if scene.substrate.periodic and scene.radius < math.inf:
        values |= {"substrate.periodic": False, "substrate.shape": "auto"}
    return scene.with_values(values)


def _with_one_field(*scenes: Scene) -> tuple[Scene, ...]:
    """Return scenes with the period of the last one's local work of adhesion."""
    field = getattr(scenes[-1].local_adhesion, "pattern", None)
    if not isinstance(field, SelfAffine):
        return scenes
    domain = f"{field.side / scenes[-1].spacing:.12g} a0"
    return tuple(s.with_values({"heterogeneity.domain": domain}) for s in scenes)


def _variants(best: Scene) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Yield source, label and settings of the choices that are calculated."""
    if best.is_continuum:
        for level in LEVELS:
            yield "grid", level, {"solver.accuracy": level}
    else:
        for error in (_LOOSE, OF_ATOMS):
            yield "tolerance", f"{error:g}", {"solver.accuracy": error}
    free: dict[str, Any] = {"substrate.periodic": False, "substrate.shape": "auto"}
    if best.interaction.entries().get("cutoff") == _LARGEST_CUTOFF:
        for cutoff in (*_CUTOFFS, _LARGEST_CUTOFF):
            yield "cutoff", f"{cutoff:g} a0", {"interaction.cutoff": cutoff}
    if best.radius < math.inf:
        yield "boundary", "free", free
    if best.radius < math.inf and best.control == "loads":
        largest = float(best.hertz_area(best.steps.max()))
        diameter = 2.0 * math.sqrt(largest / math.pi) / best.spacing
        for ratio in _CELLS:
            side = _MULTIPLE * math.ceil(ratio * diameter / _MULTIPLE)
            cells = {"substrate.periodic": True, "substrate.shape": (side, side)}
            yield "boundary", f"cell of {ratio} diameters", cells
    other = "repulsive" if best.wall.hard or best.wall.attractive else "hard"
    yield "wall", f"{other} instead", {"interaction": InteractionConfig(other)}


def _measured(
    scene: Scene, targets: Sequence[float], of: str, seconds: float
) -> _Answers | None:
    """Return answers and costs; None if it is impossible or takes too long."""
    try:
        plan = plan_path(scene.atoms(), scene.control, targets, scene.window)
    except ValueError:
        return None
    if not plan.runs or plan.seconds > seconds:
        return None
    return _answers(scene, targets, of)


def _theory(best: Scene, targets: Sequence[float], exact: _Answers) -> list[Choice]:
    """Return the choice of Eq. (4), or of Hertz for a smooth sphere, under loads."""
    if best.control != "loads" or best.wall.attractive:
        return []
    label = "Hertz" if best.rough is None else "Eq. (4)"
    areas = np.asarray(best.predicted_area(targets))
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
        for seed in range(first, first + _PILOT)
    ]
    scale = np.mean([each.scale for each in found], axis=0)
    deviation = np.std([each.values for each in found], axis=0, ddof=1)
    spread = (deviation[scale > 0.0] / scale[scale > 0.0]).max(initial=0.0)
    time = sum(each.seconds for each in found) / _PILOT
    memory = max(each.memory for each in found)
    return [
        Choice("realisations", str(n), float(spread / math.sqrt(n)), n * time, memory)
        for n in _COUNTS
    ]


def _cheapest(choices: Sequence[Choice], wanted: float) -> list[tuple[Choice, ...]]:
    """Return the combinations of numerical choices that seem the fastest."""
    groups = [[c for c in choices if c.source == source] for source in _NUMERICAL]
    combined = [
        combination
        for combination in product(*filter(None, groups))
        if sum(choice.error for choice in combination) <= wanted
    ]
    # each time is that of one change: the times relative to the most accurate multiply
    combined.sort(key=lambda plan: math.prod(choice.seconds for choice in plan))
    return combined[:_TRIED]


def _fastest(
    best: Scene, plans: Sequence[tuple[Choice, ...]], targets: Sequence[float]
) -> tuple[Choice, ...]:
    """Return the plan that takes the least time, if calculated; empty without any."""

    def seconds(plan: tuple[Choice, ...]) -> float:
        return sum(step.seconds for step in _relaxed(_planned(best, plan), targets))

    return min(plans, key=seconds, default=())


def _planned(scene: Scene, plan: Sequence[Choice]) -> Scene:
    """Return the scene with the settings of a plan."""
    settings = [choice.settings.items() for choice in plan]
    return scene.with_values(dict(chain.from_iterable(settings)))


def _unseen(scene: Scene, targets: Sequence[float]) -> tuple[Scene, Sequence[float]]:
    """Return another surface, or for a smooth one other targets."""
    if scene.roughness is not None:
        seed = scene.roughness.seed + _PILOT
        return scene.with_values({"roughness.seed": seed}), targets
    between = np.unique([*targets, 0.9 * targets[-1]])
    return scene, list((between[1:] + between[:-1]) / 2.0)


def _answers(scene: Scene, targets: Sequence[float], of: str) -> _Answers:
    """Return answers and costs of the steps of a scene."""
    columns = (name or scene.area_column for name in _COLUMNS[of])
    steps = _relaxed(scene, targets)
    values, scales, errors = (
        np.array([getattr(step, name) for step in steps])
        for name in (*columns, f"{of}_error")
    )
    seconds, memory = sum(s.seconds for s in steps), max(s.memory for s in steps)
    return _Answers(values, errors, abs(scales), seconds, memory)


def _relaxed(scene: Scene, targets: Sequence[float]) -> list[LoadStep]:
    """Relax the steps of a scene."""
    return list(scene.relax(targets, validity="ignore"))
