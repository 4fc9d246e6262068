"""Output columns of sliding paths in time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ase_roughcontact.contact.creep import CreepLoad
from ase_roughcontact.elasticity.creep import Creep
from ase_roughcontact.interactions.rate_and_state import STATE
from ase_roughcontact.path_kinds.sliding.lateral_state import LateralState
from ase_roughcontact.path_kinds.sliding.record import WITH_SPRING, SlidingStep
from ase_roughcontact.results.column import Range, column
from ase_roughcontact.solvers.lateral.rate_step import elastic_energy

_WITH_BOUNDS = Range(
    "friction that does not depend on the slip rate: otherwise all atoms slip",
    lambda s: False,
    constant=True,
)
_IN_CONTACT = Range("contacts with friction", lambda s: s.lateral.slipping > 0)
_CREEPS = Range(
    "viscoelastic solids", lambda s: s.lateral.creep is not None, constant=True
)
_WITH_STATE = Range(
    "contacts with rate and state friction",
    lambda s: _IN_CONTACT.includes(s) and STATE in s.lateral.friction.law.histories,
)


@dataclass(frozen=True, kw_only=True, eq=False)
class TimedLateralState(LateralState):
    """Lateral state of a contact at a time.

    Attributes
    ----------
    time : float
        Time since the beginning.
    rates : ndarray, shape (2, n, m)
        Slip rates (length/time).
    work : float
        Work of the drive since the beginning (eV).
    time_error : float
        Error of the time step, relative to the friction.
    spring : float
        Stiffness of the spring, zero without one (eV/Å^2).
    creep : Creep or None
        Creep of the solid.
    load : CreepLoad
        Tractions, also of the past, with their displacements.
    crept : float
        Energy lost by creep under the tractions since the beginning (eV).
    """

    time: float
    rates: np.ndarray
    load: CreepLoad
    creep: Creep | None = None
    crept: float = 0.0
    work: float = 0.0
    time_error: float = 0.0
    spring: float = 0.0

    @property
    def loads(self) -> np.ndarray:
        """Tractions that displace the surface, also of the past (eV/Å^3)."""
        return sum(self.load.past, self.load.present)

    @property
    def energy(self) -> float:
        """Elastic energy of the tractions, also stored by creep (eV)."""
        return self.cell_area * elastic_energy(self.load, self.creep)

    @property
    def slip_rate(self) -> float:
        """Mean slip rate of the atoms with friction (Å/s)."""
        return float(np.hypot(*self.rates)[self.solution.slipping].mean())

    @property
    def mean_state(self) -> float:
        """Mean state of friction of the atoms with friction, see `STATE`."""
        state = self.friction.history[STATE.name]
        return float(state[self.solution.slipping].mean())

    @property
    def spring_energy(self) -> float:
        """Energy of the spring (eV)."""
        return 0.5 * float(self.force @ self.force) / self.spring


@dataclass(frozen=True)
class TimedSlidingStep(SlidingStep):
    """Result of one time step with friction; its attributes are the output columns."""

    energy: float = column(
        lambda s: s.stored_energy,
        "energy of solid, wall and load, with the work of plastic flow, without "
        "friction",
        "eV",
    )
    stick_area: float = column(
        lambda s: np.nan,
        "area of the atoms in contact that stick",
        "Å^2",
        "stick",
        _WITH_BOUNDS,
    )
    time: float = column(
        lambda s: s.lateral.time, "time since the beginning", "s", "time"
    )
    slip_rate: float = column(
        lambda s: s.lateral.slip_rate,
        "mean slip rate of the atoms with friction",
        "Å/s",
        "rate",
        _IN_CONTACT,
    )
    friction_state: float = column(
        lambda s: s.lateral.mean_state,
        "mean of the state ln(V0 theta/Dc) of rate and state friction, zero in steady "
        "sliding at the reference rate V0",
        "",
        "state",
        _WITH_STATE,
    )
    work: float = column(
        lambda s: s.lateral.work,
        "work of the drive since the beginning: stored as elastic energy, in the "
        "spring, or lost by slip and creep",
        "eV",
    )
    creep_loss: float = column(
        lambda s: s.lateral.crept,
        "energy lost by creep of the solid under the tractions since the beginning",
        "eV",
        where=_CREEPS,
    )
    spring_energy: float = column(
        lambda s: s.lateral.spring_energy,
        "elastic energy of the lateral spring",
        "eV",
        where=WITH_SPRING,
    )
    time_error: float = column(
        lambda s: s.lateral.time_error,
        "estimated error of the time step, relative to the friction",
    )
