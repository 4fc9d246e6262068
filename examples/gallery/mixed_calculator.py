"""Another ASE calculator beside RoughContact, or constraints: one and the same answer.

    python examples/gallery/mixed_calculator.py --size 12

puts tip and surface atoms on springs of their own, an elastic foundation: once by ASE's
SpringCalculator in a SumCalculator, once by its Hookean constraints.
"""

import argparse

from ase import Atoms
from ase.calculators.harmonic import SpringCalculator
from ase.calculators.mixing import SumCalculator
from ase.constraints import Hookean
from ase.optimize import LBFGS
from matplotlib.figure import Figure

from ase_roughcontact import RoughContact, RoughSphere, substrate
from ase_roughcontact.plot import style


def relaxed(kind: str, size: int, stiffness: float = 1.0) -> Atoms:  # in eV/Å^2
    sphere = RoughSphere(20.0 * size)
    atoms = substrate("Cu", (size, size), sphere, fixed=False)
    rest = atoms.positions.copy()
    rest[-1, 2] -= 8.0
    contact = RoughContact(sphere, contact_modulus=0.9)
    if kind == "calculator":
        atoms.calc = SumCalculator([contact, SpringCalculator(rest, stiffness)])
    else:
        atoms.calc = contact
        held = range(len(atoms)) if kind == "constraints" else [len(atoms) - 1]
        atoms.set_constraint([Hookean(i, rest[i], k=stiffness, rt=0.0) for i in held])
    if not LBFGS(atoms, logfile=None).run(fmax=1e-6, steps=5000):
        raise RuntimeError(f"{kind}: the contact did not converge")
    return atoms


def main(arguments: list[str] | None = None) -> float:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--size", type=int, default=12, help="atoms along a side")
    parser.add_argument("--picture", default="mixed_calculator.png")
    options = parser.parse_args(arguments)
    size, lines = options.size, {"bare": ":", "calculator": "-", "constraints": "--"}
    atoms = {kind: relaxed(kind, size) for kind in lines}
    error = abs(atoms["calculator"].positions - atoms["constraints"].positions).max()
    with style():
        axes = Figure().subplots()
        for kind, each in atoms.items():
            row = each.positions[:-1].reshape(2 * size, 2 * size, 3)[:size, size // 2]
            axes.plot(row[:, 0], row[:, 2], lines[kind], label=kind)
        axes.set(xlabel="$x$ (Å)", ylabel="displacement (Å)")
        axes.legend().figure.savefig(options.picture, dpi=200)
    print(f"calculator and constraints differ by {error:.1e} Å")
    return float(error)


if __name__ == "__main__":
    main()
