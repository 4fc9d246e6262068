r"""
Pull-off force, hysteresis and rate
===================================

A sphere is pressed into a viscoelastic solid, held until the solid has relaxed, and
pulled off at rates over five decades, smooth and rough. Slow retraction gives the
pull-off force of the relaxed solid. Fast retraction gives a much larger one: the solid
responds with its instantaneous modulus, to a contact as large as on the relaxed solid.
The pull-off force over :math:`\frac{3}{2} \pi R` is the effective work of adhesion, as
JKR theory would read it. The energy that the solid dissipates has a maximum in
between: a solid that stays relaxed, or has no time to, dissipates little.
"""

import warnings

import matplotlib.pyplot as plt
import numpy as np
from scipy.integrate import trapezoid

import ase_roughcontact as rc
from ase_roughcontact.plot.style import letter, style

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
    """Return depths (Å) and forces (eV/Å) at a rate, and the dissipated energy (eV)."""
    sphere = rc.RoughSphere(RADIUS, roughness)
    atoms = rc.substrate("Cu", (8, 8), sphere, spacing=A0)
    solid = rc.Viscoelastic(MODULUS, CREEP)
    atoms.calc = rc.RoughContact(sphere, solid=solid, interaction=WALL)
    path = rc.Schedule(3.0).hold(DWELL).ramp(-60.0, rate=rate)
    curve = []
    for step in rc.time_path(atoms, path, window="auto", tolerance=2e-3):
        if step.time >= DWELL:
            row = step.penetration, step.normal_force, step.time, step.dissipation
            curve.append(row)
            if not step.repulsive_atoms + step.attractive_atoms:
                break
    depths, forces, times, powers = np.transpose(curve)
    return depths, forces, trapezoid(powers, times)


with style():
    figure, panels = plt.subplots(1, 3, figsize=(8.4, 2.8))
    curves, works, losses = panels
    for roughness, label, line in ((None, "smooth", "o-"), (ROUGH, "rough", "s--")):
        effective, dissipated = [], []
        for rate in RATES:
            depths, forces, lost = retraction(rate, roughness)
            effective.append(-forces.min() / (1.5 * np.pi * RADIUS * WORK))
            dissipated.append(lost)
            if roughness is None:
                colour = plt.cm.viridis(np.log10(rate / RATES[0]) / 5.5)
                curves.plot(depths, forces, color=colour, label=f"{rate:g}")
        works.semilogx(RATES, effective, line, label=label)
        losses.loglog(RATES, dissipated, line, label=label)
        print(label, np.round(effective, 2), np.round(dissipated))
    curves.set(xlabel="penetration (Å)", ylabel="normal force (eV/Å)")
    curves.legend(title="rate (Å/s)")
    works.set(ylabel="effective / true work of adhesion", ylim=(0.0, None))
    losses.set(ylabel="dissipated energy (eV)")
    for panel in (works, losses):
        panel.set(xlabel="rate (Å/s)")
        panel.legend()
    letter(panels)
    figure.savefig("pull_off_rates.png", dpi=140)

# %%
# The rough sphere adheres a little less at all rates; its pull-off force grows with the
# rate in the same way.
