"""Result of a load step: its attributes are output columns.

A column is one entry of `LoadStep`, see `results.column`. The CSV file, the trajectory,
JSON lines and tables of columns follow from it. A subclass adds columns: ::

    from dataclasses import dataclass
    from ase_roughcontact import LoadStep, Output, column, load_path

    @dataclass(frozen=True)
    class MyStep(LoadStep):
        largest_gap: float = column(
            lambda s: float(s.fields.gap.max()), "largest gap in the window", "Å"
        )

    load_path(atoms, depths, output=Output(record=MyStep, csv="curve.csv"))

A column that needs a solution of its own is calculated on request only, see
`column_on_request` and `LoadStep.with_columns`.
"""

from __future__ import annotations

import copyreg
import math
from collections.abc import Mapping, Sequence, Set
from dataclasses import Field, dataclass, field, fields, make_dataclass
from functools import lru_cache
from typing import Any, ClassVar, TypeVar, get_type_hints

from ase_roughcontact._util.summary import Summarized, short_text
from ase_roughcontact._util.validation import lookup
from ase_roughcontact.results.column import (
    EVERYWHERE,
    Column,
    ColumnOnRequest,
    Range,
    column,
    column_on_request,
)
from ase_roughcontact.results.errors import errors_of
from ase_roughcontact.results.grid_errors import continuum_area_error
from ase_roughcontact.results.limits import violations
from ase_roughcontact.results.stresses import (
    WITH_PLACE,
    WITH_STRESS,
    place_column,
    value_column,
)
from ase_roughcontact.solvers.conductance import region_conductance
from ase_roughcontact.solvers.relaxation import SolverRelaxer
from ase_roughcontact.stepping.relaxed import RelaxedStep
from ase_roughcontact.theory.counted_area import continuum_area
from ase_roughcontact.windows.memory import memory_of

#: States in which an atom is in contact.
IN_CONTACT = Range("steps in contact", lambda s: s.touches)
_HARD = Range("hard walls", lambda s: s.contact.wall.hard, constant=True)
_WITH_HARDNESS = Range(
    "walls with a hardness", lambda s: s.contact.wall.plastic, constant=True
)
_STABLE = Range(
    "states that are a minimum of the energy, if no constraint holds atoms of the "
    "surface",
    lambda s: not (s.run.constrained or math.isnan(s.response.force)),
)
# A step has its own reason why its errors are NaN.
_WITH_ERRORS = Range(
    "states that are a minimum of the energy, see `unknown_errors`",
    lambda s: True,
)
_WITH_SOLVER = Range(
    "the solvers NewtonKrylov and ActiveSet",
    lambda s: s.options.relaxer is None or isinstance(s.options.relaxer, SolverRelaxer),
    constant=True,
)


def text_of(shape: tuple[int, ...]) -> str:
    """Return a shape as written in the columns: ``"128x96"``."""
    return "x".join(map(str, shape))


def shape_of(text: str) -> tuple[int, int]:
    """Return a shape as written in the columns."""
    n, m = map(int, text.split("x"))
    return n, m


def size_of(text: str) -> int:
    """Return the number of points of a shape as written in the columns."""
    return math.prod(shape_of(text))


def _continuum_area(step: RelaxedStep) -> float:
    area = step.fields.contact_area
    if step.edge_area is not None:
        area = step.edge_area.area
    elif step.contact.wall.hard:
        area = continuum_area(area, step.perimeter, step.halfspace.spacing)
    # with plastic contact to the edge there is nothing to correct, and A >= N/H
    return max(area, step.fields.normal_force / step.fields.hardness)


def _continuum_area_error(step: RelaxedStep) -> float:
    if step.grid_model.is_continuum:
        return errors_of(step).area
    return errors_of(step).area + continuum_area_error(step)


def _mean_pressure(step: RelaxedStep) -> float:
    if step.grid_model.is_continuum and (area := _continuum_area(step)):
        return step.mean_pressure * step.fields.contact_area / area
    return step.mean_pressure


