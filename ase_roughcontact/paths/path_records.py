"""Output columns of sliding paths, of paths in time, and of nominally flat contacts."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ase_roughcontact.contact import State
from ase_roughcontact.contact.creep import creep_energy, dissipation_rate
from ase_roughcontact.elasticity.creep import Creep
from ase_roughcontact.results.column import Range, column, column_on_request
from ase_roughcontact.results.record import LoadStep, columns_of
from ase_roughcontact.stepping.relaxed import RelaxedStep
from ase_roughcontact.windows.memory import friction_memory

_WITH_SPRING = Range(
    "paths with a spring", lambda s: not np.isnan(s.lateral.base).any(), constant=True
)
_WITH_FRICTION = Range("contacts with friction", lambda s: s.lateral.bound > 0.0)
_IN_TIME = Range("paths in time", lambda s: not math.isnan(s.time), constant=True)
_ON_CANTILEVER = Range(
    "the base of a cantilever", lambda s: not math.isnan(s.base), constant=True
)
_PERIODIC = Range("periodic cells", lambda s: s.halfspace.periodic, constant=True)


@dataclass(frozen=True)
class SlidingStep(LoadStep):
    """Result of one step with friction; its attributes are the output columns."""

    lateral_x: float = column(
        lambda s: float(s.lateral.displacement[0]),
        "lateral displacement of the indenter along x",
        "Å",
        "x",
    )
    lateral_y: float = column(
        lambda s: float(s.lateral.displacement[1]),
        "lateral displacement of the indenter along y",
        "Å",
    )
    lateral_force_x: float = column(
        lambda s: float(s.lateral.force[0]),
        "force along x that holds the indenter against friction",
        "eV/Å",
        "friction",
    )
    lateral_force_y: float = column(
        lambda s: float(s.lateral.force[1]),
        "force along y that holds the indenter against friction",
        "eV/Å",
    )
    base_x: float = column(
        lambda s: float(s.lateral.base[0]),
        "displacement along x of the base of the spring",
        "Å",
        "base",
        _WITH_SPRING,
    )
    base_y: float = column(
        lambda s: float(s.lateral.base[1]),
        "displacement along y of the base of the spring",
        "Å",
        where=_WITH_SPRING,
    )
    largest_friction: float = column(
        lambda s: s.lateral.bound,
        "lateral force if all atoms slip in one direction: with a friction coefficient "
        "mu, mu times the repulsive part of the normal force",
        "eV/Å",
    )
    stick_area: float = column(
        lambda s: s.lateral.sticking * s.fields.cell_area,
        "area of the atoms in contact that stick; those without friction, under a "
        "pressure of zero or a tension, neither stick nor slip",
        "Å^2",
        "stick",
    )
    slip_area: float = column(
        lambda s: s.lateral.slipping * s.fields.cell_area,
        "area of the atoms in contact that slip in the step, their tractions at the "
        "bounds",
        "Å^2",
        "slip",
    )
    lateral_stiffness = column_on_request(
        lambda s: s.lateral.stiffness,
        "of sliding paths: derivative of the lateral force along x to the "
        "displacement, if all atoms that friction acts on stuck: with a coefficient, "
        "the repelled ones",
        "eV/Å^2",
        "lateral stiffness",
    )
    lateral_energy: float = column(
        lambda s: s.lateral.energy,
        "elastic energy of the tractions, and of their coupling to the pressure",
        "eV",
    )
    dissipated_energy: float = column(
        lambda s: s.lateral.dissipated, "energy lost by slip since the beginning", "eV"
    )
    memory: float = column(
        lambda s: (
            columns_of()["memory"].value(s)
            + friction_memory(
                s.lateral.solution.slipping.size, s.lateral.alternations > 0
            )
        ),
        "estimated peak memory, also for friction",
        "bytes",
        where=columns_of()["memory"].where,
    )
    friction_residual: float = column(
        lambda s: s.lateral.solution.residual,
        "residual of the conditions of friction, relative to the largest traction",
        where=_WITH_FRICTION,
    )
    friction_pairs: float = column(
        lambda s: s.lateral.solution.pairs,
        "FFT pairs of two components for friction, on the box of the tractions",
    )
    alternations: int = column(
        lambda s: s.lateral.alternations,
        "solutions in turn of the normal and the lateral problem until they agree, 0 "
        "without coupling",
    )


def _of_creep(step: RelaxedStep, density: Callable[[State, Creep], float]) -> float:
    creep = step.problem.solid.creep
    return step.fields.cell_area * density(step.run.state, creep) if creep else 0.0


@dataclass(frozen=True)
class TimeStep(LoadStep):
    """Result of one time step; its attributes are the output columns.

    Errors are those of the contact; those of the time steps come in addition.
    """

    time: float = column(
        lambda s: s.time, "time since the beginning", "s", "time", _IN_TIME
    )
    energy: float = column(
        lambda s: s.run.energy + _of_creep(s, creep_energy),
        "energy of solid, wall and load that is stored",
        "eV",
    )
    dissipation: float = column(
        lambda s: _of_creep(s, dissipation_rate),
        "power that the solid dissipates",
        "eV/s",
        where=_IN_TIME,
    )
    dissipated_energy: float = column(
        lambda s: 0.0,
        "energy that the solid has dissipated since the last step",
        "eV",
        where=_IN_TIME,
    )
    lost_energy: float = column(
        lambda s: 0.0,
        "energy lost since the last step in an instability at the instantaneous "
        "modulus; zero below the tolerance of the time steps",
        "eV",
        where=_IN_TIME,
    )
    base: float = column(
        lambda s: s.base,
        "height of the base of the cantilever",
        "Å",
        where=_ON_CANTILEVER,
    )
    deflection: float = column(
        lambda s: s.height - s.base,
        "deflection of the cantilever, positive in compression",
        "Å",
        where=_ON_CANTILEVER,
    )


@dataclass(frozen=True)
class FlatStep(LoadStep):
    """Result for a nominally flat indenter; its attributes are the output columns."""

    default_columns = ("conductance",)

    nominal_pressure: float = column(
        lambda s: s.fields.normal_force / (s.fields.gap.size * s.fields.cell_area),
        "force over the area of the periodic cell",
        "eV/Å^3",
        "pressure",
        _PERIODIC,
    )
    mean_gap: float = column(
        lambda s: float(np.maximum(s.fields.gap, 0.0).mean()),
        "mean distance of the surfaces over the periodic cell",
        "Å",
        "mean gap",
        _PERIODIC,
    )
