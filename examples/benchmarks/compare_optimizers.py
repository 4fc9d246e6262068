"""Which optimizer for what: the same contact relaxed by all of them.

    python examples/benchmarks/compare_optimizers.py --sizes 128

prints, for a smooth sphere, a rough one, and a rough one that adheres, how many force
evaluations (padded transform pairs) and seconds each optimizer took to the same force,
and which energy it found; writes the table as `optimizers.csv` and the residual of the
largest size against evaluations and time as `optimizers.png`.
BFGSLineSearch keeps a matrix of all coordinates: it runs at sizes up to 8, and up to 16
on the modes.
"""

import argparse
import csv
import time
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
from ase.optimize import FIRE, FIRE2, LBFGS, BFGSLineSearch
from ase.optimize.precon import PreconFIRE, PreconLBFGS
from markdown import order
from markdown import table as print_table
from matplotlib import pyplot

from ase_roughcontact import (
    FourierModes,
    HalfSpacePrecon,
    LennardJones93,
    NewtonKrylov,
    RoughContact,
    RoughSphere,
    SelfAffine,
    substrate,
)
from ase_roughcontact.atoms.calculator import contact_of
from ase_roughcontact.plot import style

OUT = Path(__file__).with_name("optimizers")
SPACING, MODULUS = 2.5, 0.9  # Å, eV/Å^3
UNIT = MODULUS * SPACING**2  # of force, E* a0^2
LOOKS = {
    "NewtonKrylov": ("black", "*"),
    "FIRE": ("#0072B2", "o"),
    "FIRE2": ("#56B4E9", "s"),
    "LBFGS": ("#D55E00", "^"),
    "PreconLBFGS": ("#009E73", "v"),
    "PreconFIRE": ("#CC79A7", "D"),
    "BFGSLineSearch": ("#E69F00", "x"),
}
TITLES = {
    "smooth": "smooth sphere",
    "rough": "rough sphere",
    "adhesive": "rough sphere, adhesion",
}
DENSE = 8, 16  # BFGSLineSearch keeps a matrix: largest sides of atoms and modes


class Run(NamedTuple):
    """What one optimizer did."""

    case: str
    size: int
    optimizer: str
    converged: bool
    steps: int
    evaluations: float
    seconds: float
    energy: float
    history: list


def contact(case, size):
    """Atoms of a case, the indenter pressed in as far as the window is wide."""
    a0 = SPACING
    rough = SelfAffine(0.1, 0.8, 4 * a0, 64 * a0, seed=1)
    sphere = RoughSphere(20 * size * a0, None if case == "smooth" else rough)
    work = 0.005 * MODULUS * a0 if case == "adhesive" else 0.0
    wall = LennardJones93.adhesive(MODULUS, a0, work)
    atoms = substrate("Cu", (size, size), sphere, spacing=a0)
    atoms.calc = RoughContact(sphere, MODULUS, wall)
    atoms.positions[-1, 2] -= 0.5 * a0
    return atoms


def on_modes(optimizer, atoms, **options):
    """Optimizer on the scaled modes of the half space."""
    modes = FourierModes(atoms)
    if optimizer in (FIRE, FIRE2):
        options["maxstep"] = modes.maxstep
    return optimizer(modes, **options)


def with_precon(optimizer, atoms, **options):
    """Optimizer of ASE's preconditioned family."""
    return optimizer(atoms, precon=HalfSpacePrecon(atoms), **options)


def optimizers(size):
    """Name and maker of each optimizer, plain and with the half space's help."""
    memory = {"memory": 20}
    wide = {"maxstep": 0.2 * size}  # FIRE limits the norm of the whole step
    makers = {
        "NewtonKrylov": NewtonKrylov,
        "FIRE": partial(FIRE, **wide),
        "FIRE2": partial(FIRE2, **wide),
        "LBFGS": partial(LBFGS, **memory),
        "PreconLBFGS": partial(PreconLBFGS, precon=None, **memory),
        "FIRE, modes": partial(on_modes, FIRE),
        "FIRE2, modes": partial(on_modes, FIRE2),
        "LBFGS, modes": partial(on_modes, LBFGS, alpha=1.0, **memory),
        "PreconLBFGS, half space": partial(with_precon, PreconLBFGS, **memory),
        "PreconFIRE, half space": partial(with_precon, PreconFIRE, maxmove=0.2 * size),
    }
    if size <= DENSE[0]:
        makers["BFGSLineSearch"] = BFGSLineSearch
    if size <= DENSE[1]:
        makers["BFGSLineSearch, modes"] = partial(on_modes, BFGSLineSearch)
    return makers


def evaluations(dynamics, halfspace):
    """Count the padded transform pairs so far."""
    if isinstance(dynamics, NewtonKrylov):
        return dynamics.pairs
    if isinstance(dynamics.optimizable, FourierModes):
        return dynamics.optimizable.evaluations
    return halfspace.grid_transform.pairs


