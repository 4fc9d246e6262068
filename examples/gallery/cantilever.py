"""An AFM tip on its cantilever: snap-in, pull-off, and the same force as a load.

    python examples/gallery/cantilever.py --steps 80

lowers the end of a soft spring with a smooth adhesive tip, and raises it again. Lengths
are in spacings a0, forces in E* a0^2.
"""

import argparse

import numpy as np
from ase.constraints import Hookean
from matplotlib.figure import Figure

from ase_roughcontact import NewtonKrylov, RoughContact, RoughSphere, substrate
from ase_roughcontact.interactions import LennardJones93
from ase_roughcontact.plot import style
from ase_roughcontact.theory import maugis_dugdale_pull_off_force, maugis_parameter

RADIUS, WORK, SIZE = 50.0, 0.02, 30


def main(arguments: list[str] | None = None) -> float:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--steps", type=int, default=80, help="on the way down")
    parser.add_argument("--picture", default="cantilever.png")
    options = parser.parse_args(arguments)
    tip, wall = RoughSphere(RADIUS), LennardJones93.adhesive(1.0, 1.0, WORK)
    atoms = substrate("Cu", (SIZE, SIZE), tip, spacing=1.0, height=3.0, fixed=False)
    atoms.calc = RoughContact(tip, 1.0, wall)
    n, unit, heights, forces = options.steps, np.pi * WORK * RADIUS, [], []
    end = np.append(np.linspace(3.0, -1.0, n), np.linspace(-1.0, 6.0, 2 * n))
    for z in end:
        point = (*atoms.positions[-1, :2], z)
        atoms.set_constraint(Hookean(len(atoms) - 1, point, k=0.5 * unit, rt=0.0))
        NewtonKrylov(atoms, logfile=None).run(fmax=1e-6)
        heights.append(atoms.positions[-1, 2])
        forces.append(atoms.calc.state(atoms).normal_force)
    atoms.set_constraint()  # and now the largest force as a load
    atoms.calc.set(load=max(forces))
    atoms.positions[-1, 2] = 1.0
    NewtonKrylov(atoms, logfile=None).run(fmax=1e-6)
    print(f"load for spring: {abs(atoms.positions[-1, 2] - min(heights)):.0e} a0 apart")
    parameter = maugis_parameter(RADIUS, 1.0, WORK, WORK / wall.attraction_range)
    theory = maugis_dugdale_pull_off_force(float(parameter)) * unit
    error = float(min(forces) / theory - 1)
    with style():
        axes = Figure().subplots()
        axes.plot(end[:n], forces[:n], "o-", ms=2, label="approach")
        axes.plot(end[n:], forces[n:], "-", label="retraction")
        axes.axhline(theory, color="k", ls="--", label="Maugis-Dugdale")
        axes.set(xlabel="end of the cantilever / $a_0$", ylabel="force / $E^* a_0^2$")
        axes.legend().figure.savefig(options.picture, dpi=200)
    print(f"pull-off force {-min(forces):.3f} E* a0^2, off by {100 * error:.1f} %")
    return error


if __name__ == "__main__":
    main()
