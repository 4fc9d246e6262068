"""Trade-off between accuracy and cost, measured on a few steps of a scene.

The steps are calculated with several settings, and compared with a reference that is
calculated far more accurately.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import integer, positive
from ase_roughcontact.paths.accuracy import accuracy_of
from ase_roughcontact.paths.record import LoadStep
from ase_roughcontact.scene.scene import Scene

#: Largest fraction of the requested error that a recommended setting may have made, as
#: the error of other steps may be larger.
SAFETY_FACTOR = 0.3
# Accuracies of the trials.
_ACCURACIES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-6)
# Accuracy of the reference, and of a second one, from which its error is estimated.
_REFERENCE, _SECOND_REFERENCE = 1e-10, 1e-9
# Smallest error that can be distinguished from that of the reference.
_SMALLEST_ERROR = 10.0 * _REFERENCE
# Least ratio of the requested error to that of a reference that did not converge.
_REFERENCE_MARGIN = 10.0
# Cutoffs of the trials and of the reference, in units of the spacing.
_CUTOFFS, _REFERENCE_CUTOFF = (3.0, 5.0, 10.0, 20.0), 30.0
# Accuracy of the trials that compare cutoffs.
_CUTOFF_ACCURACY = 1e-6
# Typical mean pressure in contact, in units of E*.
_TYPICAL_PRESSURE = 0.05
# Number of times that a trial is run; the shortest time counts.
_REPEATS = 2


@dataclass(frozen=True)
class Choice:
    """Settings of a trial.

    Attributes
    ----------
    accuracy : float or str
        Key of ``[solver]``.
    optimizer : str or None
        Key of ``[solver]``; None for the default one.
    fmax : float or None
        Key of ``[solver]``, used instead of the accuracy.
    cutoff : float or None
        Key of ``[interaction]``; None for that of the scene.
    """

    accuracy: float | str
    optimizer: str | None = None
    fmax: float | None = None
    cutoff: float | None = None

    def __str__(self) -> str:
        accuracy = self.accuracy
        words = [accuracy if isinstance(accuracy, str) else f"{accuracy:.0e}"]
        if self.fmax is not None:
            words = [f"fmax {self.fmax:.3g}"]
        if self.optimizer is not None:
            words.append(self.optimizer)
        if self.cutoff is not None:
            words.append(f"cutoff {self.cutoff:g}")
        return ", ".join(words)

    @property
    def nominal_error(self) -> float:
        """Relative error that the accuracy allows; zero if `fmax` replaces it."""
        return 0.0 if self.fmax is not None else accuracy_of(self.accuracy).error

    @property
    def toml(self) -> str:
        """The settings as keys of a scene file."""
        accuracy = self.accuracy
        value = f'"{accuracy}"' if isinstance(accuracy, str) else f"{accuracy:g}"
        lines = ["[solver]", f"accuracy = {value}"]
        if self.fmax is not None:
            lines[1] = f"fmax = {self.fmax!r}"
        if self.optimizer is not None:
            lines.append(f'optimizer = "{self.optimizer}"')
        if self.cutoff is not None:
            lines += ["", "[interaction]", f"cutoff = {self.cutoff}"]
        return "\n".join(lines)

    def scene(self, scene: Scene) -> Scene:
        """Return a scene with these settings."""
        solver = replace(
            scene.solver,
            accuracy=self.accuracy,
            optimizer=self.optimizer,
            fmax=self.fmax,
        )
        wall = scene.interaction
        if self.cutoff is not None:
            wall = wall.changed("cutoff", self.cutoff)
        return replace(scene, solver=solver, interaction=wall)


@dataclass(frozen=True)
class Trial:
    """Cost and error of a choice of settings for the steps of the trial.

    Attributes
    ----------
    choice : Choice
    force_error : float
        Largest relative error of the normal force; it is relative to a pressure of
        0.05 E* on the atoms in contact where the force is smaller than that. Under load
        control that of the penetration instead, relative to the penetration or to the
        spacing if that is larger.
    area_error : float
        Largest relative error of the contact area.
    atoms : int
        Largest error of the number of atoms in contact.
    pairs : float
        Number of FFT pairs.
    work : float
        Number of FFT pairs times the points of their grids.
    seconds : float
        Wall-clock time, the shorter one of two runs.
    memory : float
        Estimated peak memory (bytes).
    converged : bool
        Whether all steps converged.
    """

    choice: Choice
    force_error: float
    area_error: float
    atoms: int
    pairs: float
    work: float
    seconds: float
    memory: float
    converged: bool

    @property
    def error(self) -> float:
        """Error of force and area, infinite if a step did not converge."""
        return max(self.force_error, self.area_error) if self.converged else np.inf


@dataclass(frozen=True)
class Tradeoff:
    """Trials of a scene, and the recommended settings.

    Attributes
    ----------
    wanted : float
        Requested relative error.
    steps : tuple of str
        Targets of the calculated steps.
    left_out : int
        Number of steps that would have been too slow.
    trials : tuple of Trial
        That of the scene's own settings, then the others.
    reference_error : float
        Estimated error of the reference; it is added to that of each trial.
    """

    wanted: float
    steps: tuple[str, ...]
    left_out: int
    trials: tuple[Trial, ...]
    reference_error: float

    @property
    def best(self) -> Trial | None:
        """Cheapest trial whose accuracy and measured error are sufficient, or None."""
        sufficient = [
            trial
            for trial in self.trials
            if trial.choice.nominal_error <= self.wanted
            and trial.error + self.reference_error <= SAFETY_FACTOR * self.wanted
        ]
        # the work does not depend on the load of the machine, the time does
        return min(sufficient, key=lambda trial: trial.work, default=None)

    def __str__(self) -> str:
        lines = [
            f"{'setting':<26}   force error    area error  atoms    pairs  time (s)"
            "  memory (GB)"
        ]
        lines += [
            f"{t.choice!s:<26}{t.force_error:14.1e}{t.area_error:14.1e}"
            f"{t.atoms:7d}{t.pairs:9.0f}{t.seconds:10.2g}{t.memory / 1e9:13.2f}"
            + ("" if t.converged else "   NOT CONVERGED")
            for t in self.trials
        ]
        skipped = f" ({self.left_out} slow steps left out)" if self.left_out else ""
        lines += [
            "",
            "First line: settings of the scene. Errors: largest relative error of any "
            "step (force: under load control, of the penetration); atoms: largest "
            "error of the number in contact; pairs: forward/inverse FFT pairs.",
            f"Steps: {', '.join(self.steps)}{skipped}.",
            f"Estimated error of the reference: {self.reference_error:.0e}.",
            "",
        ]
        if self.best is not None:
            lines += [f"Recommended for an error of {self.wanted:g}:", ""]
            return "\n".join([*lines, self.best.choice.toml])
        least = min(self.trials, key=lambda trial: trial.error)
        lines.append(
            f"No setting is safe for an error of {self.wanted:g}: its accuracy must "
            f"allow no more, and its measured error must be below "
            f"{SAFETY_FACTOR:g} of that. The smallest measured error was "
            f"{least.error:.1e} ({least.choice})."
        )
        return "\n".join(lines)


def tradeoff(
    scene: Scene, error: float = 1e-3, *, steps: int = 3, seconds: float = 120.0
) -> Tradeoff:
    """Measure the cost of accuracy in a scene, and recommend settings.

    Parameters
    ----------
    scene : Scene
        Its own settings are tried first.
    error : float
        Requested relative error of force and area.
    steps : int
        Number of steps of the path to calculate: the first, the last, and some between,
        each after its predecessor.
    seconds : float
        Time for all trials (s). Steps that are too slow for it are left out, except
        for the first one.

    Returns
    -------
    Tradeoff
        Printed, it is a table and a recommendation.

    Raises
    ------
    ValueError
        If an argument is out of range, or the scene is invalid.
    RuntimeError
        If the reference does not converge to a tenth of `error`.

    Notes
    -----
    Most steps between the calculated ones are skipped. With strong adhesion this may
    lead to other states than the whole path.
    """
    positive(error=error, seconds=seconds)
    integer("steps", steps, 1)
    vary_cutoff = (
        "cutoff" in scene.wall.parameters
        and "cutoff" not in scene.interaction.parameters
    )
    best = Choice(_REFERENCE, cutoff=_REFERENCE_CUTOFF if vary_cutoff else None)
    targets, left_out = _targets(best.scene(scene), steps, seconds)
    reference = list(best.scene(scene).relax(targets))
    reached = _reached(reference, error)
    second = replace(best, accuracy=max(_SECOND_REFERENCE, 10.0 * reached))
    force_error, area_error, _ = _errors(
        scene, list(second.scene(scene).relax(targets)), reference
    )

    def tried(*choices: Choice) -> list[Trial]:
        return [_trial(scene, choice, targets, reference) for choice in choices]

    solver, cutoff = scene.solver, None
    trials = tried(Choice(solver.accuracy, solver.optimizer, solver.fmax))
    if vary_cutoff:
        walls = tried(*(Choice(_CUTOFF_ACCURACY, cutoff=c) for c in _CUTOFFS))
        good = [t.choice.cutoff for t in walls if t.error <= SAFETY_FACTOR * error]
        cutoff = good[0] if good else _CUTOFFS[-1]
        trials += walls
    requested = {error} if _SMALLEST_ERROR <= error < 1.0 else set()
    accuracies = sorted(requested | set(_ACCURACIES), reverse=True)
    trials += tried(*(Choice(accuracy, cutoff=cutoff) for accuracy in accuracies))
    unit = "nN" if scene.path.control == "load" else "Å"
    return Tradeoff(
        wanted=error,
        steps=tuple(f"{target / UNITS[unit]:.4g} {unit}" for target in targets),
        left_out=left_out,
        trials=tuple(trials),
        reference_error=max(reached, force_error, area_error),
    )


def _targets(scene: Scene, steps: int, seconds: float) -> tuple[list[float], int]:
    """Return the targets to calculate, and the number of steps that are too slow."""
    plan = scene.plan()
    planned = [step for step in plan.steps if not step.problem]
    if not planned:
        raise ValueError(f"no step can be tried: {plan.steps[0].problem}")
    runs = _REPEATS * (len(_ACCURACIES) + len(_CUTOFFS) + 2) + 2
    limit = seconds / (runs * 2 * steps)
    fast = [step.target for step in planned if step.seconds <= limit]
    fast = fast or [planned[0].target]
    chosen = np.linspace(0, len(fast) - 1, min(steps, len(fast))).round().astype(int)
    chosen = np.union1d(chosen, chosen[1:] - 1)  # each step after its predecessor
    return [fast[i] for i in chosen], len(planned) - len(fast)


def _reached(reference: list[LoadStep], error: float) -> float:
    """Return the accuracy at which the reference stalled; zero if it converged."""
    stalled = [step for step in reference if not step.converged]
    if not stalled:
        return 0.0
    worst = max(stalled, key=lambda step: step.max_force / step.tolerance)
    reached = _REFERENCE * worst.max_force / worst.tolerance
    if reached > error / _REFERENCE_MARGIN:
        raise RuntimeError(
            f"no reference is {_REFERENCE_MARGIN:g} times more accurate than an error "
            f"of {error:g}: the best one stops at {reached:.1e}, in step {worst.step} "
            f"of those calculated: {worst.message} (forces in eV/Å)"
        )
    return reached


def _trial(
    scene: Scene, choice: Choice, targets: list[float], reference: list[LoadStep]
) -> Trial:
    runs = [list(choice.scene(scene).relax(targets)) for _ in range(_REPEATS)]
    steps = runs[0]
    points = [math.prod(map(int, step.grid.split("x"))) for step in steps]
    force_error, area_error, atoms = _errors(scene, steps, reference)
    return Trial(
        choice,
        force_error,
        area_error,
        atoms,
        pairs=sum(step.pairs for step in steps),
        work=sum(step.pairs * n for step, n in zip(steps, points, strict=True)),
        seconds=min(sum(step.seconds for step in run) for run in runs),
        memory=max(step.memory for step in steps),
        converged=all(step.converged for step in steps),
    )


def _errors(
    scene: Scene, steps: list[LoadStep], reference: list[LoadStep]
) -> tuple[float, float, int]:
    """Return the largest errors of force, area and number of atoms in contact."""

    def column(name: str) -> np.ndarray:
        return np.array(
            [[getattr(s, name) for s in path] for path in (steps, reference)]
        )

    atoms, exact_atoms = column("repulsive_atoms")
    wrong = abs(atoms - exact_atoms)
    if scene.path.control == "load":
        value, exact = column("height")
        scale = np.maximum(abs(column("penetration")[1]), scene.spacing)
    else:
        # a small force may be the difference of large repulsion and attraction
        value, exact = column("normal_force")
        pressure = _TYPICAL_PRESSURE * scene.contact_modulus
        scale = np.maximum(abs(exact), pressure * column("contact_area")[1])
        scale[scale == 0.0] = 1.0
    return (
        float((abs(value - exact) / scale).max()),
        float((wrong / np.maximum(1, exact_atoms)).max()),
        int(wrong.max()),
    )
