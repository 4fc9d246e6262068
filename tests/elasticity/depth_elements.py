"""Compliance of plane waves by finite elements through the depth of a solid.

An independent reference: displacements ``u(z) exp(i q x')`` on quadratic elements,
for any stack of anisotropic materials.
"""

from itertools import pairwise

import numpy as np
from matscipy.elasticity import Voigt_6x6_to_full_3x3x3x3
from numpy.polynomial.legendre import leggauss


def isotropic(contact_modulus, poisson):
    """Stiffness matrix (6, 6) from contact modulus and Poisson's ratio."""
    shear = contact_modulus * (1 - poisson) / 2
    lame = 2 * shear * poisson / (1 - 2 * poisson)
    stiffness = np.diag([2 * shear] * 3 + [shear] * 3)
    stiffness[:3, :3] += lame
    return stiffness


def compliance(stack, q, angle=0.0, bonded=True):
    """Compliance under normal pressure of a stack of (stiffness, mesh of depths).

    The bottom of the last mesh is clamped. A stack slides at its first interface if it
    is not bonded; a single layer then slides on the rigid base.
    """
    wave = q * np.array([np.cos(angle), np.sin(angle), 0.0])
    elements = []  # of stiffness, top, bottom, degrees of freedom of its three nodes
    number, dof = 3, [0, 1, 2]
    for part, (stiffness, depths) in enumerate(stack):
        if part == 1 and not bonded:
            dof = [number, number + 1, dof[2]]
            number += 2
        for top, bottom in pairwise(depths):
            middle, end = ([*range(n, n + 3)] for n in (number, number + 3))
            elements.append((stiffness, top, bottom, dof + middle + end))
            number, dof = number + 6, end
    matrix = np.zeros((number, number), dtype=complex)
    for stiffness, top, bottom, where in elements:
        tensor = Voigt_6x6_to_full_3x3x3x3(stiffness)
        length = bottom - top
        for x, weight in zip(*leggauss(3), strict=True):
            values = np.array([x * (x - 1) / 2, 1 - x * x, x * (x + 1) / 2])
            slopes = np.array([x - 0.5, -2 * x, x + 0.5]) * 2 / length
            # gradient of each nodal displacement; z points up, depth down
            gradient = 1j * values[:, None] * wave
            gradient[:, 2] -= slopes
            block = np.einsum("aj,ijkl,bl->aibk", gradient.conj(), tensor, gradient)
            matrix[np.ix_(where, where)] += weight * length / 2 * block.reshape(9, 9)
    free = np.ones(number, dtype=bool)
    free[dof if bonded or len(stack) > 1 else dof[2:]] = False
    load = np.zeros(number)
    load[2] = 1.0
    solution = np.linalg.solve(matrix[np.ix_(free, free)], load[free])
    return float(solution[np.flatnonzero(free) == 2][0].real)
