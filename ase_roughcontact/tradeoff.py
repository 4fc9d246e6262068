"""What accuracy costs in a scene of one's own, and which settings to take for it.

A few steps of the scene are calculated with one setting after the other, and compared
with the same steps calculated far more accurately.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from ase_roughcontact.checks import integer, positive
from ase_roughcontact.loading import load_path
from ase_roughcontact.memory import memory_of
from ase_roughcontact.record import LoadStep
from ase_roughcontact.scene import NANONEWTON, OPTIMIZERS, Scene

# Accuracies that are tried, and those of the reference and of what tells its error.
_TRIED = (1e-1, 1e-2, 1e-3, 1e-4, 1e-6)
_REFERENCE, _NEARLY = 1e-10, 1e-9
# Cutoffs of a full wall that are tried, and that of the reference, in units of r0.
_CUTOFFS, _FAR = (3.0, 5.0, 10.0, 20.0), 30.0
# Accuracy when the cutoff is what is tried.
_TIGHT = 1e-6
# Mean pressure in contact, in units of E*: that of the paper's rough surfaces.
_USUAL_PRESSURE = 0.05
# Part of the error that a trial may make: steps that are not tried may be worse.
_SAFE = 0.3
# Least of so many times is taken.
_REPEATS = 2


@dataclass(frozen=True)
class Choice:
    """Settings of a trial.

    Attributes
    ----------
    accuracy : float or str
        Key of ``[solver]``.
    optimizer : str or None
        Key of ``[solver]``; None is the default one.
    fmax : float or None
        Key of ``[solver]``, in place of the accuracy.
    precision : str
        Of the transforms: option `fft` of `RoughContact`, no key of a scene.
    cutoff : float or None
        Key of ``[interaction]``, for a full wall.
    """

    accuracy: float | str
    optimizer: str | None = None
    fmax: float | None = None
    precision: str = "float64"
    cutoff: float | None = None

    def __str__(self) -> str:
        """Tell what is not as usual."""
        accuracy = self.accuracy
        told = [accuracy if isinstance(accuracy, str) else f"{accuracy:.0e}"]
        if self.fmax is not None:
            told = [f"fmax {self.fmax:.3g}"]
        told += [self.optimizer] if self.optimizer else []
        told += [self.precision] if self.precision != "float64" else []
        told += [f"cutoff {self.cutoff:g}"] if self.cutoff is not None else []
        return ", ".join(told)

    @property
    def toml(self) -> str:
        """Keys to write into the scene file."""
        accuracy = self.accuracy
        told = f'"{accuracy}"' if isinstance(accuracy, str) else f"{accuracy:g}"
        lines = ["[solver]", f"accuracy = {told}"]
        if self.fmax is not None:
            lines[1] = f"fmax = {self.fmax!r}"
        if self.optimizer is not None:
            lines.append(f'optimizer = "{self.optimizer}"')
        if self.cutoff is not None:
            lines += ["", "[interaction]", f"cutoff = {self.cutoff}"]
        return "\n".join(lines)


@dataclass(frozen=True)
class Trial:
    """What a choice costs, and what error it makes, on the steps that were tried.

    Attributes
    ----------
    choice : Choice
    force_error : float
        Largest relative error of the normal force (relative to a push of 0.05 E* on
        the atoms in contact where it is less than that); where loads are given, of the
        penetration instead, relative to itself or to the spacing if that is larger.
    area_error : float
        Largest relative error of the contact area beyond one atom.
    atoms : int
        Largest number of atoms in contact that are too many or too few.
    pairs, work : float
        Pairs of transforms in all, and the points of their grids.
    seconds : float
        Time in all, the least of two.
    memory : float
        Most that a step takes (bytes, estimated).
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
        """Error in force and area, infinite where a step did not converge."""
        return max(self.force_error, self.area_error) if self.converged else np.inf


