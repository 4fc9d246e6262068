"""Output columns of paths in time."""

from __future__ import annotations

from dataclasses import dataclass

from ase_roughcontact.contact.creep import creep_energy, dissipation_rate
from ase_roughcontact.paths.record import LoadStep, column
from ase_roughcontact.paths.relaxed import RelaxedStep


def _energy_with_creep(step: RelaxedStep) -> float:
    creep = step.problem.solid.creep
    of_past = creep_energy(step.run.state, creep) if creep else 0.0
    return step.run.energy + step.fields.cell_area * of_past


def _dissipation(step: RelaxedStep) -> float:
    creep = step.problem.solid.creep
    power = dissipation_rate(step.run.state, creep) if creep else 0.0
    return step.fields.cell_area * power


@dataclass(frozen=True)
class TimeStep(LoadStep):
    """Result of one time step; its attributes are the output columns."""

    time: float = column(lambda s: s.time, "time since the beginning", "s", "time")
    energy: float = column(
        _energy_with_creep, "energy of solid, wall and load that is stored", "eV"
    )
    dissipation: float = column(_dissipation, "power that the solid dissipates", "eV/s")
    dissipated_energy: float = column(
        lambda s: 0.0, "energy that the solid has dissipated since the last step", "eV"
    )
    lost_energy: float = column(
        lambda s: 0.0,
        "energy lost since the last step in an instability at the instantaneous "
        "modulus; zero below the tolerance of the time steps",
        "eV",
    )
    base: float = column(
        lambda s: s.base, "height of the base of the cantilever, nan without one", "Å"
    )
    deflection: float = column(
        lambda s: s.height - s.base,
        "deflection of the cantilever, positive in compression, nan without one",
        "Å",
    )