def _memory(step: RelaxedStep) -> float:
    problem = step.problem
    points = problem.topography.points(problem.spacing)
    shape, periodic = step.halfspace.shape, problem.periodic
    return memory_of(
        shape, problem.wall, problem.solid, points=points, periodic=periodic
    )


Step = TypeVar("Step", bound="LoadStep")

#: Value in place of a missing one, by type.
MISSING: dict[type, Any] = {str: "", float: math.nan, int: -1, bool: False}


@dataclass(frozen=True)
class LoadStep(Summarized):
    """Result of one load step; its attributes are the output columns.

    `load_path` and the other paths make them. Forces are in eV/Å, areas in Å^2; the
    guide lists all columns, `columns_of` their descriptions and units.

    Examples
    --------
    >>> from ase_roughcontact import RoughContact, RoughSphere, load_path, substrate
    >>> sphere = RoughSphere(radius=200.0)
    >>> atoms = substrate('Cu', (8, 8), sphere, fixed=False)
    >>> atoms.calc = RoughContact(sphere, contact_modulus=0.9)
    >>> (step,) = load_path(atoms, loads=[10.0], window='auto')
    >>> step.repulsive_atoms, step.window, step.converged
    (89, '14x14', True)
    >>> print(f'{step.continuum_area:.0f} ± {step.continuum_area_error:.0f} Å^2')
    580 ± 12 Å^2
    """

    #: Names of the columns on request that paths have by default.
    default_columns: ClassVar[tuple[str, ...]] = ()
    #: Names of the columns that a file did not have; see `from_columns`.
    _missing: ClassVar[Set[str]] = frozenset()

    step: int = column(lambda s: s.number, "number of the step, from zero")
    height: float = column(lambda s: s.height, "height of the indenter", "Å", "height")
    penetration: float = column(
        lambda s: s.first_contact - s.height,
        "distance that the indenter has moved down since it first repels the flat "
        "substrate",
        "Å",
        "depth",
    )
    normal_force: float = column(
        lambda s: s.fields.normal_force,
        "force of the wall on the indenter, positive in compression; 1 nN is 0.624 "
        "eV/Å",
        "eV/Å",
        "load",
    )
    contact_area: float = column(
        lambda s: s.fields.contact_area,
        "number of repelled atoms times the area per atom",
        "Å^2",
        "area",
    )
    continuum_area: float = column(
        _continuum_area,
        "area of the continuum: the count under soft walls; under hard walls by the "
        "fields at the edge if the continuum is asked for, otherwise the count less a "
        "part of the perimeter; at least load over hardness",
        "Å^2",
        "area",
    )
    area_column: str = column(
        lambda s: s.grid_model.area_column,
        "which of the two areas is asked for, and has the `area_error`",
    )
    area_error: float = column(
        lambda s: errors_of(s).area,
        "estimated error of the area that `area_column` names; the true error is below "
        "twice the estimate in nine of ten cases",
        "Å^2",
        where=_WITH_ERRORS,
    )
    continuum_area_error: float = column(
        _continuum_area_error,
        "estimated error of `continuum_area`; the `area_error` if that is asked for",
        "Å^2",
        where=_WITH_ERRORS,
    )
    force_error: float = column(
        lambda s: errors_of(s).force,
        "estimated error of the force; under a load the residual of the balance",
        "eV/Å",
        where=_WITH_ERRORS,
    )
    height_error: float = column(
        lambda s: errors_of(s).height,
        "estimated error of the height; zero at a given height or penetration",
        "Å",
        where=_WITH_ERRORS,
    )
    penetration_error: float = column(
        lambda s: errors_of(s).penetration,
        "estimated error of the penetration: of the height, and for the continuum of "
        "the lowest point of the indenter; zero at a given penetration",
        "Å",
        where=_WITH_ERRORS,
    )
    unknown_errors: str = column(
        lambda s: errors_of(s).unknown, "why errors are not known (nan), else empty"
    )
    perimeter: float = column(
        lambda s: s.perimeter,
        "length of the boundary between repelled atoms and others, along the grid",
        "Å",
    )
    contact_stiffness: float = column(
        lambda s: 0.0 - s.response.force,
        "derivative of the force to the penetration of the relaxed contact, to within "
        "1 %: on loading under a wall with a hardness, of a viscoelastic solid the "
        "instantaneous one, under friction at fixed tractions",
        "eV/Å^2",
        where=_STABLE,
    )
    conductance = column_on_request(
        lambda s: region_conductance(s.halfspace, s.fields.contact),
        "electrical or thermal conductance of the contact region, times the sum of the "
        "resistivities of both bodies: 4 a for a circle of radius a; infinite in full "
        "contact of a periodic cell",
        "Å",
    )
    largest_von_mises = value_column(
        "von_mises",
        "largest von Mises stress below the surface, from a depth of one spacing on",
    )
    von_mises_depth = place_column("von_mises", "depth")
    von_mises_x = place_column("von_mises", "x")
    von_mises_y = place_column("von_mises", "y")
    largest_tresca = value_column(
        "tresca",
        "largest difference of two principal stresses below the surface, "
        "from a depth of one spacing on",
    )
    tresca_depth = place_column("tresca", "depth")
    tresca_x = place_column("tresca", "x")
    tresca_y = place_column("tresca", "y")
    largest_tension = value_column(
        "tension",
        "largest principal stress below the surface, positive in tension, "
        "from a depth of one spacing on",
    )
    tension_depth = place_column("tension", "depth")
    tension_x = place_column("tension", "x")
    tension_y = place_column("tension", "y")
    mean_pressure: float = column(
        _mean_pressure,
        "mean pressure on the repelled atoms; if the continuum is asked for, their "
        "force over `continuum_area`",
        "eV/Å^3",
        where=IN_CONTACT,
    )
    largest_pressure: float = column(
        lambda s: float(max(s.fields.pressure.max(), 0.0)),
        "largest pressure, zero where nothing is pressed",
        "eV/Å^3",
    )
    repulsive_atoms: int = column(
        lambda s: s.fields.repulsive_atoms, "number of atoms that the wall repels"
    )
    attractive_atoms: int = column(
        lambda s: s.fields.attractive_atoms, "number of atoms that the wall attracts"
    )
    plastic_atoms: float = column(
        lambda s: s.fields.plastic_atoms,
        "number of atoms in plastic contact, at the hardness of the wall",
        where=_WITH_HARDNESS,
    )
    plastic_depth: float = column(
        lambda s: float(s.fields.plastic_depth.max()),
        "largest depth by which the surface has flowed",
        "Å",
        where=_WITH_HARDNESS,
    )
    energy: float = column(
        lambda s: s.run.energy,
        "energy of solid, wall and load, with the work of plastic flow",
        "eV",
    )
    max_force: float = column(
        lambda s: s.run.max_force,
        "largest remaining force on any atom",
        "eV/Å",
    )
    gap_error: float = column(
        lambda s: s.gap_error,
        "largest gap of an atom in contact, or overlap of one out of plastic contact",
        "Å",
        where=_HARD,
    )
    converged: bool = column(
        lambda s: s.run.converged,
        "whether the optimizer has converged, and forces and gaps confirm it",
    )
    message: str = column(
        lambda s: s.run.status.text("eV/Å", "Å"), "why it did not, else empty"
    )
    validity: str = column(
        violations, "limits of the model that the step exceeds, else empty"
    )
    tolerance: float = column(
        lambda s: s.run.tolerance, "tolerance of the force on any atom", "eV/Å"
    )
    iterations: int = column(lambda s: s.run.iterations, "steps of the optimizer")
    pairs: float = column(
        lambda s: s.run.pairs,
        "forward/inverse FFT pairs, normalised to one full-grid pair",
    )
    window: str = column(
        lambda s: text_of(s.halfspace.shape),
        'shape of the window of atoms, a text like "128x96"',
    )
    grid: str = column(lambda s: text_of(s.halfspace.grid), "shape of the FFT grid")
    precision: str = column(
        lambda s: s.halfspace.dtype.name,
        "floating-point type of the FFTs",
    )
    memory: float = column(
        _memory,
        "estimated peak memory, between 3/4 and 4/3 of the actual one if Python and "
        "its libraries need 165 MB",
        "bytes",
        where=_WITH_SOLVER,
    )
    seconds: float = column(
        lambda s: s.seconds, "wall-clock time of the step", "s", "time"
    )

    @classmethod
    def with_columns(
        cls: type[Step], columns: Sequence[str] | None = None
    ) -> type[Step]:
        """Return the class of results with columns that are on request.

        Parameters
        ----------
        columns : sequence of str, optional
            Names of any columns; by default `default_columns`.

        Returns
        -------
        type

        Raises
        ------
        ValueError
            If there is no such column.
        TypeError
            If the names are one string.

        Examples
        --------
        >>> from ase_roughcontact import LoadStep
        >>> from ase_roughcontact.results.record import columns_of
        >>> asked = LoadStep.with_columns(['conductance'])
        >>> 'conductance' in columns_of(asked), 'conductance' in columns_of(LoadStep)
        (True, False)
        """
        if isinstance(columns, str):
            raise TypeError(f"columns must be a list of names, got {columns!r}")
        original, added = vars(cls).get("_made_from", (cls, ()))
        known, on_request = columns_of(original), columns_on_request(original)
        for name in cls.default_columns if columns is None else columns:
            if name not in known:
                lookup(name, on_request, "column on request")
                added = tuple(dict.fromkeys([*added, name]))
        return _with_columns(original, added) if added else cls

    @classmethod
    def of(cls: type[Step], relaxed: RelaxedStep) -> Step:
        """Calculate the columns of relaxed atoms.

        Parameters
        ----------
        relaxed : RelaxedStep

        Returns
        -------
        LoadStep
            The result, of the class that the method is called on. Forces, energy and
            gaps are calculated from the positions, not taken from the optimizer.

        Raises
        ------
        AttributeError
            If the function of a column needs an attribute that a step does not have.
        """
        values = {}
        for name, each in columns_of(cls).items():
            try:
                values[name] = each.of(relaxed)
            except AttributeError as error:
                raise AttributeError(
                    f"column {name!r}: {error}. Its function is called with a "
                    "RelaxedStep, and fields and sums, such as contact_area, are in "
                    "step.fields"
                ) from error
        return cls(**values)

    def _summary(self) -> dict[str, str]:
        """Return the columns that are printed in tables, as far as they are known."""
        found = {"step": str(self.step)}
        for name, each in columns_of(type(self)).items():
            value = getattr(self, name)
            if each.label and value == value:
                found[name] = short_text(value, each.unit)
        found["converged"] = str(self.converged)
        texts = {"message": self.message, "validity": self.validity}
        return found | {name: text for name, text in texts.items() if text}

    @property
    def not_known(self) -> dict[str, str]:
        """Reasons why columns are NaN, by their names."""
        values = {name: getattr(self, name) for name in columns_of(type(self))}
        unknown = [name for name, value in values.items() if value != value]
        return {name: self._why_not_known(name) for name in unknown}

    def _why_not_known(self, name: str) -> str:
        column = columns_of(type(self))[name]
        if name in self._missing:
            return "the run that calculated the step had no such column"
        if column.where is _WITH_ERRORS and self.unknown_errors:
            return self.unknown_errors
        if column.where in (EVERYWHERE, _WITH_ERRORS):
            return "its function returned nan"
        return f"it is defined for {column.where.text}"

    @classmethod
    def from_columns(cls: type[Step], columns: Mapping[str, Any]) -> Step:
        """Return the result with the columns of a file of this or another version.

        Parameters
        ----------
        columns : mapping
            Values by column. Missing ones are NaN, -1, False or empty; columns that the
            class does not have are ignored.

        Returns
        -------
        LoadStep
            The result, of the class that the method is called on.

        Raises
        ------
        KeyError
            If the columns have no number of the step.
        """
        values = missing_values(cls)
        missing = values.keys() - columns.keys()
        for name in values.keys() & columns.keys():
            value = columns[name]
            # one object for NaN, so that equal results compare as equal
            values[name] = math.nan if value != value else value
        values["step"] = columns["step"]
        found = cls(**values)
        object.__setattr__(found, "_missing", missing)
        return found


