r"""Contact of a rough sphere with friction: ours and ASPHER on the same input.

    python friction_codes.py --sizes 64 128 256
    python friction_codes.py --report

A sphere of the radius 10 n with roughness between 4 and n cells touches a third of
n x n cells, at a Poisson's ratio of 0.3 and a friction coefficient of 0.3, and is moved
sideways, each displacement cold: parts of the largest displacement that the full
friction would cause. A row is appended to `friction_codes.csv` as soon as it is known.

seconds
    of the lateral solution, of the processor with one thread; for ASPHER the step with
    the pressure already known, which it solves again
iterations
    FFT pairs of two components, normalised to the grid; for ASPHER its iterations, each
    at least one
residual
    largest :math:`|t - P(t + g/G_0)|` over the largest traction or bound, of each code
    with its own kernel
force, difference
    lateral force over the friction of full sliding, and largest difference of ASPHER's
    tractions from ours, relative to the largest of ours. Its displacements by its own
    tractions differ from ours by up to 10 % (64 cells), so that kernels differ, too

Tamaas has friction too (Kato, Condat), for another problem: periodic, with the
associated law, by which slip lifts the surface and changes the pressure, in one step.
``pip install ase-roughcontact[bench]`` brings
ASPHER; without it its rows are skipped.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Callable
from pathlib import Path
from time import process_time

import numpy as np
from markdown import order, table

from ase_roughcontact import (
    HardWall,
    Problem,
    RoughSphere,
    SelfAffine,
    StepOptions,
    Stepper,
)
from ase_roughcontact.elasticity import Isotropic
from ase_roughcontact.elasticity.lateral import LateralHalfSpace
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.solvers.lateral.friction import solve_friction

FRICTION, POISSON = 0.3, 0.3
PARTS = 0.05, 0.2, 0.4, 0.8, 1.5
FIELDS = (
    *("n", "part", "code", "seconds", "iterations"),
    *("residual", "force", "difference", "converged"),
)
# Tolerances of ASPHER for pressure and tractions, and its largest number of iterations.
ASPHER = {"tol_normal": 1e-9, "tol_tangential": 1e-7, "max_iter": 2000}

Solution = tuple[float, float, float, np.ndarray, bool]


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sizes", type=int, nargs="+", default=[64, 128, 256])
    parser.add_argument("--csv", type=Path, default=Path("friction_codes.csv"))
    parser.add_argument(
        "--report", action="store_true", help="table of the stored rows"
    )
    options = parser.parse_args()
    if options.report:
        report()
        return
    for n in options.sizes:
        compare(n, options.csv)


def compare(n: int, path: Path) -> None:
    """Solve all displacements by both codes."""
    gap, pressure = normal_contact(n)
    half = LateralHalfSpace((n, n), 1.0, Isotropic(1.0, POISSON))
    bound = FRICTION * pressure
    full = half.displacement(np.stack([bound, 0.0 * bound]))[0].max()
    codes: dict[str, Callable[[float], Solution]] = {
        "ours": lambda move: solve_ours(half, bound, move)
    }
    try:
        codes["ASPHER"] = aspher(gap, float(pressure.mean()))
    except ImportError as missing:
        print(f"ASPHER: skipped, {missing}")
    for part in PARTS:
        for code, solve in codes.items():
            seconds, iterations, error, tractions, converged = solve(part * full)
            if code == "ours":
                ours = tractions
            force = tractions[0].sum() / bound.sum()
            change = abs(tractions - ours).max() / abs(ours).max()
            row = [n, part, code, seconds, iterations, error, force, change, converged]
            write(path, row)
            print(
                f"{n} {part:5g} {code:7} {seconds:8.3f} s {iterations:6.0f} "
                f"{error:8.1e} {force:7.4f} {change:8.1e} "
                f"{'' if converged else 'not converged'}",
                flush=True,
            )


def report() -> None:
    """Print the table of the guide from the stored rows."""
    with (Path(__file__).parent / "friction_codes.csv").open(newline="") as file:
        stored = list(csv.DictReader(file))
    head = "n, displacement | pairs | residual | iterations | residual | converged"
    lines = []
    for ours, theirs in zip(stored[::2], stored[1::2], strict=True):
        lines.append(
            [
                f"{ours['n']}, {ours['part']}",
                f"{float(ours['iterations']):.0f}",
                order(float(ours["residual"])),
                theirs["iterations"],
                order(float(theirs["residual"])),
                "yes" if theirs["converged"] == "True" else "no",
                f"{float(theirs['seconds']) / float(ours['seconds']):.0f}",
            ]
        )
    table(f"{head} | ASPHER's time over ours", lines)


def normal_contact(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the gap before contact and the pressure."""
    rough = SelfAffine(0.1, 0.8, 4.0, float(n), domain=float(n), seed=1)
    sphere = RoughSphere(10.0 * n, rough)
    problem = Problem(sphere, Isotropic(1.0), HardWall(), 1.0, offset=(0.5, 0.5))
    window = Box((-n // 2, -n // 2), (n, n))
    options = StepOptions(window="unchecked", accuracy=1e-6)
    stepper = Stepper(problem, "penetrations", window, options)
    relaxed = stepper.relax(stepper.start, 0.03 * n)
    gap = relaxed.contact.gap(np.zeros((n, n)), 0.0)
    return gap - gap.min(), relaxed.fields.pressure


def solve_ours(half: LateralHalfSpace, bound: np.ndarray, move: float) -> Solution:
    imposed = np.zeros((2, *bound.shape))
    imposed[0] = move
    start = process_time()
    found = solve_friction(half, bound, imposed)
    seconds = process_time() - start
    return seconds, found.pairs, found.residual, found.tractions, found.converged


def aspher(gap: np.ndarray, pressure: float) -> Callable[[float], Solution]:
    from aspher import CoulombFriction, FrictionSolver

    n = len(gap)
    law = CoulombFriction(mu=FRICTION)
    solver = FrictionSolver(
        grid_size=n, domain_size=float(n), E_star=1.0, nu=POISSON, model=law
    )

    def solve(move: float) -> Solution:
        solver.set_gap(gap)
        solver.step(p_bar=pressure, delta_t=(0.0, 0.0), **ASPHER)
        start = process_time()
        result = solver.step(delta_t=(move, 0.0), **ASPHER)
        seconds = process_time() - start
        tractions = np.reshape([result.qx, result.qy], (2, n, n))
        error, count = result.proj_residual, result.tangential_iters
        return seconds, count, error, tractions, result.converged

    return solve


def write(path: Path, row: list) -> None:
    new = not path.exists()
    with path.open("a", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        if new:
            writer.writerow(FIELDS)
        writer.writerow(row)


if __name__ == "__main__":
    main()
