"""One step of a quasi-static path: set the target, choose the window, relax."""

from __future__ import annotations

import json
import math
import time
from copy import copy
from dataclasses import replace
from typing import Any

import numpy as np

from ase_roughcontact._util.identity import digest
from ase_roughcontact._util.validation import function, instance_of
from ase_roughcontact.contact import Problem, State
from ase_roughcontact.contact.control import BASE, LOAD, Control, control_of
from ase_roughcontact.contact.state import PLASTIC_DEPTH
from ase_roughcontact.contact.support import External, Spring, Support
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.solvers.relaxation import Run, fields_of
from ase_roughcontact.stepping.convergence import StepRelaxer
from ase_roughcontact.stepping.extrapolation import extrapolated, with_earlier
from ase_roughcontact.stepping.options import StepOptions
from ase_roughcontact.stepping.relaxed import RelaxedStep
from ase_roughcontact.stepping.surface_history import SurfaceHistory
from ase_roughcontact.windows.auto import AutoWindow
from ase_roughcontact.windows.fixed import FixedWindow


class Stepper:
    """Relaxes a contact at a target, from the state of the last step.

    Only objects that are cheaper to reuse than to calculate are kept between steps.

    Parameters
    ----------
    problem : Problem
    control : Control or str
        Meaning of the targets: "penetration", "height", "load" or "base", or their
        plural; see `load_path` and `time_path`.
    start : State or Box
        First state, or a window of flat atoms.
    options : StepOptions, optional
    springs : callable, optional
        Energy and upward force of springs on the indenter at a height.

    Attributes
    ----------
    control : Control
    start : State
        First state.
    windows : AutoWindow or FixedWindow
        Window of each step.

    Raises
    ------
    ValueError
        If the control is unknown, or the indenter is not bounded and the window is
        automatic.

    Examples
    --------
    >>> from ase_roughcontact import HardWall, LoadStep, Problem, RoughSphere
    >>> from ase_roughcontact import StepOptions, Stepper
    >>> from ase_roughcontact.elasticity import Isotropic
    >>> from ase_roughcontact.elasticity.lattice import Box
    >>> problem = Problem(RoughSphere(200.0), Isotropic(0.9), HardWall(), spacing=2.5)
    >>> first = Box(start=(-4, -4), shape=(8, 8))
    >>> stepper = Stepper(problem, 'loads', first, StepOptions(window='auto'))
    >>> state = stepper.start
    >>> for load in 1.0, 10.0:
    ...     relaxed = stepper.relax(state, load)
    ...     print(LoadStep.of(relaxed).repulsive_atoms, relaxed.state.pressure.shape)
    ...     state = stepper.commit(relaxed).state
    21 (8, 8)
    69 (16, 16)
    """

    def __init__(
        self,
        problem: Problem,
        control: Control | str,
        start: State | Box,
        options: StepOptions | None = None,
        *,
        springs: External | None = None,
    ) -> None:
        instance_of(Problem, problem=problem)
        instance_of((State, Box), start=start)
        options = StepOptions() if options is None else options
        instance_of(StepOptions, options=options)
        if springs is not None:
            function(springs=springs)
        self.problem, self.control = problem, control_of(control)
        self.options = options
        self._relax = StepRelaxer(problem, options)
        self._springs = springs
        self._surface = SurfaceHistory(problem)
        # quasi-static states under attraction depend on where they start
        creep = problem.solid.creep is not None
        self._continuous = creep or not problem.wall.attractive
        self.windows: AutoWindow | FixedWindow
        if options.keeps_window or problem.periodic:
            window = start if isinstance(start, Box) else start.window
            contact = self._surface.contact(State.flat(window, 0.0), None)[1]
            checked = options.window != "unchecked"
            self.windows = FixedWindow(problem, window, checked, contact.first_contact)
        else:
            self.windows = AutoWindow(problem)
        if isinstance(start, Box):
            start = State.flat(start, self.windows.first_contact)
        self.start: State = start

    @property
    def accuracy(self) -> float:
        """Relative error of forces that the tolerance is made for."""
        return self.options.grid_model.error

    def limited(self, error: float) -> Stepper:
        """Return a stepper with a solver that leaves at most an error.

        Parameters
        ----------
        error : float
            See `StepOptions.solver_error`.
        """
        limited = copy(self)
        limited.options = replace(self.options, solver_error=error)
        limited._relax = StepRelaxer(self.problem, limited.options)
        return limited

    def relax(
        self,
        state: State,
        target: float,
        *,
        number: int = 0,
        moment: float = math.nan,
        elapsed: float = 0.0,
        again: RelaxedStep | None = None,
    ) -> RelaxedStep:
        """Relax the contact at a target, in windows enlarged until they suffice.

        Parameters
        ----------
        state : State
            State at the end of the last step.
        target : float
            Penetration or height (length), or load (force).
        number : int
            Number of the step, for its result.
        moment, elapsed : float
            Time of the step, and since the last one, if the solid creeps (time).
        again : RelaxedStep, optional
            Solution of this step with another history. The step starts from its state,
            and its cost is added.

        Returns
        -------
        RelaxedStep
            After `commit`, its state is the one from which the next step starts.

        Raises
        ------
        ValueError
            If the solid creeps and no time is given, or the other way round.
        """
        begun = time.perf_counter()
        self._check_moment(moment)
        creep, last = self._surface.step(elapsed), state.height
        if again is None:
            state = self._surface.begun(state, creep)
        if self.problem.wall.purely_hard:  # only the pressure is needed again
            state = replace(state, displacement=None)
        state, support = self._at_target(state, target)
        state, level = self.windows.choose(state, support, last)
        state, contact = self._surface.contact(state, creep)
        # the quantity along which pressures are extrapolated
        coordinate = target if math.isnan(moment) else moment
        earlier_run = start = None
        if again is not None:
            earlier_run = again.run
        elif target or support.fixed:  # without a load nothing holds a sphere
            start = extrapolated(state.earlier, state.window, coordinate)
        run = self._relax(contact, state, support, earlier_run, start)
        while wider := self.windows.enlarged(run, contact, level):
            state, contact = self._surface.contact(wider.state, creep)
            run, level = self._relax(contact, state, support, run), wider.level
        run, contact = self._surface.ended(run, contact, creep)
        relaxed = RelaxedStep(
            problem=self.problem,
            contact=contact,
            run=run,
            number=number,
            first_contact=self.windows.first_contact,
            seconds=time.perf_counter() - begun,
            time=moment,
            base=target if self.control == BASE else math.nan,
            control=self.control,
            options=self.options,
        )
        compliance = creep.compliance if creep else 1.0
        relaxed = self._relax.checked(relaxed, compliance)
        if relaxed.run.converged and self._continuous and again is None:
            state = with_earlier(run.state, coordinate, run.fields.pressure)
            relaxed = replace(relaxed, run=replace(relaxed.run, state=state))
        return relaxed

    def commit(self, relaxed: RelaxedStep, **history: np.ndarray) -> RelaxedStep:
        """Return a step as it leaves the surface; the next one starts from its state.

        Parameters
        ----------
        relaxed : RelaxedStep
        **history : ndarray, shape (n, m)
            Entries of `State.history` beyond the plastic depth.

        Returns
        -------
        RelaxedStep
            A step with the contact and the fields of the surface after it has flowed:
            forces and energy stay, and its plastic work is added to the work of earlier
            steps.
        """
        flowed = self.problem.wall.permanent and relaxed.fields.plastic_atoms
        if flowed:
            history[PLASTIC_DEPTH] = relaxed.fields.plastic_depth
        state, fields = relaxed.state.keeping(**history), relaxed.run.fields
        contact = relaxed.contact
        if flowed:
            state, contact = self._surface.contact(state, self._surface.step(0.0))
            fields = fields_of(contact, state, relaxed=True)
        run = replace(relaxed.run, state=state.in_order(), fields=fields)
        return replace(relaxed, contact=contact, run=run)

    def restored(self, state: State, target: float | None = None) -> RelaxedStep:
        """Return the relaxed step that ended in a state, without its statistics.

        Parameters
        ----------
        state : State
        target : float, optional
            Target of the step.

        Returns
        -------
        RelaxedStep
        """
        state, contact = self._surface.contact(state, self._surface.step(0.0))
        fields = fields_of(contact, state, relaxed=True)
        support = Support(not self.control.free, 0.0, self._springs)
        if target is not None:
            support = self._at_target(state, target)[1]
        return RelaxedStep(
            problem=self.problem,
            contact=contact,
            run=Run.of(state, fields, support),
            first_contact=self.windows.first_contact,
            control=self.control,
            options=self.options,
        )

    def describe_system(self, **more: Any) -> dict[str, Any]:
        """Describe what a state depends on, except height, load and displacement.

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
        if self.options.fmax is not None:
            more["fmax"] = self.options.fmax
        else:
            more["accuracy"] = self.accuracy
        if self.options.grid_model.is_continuum:
            more["model"] = self.options.grid_model.model
        if self.options.scan_errors is not None:
            more["scan_errors"] = self.options.scan_errors.todict()
        described = self.problem.todict() | more
        described["lattice"] = self.windows.describe_lattice()
        return json.loads(json.dumps(described, default=_encode))

    def describe_settings(self) -> dict[str, Any]:
        """Describe what results depend on, but not which state is the right one.

        Returns
        -------
        dict
            Hardness with which pressures are compared and its bound, largest number of
            steps of the optimizer, and its name with its options.
        """
        return {
            "hardness": self.options.hardness,
            "hardness_bound": self.options.hardness_bound,
            "max_steps": self.options.max_steps,
            "optimizer": self.options.optimizer,
        }

    def _check_moment(self, moment: float) -> None:
        """Raise `ValueError` unless a step has a time if, and only if, it creeps."""
        creeps, timed = self.problem.solid.creep is not None, not math.isnan(moment)
        if creeps and not timed:
            raise ValueError(
                "a viscoelastic solid needs a path in time: use time_path, "
                "sliding_path with a Schedule, or an elastic limit of the solid, "
                "solid.solid or solid.relaxed"
            )
        if timed and not creeps:
            raise ValueError(f"only a viscoelastic solid needs a time, got {moment}")

    def _at_target(self, state: State, target: float) -> tuple[State, Support]:
        """Return a state at a target, and the support of the indenter there."""
        first_contact = self.windows.first_contact
        if self.control == LOAD:
            # out of contact nothing but the load acts, and some optimizers divide by 0
            height = min(state.height, first_contact)
            return state.at(height), Support(False, float(target), self._springs)
        if self.control == BASE:
            spring = Spring(self.options.cantilever, target)
            return state, Support(False, 0.0, spring)
        height = float(self.control.height(target, first_contact))
        return state.at(height), Support(True, 0.0, self._springs)


def _encode(value: Any) -> Any:
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return digest(value.tobytes())
    raise ValueError(
        "a trajectory needs a description of the system, but "
        f"{type(value).__name__} has none: give it a method todict that returns its "
        "name and parameters, or leave the trajectory out"
    )
