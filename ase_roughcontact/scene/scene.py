"""Scene: a calculation that can be read from a file, checked, planned and run."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from ase import Atoms
from numpy.typing import ArrayLike

from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import grid_shape, integer, lookup, positive
from ase_roughcontact.atoms.calculator import RoughContact, contact_of
from ase_roughcontact.atoms.substrate import substrate
from ase_roughcontact.paths.accuracy import Accuracy, accuracy_of
from ase_roughcontact.paths.loading import load_path
from ase_roughcontact.paths.plan import Plan, plan_path
from ase_roughcontact.paths.record import LoadStep
from ase_roughcontact.scene.config import SECTIONS
from ase_roughcontact.scene.model import Model
from ase_roughcontact.scene.optimizers import OPTIMIZERS
from ase_roughcontact.scene.reading import read_sections
from ase_roughcontact.windows.memory import check_memory, check_roughness, points_of

# Shape of the atoms before a window is chosen.
_FIRST_SHAPE = (8, 8)

#: One nanonewton in ASE's unit of force, eV/Å.
NANONEWTON = UNITS["nN"]


@dataclass(frozen=True)
class Scene(Model):
    """Sphere, material, wall, path and solver.

    Parameters
    ----------
    substrate, sphere, roughness, interaction, path, solver
        Sections of a scene file. Without `roughness` the sphere is smooth.
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
    def parse(cls, text: str, name: str = "scene") -> Scene:
        """Return the scene of a text, without `check`.

        The scene of an ensemble may omit keys that are set for each case.

        Parameters
        ----------
        text : str
            TOML.
        name : str
            Name of the file for error messages.

        Returns
        -------
        Scene

        Raises
        ------
        ValueError
            If the text is not TOML, a section or key is unknown, or a value is of the
            wrong type.
        """
        return cls(**read_sections(text, name))

    @classmethod
    def default(cls) -> Scene:
        """Return the built-in scene."""
        return cls.parse(default_text(), "default.toml")

    def with_values(self, values: Mapping[str, Any]) -> Scene:
        """Return the scene with other values of some keys.

        Parameters
        ----------
        values : mapping
            Values by key, in the units of the scene file: ``"sphere.radius"``; or whole
            sections by title, None for none.

        Returns
        -------
        Scene

        Raises
        ------
        ValueError
            If a section or key is unknown, or a value is of the wrong type.
        """
        changes: dict[str, Any] = {}
        for key, value in values.items():
            title, _, name = key.partition(".")
            lookup(title, SECTIONS, "section")
            section = changes.get(title, getattr(self, title))
            if name and section is None:
                raise ValueError(f"{key} can't be set: the scene has no [{title}]")
            if not (name or value is None or isinstance(value, SECTIONS[title])):
                raise ValueError(f"[{title}] must be a section, got {value!r}")
            changes[title] = section.changed(name, value) if name else value
        return replace(self, **changes)

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
        parts: dict[str, Callable[[], Any]] = {
            "substrate": lambda: (self.spacing, self.contact_modulus, self.shape),
            "roughness": lambda: self.self_affine,
            "sphere": lambda: self.surface,
            "solver": lambda: (
                self.fmax,
                self.accuracy,
                self.optimizer,
                integer("max_steps", self.solver.max_steps, 1),
            ),
            "interaction": lambda: self.wall,
            "path": lambda: self.steps,
        }
        for title, part in parts.items():
            try:
                part()
            except ValueError as error:
                raise ValueError(f"{name}: [{title}] {error}") from error
        try:  # before heights of the roughness are allocated
            check_roughness(points_of(self.surface, self.spacing))
        except MemoryError as error:
            raise MemoryError(f"{name}: [roughness] {error}") from error

    @property
    def control(self) -> str:
        """Controlled quantity of the path: loads, penetrations or heights."""
        return f"{self.path.control}s"

    @property
    def steps(self) -> np.ndarray:
        """Targets of the path: loads (eV/Å), penetrations or heights (Å)."""
        return UNITS[self.path.unit] * self.path.targets

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
        given = self.substrate
        if self.shape:
            check_memory(self.shape, margin=not given.periodic)
        atoms = substrate(
            given.symbol,
            self.shape or _FIRST_SHAPE,
            self.surface,
            spacing=self.spacing,
            periodic=given.periodic,
            fixed=self.path.control != "load",
        )
        atoms.calc = RoughContact(self.surface, self.contact_modulus, self.wall)
        atoms.positions[-1, 2] = contact_of(atoms).first_contact
        return atoms

    def plan(self) -> Plan:
        """Return the windows, memory and time that the path will need."""
        return plan_path(self.atoms(), self.control, self.steps, self.window)

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
            max_steps=self.solver.max_steps,
            window=self.window,
            **path,
            **options,
        )

    def run(self, folder: str | Path) -> Iterator[LoadStep]:
        """Relax step after step, writing ``curve.csv`` and ``sweep.traj``.

        Parameters
        ----------
        folder : path
            Folder of the files, created if necessary. A run of this scene in it, or of
            one with a shorter path, is resumed.

        Yields
        ------
        LoadStep

        Raises
        ------
        ValueError
            If the folder contains a run of another scene. The error lists the
            differences if the folder contains a ``scene.toml``.
        OSError
            If the folder can't be written.
        """
        self.check()
        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        files: dict[str, Any] = {
            "trajectory": folder / "sweep.traj",
            "csv": folder / "curve.csv",
        }
        try:
            path = self.relax(resume=True, **files)
        except ValueError as error:
            changes = self._changes_from(folder / "scene.toml")
            if not changes:
                raise
            raise ValueError(
                f"{folder} contains a run of another scene: {'; '.join(changes)}. Give "
                "another folder, or delete this one; a path can be extended only by "
                "steps after its last one"
            ) from error
        yield from path

    def _entries(self) -> dict[str, Any]:
        """Return the values of all keys, such as ``"sphere.radius"``."""
        sections = {title: getattr(self, title) for title in SECTIONS}
        return {
            f"[{title}] {key}": value
            for title, section in sections.items()
            if section is not None
            for key, value in section.entries().items()
        }

    def _changes_from(self, file: Path) -> list[str]:
        """Return the keys whose values differ from those of a file, if it exists."""
        if not file.exists():
            return []
        old, new = Scene.read(file)._entries(), self._entries()
        return [
            f"{key} was {_toml(old.get(key))}, is {_toml(new.get(key))}"
            for key in {**old, **new}
            if old.get(key) != new.get(key)
        ]


def _toml(value: Any) -> str:
    return "not given" if value is None else json.dumps(value)


def default_text() -> str:
    """Return the text of the built-in scene file."""
    return files("ase_roughcontact").joinpath("default.toml").read_text("utf-8")
