"""Kinds of path: the section [path] of a scene, its steps, results and figures."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, TypeVar

import numpy as np

from ase_roughcontact._util.files import write_table
from ase_roughcontact._util.registry import Registry
from ase_roughcontact._util.summary import short_text
from ase_roughcontact._util.units import (
    FORCES,
    PRESSURES,
    QUANTITY,
    UNITS,
    per_time,
    printed_unit,
    with_unit,
)
from ase_roughcontact._util.validation import (
    FloatArray,
    finite,
    finite_array,
    integer,
    lookup,
    positive,
)
from ase_roughcontact.contact.control import HEIGHT, LOAD, PENETRATION, Control
from ase_roughcontact.paths.path_steps import NumberedSteps, PathSteps, targets_of
from ase_roughcontact.paths.schedule import Schedule
from ase_roughcontact.results.record import LoadStep
from ase_roughcontact.scene.bodies import Bodies
from ase_roughcontact.scene.path_result import PathResult, results_of
from ase_roughcontact.scene.section import Problems, Section, kind_of, lengths
from ase_roughcontact.scene.study import RANGE_KEYS, SCALE_HINTS, SCALES
from ase_roughcontact.stepping.step import Stepper

#: Largest number of steps of a path; all steps are kept in memory.
MAX_STEPS = 1_000_000
#: What to give for other names of a control.
CONTROL_HINTS = {
    **dict.fromkeys(("force", "normal_force", "pressure"), "loads"),
    **dict.fromkeys(("displacement", "depth", "indentation"), "penetrations"),
    **dict.fromkeys(("gap", "position", "distance", "z"), "heights"),
}
# Columns of force curves, and their units.
_CURVE_UNITS = {"time": "s", "distance": "nm", "deflection": "nm", "force": "nN"}

AnyPath = TypeVar("AnyPath", bound="PathKind")

#: Kinds of path by their `kind`; filled by the definition of a subclass of `PathKind`.
PATHS: Registry[type[PathKind]] = Registry("kind of path")


@dataclass(frozen=True)
class PathKind(Section):
    """Base class of the kinds of path.

    A subclass with a `kind` can be used in scene files: its fields are the keys of
    ``[path]``. It defines `control` and `targets`, from which plan, preview, table and
    pictures follow; a path that chooses its targets as it runs defines `planned` and
    `steps_of` instead, and whatever it has beyond a sequence of states.

    Attributes
    ----------
    kind : str
        Name in scene files.
    record : type
        Class of the results.
    columns : mapping of str to str
        Columns of the printed table, with their labels; by default load, depth, area,
        the area relative to theory, the largest pressure, and the time.
    captions : mapping of str to str
        Names of the pictures that `draw` makes, with their captions.
    results : mapping of str to PathResult
        Numbers that follow from all steps, by name: columns of an ensemble. Their
        names differ from the columns of the record.
    main_result : str
        Name of the result that ensembles average by default; empty for the contact
        area.
    in_order : bool
        Whether states depend on earlier states: a preview has all of them, and area
        over load and force over depth are not drawn.
    in_time : bool
        Whether its states have a time, which a viscoelastic solid needs.
    has_friction : bool
        Whether the indenter moves sideways, against the section [friction].
    is_loop : bool
        Whether the path ends when no force acts on the indenter, and its main result is
        the pull-off force.
    controls : tuple of Control
        Quantities that `control` may name.
    """

    title = "path"
    hints = {f"{name}s": key for name, key in CONTROL_HINTS.items()} | CONTROL_HINTS
    kind: ClassVar[str] = "steps"
    record: ClassVar[type[LoadStep]] = LoadStep
    columns: ClassVar[Mapping[str, str]] = {}
    captions: ClassVar[Mapping[str, str]] = {}
    results: ClassVar[Mapping[str, PathResult]] = {}
    main_result: ClassVar[str] = ""
    in_order: ClassVar[bool] = False
    in_time: ClassVar[bool] = False
    has_friction: ClassVar[bool] = False
    is_loop: ClassVar[bool] = False
    controls: ClassVar[tuple[Control, ...]] = (LOAD, PENETRATION, HEIGHT)

    def __init_subclass__(cls) -> None:
        """Make the kind known to scene files."""
        super().__init_subclass__()
        if kind := vars(cls).get("kind"):
            PATHS.add(kind, cls)

    @classmethod
    def of(cls, entries: Mapping[str, Any]) -> Any:
        """Return the path with the given entries; see `Section.of`.

        Keys of other kinds are ignored at their defaults, which older files contain.
        """
        for each in PATHS.values():
            entries = each.own_entries(entries)
        kind = kind_of(cls.title, entries, PathKind.kind, PATHS)
        problems, types = Problems(), kind.types()
        given: dict[str, Any] = {}
        foreign: dict[str, list[str]] = {}
        for key, value in kind.renamed(entries).items():
            owners = [each for each in PATHS.values() if key in each.names()]
            if key in types or not owners:
                given[key] = value
            elif all(value != getattr(each, key, None) for each in owners):
                foreign[key] = [each.kind for each in owners]
        given.pop("kind", None)
        if foreign:
            keys = ", ".join(foreign)
            other = next(iter(foreign.values()))[0]
            for name in PATHS:
                if all(name in owners for owners in foreign.values()):
                    other = name  # has all these keys
                    break
            with problems.of(cls.title):
                raise ValueError(
                    f'{keys} need kind = "{other}", got "{kind.kind}": omit {keys}, or '
                    f'give kind = "{other}"'
                )
        with problems.of(cls.title):
            path = super(PathKind, kind).of(given)
        problems.check()
        return path

    @classmethod
    def names(cls) -> set[str]:
        """Return the names of keys that files may have."""
        return {*cls.types(), *cls.aliases}

    @classmethod
    def own_entries(cls, entries: Mapping[str, Any]) -> Mapping[str, Any]:
        """Return the entries of a section, in the keys of this kind if it is meant.

        A kind with a second name overrides this method.
        """
        return entries

    @property
    def given(self) -> dict[str, Any]:
        """Values that are not the default; see `Section.given`."""
        kind = {} if self.kind == PathKind.kind else {"kind": self.kind}
        return kind | super().given

    def entries(self) -> dict[str, Any]:
        """Return the values by key; see `Section.entries`."""
        return {"kind": self.kind, **super().entries()}

    def changed(self, name: str, value: Any) -> Any:
        """Return the path with another value; another kind has only its own keys."""
        kind = PATHS.get(str(value), PathKind) if name == "kind" else type(self)
        kept = {k: v for k, v in self.entries().items() if k in kind.types()}
        if name == "kind":  # other keys get defaults of the new kind
            kept = {k: v for k, v in kept.items() if v is not None}
        key = self.aliases.get(name, name)
        return self.of({**kept, "kind": self.kind, key: value})

    @property
    def control(self) -> str:
        """Name of the controlled quantity."""
        raise NotImplementedError

    @property
    def controlled(self) -> Control:
        """Quantity that the path prescribes."""
        controls = {each.name: each for each in self.controls}
        return lookup(self.control, controls, "control")

    @property
    def unit(self) -> str:
        """Unit of the targets, one of `UNITS`."""
        return self.controlled.unit

    def units_of_targets(self, bodies: Bodies) -> Mapping[str, float]:
        """Return the units in which targets may be given, with their values."""
        if self.unit not in FORCES:
            return lengths(bodies.spacing)
        if not bodies.is_flat:
            return FORCES
        loads = {name: bodies.nominal_area * unit for name, unit in PRESSURES.items()}
        return {**FORCES, **loads}

    def in_unit(self: AnyPath, keys: Iterable[str], bodies: Bodies) -> AnyPath:
        """Return the path with targets that are numbers in `unit`.

        Raises
        ------
        ValueError
            See `Section.plain`; with the control that targets in other units need.
        """
        try:
            return self.plain(keys, self.units_of_targets(bodies), self.unit)
        except ValueError as error:
            control, values = LOAD, "forces"
            if self.unit in FORCES:
                control, values = PENETRATION, "lengths"
            other = self.changed("control", control.name)
            plurals = [each.plural for each in self.controls]
            others = [control.plural if key in plurals else key for key in keys]
            with suppress(ValueError):
                other.plain(others, other.units_of_targets(bodies), other.unit)
                error.args = (f"{error}; {values} are given as {control.plural}",)
            raise

    @property
    def along(self) -> str:
        """Column against which the force is drawn."""
        return "height" if self.controlled == HEIGHT else "penetration"

    @property
    def stiffness(self) -> float | None:
        """Stiffness of a cantilever on which the tip is (eV/Å^2); None without one."""
        return None

    def check(self, bodies: Bodies) -> None:
        """Raise an error if the solid or the wall needs another kind of path."""
        if bodies.solid.creep is not None and not self.in_time:
            raise ValueError(
                'the solid of relaxation_moduli is viscoelastic: give kind = "time"'
                ", or rate in a loop"
            )

    def targets(self, bodies: Bodies) -> FloatArray:
        """Return loads (eV/Å), penetrations or heights (Å) of the steps.

        Raises
        ------
        ValueError
            If a key is missing or invalid, or the path chooses them as it runs.
        """
        raise ValueError(
            f'kind = "{self.kind}" chooses its steps as it runs: run it, or give kind '
            '= "steps"'
        )

    def count(self, bodies: Bodies) -> int | None:
        """Return the number of states; None if the path chooses them as it runs."""
        has_targets = type(self).targets is not PathKind.targets
        return len(self.targets(bodies)) if has_targets else None

    def schedule(self, bodies: Bodies) -> Schedule | None:
        """Return the targets as a function of time (s); None without times."""
        return None

    def target_of(self, bodies: Bodies, state: Any) -> float:
        """Return the target of a state."""
        schedule = self.schedule(bodies)
        if schedule is not None:
            return schedule.at(state.time)
        if self.count(bodies) is None:  # chosen as the path runs
            return float(getattr(state, self.controlled.column))
        return float(self.targets(bodies)[state.step])

    def deepest_of(self, targets: Iterable[float]) -> float:
        """Return the target at which the contact is pressed most."""
        deeper = self.controlled.deeper
        return max(targets, key=lambda target: deeper * target)

    def planned(self, bodies: Bodies) -> PathKind:
        """Return the path of known targets that is planned and previewed.

        Raises
        ------
        ValueError
            If a key is missing or invalid.
        """
        self.targets(bodies)
        return self

    def certain(self, bodies: Bodies) -> PathKind:
        """Return the path of those known targets that are certainly reached."""
        return self.planned(bodies)

    def expected_count(self, bodies: Bodies) -> int:
        """Return the number of states for which each planned step stands."""
        return 1

    def expected_counts(self, bodies: Bodies) -> list[float]:
        """Return the numbers of time steps to expect in the parts of the schedule."""
        return []

    def describe(self, bodies: Bodies) -> str:
        """Return a description of the path, printed above its plan."""
        return ""

    def steps_of(self, bodies: Bodies, stepper: Stepper) -> PathSteps:
        """Return the driver that relaxes the states, one after the other."""
        targets = targets_of(stepper.control, self.targets(bodies))
        return NumberedSteps(stepper, targets)

    @property
    def springs(self) -> dict[str, Any]:
        """Springs of the path as they are written beside its results."""
        return {"springs": []}

    def branch_names(self, bodies: Bodies, states: Sequence[LoadStep]) -> list[str]:
        """Return the name of the branch of each state, "approach" for instance."""
        depths = np.array([state.penetration for state in states])
        approaches = np.diff(depths, prepend=-np.inf) > 0.0
        if self.in_order or approaches.all():
            return [""] * len(states)
        return np.where(approaches, "approach", "retraction").tolist()

    def extremes(
        self, bodies: Bodies, states: Sequence[LoadStep]
    ) -> tuple[LoadStep, float]:
        """Return the last state of the loading, and the largest tension (eV/Å)."""
        return states[-1], max(0.0, -min(state.normal_force for state in states))

    def result(self, bodies: Bodies, states: Sequence[LoadStep]) -> Any:
        """Return an object from which `results` follow; by default the states."""
        return states

    def summary(self, bodies: Bodies, states: Sequence[LoadStep]) -> Mapping[str, str]:
        """Return characteristic values by their names; by default the results."""
        found = {}
        for name, value in results_of(self, bodies, states).items():
            result = self.results[name]
            label = result.label or name.replace("_", " ")
            unknown = f"not known: defined for {result.where}"
            text = with_unit(value, printed_unit(result.unit)).strip()
            found[label] = unknown if math.isnan(value) else text
        return found

    def warnings(self, bodies: Bodies, states: Sequence[LoadStep]) -> tuple[str, ...]:
        """Return warnings about the characteristic values; none by default."""
        return ()

    def draw(
        self,
        bodies: Bodies,
        states: Sequence[LoadStep],
        folder: Path,
        ending: str = "png",
    ) -> Iterator[str]:
        """Draw the pictures in `captions` into a folder, and yield their names.

        Parameters
        ----------
        bodies : Bodies
        states : sequence of LoadStep
            All steps of the path.
        folder : path
        ending : str
            Ending of the names, which is the format.

        Raises
        ------
        ValueError
            If one of them has no data.
        """
        return iter(())


class TargetPath(PathKind):
    """Base class of kinds with a key for the targets of each of their `controls`.

    A subclass has the fields ``loads``, ``penetrations``, ``heights``, the plurals of
    its controls. Files may also name the quantity by ``control`` and the targets by
    ``values``.
    """

    @classmethod
    def names(cls) -> set[str]:
        """Return the names of keys that files may have."""
        return super().names() | {"control", "values"}

    @classmethod
    def renamed(cls, entries: Mapping[str, Any]) -> dict[str, Any]:
        """Return the entries with the targets by the name of their control."""
        found = super().renamed(entries)
        plurals = [each.plural for each in cls.controls]
        given = [key for key in plurals if found.get(key) is not None]
        target = given[0] if given else LOAD.plural
        control = found.pop("control", None)
        if control is not None:
            problems = Problems()
            with problems.of(cls.title):
                target = cls._target_key_of(control)
                if given and given != [target]:
                    raise ValueError(f"give {given[0]} without control = {control!r}")
            problems.check()
            found[target] = found.get(target) or []
        if "values" in found:
            found[target] = found.pop("values")
        return found

    @classmethod
    def _target_key_of(cls, control: Any) -> str:
        """Return the key of the targets of a control, given by its name."""
        keys = {each.name: each.plural for each in cls.controls}
        return str(lookup(str(control), keys, "control", CONTROL_HINTS))

    def changed(self, name: str, value: Any) -> Any:
        """Return the path with another value; targets of another control replace it.

        Another control keeps the numbers of the targets.
        """
        if name == "control":
            name, value = self._target_key_of(value), self.values or []
        plurals = [each.plural for each in self.controls]
        if name in plurals and value is not None and name != self.target_key:
            kept = {k: v for k, v in self.entries().items() if k not in plurals}
            return self.of({**kept, name: value})
        return super().changed(name, value)

    @property
    def control(self) -> str:
        """Name of the quantity with given targets; by default the load."""
        given = [k for k in self.controls if getattr(self, k.plural) is not None]
        if len(given) > 1:
            names = " or ".join(each.plural for each in given)
            raise ValueError(f"give {names}, not both")
        return given[0].name if given else LOAD.name

    @property
    def target_key(self) -> str:
        """Key of the targets."""
        return self.controlled.plural

    @property
    def values(self) -> Any:
        """Targets as they are given; None without any."""
        return getattr(self, self.target_key)


# Range of targets with its keys in the section itself.
_OLD_RANGE = {"scale": "geometric"}


@dataclass(frozen=True)
class Steps(TargetPath):
    """``[path]``: given loads in nN, penetrations or heights in Å, or with a unit.

    Targets are a list, or a range ``{first, last, steps, scale}``, by default linear.
    Loads of a rough flat may also be nominal pressures, such as ``"10 MPa"``. Files may
    have the keys of a range in the section itself; it is geometric then by default.
    """

    kind = "steps"

    loads: tuple | dict | None = None
    penetrations: tuple | dict | None = None
    heights: tuple | dict | None = None

    @classmethod
    def names(cls) -> set[str]:
        """Return the names of keys that files may have."""
        return super().names() | {*RANGE_KEYS}

    @classmethod
    def renamed(cls, entries: Mapping[str, Any]) -> dict[str, Any]:
        """Return the entries with the targets as a list or a range."""
        others = {key: each for key, each in entries.items() if key not in RANGE_KEYS}
        ends = {key: entries[key] for key in entries.keys() - others.keys()}
        found = super().renamed(others)
        keys = (each.plural for each in cls.controls)
        key = next((k for k in keys if found.get(k) is not None), LOAD.plural)
        old = found.get(key)
        if isinstance(old, Mapping):
            found[key] = {**old, **ends}
        elif any(ends.get(name) is not None for name in RANGE_KEYS[:3]):
            found[key] = {**_OLD_RANGE, **ends}
        return found

    def _summary(self) -> dict[str, str]:
        """Return the values that are not the default, a range with its keys."""
        found, values = super()._summary(), self.values
        if isinstance(values, Mapping):
            texts = [f"{key} = {short_text(each)}" for key, each in values.items()]
            found[self.target_key] = f"{{{', '.join(texts)}}}"
        return found

    @classmethod
    def at(cls, control: Control, values: Iterable[float]) -> Steps:
        """Return the path of the targets of a control, in its unit."""
        given: dict[str, Any] = {control.plural: tuple(values)}
        return cls(**given)

    def targets(self, bodies: Bodies) -> FloatArray:
        """Return the targets of the steps; see `PathKind.targets`."""
        key = self.target_key
        values = getattr(self.in_unit([key], bodies), key)
        if isinstance(values, Mapping):
            return UNITS[self.unit] * _interval(key, **_checked_range(key, values))
        targets = finite_array(key, list(values or ()))
        if not targets.size:
            raise ValueError(
                f"give loads, penetrations or heights, such as {key} = [1, 2], or "
                f"{key} = {{ first = 1, last = 2, steps = 2 }}"
            )
        return UNITS[self.unit] * targets


def _checked_range(key: str, given: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the keys of a range; raise an error for unknown and missing ones."""
    for name in given:
        lookup(name, dict.fromkeys(RANGE_KEYS), f"key of the range of {key}")
    missing = [name for name in RANGE_KEYS[:3] if given.get(name) is None]
    if missing:
        raise ValueError(f"give {', '.join(missing)} for the range of {key}, or a list")
    return given