def columns_of(record: type[LoadStep] = LoadStep) -> dict[str, Column]:
    """Return the columns of a class of results by name, in the order of output.

    Parameters
    ----------
    record : type
        `LoadStep` or a subclass with more columns.

    Returns
    -------
    dict of Column

    Raises
    ------
    TypeError
        If the class is not a dataclass of columns.
    """
    return dict(_columns(record))  # type: ignore[arg-type]


def missing_values(record: type[LoadStep] = LoadStep) -> dict[str, Any]:
    """Return the value in place of a missing one in each column; see `MISSING`."""
    types = get_type_hints(record)
    return {name: MISSING.get(types[name]) for name in columns_of(record)}


def columns_on_request(record: type[LoadStep] = LoadStep) -> dict[str, Column]:
    """Return the columns of a class of results that are calculated on request only."""
    attributes = {name: getattr(record, name, None) for name in dir(record)}
    return {
        name: attribute.column
        for name, attribute in attributes.items()
        if isinstance(attribute, ColumnOnRequest)
    }


#: Names of the columns of stresses below the surface.
STRESS_COLUMNS = frozenset(
    name
    for name, each in columns_on_request().items()
    if each.where in (WITH_STRESS, WITH_PLACE)
)


@lru_cache
def _with_columns(record: Any, added: tuple[str, ...]) -> Any:
    """Return a class of results with columns on request."""
    on_request = columns_on_request(record)
    made = make_dataclass(
        record.__name__,
        [(name, float, field(metadata={"column": on_request[name]})) for name in added],
        bases=(record,),
        frozen=True,
        namespace={
            "__module__": record.__module__,
            "__doc__": record.__doc__,
            "_made_from": (record, added),
        },
    )
    copyreg.pickle(made, _reduced)
    return made


