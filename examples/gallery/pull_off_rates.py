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

import warnings

import matplotlib.pyplot as plt
import numpy as np

import ase_roughcontact as rc
from ase_roughcontact.plot import style

warnings.simplefilter("ignore", rc.ValidityWarning)  # contacts of a few atoms

A0, RADIUS, WORK = 2.5, 100.0, 0.05  # Å, Å, eV/Å^2
MODULUS = 1.0  # eV/Å^3, instantaneous; the relaxed modulus is a tenth
CREEP = rc.Creep.standard_solid(relaxed=0.1, time=1.0)  # s
DWELL = 200.0  # s
RATES = np.logspace(-4, 1, 6)  # Å/s
ROUGH = rc.SelfAffine(0.1, 0.8, 4 * A0, 32 * A0, domain=64 * A0, seed=1)

# %%
# The stiffness of the wall is that for the relaxed modulus, at which the zone of
# attraction at the edge of the contact is narrowest.

WALL = rc.LennardJones93.adhesive(0.1 * MODULUS, A0, WORK)


def retraction(rate, roughness=None):
    """Return depths (Å) and forces (eV/Å) of a retraction at a rate."""
    sphere = rc.RoughSphere(RADIUS, roughness)
    atoms = rc.substrate("Cu", (8, 8), sphere, spacing=A0)
    solid = rc.Viscoelastic(MODULUS, CREEP)
    atoms.calc = rc.RoughContact(sphere, solid=solid, interaction=WALL)
    path = rc.Schedule(3.0).hold(DWELL).ramp(-60.0, rate=rate)
    curve = []
    for step in rc.time_path(atoms, path, window="auto", tolerance=2e-3):
        if step.time >= DWELL:
            curve.append((step.penetration, step.normal_force))
            if not step.repulsive_atoms + step.attractive_atoms:
                break
    return np.transpose(curve)


with style():
    figure, (left, right) = plt.subplots(1, 2, figsize=(6.8, 3.0))
    for roughness, label, line in ((None, "smooth", "o-"), (ROUGH, "rough", "s--")):
        effective = []
        for rate in RATES:
            depths, forces = retraction(rate, roughness)
            effective.append(-forces.min() / (1.5 * np.pi * RADIUS * WORK))
            if roughness is None:
                colour = plt.cm.viridis(np.log10(rate / RATES[0]) / 5.5)
                left.plot(depths, forces, color=colour, label=f"{rate:g}")
        right.semilogx(RATES, effective, line, label=label)
        print(label, np.round(effective, 2))
    left.set(xlabel="penetration (Å)", ylabel="normal force (eV/Å)")
    left.set_title("(a) retraction of the smooth sphere")
    left.legend(title="rate (Å/s)")
    right.set(xlabel="rate (Å/s)", ylabel="effective / true work of adhesion")
    right.set_ylim(bottom=0.0)
    right.set_title("(b) work of adhesion as read by JKR")
    right.legend()
    figure.savefig("pull_off_rates.png", dpi=150)

# %%
# The rough sphere adheres a little less at all rates; its pull-off force grows with the
# rate in the same way.
