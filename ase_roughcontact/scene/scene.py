"""Scene: a calculation that can be read from a file, checked and run."""

from __future__ import annotations

import shutil
from collections.abc import Generator, Iterator, Sequence
from contextlib import closing, suppress
from dataclasses import asdict, dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from ase_roughcontact._util.files import replaced
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.paths.instabilities import AdhesionLoop
from ase_roughcontact.paths.loading import (
    PathFiles,
    follow_path,
    targets_of,
    warn_of_lost_slope,
)
from ase_roughcontact.paths.record import LoadStep
from ase_roughcontact.paths.resume import OtherPathError
from ase_roughcontact.paths.validity import ValidityReport
from ase_roughcontact.scene.loop import Loop
from ase_roughcontact.scene.path import ContactPath
from ase_roughcontact.scene.scan_summary import scan_warnings
from ase_roughcontact.windows.memory import check_roughness, points_of
from ase_roughcontact.windows.regrid import GridChange

#: One nanonewton in ASE's unit of force, eV/Å.
NANONEWTON = UNITS["nN"]
# Files that are the results of a scene.
_RESULTS = "sweep.traj", "places.csv"


@dataclass(frozen=True)
class Scene(ContactPath):
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
        return cls._read(Path(file))

    @classmethod
    def of_results(cls, folder: str | Path) -> Scene:
        """Read the scene of a folder of results, with the files copied to it.

        Parameters
        ----------
        folder : path
            With ``scene.toml``; see `run`.

        Returns
        -------
        Scene

        Raises
        ------
        ValueError
            See `read`.
        """
        return cls._read(Path(folder) / "scene.toml", copied=True)

    @classmethod
    def _read(cls, file: Path, copied: bool = False) -> Scene:
        scene = cls.parse(cls.text_of(file), str(file), copied)
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
        except UnicodeDecodeError as error:
            raise ValueError(f"{file} is not a TOML file: it is not text") from error
        except OSError as error:
            raise ValueError(f"can't read the scene {file}: {error}") from error

    @classmethod
    def default(cls) -> Scene:
        """Return the built-in scene."""
        return cls.parse(default_text(), "default.toml")

    def with_grid(self, change: GridChange) -> Scene:
        """Return the scene with a given grid, in place of that for its accuracy."""
        values: dict[str, Any] = {
            f"substrate.{key}": value for key, value in asdict(change).items()
        }
        if GridChange.of(spacing=self.substrate.spacing) is not None:
            values["substrate.spacing"] = None
        return self.with_values(values)

    @property
    def warnings(self) -> list[str]:
        """Warnings about the scan; empty if there are none, or no scan."""
        if self.scan is None or self.topography is None:
            return []
        return scan_warnings(self.topography, self.radius, self.whole_tip is not None)

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
                "area_column",
                "given_grid",
                "spacing",
                "contact_modulus",
                "given_hardness",
                "shape",
            ],
            "roughness": ["self_affine"],
            "topography": ["scan"],
            "sphere": ["radius", "surface"],
            "solver": ["fmax", "accuracy", "optimizer", "max_steps"],
            "interaction": ["wall", "hardness"],
            "heterogeneity": ["local_adhesion"],
            "path": ["_checked_path"],
        }
        names = {Path(file).name for file in self.files}
        if len(names) < len(set(self.files)):
            raise ValueError(
                f"{name}: the files of a scene must have different names, as they are "
                f"copied to the folder of its results, got {', '.join(self.files)}"
            )
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
        return self.path.check(self)

    def _problem(self, name: str) -> str:
        """Return why a property can't be calculated, else nothing."""
        try:
            getattr(self, name)
        except ValueError as error:
            return str(error)
        return ""

    def loop(self, validity: str = "warn") -> AdhesionLoop:
        """Approach and retract; see `adhesion_loop`.

        Parameters
        ----------
        validity : {"warn", "raise", "ignore"}
            What to do if a step exceeds a limit of the model; see `load_path`.

        Returns
        -------
        AdhesionLoop

        Raises
        ------
        ValueError
            If the path is not a loop.
        """
        if not isinstance(self.path, Loop):
            raise ValueError('the path is not a loop: give [path] kind = "loop"')
        return self.path.result(self, tuple(self.relax(validity=validity)))

    def relax(
        self,
        targets: ArrayLike | None = None,
        *,
        validity: str = "warn",
        record: type[LoadStep] = LoadStep,
        **files: Any,
    ) -> Generator[LoadStep, None, None]:
        """Relax step after step.

        Parameters
        ----------
        targets : array_like, optional
            Loads (eV/Å), penetrations or heights (Å) in place of those of the path.
        validity, record
            See `load_path`.
        **files
            Files of the path; see `PathFiles`.

        Returns
        -------
        generator of LoadStep
        """
        frames = self.frames()
        written = PathFiles(**files, frames=frames)
        stepper = self.stepper(frames, record)
        warn_of_lost_slope(stepper, self.grid_change, validity)
        if targets is None:
            return self.path.run(self, stepper, written, validity)
        targets = targets_of(self.control, targets)
        return follow_path(stepper, targets, written, validity, springs=[])

    def run(
        self, folder: str | Path, validity: str = "warn", text: str | None = None
    ) -> Iterator[LoadStep]:
        """Relax step after step; write ``curve.csv``, ``sweep.traj``, ``scene.toml``.

        Parameters
        ----------
        folder : path
            Folder of the files, created if necessary. A run of this scene in it, or of
            one with a shorter path, is resumed; a loop is started anew.
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
        report = ValidityReport(validity)
        folder = _results_folder(folder)
        resume = not self.path.adaptive
        self.check_folder(folder, ["places.csv"] if resume else _RESULTS)
        file = folder / "scene.toml"
        files: dict[str, Any] = {
            "trajectory": folder / "sweep.traj",
            "csv": folder / "curve.csv",
        }
        try:
            path = self.relax(resume=resume, validity="ignore", **files)
            with closing(path):
                for number, step in enumerate(path):
                    if number == 0:  # from here on, no other run writes into the folder
                        self.write_inputs(file, text)
                    report(number, step.validity)
                    yield step
        except OtherPathError as error:
            changes: list[str] = []
            with suppress(ValueError, OSError):
                changes = self.changes_from(Scene.of_results(folder))
            if not changes:
                raise
            raise ValueError(
                f"{_another(folder, changes)}; a path can be extended only by steps "
                "after its last one"
            ) from error

    def check_folder(self, folder: Path, results: Sequence[str] = _RESULTS) -> None:
        """Raise an error if a folder contains results of another scene.

        Parameters
        ----------
        folder : path
        results : sequence of str
            Names of the files that are results.

        Raises
        ------
        ValueError
            With the differences of the scenes, or if the folder has results, but no
            scene.
        """
        if any((folder / name).exists() for name in results):
            changes = self.changes_from(Scene.of_results(folder))
            if changes:
                raise ValueError(_another(folder, changes))

    def write_inputs(self, file: Path, text: str | None = None) -> None:
        """Write the scene, and copy its files beside it, where they are found again.

        Parameters
        ----------
        file : path
        text : str, optional
            Text of the scene's file, with its comments; by default `toml`.
        """
        with replaced(file) as name:
            Path(name).write_text(text or self.toml, encoding="utf-8")
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


def _another(folder: Path, changes: Sequence[str]) -> str:
    return (
        f"{folder} contains results of another scene: {'; '.join(changes)}. Give "
        "another folder, or delete this one"
    )


def default_text() -> str:
    """Return the text of the built-in scene file."""
    return files("ase_roughcontact").joinpath("default.toml").read_text("utf-8")
