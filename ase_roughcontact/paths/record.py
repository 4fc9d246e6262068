"""Result of a load step: its columns, each with value, description, unit and label.

A column is one entry of `LoadStep`. The CSV file, the trajectory, JSON lines and tables
of columns follow from it. A subclass adds columns: ::

    @dataclass(frozen=True)
    class MyStep(LoadStep):
        largest_gap: float = column(
            lambda relaxed: relaxed.state.gap.max(), "largest gap in the window", "Å"
        )

    load_path(atoms, depths, record=MyStep, csv="curve.csv")
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from ase import Atoms

from ase_roughcontact.contact import ContactState
from ase_roughcontact.elasticity.halfspace import HalfSpace
from ase_roughcontact.windows.memory import memory_of, points_of


@dataclass
class SolverStatistics:
    """Outcome and cost of relaxing a step; summed over its runs of the optimizer.

    Attributes
    ----------
    converged : bool
    message : str
    tolerance : float
    iterations : int
    pairs : float
        See `LoadStep`.
    """

    converged: bool = False
    message: str = ""
    tolerance: float = np.inf
    iterations: int = 0
    pairs: float = 0.0


@dataclass(frozen=True)
class RelaxedStep:
    """Relaxed atoms, from which the columns of a step are calculated.

    Attributes
    ----------
    atoms : Atoms
        With a `RoughContact` calculator.
    number : int
        Number of the step, from zero.
    first_contact : float
        Height at which the indenter begins to repel the flat substrate (Å).
    statistics : SolverStatistics
    seconds : float
        Wall-clock time of the relaxation.
    """

    atoms: Atoms
    number: int
    first_contact: float
    statistics: SolverStatistics
    seconds: float

    @property
    def height(self) -> float:
        """Height of the indenter (Å)."""
        return float(self.atoms.positions[-1, 2])

    @cached_property
    def state(self) -> ContactState:
        """Forces, gaps and pressures, calculated from the positions."""
        return self.atoms.calc.state(self.atoms)

    @property
    def halfspace(self) -> HalfSpace:
        """The elastic half space, with the shapes of window and FFT grid."""
        return self.atoms.calc.contact(self.atoms).halfspace


@dataclass(frozen=True)
class Column:
    """An output column.

    Attributes
    ----------
    value : callable
        Called with a `RelaxedStep`; returns a number, a bool or a string.
    description : str
        Half a sentence for tables and reference pages.
    unit : str
        ASE's unit; empty for a number without unit.
    label : str
        Short name for the axes of figures, without the unit.
    """

    value: Callable[[RelaxedStep], Any]
    description: str
    unit: str = ""
    label: str = ""


def column(
    value: Callable[[RelaxedStep], Any],
    description: str,
    unit: str = "",
    label: str = "",
) -> Any:
    """Return a dataclass field that is an output column; see `Column`.

    Returns
    -------
    dataclasses.Field
    """
    return field(metadata={"column": Column(value, description, unit, label)})


def text_of(shape: tuple[int, ...]) -> str:
    """Return a shape as written in the columns: ``"128x96"``."""
    return "x".join(map(str, shape))


def _gap_error(step: RelaxedStep) -> float:
    if not step.atoms.calc.contact(step.atoms).interaction.hard:
        return 0.0
    contact, gap = step.state.contact, step.state.gap
    closed = abs(gap[contact]).max(initial=0.0)
    return float(max(closed, -gap[~contact].min(initial=0.0)))


def _memory(step: RelaxedStep) -> float:
    halfspace = step.halfspace
    return memory_of(
        halfspace.shape,
        margin=halfspace.dof_shape != halfspace.shape,
        points=points_of(step.atoms.calc.parameters["indenter"], halfspace.spacing),
    )


Step = TypeVar("Step", bound="LoadStep")


@dataclass(frozen=True)
class LoadStep:
    """Result of one load step; its attributes are the output columns."""

    step: int = column(lambda step: step.number, "number of the step, from zero")
    height: float = column(
        lambda step: step.height, "height of the indenter", "Å", "height"
    )
    penetration: float = column(
        lambda step: step.first_contact - step.height,
        "distance that the indenter has moved down from the height at which it begins "
        "to repel the flat substrate",
        "Å",
        "penetration",
    )
    normal_force: float = column(
        lambda step: step.state.normal_force,
        "force of the wall on the indenter, positive in compression; 1 nN is "
        "0.624 eV/Å",
        "eV/Å",
        "normal force",
    )
    contact_area: float = column(
        lambda step: step.state.contact_area,
        "number of atoms under a repulsive force, times the area per atom",
        "Å^2",
        "contact area",
    )
    repulsive_atoms: int = column(
        lambda step: step.state.repulsive_atoms,
        "number of atoms that the wall repels",
        label="repelled atoms",
    )
    attractive_atoms: int = column(
        lambda step: step.state.attractive_atoms,
        "number of atoms that the wall attracts",
        label="attracted atoms",
    )
    energy: float = column(
        lambda step: float(step.atoms.get_potential_energy()),
        "energy of the solid, the wall and the load",
        "eV",
        "energy",
    )
    max_force: float = column(
        lambda step: float(np.linalg.norm(step.atoms.get_forces(), axis=1).max()),
        "largest remaining force on any atom",
        "eV/Å",
        "largest force",
    )
    gap_error: float = column(
        _gap_error,
        "hard wall: largest gap of an atom in contact, or overlap of one outside; "
        "zero for soft walls",
        "Å",
        "error of the gap",
    )
    converged: bool = column(
        lambda step: step.statistics.converged,
        "whether the optimizer reached its tolerance",
    )
    message: str = column(
        lambda step: step.statistics.message, "reason why it did not, else empty"
    )
    tolerance: float = column(
        lambda step: step.statistics.tolerance,
        "tolerance of the force on every atom",
        "eV/Å",
        "tolerance",
    )
    iterations: int = column(
        lambda step: step.statistics.iterations,
        "steps of the optimizer",
        label="iterations",
    )
    pairs: float = column(
        lambda step: step.statistics.pairs,
        "forward/inverse FFT pairs, normalised to one full-grid pair",
        label="FFT pairs",
    )
    window: str = column(
        lambda step: text_of(step.halfspace.shape),
        "shape of the window of atoms that may touch",
    )
    grid: str = column(
        lambda step: text_of(step.halfspace.grid), "shape of the FFT grid"
    )
    precision: str = column(
        lambda step: np.dtype(step.halfspace.fft.get("dtype", float)).name,
        "floating-point type of the FFTs",
    )
    memory: float = column(
        _memory,
        "estimated peak memory of the step, between 3/4 and 4/3 of the actual one",
        "bytes",
        "memory",
    )
    seconds: float = column(
        lambda step: step.seconds, "wall-clock time of the step", "s", "time"
    )

    @classmethod
    def of(cls: type[Step], relaxed: RelaxedStep) -> Step:
        """Calculate the columns of relaxed atoms.

        Parameters
        ----------
        relaxed : RelaxedStep

        Returns
        -------
        LoadStep
            Of the class that it is called on. Forces, energy and gaps are calculated
            from the positions, not taken from the optimizer.
        """
        return cls(
            **{name: each.value(relaxed) for name, each in columns_of(cls).items()}
        )


def columns_of(record: type[LoadStep] = LoadStep) -> dict[str, Column]:
    """Return the columns of a class of results by name, in the order of output.

    Parameters
    ----------
    record : type
        `LoadStep` or a subclass with more columns.

    Returns
    -------
    dict of Column
    """
    return {each.name: each.metadata["column"] for each in fields(record)}


def units_of(record: type[LoadStep] = LoadStep) -> dict[str, str]:
    """Return the units of the columns that have one, by name; see `columns_of`."""
    return {name: each.unit for name, each in columns_of(record).items() if each.unit}


def _entry(name: str, kind: str, column: Column) -> str:
    unit = f" ({column.unit})" if column.unit else ""
    return f"    {name} : {kind}\n        {column.description}{unit}."


LoadStep.__doc__ = "\n".join(
    [
        f"{LoadStep.__doc__}\n\n    Attributes\n    ----------",
        *(
            _entry(each.name, str(each.type), each.metadata["column"])
            for each in fields(LoadStep)
        ),
    ]
)
