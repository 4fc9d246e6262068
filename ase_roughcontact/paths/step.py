"""One step of a quasi-static path: set the target, choose the window, relax."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from typing import Any

from ase import Atoms

from ase_roughcontact._util.validation import integer, one_of, positive, shown
from ase_roughcontact.atoms.calculator import RoughContact, contact_of, indent
from ase_roughcontact.atoms.grid import SurfaceGrid
from ase_roughcontact.atoms.indenter import indenter_fixed
from ase_roughcontact.atoms.plastic_shape import set_kept_depth
from ase_roughcontact.atoms.snapshot import kept_depth_of, restore
from ase_roughcontact.optimize import default_optimizer
from ase_roughcontact.optimize.base import ContactOptimizer, Start
from ase_roughcontact.paths.accuracy import ForceTolerance, accuracy_of
from ase_roughcontact.paths.extrapolation import Extrapolation
from ase_roughcontact.paths.hardness import hardness_of_atoms
from ase_roughcontact.paths.record import LoadStep
from ase_roughcontact.paths.relaxed import RelaxedStep, SolverStatistics
from ase_roughcontact.paths.resume import describe_system
from ase_roughcontact.windows.auto import AutoWindow
from ase_roughcontact.windows.exchange import exchange_window, window_of
from ase_roughcontact.windows.fixed import FixedWindow
from ase_roughcontact.windows.options import WindowOptions

CONTROLS = ("penetrations", "heights", "loads")
# A load counts as not carried if rounding leaves more than this part of it.
_UNCARRIED_PART = 0.1


class Stepper:
    """Relaxes atoms at one target after another, each from the last relaxed state.

    Parameters
    ----------
    atoms : Atoms
        From `substrate`, with a `RoughContact` calculator. They are moved.
    control : {"penetrations", "heights", "loads"}
        Meaning of the targets; see `load_path`.
    optimizer, fmax, accuracy, max_steps, window, edge, hardness, record
        See `load_path`.
    continuum : bool
        Whether the continuum is asked for, and not the model of atoms.
    lost_slope : float
        Part of the rms slope that the grid can't resolve, and that is lost.
    coarser : Stepper, optional
        Of the same contact on a grid of twice the spacing, from whose area that of the
        continuum is extrapolated. Its targets are heights or loads.

    Raises
    ------
    ValueError
        If a parameter is not valid, or the indenter's constraint does not fit the
        control.
    """

    def __init__(
        self,
        atoms: Atoms,
        control: str,
        optimizer: Callable[..., Any] | None = None,
        *,
        fmax: float | None = None,
        accuracy: str | float = "normal",
        max_steps: int = 10_000,
        window: str | WindowOptions = "fixed",
        edge: str = "raise",
        hardness: float | None = None,
        record: type[LoadStep] = LoadStep,
        continuum: bool = False,
        lost_slope: float = 0.0,
        coarser: Stepper | None = None,
    ) -> None:
        _check(atoms, control, window, edge)
        if not (optimizer is None or callable(optimizer)):
            raise ValueError(
                "optimizer must be a class, or a function called as optimizer(atoms, "
                f"logfile=None), got {shown(optimizer)}"
            )
        if fmax is not None:
            positive(fmax=fmax)
        self.atoms = atoms
        self.control = control
        self._fmax = fmax
        self._accuracy = accuracy_of(accuracy, continuum)
        self._max_steps = integer("max_steps", max_steps, 1)
        self._record = record
        self._continuum, self._lost_slope = continuum, lost_slope
        self._coarser = coarser
        self._extrapolation = Extrapolation()
        contact = contact_of(atoms)
        self._hardness = hardness_of_atoms(atoms, hardness)
        self._optimizer = optimizer or default_optimizer(contact.interaction)
        self._tolerance = ForceTolerance(
            self._accuracy.tolerance,
            contact.halfspace.contact_modulus * contact.halfspace.cell_area,
        )
        self.windows: AutoWindow | FixedWindow
        if window == "fixed" or atoms.pbc.any():
            self.windows = FixedWindow(atoms, edge)
        else:
            options = window if isinstance(window, WindowOptions) else WindowOptions()
            self.windows = AutoWindow(atoms, options)

    def step(self, number: int, target: float) -> LoadStep:
        """Relax the atoms at a target, in windows enlarged until they suffice.

        Parameters
        ----------
        number : int
            Number of the step, for its result.
        target : float
            Penetration or height (Å), or load (eV/Å).

        Returns
        -------
        LoadStep
        """
        relaxed = self._relaxed(number, target)
        record = self._record.of(relaxed)
        self._indent(relaxed)
        return record

    def _indent(self, relaxed: RelaxedStep) -> None:
        """Leave the plastic shape of a step in the surface, if the wall does."""
        if relaxed.contact.interaction.permanent:
            indent(self.atoms)

    def _relaxed(self, number: int, target: float) -> RelaxedStep:
        begun = time.perf_counter()
        statistics = SolverStatistics()
        self._set_target(target)
        self.windows.choose(self.atoms, self.control)
        start = None
        if target or self.control != "loads":  # without a load nothing holds a sphere
            start = self._extrapolation.start(contact_of(self.atoms), target)
        self._relax(statistics, start)
        while self.windows.enlarge_if_needed(self.atoms):
            self._relax(statistics)
        self._check_load(target, statistics)
        coarse_area = None
        if self._coarser:
            coarse = self._coarser_step(self._coarser, number, target)
            coarse_area = coarse.state.contact_area
            grids = coarse.halfspace.grid, contact_of(self.atoms).halfspace.grid
            share = math.prod(grids[0]) / math.prod(grids[1])
            statistics.pairs += share * coarse.statistics.pairs
            if not coarse.statistics.converged:
                statistics.converged = False
                statistics.message = f"coarser grid: {coarse.statistics.message}"
        relaxed = RelaxedStep(
            atoms=self.atoms,
            number=number,
            first_contact=self.windows.first_contact,
            statistics=statistics,
            seconds=time.perf_counter() - begun,
            hardness=self._hardness,
            control=self.control,
            continuum=self._continuum,
            lost_slope=self._lost_slope,
            coarse_area=coarse_area,
        )
        if statistics.converged:
            state, height = relaxed.state, relaxed.height
            self._extrapolation.add(relaxed.contact, target, state, height)
        return relaxed

    def restart_from(self, frame: Atoms, targets: Sequence[float] = ()) -> None:
        """Move the atoms to the state of a frame, as if a step had ended there.

        Parameters
        ----------
        frame : Atoms
            From `snapshot`.
        targets : sequence of float
            Of the steps up to the frame. They are repeated on the coarser grid, which
            is not in the frame, if its state depends on them.
        """
        if self._coarser and contact_of(self.atoms).interaction.depends_on_history:
            for number, target in enumerate(targets):
                self._set_target(target)
                self._coarser_step(self._coarser, number, target)
        atoms, self._extrapolation = self.atoms, Extrapolation()
        if isinstance(self.windows, AutoWindow):
            exchange_window(atoms, window_of(SurfaceGrid.of(frame)))
            atoms.positions = frame.positions
        else:
            restored = restore(frame, contact_of(atoms).halfspace.solid)
            atoms.positions = restored.positions
        set_kept_depth(atoms, SurfaceGrid.of(atoms), kept_depth_of(frame))
        self.windows.accept(atoms)

    def describe_system(self) -> dict[str, Any]:
        """Describe all that a state depends on except height, load and displacement.

        Returns
        -------
        dict
            Numbers, strings, lists and dicts as a JSON file returns them.

        Raises
        ------
        ValueError
            If something can't be described, such as an indenter without `todict`.
        """
        tolerance = {"accuracy": self._accuracy.error}
        if self._fmax is not None:
            tolerance = {"fmax": self._fmax}
        question: dict[str, Any] = {}
        if self._continuum:
            question = {"model": "continuum", "extrapolated": bool(self._coarser)}
        lattice = self.windows.describe_lattice()
        return describe_system(self.atoms, lattice=lattice, **tolerance, **question)

    def _coarser_step(
        self, coarser: Stepper, number: int, target: float
    ) -> RelaxedStep:
        """Relax the contact on the coarser grid, at the same height or load."""
        if self.control != "loads":
            target = float(self.atoms.positions[-1, 2])
        relaxed = coarser._relaxed(number, target)
        coarser._indent(relaxed)  # energy, forces and areas do not change
        return relaxed

    def _set_target(self, target: float) -> None:
        atoms, first_contact = self.atoms, self.windows.first_contact
        if self.control == "loads":
            atoms.calc.set(load=float(target))
            # out of contact nothing but the load acts, and some optimizers divide by 0
            atoms.positions[-1, 2] = min(atoms.positions[-1, 2], first_contact)
        elif self.control == "heights":
            atoms.positions[-1, 2] = target
        else:
            atoms.positions[-1, 2] = first_contact - target

    def _relax(self, statistics: SolverStatistics, start: Start | None = None) -> None:
        """Relax the atoms to the tolerance that the relaxed state requires."""
        if self._fmax:
            self._run_optimizer(statistics, self._fmax, start)
            return
        load = self.atoms.calc.parameters["load"]
        tolerance: float | None = self._tolerance.expected(load)
        while tolerance is not None:
            self._run_optimizer(statistics, tolerance, start)
            start = None
            state = self.atoms.calc.state(self.atoms)
            tolerance = self._tolerance.reduced(tolerance, state)
            if not statistics.converged:
                return

    def _run_optimizer(
        self, statistics: SolverStatistics, tolerance: float, start: Start | None
    ) -> None:
        """Run the optimizer once, and add its cost to the statistics."""
        optimizer = self._optimizer(self.atoms, logfile=None)
        if start and isinstance(optimizer, ContactOptimizer):
            optimizer.start_from(*start)
        counts = hasattr(optimizer, "pairs")
        before = 0 if counts else contact_of(self.atoms).halfspace.pairs
        statistics.converged = bool(
            optimizer.run(fmax=tolerance, steps=self._max_steps)
        )
        for _ in optimizer.optimizable.iterimages():
            pass  # moves the atoms if the optimizer works on other coordinates
        steps = int(optimizer.nsteps)
        statistics.tolerance = tolerance
        statistics.iterations += steps
        pairs = optimizer.pairs if counts else contact_of(self.atoms).halfspace.pairs
        statistics.pairs += float(pairs - before)
        statistics.message = ""
        if not statistics.converged:
            default = f"not converged after {steps} steps"
            statistics.message = getattr(optimizer, "message", default)

    def _check_load(self, load: float, statistics: SolverStatistics) -> None:
        """Mark a step whose load is lost in the rounding of forces."""
        if self.control != "loads" or self._fmax or not statistics.converged:
            return
        if statistics.tolerance <= _UNCARRIED_PART * abs(load):
            return
        missing = abs(float(self.atoms.get_forces()[-1, 2]))
        if 0.0 < _UNCARRIED_PART * abs(load) < missing:
            statistics.converged = False
            statistics.message = (
                f"a load of {load:.3g} is below the rounding of forces: {missing:.3g} "
                "of it is not carried"
            )


def check_control(control: str, window: str | WindowOptions) -> None:
    """Raise `ValueError` for an unknown control or kind of window.

    Parameters
    ----------
    control, window
        See `load_path`.
    """
    if not isinstance(window, WindowOptions):
        one_of(("fixed", "auto"), window=window)
    one_of(CONTROLS, control=control)


def _check(atoms: Atoms, control: str, window: str | WindowOptions, edge: str) -> None:
    one_of(("raise", "ignore"), edge=edge)
    check_control(control, window)
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
