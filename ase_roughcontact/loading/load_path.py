"""Load paths of atoms: one relaxed state after another."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import closing
from dataclasses import replace
from typing import Any

import numpy as np
from ase import Atoms
from ase.constraints import Hookean
from numpy.typing import ArrayLike

from ase_roughcontact._util.keywords import suggesting
from ase_roughcontact._util.lazy import lazy
from ase_roughcontact._util.validation import instance_of
from ase_roughcontact.atoms.calculator import problem_of
from ase_roughcontact.atoms.constraints import support_of
from ase_roughcontact.atoms.exchange import regrid
from ase_roughcontact.atoms.grid import SurfaceGrid
from ase_roughcontact.atoms.history import history_of
from ase_roughcontact.atoms.sticking import check_released, indenter_fixed
from ase_roughcontact.atoms.substrate import set_support
from ase_roughcontact.contact.control import BASE, LOAD, Control, control_of
from ase_roughcontact.loading.path_atoms import PathAtoms, relaxer_of
from ase_roughcontact.paths.follow import follow_states
from ase_roughcontact.paths.output import Output, OutputLike
from ase_roughcontact.paths.path_steps import NumberedSteps, PathSteps, targets_of
from ase_roughcontact.results.record import LoadStep
from ase_roughcontact.results.validity import (
    Reaction,
    Validity,
    hardness_bound_for,
    hardness_for,
    warn_of_lost_slope,
)
from ase_roughcontact.solvers.relaxation import SolverRelaxer
from ase_roughcontact.stepping.accuracy import Accuracy, GridModel
from ase_roughcontact.stepping.options import StepOptions, Window
from ase_roughcontact.stepping.relaxed import RelaxedStep
from ase_roughcontact.stepping.step import Stepper


@lazy
@suggesting
def load_path(
    atoms: Atoms,
    *,
    penetrations: ArrayLike | None = None,
    heights: ArrayLike | None = None,
    loads: ArrayLike | None = None,
    optimizer: Callable[..., Any] | None = None,
    fmax: float | None = None,
    accuracy: Accuracy = "normal",
    max_steps: int = 10_000,
    window: Window = "fixed",
    grid: str = "atoms",
    validity: Reaction | Validity = "warn",
    output: OutputLike | None = None,
) -> Generator[LoadStep, None, None]:
    """Relax the atoms at one load after another.

    Parameters
    ----------
    atoms : Atoms
        Atoms from `substrate`, with a `RoughContact` calculator. They are moved, and
        the indenter is fixed or freed unless they were built with `fixed`.
    penetrations, heights, loads : array_like, shape (steps,), or float
        The path, exactly one of: distances that the indenter has moved down since it
        first repels the flat substrate (Å), heights of the indenter (Å), or loads on
        it (eV/Å). The first two need a fixed indenter, loads need a free one. A step up
        from an adhesive contact is made in parts of at most half the range of the
        attraction.
    optimizer : callable, optional
        Function called as ``optimizer(atoms, logfile=None)`` that returns an ASE
        optimizer: a class, or a `functools.partial` of one with its options. A class of
        ASE also gets the options of `settings_for`. By default `NewtonKrylov`, or
        `ActiveSet` for a hard wall.
    fmax : float, optional
        Tolerance of the force on every atom (eV/Å), instead of `accuracy`. Steps with
        an error of force or area by it above 1 % are marked; see `fmax_for`.
    accuracy : {"fast", "normal", "high"} or float
        Allowed relative error of force and area. For the model of atoms it sets a
        tolerance relative to the mean force on the atoms in contact, 1e-4 for each of
        the names. For the continuum the names mean errors of the area of 5, 1 and
        0.2 %, and set the grid, too; see `grid_for`.
    max_steps : int
        Maximum number of steps for each run of the optimizer. A step takes several
        runs if its window is enlarged or its tolerance reduced.
    window : {"fixed", "unchecked", "auto"}
        "fixed" keeps the window of the atoms; that the wall acts on an atom at the edge
        of it in a free half space is an error, as the window is probably too small. It
        is not if the indenter ends there, as a flat punch does: "unchecked". "auto", on
        a free half space, exchanges the window in place for a small one that contains
        all atoms that can touch at the step; this needs a bounded indenter, such as
        `RoughSphere`.
    grid : str
        "atoms": each grid point is an atom. Otherwise the grid is numerical, and the
        continuum is asked for: on a spacing relative to the spacing of the atoms, such
        as ``"a0/2"`` or ``"2 a0"``, or with "continuum" on the one that the accuracy
        needs. The grid of the atoms is exchanged first, in place. All else stays, but
        for the waves of the indenter that a coarser grid can't resolve: they are left
        out, with a warning.
    validity : {"warn", "raise", "ignore"} or Validity
        Reaction to a step that exceeds a limit of the model; `Validity` has the
        hardness of the substrate, too.
    output : Output or path, optional
        Files (CSV, trajectory), resuming from them, and columns of your own. A path is
        a folder for all files, from which the path is resumed; see `Output.of`.

    Yields
    ------
    LoadStep
        Result of a step, after it is written. A step that has not converged is yielded
        and written too, with ``converged=False`` and a message.

    Raises
    ------
    ValueError
        If not exactly one path is given, it is empty or not finite, the indenter's
        constraint does not fit it, the grid is unknown, or the trajectory to resume
        from is damaged or of another path. With a trajectory, if the indenter has no
        `todict`. With automatic windows, if the
        indenter is not bounded, or its roughness not defined where atoms could touch.
    RuntimeError
        If the contact reaches the edge of a fixed window, or another run is writing the
        trajectory. With ``validity="raise"``, if a step exceeds a limit of the model.
    MemoryError
        If an automatic window does not fit into the available memory.
    OSError
        If a file can't be written.

    Examples
    --------
    >>> from ase_roughcontact import RoughContact, RoughSphere, load_path, substrate
    >>> sphere = RoughSphere(radius=200.0)
    >>> atoms = substrate('Cu', (8, 8), sphere, fixed=False)
    >>> atoms.calc = RoughContact(sphere, contact_modulus=0.9)
    >>> for step in load_path(atoms, loads=[1.0, 10.0], window='auto'):
    ...     print(f'{step.normal_force:.1f} {step.repulsive_atoms} {step.converged}')
    1.0 21 True
    10.0 89 True
    """
    name, path_of_control = single_path(
        penetrations=penetrations, heights=heights, loads=loads
    )
    control = control_of(name)
    targets = targets_of(control, path_of_control)
    path = AtomsPath(
        atoms,
        control,
        optimizer,
        grid=grid,
        validity=validity,
        output=output,
        fmax=fmax,
        accuracy=accuracy,
        max_steps=max_steps,
        window=window,
    )
    return path.follow(NumberedSteps(path.stepper, targets))


class AtomsPath:
    """Path of atoms: what relaxes its steps, and the atoms that follow it.

    Parameters
    ----------
    atoms : Atoms
        Atoms with a `RoughContact` calculator. They are moved.
    control : Control
    optimizer, grid, accuracy, validity, output
        See `load_path`.
    **options
        Options of `StepOptions`; see `load_path`.

    Attributes
    ----------
    stepper : Stepper
    """

    def __init__(
        self,
        atoms: Atoms,
        control: Control,
        optimizer: Callable[..., Any] | None = None,
        *,
        grid: str = "atoms",
        accuracy: Accuracy = "normal",
        validity: Reaction | Validity = "warn",
        output: OutputLike | None = None,
        **options: Any,
    ) -> None:
        validity = Validity(validity) if isinstance(validity, str) else validity
        instance_of(Validity, validity=validity)
        output = Output.of(output)
        self._action = validity.action
        problem, window = problem_of(atoms)
        _set_support(atoms, control)
        symbol = atoms.symbols[0]
        model = GridModel.of(grid, accuracy)
        settings = StepOptions(
            # before the spacing differs from the crystal
            hardness=hardness_for(problem, symbol, validity.hardness),
            hardness_bound=hardness_bound_for(problem, symbol, validity.hardness),
            yield_strength=validity.yield_strength,
            accuracy=accuracy,
            continuum=model.is_continuum,
            **options,
        )
        springs = [c for c in atoms.constraints if isinstance(c, Hookean)]
        described = [spring.todict()["kwargs"] for spring in springs]
        self._springs = [  # x and y of their ends move with windows
            {"k": s["k"], "rt": s["rt"], "end": np.ravel(s["a2"]).tolist()[2:]}
            for s in described
        ]
        external = support_of(atoms).springs if springs else None
        lost = 0.0
        shape = window.shape if settings.keeps_window else None
        change = model.grid(problem.indenter, problem.wall, problem.spacing, shape)
        if change:
            if history_of(atoms, SurfaceGrid.of(atoms)):
                raise ValueError(
                    "the surface has kept a plastic shape, creep or friction, which "
                    "another grid would lose: start from new atoms"
                )
            lost = regrid(atoms, change, settings.keeps_window)
            warn_of_lost_slope(lost, change, self._action)
        self._frames = PathAtoms(atoms)
        pulled = (bool(springs) and control == LOAD) or control == BASE
        relaxer = relaxer_of(optimizer, problem.wall, self._frames, pulled)
        if isinstance(relaxer, SolverRelaxer):
            # raises for constraints that only optimizers of ASE honour
            support_of(atoms)
        self.stepper = Stepper(
            self._frames.problem,
            control,
            self._frames.first_state(),
            replace(settings, relaxer=relaxer, lost_slope=lost),
            springs=external,
        )
        self._output = replace(output, frames=self._frames)

    def follow(
        self, steps: PathSteps, **description: Any
    ) -> Generator[Any, None, None]:
        """Return the steps of a path, each with the atoms in its state.

        Parameters
        ----------
        steps : PathSteps
            Steps of the path, made with `stepper`.
        **description
            Parameters of a state beside the path, such as a cantilever.

        Returns
        -------
        generator of LoadStep
            The results. After an error the atoms are in the last relaxed state.
        """
        description["springs"] = self._springs
        found = follow_states(
            steps, self._output, self._action, self._frames.first_state, **description
        )
        return self._with_atoms(found)

    def _with_atoms(
        self, steps: Generator[tuple[Any, RelaxedStep | None], None, None]
    ) -> Generator[Any, None, None]:
        reached: RelaxedStep | None = None
        try:
            with closing(steps):
                for record, reached in steps:
                    if reached:
                        self._frames.show(reached)
                    yield record
        except Exception:
            if reached:
                self._frames.show(reached)
            else:
                self._frames.show_first()
            raise


def _set_support(atoms: Atoms, control: Control) -> None:
    """Fix or free the indenter for a path, or raise `ValueError` if it can't be."""
    check_released(atoms)
    was_fixed = indenter_fixed(atoms)
    set_support(atoms, fixed=not control.free)
    fixed, free = indenter_fixed(atoms), control.free
    if fixed and not was_fixed:
        atoms.calc.set(load=0.0)  # of an earlier path
    if fixed and free:
        raise ValueError(
            f"{control.plural} need an indenter that is free to move, but it is fixed: "
            "remove its constraint, or build the atoms without fixed=True"
        )
    if not (fixed or free):
        raise ValueError(
            f"{control.plural} need a fixed indenter, but it is free: constrain it by "
            "FixAtoms, or build the atoms without fixed=False"
        )


def single_path(**paths: Any) -> tuple[str, Any]:
    """Return name and value of the only path that is not None."""
    given = {name: path for name, path in paths.items() if path is not None}
    if len(given) != 1:
        raise ValueError(
            f"give exactly one of {', '.join(paths)}; got {', '.join(given) or 'none'}"
        )
    ((control, path),) = given.items()
    return control, path
