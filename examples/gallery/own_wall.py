"""
An interaction of your own
==========================

A wall is a class with one method. This one is the repulsion of two electric double
layers, V(g) = p0 rho exp(-g/rho).
"""

import matplotlib.pyplot as plt
import numpy as np

from ase_roughcontact import (
    Interaction,
    RoughContact,
    RoughSphere,
    load_path,
    substrate,
)
from ase_roughcontact.plot import style

STIFFNESS = 0.01  # p0/E*

# %%
# ``evaluate`` returns energy per area, pressure and stiffness for an array of gaps. It
# may be called by several threads at once, so it must not keep anything. Beyond the
# ``cutoff`` the wall is not evaluated, so the energy is shifted to zero there.


class DoubleLayer(Interaction):
    """Pressure p0 exp(-g/rho), up to a gap of 12 rho."""

    work_of_adhesion = attraction_range = 0.0

    def __init__(self, pressure: float, decay: float) -> None:
        self.pressure, self.decay = pressure, decay
        self.cutoff = self.contact_distance = 12 * decay

    def evaluate(self, gap: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return energy per area, pressure and stiffness."""
        end = self.pressure * np.exp(-self.cutoff / self.decay)
        p = self.pressure * np.exp(-np.minimum(gap, self.cutoff) / self.decay)
        inside = gap < self.cutoff
        return (p - end) * self.decay, p * inside, p / self.decay * inside


# %%
# Lengths are in units of the decay length rho, pressures in units of E*. The sphere is
# lowered from a distance at which the solid hardly deforms.

sphere, wall = RoughSphere(50.0), DoubleLayer(STIFFNESS, 1.0)
atoms = substrate("Cu", (84, 84), sphere, spacing=1.0, height=12.0)
atoms.calc = RoughContact(sphere, 1.0, wall)
heights = np.linspace(7.0, -3.0, 21)
# the theory is that of a paraboloid, too, whose width does not matter
path = load_path(atoms, heights=heights, validity="ignore")
forces = np.array([step.normal_force for step in path])

# %%
# While the solid is flat, the force on a sphere is that of Derjaguin's approximation,
# 2 pi R V.

derjaguin = 2 * np.pi * sphere.radius * wall.evaluate(heights)[0]
error = float(forces[0] / derjaguin[0] - 1)
print(f"relative difference from Derjaguin at {heights[0]:g} rho: {100 * error:.2f} %")

with style():
    figure, axes = plt.subplots()
    axes.semilogy(heights, forces, "o", label="simulation, elastic solid")
    axes.semilogy(heights, derjaguin, "k-", label="Derjaguin, rigid solid")
    axes.set(xlabel=r"height of the sphere / $\rho$", ylabel=r"force / $E^* \rho^2$")
    axes.legend()
    figure.savefig("own_wall.png", dpi=200)
