"""Contact area at which no open way crosses a rough flat any more.

Roll-off from an eighth of the period. A way leads from one side of the cell to the
opposite one through points that are neighbours along x or y; the other two sides are
periodic.
"""

import numpy as np
from published import Value, finest, run
from rough_flats import pressed
from scipy.ndimage import label

from ase_roughcontact import SelfAffine
from ase_roughcontact.analysis import ContactMap

FIELDS = "seed", "points", "short", "along_x", "along_y"
CASES = [(seed, 512, 8.0) for seed in range(1, 13)]
CASES += [(1, 1024, 8.0)]
QUICK = [(1, 256, 8.0)]
PRESSURES = np.linspace(0.14, 0.34, 21)


def crosses(opened):
    """Whether a way along the first axis crosses the open points."""
    pieces, _ = label(np.tile(opened, (1, 3)))
    both = np.intersect1d(pieces[0], pieces[-1])
    return bool((both > 0).any())


def calculate(seed, points, short):
    """Yield the areas between the last open and the first closed step."""
    period = float(points)
    rough = SelfAffine(
        *(0.1, 0.8, short, period / 8),
        longest_wavelength=period,
        domain=period,
        seed=seed,
    )
    last, closed = 0.0, {}
    for step, atoms in pressed(rough, points, PRESSURES):
        area = step.continuum_area / points**2
        opened = ~ContactMap.from_atoms(atoms).contact
        for axis in (0, 1):
            if axis not in closed and not crosses(opened if axis == 0 else opened.T):
                closed[axis] = 0.5 * (last + area)
        last = area
        if len(closed) == 2:
            break
    yield seed, points, short, closed[0], closed[1]


def reported(rows):
    """Return the mean over the realisations."""
    means = (0.5 * (row["along_x"] + row["along_y"]) for row in finest(rows))
    return {"percolation": Value.mean(means)}


if __name__ == "__main__":
    run(__file__, FIELDS, CASES, calculate)
