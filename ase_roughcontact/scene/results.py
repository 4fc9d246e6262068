"""Folders with the results of a scene, its file, and the other files that it needs."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Generator, Sequence
from contextlib import closing, suppress
from pathlib import Path

from ase_roughcontact._util.files import replaced
from ase_roughcontact.paths.path_steps import OtherPathError
from ase_roughcontact.results.record import LoadStep
from ase_roughcontact.results.validity import ValidityReport
from ase_roughcontact.scene.file import SceneFile, read_text
from ase_roughcontact.scene.path_kind import PATHS

#: Restart file of the path of a scene.
RESTART = "sweep.restart.npz"
#: Files that are the results of a scene.
RESULTS = RESTART, "sweep.traj", "places.csv"
# Files and folders that commands write into the folder of any scene.
_OUTPUT_NAMES = {
    RESTART,
    "cantilever.csv",
    "contact.png",
    "curve.csv",
    "curve.png",
    "force.png",
    "maps",
    "places.csv",
    "places.png",
    "report.html",
    "scene.toml",
    "stress.png",
    "sweep.traj",
    "view.traj",
}
# Endings of the files that are written for each of these names.
_FILE_ENDINGS = "", ".new", ".lock"


def outputs() -> set[str]:
    """Return the names of all files and folders in the folder of a scene.

    Pictures of all kinds of path are among them.
    """
    pictures = {name for kind in PATHS.values() for name in kind.captions}
    return _OUTPUT_NAMES | pictures


def check_inputs(scene: SceneFile) -> None:
    """Raise `ValueError` if a file of a scene has the name of one that is written."""
    written = {name + ending for name in outputs() for ending in _FILE_ENDINGS}
    for file in scene.files:
        if Path(file).name.lower() in written:
            raise ValueError(
                f"{file} has the name of a file in the folder of the results, to which "
                "it would be copied: rename it"
            )


def check_folder(
    scene: SceneFile, folder: Path, results: Sequence[str] = RESULTS
) -> None:
    """Raise an error if a folder contains results of another scene.

    Parameters
    ----------
    scene : SceneFile
        Scene to be run.
    folder : path
        Folder that the results are written to.
    results : sequence of str
        Names of the files that are results.

    Raises
    ------
    ValueError
        If the folder has results of another scene, with the differences, or results
        without a valid scene.
    """
    has_results = any((folder / name).exists() for name in results)
    if has_results and (message := _difference_message(scene, folder)):
        raise ValueError(message)


def _difference_message(scene: SceneFile, folder: Path) -> str:
    """Return the error if a folder has results of another scene; empty if not."""
    file = folder / "scene.toml"
    old = SceneFile.parse(read_text(file), str(file), copied=True)
    if not (found := scene.changes_from(old)):
        return ""
    return (
        f"{folder} contains results of another scene: {'; '.join(found)}. Give another "
        "folder, or delete this one"
    )


def _check_replaced(folder: Path) -> None:
    """Raise an error if a run would overwrite a table or scene that no run wrote."""
    table, scene = folder / "curve.csv", folder / "scene.toml"
    if (folder / RESTART).exists():
        return
    error = "{} is not of a run, which would overwrite it: give another folder"
    if _is_overwritten(table) and table.read_bytes()[:5] not in (b"", b"step,"):
        raise ValueError(error.format(table))
    if _is_overwritten(scene):
        try:
            SceneFile.parse(read_text(scene), str(scene), copied=True)
        except ValueError as invalid:
            raise ValueError(error.format(scene)) from invalid


def _is_overwritten(file: Path) -> bool:
    """Return whether a run would overwrite a file: of links it replaces the link."""
    return file.is_file() and not file.is_symlink()


def write_inputs(scene: SceneFile, file: Path, text: str | None = None) -> None:
    """Write the scene, and copy its files beside it, where they are found again.

    Parameters
    ----------
    scene : SceneFile
    file : path
        Scene file to write.
    text : str, optional
        Text of the scene's file, with its comments; by default `toml`.
    """
    with replaced(file) as name:
        Path(name).write_text(text or scene.toml, encoding="utf-8")
    for other in map(Path, scene.files):
        if other.parent.resolve() != file.parent.resolve():
            with replaced(file.parent / other.name) as name:
                shutil.copy(other, name)


def write_results(
    scene: SceneFile,
    folder: Path,
    path: Callable[..., Generator[LoadStep, None, None]],
    report: ValidityReport,
    text: str | None,
) -> Generator[LoadStep, None, None]:
    """Relax the steps of a scene and write them into a folder; see `Scene.run`.

    Parameters
    ----------
    scene : SceneFile
    folder : path
        Folder of the results.
    path : callable
        Function that returns the steps, given the files in which they are stored.
    report : ValidityReport
        Report of the limits that steps exceed.
    text : str or None
        See `write_inputs`.

    Yields
    ------
    LoadStep
    """
    if folder.exists() and not folder.is_dir():
        raise ValueError(f"{folder} is a file, give a folder for the results")
    check_inputs(scene)
    folder.mkdir(parents=True, exist_ok=True)
    check_folder(scene, folder, ["places.csv"])
    _check_replaced(folder)
    files = {
        "restart": folder / RESTART,
        "trajectory": folder / "sweep.traj",
        "csv": folder / "curve.csv",
    }
    try:
        with closing(path(**files)) as steps:
            for number, step in enumerate(steps):
                if number == 0:  # from here on, no other run writes into the folder
                    write_inputs(scene, folder / "scene.toml", text)
                report(number, step.validity)
                yield step
    except OtherPathError as error:
        message = ""
        with suppress(ValueError):  # without a valid scene
            message = _difference_message(scene, folder)
        if not message:
            raise
        raise ValueError(
            f"{message}; to extend a path, append to its lists, as values: another "
            "last or steps changes all targets"
        ) from error
