"""Results of a run of a scene, read from its folder."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, overload

import numpy as np

from ase_roughcontact._util.rounding import ROUNDING
from ase_roughcontact._util.summary import Summarized, short_text
from ase_roughcontact._util.validation import FloatArray, lookup
from ase_roughcontact.analysis.contact_map import ContactMap
from ase_roughcontact.analysis.map_dataset import map_dataset
from ase_roughcontact.contact.control import LOAD
from ase_roughcontact.loading.trajectory import frame_of_step, places_of_steps
from ase_roughcontact.paths.restart import read_steps
from ase_roughcontact.results.record import LoadStep, columns_of, units_of
from ase_roughcontact.scene.path_result import results_of
from ase_roughcontact.scene.printed import units_in_print
from ase_roughcontact.scene.reference import Reference, reference_for
from ase_roughcontact.scene.results import RESTART
from ase_roughcontact.scene.scene import Scene
from ase_roughcontact.scene.tabular import Tabular

# Columns that differ from run to run.
_COSTS = "seconds", "memory"
# Number of points of a curve of theory, and the factor by which it exceeds the steps.
_CURVE_POINTS = 100
_CURVE_EXTENT = 1.1


class Results(Tabular, Sequence[LoadStep]):
    """Results of a run of a scene: steps, columns, maps, theory and figures.

    It is a sequence of the finished steps; the run may be interrupted or in progress.

    Parameters
    ----------
    folder : path
        Folder of the run; see `Scene.run`.

    Attributes
    ----------
    folder : Path
        The folder.
    scene : Scene
        The scene of the run.

    Raises
    ------
    ValueError
        If the folder has no results of a run, or they are damaged.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from ase_roughcontact.scene import Results, Scene
    >>> scene = Scene.parse('''
    ... [substrate]
    ... material = "Cu"
    ... [sphere]
    ... radius = "30 nm"
    ... [interaction]
    ... kind = "hard"
    ... [path]
    ... loads = ["1 nN", "10 nN"]
    ... ''')
    >>> with TemporaryDirectory() as folder:
    ...     finished = list(scene.run(folder))
    ...     results = Results(folder)
    ...     pressed = results.map(-1)
    >>> results['repulsive_atoms'].tolist(), results.units['normal_force']
    ([21, 69], 'eV/Å')
    >>> int(pressed.contact.sum())
    69
    """

    index_column = "step"
    ordered = True

    def __init__(self, folder: str | Path) -> None:
        self.folder = Path(folder)
        self.scene = Scene.of_results(folder)
        self._steps = read_steps(self.folder / RESTART, self.scene.record)

    def __len__(self) -> int:
        return len(self._steps)

    @overload
    def __getitem__(self, number: int) -> LoadStep: ...
    @overload
    def __getitem__(self, number: slice) -> list[LoadStep]: ...
    @overload
    def __getitem__(self, number: str) -> np.ndarray: ...
    def __getitem__(self, number: Any) -> Any:
        """Return a step by its number, some steps, or the column of a name."""
        if isinstance(number, str):
            return self.column(number)
        try:
            return self._steps[number]
        except IndexError:
            raise IndexError(
                f"there is no step {number}: give 0 to {len(self) - 1}, or a negative "
                "number from the last step"
            ) from None

    @property
    def columns(self) -> list[str]:
        """Names of the columns."""
        return list(columns_of(self.scene.record))

    def column(self, name: str) -> np.ndarray:
        """Return a column, or raise `ValueError` with the most similar name."""
        lookup(name, columns_of(self.scene.record), "column")
        return np.array([getattr(step, name) for step in self._steps])

    @property
    def units(self) -> dict[str, str]:
        """Units of the columns that have one, by name; units of ASE, as `LoadStep`."""
        return units_of(self.scene.record)

    @property
    def values(self) -> dict[str, float]:
        """Numbers that follow from all steps, by name; see `PathKind.results`.

        They are in units of ASE, and NaN where a number is not defined.
        """
        return results_of(self.scene.path, self.scene.bodies, self._steps)

    @cached_property
    def loop(self) -> Any:
        """`AdhesionLoop` of a path of kind "loop"; `ValueError` for another path."""
        scene = self.scene
        found = scene.path.result(scene.bodies, self._steps)
        if found is self._steps:
            raise ValueError(
                f'the path is not a loop but kind = "{scene.path.kind}": its steps '
                "are the items of the results"
            )
        return found

    @cached_property
    def reference(self) -> Reference:
        """Theory with which the results are compared."""
        return reference_for(self.scene)

    @property
    def steps_with_map(self) -> list[int]:
        """Numbers of the steps that have a map; see `Output.keep`."""
        found = places_of_steps(self._trajectory)
        return [number for number in found if number < len(self)]

    @property
    def _trajectory(self) -> Path:
        return self.folder / "sweep.traj"

    def map(self, number: int) -> ContactMap:
        """Return the map of the contact at a step, for which one frame is read.

        Parameters
        ----------
        number : int
            Number of the step; a negative one counts from the last step.

        Returns
        -------
        ContactMap
            Map with the gap, in single precision.

        Raises
        ------
        IndexError
            If there is no such step.
        ValueError
            If the step has no frame, or it is damaged.
        """
        step = self[number].step
        kept = self.steps_with_map
        if step not in kept:
            others = "as no step has"
            if kept:
                nearest = min(kept, key=lambda each: abs(each - step))
                others = f"the nearest is {nearest}"
            raise ValueError(
                f'step {step} has no frame, {others}: give keep = "all" in [output] to '
                "have all"
            )
        frame = frame_of_step(self._trajectory, step)
        return ContactMap.from_frame(frame, self.scene.sampled_surface)

    def to_xarray(self, number: int) -> Any:
        """Return the map of a step as a data set of xarray.

        Parameters
        ----------
        number : int
            Number of the step; see `map`.

        Returns
        -------
        xarray.Dataset
            Fields with units on x and y; see `map_dataset`.

        Raises
        ------
        ImportError
            If xarray is not installed.
        IndexError, ValueError
            As `map` does.
        """
        return map_dataset(self.map(number), self[number])

    def theory(
        self, column: str, along: str
    ) -> tuple[FloatArray, dict[str, FloatArray]]:
        """Return forces and areas by theory, for an area against the normal force."""
        if column not in ("contact_area", "continuum_area") or along != "normal_force":
            return super().theory(column, along)
        forces, areas = self.areas_by_theory()
        unit = self.factor(column)
        printed = {name: each / unit for name, each in areas.items()}
        return forces / self.factor(along), printed

    def error_column(self, column: str) -> str:
        """Return the name of the column with errors of a column, if there is one."""
        errors = {self.scene.area_column: "area_error", "normal_force": "force_error"}
        return errors.get(column, super().error_column(column))

    @property
    def usual_columns(self) -> tuple[str, str]:
        """Columns on the vertical and the horizontal axis of a figure by default.

        The force, or the area under a controlled load, against the controlled quantity,
        the lateral displacement, or the time.
        """
        path, control = self.scene.path, self.scene.control
        if path.has_friction:
            axis = max("xy", key=lambda each: float(np.ptp(self[f"lateral_{each}"])))
            return f"lateral_force_{axis}", f"lateral_{axis}"
        if path.in_time:
            return "normal_force", "time"
        if control == LOAD:
            return self.scene.area_column, "normal_force"
        return "normal_force", control.column

    def areas_by_theory(self) -> tuple[FloatArray, dict[str, FloatArray]]:
        """Return areas by theory under forces in the range of the steps.

        Returns
        -------
        forces : ndarray, shape (n,)
            Normal forces (eV/Å); empty if no force is compressive.
        areas : dict of ndarray, shape (n,)
            Areas by name of the theory (Å^2).
        """
        largest = float(self["normal_force"].max())
        if not largest > 0.0:
            return np.zeros(0), {}
        # close together at small forces, for logarithmic axes
        parts = np.linspace(0.0, 1.0, _CURVE_POINTS)[1:] ** 3
        forces = _CURVE_EXTENT * largest * parts
        areas = {
            self.scene.bodies.labelled(each.label): each.contact_area(forces)
            for each in (self.reference.smooth, *self.reference.limits)
        }
        rough = self.reference.rough_area(forces)
        if np.isfinite(rough).any():
            areas[self.scene.bodies.labelled("theory with roughness")] = rough
        return forces, areas

    def printed(self, name: str) -> str:
        """Return the unit in which a column is printed."""
        return units_in_print(self.scene)[name]

    def diff(self, other: Results | str | Path) -> ResultsDifference:
        """Compare the results with results of another run.

        Parameters
        ----------
        other : Results or path
            The other results, or their folder.

        Returns
        -------
        ResultsDifference
        """
        if not isinstance(other, Results):
            other = Results(other)
        count = min(len(self), len(other))
        largest: dict[str, float] = {}
        others = columns_of(other.scene.record)
        for name in columns_of(self.scene.record):
            if name in others and name not in _COSTS:
                change = _largest_change(self[name][:count], other[name][:count])
                if change:
                    largest[name] = change
        return ResultsDifference(
            tuple(self.scene.changes_from(other.scene)),
            (len(other), len(self)),
            largest,
            self.units,
        )

    def _summary(self) -> dict[str, str]:
        force = self["normal_force"]
        lowest, highest = short_text(force.min()), short_text(force.max(), "eV/Å")
        found = {
            "folder": repr(str(self.folder)),
            "kind": repr(self.scene.path.kind),
            "steps": str(len(self)),
            "normal_force": f"{lowest} to {highest}",
        }
        if not self["converged"].all():
            found["not_converged"] = str(int((~self["converged"]).sum()))
        return found

    @property
    def shown(self) -> list[str]:
        """Names of the columns of a table in a notebook."""
        columns = columns_of(self.scene.record)
        names = [name for name, each in columns.items() if each.label]
        if not self["converged"].all():
            names.append("converged")
        if self["validity"].any():
            names.append("validity")
        return names


@dataclass(frozen=True)
class ResultsDifference(Summarized):
    """Differences of results from other results; false if nothing differs.

    Attributes
    ----------
    scene : tuple of str
        Keys of the scene with other values.
    steps : (int, int)
        Numbers of steps of the other results and of these.
    columns : dict of str to float
        Largest absolute differences of columns in the common steps, by name; infinity
        if one value is not known, or texts differ. Time and memory are not compared.
    units : dict of str to str
        Units of the columns.
    """

    scene: tuple[str, ...]
    steps: tuple[int, int]
    columns: dict[str, float]
    units: dict[str, str]

    def __bool__(self) -> bool:
        before, after = self.steps
        return bool(self.scene or self.columns) or before != after

    def _summary(self) -> dict[str, str]:
        found = {"scene": "; ".join(self.scene) or "no difference"}
        found["steps"] = "{} and {}".format(*self.steps)
        for name, change in self.columns.items():
            found[name] = short_text(change, self.units.get(name, ""))
        return found


def _largest_change(values: np.ndarray, others: np.ndarray) -> float:
    """Return the largest difference of two columns beyond rounding errors."""
    if values.dtype.kind not in "fiub" or others.dtype.kind not in "fiub":
        return math.inf if (values != others).any() else 0.0
    first, second = values.astype(float), others.astype(float)
    unknown = np.isnan(first) | np.isnan(second)
    if (np.isnan(first) != np.isnan(second)).any():
        return math.inf
    change = abs(first - second)[~unknown]
    scale = np.maximum(abs(first), abs(second))[~unknown]
    return float(change[change > ROUNDING * scale].max(initial=0.0))
