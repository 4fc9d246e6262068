"""Output columns: a value of a relaxed step, its description, unit, label and range.

A class of results has columns as fields, `column`, and on request, `column_on_request`:
which are attributes of the classes that `LoadStep.with_columns` makes.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, overload

from ase_roughcontact.stepping.relaxed import RelaxedStep


@dataclass(frozen=True)
class Range:
    """Walls, solids, boundaries, paths and states for which a column is defined.

    Attributes
    ----------
    text : str
        The cases in which the column is defined: "walls with a hardness".
    includes : callable
        Function of a `RelaxedStep` that returns whether the column is defined.
    constant : bool
        Whether the function depends on wall, solid, boundary and path alone, and so is
        the same in all steps.
    """

    text: str
    includes: Callable[[RelaxedStep], bool]
    constant: bool = False


#: All steps.
EVERYWHERE = Range("all steps", lambda s: True)


@dataclass(frozen=True)
class Column:
    """An output column.

    Attributes
    ----------
    value : callable
        Function of a `RelaxedStep` that returns a number, a bool or a string.
    description : str
        A description of half a sentence for tables and reference pages.
    unit : str
        The unit in ASE's units; empty for a number without unit.
    label : str
        Short heading for printed tables; empty for a column that is not printed.
    where : Range
        The range in which the column is defined; it is NaN elsewhere.
    """

    value: Callable[[RelaxedStep], Any]
    description: str
    unit: str = ""
    label: str = ""
    where: Range = EVERYWHERE

    def of(self, step: RelaxedStep) -> Any:
        """Return the value of a step, NaN where the column is not defined."""
        return self.value(step) if self.where.includes(step) else math.nan


def column(
    value: Callable[[RelaxedStep], Any],
    description: str,
    unit: str = "",
    label: str = "",
    where: Range = EVERYWHERE,
) -> Any:
    """Return a dataclass field that is an output column; see `Column`.

    Returns
    -------
    dataclasses.Field
    """
    return field(metadata={"column": Column(value, description, unit, label, where)})


class ColumnOnRequest:
    """Column that is calculated only in classes of results for which it is requested.

    Parameters
    ----------
    column : Column
        The column, with values of type float.
    """

    def __init__(self, column: Column) -> None:
        self.column = column

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    @overload
    def __get__(self, step: None, owner: type) -> ColumnOnRequest: ...
    @overload
    def __get__(self, step: Any, owner: type) -> float: ...
    def __get__(self, step: Any, owner: type) -> Any:
        if step is None:
            return self
        raise AttributeError(
            f"{self._name} is calculated on request only: give "
            f'Output(columns=[{self._name!r}]), or columns = ["{self._name}"] in '
            "[output] of a scene"
        )


def column_on_request(
    value: Callable[[RelaxedStep], float],
    description: str,
    unit: str = "",
    label: str = "",
    where: Range = EVERYWHERE,
) -> ColumnOnRequest:
    """Return a column that is calculated on request only; see `Column`.

    It is an attribute without a type of a class of results.

    Returns
    -------
    ColumnOnRequest
    """
    return ColumnOnRequest(Column(value, description, unit, label, where))
