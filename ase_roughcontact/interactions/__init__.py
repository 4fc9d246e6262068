"""Interaction between the surfaces: energy, pressure and stiffness of a gap.

An interaction is an energy per area ``V(g)`` of the local gap ``g`` between the
rigid indenter and an atom of the substrate. From it follow

::

    pressure   p(g) = -V'(g)     positive in compression (repulsion)
    stiffness  k(g) =  V''(g)

Everything here is free of units: any consistent set of them will do.
"""

from ase_roughcontact.interactions.base import HardWall, Interaction
from ase_roughcontact.interactions.lennard_jones import LennardJones93

__all__ = ["HardWall", "Interaction", "LennardJones93"]
