r"""Cost of the coupling of normal and lateral motion on a sliding path.

    python coupling.py --sizes 64 128 256

A sphere of the radius 10 n with roughness between 4 and n/4 cells is pressed into n x n
cells in two steps, and moved sideways in two more, at a friction coefficient of 0.3.
For each Poisson's ratio: the mean number of alternations of a step, FFT pairs of the
normal problem and pairs of two components of the lateral one with the coupling, and in
parentheses without, and the ratio of the times of the processor.
"""

from __future__ import annotations

import argparse
from time import process_time

import numpy as np
from markdown import table

from ase_roughcontact import (
    Coulomb,
    HardWall,
    Problem,
    RoughSphere,
    SelfAffine,
    StepOptions,
    Stepper,
)
from ase_roughcontact.elasticity import Isotropic
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.path_kinds.sliding.specification import SlidingSpecification
from ase_roughcontact.path_kinds.sliding.steps import SlidingSteps
from ase_roughcontact.paths.follow import follow

DEPTHS, PATH = np.array([0.5, 1.0, 1.0, 1.0]), np.array([0.0, 0.0, 0.3, 0.6])
POISSON = 0.0, 0.15, 0.3, 0.45


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sizes", type=int, nargs="+", default=[64, 128])
    sizes = parser.parse_args().sizes
    head = "n | Poisson's ratio | alternations | pairs | lateral pairs | time"
    rows = []
    for n in sizes:
        for poisson in POISSON:
            neglected, solved = (
                costs(n, poisson, coupling) for coupling in ("neglected", "solved")
            )
            counts = [
                f"{a:.0f} ({b:.0f})" for a, b in zip(solved, neglected, strict=True)
            ]
            ratio = solved[3] / neglected[3]
            row = n, poisson, f"{solved[0]:.3g}", *counts[1:3], f"{ratio:.2g}"
            rows.append(row)
    table(head, rows)


def costs(n: int, poisson: float, coupling: str) -> tuple[float, ...]:
    """Return means of a step: alternations, pairs, lateral pairs and time."""
    rough = SelfAffine(0.1, 0.8, 4.0, n / 4.0, domain=float(n), seed=1)
    solid = Isotropic(1.0, poisson)
    sphere = RoughSphere(10.0 * n, rough)
    problem = Problem(sphere, solid, HardWall(), 1.0, offset=(0.5, 0.5))
    window = Box((-n // 2, -n // 2), (n, n))
    options = StepOptions(window="unchecked")
    stepper, law = Stepper(problem, "penetrations", window, options), Coulomb(0.3)
    path, depths = PATH * n / 100.0, DEPTHS * n / 40.0
    stepper.relax(stepper.start, depths[0] / 2.0)  # makes spectra and plans
    begun = process_time()
    sliding = SlidingSteps(
        stepper, SlidingSpecification(depths, law, path, coupling=coupling)
    )
    steps = list(follow(sliding, validity="ignore"))
    seconds = process_time() - begun
    if not all(step.converged for step in steps):
        raise RuntimeError([step.message for step in steps])
    counts = [(s.alternations, s.pairs, s.friction_pairs) for s in steps]
    return *np.mean(counts, axis=0).tolist(), seconds


if __name__ == "__main__":
    main()
