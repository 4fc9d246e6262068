r"""
Creep under a load
==================

A load is put at once on a smooth and on a rough sphere on a viscoelastic solid, under a
hard wall, and held. The contact of the smooth sphere creeps as the compliance: the
force of Hertz with the modulus of the moment gives :math:`a^3 \propto J(t)`. The area
of the rough sphere, at first that of its asperities, approaches that of the smooth one.
"""

import warnings

import matplotlib.pyplot as plt
import numpy as np

import ase_roughcontact as rc
from ase_roughcontact.plot import style

warnings.simplefilter("ignore", rc.ValidityWarning)

A0, RADIUS, LOAD = 2.5, 800.0, 60.0  # Å, Å, eV/Å
MODULUS = 1.0  # eV/Å^3, instantaneous; the relaxed modulus is a tenth
CREEP = rc.Creep.of_relaxation([0.5, 0.4], times=[0.02, 1.0])  # s
DWELL = 40.0  # s
ROUGH = rc.SelfAffine(0.03, 0.8, 4 * A0, 64 * A0, domain=128 * A0, seed=1)


def creep(roughness):
    """Return times (s) since the load acts, and contact areas (Å^2)."""
    sphere = rc.RoughSphere(RADIUS, roughness)
    atoms = rc.substrate("Cu", (8, 8), sphere, spacing=A0)
    solid = rc.Viscoelastic(MODULUS, CREEP)
    atoms.calc = rc.RoughContact(sphere, solid=solid, wall=rc.HardWall())
    path = rc.Schedule(0.0).step(LOAD).hold(DWELL)
    steps = list(rc.time_path(atoms, loads=path, window="auto"))[1:]
    return np.transpose([(step.time, step.contact_area) for step in steps])


hertz = np.pi * (0.75 * RADIUS * LOAD / MODULUS) ** (2 / 3)
with style():
    figure, axes = plt.subplots(figsize=(4.5, 3.2), layout="constrained")
    for roughness, label, line in ((None, "smooth", "-"), (ROUGH, "rough", "--")):
        times, areas = creep(roughness)
        theory = hertz * CREEP.compliance(times) ** (2 / 3)
        axes.plot(times, areas / hertz, line, label=label)
        last = areas[-1] / theory[-1]
        print(f"{label}: {areas[0] / theory[0]:.3f} of Hertz at once, {last:.3f} late")
        if roughness is None:
            error = abs(areas / theory - 1.0).max()
            axes.plot(times, theory / hertz, "k:", label=r"theory, $a^3 \propto J(t)$")
    axes.set(xlabel="time (s)", ylabel="contact area over that of Hertz at once")
    axes.legend()
    figure.savefig("creep_under_load.png", dpi=120)

# %%
# The largest difference of the smooth sphere from theory is that of the counted atoms.

print(f"smooth sphere: {100 * error:.1f} % from theory")
