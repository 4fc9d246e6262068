"""Which optimizers of ASE relax a contact, on atoms and on the Fourier modes.

    python examples/benchmarks/ase_optimizers.py

compares all of them on a small contact: fixed and under a load, with a repulsive and an
adhesive wall. Writes `ase_optimizers.csv`.
"""

import argparse
import csv
import warnings
from dataclasses import asdict
from pathlib import Path

from markdown import table as print_table

from ase_roughcontact import (
    FourierModes,
    LennardJones93,
    RoughContact,
    RoughSphere,
    SelfAffine,
    compare_optimizers,
    settings_for,
    substrate,
)
from ase_roughcontact.atoms.calculator import contact_of
from ase_roughcontact.optimize.names import optimizer_class, optimizer_names

OUT = Path(__file__).with_name("ase_optimizers.csv")
SPACING, MODULUS = 2.5, 0.9  # Å, eV/Å^3
WALLS = {
    "repulsive": LennardJones93.repulsive(MODULUS, SPACING),
    "adhesive": LennardJones93.adhesive(MODULUS, SPACING, 0.01 * MODULUS * SPACING),
}
CASES = [(wall, control) for wall in WALLS for control in ("fixed", "load")]


def contact(wall, control):
    """Atoms under a rough sphere, 7 x 7 of them."""
    rough = SelfAffine(0.05, 0.8, 4 * SPACING, 16 * SPACING, seed=1)
    sphere = RoughSphere(250.0, rough)
    fixed = control == "fixed"
    atoms = substrate("Cu", (7, 7), sphere, spacing=SPACING, fixed=fixed)
    load = 0.0 if fixed else 3.0  # eV/Å
    atoms.calc = RoughContact(sphere, MODULUS, WALLS[wall], load=load)
    depth = 0.5 if fixed else 0.0
    atoms.positions[-1, 2] = contact_of(atoms).first_contact - depth
    return atoms


def settings(name):
    """Names of the settings that an optimizer gets, and what it works on."""
    atoms = contact("repulsive", "fixed")
    target = FourierModes(atoms) if name.endswith(" on modes") else atoms
    try:
        return " ".join(settings_for(optimizer_class(name), target))
    except ValueError:
        return ""


def report(out):
    """Print the steps to an error of 1 %, or why an optimizer is refused."""
    with open(out, encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    names = list(dict.fromkeys(row["optimizer"] for row in rows))
    found = {(r["optimizer"], r["wall"], r["control"]): r for r in rows}
    table, refused = [], {}
    for name in names:
        steps, kept = [], ""
        for case in CASES:
            row = found[(name, *case)]
            kept = row["settings"]
            failed = "-" if int(row["steps"]) == 0 else f"> {row['steps']}"
            steps.append(row["steps"] if row["converged"] == "True" else failed)
        if set(steps) == {"-"}:
            reason = found[(name, *CASES[0])]["reason"].partition(" ")[2]
            refused.setdefault(reason, []).append(name)
            continue
        shown = f"`{name}`".replace(" on modes`", "` on modes")
        table.append((shown, f"`{kept}`" if kept else "", *steps))
    heads = " | ".join(f"{wall}, {control}" for wall, control in CASES)
    print_table(f"optimizer | settings | {heads}", table)
    print()
    for reason, those in refused.items():
        print(f"- {', '.join(those)}: {reason}")


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--steps", type=int, default=2000)
    parser.add_argument("--names", nargs="+", default=optimizer_names()[2:])
    parser.add_argument("--out", type=Path, default=OUT)
    parser.add_argument("--report", action="store_true", help="print the table")
    options = parser.parse_args(arguments)
    if options.report:
        return report(options.out)
    rows = []
    warnings.filterwarnings("ignore", "Armijo linesearch failed")
    for wall, control in CASES:
        compared = compare_optimizers(
            contact(wall, control), options.names, max_steps=options.steps
        )
        print(f"{wall}, {control}: {compared}", flush=True)
        for result in compared.results:
            given = {"wall": wall, "control": control}
            given["settings"] = settings(result.optimizer)
            rows.append(given | asdict(result))
    with open(options.out, "w", encoding="utf-8", newline="") as file:
        names = [name for name in rows[0] if name != "history"]
        table = csv.DictWriter(file, names, extrasaction="ignore")
        table.writeheader()
        table.writerows(rows)
    return None


if __name__ == "__main__":
    main()
