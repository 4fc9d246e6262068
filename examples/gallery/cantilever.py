"""
The tip of an AFM on its cantilever
===================================

A smooth adhesive tip hangs on a soft spring, ASE's ``Hookean``. The end of the spring
is lowered and raised again: the tip snaps in and is pulled off.
"""

import matplotlib.pyplot as plt
import numpy as np
from ase.constraints import Hookean

from ase_roughcontact import (
    LennardJones93,
    NewtonKrylov,
    RoughContact,
    RoughSphere,
    substrate,
)
from ase_roughcontact.plot import style
from ase_roughcontact.theory import MaugisDugdale

STEPS = 140  # each way

# %%
# Lengths are in units of the lattice spacing, pressures in units of E*. The spring
# constant is half of pi w R per spacing, which is soft compared with the contact.

radius, work = 50.0, 0.02
unit = np.pi * work * radius
tip = RoughSphere(radius)
wall = LennardJones93.adhesive(1.0, 1.0, work)
atoms = substrate("Cu", (30, 30), tip, spacing=1.0, height=3.0, fixed=False)
atoms.calc = RoughContact(tip, 1.0, wall)

# %%
# A spring to a point above or below the indenter is honoured by the solvers of this
# package. Each step starts from the state before, so that the path decides between the
# metastable states.

ends = np.append(np.linspace(6.0, -1.0, STEPS), np.linspace(-1.0, 6.0, STEPS))
heights, forces = [], []
for z in ends:
    point = (*atoms.positions[-1, :2], z)
    atoms.set_constraint(Hookean(len(atoms) - 1, point, k=0.5 * unit, rt=0.0))
    NewtonKrylov(atoms, logfile=None).run(fmax=1e-6)
    heights.append(atoms.positions[-1, 2])
    forces.append(atoms.calc.state(atoms).normal_force)

# %%
# The largest force, now applied as a load instead of by the spring, must give the same
# height.

atoms.set_constraint()
atoms.calc.set(load=max(forces))
atoms.positions[-1, 2] = 1.0
NewtonKrylov(atoms, logfile=None).run(fmax=1e-6)
difference = abs(atoms.positions[-1, 2] - min(heights))
print(f"heights under the load and on the spring differ by {difference:.0e} a0")

# %%
# The pull-off force is that of Maugis and Dugdale for the same work of adhesion and the
# same range of the attraction.

theory = MaugisDugdale(radius, 1.0, work, wall.attraction_range).pull_off_force
error = float(-min(forces) / theory - 1)
print(f"pull-off force {-min(forces):.3f} E* a0^2, relative error {100 * error:.1f} %")

with style():
    figure, axes = plt.subplots()
    axes.plot(ends[:STEPS], forces[:STEPS], "-", lw=2, label="approach")
    axes.plot(ends[STEPS:], forces[STEPS:], "-", label="retraction")
    axes.axhline(theory, color="k", ls="--", label="pull-off, Maugis-Dugdale")
    axes.set(xlabel="height of the base / $a_0$", ylabel="force / $E^* a_0^2$")
    axes.set_ylim(top=3.5)
    axes.legend()
    figure.savefig("cantilever.png", dpi=200)
