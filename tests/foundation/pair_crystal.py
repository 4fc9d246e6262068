"""Crystal of atoms with a pair potential whose Hessian is known."""

from ase.build import bulk
from matscipy.calculators.pair_potential import LennardJonesCut, PairPotential

from ase_roughcontact import CrystalSurface

A = 3.6


def pair_potential():
    return PairPotential({(29, 29): LennardJonesCut(0.4, A / 2**0.5 / 1.1, 1.3 * A)})


def pair_surface(name="fcc100", layers=11, size=7):
    return CrystalSurface.from_calculator(
        pair_potential(),
        bulk("Cu", a=A),
        name,
        layers=layers,
        size=size,
        displacement=0.0,
    )
