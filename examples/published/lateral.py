"""Normal over lateral stiffness of rough flats that stick.

Roughness from 8 points to a quarter of the period, at a contact of some 5 %.
"""

from published import Value, run

from ase_roughcontact import (
    HardWall,
    Isotropic,
    RoughContact,
    SelfAffine,
    Tresca,
    sliding_path,
)
from ase_roughcontact import substrate as flat

FIELDS = "poisson", "seed", "points", "area", "normal", "lateral"
CASES = [(nu, seed, 256) for seed in (1, 2, 3) for nu in (0.0, 0.25, 0.45)]
QUICK = [(0.25, 1, 64)]


def calculate(poisson, seed, points):
    """Yield the stiffnesses, the lateral one as the mean along x and y."""
    period = float(points)
    rough = SelfAffine(0.1, 0.8, 8.0, period / 4, seed=seed, domain=period)
    atoms = flat("Cu", (points, points), rough, spacing=1.0, periodic=True, fixed=False)
    atoms.calc = RoughContact(rough, solid=Isotropic(1.0, poisson), wall=HardWall())
    way = 1e-3
    steps = list(
        sliding_path(
            atoms,
            Tresca(1e3),
            loads=0.025 * rough.rms_slope * points**2,
            displacements=[(0.0, 0.0), (way, 0.0), (0.0, way)],
            window="fixed",
            validity="ignore",
        )
    )
    forces = steps[1].lateral_force_x, steps[2].lateral_force_y
    area = steps[0].continuum_area / points**2
    normal = steps[0].contact_stiffness
    yield poisson, seed, points, area, normal, 0.5 * sum(forces) / way


def reported(rows):
    """Return the ratio of the stiffnesses over the published one."""
    ratios = []
    for row in rows:
        nu = row["poisson"]
        ratio = row["normal"] / row["lateral"]
        ratios.append(ratio * (2.0 - 2.0 * nu) / (2.0 - nu))
    return {"lateral": Value.mean(ratios)}


if __name__ == "__main__":
    run(__file__, FIELDS, CASES, calculate)
