"""Atoms joined by harmonic springs, as a calculator of ASE."""

import numpy as np
from ase.calculators.calculator import Calculator, all_changes
from matscipy.neighbours import neighbour_list
from scipy.sparse import bsr_matrix


class Springs(Calculator):
    """Springs to shells of neighbours, given as ``{rest length: stiffness}``."""

    implemented_properties = ["energy", "forces"]

    def __init__(self, shells, **kwargs):
        super().__init__(**kwargs)
        self.shells = np.array(list(shells.items()), dtype=float)

    def calculate(self, atoms=None, properties=("energy",), system_changes=all_changes):
        super().calculate(atoms, properties, system_changes)
        rest, stiffness = self.shells.T
        i, vector, distance = neighbour_list("iDd", self.atoms, 1.12 * rest.max())
        stretch = distance[:, None] - rest
        shell = abs(stretch).argmin(axis=1)
        stretch = np.take_along_axis(stretch, shell[:, None], 1)[:, 0]
        tension = stiffness[shell] * stretch
        forces = np.zeros((len(self.atoms), 3))
        np.add.at(forces, i, (tension / distance)[:, None] * vector)
        energy = 0.25 * float(tension @ stretch)
        self.results = {"energy": energy, "forces": forces}


class OtherSlabs(Springs):
    """Other springs between many atoms than between a few."""

    def __init__(self, shells, change):
        super().__init__(shells)
        self.few, self.many = self.shells, change(self.shells)

    def calculate(self, atoms=None, *args, **kwargs):
        self.shells = self.few if len(atoms) < 50 else self.many
        super().calculate(atoms, *args, **kwargs)


class Softer(OtherSlabs):
    """Second springs half as stiff in slabs as in crystals."""

    def __init__(self, shells):
        super().__init__(shells, lambda springs: springs * [1.0, 0.5])


def fcc_springs(a, first=1.0, second=0.1):
    """Springs in an fcc crystal of lattice constant a, and its C11, C12 and C44."""
    constants = (2 * first + 4 * second) / a, first / a, first / a
    return Springs({a / np.sqrt(2): first, a: second}), constants


class SpringsAtRest(Springs):
    """Springs with the Hessian of atoms between which they have no tension."""

    def get_hessian(self, atoms, format="sparse"):
        rest, stiffness = self.shells.T
        i, j, vector, distance = neighbour_list("ijDd", atoms, 1.12 * rest.max())
        shell = abs(distance[:, None] - rest).argmin(axis=1)
        direction = vector / distance[:, None]
        blocks = np.einsum("n,ni,nj->nij", stiffness[shell], direction, direction)
        first = np.searchsorted(i, np.arange(len(atoms) + 1))
        size = 3 * len(atoms)
        between = bsr_matrix((blocks, j, first), shape=(size, size))
        itself = bsr_matrix((blocks, i, first), shape=(size, size))
        return itself - between


def diamond_springs(a, first=1.0, second=0.2):
    """Springs in diamond of lattice constant a, and its C11, C12 and C44.

    The displacement of the sublattices leaves no energy of the first springs in C44.
    """
    constants = first / 3 + 4 * second, first / 3 + 2 * second, 2 * second
    springs = SpringsAtRest({a * 3**0.5 / 4: first, a / 2**0.5: second})
    return springs, tuple(constant / a for constant in constants)
