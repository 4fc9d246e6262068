"""The solver that is recommended for a wall."""

from ase_roughcontact.interactions import Interaction
from ase_roughcontact.solvers.active_set import active_set
from ase_roughcontact.solvers.newton import newton_krylov
from ase_roughcontact.solvers.relaxation import SolverRelaxer


def default_relaxer(wall: Interaction) -> SolverRelaxer:
    """Return `active_set` for a hard wall without attraction, else `newton_krylov`."""
    plain = wall.purely_hard
    return SolverRelaxer(active_set if plain else newton_krylov)
