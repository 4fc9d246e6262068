"""Accuracy, steps and cost of atoms on an elastic semi-infinite crystal.

    python examples/benchmarks/foundation.py accuracy steps cost

accuracy: an atom of an EMT copper surface under a force, balanced by the others, on
7 x 7 cells: its displacement relative to that on a relaxed slab of 40 layers.
steps: a sphere (R = 20 Å) pressed 0.5 Å into two layers of atoms with a Lennard-Jones
potential, forces of 1e-3 eV/Å: steps of optimizers for 8 to 64 cells a side.
cost: processor time of the foundation, and of the EMT forces of six explicit layers.
"""

import argparse
from time import process_time

import numpy as np
from ase.build import bulk
from ase.calculators.emt import EMT
from ase.optimize import FIRE, LBFGS
from ase.optimize.precon import PreconLBFGS
from markdown import order, table
from matscipy.calculators.pair_potential import LennardJonesCut, PairPotential

from ase_roughcontact import RoughSphere
from ase_roughcontact.foundation import (
    CrystalSurface,
    FoundationPrecon,
    add_indenter,
    crystal_slab,
)


def displacement(atoms, calculator, precon, force):
    """Return how far an atom moves under a force, relative to the surface's mean."""
    top = np.flatnonzero(atoms.get_tags() == 1)
    external = np.zeros((len(atoms), 3))
    external[top, 2] = -force / len(top)
    external[top[0], 2] += force
    atoms = atoms.copy()
    atoms.set_constraint()
    atoms.calc = calculator
    for _ in range(60):
        forces = atoms.get_forces() + external
        if abs(forces).max() < 1e-6:
            return atoms.positions[top[0], 2] - atoms.positions[top, 2].mean()
        atoms.positions += precon.solve(forces.ravel()).reshape(-1, 3)
    return np.nan


def thick_slab(surface, n, layers=40):
    """Return a slab with two free surfaces, and a preconditioner for it."""
    atoms, foundation = crystal_slab("Cu", (n, n), layers, EMT(), surface)
    distances = -np.diff(surface.column(layers).positions[:, 2])
    number = len(surface.heights) - 1
    distances[-number:] = distances[:number][::-1]
    heights = -np.append(0.0, np.cumsum(distances))
    atoms.positions[:, 2] = np.repeat(heights[::-1], n * n)
    return atoms, FoundationPrecon(atoms, foundation)


def accuracy(n=7):
    """Print relative errors of the displacement."""
    surface = CrystalSurface.from_calculator(EMT(), "Cu")
    thick, precon = thick_slab(surface, n)
    slabs = {k: crystal_slab("Cu", (n, n), k, EMT(), surface) for k in (2, 4, 8)}
    rows = []
    for force in (0.02, -0.02, 0.3, -0.3, -1.0):
        expected = displacement(thick, EMT(), precon, force)
        errors = [
            displacement(atoms, calculator, FoundationPrecon(atoms, calculator), force)
            / expected
            - 1
            for atoms, calculator in slabs.values()
        ]
        rows.append((f"{force:g}", *map(order, errors)))
    table("force (eV/Å) | 2 layers | 4 layers | 8 layers", rows)


def steps(sizes=(8, 16, 32, 64)):
    """Print the number of steps of optimizers."""
    a = 3.6
    potential = LennardJonesCut(0.4, a / 2**0.5 / 1.1, 1.3 * a)
    calculator = PairPotential({(29, 29): potential})
    surface = CrystalSurface.from_calculator(
        calculator, bulk("Cu", a=a), layers=11, size=7, displacement=0.0
    )
    rows = []
    for n in sizes:
        counts = []
        for name in ("preconditioned", "LBFGS", "FIRE"):
            atoms, foundation = crystal_slab("Cu", (n, n), 2, calculator, surface)
            add_indenter(atoms, RoughSphere(20.0))
            atoms.positions[-1, 2] -= 0.5
            if name == "preconditioned":
                precon = FoundationPrecon(atoms, foundation)
                relax = PreconLBFGS(
                    atoms, precon=precon, use_armijo=False, logfile=None
                )
            else:
                relax = {"LBFGS": LBFGS, "FIRE": FIRE}[name](atoms, logfile=None)
            relax.run(fmax=1e-3, steps=1000)
            counts.append(relax.nsteps)
        rows.append((f"{n} × {n}", *counts))
    table("cells | `PreconLBFGS` with it | `LBFGS` | `FIRE`", rows)


def cost(sizes=(16, 32, 64)):
    """Print processor times."""
    surface = CrystalSurface.from_calculator(EMT(), "Cu")
    rows = []
    for n in sizes:
        begin = process_time()
        atoms, foundation = crystal_slab("Cu", (n, n), 6, EMT(), surface)
        built = process_time()
        atoms.get_forces()
        times = []
        inner = atoms.copy()
        inner.set_constraint()
        inner.calc = EMT()
        for _ in range(3):
            atoms.rattle(1e-3)
            inner.positions = atoms.positions
            start = process_time()
            inner.get_forces()
            middle = process_time()
            moved = foundation.sites.displacement(atoms.positions)
            foundation.coupling.evaluate(moved)
            times.append((middle - start, process_time() - middle))
        forces, elastic = np.min(times, axis=0)
        times = f"{1e3 * forces:.0f}", f"{1e3 * elastic:.1f}", f"{built - begin:.1f}"
        rows.append((f"{n} × {n}", *times))
    table("cells | EMT (ms) | foundation (ms) | once (s)", rows)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    studies = {"accuracy": accuracy, "steps": steps, "cost": cost}
    parser.add_argument("studies", nargs="+", choices=studies)
    for study in parser.parse_args().studies:
        studies[study]()
