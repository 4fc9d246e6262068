"""Numbers that docstrings promise, and that are not in the table of speed_accuracy.py.

    python promises.py                          # all, some minutes
    python promises.py --study turns            # ratios of times
    python promises.py --study cutoffs paths

*turns*: settings of `speed_accuracy.relaxed`, and transforms in double and in single
precision, taken in turn, the least of six times: a busy machine is so to all of them.
*cutoffs*: what the end of the full 9-3 wall changes in the force, against 300 r0.
*paths*: the error of the force along paths, against an accuracy of 1e-10. Errors are
relative to the push on the atoms in contact.
"""

import argparse
import time
from functools import cache, partial
from itertools import product

import numpy as np
from markdown import ends, table
from speed_accuracy import CASES, LARGE, LEVELS, Settings, reference, relaxed

from ase_roughcontact import (
    HardWall,
    LennardJones93,
    RoughContact,
    RoughSphere,
    SelfAffine,
    load_path,
    substrate,
)
from ase_roughcontact._util.threads import threads
from ase_roughcontact.elasticity.fft import RealFFT2

TURNS = 6
PAIRS = 40  # as many as a step takes


def turns():
    """Print ratios of times."""
    print("pairs of transforms: float32 over float64")
    for side in (100, 270, 540):
        double, single = in_turn([pairs(side, kind) for kind in ("float64", "float32")])
        print(f"  grid {2 * side}: {single / double:.2f}")
    print(f"contact of {LARGE} atoms: time over that of the first")
    settings = [Settings(None, level) for level in LEVELS]
    settings += [Settings(1e-2), Settings(1e-2, dtype="float32")]
    settings += [Settings(1e-4), Settings(1e-4, polished=True)]
    for case in CASES[:4]:
        target = reference(case, LARGE, Settings(1e-12))[0]
        runs = [partial(relaxed, case, LARGE, s, target, 0.04) for s in settings]
        seconds = in_turn(runs)
        for group in (slice(0, 3), slice(3, 5), slice(5, 7)):
            first = seconds[group][0]
            for chosen, took in zip(settings[group], seconds[group], strict=True):
                print(f"  {case:9} {chosen!s:40} {took / first:.2f}")


def in_turn(runs):
    """Least time of each (s)."""
    times = [[] for _ in runs]
    for _ in range(TURNS):
        for run, taken in zip(runs, times, strict=True):
            start = time.perf_counter()
            run()
            taken.append(time.perf_counter() - start)
    return [min(taken) for taken in times]


def pairs(side, dtype):
    """Return what does the transforms of a step."""
    fft = RealFFT2((side, side), (2 * side, 2 * side), dtype=dtype)
    weights = fft.multiplier(np.ones(fft.spectrum.shape))
    values = np.ones((side, side), dtype)
    return lambda: [fft.filter(values, weights) for _ in range(PAIRS)]


def cutoffs():
    """Print the error of the force by the cutoff, smooth and rough."""
    rough = SelfAffine(0.1, 0.8, 4.0, 48.0, seed=1, domain=4096.0)
    values = (3.0, 5.0, 10.0, 30.0, 100.0)
    rows, windows = [], {cutoff: [] for cutoff in values}
    for name, roughness in (("smooth", None), ("rough", rough)):
        errors = {cutoff: [] for cutoff in values}
        for depth in (0.3, 1.5, 4.0):
            sphere = RoughSphere(300.0, roughness)
            truth, push = attracted(sphere, 1 / 27, 300.0, depth)
            for cutoff in values:
                record, _ = attracted(sphere, 1 / 27, cutoff, depth)
                error = abs(record.normal_force - truth.normal_force) / push
                errors[cutoff].append(error)
                windows[cutoff].append(int(record.window.partition("x")[0]))
        rows.append((name, *map(ends, errors.values())))
    sides = [ends(sides, str) for sides in windows.values()]
    rows.append(("side of the window ($a_0$)", *sides))
    table("cutoff / $r_0$ | " + " | ".join(f"{cutoff:g}" for cutoff in values), rows)


def attracted(sphere, work, cutoff, depth):
    """Record of a sphere at a depth, and the push on the atoms in contact."""
    atoms = substrate("Cu", (8, 8), sphere, spacing=1.0)
    wall = LennardJones93.full(distance=1.0, work_of_adhesion=work, cutoff=cutoff)
    atoms.calc = RoughContact(sphere, 1.0, wall)
    (record,) = load_path(atoms, penetrations=[depth], accuracy=1e-11, window="auto")
    return record, push_of(atoms)


def push_of(atoms):
    state = atoms.calc.state(atoms)
    return state.pressure[state.contact].sum()


def paths():
    """Print errors over relative tolerances, which are a quarter of the accuracy."""
    walls = {
        "hard": HardWall(),
        "repulsive": LennardJones93.repulsive(1.0, 1.0),
        "adhesive, w = 0.01": LennardJones93.adhesive(1.0, 1.0, 0.01),
        "adhesive, w = 0.05": LennardJones93.adhesive(1.0, 1.0, 0.05),
        "full": LennardJones93.full(distance=1.0, work_of_adhesion=1 / 27, cutoff=5.0),
    }
    in_contact = (
        ("penetrations", (0.3, 1.0, 2.0)),
        ("penetrations", tuple(np.linspace(0.8, 1.0, 6))),
        ("loads", (0.05, 1.0, 10.0)),
    )
    touching_and_parting = (
        ("penetrations", tuple(np.linspace(-0.7, 1.0, 8))),
        ("penetrations", tuple(np.linspace(1.0, -1.5, 11))),
    )
    print(
        "wall, path, tolerance: largest and median error over it; above 4, of so many"
    )
    kinds = {"in contact": in_contact, "touching, parting": touching_and_parting}
    for (name, wall), (kind, ways) in product(walls.items(), kinds.items()):
        for tolerance in (1e-1, 1e-2, 1e-3, 1e-4, 1e-5):
            errors = [
                abs(force - exact) / push / tolerance
                for rough in product((0.03, 0.1), range(4), ways)
                for (force, _), (exact, push) in zip(
                    along(wall, 4.0 * tolerance, *rough),
                    along(wall, 1e-10, *rough),
                    strict=True,
                )
                if push > 0.0
            ]
            print(
                f"  {name:18} {kind:17} {tolerance:.0e} {max(errors):8.2g} "
                f"{np.median(errors):8.2g} {np.sum(np.array(errors) > 4.0):3} "
                f"{len(errors)}",
                flush=True,
            )


@cache
def along(wall, accuracy, slope, seed, way):
    """Force, and push on the atoms in contact, at each step of a path."""
    rough = SelfAffine(slope, 0.8, 4.0, 48.0, seed=seed, domain=256.0)
    sphere = RoughSphere(150.0, rough)
    atoms = substrate("Cu", (8, 8), sphere, spacing=1.0, fixed=way[0] != "loads")
    atoms.calc = RoughContact(sphere, 1.0, wall)
    steps = load_path(atoms, accuracy=accuracy, window="auto", **dict([way]))
    return [(record.normal_force, push_of(atoms)) for record in steps]


def main():
    studies = {"turns": turns, "cutoffs": cutoffs, "paths": paths}
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--study", nargs="+", choices=studies, default=studies)
    with threads(1):
        for name in parser.parse_args().study:
            studies[name]()


if __name__ == "__main__":
    main()
