"""Pull-off force of a sphere with concentric waves, against Guduru's theory.

The profile is r^2/2R + A (1 - cos(2 pi r/lambda)), in contact without gaps. The wall is
hard, with Dugdale's attraction of a short range. Theory: JKR for this profile, along
the states that are reached while the sphere is raised.
"""

from dataclasses import dataclass

import numpy as np
from published import Value, run

from ase_roughcontact import DugdaleWall, RoughContact, load_path, substrate
from ase_roughcontact.topography import BoundedSurface

FIELDS = "amplitude", "spacing", "range", "pull_off", "jumps", "theory"
GRIDS = (1.0, 0.5), (1.0, 1.0), (0.5, 0.5)  # spacing and range
CASES = [(amplitude, *grid) for grid in GRIDS for amplitude in (0.0, 0.2)]
QUICK = [(amplitude, 1.0, 1.0) for amplitude in (0.0, 0.2)]
RADIUS, WORK, WAVELENGTH = 200.0, 0.1, 16.0
DEPTHS = np.arange(3.0, -4.0, -0.05)  # while the sphere is raised


@dataclass(frozen=True)
class WavySphere(BoundedSurface):
    """Paraboloid with concentric waves."""

    radius: float
    amplitude: float
    wavelength: float

    def profile(self, r):
        """Return the height at a distance from the axis."""
        wave = 1.0 - np.cos(2.0 * np.pi * r / self.wavelength)
        return r**2 / (2.0 * self.radius) + self.amplitude * wave

    def slope(self, r):
        """Return the derivative of the profile."""
        q = 2.0 * np.pi / self.wavelength
        return r / self.radius + self.amplitude * q * np.sin(q * r)

    def heights(self, shape, spacing, origin=(0.0, 0.0)):
        """Sample the heights; see `Surface.heights`."""
        x, y = (o + spacing * np.arange(n) for o, n in zip(origin, shape, strict=True))
        return self.profile(np.hypot(x[:, None], y))

    def reach(self, level, spacing, origin=(0.0, 0.0)):
        """Return where the profile is surely above a level."""
        return np.sqrt(2.0 * self.radius * max(level, 0.0))


def pull_off_of_theory(sphere, largest=60.0):
    """Return the largest tension of JKR on the way out from a contact radius."""
    a = np.linspace(0.05, largest, 2400)
    angle = (np.arange(400) + 0.5) * np.pi / 800
    # I. N. Sneddon, Int. J. Eng. Sci. 3, 47 (1965), with r = a sin(angle)
    slopes = sphere.slope(a[:, None] * np.sin(angle)).mean(axis=1)
    depth = a * slopes * np.pi / 2.0
    force = 2.0 * np.cumsum(0.5 * (a[1:] + a[:-1]) * np.diff(depth))
    force = np.concatenate([[0.0], force]) - np.sqrt(8.0 * np.pi * WORK * a**3)
    depth = depth - np.sqrt(2.0 * np.pi * WORK * a)
    reached = depth <= np.minimum.accumulate(depth[::-1])[::-1]
    return -force[reached].min()


def calculate(amplitude, spacing, reach):
    """Yield pull-off force over 1.5 pi w R, steps that lose 0.05 of it, and theory."""
    sphere = WavySphere(RADIUS, amplitude, WAVELENGTH)
    atoms = substrate("Cu", (16, 16), sphere, spacing=spacing)
    atoms.calc = RoughContact(sphere, 1.0, DugdaleWall(WORK, reach))
    unit = 1.5 * np.pi * WORK * RADIUS
    tensions = []
    for step in load_path(atoms, penetrations=DEPTHS, window="auto", validity="ignore"):
        if not step.converged:
            raise RuntimeError(step.message)
        tensions.append(-step.normal_force / unit)
        if step.contact_area == 0.0:
            break
    jumps = (np.diff(tensions) < -0.05).sum()
    values = max(tensions), jumps, pull_off_of_theory(sphere) / unit
    yield amplitude, spacing, reach, *values


def reported(rows):
    """Return the ratio of wavy and smooth sphere, and this over theory.

    Of the finest grid and the shortest range.
    """
    finest = min((row["spacing"], row["range"]) for row in rows)
    fine = {
        row["amplitude"]: row
        for row in rows
        if (row["spacing"], row["range"]) == finest
    }
    smooth, wavy = fine[0.0], fine[max(fine)]
    ratio = wavy["pull_off"] / smooth["pull_off"]
    theory = wavy["theory"] / smooth["theory"]
    return {"wavy_sphere": Value(ratio), "wavy_theory": Value(ratio / theory)}


if __name__ == "__main__":
    run(__file__, FIELDS, CASES, calculate)
