r"""
Static friction after a hold
============================

A smooth and a rough sphere slide, stop for some time, and slide again at some rate.
With rate and state friction the contacts age in the hold. The static friction, the
largest force when they slide again, grows by :math:`b \ln t` with the time t of the
hold and by :math:`a \ln V` with the rate V, whatever the roughness.
"""

import matplotlib.pyplot as plt
import numpy as np

import ase_roughcontact as rc
from ase_roughcontact.plot import style

A0, RADIUS = 2.5, 200.0  # Å
LOAD = 4.0  # eV/Å
SIZE = 24  # atoms along x and y
HOLDS = [100.0, 1000.0, 10000.0]  # s
RATES = [0.1, 1.0, 10.0]  # Å/s
HOLD, RATE, WAY = 1000.0, 1.0, 6.0  # s, Å/s, Å
SOLID = rc.Isotropic(0.8, poisson=0.5)  # eV/Å^3
ROUGH = rc.SelfAffine(0.1, 0.8, 2 * A0, 16 * A0, seed=1)
LAW = rc.RateAndState(0.3, 0.01, 0.015, distance=3.0, velocity=RATE)


def static_friction(roughness, holds, rates):
    """Return the largest friction coefficient of the slide after each hold."""
    sphere = rc.RoughSphere(RADIUS, roughness)
    atoms = rc.substrate("Cu", (SIZE, SIZE), sphere, spacing=A0)
    atoms.calc = rc.RoughContact(sphere, solid=SOLID, wall=rc.HardWall())
    schedule, slides = rc.Schedule(0.0).ramp(WAY, rate=RATE), []
    for number, (hold, rate) in enumerate(zip(holds, rates, strict=True), 2):
        begin = schedule.duration + hold
        schedule = schedule.hold(hold).ramp(number * WAY, rate=rate)
        slides.append((begin, schedule.duration))
    times, friction = [], []
    for step in rc.sliding_path(
        atoms,
        LAW,
        loads=LOAD,
        displacements=schedule,
        tolerance=1e-2,
        validity="ignore",  # the surface is alike everywhere along the slide
    ):
        times.append(step.time)
        friction.append(step.lateral_force_x / step.normal_force)
    times, friction = np.array(times), np.array(friction)
    return [friction[(times >= a) & (times <= b)].max() for a, b in slides]


# %%
# The holds are long against :math:`D_c/V_0`, 3 s.

with style():
    figure, (left, right) = plt.subplots(1, 2, figsize=(6.8, 2.6), sharey=True)
    for roughness, label, color in ((None, "smooth", "C0"), (ROUGH, "rough", "C1")):
        aged = static_friction(roughness, HOLDS, [RATE] * len(HOLDS))
        moved = static_friction(roughness, [HOLD] * len(RATES), RATES)
        left.plot(HOLDS, aged, "o", color=color, label=label)
        right.plot(RATES, moved, "o", color=color, label=label)
        b = np.polyfit(np.log(HOLDS), aged, 1)[0]
        a = np.polyfit(np.log(RATES), moved, 1)[0]
        print(f"{label}: grows by {b:.4f} ln t (b = 0.015), {a:.4f} ln V (a = 0.010)")
    last = aged[-1] + LAW.evolution_effect * np.log(np.array(HOLDS) / HOLDS[-1])
    left.plot(HOLDS, last, "k-", lw=0.8, label=r"$b \ln t$")
    last = moved[-1] + LAW.direct_effect * np.log(np.array(RATES) / RATES[-1])
    right.plot(RATES, last, "k-", lw=0.8, label=r"$a \ln V$")
    left.set(xlabel="time of the hold (s)", ylabel="static friction", xscale="log")
    right.set(xlabel="rate of the slide (Å/s)", xscale="log")
    left.set_title(f"(a) at {RATE:g} Å/s")
    right.set_title(f"(b) after {HOLD:g} s")
    left.legend()
    right.legend()
    figure.savefig("static_friction.png", dpi=150)
