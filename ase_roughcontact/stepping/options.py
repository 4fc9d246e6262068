"""Options of the steps of a path."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, get_args

from ase_roughcontact._util.identity import name_of
from ase_roughcontact._util.summary import Summarized
from ase_roughcontact._util.validation import function, integer, one_of, positive
from ase_roughcontact.contact import Contact, State
from ase_roughcontact.contact.support import Support
from ase_roughcontact.solvers.relaxation import Run, SolverRelaxer, Start
from ase_roughcontact.stepping.accuracy import Accuracy, GridModel

#: Relaxes a contact from a state, to a tolerance in at most some steps; see
#: `SolverRelaxer`.
Relaxer: TypeAlias = Callable[
    [Contact, State, Support, float, int, "Start | None"], Run
]

#: Whether the window of atoms is kept, and checked; see `load_path`.
Window: TypeAlias = Literal["fixed", "unchecked", "auto"]


@dataclass(frozen=True, kw_only=True)
class StepOptions(Summarized):
    """Options of the steps of a path; see `load_path`.

    Attributes
    ----------
    relaxer : Relaxer, optional
        The relaxation; by default the recommended solver for the wall.
    fmax, accuracy, max_steps, window
        See `load_path`.
    hardness : float
        Hardness with which pressures are compared; infinity or NaN for none (pressure).
    hardness_bound : float
        Pressure that a body of unknown hardness can hardly bear; NaN without such a
        body, and for rubbers (pressure).
    yield_strength : float
        Yield strength with which the largest von Mises stress below the surface is
        compared; NaN for none (pressure).
    continuum : bool
        Whether the continuum is asked for, and not the model of atoms.
    lost_slope : float
        Part of the rms slope that the grid can't resolve, and that is lost.
    cantilever : float
        Stiffness of the spring between the indenter and a base at a given height
        (force/length).
    solver_error : float
        Largest error of the normal force that the solver may leave, relative to the
        forces in contact, if it is smaller than the error that `accuracy` allows.
    scan_errors : ScanErrors, optional
        Function of a `RelaxedStep` that returns its errors by the scan that is pressed,
        with a method `todict` that describes them.

    Raises
    ------
    ValueError
        If an option is not valid.
    TypeError
        If `scan_errors` is not callable.
    """

    relaxer: Relaxer | None = None
    fmax: float | None = None
    accuracy: Accuracy = "normal"
    max_steps: int = 10_000
    window: Window = "fixed"
    hardness: float = math.nan
    hardness_bound: float = math.nan
    yield_strength: float = math.nan
    continuum: bool = False
    lost_slope: float = 0.0
    cantilever: float = 0.0
    solver_error: float = math.inf
    scan_errors: Any = None

    def __post_init__(self) -> None:
        """Check the options."""
        one_of(get_args(Window), window=self.window)
        if self.fmax is not None:
            positive(fmax=self.fmax)
        integer("max_steps", self.max_steps, 1)
        if self.scan_errors is not None:
            function(scan_errors=self.scan_errors)
        _ = self.grid_model

    @property
    def grid_model(self) -> GridModel:
        """Model that the grid samples, and the error asked for."""
        return GridModel("continuum" if self.continuum else "atoms", self.accuracy)

    @property
    def keeps_window(self) -> bool:
        """Whether all states have the window of the first one."""
        return self.window != "auto"

    @property
    def optimizer(self) -> str:
        """Name of the solver or optimizer and its options; empty for the default."""
        if self.relaxer is None:
            return ""
        if isinstance(self.relaxer, SolverRelaxer):
            options = "" if self.relaxer.options is None else f" {self.relaxer.options}"
            return f"{self.relaxer.solver.__name__}{options}"
        return name_of(self.relaxer)
