"""
A smooth sphere
===============

A smooth sphere is pressed into copper, and the contact is compared with the solution of
Hertz. This is the shortest complete calculation.
"""

import matplotlib.pyplot as plt
from ase.units import GPa

from ase_roughcontact import (
    ActiveSet,
    HardWall,
    Hertz,
    RoughContact,
    RoughSphere,
    substrate,
)
from ase_roughcontact.analysis import ContactMap
from ase_roughcontact.plot import plot_pressure, style

SIZE = 64  # atoms along a side of the window

# %%
# Set up
# ------
# ``substrate`` builds the surface atoms of the elastic solid and, as the last atom, the
# indenter. The calculator needs the indenter, the contact modulus and the interaction
# between the two surfaces, here a hard wall as in the theory of Hertz.

radius = 25.0 * SIZE  # Å
depth = SIZE / 20  # Å
modulus = 145 * GPa

sphere = RoughSphere(radius)
atoms = substrate("Cu", (SIZE, SIZE), sphere, height=-depth)
atoms.calc = RoughContact(sphere, modulus, HardWall())

# %%
# Relax
# -----
# A hard wall is a constraint rather than a potential. ``ActiveSet`` is the solver for
# it; like every ASE optimizer it returns whether it has converged.

optimizer = ActiveSet(atoms)
if not optimizer.run(fmax=1e-6):
    raise RuntimeError(f"not converged: {optimizer.message}")

# %%
# Compare
# -------

force = atoms.calc.state(atoms).normal_force
hertz = Hertz(radius, modulus)
contact_radius = hertz.contact_radius_from_penetration(depth)
error = force / hertz.force(contact_radius) - 1
print(f"force {force:.4f} eV/Å, relative difference from Hertz: {100 * error:.2f} %")

with style():
    figure, axes = plt.subplots()
    plot_pressure(axes, ContactMap.from_atoms(atoms), float(contact_radius))
    figure.savefig("first_contact.png", dpi=200)
