"""
One contact, five optimizers
============================

The same smooth sphere on the same soft wall is relaxed by optimizers of ASE on the
atoms, by optimizers of ASE on the scaled Fourier modes, and by Newton's method.
"""

from functools import partial

import matplotlib.pyplot as plt
import numpy as np
from ase.optimize import FIRE, FIRE2, LBFGS

from ase_roughcontact import (
    Hertz,
    LennardJones93,
    NewtonKrylov,
    RoughContact,
    RoughSphere,
    on_modes,
    substrate,
)
from ase_roughcontact.plot import plot_convergence, style

SIZE = 32  # atoms along a side of the window

# %%
# All optimizers have the interface of ASE. ``on_modes`` takes ``FourierModes`` in place
# of the atoms: in these coordinates the elastic energy has the same curvature in all
# directions. FIRE and FIRE2 limit the norm of a step over all atoms, so their
# ``maxstep`` must grow with the system.

optimizers = {
    "FIRE on atoms": partial(FIRE, maxstep=0.2 * SIZE),
    "LBFGS on atoms": LBFGS,
    "FIRE2 on modes": on_modes(FIRE2),
    "LBFGS on modes": on_modes(LBFGS),
    "NewtonKrylov": NewtonKrylov,
}

# %%
# Lengths are in units of the lattice spacing, forces in units of E* times its square:
# any consistent system of units will do. The wall is ten times as stiff as the solid,
# which leaves a difference of 0.33 % from the force of Hertz.

depth = SIZE / 32
sphere = RoughSphere(5.0 * SIZE)
wall = LennardJones93.repulsive(1.0, 1.0, stiffness=10.0)
hertz = Hertz(sphere.radius, 1.0)
exact = hertz.force(hertz.contact_radius_from_penetration(depth))

errors, residuals = {}, {}
for name, optimizer in optimizers.items():
    atoms = substrate("Cu", (SIZE, SIZE), sphere, spacing=1.0, height=1.0 - depth)
    atoms.calc = RoughContact(sphere, 1.0, wall)
    dynamics = optimizer(atoms, logfile=None)
    residual = []
    for _ in dynamics.irun(fmax=1e-5, steps=5000):
        gradient = dynamics.optimizable.get_gradient()
        residual.append(dynamics.optimizable.gradient_norm(gradient))
    next(dynamics.optimizable.iterimages())  # moves the atoms
    force = atoms.calc.state(atoms).normal_force
    errors[name] = float(force / exact - 1)
    least = np.minimum.accumulate(residual)  # the forces of FIRE oscillate
    residuals[name] = range(1, len(residual) + 1), least
    print(f"{name:14s} {len(residual) - 1:4d} steps, error {100 * errors[name]:7.4f} %")

# %%
# FIRE and FIRE2 end at a slightly larger force: the long waves are soft, so that small
# forces do not guarantee a small error of the energy.

with style():
    figure, axes = plt.subplots()
    plot_convergence(axes, residuals, xlabel="step of the optimizer").loglog()
    axes.set_ylabel("largest force so far / $E^* a_0^2$")
    figure.savefig("hertz_optimizers.png", dpi=200)
