"""One step of a quasi-static path: set the target, choose the window, relax."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import Any, Protocol

import numpy as np

from ase_roughcontact._util.validation import integer, one_of, positive
from ase_roughcontact.contact import Contact, Problem, State
from ase_roughcontact.contact.creep import (
    after_step,
    before_step,
    check_past,
    past_of,
    with_depths,
)
from ase_roughcontact.contact.state import PLASTIC_DEPTH, TRACTION_DEPTH
from ase_roughcontact.elasticity.creep import CreepStep
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.paths.accuracy import ForceTolerance, accuracy_of
from ase_roughcontact.paths.errors import Errors
from ase_roughcontact.paths.extrapolation import Extrapolation
from ase_roughcontact.paths.record import LoadStep, Step
from ase_roughcontact.paths.relaxed import RelaxedStep, SolverStatistics
from ase_roughcontact.paths.resume import describe_system
from ase_roughcontact.solvers.default import default_relaxer
from ase_roughcontact.solvers.relaxation import (
    External,
    Run,
    Start,
    Support,
    fields_of,
    largest_error,
)
from ase_roughcontact.windows.auto import AutoWindow
from ase_roughcontact.windows.fixed import FixedWindow

#: What a path prescribes: that of the indenter, or of the base of its cantilever.
CONTROLS = ("penetrations", "heights", "loads", "bases")
#: Those under which the indenter is free to move.
FREE = ("loads", "bases")
# A load counts as not carried if rounding leaves more than this part of it.
_UNCARRIED_PART = 0.1
# A step has not converged if a force, or the force that would close a gap, is above the
# first times the tolerance plus the second, for rounding, times all forces of the wall.
_EXCESS, _ROUNDING = 2.0, 1e-13
# Number of time steps of other lengths whose half spaces are kept.
_KEPT_HALFSPACES = 4


class Relaxer(Protocol):
    """Relaxes a contact from a state; see `SolverRelaxer`."""

    def __call__(
        self,
        contact: Contact,
        state: State,
        support: Support,
        tolerance: float,
        max_steps: int,
        start: Start | None = None,
    ) -> Run:
        """Return the outcome of a run."""
        ...


@dataclass(frozen=True, kw_only=True)
class StepOptions:
    """Options of the steps of a path; see `load_path`.

    Attributes
    ----------
    relaxer : Relaxer, optional
        By default that of the recommended solver for the wall.
    fmax, accuracy, max_steps, window
        See `load_path`.
    hardness : float
        Hardness with which pressures are compared; infinity or NaN for none (pressure).
    continuum : bool
        Whether the continuum is asked for, and not the model of atoms.
    lost_slope : float
        Part of the rms slope that the grid can't resolve, and that is lost.
    cantilever : float
        Stiffness of the spring between the indenter and a base whose height is given
        (force/length).
    scan_errors : ScanErrors, optional
        Adds errors by the scan that is pressed.

    Raises
    ------
    ValueError
        If an option is not valid.
    """

    relaxer: Relaxer | None = None
    fmax: float | None = None
    accuracy: str | float = "normal"
    max_steps: int = 10_000
    window: str = "fixed"
    hardness: float = math.nan
    continuum: bool = False
    lost_slope: float = 0.0
    cantilever: float = 0.0
    scan_errors: Callable[[RelaxedStep], Errors] | None = None

    def __post_init__(self) -> None:
        """Check the options."""
        one_of(("fixed", "unchecked", "auto"), window=self.window)
        if self.fmax is not None:
            positive(fmax=self.fmax)
        integer("max_steps", self.max_steps, 1)
        accuracy_of(self.accuracy, self.continuum)

    @property
    def keeps_window(self) -> bool:
        """Whether the window is that of the first state."""
        return self.window != "auto"


class Stepper:
    """Relaxes a contact at one target after another, each from the last state.

    Parameters
    ----------
    problem : Problem
    control : {"penetrations", "heights", "loads", "bases"}
        Meaning of the targets; see `load_path` and `time_path`.
    start : State or Box
        First state, or a window of flat atoms.
    options : StepOptions, optional
    springs : callable, optional
        Energy and upward force of springs on the indenter at a height.

    Attributes
    ----------
    state : State
        Last relaxed state.
    run : Run or None
        Of this state; None before the first step.
    contact : Contact
        On its window.
    windows : AutoWindow or FixedWindow

    Raises
    ------
    ValueError
        If the control is unknown, or the indenter is not bounded and the window is
        automatic.

    Examples
    --------
    >>> from ase_roughcontact import HardWall, Problem, RoughSphere
    >>> from ase_roughcontact import StepOptions, Stepper
    >>> from ase_roughcontact.elasticity import Isotropic
    >>> from ase_roughcontact.elasticity.lattice import Box
    >>> problem = Problem(RoughSphere(200.0), Isotropic(0.9), HardWall(), spacing=2.5)
    >>> first = Box(start=(-4, -4), shape=(8, 8))
    >>> stepper = Stepper(problem, 'loads', first, StepOptions(window='auto'))
    >>> steps = [stepper.step(number, load) for number, load in enumerate([1.0, 10.0])]
    >>> [step.repulsive_atoms for step in steps]
    [21, 69]
    >>> stepper.state.pressure.shape
    (16, 16)
    """

    def __init__(
        self,
        problem: Problem,
        control: str,
        start: State | Box,
        options: StepOptions | None = None,
        *,
        springs: External | None = None,
    ) -> None:
        one_of(CONTROLS, control=control)
        self.problem, self.control = problem, control
        self.options = options = options or StepOptions()
        self._accuracy = accuracy_of(options.accuracy, options.continuum)
        self._relaxer = options.relaxer or default_relaxer(problem.wall)
        self._springs = springs
        self._extrapolation = self._new_extrapolation()
        self._tolerance = ForceTolerance(
            self._accuracy.tolerance,
            problem.solid.contact_modulus * problem.spacing**2,
        )
        window = start if isinstance(start, Box) else start.window
        self.windows: AutoWindow | FixedWindow
        self.contact: Contact
        self._contact_window: Box | None = None
        self._creep_step: CreepStep | None = None
        self._at_rest()
        # quasi-static states under attraction depend on where they start
        self._continuous = self._creep_step is not None or not problem.wall.attractive
        if options.keeps_window or problem.periodic:
            self._set_contact(State.flat(window, 0.0))
            checked = options.window != "unchecked"
            self.windows = FixedWindow(
                problem, window, checked, self.contact.first_contact
            )
        else:
            self.windows = AutoWindow(problem)
        if isinstance(start, Box):
            start = State.flat(start, self.windows.first_contact)
        self.state: State = start
        self.run: Run | None = None

    @property
    def accuracy(self) -> float:
        """Relative error of forces that the tolerance is made for."""
        return self._accuracy.error

    def remember(self, key: str, values: np.ndarray | None) -> None:
        """Set what the surface keeps under a key of `State.history`; None removes it.

        Raises
        ------
        RuntimeError
            If there was no step yet.
        """
        if self.run is None:
            raise RuntimeError("there is nothing to remember before the first step")
        history = {k: v for k, v in self.state.history.items() if k != key}
        if values is not None:
            history[key] = values
        self.state = replace(self.state, history=history)
        self.run = replace(self.run, state=self.state)

    def step(
        self,
        number: int,
        target: float,
        record: type[Step] = LoadStep,  # type: ignore[assignment]
        *,
        moment: float = math.nan,
        elapsed: float = 0.0,
        completed: Callable[[RelaxedStep], RelaxedStep] | None = None,
    ) -> Step:
        """Relax the contact at a target, in windows enlarged until they suffice.

        Parameters
        ----------
        number : int
            Number of the step, for its result.
        target : float
            Penetration or height (length), or load (force).
        record : type
            Class of the result.
        moment, elapsed : float
            Time of the step, and since the last one, if the solid creeps (time).
        completed : callable, optional
            Adds to the relaxed step what its result needs beside.

        Returns
        -------
        LoadStep
            Of this class.

        Raises
        ------
        ValueError
            If the solid creeps and no time is given, or the other way round.
        """
        creep = self.problem.solid.creep
        if (creep is None) != math.isnan(moment):
            raise ValueError(
                "a viscoelastic solid needs a path in time: use time_path, or one of "
                "its limits, solid.solid and solid.relaxed"
                if creep
                else f"only a viscoelastic solid needs a time, got {moment}"
            )
        check_past(self.state, creep)
        if creep:
            self._creep_step = creep.over(elapsed)
            aged = before_step(self.state, self._creep_step)
            self.state = replace(aged, creep=creep)
        relaxed = self._relaxed(number, target, moment)
        if completed is not None:
            relaxed = completed(relaxed)
        result = record.of(relaxed)
        fields = relaxed.fields
        if self.problem.wall.permanent and fields.plastic_atoms:
            self.remember(PLASTIC_DEPTH, fields.plastic_depth)
        return result

    def repeat(
        self, relaxed: RelaxedStep, target: float, **history: np.ndarray
    ) -> RelaxedStep:
        """Relax a step again from where it has ended, with more history.

        Parameters
        ----------
        relaxed : RelaxedStep
            Whose statistics go on.
        target : float
        **history : ndarray, shape (n, m)
            See `remember`.

        Returns
        -------
        RelaxedStep
        """
        for key, values in history.items():
            self.remember(key, values)
        return self._relaxed(relaxed.number, target, relaxed.time, relaxed.statistics)

    def restart_from(self, state: State, target: float | None = None) -> None:
        """Continue from a state, as if a step had ended there.

        Parameters
        ----------
        state : State
        target : float, optional
            Of this step.
        """
        self._extrapolation = self._new_extrapolation()
        self._at_rest()
        self.state = state = self._set_contact(state)
        fields = fields_of(self.contact, state, relaxed=True)
        support = Support(self.control not in FREE, 0.0, self._springs)
        if target is not None:
            support = self._at(target)[1]
        self.run = Run.of(state, fields, support)
        self.windows.accept(state, fields)

    def describe_system(self, **more: Any) -> dict[str, Any]:
        """Describe all that a state depends on except height, load and displacement.

        Parameters
        ----------
        **more
            Further descriptions, of springs for instance.

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
        if self.options.fmax is not None:
            tolerance = {"fmax": self.options.fmax}
        question: dict[str, Any] = {}
        if self.options.continuum:
            question = {"model": "continuum"}
        lattice = self.windows.describe_lattice()
        return describe_system(
            self.problem, **more, lattice=lattice, **tolerance, **question
        )

    def _new_extrapolation(self) -> Extrapolation:
        return Extrapolation(-math.inf if self.problem.wall.attractive else 0.0)

    def _at_rest(self) -> None:
        """Take the contact as between time steps, with the instantaneous solid."""
        if self.problem.solid.creep is not None:
            self._creep_step = self.problem.solid.creep.over(0.0)

    def _set_contact(self, state: State) -> State:
        """Make the contact on the window of a state, with its history.

        Returns the state with the depths that its history causes.
        """
        depth = state.plastic_depth
        if self._contact_window != state.window:
            self.contact = self.problem.contact(state.window, depth)
            self._contact_window = state.window
            self._instantaneous = self.contact.halfspace
            self._softened = lru_cache(_KEPT_HALFSPACES)(self._instantaneous.softened)
        if self._creep_step is None:
            lowered = state.history.get(TRACTION_DEPTH)
            old = self.contact.plastic_depth, self.contact.past_depth
            if old[0] is not depth or old[1] is not lowered:
                past = None, lowered
                self.contact = self.contact.changed(
                    self.contact.halfspace, depth, *past
                )
            return state
        state = with_depths(state, self._instantaneous)
        halfspace = self._softened(self._creep_step.compliance)
        self.contact = self.contact.changed(halfspace, depth, *past_of(state))
        return state

    def _relaxed(
        self,
        number: int,
        target: float,
        moment: float,
        repeated: SolverStatistics | None = None,
    ) -> RelaxedStep:
        begun = time.perf_counter()
        statistics = repeated or SolverStatistics()
        state, support = self._at(target)
        state = self.windows.choose(state, support)
        state = self._set_contact(state)
        start, along = None, target if math.isnan(moment) else moment
        # without a load nothing holds a sphere
        if (target or support.fixed) and repeated is None:
            start = self._extrapolation.start(state.window, along)
        run = self._relax(state, support, statistics, start)
        while wider := self.windows.enlarged(
            run.state, run.fields, self.contact, support
        ):
            wider = self._set_contact(wider)
            run = self._relax(wider, support, statistics)
        softness = 1.0
        if self._creep_step is not None:
            softness = self._creep_step.compliance
            run = self._ended(run, self._creep_step)
        self.state, self.run = run.state, run
        self._check_load(target, run, statistics)
        relaxed = RelaxedStep(
            problem=self.problem,
            contact=self.contact,
            run=run,
            number=number,
            first_contact=self.windows.first_contact,
            statistics=statistics,
            seconds=time.perf_counter() - begun,
            time=moment,
            base=target if self.control == "bases" else math.nan,
            hardness=self.options.hardness,
            control=self.control,
            continuum=self.options.continuum,
            lost_slope=self.options.lost_slope,
            scan_errors=self.options.scan_errors,
        )
        _check_residuals(relaxed, softness)
        if statistics.converged and self._continuous and repeated is None:
            self._extrapolation.add(along, run.state, run.fields.pressure)
        return relaxed

    def _ended(self, run: Run, step: CreepStep) -> Run:
        """Return the outcome of a time step with the history at its end."""
        state = run.state
        if state.displacement is None:
            displacement = self.contact.halfspace.displacement(state.pressure)
            state = replace(state, displacement=np.asarray(displacement, dtype=float))
        state = after_step(state, step)
        self._at_rest()
        state = self._set_contact(state)
        fields = fields_of(self.contact, state, relaxed=True)
        return replace(
            run,
            state=state,
            fields=fields,
            energy=fields.energy + run.support.external(state.height)[0],
        )

    def _at(self, target: float) -> tuple[State, Support]:
        """Return the last state at a target, and what holds the indenter there."""
        first_contact = self.windows.first_contact
        if self.control == "loads":
            # out of contact nothing but the load acts, and some optimizers divide by 0
            height = min(self.state.height, first_contact)
            return self.state.at(height), Support(False, float(target), self._springs)
        if self.control == "bases":
            spring = partial(_spring, self.options.cantilever, target)
            return self.state, Support(False, 0.0, spring)
        height = target if self.control == "heights" else first_contact - target
        return self.state.at(float(height)), Support(True, 0.0, self._springs)

    def _relax(
        self,
        state: State,
        support: Support,
        statistics: SolverStatistics,
        start: Start | None = None,
    ) -> Run:
        """Relax the contact to the tolerance that the relaxed state requires."""
        given = self.options.fmax
        tolerance: float | None = given or self._tolerance.expected(support.load)
        while tolerance is not None:
            run = self._relaxer(
                self.contact, state, support, tolerance, self.options.max_steps, start
            )
            statistics.add(run, tolerance)
            state, start = run.state, None
            reduced = self._tolerance.reduced(tolerance, run.fields)
            tolerance = reduced if run.converged and given is None else None
        return run

    def _check_load(self, load: float, run: Run, statistics: SolverStatistics) -> None:
        """Mark a step whose load is lost in the rounding of forces."""
        given = self.options.fmax is not None
        if self.control != "loads" or given or not statistics.converged:
            return
        if statistics.tolerance <= _UNCARRIED_PART * abs(load):
            return
        if 0.0 < _UNCARRIED_PART * abs(load) < run.unbalanced:
            statistics.converged = False
            statistics.message = (
                f"a load of {load:.3g} is below the rounding of forces: "
                f"{run.unbalanced:.3g} of it is not carried"
            )


def _spring(stiffness: float, base: float, height: float) -> tuple[float, float]:
    """Return the energy of a spring to a base, and its upward force."""
    extension = base - height
    return 0.5 * stiffness * extension**2, stiffness * extension


def _check_residuals(relaxed: RelaxedStep, softness: float = 1.0) -> None:
    """Mark a step whose forces or gaps are above the tolerance as not converged.

    Over a time step the solid is softer than between steps.
    """
    statistics, halfspace, state = relaxed.statistics, relaxed.halfspace, relaxed.fields
    stiffness = halfspace.cell_area / (softness * halfspace.self_compliance)
    limit = statistics.tolerance
    if not relaxed.contact.interaction.hard and state.pressure.any():
        limit = min(limit, largest_error(relaxed.contact, state.pressure))
    left = max(relaxed.run.max_force, stiffness * relaxed.gap_error)
    rounding = _ROUNDING * state.cell_area * float(abs(state.pressure).sum())
    if statistics.converged and not left <= _EXCESS * limit + rounding:
        statistics.converged = False
        statistics.message = (
            f"a force of {left:.3g} remains, more than the {limit:.3g} that the "
            "tolerance and the forces of the wall allow, although the optimizer has "
            "converged: lower fmax"
        )
