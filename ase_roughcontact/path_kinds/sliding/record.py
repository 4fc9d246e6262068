"""Output columns of sliding paths."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ase_roughcontact.results.column import Range, column, column_on_request
from ase_roughcontact.results.record import LoadStep, columns_of
from ase_roughcontact.windows.memory import friction_memory

#: Paths that move the base of a spring.
WITH_SPRING = Range(
    "paths with a spring", lambda s: not np.isnan(s.lateral.base).any(), constant=True
)
_WITH_WEAKENING = Range(
    "friction that depends on slip", lambda s: s.lateral.friction.law.weakens, True
)
_WITH_FRICTION = Range("contacts with friction", lambda s: s.lateral.bound > 0.0)


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
        WITH_SPRING,
    )
    base_y: float = column(
        lambda s: float(s.lateral.base[1]),
        "displacement along y of the base of the spring",
        "Å",
        where=WITH_SPRING,
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
    largest_slip: float = column(
        lambda s: s.lateral.slipped,
        "longest way that an atom has slipped since it came into contact",
        "Å",
        where=_WITH_WEAKENING,
    )
    instabilities: int = column(
        lambda s: s.lateral.instabilities,
        "instabilities in the step: slip that grows without further load, as friction "
        "weakens by it",
    )
    released_energy: float = column(
        lambda s: s.lateral.released,
        "energy released by instabilities since the beginning",
        "eV",
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
