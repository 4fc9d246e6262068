"""Stiffness of a square punch with a rough face on a free half space, over the force.

The fractal dimension is 3 - H, waves are from 4 points to the side of the punch. The
exponent is that of stiffnesses between 3 and 30 % of a smooth punch.
"""

from itertools import pairwise

import numpy as np
from published import Value, by, run

from ase_roughcontact import HardWall, RoughContact, SelfAffine, load_path, substrate

FIELDS = "hurst", "seed", "points", "force", "stiffness"
CASES = [(h, seed, 256) for seed in range(1, 11) for h in (0.9, 0.5, 0.2)]
QUICK = [(hurst, 1, 64) for hurst in (0.9, 0.2)]
# of a square punch, over E* times its side: that of a circle of the same area times
# 1.02; only the range of the fit depends on it
SMOOTH = 1.15
FORCES = np.geomspace(1e-5, 0.3, 28)  # over slope, modulus and area


def calculate(hurst, seed, points):
    """Yield force over slope, modulus and area, and stiffness over modulus and side."""
    side = float(points)
    rough = SelfAffine(0.1, hurst, 4.0, side, seed=seed, domain=side)
    atoms = substrate("Cu", (points, points), rough, spacing=1.0, fixed=False)
    atoms.calc = RoughContact(rough, 1.0, HardWall())
    loads = FORCES * rough.rms_slope * side**2
    steps = load_path(atoms, loads=loads, window="unchecked", validity="ignore")
    for force, step in zip(FORCES, steps, strict=True):
        yield hurst, seed, points, force, step.contact_stiffness / side


def exponents(rows):
    """Return mean exponents by the Hurst exponent."""
    found = {}
    for (hurst, _), steps in by(rows, "hurst", "seed").items():
        force, stiffness = np.array([(s["force"], s["stiffness"]) for s in steps]).T
        part = stiffness / SMOOTH
        near = (part > 0.03) & (part < 0.3)
        slope = np.polyfit(np.log(force[near]), np.log(stiffness[near]), 1)[0]
        found.setdefault(hurst, []).append(slope)
    return {hurst: Value.mean(values) for hurst, values in sorted(found.items())}


def reported(rows):
    """Return the largest exponent; none is tested if they do not rise with D."""
    found = list(exponents(rows).values())
    falling = all(a.value > b.value for a, b in pairwise(found))
    top = found[0]
    tested = top.value if falling and found[-1].value > 0.48 else np.inf
    both = Value(top.value, top.error, tested)
    return {"exponent": both, "exponent_later": both}


if __name__ == "__main__":
    run(__file__, FIELDS, CASES, calculate)
