r"""
Lateral stiffness and the onset of sliding
==========================================

A rough sphere is loaded over ten decades, and moved sideways against friction. For a
smooth sphere of an isotropic solid, Mindlin's lateral stiffness is
:math:`2 (1 - \nu)/(2 - \nu)` times the normal one, and all of the contact slides at the
displacement :math:`3 \mu N (2 - \nu)/(16 G a)`.
"""

import warnings

import matplotlib.pyplot as plt
import numpy as np
from ase.calculators.emt import EMT

import ase_roughcontact as rc
from ase_roughcontact.elasticity import Crystal, Isotropic
from ase_roughcontact.plot import style

warnings.simplefilter("ignore", rc.ValidityWarning)  # contacts of a few atoms

FRICTION, POISSON = 0.3, 0.3
LOADS = np.logspace(-6, 4, 11)  # E* a0^2
SLAB = {}

# %%
# The crystal is copper, as the potential EMT describes it, with the lateral components
# of its lattice Green's function; the isotropic solid has its contact modulus.

copper = Crystal.from_calculator(EMT(), "Cu", **SLAB)
A0, MODULUS = copper.spacing, copper.contact_modulus
SOLIDS = {"isotropic": Isotropic(MODULUS, POISSON), "crystal": copper}
SMOOTH = rc.RoughSphere(100.0 * A0)
ROUGHNESS = rc.SelfAffine(0.1, 0.8, 4 * A0, 64 * A0, domain=512 * A0, seed=1)
ROUGH = rc.RoughSphere(100.0 * A0, ROUGHNESS)
# displacements relative to Mindlin's at which a smooth sphere slides
PARTS = np.concatenate([[0.0, 1e-3], np.geomspace(0.02, 5.0, 18)])


def lateral(indenter, solid, load):
    """Return the ratio of the stiffnesses, and the displacement of sliding."""
    force = load * MODULUS * A0**2
    radius = (0.75 * force * indenter.radius / MODULUS) ** (1.0 / 3.0)
    shear = 0.5 * MODULUS * (1.0 - POISSON)
    mindlin = 3.0 * FRICTION * force * (2.0 - POISSON) / (16.0 * shear * radius)
    atoms = rc.substrate("Cu", (8, 8), indenter, spacing=A0)
    atoms.calc = rc.RoughContact(indenter, solid=solid, wall=rc.HardWall())
    path = rc.sliding_path(
        atoms,
        rc.Coulomb(FRICTION),
        loads=force,
        displacements=mindlin * PARTS,
        window="auto",
    )
    steps = list(path)
    forces = np.array([step.lateral_force_x for step in steps]) / (FRICTION * force)
    stiffness = forces[1] * FRICTION * force / (PARTS[1] * mindlin)
    return stiffness / steps[0].contact_stiffness, np.interp(0.99, forces, PARTS)


with style():
    results = {}
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.0, 3.0))
    for name, solid, indenter, marker in (
        ("smooth, isotropic", SOLIDS["isotropic"], SMOOTH, "k-"),
        ("rough, isotropic", SOLIDS["isotropic"], ROUGH, "o-"),
        ("rough, crystal", SOLIDS["crystal"], ROUGH, "s--"),
    ):
        ratios, slides = zip(*(lateral(indenter, solid, n) for n in LOADS), strict=True)
        left.semilogx(LOADS, ratios, marker, label=name)
        right.loglog(LOADS, slides, marker, label=name)
        results[name] = ratios
        print(name, "ratio", np.round(ratios, 3), "slides", np.round(slides, 2))
    left.axhline(2.0 * (1.0 - POISSON) / (2.0 - POISSON), color="gray", lw=0.8)
    left.set(title="(a) stiffness", ylabel="lateral over normal stiffness")
    right.set(title="(b) onset of sliding", ylabel="displacement over Mindlin's")
    for axes in (left, right):
        axes.set_xlabel(r"load ($E^* a_0^2$)")
    right.legend()
    figure.savefig("lateral_stiffness.png", dpi=150)

# %%
# A single atom has the ratio of its self-compliances, which on the crystal is larger
# than that of long waves. An isotropic contact has Mindlin's ratio, whatever its shape:
# a little less or more where a few asperities are not round as a group. Where
# asperities carry the load, it slides at a larger displacement than a smooth one.
