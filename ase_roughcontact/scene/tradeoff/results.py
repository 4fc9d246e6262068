"""What accuracy costs in a scene: settings, trials of them, and a recommendation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ase_roughcontact.paths.accuracy import accuracy_of

#: Part of the error that a trial may make: steps that are not tried may be worse.
SAFE = 0.3


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
    cutoff : float or None
        Key of ``[interaction]``, for a full wall.
    """

    accuracy: float | str
    optimizer: str | None = None
    fmax: float | None = None
    cutoff: float | None = None

    def __str__(self) -> str:
        """Tell what is not as usual."""
        accuracy = self.accuracy
        told = [accuracy if isinstance(accuracy, str) else f"{accuracy:.0e}"]
        if self.fmax is not None:
            told = [f"fmax {self.fmax:.3g}"]
        told += [self.optimizer] if self.optimizer else []
        told += [f"cutoff {self.cutoff:g}"] if self.cutoff is not None else []
        return ", ".join(told)

    @property
    def promise(self) -> float:
        """Relative error that the accuracy allows; zero where `fmax` replaces it."""
        return 0.0 if self.fmax is not None else accuracy_of(self.accuracy).error

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
        Largest relative error of the contact area.
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
        Error of the reference itself, which counts as one of the trials, too.
    """

    wanted: float
    steps: tuple[str, ...]
    left_out: int
    trials: tuple[Trial, ...]
    reference_error: float

    @property
    def best(self) -> Trial | None:
        """Cheapest trial that promises the error and safely keeps to it, or None."""
        good = [
            trial
            for trial in self.trials
            if trial.choice.promise <= self.wanted
            and trial.error + self.reference_error <= SAFE * self.wanted
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
            "Errors: relative, largest of any step (force: under given loads, of the "
            "penetration); atoms: in contact, too many or too few; pairs: of FFTs.",
            f"Steps: {', '.join(self.steps)}{skipped}.",
            "The first line is the scene as it is.",
            f"What is compared with is itself known to {self.reference_error:.0e}.",
            "",
        ]
        if self.best is None:
            return "\n".join([*lines, self._refusal])
        advice = f"For an error of {self.wanted:g} write:"
        return "\n".join([*lines, advice, "", self.best.choice.toml])

    @property
    def _refusal(self) -> str:
        least = min(self.trials, key=lambda trial: trial.error)
        return (
            f"No setting that was tried is safe for an error of {self.wanted:g}: its "
            f"accuracy must promise that, and {SAFE:g} of it be kept to on these "
            f"steps. The least error was {least.error:.1e} ({least.choice})."
        )