def _interval(
    key: str, first: Any, last: Any, steps: Any, scale: Any = "linear"
) -> FloatArray:
    """Return evenly spaced targets from the first to the last one."""
    integer("steps", steps, 1)
    if steps > MAX_STEPS:
        raise ValueError(f"steps must be at most {MAX_STEPS}, got {steps}")
    finite(first=first, last=last)
    spaced = lookup(str(scale), SCALES, "scale", SCALE_HINTS)
    if scale == "geometric" and not (first and last and first * last > 0):
        raise ValueError(
            f"a geometric range of {key} needs first and last of one sign and not "
            f"zero, got {first} and {last}"
        )
    return np.asarray(spaced(float(first), float(last), steps))


def write_curve(
    file: Path, branches: Sequence[str], columns: Mapping[str, Iterable[float]]
) -> None:
    """Write the force curve of a cantilever as CSV, with the branch of each point.

    Parameters
    ----------
    file : path
        Table to write.
    branches : sequence of str, length n
        Name of the branch of each point.
    columns : mapping of str to iterable of float, length n
        Some of time (s), distance, deflection (Å), and force (eV/Å).
    """
    units = {name: _CURVE_UNITS[name] for name in columns}
    heads = ("branch", *(f"{name} ({unit})" for name, unit in units.items()))
    texts = []
    for name, values in columns.items():
        unit = UNITS[units[name]]
        texts.append([f"{value / unit:.8g}" for value in values])
    write_table(file, heads, zip(branches, *texts, strict=True))


