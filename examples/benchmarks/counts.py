"""Iterations and FFT pairs of small contacts; the tests allow twice as many.

    python counts.py --csv counts.csv

prints and stores a table: iterations of the solver, and forward/inverse FFT pairs
(normalised to one pair on the full padded grid). The stored table shows what a change
of a solver costs or saves; counts differ a little between processors and libraries.
"""

import argparse
import csv
from functools import partial
from itertools import chain

import numpy as np
from ase.optimize import FIRE2, LBFGS
from solver_options import external, flat_contact, sphere_contact

from ase_roughcontact import (
    ActiveSet,
    FourierModes,
    HardWall,
    LennardJones93,
    NewtonKrylov,
    PlasticWall,
    RoughContact,
    RoughSphere,
    load_path,
    substrate,
)
from ase_roughcontact.elasticity.reduced import ReducedHalfSpace
from ase_roughcontact.solvers.hard.active_set import active_set
from ase_roughcontact.solvers.options import ActiveSetOptions, NewtonKrylovOptions
from ase_roughcontact.solvers.soft.newton import newton_krylov

REPULSIVE = LennardJones93.repulsive(1.0, 1.0)
ADHESIVE = LennardJones93.adhesive(1.0, 1.0, 0.005)


def counted(contact, load, part=None, **options):
    """Cold start under a load, or start from the solution at a part of the load."""
    hard = contact.wall.hard
    kind = ActiveSetOptions if hard else NewtonKrylovOptions
    solve = partial(active_set if hard else newton_krylov, contact, tolerance=1e-6)
    height, start = contact.first_contact, None
    if part is not None:
        at_part = partial(external, part * load)
        *_, last = solve(height=height, external=at_part, start=start)
        height, start = last.height, last.pressure
    at_load = partial(external, load)
    states = list(
        solve(height=height, external=at_load, start=start, options=kind(**options))
    )
    assert states[-1].converged, states[-1].message
    return len(states), sum(state.pairs for state in states)


def solver_cases():
    """Yield names and counts of the solvers on arrays."""
    hard, flat = sphere_contact(128, HardWall()), flat_contact(128, HardWall())[0]
    yield "hard, free, 128", counted(*hard)
    yield "hard, free, 128, from 97 % of the load", counted(*hard, 0.97)
    yield "hard, free, 60", counted(*sphere_contact(60, HardWall()))
    for mean in (0.01, 0.05, 0.1):
        name = f"hard, periodic, 128, mean pressure {mean:g}"
        yield name, counted(flat, mean * 128**2)
    wide = hard[0], 0.1 * 128**2
    yield "hard, free, 128, nearly full", counted(*wide)
    large = sphere_contact(256, HardWall())[0], 0.022 * 256**2
    yield "hard, free, 256, wide", counted(*large)
    yield "hard, free, 256, wide, single steps", counted(*large, slow_contraction=1.0)
    for part in (0.01, 0.5, 0.99):
        plastic = flat_contact(64, PlasticWall(0.05))[0]
        yield f"plastic, {part:g} of hardness", counted(plastic, part * 0.05 * 64**2)
    for stiffness in (0.01, 1.0, 1e2, 1e4):
        wall = LennardJones93.repulsive(1.0, 1.0, stiffness=stiffness)
        yield f"repulsive, stiffness {stiffness:g}", counted(*sphere_contact(96, wall))
    soft = sphere_contact(128, REPULSIVE)
    yield "repulsive, 128", counted(*soft)
    yield "repulsive, 128, from 99 % of the load", counted(*soft, 0.99)
    yield "repulsive, 128, from a third of the load", counted(*soft, 1.0 / 3.0)
    small = sphere_contact(14, REPULSIVE)
    yield "repulsive, 14", counted(*small)
    yield "adhesive, 128", counted(*sphere_contact(128, ADHESIVE))


def atoms_of(wall, size=32, spacing=1.0, **options):
    """Atoms under a smooth sphere."""
    sphere = RoughSphere(60.0)
    atoms = substrate("Cu", (size, size), sphere, spacing=spacing, **options)
    atoms.calc = RoughContact(sphere, 1.0, wall)
    return atoms


def atom_cases():
    """Yield names and counts of paths, of ASE's optimizers and of condensed windows."""
    for wall, optimizer in ((HardWall(), ActiveSet), (REPULSIVE, NewtonKrylov)):
        atoms, heights = atoms_of(wall), [-0.5, -0.48, -0.46]
        path = load_path(atoms, heights=heights, fmax=1e-6, optimizer=optimizer)
        for record, name in zip(path, ("first", "second", "third"), strict=True):
            counts = record.iterations, record.pairs
            yield f"{name} step, {optimizer.__name__}", counts
    for size in (32, 64):
        for optimizer, options in ((LBFGS, {"alpha": 1.0}), (FIRE2, {})):
            atoms = atoms_of(REPULSIVE, size, 32.0 / size, height=0.2)
            modes = FourierModes(atoms)
            if optimizer is FIRE2:
                options = {"maxstep": modes.maxstep}
            dynamics = optimizer(modes, logfile=None, **options)
            dynamics.run(fmax=1e-4 * (32.0 / size) ** 2, steps=3000)
            name = f"{optimizer.__name__} on FourierModes, {size}"
            yield name, (dynamics.nsteps, modes.evaluations)
    halfspace = ReducedHalfSpace((64, 64), 1.0, 1.0)
    pressure = np.random.default_rng(0).random((64, 64))
    displacement, before = halfspace.displacement(pressure), halfspace.pairs
    halfspace.elastic_pressure(displacement)
    pairs = halfspace.pairs - before
    yield "pressure of a condensed window", (pairs, pairs)


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--csv", help="file for the table")
    file = parser.parse_args().csv
    rows = [("contact", "iterations", "FFT pairs")]
    for name, (iterations, pairs) in chain(solver_cases(), atom_cases()):
        rows.append((name, iterations, f"{pairs:.1f}"))
        print(f"{name:45} {iterations:6} {pairs:8.1f}", flush=True)
    if file:
        with open(file, "w", encoding="utf-8", newline="") as out:
            csv.writer(out, lineterminator="\n").writerows(rows)


if __name__ == "__main__":
    main()
