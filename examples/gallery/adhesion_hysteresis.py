"""
Adhesion hysteresis from heterogeneity and from waviness
========================================================

A sphere whose attraction has a long range comes into contact and leaves it along the
same curve. A work of adhesion that varies over the surface, or waves on the sphere,
make it jump, and energy is lost.
"""

import matplotlib.pyplot as plt
import numpy as np

from ase_roughcontact import (
    DugdaleWall,
    HeightMap,
    Heterogeneity,
    RoughContact,
    RoughSphere,
    adhesion_loop,
    substrate,
)
from ase_roughcontact.paths.instabilities import interpolated
from ase_roughcontact.plot import style

RADIUS, WORK, RANGE = 100.0, 0.02, 0.8
DEEPEST = 0.7
PATCHES, WAVES = 32.0, 20.0

# %%
# Lengths are in units of the lattice spacing, pressures in units of E*. The parameter
# of Maugis is 0.48, too small for an instability of a smooth sphere.


def patches(x, y):
    """Return the relative deviation of the work of adhesion."""
    return 0.9 * np.cos(2 * np.pi * x / PATCHES) * np.cos(2 * np.pi * y / PATCHES)


x = np.arange(-64.0, 65.0)
waves = HeightMap(0.2 * np.cos(2 * np.pi * np.hypot(x[:, None], x) / WAVES), 1.0)
spheres = RoughSphere(RADIUS), RoughSphere(RADIUS), RoughSphere(RADIUS, waves)
adhesions = None, Heterogeneity(patches), None
names = "smooth and uniform", "patches of adhesion", "waves on the sphere"


def loop_of(sphere, adhesion):
    """Return the adhesion loop of a sphere."""
    atoms = substrate("Cu", (16, 16), sphere, spacing=1.0)
    wall = DugdaleWall(WORK, RANGE)
    atoms.calc = RoughContact(sphere, 1.0, wall, heterogeneity=adhesion)
    return adhesion_loop(atoms, DEEPEST, 0.17, window="auto", validity="ignore")


# %%
# Energies are in units of (w^5 R^4/E*^2)^(1/3), forces in units of pi w R. The small
# maps show the work of adhesion and the height of the waves, bright where they are
# large.

force, energy = np.pi * WORK * RADIUS, np.cbrt(WORK**5 * RADIUS**4)
window = (49, 49), 1.0, (-24.0, -24.0)
maps = None, adhesions[1].factors(*window), waves.heights(*window)
lost = {}
with style():
    figure, axes = plt.subplots(1, 3, figsize=(9.0, 3.4), sharey=True, layout="tight")
    for i, ax in enumerate(axes):
        loop = loop_of(spheres[i], adhesions[i])
        lost[names[i]] = loop.dissipated_energy / energy
        print(f"{names[i]}: energy lost {lost[names[i]]:.3f}")
        for steps, jumps, line in (
            (loop.approach, loop.approach_jumps, "--"),
            (loop.retraction, loop.retraction_jumps, "-"),
        ):
            heights, forces = interpolated(steps, jumps)
            ax.plot(heights, forces / force, line)
        ax.set(title=names[i], xlabel="height of the sphere / $a_0$")
        ax.set(xlim=(-0.4, 1.5), ylim=(-2.3, 0.4))
        if maps[i] is not None:
            inset = ax.inset_axes((0.7, 0.06, 0.28, 0.42), xticks=[], yticks=[])
            inset.imshow(maps[i])
    axes[0].legend(axes[0].lines, ("approach", "retraction"))
    axes[0].set(ylabel=r"force / $\pi w R$")
    figure.savefig("adhesion_hysteresis.png", dpi=150)
