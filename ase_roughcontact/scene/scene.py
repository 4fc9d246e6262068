"""Scene: a calculation that can be read from a file, checked and run."""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any, cast

import numpy as np
from ase import Atoms
from numpy.typing import ArrayLike

from ase_roughcontact._util.files import PathName
from ase_roughcontact._util.keywords import suggesting
from ase_roughcontact._util.lazy import lazy
from ase_roughcontact._util.validation import boolean, integer, one_of, positive
from ase_roughcontact.atoms.calculator import contact_of
from ase_roughcontact.contact import Problem
from ase_roughcontact.contact.control import LOAD, Control
from ase_roughcontact.elasticity import ElasticSolid
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.interactions import Interaction
from ase_roughcontact.loading.path_atoms import ProblemAtoms, relaxer_of
from ase_roughcontact.paths.follow import follow
from ase_roughcontact.paths.kept_frames import KEPT, Keep
from ase_roughcontact.paths.output import Output
from ase_roughcontact.paths.path_steps import NumberedSteps, targets_of
from ase_roughcontact.paths.planned_steps import Plan
from ase_roughcontact.results.flat_record import FlatStep
from ase_roughcontact.results.record import LoadStep
from ase_roughcontact.results.scan_errors import ScanErrors
from ase_roughcontact.results.validity import (
    Reaction,
    ValidityReport,
    warn_of_lost_slope,
)
from ase_roughcontact.scene.bodies import Bodies
from ase_roughcontact.scene.build import build
from ase_roughcontact.scene.config import OPTIMIZERS
from ase_roughcontact.scene.file import SECTIONS, SceneFile, attribute_of
from ase_roughcontact.scene.path_kind import PATHS, PathKind
from ase_roughcontact.scene.plan import (
    check_path,
    plan_of,
    warn_of_memory,
    warnings_of,
)
from ase_roughcontact.scene.results import write_results
from ase_roughcontact.scene.section import Problems
from ase_roughcontact.stepping.accuracy import LEVELS, Accuracy, GridModel
from ase_roughcontact.stepping.options import StepOptions, Window
from ase_roughcontact.stepping.step import Stepper
from ase_roughcontact.topography import HeightMap
from ase_roughcontact.topography.topography import topography_of
from ase_roughcontact.windows.memory import check_memory, check_roughness
from ase_roughcontact.windows.regrid import GridChange, lost_slope, on_grid

# Least side of the atoms before a window is chosen.
_FIRST_WINDOW_SIDE = 8


