"""
Atoms under a sphere
====================

The atoms of a copper surface are explicit, with a calculator of ASE, on the elastic
crystal below them. A sharp sphere presses into them, until the atoms slip. The elastic
model, the same crystal without explicit atoms, does not include slip.
"""

import matplotlib.pyplot as plt
import numpy as np
from ase.calculators.emt import EMT
from ase.neighborlist import neighbor_list
from ase.optimize import LBFGS

import ase_roughcontact as rough
from ase_roughcontact.elasticity import Crystal
from ase_roughcontact.foundation import CrystalSurface, add_indenter, crystal_slab
from ase_roughcontact.plot import style

SIZE, LAYERS = 10, 8
DEPTHS = (1.0, 1.8, 2.6, 3.0, 3.4, 3.8)  # Å
SLAB = {"layers": 11, "size": 7}

# %%
# The sphere is beside a symmetric place, so that the atoms under it can choose a
# direction of slip.

sphere = rough.RoughSphere(radius=5.0)
surface = CrystalSurface.from_calculator(EMT(), "Cu", **SLAB)
a0, size = surface.constants.spacing, (SIZE, SIZE)
atoms, _ = crystal_slab("Cu", size, LAYERS, EMT(), surface)
axis = SIZE // 2 * a0 + np.array([0.4, 0.25])
indenter = add_indenter(atoms, sphere, position=axis)
touching = atoms.positions[-1, 2]


def neighbours():
    """Return the number of nearest neighbours of each atom."""
    found = neighbor_list("i", atoms[:-1], 1.2 * a0)
    return np.bincount(found, minlength=len(atoms) - 1)


# %%
# Depths are relative to the mean height of the surface, as in the elastic model.

at_rest, path = neighbours(), []
for depth in DEPTHS:
    atoms.positions[-1, 2] = touching - depth
    if not LBFGS(atoms, logfile=None).run(fmax=0.02, steps=1000):
        raise RuntimeError(f"the atoms did not relax at a depth of {depth} Å")
    height = atoms.positions[-1, 2] - atoms.positions[atoms.get_tags() == 1, 2].mean()
    path.append((touching - height, indenter.get_property("normal_force")))

# %%
# The elastic model at the same depths.

crystal = Crystal.from_calculator(EMT(), "Cu", **SLAB)
elastic = rough.substrate("Cu", size, sphere, spacing=crystal.spacing, periodic=True)
elastic.positions[-1, :2], wall = axis, indenter.wall
elastic.calc = rough.RoughContact(sphere, solid=crystal, wall=wall)
depths, forces = np.transpose([(0.0, 0.0), *path])
expected = []
for depth in depths:
    elastic.positions[-1, 2] = touching - depth
    if not rough.NewtonKrylov(elastic, logfile=None).run(fmax=1e-4):
        raise RuntimeError(f"the contact did not converge at a depth of {depth} Å")
    expected.append(elastic.calc.get_property("normal_force", elastic))
    force = forces[len(expected) - 1]
    print(f"depth {depth:.2f} Å: {force:.2f} eV/Å, elastic {expected[-1]:.2f} eV/Å")

# %%
# The last state from the side, with the atoms that have other neighbours than at rest.

change = neighbours() - at_rest
with style():
    figure, (left, right) = plt.subplots(1, 2, figsize=(6.8, 2.8))
    left.plot(depths, expected, label="elastic crystal")
    left.plot(depths, forces, "o-", label="explicit atoms")
    left.set(xlabel="depth (Å)", ylabel="load (eV/Å)", title="(a) load")
    left.legend()
    x, _, z = atoms.positions[:-1].T
    right.scatter(x, z, s=12, color="0.8")
    x, z, change = x[change != 0], z[change != 0], change[change != 0]
    dots = right.scatter(x, z, s=25, c=change, cmap="coolwarm", vmin=-4, vmax=4)
    right.set(xlabel="$x$ (Å)", ylabel="$z$ (Å)", aspect="equal")
    right.set_title(f"(b) atoms at a depth of {DEPTHS[-1]:g} Å")
    figure.colorbar(dots, ax=right, label="change of neighbours")
    figure.savefig("atoms_under_sphere.png", dpi=150)
