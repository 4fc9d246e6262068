"""
Together with another calculator
================================

All atoms are tied to springs of their own, an elastic foundation: once by a second
calculator in ASE's ``SumCalculator``, once by constraints. Both must give the same
displacement.
"""

import matplotlib.pyplot as plt
from ase.calculators.harmonic import SpringCalculator
from ase.calculators.mixing import SumCalculator
from ase.constraints import Hookean
from ase.optimize import LBFGS

from ase_roughcontact import RoughContact, RoughSphere, substrate
from ase_roughcontact.plot import style

SIZE = 12  # atoms along a side of the window

# %%
# The solvers of this package know the half space, the load and a spring on the indenter
# and refuse other constraints. With anything else, use ASE's optimizers on the atoms.


def relaxed(kind, stiffness=1.0):  # eV/Å^2
    """Return atoms relaxed with springs of a kind."""
    sphere = RoughSphere(20.0 * SIZE)
    atoms = substrate("Cu", (SIZE, SIZE), sphere, fixed=False)
    ends = atoms.positions.copy()
    ends[-1, 2] -= 8.0
    contact = RoughContact(sphere, contact_modulus=0.9)
    if kind == "calculator":
        atoms.calc = SumCalculator([contact, SpringCalculator(ends, stiffness)])
    else:
        atoms.calc = contact
        tied = range(len(atoms)) if kind == "constraints" else [len(atoms) - 1]
        atoms.set_constraint([Hookean(i, ends[i], k=stiffness, rt=0.0) for i in tied])
    if not LBFGS(atoms, logfile=None).run(fmax=1e-6, steps=5000):
        raise RuntimeError(f"{kind}: the contact did not converge")
    return atoms


lines = {
    "indenter only": (":", "no springs on the surface"),
    "calculator": ("-", "springs by a second calculator"),
    "constraints": ("--", "springs by constraints"),
}
atoms = {kind: relaxed(kind) for kind in lines}
error = abs(atoms["calculator"].positions - atoms["constraints"].positions).max()
print(f"calculator and constraints differ by {error:.1e} Å")

# %%
# The displacement along a line through the middle: the foundation keeps the surface
# around the contact in place.

with style():
    figure, axes = plt.subplots()
    for kind, relaxed_atoms in atoms.items():
        shape = 2 * SIZE, 2 * SIZE, 3
        row = relaxed_atoms.positions[:-1].reshape(shape)[:SIZE, SIZE // 2]
        line, label = lines[kind]
        axes.plot(row[:, 0], row[:, 2], line, label=label)
    axes.set(
        xlabel="$x$ (Å)", ylabel="displacement of the surface (Å)", ylim=(-0.6, 0.2)
    )
    axes.legend()
    figure.savefig("mixed_calculator.png", dpi=200)