@dataclass(frozen=True)
class Scene(SceneFile):
    """Sphere, material, wall, path and solver.

    Parameters
    ----------
    substrate, sphere, roughness, topography, interaction, friction, path, solver
        Sections of a scene file. With neither `roughness` nor `topography` the sphere
        is smooth.
    output, study
        Sections of a scene file that do not change the other results. The study gives
        parameters and their values for ensembles.

    Examples
    --------
    >>> from ase_roughcontact.scene import Scene
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
    >>> [step.repulsive_atoms for step in scene.relax()]
    [21, 69]
    """

    def __getstate__(self) -> dict[str, Any]:
        """Return the sections, without the objects built from them."""
        names = map(attribute_of, SECTIONS)
        return {name: getattr(self, name) for name in names}

    @property
    def settled(self) -> Scene:
        """The scene with its model, and a spacing that fits its contact, as if given.

        They do not follow from other values then, which may be changed.
        """
        values: dict[str, Any] = {"substrate.model": self.model}
        if self.bodies.fitted:
            values["substrate.spacing"] = self.spacing
        return self.with_values(values)

    def with_grid(self, change: GridChange | None) -> Scene:
        """Return the scene with a given grid; None: chosen for the accuracy."""
        values: dict[str, Any] = {
            "substrate.refine": None if change is None else change.refine,
            "substrate.coarsen": None if change is None else change.coarsen,
        }
        if self.substrate.grid:
            values["substrate.grid"] = ""
        return self.settled.with_values(values)

    @cached_property
    def bodies(self) -> Bodies:
        """Solid, indenter and wall, and theory for them; see `build` for errors.

        The properties below are attributes of the scene, too. Areas by theory, labels
        and all else are attributes of the bodies alone.
        """
        return build(self)

    @property
    def spacing(self) -> float:
        """Atomic spacing a0 (Å), of the forces between atoms if they are given."""
        return self.bodies.spacing

    @property
    def solid(self) -> ElasticSolid:
        """Elastic solid below the surface."""
        return self.bodies.solid

    @property
    def wall(self) -> Interaction:
        """Interaction between the indenter and the atoms."""
        return self.bodies.wall

    @property
    def contact_modulus(self) -> float:
        """Contact modulus E* of the far field of the solid (eV/Å^3)."""
        return self.bodies.contact_modulus

    @property
    def hardness(self) -> float:
        """Hardness of the surface (eV/Å^3); NaN if it is not known."""
        return self.bodies.hardness

    @property
    def radius(self) -> float:
        """Radius of the sphere, or of curvature of a whole tip (Å); see `Bodies`."""
        return self.bodies.radius

    @property
    def rough(self) -> Any:
        """`SelfAffine` or `HeightMap`; None for a smooth sphere and a whole tip."""
        return self.bodies.rough

    @property
    def surface(self) -> Any:
        """Surface of the indenter, on the grid of the atoms."""
        return self.bodies.problem.indenter

    @property
    def whole_tip(self) -> HeightMap | None:
        """Scan that is a whole tip, for which the radius in the file is infinity."""
        return self.bodies.whole_tip

    @property
    def is_flat(self) -> bool:
        """Whether the indenter is nominally flat, without a sphere."""
        return self.bodies.is_flat

    @property
    def scan(self) -> HeightMap | None:
        """Scan of one of the bodies, of the substrate if both are; None without one."""
        return next((each.surface for each in self.scans.values()), None)

    @property
    def record(self) -> type[LoadStep]:
        """Class of the results."""
        record = self.path.record
        if self.is_flat and record is LoadStep:
            record = FlatStep
        return record.with_columns(self.output.columns)

    @property
    def warnings(self) -> list[str]:
        """Warnings about the scan and the grid; see `warnings_of`."""
        return warnings_of(self)

    @property
    def expected_areas(self) -> np.ndarray:
        """Contact areas (Å^2) at the targets if it were smooth and without adhesion."""
        if self.control == LOAD:
            return self.bodies.hertz_area(np.maximum(self.targets, 0.0))
        return self.bodies.area_at(self.control.depths(self.targets))

    @property
    def area_column(self) -> str:
        """Column of the contact area that answers the scene's question."""
        return self.grid_model.area_column

    @property
    def is_continuum(self) -> bool:
        """Whether the scene asks for the continuum, and not for the model of atoms."""
        return self.grid_model.is_continuum

    @cached_property
    def grid_change(self) -> GridChange:
        """Grid relative to the grid of the atoms, given or chosen for the accuracy."""
        return self._grid_of(self.grid_model)

    def _grid_of(self, model: GridModel) -> GridChange:
        """Return the grid of a model relative to the grid of the atoms."""
        return model.grid(self.surface, self.wall, self.spacing, self.shape)

    @cached_property
    def lost_slope(self) -> float:
        """Part of the rms slope that is lost, as a coarse grid can't resolve it."""
        return lost_slope(self.surface, self.sampled_surface)

    @property
    def sampled_surface(self) -> Any:
        """Surface of the indenter without waves that a coarse grid can't resolve."""
        return self.problem.indenter

    def check(self, name: str = "scene") -> None:
        """Raise an error if a value can't be used; see `SceneFile.check`."""
        super().check(name)
        problems = Problems(name)
        with problems.of():
            _ = self.bodies
        with problems.of("substrate"):
            _ = GridModel(self.model, given=self.substrate.grid_change)
            if self.sphere.radius != math.inf:
                _ = self.substrate.window_shape
        with problems.of("solver"):
            _ = GridModel("continuum", self.solver.asked_accuracy)
        with problems.of("solver"):
            _ = self.fmax
        with problems.of("solver"):
            _ = self.optimizer
        with problems.of("solver"):
            integer("max_steps", self.solver.max_steps, 1)
        with problems.of("output"):
            one_of(KEPT, keep=self.output.keep)
        with problems.of("path"):
            _ = self.path.controlled
        problems.check()
        with problems.of("output"):
            _ = self.record
        with problems.of("friction"):
            if self.friction:
                self.friction.law_on(self.spacing)
            if self.friction and not self.path.has_friction:
                kinds = [name for name, each in PATHS.items() if each.has_friction]
                raise ValueError(
                    f'needs [path] kind = "{" or ".join(kinds)}", in which the '
                    f'indenter moves sideways, got kind = "{self.path.kind}": change '
                    "the path, or omit [friction]"
                )
        problems.check()  # friction is a part of the path
        with problems.of("path"):
            _ = self.planned, self.cantilever
            self.path.check(self.bodies)
        problems.check()
        try:  # before heights of the roughness are allocated
            spacing = self.grid_change.spacing(self.spacing)
            check_roughness(topography_of(self.surface).points(spacing))
        except MemoryError as error:
            raise MemoryError(f"{name}: [roughness] {error}") from error

    @property
    def control(self) -> Control:
        """Quantity that the path prescribes."""
        return self.path.controlled

    @property
    def is_in_order(self) -> bool:
        """Whether states depend on earlier states."""
        whole = self.path.in_order or self.path.count(self.bodies) is None
        return whole or self.wall.depends_on_history

    @property
    def targets(self) -> np.ndarray:
        """Targets of the path: loads (eV/Å), penetrations or heights (Å)."""
        return self.path.targets(self.bodies)

    @cached_property
    def planned(self) -> Scene:
        """The scene with the known targets that are planned and previewed."""
        return self._with_targets(self.path.planned(self.bodies))

    def _with_targets(self, path: PathKind) -> Scene:
        """Return the scene with a path of known targets, without time."""
        if path is self.path:
            return self
        return replace(self.settled, path=path).with_values(
            {"substrate.relaxation_moduli": None, "substrate.relaxation_times": None}
        )

    @property
    def fmax(self) -> float | None:
        """Tolerance of the forces (eV/Å); None if it is not given."""
        if self.solver.fmax is not None:
            positive(fmax=self.solver.fmax)
        return self.solver.fmax

    @property
    def grid_model(self) -> GridModel:
        """What the points of the grid are, the error asked for, and the given grid."""
        return GridModel(
            self.model, self.solver.asked_accuracy, self.substrate.grid_change
        )

    @property
    def optimizer(self) -> Any:
        """Optimizer; None if it is chosen for the wall."""
        name = self.solver.optimizer
        return None if name is None else OPTIMIZERS.find(name)

    @property
    def shape(self) -> tuple[int, int] | None:
        """Shape of the window of atoms; None if it is chosen for each step."""
        cell = self.bodies.cell
        return self.substrate.window_shape if cell is None else cell

    @property
    def window(self) -> Window:
        """``"fixed"`` if all steps have the same window, else ``"auto"``."""
        return "fixed" if self.shape else "auto"

    @property
    def problem(self) -> Problem:
        """Solid, wall and indenter on the grid of the path."""
        return self._on_grid[0]

    @property
    def start(self) -> Box:
        """Window of all steps, or of the first one."""
        return self._on_grid[1]

    @cached_property
    def _on_grid(self) -> tuple[Problem, Box]:
        return self._problem_on(self.grid_change)

    def _problem_on(self, change: GridChange) -> tuple[Problem, Box]:
        if self.shape:
            check_memory(change.shape(self.shape))
        first = _FIRST_WINDOW_SIDE, _FIRST_WINDOW_SIDE
        n, m = self.shape or change.enclosing_shape(first)
        window = Box((-(n // 2), -(m // 2)), (n, m))
        return on_grid(self.bodies.problem, window, change)

    def atoms(self) -> Atoms:
        """Return the substrate and the indenter above it, with a calculator."""
        atoms = self.frames().atoms
        atoms.positions[-1, 2] = contact_of(atoms).first_contact
        return atoms

    def frames(self) -> ProblemAtoms:
        """Return the atoms of the path, which are made when they are needed."""
        problem, window = self._on_grid
        return ProblemAtoms(problem, window, self.bodies.symbol, not self.control.free)

    def stepper(self, frames: ProblemAtoms, scan_errors: bool = False) -> Stepper:
        """Return the stepper that relaxes the steps; see `relax`.

        `frames` makes the atoms for optimizers that work on atoms.
        """
        options = StepOptions(
            relaxer=relaxer_of(self.optimizer, self.wall, frames),
            fmax=self.fmax,
            accuracy=cast("Accuracy", self.solver.asked_accuracy),
            max_steps=self.solver.max_steps,
            window=self.window,
            hardness=self.hardness,
            hardness_bound=self.bodies.hardness_bound,
            yield_strength=self.bodies.yield_strength,
            continuum=self.is_continuum,
            lost_slope=self.lost_slope,
            cantilever=self.cantilever or 0.0,
        )
        if scan_errors and self.scans:
            options = replace(options, scan_errors=self.planned._scan_errors(options))
        return Stepper(self.problem, self.control, self.start, options)

    def _scan_errors(self, options: StepOptions) -> ScanErrors:
        error = max(self.grid_model.error, LEVELS["fast"])
        model = replace(self.grid_model, accuracy=error)
        problem, start = self._problem_on(self._grid_of(model))
        return ScanErrors(
            problem,
            self.control,
            start,
            replace(options, accuracy=error, lost_slope=0.0),
            self.targets.tolist(),
        )

    @cached_property
    def first_contact(self) -> float:
        """Height at which the indenter begins to repel the flat substrate (Å)."""
        return self.stepper(self.frames()).windows.first_contact

    @property
    def cantilever(self) -> float | None:
        """Stiffness of the cantilever (eV/Å^2); None if it is not given."""
        return self.path.stiffness

    def check_path(self) -> None:
        """Raise an error if a step certainly can't be calculated; see `check_path`."""
        check_path(self._with_targets(self.path.certain(self.bodies)))

    def plan(self) -> Plan:
        """Return the windows, memory and time that the path will need.

        If the path chooses its targets as it runs, this is the plan of `planned`.
        """
        return plan_of(self)

    @lazy
    @suggesting
    def relax(
        self,
        targets: ArrayLike | None = None,
        *,
        validity: Reaction = "warn",
        record: type[LoadStep] | None = None,
        scan_errors: bool = True,
        csv: PathName | None = None,
        trajectory: PathName | None = None,
        keep: Keep | None = None,
        restart: PathName | None = None,
        resume: bool = False,
    ) -> Generator[LoadStep, None, None]:
        """Relax step after step.

        Parameters
        ----------
        targets : array_like, optional
            Loads (eV/Å), penetrations or heights (Å) in place of the path's targets.
        validity, record
            See `load_path`.
        scan_errors : bool
            Whether the errors include effects of the pixels and the noise of a scan;
            some modified copies of the scan are pressed for this, too.
        csv, trajectory, keep, restart, resume
            Files of the path; see `Output`. `keep` is by default the key of the scene.

        Returns
        -------
        generator of LoadStep
        """
        boolean(scan_errors=scan_errors)
        frames = self.frames()
        output = Output(
            csv=csv,
            trajectory=trajectory,
            keep=keep or cast("Keep", self.output.keep),
            restart=restart,
            resume=resume,
            record=record or self.record,
            columns=self.output.columns,
            frames=frames,
        )
        stepper = self.stepper(frames, scan_errors)
        lost = stepper.options.lost_slope
        warn_of_lost_slope(lost, self.grid_change, validity)
        if targets is None:
            steps = self.path.steps_of(self.bodies, stepper)
        else:
            steps = NumberedSteps(stepper, targets_of(self.control, targets))
        return follow(steps, output, validity, **self.path.springs)

    @lazy
    @suggesting
    def run(
        self, folder: str | Path, validity: Reaction = "warn", text: str | None = None
    ) -> Generator[LoadStep, None, None]:
        """Relax step after step; write ``curve.csv``, ``sweep.traj``, ``scene.toml``.

        Parameters
        ----------
        folder : path
            Folder of the files, created if necessary. A run of this scene in it, or of
            one with a shorter path, is resumed.
        validity : {"warn", "raise", "ignore"}
            What to do if a step exceeds a limit of the model; see `load_path`.
        text : str, optional
            Text of the scene's file, with its comments; by default `toml`.

        Returns
        -------
        generator of LoadStep
            The steps, each after it is written; `Results` reads them again. It warns if
            it is dropped before a step is taken: nothing is calculated then.

        Raises
        ------
        ValueError
            If the folder contains a run of another scene, with the differences, a
            damaged one, or a table or scene that no run wrote, or if a file of the
            scene has the name of one that is written.
        OSError
            If the folder can't be written, or a file in it is a symbolic link.
        """
        self.check()
        self.check_path()
        warn_of_memory(self.planned)
        path = partial(self.relax, resume=True, validity="ignore")
        return write_results(self, Path(folder), path, ValidityReport(validity), text)
