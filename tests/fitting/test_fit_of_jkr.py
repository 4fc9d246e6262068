"""Fits of curves of JKR's theory, without a range of attraction, by scenes with one."""

import numpy as np
import pytest

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.fitting.fit import fit_curve
from ase_roughcontact.fitting.force_curve import ForceCurve
from ase_roughcontact.scene import Scene
from ase_roughcontact.theory import JKR

WORK, MODULUS = 0.06, 1.0  # J/m², GPa
SCENE = """
[substrate]
model = "atoms"
spacing = "0.5 nm"
contact_modulus = {modulus}
hardness = inf
[sphere]
radius = "{radius} nm"
[interaction]
kind = "adhesive"
work_of_adhesion = {work}
[path]
kind = "loop"
deepest = "1 nm"
cantilever = {stiffness}
tolerance = {tolerance}
"""
NM, NN = UNITS["nm"], UNITS["nN"]


def jkr_curve(radius, stiffness, deepest, noise, seed, points=150):
    """Approach and retraction at equal steps of the base, with noise (nm, N/m, nN)."""
    theory = JKR(radius * NM, MODULUS * UNITS["GPa"], WORK * UNITS["J/m²"])
    depth, force = theory.curve(2.2 * np.sqrt(radius * (deepest + 1.3)) * NM)
    k = stiffness * UNITS["N/m"]
    base = -depth - force / k  # falls while the contact grows
    stable = slice(int(np.argmax(base)), None)
    low = np.interp(deepest * NM, depth[stable], base[stable])
    base, force = base[stable][::-1], force[stable][::-1]
    points_up = np.linspace(low, base[-1] + 4.0 * NM, points)
    in_contact = np.interp(points_up, base, force)
    down = np.where(points_up <= 0.0, in_contact, 0.0)[::-1]
    up = np.where(points_up <= base[-1], in_contact, 0.0)
    forces = np.append(down, up[1:])
    forces += noise * NN * np.random.default_rng(seed).normal(size=forces.size)
    bases = np.append(points_up[::-1], points_up[1:])
    return ForceCurve(-(bases + forces / k), forces, k)


def scene(radius, stiffness, tolerance):
    return Scene.parse(
        SCENE.format(
            radius=radius,
            stiffness=stiffness,
            tolerance=tolerance,
            work=0.9 * WORK,
            modulus=1.1 * MODULUS,
        )
    )


@pytest.mark.slow  # a minute each
@pytest.mark.parametrize("seed", range(5))
def test_work_and_modulus_of_jkr_are_within_twice_the_errors(seed):
    curve = jkr_curve(150.0, 5.0, 3.0, noise=0.3, seed=seed)
    free = ["work_of_adhesion", "contact_modulus"]
    found = fit_curve(scene(150.0, 5.0, 3e-3), curve, free)
    distance = abs(found.values[:2] - [WORK, MODULUS])
    assert (distance < 2.0 * found.errors[:2]).all(), str(found)
    assert (found.errors[:2] < [0.05 * WORK, 0.1 * MODULUS]).all(), str(found)
    assert (distance > 2.0 * found.contributions["noise"][:2]).any()