@dataclass(frozen=True)
class Tradeoff:
    """What accuracy costs in a scene.

    Attributes
    ----------
    wanted : float
        Relative error that is allowed.
    steps : tuple of str
        Targets of the steps that were tried.
    left_out : int
        Number of steps that would have taken too long.
    trials : tuple of Trial
        The scene as it is, then the others.
    reference_error : float
        Error of the reference itself.
    atom : float
        Share of one atom in the smallest contact: no area is known better.
    """

    wanted: float
    steps: tuple[str, ...]
    left_out: int
    trials: tuple[Trial, ...]
    reference_error: float
    atom: float

    @property
    def best(self) -> Trial | None:
        """Cheapest trial in double precision, safely within the error; or None."""
        good = [
            trial
            for trial in self.trials
            if trial.error <= _SAFE * self.wanted
            and trial.choice.precision == "float64"
        ]
        # transforms in place of seconds, which other work on the machine disturbs
        return min(good, key=lambda trial: trial.work, default=None)

    def __str__(self) -> str:
        """Tell the table and the recommendation."""
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
        skipped = f" ({self.left_out} slow steps not tried)" if self.left_out else ""
        lines += [
            "",
            f"Steps: {', '.join(self.steps)}{skipped}.",
            "The first line is the scene as it is; errors are the largest of any step.",
            f"The reference itself is known to {self.reference_error:.0e}; one atom of "
            f"the smallest contact is {self.atom:.1e} of it, and not counted.",
            "",
        ]
        if self.best is None:
            return "\n".join([*lines, f"No setting keeps to {self.wanted:g}."])
        advice = f"For an error of {self.wanted:g} write:"
        return "\n".join([*lines, advice, "", self.best.choice.toml])


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
        If the reference does not converge.

    Notes
    -----
    The steps are taken one after the other, without most of those between: with strong
    adhesion that may lead to other states than the whole path. Steps that are not tried
    may make larger errors: a setting is recommended if its own are below 0.3 of what is
    allowed. Single precision is told, but not recommended: it is no key of a scene.
    """
    positive(error=error)
    integer("steps", steps, 1)
    positive(seconds=seconds)
    varies = scene.interaction.kind == "full" and scene.interaction.cutoff is None
    reference = Choice(_REFERENCE, cutoff=_FAR if varies else None)
    targets, left_out = _targets(_with(scene, reference), steps, seconds)

    truth = _relaxed(scene, reference, targets)
    failed = [record.message for record in truth if not record.converged]
    if failed:
        raise RuntimeError(
            f"the reference, accuracy {_REFERENCE:g}, does not converge: {failed[0]}"
        )
    nearly = _relaxed(scene, replace(reference, accuracy=_NEARLY), targets)

    def tried(choices: Iterable[Choice]) -> list[Trial]:
        return [_trial(scene, choice, targets, truth) for choice in choices]

    solver = scene.solver
    trials = tried([Choice(solver.accuracy, solver.optimizer, solver.fmax)])
    cutoff = None
    if varies:
        walls = tried(Choice(_TIGHT, cutoff=cutoff) for cutoff in _CUTOFFS)
        good = [wall.choice.cutoff for wall in walls if wall.error <= _SAFE * error]
        cutoff = good[0] if good else _CUTOFFS[-1]
        trials += walls
    trials += tried(Choice(accuracy, cutoff=cutoff) for accuracy in _TRIED)
    trials += tried([Choice(1e-2, precision="float32", cutoff=cutoff)])
    unit, name = {"load": (NANONEWTON, "nN")}.get(scene.path.control, (1.0, "Å"))
    return Tradeoff(
        wanted=error,
        steps=tuple(f"{target / unit:.4g} {name}" for target in targets),
        left_out=left_out,
        trials=tuple(trials),
        reference_error=max(_errors(scene, nearly, truth)[:2]),
        atom=1.0 / max(1, min(record.repulsive_atoms for record in truth)),
    )


def _targets(scene: Scene, steps: int, seconds: float) -> tuple[list[float], int]:
    """Choose steps that do not take too long, and count those that do."""
    planned = scene.plan().steps
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
        wall = replace(wall, cutoff=choice.cutoff)
    return replace(scene, solver=solver, interaction=wall)


def _some(count: int, wanted: int) -> list[int]:
    """Return the first of a number of steps, the last, and some between, evenly.

    Each has the one before it, from which the path comes to it.
    """
    places = np.linspace(0, count - 1, min(wanted, count)).round().astype(int)
    return sorted({*places.tolist(), *(place - 1 for place in places[1:].tolist())})


def _relaxed(scene: Scene, choice: Choice, targets: list[float]) -> list[LoadStep]:
    """Relax some steps of the scene with the settings of a choice."""
    chosen = _with(scene, choice)
    atoms = chosen.atoms()
    atoms.calc.set(fft={"dtype": choice.precision})
    name = choice.optimizer
    path = {f"{scene.path.control}s": targets}
    return list(
        load_path(
            atoms,
            optimizer=None if name is None else OPTIMIZERS[name],
            fmax=chosen.fmax,
            accuracy=choice.accuracy,
            max_steps=scene.solver.max_steps,
            window="fixed" if scene.shape else "auto",
            **path,  # type: ignore[arg-type]
        )
    )


def _trial(
    scene: Scene, choice: Choice, targets: list[float], truth: list[LoadStep]
) -> Trial:
    """Try a choice."""
    runs = [_relaxed(scene, choice, targets) for _ in range(_REPEATS)]
    records, margin = runs[0], bool(scene.shape) and not scene.substrate.periodic
    force_error, area_error, atoms = _errors(scene, records, truth)
    return Trial(
        choice,
        force_error,
        area_error,
        atoms,
        pairs=sum(record.pairs for record in records),
        work=sum(r.pairs * math.prod(_shape(r.grid)) for r in records),
        seconds=min(sum(record.seconds for record in run) for run in runs),
        memory=max(memory_of(_shape(r.window), margin=margin) for r in records),
        converged=all(record.converged for record in records),
    )


def _errors(
    scene: Scene, records: list[LoadStep], truth: list[LoadStep]
) -> tuple[float, float, int]:
    """Largest errors of force and area, and the most atoms amiss."""
    pairs = list(zip(records, truth, strict=True))
    atoms = [abs(r.repulsive_atoms - t.repulsive_atoms) for r, t in pairs]
    beyond = [
        max(0, n - 1) / max(1, t.repulsive_atoms)
        for n, t in zip(atoms, truth, strict=True)
    ]
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
    return max(force), max(beyond), max(atoms)


def _shape(text: str) -> tuple[int, int]:
    n, m = map(int, text.split("x"))
    return n, m
