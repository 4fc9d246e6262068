"""Output columns of paths in time."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ase_roughcontact.contact.creep import dissipation_rate
from ase_roughcontact.results.column import Range, column
from ase_roughcontact.results.record import LoadStep
from ase_roughcontact.stepping.relaxed import RelaxedStep

_IN_TIME = Range("paths in time", lambda s: not math.isnan(s.time), constant=True)
_ON_CANTILEVER = Range(
    "the base of a cantilever", lambda s: not math.isnan(s.base), constant=True
)


def _dissipation(step: RelaxedStep) -> float:
    creep = step.problem.solid.creep
    power = dissipation_rate(step.run.state, creep) if creep else 0.0
    return step.fields.cell_area * power


@dataclass(frozen=True)
class TimeStep(LoadStep):
    """Result of one time step; its attributes are the output columns.

    Errors are errors of the contact; the errors of the time steps come in addition.
    """

    time: float = column(
        lambda s: s.time, "time since the beginning", "s", "time", _IN_TIME
    )
    energy: float = column(
        lambda s: s.stored_energy,
        "energy of solid, wall and load that is stored",
        "eV",
    )
    dissipation: float = column(
        _dissipation,
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
