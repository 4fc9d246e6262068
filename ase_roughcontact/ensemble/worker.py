"""What a worker does: calculate what is missing of one case."""

from __future__ import annotations

import itertools
import os
import threading
from collections.abc import Generator, Iterator
from contextlib import closing, contextmanager
from dataclasses import replace
from pathlib import Path

from ase_roughcontact._util.kernels import available_threads, threads
from ase_roughcontact.ensemble.ledger import Claim, Ledger
from ase_roughcontact.paths.record import LoadStep
from ase_roughcontact.scene import Scene


def calculate(ledger: Ledger, case: str, scene: Scene, file: Path | None) -> None:
    """Calculate what is missing of a case, unless another worker does.

    Parameters
    ----------
    ledger : Ledger
    case : str
        Name of the case.
    scene : Scene
    file : path or None
        For the last frame of a path whose steps depend on those before them.
    """
    claim = ledger.claim(case, scene)
    if claim is None:
        return
    state, message = "waiting", ""
    try:
        with _heartbeat(ledger, claim), threads(_share()):
            with closing(_relaxed(claim, file)) as steps:
                if all(ledger.write(claim, record) for record in steps):
                    state = "done"
            if state == "done" and file is not None:
                file.unlink(missing_ok=True)
    except Exception as error:
        state, message = "failed", f"{type(error).__name__}: {error}"
    finally:
        ledger.renew(claim, state=state, message=message)


@contextmanager
def _heartbeat(ledger: Ledger, claim: Claim) -> Iterator[None]:
    """Tell that the worker lives, as long as a step may take."""
    over = threading.Event()

    def beat() -> None:
        while not over.wait(ledger.lease / 4.0):
            ledger.renew(claim)

    thread = threading.Thread(target=beat, daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


def _relaxed(claim: Claim, file: Path | None) -> Generator[LoadStep, None, None]:
    """Relax the steps that are missing, and those that they depend on."""
    scene, missing = claim.scene, claim.missing
    if not missing:
        return
    if not scene.wall.attractive:  # one state, however it is come by
        records = scene.relax(scene.steps[missing])
        for number, record in zip(missing, records, strict=True):
            yield replace(record, step=number)
    else:
        for record in _resumed(scene, missing[0], file):
            if record.step in missing:
                yield record


def _share() -> int:
    """Threads for a case: one where cases are threads of this process themselves."""
    alone = threading.current_thread() is threading.main_thread()
    return available_threads() if alone or os.environ.get("OMP_NUM_THREADS") else 1


def _resumed(scene: Scene, first: int, file: Path | None) -> Iterator[LoadStep]:
    """Follow the path from the frame in a file, if it is not beyond a first step."""
    if file is None:
        return scene.relax()
    file.parent.mkdir(parents=True, exist_ok=True)
    try:
        steps = scene.relax(trajectory=file, keep="last", resume=True)
        record = next(steps)
    except ValueError:  # not a frame of this path, or a path that fails again below
        pass
    except RuntimeError:  # a worker that was taken for dead still writes the file
        return scene.relax()
    else:
        if record.step <= first:
            return itertools.chain([record], steps)
    return scene.relax(trajectory=file, keep="last")
