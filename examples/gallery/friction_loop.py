r"""
Friction loops
==============

A smooth and a rough sphere are pressed down under the same load and moved to and fro.
Points at the edge of a contact slip first, under the small pressures there, and a loop
opens; when all points slip, the lateral force is the friction coefficient times the
load. Mindlin's stick area is :math:`(1 - Q/\mu N)^{2/3}` of the contact.
"""

import matplotlib.pyplot as plt
import numpy as np

import ase_roughcontact as rc
from ase_roughcontact.analysis import loop_energies
from ase_roughcontact.plot import plot_friction_loop, plot_tractions, style

A0, RADIUS, LOAD, MU = 2.5, 500.0, 60.0, 0.3  # Å, Å, eV/Å
STEPS = 20  # between two turns
SOLID = rc.Isotropic(0.8, poisson=0.3)  # eV/Å^3
ROUGH = rc.SelfAffine(0.05, 0.8, 4 * A0, 32 * A0, domain=128 * A0, seed=1)


def loop(roughness, amplitude):
    """Return the steps of a path to and fro, and the frame in the middle."""
    sphere = rc.RoughSphere(RADIUS, roughness)
    atoms = rc.substrate("Cu", (8, 8), sphere, spacing=A0)
    atoms.calc = rc.RoughContact(sphere, solid=SOLID, wall=rc.HardWall())
    turns = amplitude * np.array([0.0, 1.0, -1.0, 1.0])
    path = np.interp(np.arange(3 * STEPS + 1) / STEPS, range(4), turns)
    steps, friction = [], rc.Coulomb(MU)
    for step in rc.sliding_path(
        atoms, friction, loads=LOAD, displacements=path, window="auto"
    ):
        steps.append(step)
        if step.step == STEPS // 2:
            frame = rc.snapshot(atoms)
    return steps, frame


# %%
# The middle of the first way, from zero to the first turn, is drawn as a map.

with style():
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(6.8, 2.6))
    for roughness, label, line in ((None, "smooth", "C0"), (ROUGH, "rough", "C1")):
        steps, frame = loop(roughness, 1.0)
        plot_friction_loop(left, steps, color=line, label=label)
        first = steps[1 : STEPS + 1]
        force = [step.lateral_force_x / (MU * step.normal_force) for step in first]
        stick = [step.stick_area / step.contact_area for step in first]
        middle.plot(force, stick, "o", color=line, label=label)
        (energy,) = loop_energies(steps)
        mindlin = (1.0 - np.minimum(force, 1.0)) ** (2.0 / 3.0)
        error = max(abs(stick - mindlin))
        print(f"{label}: {energy:.1f} eV a loop, Mindlin's stick area to {error:.3f}")
    q = np.linspace(0.0, 1.0)
    middle.plot(q, (1.0 - q) ** (2.0 / 3.0), "k-", lw=0.8, label="Mindlin")
    middle.set(xlabel=r"lateral force $Q/\mu N$", ylabel="stick area / contact area")
    middle.legend()
    left.legend()
    left.set_title("(a) loops")
    middle.set_title("(b) before sliding")
    plot_tractions(right, frame)
    right.set(xlabel="$x$ (nm)", ylabel="$y$ (nm)")
    right.set_title("(c) rough: blue sticks")
    figure.savefig("friction_loop.png", dpi=150)
