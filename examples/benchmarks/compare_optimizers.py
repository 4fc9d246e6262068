"""Which optimizer for what: the same contacts relaxed by all usual ones.

    python examples/benchmarks/compare_optimizers.py --size 64

compares optimizers on a smooth sphere, a rough one, and a rough one that adheres, by
``compare_optimizers``: evaluations, FFT pairs, time, and errors of force, area and
energy. Writes the table as `optimizers.csv` and the error against FFT pairs as
`optimizers.png`.
"""

import argparse
import csv
from dataclasses import asdict
from pathlib import Path

from markdown import order
from markdown import table as print_table
from matplotlib import pyplot

from ase_roughcontact import (
    LennardJones93,
    RoughContact,
    RoughSphere,
    SelfAffine,
    compare_optimizers,
    substrate,
)
from ase_roughcontact.plot import plot_optimizers, style

OUT = Path(__file__).with_name("optimizers")
SPACING, MODULUS = 2.5, 0.9  # Å, eV/Å^3
NAMES = (
    *("NewtonKrylov", "LBFGS", "FIRE", "FIRE2", "PreconLBFGS", "PreconFIRE"),
    *("LBFGS on modes", "FIRE on modes", "FIRE2 on modes", "SciPyFminCG on modes"),
)
TITLES = {
    "smooth": "smooth sphere",
    "rough": "rough sphere",
    "adhesive": "rough sphere, adhesion",
}


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


def draw(compared, file):
    """Draw a panel for each case."""
    size = {"figsize": (1.5 + 2.0 * len(compared), 2.6), "squeeze": False}
    figure, axes = pyplot.subplots(1, len(compared), **size, sharex=True, sharey=True)
    panels = zip("abc", compared.items(), axes[0], strict=False)
    for letter, (case, comparison), axis in panels:
        plot_optimizers(axis, comparison)
        axis.set(title=f"({letter}) {TITLES[case]}", xlabel="FFT pairs")
        if axis is not axes[0, -1]:
            axis.get_legend().remove()
        if axis is not axes[0, 0]:
            axis.set_ylabel("")
    figure.savefig(file, dpi=150)


def report(out):
    """Print what the rough sphere took, from the table."""
    with open(out.with_suffix(".csv"), encoding="utf-8", newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["case"] == "rough"]
    rows.sort(key=lambda row: float(row["pairs"]))
    print_table(
        "optimizer | steps | FFT pairs | to the error | error | energy (eV)",
        (
            (
                f"`{row['optimizer']}`".replace(" on modes`", "` on modes"),
                row["steps"],
                f"{float(row['pairs']):.0f}",
                f"{float(row['pairs_to_accuracy']):.0f}",
                order(float(row["error"])),
                order(float(row["energy_error"])),
            )
            for row in rows
        ),
    )


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--size", type=int, default=64)
    parser.add_argument("--cases", nargs="+", default=list(TITLES))
    parser.add_argument("--error", type=float, default=1e-3)
    parser.add_argument("--steps", type=int, default=2000)
    parser.add_argument("--out", default=OUT, help="name of the files")
    parser.add_argument("--report", action="store_true", help="print the rough sphere")
    options = parser.parse_args(arguments)
    if options.report:
        return report(Path(options.out))
    compared, out = {}, Path(options.out)
    for case in options.cases:
        atoms = contact(case, options.size)
        compared[case] = compare_optimizers(
            atoms, NAMES, options.error, max_steps=options.steps
        )
        print(f"{TITLES[case]}: {compared[case]}", flush=True)
    rows = [
        {"case": case, **asdict(result)}
        for case, comparison in compared.items()
        for result in comparison.results
    ]
    with open(out.with_suffix(".csv"), "w", encoding="utf-8", newline="") as file:
        names = [name for name in rows[0] if name != "history"]
        table = csv.DictWriter(file, names, extrasaction="ignore")
        table.writeheader()
        table.writerows(rows)
    with style():
        draw(compared, out.with_suffix(".png"))
    return compared


if __name__ == "__main__":
    main()
