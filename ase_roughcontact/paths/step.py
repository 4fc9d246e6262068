"""One step of a quasi-static path after the other."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from ase import Atoms
from ase.constraints import Hookean

from ase_roughcontact._util.validation import integer, positive
from ase_roughcontact.atoms.build import indenter_fixed, restore
from ase_roughcontact.atoms.calculator import RoughContact
from ase_roughcontact.atoms.grid import SurfaceGrid
from ase_roughcontact.optimize import ActiveSet, NewtonKrylov
from ase_roughcontact.paths.accuracy import accuracy_of
from ase_roughcontact.paths.record import LoadStep, SolverStatistics, record_of
from ase_roughcontact.windows.exchange import exchange_window, window_of
from ase_roughcontact.windows.policy import AutoWindow, FixedWindow

CONTROLS = ("penetrations", "heights", "loads")
# Force on an atom in contact, in units of E* a0^2, until it is known: about that of the
# paper's rough surfaces.
_USUAL_FORCE = 0.05
# Least tolerance, in units of E* a0^2: what rounding leaves.
_ROUNDING = 1e-13
# Part of a load that may be missing, where rounding does not let it be less.
_UNCARRIED = 0.1
# A tolerance that the state turned out to need is taken this much smaller, so that the
# next one does not fall short of it by little.
_MARGIN = 0.5


class Stepper:
    """Relaxes atoms at one load after the other, each from where the last one ended.

    Parameters
    ----------
    atoms : Atoms
        From `substrate`, with a `RoughContact` calculator. They are moved.
    control : {"penetrations", "heights", "loads"}
        What a step's target is; see `load_path`.
    optimizer, fmax, accuracy, max_steps, window, edge
        See `load_path`.

    Raises
    ------
    ValueError
        If a parameter is not what it should be, or the indenter's constraint does not
        fit the control.
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
        window: str = "fixed",
        edge: str = "raise",
    ) -> None:
        _check(atoms, control, window, edge)
        if fmax is not None:
            positive(fmax=fmax)
        self.atoms = atoms
        self.control = control
        self._fmax = fmax
        self._accuracy = accuracy_of(accuracy)
        self._max_steps = integer("max_steps", max_steps, 1)
        contact = atoms.calc.contact(atoms)
        hard = contact.interaction.hard
        self._optimizer = optimizer or (ActiveSet if hard else NewtonKrylov)
        auto = window == "auto" and not atoms.pbc.any()
        self.windows = AutoWindow(atoms) if auto else FixedWindow(atoms, edge)
        halfspace = contact.halfspace
        unit = halfspace.contact_modulus * halfspace.cell_area
        self._force, self._least = _USUAL_FORCE * unit, _ROUNDING * unit

    def step(self, number: int, target: float) -> LoadStep:
        """Relax the atoms at a target, in windows that grow until they suffice.

        Parameters
        ----------
        number : int
            Of the step, for its record.
        target : float
            Penetration or height (Å), or load (eV/Å).

        Returns
        -------
        LoadStep
        """
        start = time.perf_counter()
        self._apply(target)
        self.windows.place(self.atoms, self.control)
        effort = SolverStatistics()
        self._relax(effort)
        while self.windows.grow(self.atoms):
            self._relax(effort)
        self._weigh(target, effort)
        seconds = time.perf_counter() - start
        first_contact = self.windows.first_contact
        return record_of(self.atoms, number, first_contact, effort, seconds)

    def proceed_from(self, frame: Atoms) -> None:
        """Put the atoms where they are in a frame, as if a step had ended there.

        Parameters
        ----------
        frame : Atoms
            As `snapshot` made it.
        """
        atoms = self.atoms
        if not atoms.pbc.any() and isinstance(self.windows, AutoWindow):
            exchange_window(atoms, window_of(SurfaceGrid.of(frame)))
            atoms.positions = frame.positions
        else:
            restored = restore(frame, atoms.calc.contact(atoms).halfspace.solid)
            atoms.positions = restored.positions
        self.windows.settle(atoms)

    def system(self) -> dict[str, Any]:
        """Return all that a state depends on but height, load and displacement.

        Returns
        -------
        dict
            Of numbers, words, lists and dicts, as a file gives them back.

        Raises
        ------
        ValueError
            If something does not tell what it is, such as a surface without `todict`.
        """
        calc = self.atoms.calc
        system = {k: v for k, v in calc.todict().items() if k not in ("load", "fft")}
        # the wall that there is, also where none was named
        system["interaction"] = calc.contact(self.atoms).interaction.todict()
        system["precision"] = np.dtype(calc.parameters["fft"].get("dtype", float)).name
        springs = [_spring(c) for c in self.atoms.constraints if isinstance(c, Hookean)]
        system |= {"springs": springs, "lattice": self.windows.system()}
        if self._fmax is None:
            system["accuracy"] = self._accuracy.error
        else:
            system["fmax"] = self._fmax
        return json.loads(json.dumps(system, default=_plain))

    def _apply(self, target: float) -> None:
        atoms, first_contact = self.atoms, self.windows.first_contact
        if self.control == "loads":
            atoms.calc.set(load=float(target))
            # out of contact nothing but the load acts, and some optimizers divide by 0
            atoms.positions[-1, 2] = min(atoms.positions[-1, 2], first_contact)
        else:
            height = target if self.control == "heights" else first_contact - target
            atoms.positions[-1, 2] = height

    def _relax(self, effort: SolverStatistics) -> None:
        """Relax the atoms to the tolerance that their state turns out to need."""
        tolerance = self._fmax or self._wanted(self._least_force())
        while True:
            self._run(effort, tolerance)
            if self._fmax or not self._touch():
                return
            needed = self._wanted(self._force)
            if tolerance <= needed or not effort.converged:
                return
            tolerance = max(_MARGIN * needed, self._least)

    def _weigh(self, load: float, effort: SolverStatistics) -> None:
        """Mark a step whose load rounding has left uncarried."""
        if self.control != "loads" or self._fmax or not effort.converged:
            return
        left = abs(float(self.atoms.get_forces()[-1, 2]))
        if 0.0 < _UNCARRIED * abs(load) < left:
            effort.converged = False
            effort.message = (
                f"a load of {load:.3g} is below the rounding of forces: {left:.3g} of "
                "it is not carried"
            )

    def _wanted(self, force: float) -> float:
        """Tolerance for a mean force on an atom in contact."""
        return max(self._accuracy.tolerance * force, self._least)

    def _least_force(self) -> float:
        """Force on an atom in contact as far as it is known before the relaxation."""
        load = self.atoms.calc.parameters["load"]
        return min(self._force, load) if load > 0.0 else self._force

    def _touch(self) -> bool:
        """Whether atoms touch; remember the mean force on one."""
        state = self.atoms.calc.state(self.atoms)
        count = state.repulsive_atoms
        if count:
            push = state.pressure.sum(where=state.contact) * state.cell_area
            self._force = float(push) / count
        return count > 0

    def _run(self, effort: SolverStatistics, tolerance: float) -> None:
        """Run the optimizer once, and add what it took to the effort."""
        halfspace = self.atoms.calc.contact(self.atoms).halfspace
        before = halfspace.pairs
        dynamics = self._optimizer(self.atoms, logfile=None)
        effort.converged = bool(dynamics.run(fmax=tolerance, steps=self._max_steps))
        for _ in dynamics.optimizable.iterimages():
            pass  # an optimizer with coordinates of its own moves the atoms only now
        effort.tolerance = tolerance
        effort.iterations += int(dynamics.nsteps)
        effort.pairs += float(getattr(dynamics, "pairs", halfspace.pairs - before))
        told = f"not converged after {int(dynamics.nsteps)} steps"
        message = getattr(dynamics, "message", told)
        effort.message = "" if effort.converged else message