def _reduced(step: Any) -> tuple:
    """Return function, arguments and state that make a result again."""
    return _empty, step._made_from, vars(step)


def _empty(record: type, added: tuple[str, ...]) -> Any:
    """Return a result without values."""
    return object.__new__(_with_columns(record, added))


@lru_cache
def _columns(record: Any) -> dict[str, Column]:
    for parent in record.__mro__:
        if any(isinstance(value, Field) for value in vars(parent).values()):
            raise TypeError(
                f"{parent.__name__} has new columns, but is not a dataclass: decorate "
                "it with @dataclass(frozen=True)"
            )
    others = [each.name for each in fields(record) if "column" not in each.metadata]
    if others:
        raise TypeError(
            f"every field of {record.__name__} must be a column(function, description),"
            f" got {', '.join(others)}"
        )
    return {each.name: each.metadata["column"] for each in fields(record)}


def units_of(record: type[LoadStep] = LoadStep) -> dict[str, str]:
    """Return the units of the columns that have one, by name; see `columns_of`."""
    return {name: each.unit for name, each in columns_of(record).items() if each.unit}


def _attributes(record: type[LoadStep]) -> str:
    """Return the section on attributes of a class of results, for its docstring."""
    lines = ["", "", "    Attributes", "    ----------"]
    types = {each.name: each.type for each in fields(record)}
    for name, entry in (columns_of(record) | columns_on_request(record)).items():
        unit = f" ({entry.unit})" if entry.unit else ""
        kind = types.get(name, "float, on request")
        lines += [f"    {name} : {kind}", f"        {entry.description}{unit}"]
    return "\n".join(lines)


LoadStep.__doc__ = f"{LoadStep.__doc__}{_attributes(LoadStep)}"
