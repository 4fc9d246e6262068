"""Work of adhesion at pull-off over the speed of the contact's edge.

    python edge_speed.py            # calculates the rows that edge_speed.csv lacks
    python edge_speed.py --report   # prints the table

A smooth and a rough sphere are pressed into a standard linear solid (relaxed modulus a
tenth of the instantaneous one), held until it has relaxed, and pulled off at rates over
five decades. At the largest tension, radius a and force N of the contact give the work
of adhesion that JKR theory with the relaxed modulus needs,
``w = (4 E a^3/3R - N)^2/(8 pi E a^3)``, and the radii around it the speed of the edge.
Beside it are those of a long crack with the largest tension of the wall at its tip, B.
N. J. Persson, E. A. Brener, Phys. Rev. E 71, 036123 (2005), and with that tension along
a cohesive zone, as R. A. Schapery, Int. J. Fract. 11, 141 (1975), and J. A. Greenwood,
J. Phys. D 37, 2557 (2004), for an opening crack; its equation is derived anew here, see
`zone_work`. Both are checked in the limits of slow and fast cracks.
"""

import csv
import math
import sys
import warnings
from pathlib import Path

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq

import ase_roughcontact as rc

FILE = Path(__file__).with_suffix(".csv")
A0, RADIUS, WORK = 2.5, 100.0, 0.05  # Å, Å, eV/Å^2
MODULUS, RELAXED = 1.0, 0.1  # eV/Å^3
CREEP = rc.Creep.standard_solid(relaxed=RELAXED / MODULUS, time=1.0)  # s
DWELL = 200.0  # s
RATES = np.logspace(-4, 1, 6)  # Å/s
ROUGH = rc.SelfAffine(0.1, 0.8, 4 * A0, 32 * A0, domain=64 * A0, seed=1)
WALL = rc.LennardJones93.adhesive(RELAXED, A0, WORK)
COLUMNS = "sphere", "rate", "speed", "pull_off", "work", "dissipated"


def retraction(rate, roughness):
    """Return speed of the edge, pull-off force, work of adhesion, dissipated energy."""
    sphere = rc.RoughSphere(RADIUS, roughness)
    atoms = rc.substrate("Cu", (8, 8), sphere, spacing=A0)
    solid = rc.Viscoelastic(MODULUS, CREEP)
    atoms.calc = rc.RoughContact(sphere, solid=solid, wall=WALL)
    path = rc.Schedule(3.0).hold(DWELL).ramp(-60.0, rate=rate)
    steps = []
    for step in rc.time_path(atoms, penetrations=path, window="auto", tolerance=2e-3):
        if step.time >= DWELL:
            steps.append(step)
            if not step.repulsive_atoms + step.attractive_atoms:
                break
    time, force, depth, dissipated = (
        np.array([getattr(step, name) for step in steps])
        for name in ("time", "normal_force", "penetration", "dissipated_energy")
    )
    at = int(force.argmin())
    near = range(max(at - 4, 0), min(at + 5, len(steps) - 1))
    radii = [jkr_radius(force[i], depth[i]) for i in near]
    speed = -np.polyfit(time[list(near)], radii, 1)[0]
    radius = jkr_radius(force[at], depth[at])
    work = RELAXED / (2.0 * np.pi * radius) * (radius**2 / RADIUS - depth[at]) ** 2
    return speed, -force[at], work, dissipated[1:].sum()


def jkr_radius(force, depth):
    """Return the radius ``a`` with ``N = 2 E a (D - a^2/3R)``, which JKR theory has."""
    cubic = [2.0 * RELAXED / (3.0 * RADIUS), 0.0, -2.0 * RELAXED * depth, force]
    roots = np.roots(cubic)
    return float(roots[abs(roots.imag) < 1e-9].real.max())


