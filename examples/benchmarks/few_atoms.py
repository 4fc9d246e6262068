"""Contact area of few atoms, at twelve places of the axis between the atoms.

    python few_atoms.py

A smooth paraboloid of radius 1000 a0 under a hard wall; areas by count, relative to
that of Hertz, by the number of atoms in contact.
"""

from dataclasses import dataclass

import numpy as np
from markdown import table

from ase_roughcontact import (
    HardWall,
    RoughContact,
    RoughSphere,
    Validity,
    load_path,
    substrate,
)
from ase_roughcontact.theory import Hertz
from ase_roughcontact.topography import BoundedSurface

RADIUS, PLACES = 1000.0, 12
CLASSES = (1, 2), (2, 5), (5, 10), (10, 20), (20, 50), (50, 100), (100, 200)
# contact radii of Hertz
CONTACTS = np.geomspace(0.2, 8.0, 30)


@dataclass(frozen=True)
class OffAxis(BoundedSurface):
    """Sphere whose axis is moved from the atom at the origin."""

    sphere: RoughSphere
    x: float
    y: float

    def heights(self, shape, spacing, origin=(0.0, 0.0)):
        """Heights of the sphere, seen from its axis."""
        moved = (origin[0] - self.x, origin[1] - self.y)
        return self.sphere.heights(shape, spacing, moved)

    def reach(self, level, spacing, origin=(0.0, 0.0)):
        """Reach of the sphere and the distance of its axis."""
        return self.sphere.reach(level, spacing, origin) + np.hypot(self.x, self.y)


def main():
    """Relax all contacts, and print the table."""
    hertz, sphere = Hertz(RADIUS, 1.0), RoughSphere(RADIUS)
    rng, found = np.random.default_rng(0), []
    for x, y in rng.uniform(-0.5, 0.5, (PLACES, 2)):
        moved = OffAxis(sphere, float(x), float(y))
        atoms = substrate("Cu", (32, 32), moved, spacing=1.0, fixed=False)
        atoms.calc = RoughContact(moved, 1.0, HardWall())
        loads = [float(hertz.force(radius)) for radius in CONTACTS]
        for step in load_path(atoms, loads=loads, validity=Validity("ignore")):
            exact = float(hertz.contact_area(step.normal_force))
            found.append((step.repulsive_atoms, step.contact_area / exact))
    counts, ratios = np.transpose(found)
    rows = []
    for least, end in CLASSES:
        chosen = ratios[(counts >= least) & (counts < end)]
        name = f"{least}" if end == least + 1 else f"{least} to {end - 1}"
        values = chosen.min(), chosen.mean(), chosen.max()
        rows.append((name, *(f"{value:.2f}" for value in values)))
    table("atoms in contact | smallest | mean | largest", rows)


if __name__ == "__main__":
    main()
