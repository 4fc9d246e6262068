"""Choices of a scene with their errors and costs, and a plan."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field
from typing import Any, Literal

from ase_roughcontact._util.printing import Printed, number, table
from ase_roughcontact._util.summary import Summarized
from ase_roughcontact._util.units import UNITS

#: Sources of errors that are numerical, which a plan may combine.
NUMERICAL = ("tolerance", "grid", "steps", "optimizer", "cutoff", "boundary")
# Choices beside the numerical ones that also add to the error of a single run: labels
# by source.
_OTHER_CHOICES = {"realisations": ("1",), "model": ("atoms / continuum",)}
# Names of the errors of these choices, and advice, by source.
_ADVICE = {
    "realisations": (
        "the scatter of single realisations",
        "Next: add these lines to the scene, and average over surfaces: "
        "ase-roughcontact ensemble SCENE --error {error}",
    ),
    "model": (
        "the error of counted atoms where the continuum is meant",
        'Next: give [substrate] model = "continuum", and run tradeoff again; if each '
        "point is an atom, the count is the answer.",
    ),
}
# Advice after a plan with an error above the errors of these choices.
_RUN_ADVICE = "Next: add these lines to the scene: ase-roughcontact run SCENE"
#: Part of the wanted error that a plan may have on the steps used for planning.
SAFETY = 0.7


@dataclass(frozen=True)
class Choice(Summarized):
    """Error and cost of a choice.

    Attributes
    ----------
    source : str
        Source of the error: the scene as given, counted atoms in place of the
        continuum, tolerance, grid, steps of a loop, optimizer, cutoff, boundary, wall,
        theory or realisations.
    label : str
        Name of the choice in tables.
    error : float
        Largest relative error of the answer of any step.
    cost : float
        Sum over the steps of the FFT pairs times the points of their grids. It is the
        same in every run, unlike the time.
    seconds : float
        Wall-clock time (s).
    memory : float
        Estimated peak memory (bytes).
    settings : dict
        Values by key of the scene file.
    is_bound : bool
        Whether the error is an upper bound, as the finest grid has about this error
        itself.
    """

    source: str
    label: str
    error: float
    cost: float
    seconds: float = 0.0
    memory: float = 0.0
    settings: dict[str, Any] = field(default_factory=dict)
    is_bound: bool = False

    @property
    def error_text(self) -> str:
        """The error as it is printed, ``"< 1.0e-03"`` if it is a bound."""
        return f"{'< ' * self.is_bound}{self.error:.1e}"

    def is_beaten_by(self, other: Choice) -> bool:
        """Return whether a choice of the same source is better in error and cost."""
        better = other.error <= self.error and other.cost <= self.cost
        equal = other.error == self.error and other.cost == self.cost
        return other.source == self.source and better and not equal


@dataclass(frozen=True)
class Tradeoff(Summarized, Printed):
    """Choices of a scene, and the cheapest plan for a wanted error; printed as a table.

    Attributes
    ----------
    wanted : float
        Total relative error.
    steps : tuple of str
        Targets of the calculated steps.
    choices : tuple of Choice
        All calculated choices.
    plan : tuple of Choice
        Numerical choices with errors that add up to less; empty without such choices.
    checked : float
        Error of the plan on a surface, or at loads, not used for planning; NaN without
        a plan.
    of : {"area", "force", "height"}
        The answer with these errors; the error of the height is relative to the
        penetration.
    left_out : tuple of str
        Choices and steps that were not calculated, and why.
    """

    wanted: float
    steps: tuple[str, ...]
    choices: tuple[Choice, ...]
    plan: tuple[Choice, ...] = ()
    checked: float = math.nan
    of: Literal["area", "force", "height"] = "area"
    left_out: tuple[str, ...] = ()

    @property
    def kept(self) -> bool:
        """Whether there is a plan, and the check run had the wanted error."""
        return self.checked <= self.wanted

    @property
    def realisations(self) -> int:
        """Number of surfaces for a mean with the wanted error, too; 0 if unknown."""
        single = [c.error for c in self.choices if c.source == "realisations"]
        remaining = self.wanted**2 - sum(c.error for c in self.plan) ** 2
        if not single or not self.plan or remaining <= 0.0:
            return 0
        return math.ceil(max(single) ** 2 / remaining)

    @property
    def toml(self) -> str:
        """The settings of the plan as sections of a scene file."""
        sections: dict[str, list[str]] = {}
        for choice in self.plan:
            for key, value in choice.settings.items():
                title, name = key.split(".")
                lines = sections.setdefault(title, [f"[{title}]"])
                given = f"{name} = {json.dumps(value)}"
                lines.append(f"# without {name}" if value is None else given)
        return "\n\n".join("\n".join(lines) for lines in sections.values())

    @property
    def front(self) -> list[Choice]:
        """Numerical choices on the Pareto fronts of error and cost of their sources."""
        return [
            each
            for each in self.choices
            if each.source in NUMERICAL
            and not any(each.is_beaten_by(other) for other in self.choices)
        ]

    @property
    def parts(self) -> list[Any]:
        """The table of choices, its explanation, and the plan."""
        heads = ["source", "choice", f"{self.of} error", "cost (1e6)", "time (s)"]
        heads += ["memory (GB)", ""]
        rows = [
            (
                c.source,
                c.label,
                c.error_text,
                number(c.cost / 1e6, 3),
                number(c.seconds, 2),
                number(c.memory / UNITS["GB"], 2),
                "*" if c in self.front else "",
            )
            for c in self.choices
        ]
        reference = ", relative to the penetration" if self.of == "height" else ""
        parts = [
            table(heads, rows, left=2),
            "",
            f"Errors: largest relative error of the {self.of} of {len(self.steps)} "
            f"steps{reference}, with all other numerical choices as accurate as "
            "possible: of grids and theory against a grid finer than any choice, all "
            "others on one grid. <: below the estimated error of the finest grid.",
            "Cost: FFT pairs times points of the grid. *: no other choice of this "
            "source is both cheaper and more accurate. "
            f"Steps: {', '.join(self.steps)}.",
        ]
        parts += [f"Left out: {text}." for text in self.left_out]
        parts.append("")
        parts += self._plan_lines() if self.plan else [self._why_no_plan()]
        parts += self._largest_error_lines()
        return parts

    def _largest_error_lines(self) -> list[str]:
        """Return the source of the largest error beside the plan, and advice."""
        others = [
            c for c in self.choices if c.label in _OTHER_CHOICES.get(c.source, ())
        ]
        plan_error = sum(choice.error for choice in self.plan)
        largest = max(others, key=lambda choice: choice.error, default=None)
        if largest is None or largest.error <= max(plan_error, self.wanted):
            return [_RUN_ADVICE] if self.plan else []
        times = ""
        if plan_error:
            times = f", {largest.error / plan_error:.2g} times the plan's"
        name, advice = _ADVICE[largest.source]
        return [
            f"The largest error is {name}: {largest.error:.2g}{times}.",
            advice.format(error=f"{self.wanted:g}"),
        ]

    def _plan_lines(self) -> list[str]:
        count = self.realisations
        surface = "another surface" if count else "another case"
        verdict = "kept" if self.kept else "NOT KEPT, ask for a smaller error"
        lines = [
            f"Cheapest plan for an error of {self.wanted:g}:",
            f"\n{self.toml}\n",
            f"On {surface} its error was at most {self.checked:.2e}: {verdict}.",
        ]
        if count:
            lines.append(f"For the mean over surfaces: {count} realisations.")
        return lines

    def _why_no_plan(self) -> str:
        groups = ([c for c in self.choices if c.source == name] for name in NUMERICAL)
        least = [min(group, key=lambda c: c.error) for group in groups if group]
        smallest = " and ".join(f"{c.source} {c.label}: {c.error_text}" for c in least)
        return (
            f"No plan has an error of {self.wanted:g}: errors are added, and may be "
            f"{SAFETY * self.wanted:.2g} in all on these steps, with a margin for "
            f"others. The smallest are {smallest}."
        )
