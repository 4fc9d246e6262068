"""Status of a solution: converged, unfinished, or a reason for the end.

A status is recognised by its kind. Solvers define further kinds of their own.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class StatusKind:
    """Kind of a status.

    Attributes
    ----------
    reason : str
        Reason why a solution is not converged, with names of numbers as in
        `str.format`. The names ``force_unit`` and ``length_unit`` stand for units,
        which solvers on arrays do not know.
    advice : str
        Advice to the user; may be empty.
    """

    reason: str
    advice: str = ""


#: The solution is within the tolerance.
CONVERGED = StatusKind("converged")
#: A further step is possible.
UNFINISHED = StatusKind("unfinished")
#: The largest number of steps was reached.
STEP_LIMIT = StatusKind("not converged after {steps} steps", "allow more steps")
#: A generator of a solver has ended without a reason.
ENDED = StatusKind("the solver has ended")


@dataclass(frozen=True)
class Status:
    """Status of a solution.

    Attributes
    ----------
    kind : StatusKind
        Kind of the status.
    numbers : mapping of str to float or str
        Values of the names in the reason of the kind.
    advice : str
        Advice for this solution, in place of the advice of the kind.
    """

    kind: StatusKind
    numbers: Mapping[str, float | str] = field(default_factory=dict)
    advice: str = ""

    @classmethod
    def of(cls, converged: bool) -> Status:
        """Return the status of a solution that is converged, or can be continued."""
        return cls(CONVERGED if converged else UNFINISHED)

    @property
    def converged(self) -> bool:
        """Whether the solution is within the tolerance."""
        return self.kind == CONVERGED

    @property
    def final(self) -> bool:
        """Whether there is no further step."""
        return self.kind != UNFINISHED

    @property
    def message(self) -> str:
        """Reason and advice without units; see `text`."""
        return self.text()

    def text(self, force_unit: str = "", length_unit: str = "") -> str:
        """Return the reason why the solution is not converged, and the advice.

        Parameters
        ----------
        force_unit, length_unit : str
            Units that are written behind forces and lengths.

        Returns
        -------
        str
            Reason and advice; empty if the solution is converged or can be continued.
        """
        if self.converged or not self.final:
            return ""
        units = {"force_unit": force_unit, "length_unit": length_unit}
        units = {name: f" {unit}" if unit else "" for name, unit in units.items()}
        reason = self.kind.reason.format(**units, **self.numbers)
        advice = self.advice or self.kind.advice
        return f"{reason}; {advice}" if advice else reason


class WithStatus:
    """Base class of results of solvers, which have a `status`."""

    status: Status

    @property
    def converged(self) -> bool:
        """Whether the result is within the tolerance."""
        return self.status.converged

    @property
    def message(self) -> str:
        """Reason why the solver stopped without convergence; empty otherwise."""
        return self.status.message
