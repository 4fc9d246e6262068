"""Scene: a calculation that can be read from a file, checked, planned and run."""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from ase import Atoms
from numpy.typing import ArrayLike

from ase_roughcontact._util.files import replaced
from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import grid_shape, integer, lookup, positive
from ase_roughcontact.atoms.calculator import RoughContact, contact_of
from ase_roughcontact.atoms.substrate import substrate
from ase_roughcontact.elasticity import Isotropic
from ase_roughcontact.paths.accuracy import Accuracy, accuracy_of
from ase_roughcontact.paths.hysteresis import (
    SMALLEST_STEP,
    adhesion_loop,
    default_step,
)
from ase_roughcontact.paths.instabilities import AdhesionLoop
from ase_roughcontact.paths.loading import load_path
from ase_roughcontact.paths.plan import Plan, PlannedStep, plan_path, thinned
from ase_roughcontact.paths.record import LoadStep
from ase_roughcontact.scene.model import Model
from ase_roughcontact.scene.optimizers import OPTIMIZERS
from ase_roughcontact.scene.quantities import FORCES, lengths, plain
from ase_roughcontact.windows.expected import (
    LARGEST_DOMAIN,
    ExpectedContact,
    coarsened,
)
from ase_roughcontact.windows.memory import check_memory, check_roughness, points_of
from ase_roughcontact.windows.regrid import regrid

# Shape of the atoms before a window is chosen.
_FIRST_SHAPE = (8, 8)

#: One nanonewton in ASE's unit of force, eV/Å.
NANONEWTON = UNITS["nN"]


