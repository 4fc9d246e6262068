"""Results of a path: numbers that follow from all its steps, such as a pull-off force.

A kind of path declares them once. Its printed summary by default, and the columns,
means and figures of ensembles follow from the declaration.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from ase_roughcontact.results.record import LoadStep
from ase_roughcontact.scene.bodies import Bodies


@dataclass(frozen=True)
class FinishedPath:
    """All steps of a path, from which its results follow.

    Attributes
    ----------
    path : PathKind
        Section of the scene.
    bodies : Bodies
        Solid, indenter and wall.
    steps : sequence of LoadStep
        The steps in order, of the class `record` of the path.
    """

    path: Any
    bodies: Bodies
    steps: Sequence[Any]

    @cached_property
    def result(self) -> Any:
        """Object that the path makes of its steps, see `PathKind.result`."""
        return self.path.result(self.bodies, self.steps)


@dataclass(frozen=True)
class PathResult:
    """A number that follows from all steps of a path.

    Attributes
    ----------
    value : callable
        Function of a `FinishedPath` that returns the number.
    description : str
        A noun phrase for tables and reference pages.
    unit : str
        The unit in ASE's units; empty for a number without unit.
    label : str
        Short heading for printed tables and figures.
    where : str
        Paths for which the number is defined: "paths with a cantilever".
    includes : callable
        Function of a `FinishedPath` that returns whether the number is defined; it is
        NaN otherwise.
    error : str
        Name of the result with the estimated error of the number; empty if there is no
        estimate.
    theory : callable or None
        Function of a theory of the smooth sphere, see `ase_roughcontact.theory`, that
        returns the number (in the same unit).
    is_lower_bound : callable
        Function of a `FinishedPath` that returns whether the number is a lower bound.
    """

    value: Callable[[FinishedPath], float]
    description: str
    unit: str = ""
    label: str = ""
    where: str = "all paths"
    includes: Callable[[FinishedPath], bool] = lambda path: True
    error: str = ""
    theory: Callable[[Any], float] | None = None
    is_lower_bound: Callable[[FinishedPath], bool] = lambda path: False

    def of(self, path: FinishedPath) -> float:
        """Return the number, NaN where it is not defined."""
        return float(self.value(path)) if self.includes(path) else math.nan


def results_of(
    path: Any, bodies: Bodies, steps: Sequence[LoadStep]
) -> dict[str, float]:
    """Return the declared results of a path by name.

    Parameters
    ----------
    path : PathKind
    bodies : Bodies
    steps : sequence of LoadStep
        All steps of the path.

    Returns
    -------
    dict of float
        Numbers in ASE's units; NaN where a result is not defined.
    """
    finished = FinishedPath(path, bodies, steps)
    return {name: each.of(finished) for name, each in path.results.items()}


def lower_bounds_of(
    path: Any, bodies: Bodies, steps: Sequence[LoadStep]
) -> tuple[str, ...]:
    """Return the names of the results that are lower bounds; see `results_of`."""
    finished, results = FinishedPath(path, bodies, steps), path.results
    return tuple(k for k, each in results.items() if each.is_lower_bound(finished))