def crack_work(speed):
    """Return the work of adhesion of a long crack at a speed, relative to w."""
    if not speed > 0.0:
        return math.nan
    # radius of a slow tip
    blunt = RELAXED * WORK / (2.0 * np.pi * largest_tension() ** 2)

    def excess(log):
        ratio = math.exp(log)
        highest = 2.0 * math.pi * speed / (ratio * blunt)

        def loss(log_frequency):
            frequency = math.exp(log_frequency)
            part = math.sqrt(max(1.0 - (frequency / highest) ** 2, 0.0))
            return part * -(1.0 / CREEP.modulus(frequency)).imag

        lost = quad(loss, math.log(highest) - 25.0, math.log(highest), limit=200)[0]
        return 1.0 / ratio - 1.0 + 2.0 / math.pi * RELAXED / MODULUS * lost

    return math.exp(brentq(excess, 0.0, math.log(1.001 * MODULUS / RELAXED)))


def zone_work(speed):
    """Return the work of adhesion of an opening crack with a cohesive zone, over w.

    Along the zone of length c, behind the front that moves at the speed v, the surfaces
    are pulled together by the largest tension of the wall. Its opening on an elastic
    solid is f(s) at the distance s c from the front, with
    f'(s) = ln((1 + sqrt(s))/(1 - sqrt(s)))/2 (Dugdale). Each point passes the zone in
    the time c/v, so that the opening at its end, w over the tension, is smaller by the
    mean of J((1 - s) c/v) over f. c is proportional to the work of adhesion.
    """
    if not speed > 0.0:
        return math.nan
    length = math.pi * RELAXED * WORK / (4.0 * largest_tension() ** 2)  # at rest

    def excess(log):
        ratio = math.exp(log)

        def opening(root):  # with s = root^2
            time = (1.0 - root**2) * ratio * length / speed
            compliance = RELAXED / MODULUS * float(CREEP.compliance(time))
            return compliance * math.atanh(root) * 2.0 * root

        return ratio * quad(opening, 0.0, 1.0)[0] - 1.0

    return math.exp(brentq(excess, -1e-3, math.log(1.001 * MODULUS / RELAXED)))


def largest_tension():
    """Return the largest tension of the wall."""
    return -WALL.evaluate(np.linspace(A0, 3.0 * A0, 10_000))[1].min()


def stored_rows():
    """Return the rows of the file, as dictionaries of texts."""
    if not FILE.exists():
        return []
    with FILE.open(newline="") as file:
        return list(csv.DictReader(file))


def calculate():
    """Append the rows that the file lacks."""
    warnings.simplefilter("ignore", rc.ValidityWarning)
    rows = stored_rows()
    done = {(row["sphere"], float(row["rate"])) for row in rows}
    with FILE.open("a", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        if not rows:
            writer.writerow(COLUMNS)
        for sphere, roughness in (("smooth", None), ("rough", ROUGH)):
            for rate in RATES:
                if (sphere, rate) not in done:
                    found = retraction(rate, roughness)
                    writer.writerow([sphere, rate, *(f"{x:.6g}" for x in found)])
                    file.flush()


def report():
    """Print the table of the stored rows."""
    heads = "sphere", "rate (Å/s)", "pull-off/(3 pi w R/2)", "dissipated (eV)"
    heads += "speed of the edge (Å/s)", "w of JKR/w", "Persson, Brener", "cohesive zone"
    print(f"| {' | '.join(heads)} |")
    print("|---|---|---|---|---|---|---|---|")
    for row in stored_rows():
        rate, speed, pull_off, work, lost = (float(row[name]) for name in COLUMNS[1:])
        values = [f"{rate:g}", f"{pull_off / (1.5 * np.pi * WORK * RADIUS):.2f}"]
        values += [f"{lost:.3g}", f"{speed:.2g}", f"{work / WORK:.2f}"]
        values += [f"{crack_work(speed):.2f}", f"{zone_work(speed):.2f}"]
        print(f"| {row['sphere']} | {' | '.join(values)} |")


if __name__ == "__main__":
    report() if "--report" in sys.argv else calculate()