def turn_text(turn: LoadStep) -> str:
    """Return force and depth at which a retraction begins, as they are printed."""
    force, depth = turn.normal_force, turn.penetration
    return f"at {with_unit(force, 'nN')} and a depth of {with_unit(depth, 'nm')}"


def stiffness_of(key: str, stiffness: float | None) -> float | None:
    """Return in eV/Å^2 a stiffness that a key gives in N/m; None if not given."""
    if stiffness is None:
        return None
    positive(**{key: stiffness})
    return stiffness * UNITS["N/m"]


def rates_of(
    path: Any, changes: int, units: Mapping[str, float], unit: str
) -> list[float]:
    """Return the rate of each change from a target to the next one, in ASE's units.

    Parameters
    ----------
    path : PathKind
        Path with the key ``rate``: one rate, or one for each change.
    changes : int
        Number of changes.
    units : mapping of str to float
        Units in which the targets may be given.
    unit : {"nm", "nN"}
        Unit of targets at rates that are given as numbers.

    Raises
    ------
    ValueError
        If there is no change, a rate is not positive, or their number differs.
    """
    if not changes:
        raise ValueError(
            "a rate needs two values or more, between which the path goes, got one: "
            "give values such as [0, 20], or times"
        )
    try:
        rates = path.plain(["rate"], per_time(units), f"{unit}/s").rate
    except ValueError as error:
        raise ValueError(
            f'rate must be a number ({unit}/s), or a string such as "20 {unit}/s", got '
            f"{path.rate!r}"
        ) from error
    rates = rates if isinstance(rates, tuple) else (rates,) * changes
    if len(rates) != changes:
        raise ValueError(
            f"give one rate, or one for each change from a value to the next: {changes}"
            f", got {len(rates)}"
        )
    positive(rate=min(rates))
    return [rate * UNITS[unit] for rate in rates]


def check_deepest(bodies: Bodies, given: Any, deepest: float) -> None:
    """Raise an error for a loop that turns where the wall does not act yet.

    Parameters
    ----------
    bodies : Bodies
    given : float or str
        Deepest penetration of the loop as the user gave it, for the message.
    deepest : float
        The same penetration (Å).

    Raises
    ------
    ValueError
    """
    if -bodies.wall.reach < deepest < math.inf:
        return
    found = QUANTITY.fullmatch(str(given))
    unit = found[2] if found else "Å"
    value = lengths(bodies.spacing)[unit]
    raise ValueError(
        f"deepest must be a penetration above {-bodies.wall.reach / value:.4g} {unit}, "
        f"where the wall begins to act, got {deepest / value:g} {unit}"
    )
