"""Task of a worker: the missing load steps of one case."""

from __future__ import annotations

import itertools
import os
import threading
from collections.abc import Container, Generator, Iterator, Sequence
from contextlib import closing
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ase_roughcontact._util.threads import available_threads, threads
from ase_roughcontact.ensemble.cases import case_of
from ase_roughcontact.ensemble.columns import (
    case_columns,
    scene_columns,
    step_columns,
)
from ase_roughcontact.ensemble.database import EnsembleDatabase
from ase_roughcontact.ensemble.progress import WHOLE, is_whole
from ase_roughcontact.results.limits import exceeded_names
from ase_roughcontact.results.record import LoadStep
from ase_roughcontact.scene import Scene


def calculate_case(
    database: EnsembleDatabase,
    run: str,
    case: str,
    scene: Scene,
    steps: Sequence[int],
) -> tuple[str, str]:
    """Calculate the missing load steps of a case, and store each at once.

    Parameters
    ----------
    database : EnsembleDatabase
        The database.
    run : str
        Name that is locked as long as the run continues.
    case : str
        Name of the case.
    scene : Scene
        Scene of the case.
    steps : sequence of int
        Load steps to calculate, in increasing order; `WHOLE` alone for a whole path
        and its results.

    Returns
    -------
    state : {"done", "failed", "stopped", "busy"}
        "stopped" if the lock of the run is free, "busy" if another worker calculates
        the case.
    message : str
        Reason why the case failed; otherwise empty.
    """
    restart = database.checkpoint(case)
    data = {"scene": scene.entries()}
    with database.lock(case) as free:
        if not free:
            return "busy", ""
        stored = {step for _, step in database.steps(case=case).values()}
        state, message, found = "done", "", list[LoadStep]()
        values = dict[str, Any]()
        try:
            if case_of(scene) != case:
                raise ValueError(
                    f"{', '.join(scene.files)}: changed since the ensemble began, or "
                    "not the same on this machine: start the ensemble again"
                )
            relaxed = _relax(scene, steps, stored, restart)
            with threads(_threads()), closing(relaxed) as records:
                while database.is_locked(run):
                    record = next(records, None)
                    if record is None:
                        break
                    found.append(record)
                    if record.step not in stored:
                        row = step_columns(case, scene, record)
                        database.add_steps([row], data, case=case, step=record.step)
                else:
                    return "stopped", ""
            if is_whole(scene):
                values = case_columns(scene, found)
            if restart is not None:
                restart.unlink(missing_ok=True)
        except Exception as error:
            state, message = "failed", f"{type(error).__name__}: {error}"
            values = {"message": message}
        values = scene_columns(scene) | values | _counted(database, case)
        database.set_state(case, state, data, **values)
    return state, message


def _counted(database: EnsembleDatabase, case: str) -> dict[str, Any]:
    """Return the numbers of stored and of unconverged steps, and exceeded limits."""
    rows = list(database.select(case=case))
    limits = exceeded_names(row.get("validity", "") for row in rows)
    return {
        "steps": len(rows),
        "unconverged": sum(not row.converged for row in rows),
        "validity": "; ".join(limits),
    }


def _threads() -> int:
    """Return the number of threads for a case: one if cases run in threads."""
    one_case = threading.current_thread() is threading.main_thread()
    return available_threads() if one_case or os.environ.get("OMP_NUM_THREADS") else 1


def _relax(
    scene: Scene,
    wanted: Sequence[int],
    stored: Container[int],
    restart: Path | None,
) -> Generator[LoadStep, None, None]:
    """Relax the wanted steps that are not stored, and those on which they depend.

    A whole path has all its steps, also those that are stored or in the restart file.
    Without a restart file, steps that do not depend on others are relaxed alone.
    """
    if list(wanted) == [WHOLE]:
        yield from _resume(scene, restart)
        return
    missing = [step for step in wanted if step not in stored]
    if not missing:
        return
    if scene.is_in_order:
        numbered: Iterator[tuple[int, LoadStep]] = enumerate(_resume(scene, restart))
    else:  # each step has one solution, whatever came before
        if restart is None or (len(missing) < len(wanted) and not restart.exists()):
            wanted, restart = missing, None
        targets = scene.targets[list(wanted)]
        numbered = zip(wanted, _resume(scene, restart, targets), strict=True)
    for number, record in numbered:
        if number in missing:
            yield replace(record, step=number)
        if number == missing[-1]:
            return


def _resume(
    scene: Scene, restart: Path | None, targets: np.ndarray | None = None
) -> Iterator[LoadStep]:
    """Follow a path, from its restart file if there is one of this path."""
    relax = partial(scene.relax, targets, validity="ignore")  # the rows have the column
    if restart is None:
        return relax()
    steps = relax(restart=restart, resume=True)
    try:
        first = next(steps)
    except ValueError:  # it is damaged, or of another path
        return relax(restart=restart)
    return itertools.chain([first], steps)
