"""One step of a quasi-static path: set the target, choose the window, relax."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from ase_roughcontact._util.identity import digest
from ase_roughcontact._util.validation import function, instance_of, one_of
from ase_roughcontact.contact import Contact, Problem, State
from ase_roughcontact.contact.state import PLASTIC_DEPTH
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.paths.accuracy import accuracy_of
from ase_roughcontact.paths.convergence import StepRelaxer
from ase_roughcontact.paths.extrapolation import Extrapolation
from ase_roughcontact.paths.record import LoadStep, Step
from ase_roughcontact.paths.relaxed import RelaxedStep
from ase_roughcontact.paths.step_options import CONTROLS, FREE, StepOptions
from ase_roughcontact.paths.surface_history import SurfaceHistory
from ase_roughcontact.solvers.relaxation import External, Run, Support, fields_of
from ase_roughcontact.windows.auto import AutoWindow
from ase_roughcontact.windows.fixed import FixedWindow


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
        Of this state; None before the first step and after one that failed.
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
        instance_of(Problem, problem=problem)
        one_of(CONTROLS, control=control)
        instance_of((State, Box), start=start)
        options = StepOptions() if options is None else options
        instance_of(StepOptions, options=options)
        if springs is not None:
            function(springs=springs)
        self.problem, self.control = problem, control
        self.options = options
        self._relax = StepRelaxer(problem, options)
        self._springs = springs
        self._extrapolation = Extrapolation()
        self._surface = SurfaceHistory(problem)
        # quasi-static states under attraction depend on where they start
        creep = problem.solid.creep is not None
        self._continuous = creep or not problem.wall.attractive
        self.windows: AutoWindow | FixedWindow
        if options.keeps_window or problem.periodic:
            window = start if isinstance(start, Box) else start.window
            self._surface.on(State.flat(window, 0.0))
            checked = options.window != "unchecked"
            first_contact = self.contact.first_contact
            self.windows = FixedWindow(problem, window, checked, first_contact)
        else:
            self.windows = AutoWindow(problem)
        if isinstance(start, Box):
            start = State.flat(start, self.windows.first_contact)
        self.state: State = start
        self.run: Run | None = None

    @property
    def accuracy(self) -> float:
        """Relative error of forces that the tolerance is made for."""
        return accuracy_of(self.options.accuracy, self.options.continuum).error

    @property
    def contact(self) -> Contact:
        """Contact on the window of the last state."""
        return self._surface.contact

    def limit_error(self, error: float) -> None:
        """Let the solver leave at most an error; see `StepOptions.solver_error`."""
        self.options = replace(self.options, solver_error=error)
        self._relax = StepRelaxer(self.problem, self.options)

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
        self.state = self._surface.begun(self.state, elapsed)
        relaxed = self._relaxed(number, target, moment)
        if completed is not None:
            relaxed = completed(relaxed)
        result = record.of(relaxed)
        if self.problem.wall.permanent and relaxed.fields.plastic_atoms:
            self._keep_depth(relaxed)
        return result

    def repeat(
        self, relaxed: RelaxedStep, target: float, **history: np.ndarray
    ) -> RelaxedStep:
        """Relax a step again from where it has ended, with more history.

        Parameters
        ----------
        relaxed : RelaxedStep
            Whose cost is added.
        target : float
        **history : ndarray, shape (n, m)
            See `remember`.

        Returns
        -------
        RelaxedStep
        """
        for key, values in history.items():
            self.remember(key, values)
        return self._relaxed(relaxed.number, target, relaxed.time, relaxed.run)

    def restart_from(self, state: State, target: float | None = None) -> None:
        """Continue from a state, as if a step had ended there.

        Parameters
        ----------
        state : State
        target : float, optional
            Of this step.
        """
        self._extrapolation = Extrapolation()
        self.state = state = self._surface.at_rest(state)
        fields = fields_of(self.contact, state, relaxed=True)
        support = Support(self.control not in FREE, 0.0, self._springs)
        if target is not None:
            support = self._at(target)[1]
        self.run = Run.of(state, fields, support)

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
        if self.options.fmax is not None:
            more["fmax"] = self.options.fmax
        else:
            more["accuracy"] = self.accuracy
        if self.options.continuum:
            more["model"] = "continuum"
        described = self.problem.todict() | more
        described["lattice"] = self.windows.describe_lattice()
        return json.loads(json.dumps(described, default=_encode))

    def _keep_depth(self, relaxed: RelaxedStep) -> None:
        """Lower the surface by the depth at the end of a step, in contact and fields.

        Forces and energy stay: the plastic work becomes that of earlier steps.
        """
        self.remember(PLASTIC_DEPTH, relaxed.fields.plastic_depth)
        self.state = self._surface.on(self.state)
        fields = fields_of(self.contact, self.state, relaxed=True)
        self.run = replace(relaxed.run, state=self.state, fields=fields)

    def _relaxed(
        self,
        number: int,
        target: float,
        moment: float,
        repeated: Run | None = None,
    ) -> RelaxedStep:
        begun = time.perf_counter()
        if self.problem.wall.purely_hard:  # only the pressure is needed again
            self.state = replace(self.state, displacement=None)
        self.run = None
        last = self.state.height
        state, support = self._at(target)
        state = self.windows.choose(state, support, last)
        state = self._surface.on(state)
        start, along = None, target if math.isnan(moment) else moment
        # without a load nothing holds a sphere
        if (target or support.fixed) and repeated is None:
            start = self._extrapolation.start(state.window, along)
        run = self._relax(self.contact, state, support, repeated, start)
        while wider := self.windows.enlarged(run, self.contact):
            wider = self._surface.on(wider)
            run = self._relax(self.contact, wider, support, run)
        softness, run = self._surface.softness, self._surface.ended(run)
        self.state, self.run = run.state, run
        relaxed = RelaxedStep(
            problem=self.problem,
            contact=self.contact,
            run=run,
            number=number,
            first_contact=self.windows.first_contact,
            seconds=time.perf_counter() - begun,
            time=moment,
            base=target if self.control == "bases" else math.nan,
            control=self.control,
            options=self.options,
        )
        relaxed = self._relax.checked(relaxed, softness)
        if relaxed.run.converged and self._continuous and repeated is None:
            self._extrapolation.add(along, run.state, run.fields.pressure)
        return relaxed

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


def _spring(stiffness: float, base: float, height: float) -> tuple[float, float]:
    """Return the energy of a spring to a base, and its upward force."""
    extension = base - height
    return 0.5 * stiffness * extension**2, stiffness * extension


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
