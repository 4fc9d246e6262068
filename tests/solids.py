"""Solids of other kinds than the isotropic one, in units of a modulus and a spacing."""

import numpy as np
from ase.build import bulk
from spring_crystal import fcc_springs

from ase_roughcontact.elasticity import Crystal, Cubic, Layer

CONTINUA = {
    "cubic": Cubic(1.2, 1.0, 0.4),
    "soft layer": Layer(0.5, 3.0, 2.0, 0.3, 0.2),
    "hard layer": Layer(3.0, 1.5, 0.7, 0.2, 0.4),
    "sliding layer": Layer(1.0, 4.0, poisson=0.3, bonded=False),
    "incompressible layer": Layer(1.0, 6.0),
}


def spring_crystal():
    """Crystal of springs to first and second neighbours."""
    springs, _ = fcc_springs(np.sqrt(2))
    return Crystal.from_calculator(springs, bulk("Cu", a=np.sqrt(2)), layers=9, size=5)
