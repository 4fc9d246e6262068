"""Quasi-static load paths: one relaxed state after another, each written at once."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Generator, Sequence
from contextlib import AbstractContextManager
from dataclasses import asdict
from functools import partial
from typing import Any

import numpy as np
from ase import Atoms

from ase_roughcontact._util.files import PathName
from ase_roughcontact._util.validation import lookup, one_of
from ase_roughcontact.atoms.calculator import RoughContact, wall_of
from ase_roughcontact.atoms.grid import SurfaceGrid
from ase_roughcontact.atoms.snapshot import snapshot
from ase_roughcontact.paths.accuracy import accuracy_of
from ase_roughcontact.paths.grids import Grids, grids_for
from ase_roughcontact.paths.hardness import hardness_of_atoms
from ase_roughcontact.paths.output import Write, open_output
from ase_roughcontact.paths.record import LoadStep
from ase_roughcontact.paths.resume import FinishedSteps, PathDescription
from ase_roughcontact.paths.step import Stepper
from ase_roughcontact.paths.validity import ValidityReport
from ase_roughcontact.windows.options import WindowOptions
from ase_roughcontact.windows.regrid import GridChange, lost_text, regrid


def load_path(
    atoms: Atoms,
    penetrations: Sequence[float] | None = None,
    optimizer: Callable[..., Any] | None = None,
    fmax: float | None = None,
    trajectory: PathName | None = None,
    csv: PathName | None = None,
    *,
    heights: Sequence[float] | None = None,
    loads: Sequence[float] | None = None,
    accuracy: str | float = "normal",
    max_steps: int = 10_000,
    window: str | WindowOptions = "fixed",
    edge: str = "raise",
    keep: str = "all",
    resume: bool = False,
    record: type[LoadStep] = LoadStep,
    hardness: float | None = None,
    validity: str = "warn",
    model: str | None = None,
    refine: int | None = None,
    coarsen: int | None = None,
    spacing: str | None = None,
) -> Generator[LoadStep, None, None]:
    """Relax the atoms at one load after another.

    Parameters
    ----------
    atoms : Atoms
        From `substrate`, with a `RoughContact` calculator. They are moved.
    penetrations, heights, loads : sequence of float
        The path, exactly one of: distances that the indenter has moved down since it
        first repels the flat substrate (Å), heights of the indenter (Å), or loads on
        it (eV/Å). The first two need a fixed indenter, loads need a free one.
    optimizer : callable, optional
        Called as ``optimizer(atoms, logfile=None)``; returns an ASE optimizer. A class,
        or a `functools.partial` of one with its options. By default `NewtonKrylov`,
        or `ActiveSet` for a hard wall.
    fmax : float, optional
        Tolerance of the force on every atom (eV/Å), instead of `accuracy`.
    trajectory : path, optional
        ASE trajectory of snapshots, one per step.
    csv : path, optional
        CSV file of the results, one line per step. When a path is resumed, lines of
        steps before those in the trajectory are kept.
    accuracy : {"fast", "normal", "high"} or float
        Allowed relative error of force and area. For the model of atoms it sets a
        tolerance relative to the mean force on the atoms in contact, 1e-4 for each of
        the names. For the continuum the names mean errors of the area of 5, 1 and
        0.2 %, and set grid and extrapolation, too; see `grids_for`.
    max_steps : int
        Maximum number of steps for each run of the optimizer. A step takes several
        runs if its window is enlarged or its tolerance reduced.
    window : {"fixed", "auto"} or WindowOptions
        "fixed" keeps the window of the atoms. "auto", on a free half space, exchanges
        it in place for a small one that contains all atoms that can touch at the step;
        this needs a bounded indenter, such as `RoughSphere`. `WindowOptions` are
        options of automatic windows.
    edge : {"raise", "ignore"}
        What to do if the wall acts on an atom at the edge of a fixed window of a free
        half space, which is probably too small. It is not if the indenter ends there,
        as a flat punch does.
    keep : {"all", "last"}
        Frames that the trajectory keeps. The last one is enough to resume.
    resume : bool
        Resume after the steps that `trajectory` already contains: they are yielded, but
        not calculated, again. The path may have been extended at its end.
    record : type
        Class of the results: `LoadStep`, or a subclass with more columns.
    hardness : float, optional
        Hardness of the substrate, with which pressures are compared (eV/Å^3): infinity
        for a solid that is elastic by intent, NaN if it is not known. By default that
        of the element in `HARDNESS`, if the spacing is that of its crystal and the
        solid is not a `Layer`, and else none.
    validity : {"warn", "raise", "ignore"}
        What to do if a step exceeds a limit of the model: a `ValidityWarning`, once for
        each limit, an error after the step is written, or nothing. In any case the
        column `validity` lists the limits.
    model : {"atoms", "continuum"}, optional
        The question: each grid point is an atom, or the grid is numerical. By default
        the model of atoms, unless a grid is given.
    refine, coarsen : int, optional
        Grid for the continuum, in place of that chosen for the accuracy: exchange the
        grid of the atoms first, in place, for one of the spacing divided by `refine` or
        multiplied by `coarsen`. All else stays, but for the waves of the indenter that
        a coarser grid can't resolve: they are left out, with a warning.
    spacing : str, optional
        The same as a text: ``"a0/2"`` or ``"2 a0"``.

    Yields
    ------
    LoadStep
        After it is written. A step that has not converged is yielded and written too,
        with ``converged=False`` and a message.

    Raises
    ------
    ValueError
        If not exactly one path is given, it is empty or not finite, the indenter's
        constraint does not fit it, a grid is given twice or its spacing is not relative
        to a0, or the trajectory to resume from is damaged or of another path. With a
        trajectory, if the indenter has no `todict`. With automatic windows, if the
        indenter is not bounded, or its roughness not defined where atoms could touch.
    RuntimeError
        If the contact reaches the edge of a fixed window, or another run is writing
        `trajectory`, or has written it since it was read. With ``validity="raise"``, if
        a step exceeds a limit of the model.
    MemoryError
        If an automatic window does not fit into the available memory.
    OSError
        If a file can't be written.
    """
    if resume and trajectory is None:
        raise ValueError("resume=True needs the trajectory to resume from")
    one_of(("all", "last"), keep=keep)
    control, targets = _single_path(
        penetrations=penetrations, heights=heights, loads=loads
    )
    options: dict[str, Any] = {
        "optimizer": optimizer,
        "fmax": fmax,
        "accuracy": accuracy,
        "max_steps": max_steps,
        "window": window,
        "edge": edge,
        "hardness": hardness,
    }
    if spacing is not None and GridChange.of(spacing=spacing) is None:
        raise ValueError(f"spacing must be like 'a0/2' or '2 a0', got {spacing!r}")
    given = GridChange.of(refine, coarsen, spacing)
    if _asks_for_continuum(model, given):
        grids = _grids(atoms, accuracy, window) if given is None else Grids(given)
        options |= _on_grids(atoms, grids, control, options, validity)
    stepper = Stepper(atoms, control, record=record, **options)
    report = ValidityReport(validity)
    system = {} if trajectory is None else stepper.describe_system()
    path = PathDescription(system, control, targets)
    finished = None
    if resume and trajectory is not None:
        finished = path.finished_steps(trajectory, keep, record)
    files = open_output(trajectory, csv, record, keep=keep, finished=finished)
    return _relax(stepper, path, files, finished, report)


def _asks_for_continuum(model: str | None, given: GridChange | None) -> bool:
    if model is None:
        return given is not None
    continuum = lookup(model, {"atoms": False, "continuum": True}, "model")
    if given and not continuum:
        raise ValueError(
            'another grid needs model = "continuum": that of the model of atoms is '
            "their lattice"
        )
    return continuum


def _grids(atoms: Atoms, accuracy: str | float, window: str | WindowOptions) -> Grids:
    """Return the grids that the accuracy needs."""
    grid = SurfaceGrid.of(atoms)
    return grids_for(
        accuracy_of(accuracy, continuum=True).error,
        atoms.calc.parameters["indenter"],
        wall_of(atoms),
        grid.spacing,
        grid.window if window == "fixed" else None,
    )


def _on_grids(
    atoms: Atoms, grids: Grids, control: str, options: dict[str, Any], validity: str
) -> dict[str, Any]:
    """Exchange the grid of atoms; return what a `Stepper` needs to know of it."""
    # before the spacing is no more that of the crystal
    hardness = hardness_of_atoms(atoms, options["hardness"])
    changes: dict[str, Any] = {"hardness": hardness, "continuum": True}
    if grids.extrapolated:
        coarse = atoms.copy()
        coarse.calc = RoughContact(**atoms.calc.parameters)
        regrid(coarse, grids.coarser)
        by_load = "loads" if control == "loads" else "heights"
        changes["coarser"] = Stepper(coarse, by_load, **(options | changes))
    lost = regrid(atoms, grids.change) if grids.change else 0.0
    if lost and validity != "ignore":
        warnings.warn(lost_text(grids.change, lost), stacklevel=3)
    return changes | {"lost_slope": lost}


def _relax(
    stepper: Stepper,
    path: PathDescription,
    files: AbstractContextManager[Write],
    finished: FinishedSteps | None,
    report: ValidityReport,
) -> Generator[LoadStep, None, None]:
    """Yield the steps of a path, and write those that are not done yet."""
    first = 0
    with files as write:
        for step in finished.steps if finished else ():
            report(step.step, step.validity)
            yield step
        if finished and finished.frame:
            first = finished.steps[-1].step + 1
            stepper.restart_from(finished.frame, path.targets[:first].tolist())
        for number in range(first, len(path.targets)):
            step = stepper.step(number, path.targets[number])
            write(step, partial(_frame, stepper.atoms, step, path))
            report(number, step.validity)
            yield step


def _frame(atoms: Atoms, step: LoadStep, path: PathDescription) -> Atoms:
    """Return the frame of a step for the trajectory."""
    info = {"load_step": asdict(step), "path": path.of_step(step.step)}
    return snapshot(atoms, **info)


def _single_path(**paths: Sequence[float] | None) -> tuple[str, np.ndarray]:
    """Return control and targets of the only path that is not None."""
    given = {name: path for name, path in paths.items() if path is not None}
    if len(given) != 1:
        raise ValueError(
            f"give exactly one of {', '.join(paths)}; got {', '.join(given) or 'none'}"
        )
    ((control, path),) = given.items()
    try:
        targets = np.asarray(path, dtype=float)
    except (TypeError, ValueError, OverflowError):
        targets = np.array(np.nan)
    if targets.ndim != 1 or targets.size == 0 or not np.isfinite(targets).all():
        raise ValueError(f"{control} must be a sequence of finite numbers, got {path}")
    return control, targets
