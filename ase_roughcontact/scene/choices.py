"""Choices of a scene with their errors and costs, and a plan."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field
from typing import Any

from ase_roughcontact._util.text import cell
from ase_roughcontact._util.units import UNITS


@dataclass(frozen=True)
class Choice:
    """Error and cost of a choice.

    Attributes
    ----------
    source : str
        Of the error: the scene as given, tolerance, grid, cutoff, boundary, wall,
        theory or realisations.
    label : str
    error : float
        Largest relative error of the answer of any step.
    seconds : float
        Wall-clock time (s).
    memory : float
        Estimated peak memory (bytes).
    settings : dict
        Values by key of the scene file.
    """

    source: str
    label: str
    error: float
    seconds: float
    memory: float = 0.0
    settings: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Tradeoff:
    """Choices of a scene, and the cheapest plan for a wanted error; printed as a table.

    Attributes
    ----------
    wanted : float
        Total relative error.
    steps : tuple of str
        Targets of the calculated steps.
    choices : tuple of Choice
    plan : tuple of Choice
        Numerical choices whose errors add up to less; empty if there are none.
    checked : float
        Error of the plan on a surface, or at loads, that it was not made for; NaN
        without a plan.
    of : {"area", "force", "height"}
        The answer that has the errors; that of the height is relative to the
        penetration.
    """

    wanted: float
    steps: tuple[str, ...]
    choices: tuple[Choice, ...]
    plan: tuple[Choice, ...] = ()
    checked: float = math.nan
    of: str = "area"

    @property
    def kept(self) -> bool:
        """Whether there is a plan, and the check run had the wanted error."""
        return self.checked <= self.wanted

    @property
    def realisations(self) -> int:
        """Number of surfaces whose mean has the wanted error, too; 0 if unknown."""
        single = [c.error for c in self.choices if c.source == "realisations"]
        left = self.wanted**2 - sum(c.error for c in self.plan) ** 2
        if not single or not self.plan or left <= 0.0:
            return 0
        return math.ceil(max(single) ** 2 / left)

    @property
    def toml(self) -> str:
        """The settings of the plan as sections of a scene file."""
        sections: dict[str, list[str]] = {}
        for choice in self.plan:
            for key, value in choice.settings.items():
                title, name = key.split(".")
                lines = sections.setdefault(title, [f"[{title}]"])
                lines.append(f"{name} = {json.dumps(value)}")
        return "\n\n".join("\n".join(lines) for lines in sections.values())

    @property
    def front(self) -> list[Choice]:
        """Choices than which no other is both faster and more accurate."""
        return [
            each
            for each in self.choices
            if not any(
                other.error <= each.error
                and other.seconds <= each.seconds
                and (other.error, other.seconds) != (each.error, each.seconds)
                for other in self.choices
            )
        ]

    def __str__(self) -> str:
        labels = "choice", *(choice.label for choice in self.choices)
        width = 1 + max(map(len, labels))
        front = self.front
        lines = [
            f"{'source':<14}{'choice':<{width}}{f'{self.of} error':>12}  time (s)  "
            "memory (GB)"
        ]
        lines += [
            f"{c.source:<14}{c.label:<{width}}{cell(c.error, 12, '.1e')}"
            f"{cell(c.seconds, 10, '.2g')}{cell(c.memory / UNITS['GB'], 13, '.2f')}"
            + ("  *" if c in front else "")
            for c in self.choices
        ]
        lines += [
            "",
            f"Errors: largest relative error of the {self.of} of any step"
            + (", relative to the penetration" if self.of == "height" else "")
            + ", with all other numerical choices as accurate as possible.",
            f"*: no other choice is both faster and more accurate. Steps: "
            f"{', '.join(self.steps)}.",
            "",
        ]
        if not self.plan:
            return "\n".join([*lines, f"No plan has an error of {self.wanted:g}."])
        surface = "another surface" if self.realisations else "other steps"
        lines += [
            f"Cheapest plan for an error of {self.wanted:g}:",
            "",
            self.toml,
            "",
            f"On {surface} its error was {self.checked:.1e}: "
            + ("kept." if self.kept else "NOT KEPT."),
        ]
        if self.realisations:
            lines.append(
                f"For the mean over surfaces: {self.realisations} realisations."
            )
        return "\n".join(lines)
