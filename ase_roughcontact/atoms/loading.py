"""Load paths of atoms: one relaxed state after another."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from contextlib import closing
from dataclasses import replace
from typing import Any

import numpy as np
from ase import Atoms
from ase.constraints import Hookean

from ase_roughcontact._util.files import PathName
from ase_roughcontact._util.validation import lookup, one_of
from ase_roughcontact.atoms.calculator import RoughContact
from ase_roughcontact.atoms.exchange import regrid
from ase_roughcontact.atoms.grid import SurfaceGrid
from ase_roughcontact.atoms.indenter import indenter_fixed
from ase_roughcontact.atoms.model import problem_for
from ase_roughcontact.atoms.path_atoms import PathAtoms, relaxer_of
from ase_roughcontact.atoms.plastic_shape import kept_depth
from ase_roughcontact.contact import Problem
from ase_roughcontact.optimize.constraints import Indenter
from ase_roughcontact.paths.accuracy import accuracy_of
from ase_roughcontact.paths.grids import grid_for
from ase_roughcontact.paths.hardness import hardness_for
from ase_roughcontact.paths.loading import (
    PathFiles,
    follow_path,
    targets_of,
    warn_of_lost_slope,
)
from ase_roughcontact.paths.record import LoadStep
from ase_roughcontact.paths.step import CONTROLS, StepOptions, Stepper
from ase_roughcontact.solvers.relaxation import SolverRelaxer
from ase_roughcontact.windows.options import WindowOptions
from ase_roughcontact.windows.regrid import GridChange


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
        0.2 %, and set the grid, too; see `grid_for`.
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
        `trajectory`. With ``validity="raise"``, if a step exceeds a limit of the model.
    MemoryError
        If an automatic window does not fit into the available memory.
    OSError
        If a file can't be written.
    """
    files = PathFiles(trajectory, csv, keep, resume)
    control, targets = _single_path(
        penetrations=penetrations, heights=heights, loads=loads
    )
    if spacing is not None and GridChange.of(spacing=spacing) is None:
        raise ValueError(f"spacing must be like 'a0/2' or '2 a0', got {spacing!r}")
    given = GridChange.of(refine, coarsen, spacing)
    one_of(("warn", "raise", "ignore"), validity=validity)
    path = AtomsPath(
        atoms,
        control,
        optimizer,
        grid=given,
        continuum=_asks_for_continuum(model, given),
        fmax=fmax,
        accuracy=accuracy,
        max_steps=max_steps,
        window=window,
        edge=edge,
        hardness=hardness,
        record=record,
    )
    warn_of_lost_slope(path.stepper, path.change, validity)
    files = replace(files, frames=path.frames)
    steps = follow_path(path.stepper, targets, files, validity, springs=path.springs)
    return _shown(path, steps)