@dataclass(frozen=True)
class Scene(Model):
    """Sphere, material, wall, path and solver.

    Parameters
    ----------
    substrate, sphere, roughness, topography, interaction, path, solver
        Sections of a scene file. With neither `roughness` nor `topography` the sphere
        is smooth.
    """

    @classmethod
    def read(cls, file: str | Path) -> Scene:
        """Read a scene file.

        Parameters
        ----------
        file : path
            TOML, see ``ase-roughcontact scene``.

        Returns
        -------
        Scene

        Raises
        ------
        ValueError
            If the file can't be read, is not TOML, or has an invalid value. The error
            names file, section and key.
        """
        scene = cls.parse(cls.text_of(file), str(file))
        scene.check(str(file))
        return scene

    @staticmethod
    def text_of(file: str | Path) -> str:
        """Return the text of a scene file.

        Parameters
        ----------
        file : path

        Returns
        -------
        str

        Raises
        ------
        ValueError
            If the file can't be read.
        """
        try:
            return Path(file).read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise ValueError(f"can't read the scene {file}: {error}") from error

    @classmethod
    def default(cls) -> Scene:
        """Return the built-in scene."""
        return cls.parse(default_text(), "default.toml")

    def check(self, name: str = "scene") -> None:
        """Raise an error if a value is out of range or inconsistent with others.

        Parameters
        ----------
        name : str
            Name of the file for error messages.

        Raises
        ------
        ValueError
            With file, section and key.
        MemoryError
            If the roughness needs more memory than is free.
        """
        parts = {
            "substrate": [
                "grid_change",
                "spacing",
                "contact_modulus",
                "hardness",
                "shape",
            ],
            "roughness": ["self_affine"],
            "topography": ["rough"],
            "sphere": ["surface"],
            "solver": ["fmax", "accuracy", "optimizer", "max_steps"],
            "interaction": ["wall"],
            "path": ["_checked_path"],
        }
        for title, properties in parts.items():
            problems = dict.fromkeys(filter(None, map(self._problem, properties)))
            if problems:
                raise ValueError(f"{name}: [{title}] {'; '.join(problems)}")
        try:  # before heights of the roughness are allocated
            spacing = self.grid_change.spacing(self.spacing)
            check_roughness(points_of(self.surface, spacing))
        except MemoryError as error:
            raise MemoryError(f"{name}: [roughness] {error}") from error

    @property
    def _checked_path(self) -> Any:
        return (self.loop_options, self.cantilever) if self.path.is_loop else self.steps

    def _problem(self, name: str) -> str:
        """Return why a property can't be calculated, else nothing."""
        try:
            getattr(self, name)
        except ValueError as error:
            return str(error)
        return ""

    @property
    def control(self) -> str:
        """Controlled quantity of the path: loads, penetrations or heights."""
        return f"{self.path.control}s"

    @property
    def steps(self) -> np.ndarray:
        """Targets of the path: loads (eV/Å), penetrations or heights (Å)."""
        if self.path.is_loop:
            raise ValueError(
                "the steps of a loop are chosen as it runs: it has no plan and no "
                "targets; run it with Scene.loop or ase-roughcontact run"
            )
        unit = self.path.unit
        units = FORCES if unit in FORCES else lengths(self.spacing)
        path = plain(self.path, ["first", "last", "values"], units, unit)
        return UNITS[unit] * path.targets

    @property
    def fmax(self) -> float | None:
        """Tolerance of the forces (eV/Å); None if it is not given."""
        if self.solver.fmax is None:
            return None
        positive(fmax=self.solver.fmax)
        return self.solver.fmax * self.contact_modulus * self.spacing**2

    @property
    def accuracy(self) -> Accuracy:
        """Accuracy of force and area."""
        return accuracy_of(self.solver.accuracy)

    @property
    def max_steps(self) -> int:
        """Largest number of steps of the optimizer, for each step of the path."""
        return integer("max_steps", self.solver.max_steps, 1)

    @property
    def optimizer(self) -> Any:
        """Optimizer; None if it is chosen for the wall."""
        name = self.solver.optimizer
        return None if name is None else lookup(name, OPTIMIZERS, "optimizer")

    @property
    def shape(self) -> tuple[int, int] | None:
        """Shape of the window of atoms; None if it is chosen for each step."""
        shape = self.substrate.shape
        if not isinstance(shape, str):
            return grid_shape(shape)
        if self.substrate.periodic:
            raise ValueError(
                'shape = "auto" needs a free half space: give the shape of the '
                "periodic cell, [n, m]"
            )
        return lookup(shape, {"auto": None}, "shape")

    @property
    def window(self) -> str:
        """``"fixed"`` if all steps have the same window, else ``"auto"``."""
        return "fixed" if self.shape else "auto"

    def atoms(self) -> Atoms:
        """Return the substrate and the indenter above it, with a calculator."""
        periodic, change = self.substrate.periodic, self.grid_change
        if self.shape:
            check_memory(change.shape(self.shape), margin=not periodic)
        atoms = substrate(
            self.symbol,
            self.shape or _FIRST_SHAPE,
            self.surface,
            spacing=self.spacing,
            periodic=periodic,
            fixed=self.path.control != "load" or self.path.is_loop,
        )
        solid = self.solid
        material: dict[str, Any] = {"solid": solid}
        if isinstance(solid, Isotropic):
            material = {"contact_modulus": solid.contact_modulus}
        atoms.calc = RoughContact(self.surface, interaction=self.wall, **material)
        if change:
            regrid(atoms, change)
        atoms.positions[-1, 2] = contact_of(atoms).first_contact
        return atoms

    @property
    def loop_options(self) -> dict[str, Any]:
        """Deepest penetration, steps (Å) and tolerance of a loop."""
        if self.path.deepest is None:
            raise ValueError("a loop needs deepest, the penetration at which to turn")
        units = lengths(self.spacing)
        path: Any = plain(self.path, ["deepest", "step"], units, "Å")
        step = path.step
        if step is None:
            step = default_step(self.wall, path.deepest)
        positive(step=step, tolerance=path.tolerance)
        return {
            "deepest": path.deepest,
            "step": step,
            "smallest_step": SMALLEST_STEP * step,
            "tolerance": path.tolerance,
        }

    @property
    def cantilever(self) -> float | None:
        """Stiffness of the cantilever (eV/Å^2); None if it is not given."""
        if self.path.cantilever is None:
            return None
        positive(cantilever=self.path.cantilever)
        return self.path.cantilever * UNITS["J/m^2"]

    def loop(
        self,
        folder: str | Path | None = None,
        callback: Callable[[LoadStep], Any] | None = None,
        validity: str = "warn",
        text: str | None = None,
    ) -> AdhesionLoop:
        """Approach and retract; see `adhesion_loop`.

        Parameters
        ----------
        folder : path, optional
            Folder of the files `run` writes, created if necessary. A loop in it is
            replaced.
        callback : callable, optional
            Called with each state.
        validity : {"warn", "raise", "ignore"}
            What to do if a step exceeds a limit of the model; see `load_path`.
        text : str, optional
            Text of the scene's file; by default `toml`.

        Returns
        -------
        AdhesionLoop

        Raises
        ------
        ValueError
            If the path is not a loop, or invalid.
        """
        if not self.path.is_loop:
            raise ValueError('the path is not a loop: give [path] kind = "loop"')
        self.check()
        self.check_path()
        files: dict[str, Any] = {}
        if folder is not None:
            folder = _results_folder(folder)
            files = {"trajectory": folder / "sweep.traj", "csv": folder / "curve.csv"}

        def report(state: LoadStep) -> None:
            if folder is not None and state.step == 0:
                self._write_inputs(Path(folder) / "scene.toml", text or self.toml)
            if callback is not None:
                callback(state)

        return adhesion_loop(
            self.atoms(),
            **self.loop_options,
            optimizer=self.optimizer,
            fmax=self.fmax,
            accuracy=self.solver.accuracy,
            max_steps=self.max_steps,
            window=self.window,
            hardness=self.given_hardness,
            validity=validity,
            callback=report,
            **files,
        )

    @property
    def expected_contact(self) -> ExpectedContact:
        """Bounds for the contact, which are known without the roughness."""
        change, modulus = self.grid_change, self.contact_modulus
        surface: Any = change.surface(self.surface, self.spacing)
        return ExpectedContact(
            surface, self.wall, modulus, change.spacing(self.spacing)
        )

    def check_path(self) -> None:
        """Raise an error if a step certainly can't be calculated in automatic windows.

        Nothing is calculated for this: neither the roughness nor a window.

        Raises
        ------
        ValueError
            If atoms touch where the roughness is not defined.
        MemoryError
            If a contact exceeds the free memory.
        """
        if self.shape:
            return
        expected, control, unit = self.expected_contact, self.control, self.path.unit
        if self.path.is_loop:
            control, unit, deepest = "penetrations", "Å", self.loop_options["deepest"]
        else:
            steps = self.steps
            deepest = float(steps.min() if control == "heights" else steps.max())
        step = f"[path] {control.rstrip('s')} of {deepest / UNITS[unit]:g} {unit}"
        try:
            expected.check_surface(control, deepest)
            expected.check_memory(control, deepest)
        except ValueError as error:
            raise ValueError(f"{step}: {error}") from error
        except MemoryError as error:
            raise MemoryError(f"{step}: {error}") from error

    def plan(self) -> Plan:
        """Return the windows, memory and time that the path will need.

        Very large windows and roughnesses are planned on a coarser lattice.
        """
        expected, control = self.expected_contact, self.control
        surface, spacing = expected.indenter, expected.spacing
        path: dict[str, Any] = {"indenter": surface, "spacing": spacing}
        if self.shape:
            many = points_of(surface, spacing) > LARGEST_DOMAIN**2
            scene = replace(self, roughness=None) if many else self
            return plan_path(scene.atoms(), control, self.steps, "fixed", **path)
        targets, counts = thinned(self.steps)
        ratios = np.array([expected.coarsening(control, t) for t in targets.tolist()])
        plans, planned = {}, dict[float, PlannedStep]()
        for ratio in np.unique(ratios).tolist():
            atoms = self.atoms() if ratio == 1 else self._coarse_atoms(expected, ratio)
            part = targets[ratios == ratio]
            plans[ratio] = plan_path(atoms, control, part, "auto", **path)
            planned |= {step.target: step for step in plans[ratio].steps}
        return replace(
            plans[ratio],
            steps=tuple(
                replace(planned[target], count=count)
                for target, count in zip(targets.tolist(), counts.tolist(), strict=True)
            ),
            advice=next((p.advice for p in reversed(plans.values()) if p.advice), ""),
        )

    def _coarse_atoms(self, expected: ExpectedContact, ratio: int) -> Atoms:
        """Return atoms with which a plan is made on a coarser lattice."""
        surface, spacing = coarsened(expected.indenter, expected.spacing, ratio)
        fixed = self.path.control != "load"
        atoms = substrate(
            self.substrate.symbol, _FIRST_SHAPE, surface, spacing=spacing, fixed=fixed
        )
        atoms.calc = RoughContact(surface, self.contact_modulus, self.wall)
        return atoms

    def relax(
        self, steps: ArrayLike | None = None, **options: Any
    ) -> Iterator[LoadStep]:
        """Relax step after step.

        Parameters
        ----------
        steps : array_like, optional
            Loads (eV/Å), penetrations or heights (Å) in place of those of the path.
        **options
            Options of `load_path`, such as its files and `resume`.

        Returns
        -------
        iterator of LoadStep
        """
        targets = self.steps if steps is None else steps
        path: dict[str, Any] = {self.control: targets}
        return load_path(
            self.atoms(),
            optimizer=self.optimizer,
            fmax=self.fmax,
            accuracy=self.solver.accuracy,
            max_steps=self.max_steps,
            window=self.window,
            hardness=None if math.isnan(self.hardness) else self.hardness,
            **path,
            **options,
        )

    def run(
        self, folder: str | Path, validity: str = "warn", text: str | None = None
    ) -> Iterator[LoadStep]:
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

        Yields
        ------
        LoadStep

        Raises
        ------
        ValueError
            If the folder contains a run of another scene, with the differences, or
            a damaged one.
        OSError
            If the folder can't be written, or a file in it is a symbolic link.
        """
        self.check()
        self.check_path()
        folder = _results_folder(folder)
        file = folder / "scene.toml"
        files: dict[str, Any] = {
            "trajectory": folder / "sweep.traj",
            "csv": folder / "curve.csv",
        }
        try:
            path = self.relax(resume=True, validity=validity, **files)
        except ValueError as error:
            changes: list[str] = []
            with suppress(ValueError, OSError):
                changes = self.changes_from(Scene.read(file))
            if not changes:
                raise
            raise ValueError(
                f"{folder} contains a run of another scene: {'; '.join(changes)}. Give "
                "another folder, or delete this one; a path can be extended only by "
                "steps after its last one"
            ) from error
        for number, step in enumerate(path):
            if number == 0:  # from here on, no other run writes into the folder
                self._write_inputs(file, text or self.toml)
            yield step

    def _write_inputs(self, file: Path, text: str) -> None:
        """Write the scene, and copy its files beside it, where they are found again."""
        with replaced(file) as name:
            Path(name).write_text(text, encoding="utf-8")
        for other in map(Path, self.files):
            if other.parent.resolve() != file.parent.resolve():
                with replaced(file.parent / other.name) as name:
                    shutil.copy(other, name)


def _results_folder(folder: str | Path) -> Path:
    """Return a folder for results, created if necessary."""
    path = Path(folder)
    if path.exists() and not path.is_dir():
        raise ValueError(f"{folder} is a file, give a folder for the results")
    path.mkdir(parents=True, exist_ok=True)
    return path


def default_text() -> str:
    """Return the text of the built-in scene file."""
    return files("ase_roughcontact").joinpath("default.toml").read_text("utf-8")
