"""Comparison of optimizers on the contact of given atoms.

Each optimizer relaxes a copy of the atoms. After every step its state is compared with
the relaxed state, which the solver for the wall finds to a relative error of 1e-9. The
error of a state is the largest of

- the error of the normal force, relative to the sum of the magnitudes of the forces on
  atoms,
- the relative error of the contact area, beyond one atom,
- under a load, the error of the height times the contact stiffness, relative to the
  same sum.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

import numpy as np
from ase import Atoms

from ase_roughcontact._util.callers import warn
from ase_roughcontact._util.validation import integer, positive
from ase_roughcontact.atoms.calculator import RoughContact, contact_of, problem_of
from ase_roughcontact.atoms.constraints import surface_held
from ase_roughcontact.optimize.base import ContactOptimizer, status_of
from ase_roughcontact.optimize.comparison_result import (
    OptimizerComparison,
    OptimizerResult,
    Progress,
    reached,
)
from ase_roughcontact.optimize.modes import FourierModes
from ase_roughcontact.optimize.names import optimizer_of
from ase_roughcontact.optimize.optimizers import default_optimizer
from ase_roughcontact.optimize.settings import make_optimizer
from ase_roughcontact.optimize.tolerance import solution
from ase_roughcontact.solvers.relaxation import Run
from ase_roughcontact.solvers.response import height_response
from ase_roughcontact.stepping.convergence import StepRelaxer

# Relative error of the relaxed state with which states are compared.
_REFERENCE_ERROR = 1e-9
# Optimizers that are compared by default on soft walls, with the solver for the wall.
_ASE_OPTIMIZERS = (
    "LBFGS",
    "FIRE",
    "FIRE2",
    "PreconLBFGS",
    "LBFGS on modes",
    "FIRE on modes",
    "FIRE2 on modes",
    "SciPyFminCG on modes",
)


def compare_optimizers(
    atoms: Atoms,
    optimizers: Iterable[str] | Mapping[str, Callable[..., Any]] | None = None,
    accuracy: float = 0.01,
    *,
    max_steps: int = 2000,
) -> OptimizerComparison:
    """Relax the same atoms by several optimizers, and compare their costs and errors.

    Parameters
    ----------
    atoms : Atoms
        Atoms with a `RoughContact` calculator, and the indenter at its height, or free
        under the load. They are not moved.
    optimizers : iterable of str, or mapping of str to callable, optional
        Names as in `optimizer_names`, or functions that are called as ``f(atoms,
        logfile=None)``. By default the solver for the wall, and under a soft wall
        common optimizers of ASE, on atoms and on `FourierModes`.
    accuracy : float
        Wanted relative error of force and area: each optimizer stops at the tolerance
        of `fmax_for`.
    max_steps : int
        Largest number of steps of each optimizer.

    Returns
    -------
    OptimizerComparison
        Results, with the reason if an optimizer failed.

    Raises
    ------
    ValueError
        If a name is unknown, constraints hold atoms of the surface, or no atom is in
        contact.
    RuntimeError
        If the relaxed state is not found.

    Examples
    --------
    >>> from ase.optimize import LBFGS
    >>> from ase_roughcontact import RoughContact, RoughSphere
    >>> from ase_roughcontact import compare_optimizers, on_modes, substrate
    >>> sphere = RoughSphere(radius=200.0)
    >>> atoms = substrate('Cu', (12, 12), sphere, height=1.0)
    >>> atoms.calc = RoughContact(sphere, contact_modulus=0.5)
    >>> compared = compare_optimizers(atoms, ["NewtonKrylov", "FIRE2 on modes"])
    >>> [result.changed_atoms for result in compared.results]
    [0, 0]
    >>> compared.check(atoms=1, energy=1e-3)
    >>> own = {"mine": on_modes(LBFGS)}
    >>> compare_optimizers(atoms, own, accuracy=1e-3).check()
    """
    positive(accuracy=accuracy)
    integer("max_steps", max_steps, 1)
    if surface_held(atoms):
        raise ValueError(
            "constraints hold atoms of the surface, which the solver for the wall "
            "does not support: remove them to compare"
        )
    reference = _Reference.of(atoms)
    fmax = reference.fmax(accuracy)
    if reference.error_of(atoms) <= accuracy:
        warn(
            "the atoms are relaxed to the accuracy already, so that optimizers have "
            "nothing to do: compare on atoms from `substrate`"
        )
    results = []
    for name, optimizer in _named(atoms, optimizers).items():
        run = _Followed(name, atoms, reference)
        results.append(run.result(optimizer, fmax, accuracy, max_steps))
    solved = reference.run
    return OptimizerComparison(
        accuracy,
        fmax,
        solved.energy,
        solved.fields.normal_force,
        solved.fields.repulsive_atoms,
        tuple(results),
    )


def _named(
    atoms: Atoms, given: Iterable[str] | Mapping[str, Callable[..., Any]] | None
) -> Mapping[str, Callable[..., Any]]:
    """Return functions that make optimizers, by name."""
    if isinstance(given, Mapping):
        return given
    if given is None:
        wall = problem_of(atoms)[0].wall
        given = [default_optimizer(wall).__name__]
        if not wall.hard:
            given.extend(_ASE_OPTIMIZERS)
    return {name: optimizer_of(name) for name in given}


@dataclass(frozen=True)
class _Reference:
    """Relaxed state, with which states of optimizers are compared.

    Attributes
    ----------
    run : Run
        Relaxed state of the solver for the wall.
    relax : StepRelaxer
        Relaxer with the error of this state.
    stiffness : float
        Stiffness of the contact; zero if the indenter is fixed (eV/Å^2).
    """

    run: Run
    relax: StepRelaxer
    stiffness: float

    @classmethod
    def of(cls, atoms: Atoms) -> _Reference:
        """Return the relaxed state of atoms, which are not moved."""
        relax, run = solution(atoms, _REFERENCE_ERROR)
        if not run.converged:
            raise RuntimeError(f"the relaxed state is not found: {run.message}")
        stiffness = 0.0
        if not run.support.fixed:
            problem, window = problem_of(atoms)
            contact = problem.contact(window, run.state.plastic_depth)
            stiffness = abs(height_response(contact, run.fields).force)
        return cls(run, relax, stiffness)

    def fmax(self, accuracy: float) -> float:
        """Return the tolerance of forces for an accuracy; see `fmax_for`."""
        fmax = self.relax.required(self.run.fields)
        if math.isinf(fmax):
            raise ValueError(
                "no atom is in contact in the relaxed state: lower the indenter, or "
                "set it free under a load"
            )
        return fmax * accuracy / _REFERENCE_ERROR

    @cached_property
    def contact(self) -> np.ndarray:
        """Mask of the atoms in contact, shape (n, m)."""
        return self.run.fields.contact

    def error_of(self, atoms: Atoms) -> float:
        """Return the error of a state of atoms; infinity inside a hard wall."""
        try:
            return self.errors(atoms)["error"]
        except ValueError:
            return math.inf

    def errors(self, atoms: Atoms) -> dict[str, Any]:
        """Return the columns of `OptimizerResult` with errors of a state of atoms."""
        solved, state = self.run.fields, atoms.calc.state(atoms)
        scale, count = solved.total_magnitude, max(solved.repulsive_atoms, 1)
        force = abs(state.normal_force - solved.normal_force) / scale
        difference = abs(state.repulsive_atoms - solved.repulsive_atoms)
        height = float(atoms.positions[-1, 2]) - self.run.state.height
        force_of_height = self.stiffness * abs(height) / scale
        return {
            "error": max(force, max(difference - 1, 0) / count, force_of_height),
            "force_error": force,
            "area_error": difference / count,
            "height_error": height,
            "changed_atoms": int(np.count_nonzero(state.contact ^ self.contact)),
            "energy_error": float(atoms.get_potential_energy()) - self.run.energy,
        }


class _Counting(RoughContact):
    """Calculator that counts its calculations."""

    evaluations = 0

    def calculate(self, *args: Any, **kwargs: Any) -> None:
        self.evaluations += 1
        super().calculate(*args, **kwargs)


class _Followed:
    """Run of an optimizer on a copy of atoms, with costs and errors after each step.

    Costs do not include the comparison with the relaxed state.
    """

    def __init__(self, name: str, atoms: Atoms, reference: _Reference) -> None:
        self.name, self._reference = name, reference
        self.atoms = atoms.copy()
        self.atoms.calc = _Counting(**atoms.calc.parameters)
        self._history: list[Progress] = []
        self._spent = np.zeros(3)  # evaluations, pairs and seconds
        self._errors: dict[str, Any] = {}

    def result(
        self,
        maker: Callable[..., Any],
        fmax: float,
        accuracy: float,
        max_steps: int,
    ) -> OptimizerResult:
        """Run the optimizer and return its result."""
        converged, reason = False, ""
        self._optimizer: Any = None
        self._before = np.array([0.0, 0.0, time.perf_counter()])
        try:
            self._optimizer = make_optimizer(maker, self.atoms)
            self._optimizer.attach(self._follow)
            converged = bool(self._optimizer.run(fmax=fmax, steps=max_steps))
            self._follow()
        except Exception as error:  # any failure of an optimizer is its result
            kind, text = type(error).__name__, str(error)
            reason = text if isinstance(error, ValueError) else f"{kind}: {text}"
            reason = reason or kind
        if not (converged or reason):
            reason = status_of(self._optimizer, converged).message
        if converged and not self._errors:
            converged, reason = False, "atoms are inside the hard wall at the end"
        elif converged and self._changed > 1 + accuracy * self._count:
            reason = self._other_state()
        costs: dict[str, Any] = {}
        if self._history:
            costs = asdict(self._history[-1])
            del costs["error"]  # the last error is among `_errors`
        found = reached(self._history, accuracy)
        if found is not None:
            costs["evaluations_to_accuracy"] = float(found.evaluations)
            costs["pairs_to_accuracy"] = found.pairs
            costs["seconds_to_accuracy"] = found.seconds
        return OptimizerResult(
            self.name,
            converged,
            reason,
            **costs,
            **self._errors,
            history=tuple(self._history),
        )

    @property
    def _count(self) -> int:
        return self._reference.run.fields.repulsive_atoms

    @property
    def _changed(self) -> int:
        return self._errors["changed_atoms"]

    def _counts(self) -> np.ndarray:
        """Return numbers of evaluations and FFT pairs, and the time (s)."""
        run, evaluations = self._optimizer, self.atoms.calc.evaluations
        pairs = float(contact_of(self.atoms).halfspace.pairs)
        if isinstance(run, ContactOptimizer):
            evaluations, pairs = run.nsteps + 1, run.pairs
        elif isinstance(run.optimizable, FourierModes):
            evaluations += run.optimizable.evaluations
        return np.array([evaluations, pairs, time.perf_counter()])

    def _follow(self) -> None:
        """Compare the atoms with the relaxed state, and note the costs so far."""
        self._spent += self._counts() - self._before
        for _ in self._optimizer.optimizable.iterimages():
            pass  # this moves the atoms if the optimizer works on other coordinates
        try:
            self._errors = self._reference.errors(self.atoms)
        except ValueError:  # atoms inside a hard wall have no energy
            self._errors = {}
        else:
            evaluations, pairs, seconds = self._spent.tolist()
            steps, error = int(self._optimizer.nsteps), self._errors["error"]
            progress = Progress(steps, round(evaluations), pairs, seconds, error)
            self._history.append(progress)
        self._before = self._counts()

    def _other_state(self) -> str:
        """Return a reason if the solver ends in another state from here; else empty."""
        _, run = solution(self.atoms, _REFERENCE_ERROR)
        lowest = self._reference.run.energy
        if not run.converged or math.isclose(run.energy, lowest, rel_tol=1e-6):
            return ""
        return f"in another state, of {run.energy:.8g} eV, not {lowest:.8g} eV"