class AtomsPath:
    """Path of atoms: what relaxes its steps, and the atoms that follow it.

    Parameters
    ----------
    atoms : Atoms
        With a `RoughContact` calculator. They are moved.
    control : {"penetrations", "heights", "loads"}
    optimizer : callable, optional
    grid : GridChange, optional
    continuum : bool
        Whether the continuum is asked for, and not the model of atoms.
    hardness : float, optional
    **options
        Of `StepOptions`. For all of them see `load_path`.

    Attributes
    ----------
    frames : PathAtoms
    stepper : Stepper
    change : GridChange or None
        Grid of the continuum.
    springs : list of dict
        Description of the springs on the indenter.
    """

    def __init__(
        self,
        atoms: Atoms,
        control: str,
        optimizer: Callable[..., Any] | None = None,
        *,
        grid: GridChange | None = None,
        continuum: bool = False,
        hardness: float | None = None,
        **options: Any,
    ) -> None:
        _check(atoms, control)
        lattice = SurfaceGrid.of(atoms)
        problem = problem_for(lattice, atoms.calc.parameters)
        self.change = grid
        if continuum and grid is None:
            self.change = _grid(problem, lattice, options)
        springs = [c for c in atoms.constraints if isinstance(c, Hookean)]
        self.springs = [_describe_spring(spring) for spring in springs]
        settings = StepOptions(
            # before the spacing is no more that of the crystal
            hardness=hardness_for(problem, atoms.symbols[0], hardness),
            continuum=continuum,
            **options,
        )
        external = Indenter(atoms).springs_at if springs else None
        lost = 0.0
        if self.change:
            if kept_depth(atoms, lattice) is not None:
                raise ValueError(
                    "the surface has kept a plastic shape, which another grid would "
                    "lose: start from new atoms"
                )
            lost = regrid(atoms, self.change)
        self.frames = PathAtoms(atoms)
        pulled = bool(springs) and control == "loads"
        relaxer = relaxer_of(optimizer, problem.wall, self.frames, pulled)
        if isinstance(relaxer, SolverRelaxer):
            Indenter(atoms)  # raises for constraints that only optimizers of ASE honour
        self.stepper = Stepper(
            self.frames.problem,
            control,
            self.frames.first_state(),
            replace(settings, relaxer=relaxer, lost_slope=lost),
            springs=external,
        )

    def begin(self) -> None:
        """Start from the atoms as they are now."""
        self.stepper.state = self.frames.first_state()

    def show(self) -> None:
        """Move the atoms to the last state, with its results."""
        self.frames.show(self.stepper)


def _shown(
    path: AtomsPath, steps: Generator[LoadStep, None, None]
) -> Generator[LoadStep, None, None]:
    """Yield the steps of a path, each with the atoms in its state.

    After an error the atoms are in the last relaxed state.
    """
    path.begin()
    before = None
    with closing(steps):
        try:
            for step in steps:
                if path.stepper.run is not before:
                    path.show()
                    before = path.stepper.run
                yield step
        except Exception:
            path.show()
            raise
        if path.stepper.run is not before:  # nothing was left to do
            path.show()


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


def _grid(
    problem: Problem, lattice: SurfaceGrid, options: dict[str, Any]
) -> GridChange:
    """Return the grid that the accuracy needs."""
    return grid_for(
        accuracy_of(options.get("accuracy", "normal"), continuum=True).error,
        problem.indenter,
        problem.wall,
        problem.spacing,
        lattice.window if options.get("window") == "fixed" else None,
    )


def _describe_spring(spring: Hookean) -> dict[str, Any]:
    """Return stiffness, length and height of the end; x and y move with windows."""
    parameters = spring.todict()["kwargs"]
    end = np.ravel(parameters["a2"]).tolist()[2:]
    return {"k": parameters["k"], "rt": parameters["rt"], "end": end}


def _check(atoms: Atoms, control: str) -> None:
    one_of(CONTROLS, control=control)
    if not isinstance(atoms.calc, RoughContact):
        raise ValueError(f"a path needs a RoughContact calculator, got {atoms.calc}")
    fixed = indenter_fixed(atoms)
    if fixed and control == "loads":
        raise ValueError(
            "loads need an indenter that is free to move, but it is fixed: build the "
            "atoms with substrate(..., fixed=False)"
        )
    if not fixed and control != "loads":
        raise ValueError(
            f"{control} need a fixed indenter, but it is free: constrain it with "
            "ase.constraints.FixAtoms, or build the atoms with "
            "substrate(..., fixed=True)"
        )


def _single_path(**paths: Sequence[float] | None) -> tuple[str, np.ndarray]:
    """Return control and targets of the only path that is not None."""
    given = {name: path for name, path in paths.items() if path is not None}
    if len(given) != 1:
        raise ValueError(
            f"give exactly one of {', '.join(paths)}; got {', '.join(given) or 'none'}"
        )
    ((control, path),) = given.items()
    return control, targets_of(control, path)