def check_words(control: str, window: str) -> None:
    """Raise `ValueError` for a control or a kind of window that is not known.

    Parameters
    ----------
    control, window : str
        See `load_path`.
    """
    if window not in ("fixed", "auto"):
        raise ValueError(f"window must be 'fixed' or 'auto', got {window!r}")
    if control not in CONTROLS:
        raise ValueError(f"control must be one of {CONTROLS}, got {control!r}")


def _check(atoms: Atoms, control: str, window: str, edge: str) -> None:
    if edge not in ("raise", "ignore"):
        raise ValueError(f"edge must be 'raise' or 'ignore', got {edge!r}")
    check_words(control, window)
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
            f"{control} need an indenter that is fixed, but it is free: constrain it "
            "with ase.constraints.FixAtoms, or build the atoms with "
            "substrate(..., fixed=True)"
        )


def _spring(constraint: Hookean) -> dict[str, Any]:
    """Return what counts of a spring: its x and y move with automatic windows."""
    given = constraint.todict()["kwargs"]
    end = np.ravel(given["a2"]).tolist()[2:]
    return {"k": given["k"], "rt": given["rt"], "end": end}


def _plain(value: Any) -> Any:
    """Return a number or text in place of what JSON does not know, or refuse."""
    if isinstance(value, np.ndarray):
        return hashlib.sha256(value.tobytes()).hexdigest()[:16]
    if isinstance(value, np.generic):
        return value.item()
    raise ValueError(
        f"a trajectory tells what it is of, but {type(value).__name__} can't be told: "
        "give it a method todict, which returns its name and parameters, or leave the "
        "trajectory out"
    )
