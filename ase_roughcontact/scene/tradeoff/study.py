"""Try settings on a few steps of a scene, beside a far more accurate calculation."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from ase_roughcontact._util.validation import integer, positive
from ase_roughcontact.paths.record import LoadStep
from ase_roughcontact.scene import NANONEWTON, Scene
from ase_roughcontact.scene.tradeoff.results import SAFE, Choice, Tradeoff, Trial

# Accuracies that are tried, and those of the reference and of what tells its error.
_TRIED = (1e-1, 1e-2, 1e-3, 1e-4, 1e-6)
_REFERENCE, _NEARLY = 1e-10, 1e-9
# Least error that the reference can tell from its own.
_LEAST_ASKED = 10.0 * _REFERENCE
# How much better than the error that is asked for a reference must be.
_FAR_BETTER = 10.0
# Cutoffs of a full wall that are tried, and that of the reference, in units of r0.
_CUTOFFS, _FAR = (3.0, 5.0, 10.0, 20.0), 30.0
# Accuracy when the cutoff is what is tried.
_TIGHT = 1e-6
# Mean pressure in contact, in units of E*: that of the paper's rough surfaces.
_USUAL_PRESSURE = 0.05
# Least of so many times is taken.
_REPEATS = 2


def tradeoff(
    scene: Scene, error: float = 1e-3, *, steps: int = 3, seconds: float = 120.0
) -> Tradeoff:
    """Find out what accuracy costs in a scene, and recommend settings.

    Parameters
    ----------
    scene : Scene
        Its own settings are tried first, then others.
    error : float
        Relative error that is allowed in force and area.
    steps : int
        How many steps of its path to try: the first, the last, and some between, each
        after the one before it.
    seconds : float
        Steps for which all of it would take longer than about this are left out,
        but for the first one.

    Returns
    -------
    Tradeoff
        ``str()`` of it is a table and a recommendation.

    Raises
    ------
    ValueError
        If a number is not what it should be, or the scene is wrong.
    RuntimeError
        If the reference gets stuck before it is ten times better than `error`.

    Notes
    -----
    The steps are taken one after the other, without most of those between: with strong
    adhesion that may lead to other states than the whole path. Steps that are not tried
    may make larger errors: a setting is recommended if its accuracy promises what is
    asked for, and what was measured is below 0.3 of that.
    """
    positive(error=error)
    integer("steps", steps, 1)
    positive(seconds=seconds)
    reference = Choice(_REFERENCE, cutoff=_FAR if _varies(scene) else None)
    targets, left_out = _targets(_with(scene, reference), steps, seconds)

    truth = _relaxed(scene, reference, targets)
    reached = _reached(truth, error)
    nearly = replace(reference, accuracy=max(_NEARLY, 10.0 * reached))
    beside = _errors(scene, _relaxed(scene, nearly, targets), truth)
    unit, name = {"load": (NANONEWTON, "nN")}.get(scene.path.control, (1.0, "Å"))
    return Tradeoff(
        wanted=error,
        steps=tuple(f"{target / unit:.4g} {name}" for target in targets),
        left_out=left_out,
        trials=tuple(_trials(scene, error, targets, truth)),
        reference_error=max(reached, *beside[:2]),
    )


def _reached(truth: list[LoadStep], error: float) -> float:
    """Return the accuracy at which the reference got stuck; zero if it did not."""
    stalled = [record for record in truth if not record.converged]
    left = [_REFERENCE * record.max_force / record.tolerance for record in stalled]
    reached = max(left, default=0.0)
    if reached > error / _FAR_BETTER:
        worst = stalled[left.index(reached)]
        raise RuntimeError(
            f"no reference is {_FAR_BETTER:g} times better than an error of {error:g}: "
            f"the best one stops at {reached:.1e}, in step {worst.step} of those "
            f"tried: {worst.message} (forces in eV/Å)"
        )
    return reached


def _varies(scene: Scene) -> bool:
    """Whether the wall has a cutoff that is not given."""
    given = scene.interaction
    return "cutoff" in scene.wall.parameters and "cutoff" not in given.parameters


def _trials(
    scene: Scene, error: float, targets: list[float], truth: list[LoadStep]
) -> list[Trial]:
    """Try the scene as it is, then cutoffs where they vary, then accuracies."""

    def tried(choices: Iterable[Choice]) -> list[Trial]:
        return [_trial(scene, choice, targets, truth) for choice in choices]

    solver = scene.solver
    trials = tried([Choice(solver.accuracy, solver.optimizer, solver.fmax)])
    cutoff = None
    if _varies(scene):
        walls = tried(Choice(_TIGHT, cutoff=cutoff) for cutoff in _CUTOFFS)
        good = [wall.choice.cutoff for wall in walls if wall.error <= SAFE * error]
        cutoff = good[0] if good else _CUTOFFS[-1]
        trials += walls
    asked = {error} if 1.0 > error >= _LEAST_ASKED else set()
    accuracies = sorted({*_TRIED, *asked}, reverse=True)
    return trials + tried(Choice(accuracy, cutoff=cutoff) for accuracy in accuracies)


def _targets(scene: Scene, steps: int, seconds: float) -> tuple[list[float], int]:
    """Choose steps that do not take too long, and count those that do."""
    plan = scene.plan()
    planned = [step for step in plan.steps if not step.problem]
    if not planned:
        raise ValueError(f"no step can be tried: {plan.steps[0].problem}")
    runs = _REPEATS * (len(_TRIED) + len(_CUTOFFS) + 2) + 2
    share = seconds / (runs * 2 * steps)
    cheap = [step.target for step in planned if step.seconds <= share]
    cheap = cheap or [planned[0].target]
    return [cheap[i] for i in _some(len(cheap), steps)], len(planned) - len(cheap)


def _with(scene: Scene, choice: Choice) -> Scene:
    """Return the scene with the settings of a choice."""
    solver = replace(
        scene.solver,
        accuracy=choice.accuracy,
        optimizer=choice.optimizer,
        fmax=choice.fmax,
    )
    wall = scene.interaction
    if choice.cutoff is not None:
        wall = wall.changed("cutoff", choice.cutoff)
    return replace(scene, solver=solver, interaction=wall)


def _some(count: int, wanted: int) -> list[int]:
    """Return the first of a number of steps, the last, and some between, evenly.

    Each has the one before it, from which the path comes to it.
    """
    places = np.linspace(0, count - 1, min(wanted, count)).round().astype(int)
    return sorted({*places.tolist(), *(place - 1 for place in places[1:].tolist())})


def _relaxed(scene: Scene, choice: Choice, targets: list[float]) -> list[LoadStep]:
    """Relax some steps of the scene with the settings of a choice."""
    return list(_with(scene, choice).relax(targets))


def _trial(
    scene: Scene, choice: Choice, targets: list[float], truth: list[LoadStep]
) -> Trial:
    """Try a choice."""
    runs = [_relaxed(scene, choice, targets) for _ in range(_REPEATS)]
    records = runs[0]
    force_error, area_error, atoms = _errors(scene, records, truth)
    return Trial(
        choice,
        force_error,
        area_error,
        atoms,
        pairs=sum(record.pairs for record in records),
        work=sum(r.pairs * math.prod(_shape(r.grid)) for r in records),
        seconds=min(sum(record.seconds for record in run) for run in runs),
        memory=max(record.memory for record in records),
        converged=all(record.converged for record in records),
    )


def _errors(
    scene: Scene, records: list[LoadStep], truth: list[LoadStep]
) -> tuple[float, float, int]:
    """Largest errors of force and area, and the most atoms amiss."""
    pairs = list(zip(records, truth, strict=True))
    atoms = [abs(r.repulsive_atoms - t.repulsive_atoms) for r, t in pairs]
    area = [n / max(1, t.repulsive_atoms) for n, t in zip(atoms, truth, strict=True)]
    if scene.path.control == "load":
        depths = [max(abs(t.penetration), scene.spacing) for t in truth]
        force = [
            abs(r.height - t.height) / d
            for (r, t), d in zip(pairs, depths, strict=True)
        ]
    else:
        # a force near zero is the difference of push and pull: it is measured by the
        # usual push on as many atoms, if that is larger
        unit = _USUAL_PRESSURE * scene.contact_modulus
        pushes = [max(abs(t.normal_force), unit * t.contact_area) for t in truth]
        force = [
            abs(r.normal_force - t.normal_force) / (push or 1.0)
            for (r, t), push in zip(pairs, pushes, strict=True)
        ]
    return max(force), max(area), max(atoms)


def _shape(text: str) -> tuple[int, int]:
    n, m = map(int, text.split("x"))
    return n, m
