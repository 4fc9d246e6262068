"""Walls, the interactions of the indenter with the substrate, and friction laws.

A wall is an energy per area ``V(g)`` of the local gap ``g`` between the rigid indenter
and an atom of the substrate. Pressure and stiffness follow from it::

    pressure   p(g) = -V'(g)     positive in compression (repulsion)
    stiffness  k(g) =  V''(g)

Walls accept any consistent set of units. Only `make_wall` and `Parameter`, which make
walls from scene files, use ASE's units.
"""

from ase_roughcontact._util.history import HistoryEntry
from ase_roughcontact._util.parameter import Parameter
from ase_roughcontact.interactions.base import (
    WALLS,
    Interaction,
    make_wall,
    scaled_attraction,
    wall_parameters,
)
from ase_roughcontact.interactions.friction import LAWS, SLIP
from ase_roughcontact.interactions.hard import HardWall, PlasticWall
from ase_roughcontact.interactions.hard_adhesive import (
    DugdaleWall,
    ExponentialWall,
    PowerLawWall,
)
from ase_roughcontact.interactions.lennard_jones import (
    AdhesiveLennardJones93,
    FullLennardJones93,
    LennardJones93,
    RepulsiveLennardJones93,
)
from ase_roughcontact.interactions.rate_and_state import (
    SLIP_RATES,
    STATE,
    RateAndState,
    RateFriction,
)
from ase_roughcontact.interactions.slip_weakening import SlipWeakening

__all__ = [
    "LAWS",
    "SLIP",
    "SLIP_RATES",
    "STATE",
    "WALLS",
    "AdhesiveLennardJones93",
    "DugdaleWall",
    "ExponentialWall",
    "FullLennardJones93",
    "HardWall",
    "HistoryEntry",
    "Interaction",
    "LennardJones93",
    "Parameter",
    "PlasticWall",
    "PowerLawWall",
    "RateAndState",
    "RateFriction",
    "RepulsiveLennardJones93",
    "SlipWeakening",
    "make_wall",
    "scaled_attraction",
    "wall_parameters",
]
