r"""
Pull-off force and rate
=======================

A sphere is pressed into a viscoelastic solid, held until the solid has relaxed, and
pulled off at rates over five decades, smooth and rough. Slow retraction gives the
pull-off force of the relaxed solid. Fast retraction gives a much larger one: the solid
responds with its instantaneous modulus, to a contact as large as on the relaxed solid.
The pull-off force over :math:`\frac{3}{2} \pi R` is the effective work of adhesion, as
JKR theory would read it.
"""

# sphinx_gallery_thumbnail_number = 1
import warnings

import matplotlib.pyplot as plt
import numpy as np

from ase_roughcontact import (
    Creep,
    LennardJones93,
    RoughContact,
    RoughSphere,
    Schedule,
    SelfAffine,
    ValidityWarning,
    Viscoelastic,
    substrate,
    time_path,
)
from ase_roughcontact.plot import COLOURS, style

# small contacts are the point here
warnings.simplefilter("ignore", ValidityWarning)

A0, RADIUS, WORK, TIME = 2.5, 100.0, 0.05, 1.0  # Å, Å, eV/Å^2, s
MODULUS = 1.0  # eV/Å^3, instantaneous; the relaxed modulus is a tenth
CREEP = Creep.standard_solid(relaxed=0.1, time=TIME)
RATES = np.logspace(-2, 3, 6)  # Å/s
ROUGH = SelfAffine(0.1, 0.8, 4 * A0, 32 * A0, domain=32 * A0, seed=1)


def retraction(rate, roughness=None):
    """Return depths (Å) and forces (eV/Å) of a retraction at a rate."""
    sphere = RoughSphere(RADIUS, roughness)
    atoms = substrate("Cu", (8, 8), sphere, spacing=A0)
    atoms.calc = RoughContact(
        sphere,
        solid=Viscoelastic(MODULUS, CREEP),
        interaction=LennardJones93.adhesive(MODULUS, A0, WORK),
    )
    path = Schedule(3.0).hold(200.0 * TIME).ramp(-60.0, rate=rate)
    depths, forces = [], []
    for step in time_path(atoms, path, window="auto", tolerance=2e-3):
        if step.time >= 200.0 * TIME:
            depths.append(step.penetration)
            forces.append(step.normal_force)
            if not step.repulsive_atoms + step.attractive_atoms:
                break
    return np.array(depths), np.array(forces)


with style():
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.0, 3.0))
    for roughness, label, marker in ((None, "smooth", "o-"), (ROUGH, "rough", "s--")):
        pull_off = []
        for rate, colour in zip(RATES, COLOURS, strict=False):
            depths, forces = retraction(rate, roughness)
            pull_off.append(-forces.min())
            if roughness is None:
                left.plot(depths, forces, color=colour, label=f"{rate:g}")
        effective = np.array(pull_off) / (1.5 * np.pi * RADIUS * WORK)
        right.semilogx(RATES, effective, marker, label=label)
        print(label, np.round(effective, 2))
    left.set(xlabel="penetration (Å)", ylabel="normal force (eV/Å)")
    left.legend(title="rate (Å/s)")
    right.set(xlabel="rate (Å/s)", ylabel="effective over true work of adhesion")
    right.set_ylim(bottom=0.0)
    right.legend()
    plt.show()

# %%
# The rough sphere adheres a little less at all rates; its pull-off force grows with the
# rate in the same way. The slowest curves have steps: rows of atoms detach one by one,
# as the spacing is hardly smaller than the range of the attraction at the relaxed
# modulus.
