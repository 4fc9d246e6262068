"""
Adhesion hysteresis from heterogeneity and from waviness
========================================================

A sphere whose attraction has a long range comes into contact and leaves it along the
same curve. A work of adhesion that varies over the surface, or waves on the sphere,
make it jump, and energy is lost.
"""

from dataclasses import dataclass

import matplotlib.pyplot as plt
import numpy as np

from ase_roughcontact import (
    DugdaleWall,
    Heterogeneity,
    RoughContact,
    RoughSphere,
    adhesion_loop,
    substrate,
)
from ase_roughcontact.plot import style
from ase_roughcontact.topography import Surface

RADIUS, WORK, RANGE = 100.0, 0.02, 0.8
DEEPEST = 0.7
PATCHES, WAVES = 32.0, 20.0

# %%
# Lengths are in units of the lattice spacing, pressures in units of E*. The parameter
# of Maugis is 0.48, too small for an instability of a smooth sphere.


@dataclass(frozen=True)
class Waves(Surface):
    """Circular waves around the axis."""

    amplitude: float
    wavelength: float

    def heights(self, shape, spacing, origin=(0.0, 0.0)):
        """Return the heights on a grid."""
        x, y = (o + spacing * np.arange(n) for o, n in zip(origin, shape, strict=True))
        phase = 2 * np.pi * np.hypot(x[:, None], y) / self.wavelength
        return self.amplitude * np.cos(phase)

    def lowest(self, spacing, origin=(0.0, 0.0)):
        """Return the lowest height."""
        return -self.amplitude


def patches(x, y):
    """Return the relative deviation of the work of adhesion."""
    return 0.9 * np.cos(2 * np.pi * x / PATCHES) * np.cos(2 * np.pi * y / PATCHES)


smooth, waves = RoughSphere(RADIUS), Waves(0.2, WAVES)
cases = {
    "smooth and uniform": (smooth, None, np.zeros((48, 48))),
    "patches of adhesion": (smooth, Heterogeneity(patches), None),
    "waves on the sphere": (RoughSphere(RADIUS, waves), None, None),
}
window = (48, 48), 1.0, (-24.0, -24.0)
maps = [np.zeros((48, 48)), cases["patches of adhesion"][1].factors(*window) - 1.0]
maps.append(waves.heights(*window) / waves.amplitude)

# %%
# Energies are in units of (w^5 R^4 / E*^2)^(1/3), forces in units of pi w R. Jumps are
# dotted.

force, energy = np.pi * WORK * RADIUS, np.cbrt(WORK**5 * RADIUS**4)
lost = {}