def relax(case, size, name, make, fmax, steps):
    """Relax a case with one optimizer, and follow its residual."""
    atoms = contact(case, size)
    halfspace = contact_of(atoms).halfspace
    dynamics = make(atoms, logfile=None)
    history, start = [], time.perf_counter()
    for converged in dynamics.irun(fmax=fmax, steps=steps):
        gradient = dynamics.optimizable.get_gradient()
        residual = dynamics.optimizable.gradient_norm(gradient) / UNIT
        spent = time.perf_counter() - start
        history.append((evaluations(dynamics, halfspace), spent, float(residual)))
        done = bool(converged)
    next(dynamics.optimizable.iterimages())
    energy = float(atoms.get_potential_energy())
    return Run(
        case, size, name, done, dynamics.nsteps, *history[-1][:2], energy,
        history,
    )  # fmt: skip


def compare(cases, sizes, fmax, steps):
    """Yield a run for every case, size and optimizer."""
    for case in cases:
        for size in sizes:
            for name, make in optimizers(size).items():
                yield relax(case, size, name, make, fmax, steps)


def draw(runs, file):
    """Plot the least residual so far against the FFT pairs, one panel a case.

    Of the largest size. A colour is an optimizer; dashed, it has the half space's help.
    """
    largest = max(run.size for run in runs)
    cases = list(dict.fromkeys(run.case for run in runs))
    size = {"figsize": (1 + 2.0 * len(cases), 3.2), "squeeze": False}
    figure, axes = pyplot.subplots(1, len(cases), **size, sharex=True, sharey=True)
    for letter, case, axis in zip("abc", cases, axes[0], strict=False):
        for run in (run for run in runs if (run.case, run.size) == (case, largest)):
            name, _, helped = run.optimizer.partition(",")
            colour, mark = LOOKS[name]
            line = {"color": colour, "ls": "--" if helped else "-", "marker": mark}
            least = np.minimum.accumulate([point[2] for point in run.history])
            pairs = np.maximum([point[0] for point in run.history], 1.0)
            every = max(1, len(pairs) // 8)
            axis.loglog(pairs, least, **line, markevery=every, label=run.optimizer)
        axis.set(title=f"({letter}) {TITLES[case]}", xlabel="FFT pairs")
    axes[0, 0].set_ylabel("largest force on an atom / $E^* a_0^2$")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4)
    figure.savefig(file, dpi=150)


def report(out):
    """Print what the rough sphere took, from the table."""
    with open(out.with_suffix(".csv"), newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["case"] == "rough"]
    least = min(float(row["energy"]) for row in rows)
    rows.sort(key=lambda row: float(row["evaluations"]))
    names = [row["optimizer"].partition(", ") for row in rows]
    print_table(
        "optimizer | steps | FFT pairs | relative error of the energy",
        (
            (
                f"`{name}`{' on ' if helped == 'modes' else comma}{helped}",
                row["steps"],
                f"{float(row['evaluations']):.0f}",
                order(abs(float(row["energy"]) / least - 1)),
            )
            for row, (name, comma, helped) in zip(rows, names, strict=True)
        ),
    )


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--sizes", type=int, nargs="+", default=[64, 128])
    parser.add_argument("--cases", nargs="+", default=["smooth", "rough", "adhesive"])
    parser.add_argument("--fmax", type=float, default=1e-6, help="in E* a0^2")
    parser.add_argument("--steps", type=int, default=2000)
    parser.add_argument("--out", default=OUT, help="name of the files")
    parser.add_argument("--report", action="store_true", help="print the rough sphere")
    options = parser.parse_args(arguments)
    if options.report:
        return report(Path(options.out))
    runs = []
    print(f"{'case':9s}{'size':>5s}  {'optimizer':26s}{'steps':>6s}{'pairs':>8s}"
          f"{'s':>8s}  {'energy (eV)':>15s}  above the first")  # fmt: skip
    out = Path(options.out)
    with open(out.with_suffix(".csv"), "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(Run._fields[:-1])
        for run in compare(
            options.cases, options.sizes, options.fmax * UNIT, options.steps
        ):
            runs.append(run)
            same = [r for r in runs if (r.case, r.size) == (run.case, run.size)]
            above = (run.energy - same[0].energy) / abs(same[0].energy)
            table.writerow(run[:-1])
            file.flush()
            mark = "" if run.converged else "  not converged"
            print(f"{run.case:9s}{run.size:5d}  {run.optimizer:26s}{run.steps:6d}"
                  f"{run.evaluations:8.0f}{run.seconds:8.2f}  {run.energy:15.9f}"
                  f"  {above:8.1e}{mark}", flush=True)  # fmt: skip
    with style():
        draw(runs, out.with_suffix(".png"))
    return runs


if __name__ == "__main__":
    main()
