"""Fits of many force curves, in parallel, which continue after an interruption."""

from __future__ import annotations

import json
import logging
import math
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import ExitStack, closing, contextmanager
from dataclasses import asdict
from pathlib import Path

from ase_roughcontact._util.checked_rows import checked_rows
from ase_roughcontact._util.files import PathName, replaced, table_writer
from ase_roughcontact._util.lazy import lazy
from ase_roughcontact._util.locks import locked
from ase_roughcontact._util.workers import worker_pool
from ase_roughcontact.fitting.measurement import given_calibration
from ase_roughcontact.fitting.series.listing import CurveName, listed_curves
from ase_roughcontact.fitting.series.one_curve import FitSettings, fitted_curve
from ase_roughcontact.fitting.series.row import (
    FittedCurve,
    curve_heads,
    from_row,
    to_row,
)
from ase_roughcontact.fitting.series.table import FittedCurves

_log = logging.getLogger(__name__)
# Number of curves that a worker fits one after the other.
_TASK_CURVES = 16
# Name of the table in the folder of results.
_TABLE_FILE = "curves.csv"
# Name of the file of the settings in the folder of results.
_SETTINGS_FILE = "settings.json"


@lazy
def fit_curves(
    files: Iterable[PathName] | str | Path,
    indenter: str = "",
    folder: PathName | None = None,
    *,
    adhesion: str = "",
    relaxation: int = 0,
    thickness: float = math.inf,
    deepest: float = math.inf,
    branch: str | None = None,
    stiffness: float | None = None,
    sensitivity: str = "",
    heads: Sequence[str] = (),
    executor: Executor | None = None,
    workers: int | None = None,
) -> Iterator[FittedCurve]:
    """Fit an indenter to many force curves: a map, an archive, or a series of files.

    A curve that can't be read or fitted has a `message`, and the others go on.

    Parameters
    ----------
    files : path or iterable of path
        Files with one or more curves each, see `read_curve`, or folders of such files.
    indenter : str
        Shape and dimensions: ``"sphere 5 um"``, ``"cone 35 deg"``. Without it, the
        curves are read and checked only.
    folder : path, optional
        Folder for ``curves.csv``, which gets the rows of the curves in their order
        while others are fitted. A run that was interrupted goes on where it ended.
    adhesion : {"", "jkr", "dmt"}
        Theory of an adhesive sphere, which is fitted to the retraction by
        `fit_adhesion`.
    relaxation : int
        Number of relaxation times, which are fitted to approach and hold over the times
        in the file by `fit_relaxation`; 0 for an elastic fit.
    thickness, deepest
        See `fit_indentation` (Å).
    branch, stiffness, sensitivity, heads
        See `read_curve`. The pull-off force needs both branches in the file.
    executor : Executor, optional
        Executor of the fits, as in `run_ensemble`.
    workers : int, optional
        Number of processes of the default pool, by default one per processor; scripts
        that use it need ``if __name__ == "__main__":``.

    Yields
    ------
    FittedCurve
        Result of each curve in the order of the files, including the curves of an
        earlier run.

    Raises
    ------
    ValueError
        If there are no curves, the indenter or the theory is unknown or they do not go
        together, or the folder has the results of other files or settings.
    ImportError
        If a package that reads the format is missing.
    RuntimeError
        If another run is writing the folder.

    Notes
    -----
    E* is fitted as by `fit_indentation`, with its standard errors. A map of JPK is
    opened once by each worker.
    """
    settings = FitSettings(
        indenter,
        adhesion,
        relaxation,
        thickness,
        deepest,
        branch,
        stiffness,
        sensitivity,
        tuple(heads),
    )
    settings.check()
    given = [files] if isinstance(files, (str, Path)) else list(files)
    names = listed_curves(given, given_calibration(stiffness, sensitivity))
    with ExitStack() as stack:
        found: list[FittedCurve] = []
        if folder is not None:
            found, write = stack.enter_context(_table(Path(folder), settings, names))
        yield from found
        done, missing = len(found), names[len(found) :]
        batches = [
            missing[i : i + _TASK_CURVES] for i in range(0, len(missing), _TASK_CURVES)
        ]
        fitted = stack.enter_context(
            closing(_fitted(settings, batches, executor, workers))
        )
        for curve in fitted:
            if folder is not None:
                write(to_row(curve))
            done += 1
            _log.info("%d of %d curves", done, len(names))
            yield curve


def read_fitted_curves(file: PathName) -> FittedCurves:
    """Return the results in a file ``curves.csv``.

    Parameters
    ----------
    file : path

    Returns
    -------
    FittedCurves
        A list of `FittedCurve`, with columns by name, `to_pandas` and `figure`.

    Raises
    ------
    ValueError
        If the file is damaged.
    """
    with checked_rows(file) as rows:
        return FittedCurves(from_row(row) for row in rows)


@contextmanager
def _table(
    folder: Path, settings: FitSettings, names: Sequence[CurveName]
) -> Iterator[tuple[list[FittedCurve], Callable[[Mapping[str, str]], None]]]:
    """Yield the results of an earlier run, and a function that writes a further row."""
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / _TABLE_FILE
    with locked(file):
        _check_settings(folder, settings, names)
        found = read_fitted_curves(file) if file.exists() else []
        with table_writer(file, curve_heads(), map(to_row, found)) as write:
            yield found, write


def _check_settings(
    folder: Path, settings: FitSettings, names: Sequence[CurveName]
) -> None:
    """Write the settings and files of a run, or compare them with the earlier run."""
    files = {each.file: Path(each.file) for each in names}
    sizes = [[path.name, path.stat().st_size] for path in files.values()]
    values = {
        key: "inf" if value == math.inf else value
        for key, value in asdict(settings).items()
    }
    given = json.dumps({**values, "files": sizes}, indent=1)
    file = folder / _SETTINGS_FILE
    if not file.exists():
        with replaced(file) as new:
            Path(new).write_text(given, encoding="utf-8")
        return
    old, new = json.loads(file.read_text(encoding="utf-8")), json.loads(given)
    changed = [key for key, value in new.items() if old.get(key) != value]
    if changed:
        raise ValueError(
            f"{folder} has the results of another fit ({', '.join(changed)} differ): "
            "give another folder by --out, or delete it"
        )


def _fitted(
    settings: FitSettings,
    batches: Sequence[Sequence[CurveName]],
    executor: Executor | None,
    workers: int | None,
) -> Generator[FittedCurve, None, None]:
    """Yield the results of batches in their order, from this or other processes."""
    if executor is None and (workers == 1 or len(batches) <= 1):
        for batch in batches:
            yield from (fitted_curve(settings, name) for name in batch)
        return
    with worker_pool(executor, workers) as pool:
        tasks = [pool.submit(fit_batch, settings, batch) for batch in batches]
        try:
            for task in tasks:
                yield from task.result()
        finally:
            for task in tasks:
                task.cancel()


def fit_batch(settings: FitSettings, names: Sequence[CurveName]) -> list[FittedCurve]:
    """Return the results of some curves, the task of a worker.

    Parameters
    ----------
    settings : FitSettings
    names : sequence of CurveName

    Returns
    -------
    list of FittedCurve
    """
    return [fitted_curve(settings, name) for name in names]
