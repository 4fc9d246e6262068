r"""
Pull-off force, hysteresis and rate
===================================

A sphere is pressed into a viscoelastic solid, held until the solid has relaxed, and
pulled off at rates over five decades. Fast retraction needs a much larger force: the
solid responds with its instantaneous modulus, to a contact as large as on the relaxed
solid. The pull-off force over :math:`\frac{3}{2} \pi R` is the effective work of
adhesion, as JKR theory would read it. The hysteresis is the energy lost in a loop of
approach and retraction at one rate; its maximum is in between.
"""

import warnings

import matplotlib.pyplot as plt
import numpy as np
from scipy.integrate import trapezoid

import ase_roughcontact as rc
from ase_roughcontact.plot import letter, style

warnings.simplefilter("ignore", rc.ValidityWarning)  # contacts of a few atoms

A0, RADIUS, WORK = 2.5, 100.0, 0.05  # Å, Å, eV/Å^2
MODULUS = 1.0  # eV/Å^3, instantaneous; the relaxed modulus is a tenth
CREEP = rc.Creep.standard_solid(relaxed=0.1, time=1.0)  # s
DWELL, DEEPEST, FARTHEST = 200.0, 3.0, -60.0  # s, and penetrations in Å
RATES = np.logspace(-4, 1, 6)  # Å/s
ROUGH = rc.SelfAffine(0.1, 0.8, 4 * A0, 32 * A0, domain=64 * A0, seed=1)

# %%
# The stiffness of the wall is that for the relaxed modulus, at which the zone of
# attraction at the edge of the contact is narrowest.

WALL = rc.LennardJones93.adhesive(0.1 * MODULUS, A0, WORK)


def contact(path, turn, roughness=None):
    """Return times, depths and forces until the contact is lost after a time (s)."""
    sphere, solid = rc.RoughSphere(RADIUS, roughness), rc.Viscoelastic(MODULUS, CREEP)
    atoms = rc.substrate("Cu", (8, 8), sphere, spacing=A0)
    atoms.calc = rc.RoughContact(sphere, solid=solid, wall=WALL)
    curve = []
    for step in rc.time_path(atoms, penetrations=path, window="auto", tolerance=2e-3):
        curve.append((step.time, step.penetration, step.normal_force))
        if step.time > turn and not step.repulsive_atoms + step.attractive_atoms:
            break
    return np.transpose(curve)


def pull_off(rate, roughness=None):
    """Return depths and forces of a retraction after a dwell."""
    path = rc.Schedule(DEEPEST).hold(DWELL).ramp(FARTHEST, rate=rate)
    times, *curve = contact(path, DWELL, roughness)
    return [values[times >= DWELL] for values in curve]


def hysteresis(rate, roughness=None):
    """Return the energy lost between approach and retraction (eV)."""
    path = rc.Schedule(-20.0).ramp(DEEPEST, rate=rate).ramp(FARTHEST, rate=rate)
    _, depths, forces = contact(path, (DEEPEST + 20.0) / rate, roughness)
    return trapezoid(forces, depths)


with style():
    figure, (curves, works, losses) = plt.subplots(1, 3, figsize=(8.4, 2.8))
    for roughness, label, line in ((None, "smooth", "o-"), (ROUGH, "rough", "s--")):
        pulled = [pull_off(rate, roughness) for rate in RATES]
        effective = [-f.min() / (1.5 * np.pi * RADIUS * WORK) for _, f in pulled]
        lost = [hysteresis(rate, roughness) for rate in RATES]
        works.semilogx(RATES, effective, line, label=label)
        losses.semilogx(RATES, lost, line, label=label)
        print(label, np.round(effective, 2), np.round(lost))
        for number, curve in enumerate(pulled if roughness is None else ()):
            colour = plt.cm.viridis(number / 5.5)
            curves.plot(*curve, color=colour, label=f"{RATES[number]:g}")
    curves.set(xlabel="penetration (Å)", ylabel="normal force (eV/Å)")
    curves.legend(title="rate (Å/s)")
    works.set(ylabel="effective / true work of adhesion", ylim=(0.0, None))
    losses.set(ylabel="energy lost in a loop (eV)", ylim=(0.0, None))
    plt.setp((works, losses), xlabel="rate (Å/s)")
    works.legend()
    letter((curves, works, losses))
    figure.savefig("pull_off_rates.png", dpi=140)

# %%
# The rough sphere adheres a little less at all rates; its pull-off force grows with the
# rate in the same way. At the lowest rate the solid is relaxed at all times but in the
# jumps, and a loop loses nearly what :func:`.adhesion_loop` finds for an elastic solid
# with the relaxed modulus, 36 eV (smooth) and 19 eV (rough).
