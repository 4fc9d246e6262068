"""
Adhesion hysteresis from heterogeneity and from roughness
=========================================================

A sphere whose attraction has a long range retraces its approach. A work of adhesion
that varies over the surface makes it jump, and energy is lost. So does random
roughness that a strong, short attraction flattens: it pins the edge of the contact.
"""

import matplotlib.pyplot as plt
import numpy as np

from ase_roughcontact import (
    DugdaleWall,
    Heterogeneity,
    RoughContact,
    RoughSphere,
    SelfAffine,
    adhesion_loop,
    substrate,
)
from ase_roughcontact.plot import style

RADIUS, RANGE = 100.0, 0.8
WEAK, STRONG = 0.02, 0.1
DEEPEST = 0.7
PATCHES = 32.0

# %%
# Lengths are in units of the lattice spacing, pressures in units of E*. With the weak
# adhesion the parameter of Maugis is 0.48, too small for an instability of a smooth
# sphere; with the strong one it is 1.4.


def patches(x, y):
    """Return the relative deviation of the work of adhesion."""
    return 0.9 * np.cos(2 * np.pi * x / PATCHES) * np.cos(2 * np.pi * y / PATCHES)


rough = SelfAffine(0.2, 0.8, 12.0, 24.0, seed=2, domain=192.0)
adhesion = Heterogeneity(patches)
cases = {
    "smooth and uniform": (RoughSphere(RADIUS), WEAK, None),
    "patches of adhesion": (RoughSphere(RADIUS), WEAK, adhesion),
    "random roughness": (RoughSphere(RADIUS, rough), STRONG, None),
}


def loop_of(sphere, work, heterogeneity):
    """Return the adhesion loop of a sphere."""
    atoms = substrate("Cu", (16, 16), sphere, spacing=1.0)
    wall = DugdaleWall(work, RANGE)
    atoms.calc = RoughContact(sphere, 1.0, wall, heterogeneity=heterogeneity)
    step = 0.5 * np.cbrt(work**2 * RADIUS)
    return adhesion_loop(
        atoms, deepest=DEEPEST, step=step, window="auto", validity="ignore"
    )


# %%
# Energies are in units of (w^5 R^4/E*^2)^(1/3), forces in units of pi w R. The small
# maps show the work of adhesion and the height of the roughness, bright where they are
# large.

window = (49, 49), 1.0, (-24.0, -24.0)
maps = None, adhesion.factors(*window), rough.heights(*window)
lost = {}
with style():
    figure, axes = plt.subplots(1, 3, figsize=(6.8, 2.8), sharey=True)
    for ax, (name, case), shown in zip(axes, cases.items(), maps, strict=True):
        loop, work = loop_of(*case), case[1]
        lost[name] = loop.dissipated_energy / np.cbrt(work**5 * RADIUS**4)
        print(f"{name}: energy lost {lost[name]:.3f}")
        first_contact = loop.turn.height + loop.turn.penetration
        for branch, line in (("approach", "--"), ("retraction", "-")):
            heights, forces = loop.curve(branch)
            depths = first_contact - heights
            ax.plot(depths, forces / (np.pi * work * RADIUS), line)
        ax.set_title(f"({'abc'[len(lost) - 1]}) {name}")
        ax.set(xlabel="depth / $a_0$", ylim=(-2.8, 0.5))
        if shown is not None:
            inset = ax.inset_axes((0.7, 0.04, 0.27, 0.38), xticks=[], yticks=[])
            inset.imshow(shown)
    axes[0].legend(axes[0].lines, ("approach", "retraction"))
    axes[0].set(ylabel=r"force / $\pi w R$")
    figure.savefig("adhesion_hysteresis.png", dpi=150)
