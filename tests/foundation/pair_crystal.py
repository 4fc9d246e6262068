"""Crystals of atoms with pair potentials and a known Hessian."""

from ase.build import bulk
from matscipy.calculators.pair_potential import LennardJonesCut, PairPotential
from spring_crystal import diamond_springs

from ase_roughcontact.foundation import CrystalSurface, crystal_slab

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


def diamond_surface():
    springs, _ = diamond_springs(A)
    crystal = bulk("Si", "diamond", a=A)
    return CrystalSurface.from_calculator(
        springs, crystal, "diamond100", layers=11, size=5, displacement=0.0
    )


def slab(surface, layers=2, size=(3, 4), **options):
    """Copper or diamond on its foundation."""
    symbol = surface.symbol
    calculator = pair_potential() if symbol == "Cu" else diamond_springs(A)[0]
    return crystal_slab(symbol, size, layers, calculator, surface, **options)[0]
