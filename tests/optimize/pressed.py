"""Atoms under a rough sphere at a penetration, which the tests of optimizers share."""

import numpy as np
from built import atoms_under

import ase_roughcontact as rc
from ase_roughcontact.atoms.calculator import contact_of

ROUGH = rc.RoughSphere(40.0, rc.SelfAffine(0.1, 0.8, 4.0, 16.0, seed=1))
SOFT = rc.LennardJones93.repulsive(1.0, 1.0)


def pressed_atoms(wall=SOFT, *, sphere=ROUGH, depth=0.5, n=14, **options):
    """Atoms of unit spacing and contact modulus at a penetration."""
    atoms = atoms_under(sphere, wall, (n, n), **options)
    atoms.positions[-1, 2] = contact_of(atoms).first_contact - depth
    return atoms


def calculated_anew(atoms):
    """A copy with a new calculator, which knows nothing of a solver."""
    fresh = atoms.copy()
    fresh.calc = rc.RoughContact(**atoms.calc.parameters)
    return fresh


def largest_force(atoms):
    """Largest force by a new calculator, including the padding."""
    return np.linalg.norm(calculated_anew(atoms).get_forces(), axis=1).max()
