"""Transforms and errors of the area of plastic contact, for the guide.

    python plastic_contact.py pairs   # pairs of transforms, from light to full loads
    python plastic_contact.py walls   # beside the hard and the repulsive wall
    python plastic_contact.py area    # errors of the area by the grid

Lengths are in a0, and the contact modulus is 1.
"""

import sys

import numpy as np
from markdown import table
from problems import Problem

from ase_roughcontact import (
    HardWall,
    LennardJones93,
    PlasticWall,
    RoughContact,
    RoughSphere,
    SelfAffine,
    load_path,
    substrate,
)
from ase_roughcontact.contact import Contact
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace, PeriodicHalfSpace
from ase_roughcontact.solvers.hard.active_set import active_set
from ase_roughcontact.solvers.soft.newton import newton_krylov
from ase_roughcontact.theory.counted_area import continuum_area

SIZE, TOLERANCE = 256, 1e-6
PARTS = (0.01, 0.1, 0.5, 0.9, 0.99)
WALLS = {
    "hard": HardWall(),
    "plastic, $H$ = 0.1 $E^*$": PlasticWall(0.1),
    "plastic, $H$ = 0.03 $E^*$": PlasticWall(0.03),
    "plastic, $H$ = 0.01 $E^*$": PlasticWall(0.01),
    "repulsive": LennardJones93.repulsive(1.0, 1.0),
}


def main(studies):
    """Print the tables."""
    for study in studies or ("pairs", "walls", "area"):
        {"pairs": pairs, "walls": walls, "area": area}[study]()


def solved(contact, height, load=None):
    """Return the height of a cold solution and the pairs that it takes."""
    solver = active_set if contact.wall.hard else newton_krylov
    states = list(
        solver(
            contact,
            height=height,
            external=None if load is None else lambda z: (load * z, -load),
            start=None,
            tolerance=TOLERANCE,
        )
    )
    assert states[-1].converged, states[-1].message
    return states[-1].height, sum(state.pairs for state in states)


def pairs():
    """Pairs of transforms under a load and at the height that is found."""
    shape = SIZE, SIZE
    rough = SelfAffine(0.1, 0.8, 4.0, float(SIZE), seed=1, domain=float(SIZE))
    sphere = RoughSphere(8.0 * SIZE, SelfAffine(0.1, 0.8, 4.0, 64.0, seed=1))
    corner = -(SIZE // 2), -(SIZE // 2)
    rows = []
    for name, kind, heights in (
        ("periodic", PeriodicHalfSpace, rough.heights(shape, 1.0)),
        ("rough sphere", FreeHalfSpace, sphere.heights(shape, 1.0, corner)),
    ):
        for hardness in (0.1, 0.03, 0.01, 0.001):
            row = []
            for part in PARTS:
                contact = Contact(kind(shape, 1.0, 1.0), heights, PlasticWall(hardness))
                height, loaded = solved(contact, 0.0, part * hardness * SIZE**2)
                row.append(f"{loaded:.0f} / {solved(contact, height)[1]:.0f}")
            rows.append((f"{name}, {hardness:g}", *row))
    parts = " | ".join(f"{part:g} $H$" for part in PARTS[1:])
    table(f"$H/E^*$ | mean pressure {PARTS[0]:g} $H$ | {parts}", rows)


def walls():
    """Pairs of cold solutions under the load of `problems`."""
    problems = {
        f"{name}, {n}": Problem(kind, n)
        for name, kind in (("flat", "periodic"), ("sphere", "hard"))
        for n in (256, 512)
    }
    rows = []
    for name, wall in WALLS.items():
        counts = []
        for problem in problems.values():
            contact = Contact(problem.contact().halfspace, problem.heights, wall)
            counts.append(solved(contact, contact.first_contact, problem.load)[1])
        rows.append((name, *(f"{count:.0f}" for count in counts)))
    table(f"wall | {' | '.join(problems)}", rows)


def area(side=32, spacings=(1.0, 0.25, 0.125)):
    """Errors in % on the grid of spacing one, mean of three flats."""
    rows = []
    for hardness in (0.1, 0.05, 0.02, 0.01):
        for part in (0.05, 0.3, 0.7):
            found = np.mean(
                [
                    [row(hardness, part, side, dx, seed) for dx in spacings]
                    for seed in (3, 4, 5)
                ],
                axis=0,
            )
            counted = found[:, 0]
            limit = 2.0 * counted[-1] - counted[-2]
            errors = 100.0 * (found[0, :3] / limit - 1.0)
            plastic = found[-1, 3] / limit
            cells = f"{hardness:g}", f"{part:g} $H$", f"{100 * plastic:.0f} %"
            rows.append((*cells, *(f"{error:.1f}" for error in errors)))
    head = "$H/E^*$ | mean pressure | area at $H$ | counted"
    table(f"{head} | corrected by the perimeter | and at least $N/H$", rows)


def row(hardness, part, side, spacing, seed):
    """Return areas: counted, corrected, of the record, and in plastic contact."""
    rough = SelfAffine(0.1, 0.8, 4.0, 16.0, seed=seed, domain=float(side))
    flat, n = RoughSphere(np.inf, rough), round(side / spacing)
    atoms = substrate("Cu", (n, n), flat, spacing=spacing, periodic=True, fixed=False)
    atoms.calc = RoughContact(flat, 1.0, PlasticWall(hardness))
    (step,) = load_path(atoms, loads=[part * hardness * side**2], validity="ignore")
    return (
        step.contact_area,
        continuum_area(step.contact_area, step.perimeter, spacing),
        step.continuum_area,
        step.plastic_atoms * spacing**2,
    )


if __name__ == "__main__":
    main(sys.argv[1:])
