"""
Adhesion loops between DMT and JKR
==================================

A smooth sphere is brought into contact and pulled off again, for three walls with the
same work of adhesion and different ranges of the attraction.
"""

import matplotlib.pyplot as plt
import numpy as np

from ase_roughcontact import (
    LennardJones93,
    RoughContact,
    RoughSphere,
    adhesion_loop,
    substrate,
)
from ase_roughcontact.plot import style
from ase_roughcontact.theory import MaugisDugdale

RADIUS = 100.0
WORK = 0.02
STIFFNESSES = (0.01, 0.1, 1.0)

# %%
# Lengths are in units of the lattice spacing, pressures in units of E*. The function
# ``adhesion_loop`` chooses its steps and halves them where the contact jumps. The
# stiffer the wall, the shorter its attraction, and the closer the contact to JKR.


def loop_of(stiffness):
    """Return wall and adhesion loop for a stiffness of the wall."""
    sphere = RoughSphere(RADIUS)
    wall = LennardJones93.adhesive(1.0, 1.0, WORK, stiffness=stiffness)
    atoms = substrate("Cu", (16, 16), sphere, spacing=1.0)
    atoms.calc = RoughContact(sphere, contact_modulus=1.0, wall=wall)
    depth = np.cbrt(WORK**2 * RADIUS)  # scale of the penetration in JKR theory
    deepest = 3 * depth + wall.attraction_range / 2
    # the theory is that of a paraboloid, too, so that its width does not matter
    options = {"window": "auto", "validity": "ignore"}
    return adhesion_loop(atoms, deepest=deepest, step=depth / 2, **options)


loops = {stiffness: loop_of(stiffness) for stiffness in STIFFNESSES}

# %%
# The theory of Maugis and Dugdale describes all three, with a constant stress of the
# same work and the same range. Energy that the loop dissipates is in units of
# (w^5 R^4 / E*^2)^(1/3).

unit, energy = np.pi * WORK * RADIUS, np.cbrt(WORK**5 * RADIUS**4)
print("Maugis parameter  pull-off force/(pi w R)  Maugis-Dugdale  dissipated energy")
with style():
    figure, axes = plt.subplots()
    for stiffness, loop in loops.items():
        theory = MaugisDugdale(RADIUS, 1.0, WORK, np.sqrt(12 * WORK / stiffness))
        parameter = theory.parameter
        force, expected = loop.pull_off_force / unit, theory.pull_off_force / unit
        lost = loop.dissipated_energy / energy
        print(f"{parameter:16.3f}  {force:23.4f}  {expected:14.4f}  {lost:17.3f}")
        colour = f"C{STIFFNESSES.index(stiffness)}"
        for steps, line in ((loop.approach, "--"), (loop.retraction, "-")):
            points = [(step.height, step.normal_force / unit) for step in steps]
            label = rf"Maugis $\lambda$ = {parameter:.2f}" if line == "-" else ""
            axes.plot(*np.transpose(points), line, color=colour, label=label)
    axes.axhline(-1.5, color="k", ls="-.", label="pull-off, JKR")
    axes.axhline(-2.0, color="k", ls=":", label="pull-off, DMT")
    axes.set(xlabel="height of the sphere / $a_0$", ylabel=r"force / $\pi w R$")
    axes.set(xlim=(-0.8, 6), ylim=(-2.2, 2), title="approach (dashed) and retraction")
    axes.legend()
    figure.savefig("adhesion_loop.png", dpi=200)
