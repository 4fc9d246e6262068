"""Pull-off of smooth spheres from DMT to JKR, and the energy that a loop costs.

    python examples/gallery/adhesion_loop.py --radius 100 --work 0.02

brings a smooth sphere into contact and pulls it off. Units: spacing a0, pressure E*.
"""

import argparse

import numpy as np
from matplotlib.figure import Figure

from ase_roughcontact import LennardJones93, RoughContact, RoughSphere, substrate
from ase_roughcontact.paths.hysteresis import AdhesionLoop, adhesion_loop
from ase_roughcontact.plot import style
from ase_roughcontact.theory import maugis_dugdale_pull_off_force, maugis_parameter


def loop_of(radius: float, work: float, stiffness: float) -> AdhesionLoop:
    sphere = RoughSphere(radius=radius)
    wall = LennardJones93.adhesive(1.0, 1.0, work, stiffness=stiffness)
    atoms = substrate("Cu", (16, 16), sphere, spacing=1.0)
    atoms.calc = RoughContact(sphere, contact_modulus=1.0, interaction=wall)
    depth = np.cbrt(work**2 * radius)  # of JKR's contact
    deepest = 3 * depth + wall.attraction_range / 2
    return adhesion_loop(atoms, deepest, depth / 2, window="auto")


def main(arguments: list[str] | None = None) -> list[AdhesionLoop]:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--radius", type=float, default=100.0)
    parser.add_argument("--work", type=float, default=0.02)
    parser.add_argument("--stiffness", type=float, nargs="+", default=[0.01, 0.1, 1.0])
    parser.add_argument("--picture", default="adhesion_loop.png")
    options = parser.parse_args(arguments)
    radius, work = options.radius, options.work
    unit, cost = np.pi * work * radius, np.cbrt(work**5 * radius**4)
    loops = [loop_of(radius, work, stiffness) for stiffness in options.stiffness]
    with style():
        axes = Figure().subplots()
        print("stiffness  parameter  pull-off/(pi w R)  Maugis-Dugdale  energy")
        for stiffness, loop in zip(options.stiffness, loops, strict=True):
            stress = np.sqrt(work * stiffness / 12)  # Dugdale's, of the same range
            parameter = float(maugis_parameter(radius, 1.0, work, stress))
            theory = maugis_dugdale_pull_off_force(parameter)
            force, lost = loop.pull_off_force / unit, loop.dissipated_energy / cost
            row = stiffness, parameter, force, -theory, lost
            print("{:9g}  {:9.3f}  {:17.4f}  {:14.4f}  {:6.3f}".format(*row))
            way = (*loop.approach, *loop.retraction)
            points = np.array([(step.height, step.normal_force / unit) for step in way])
            axes.plot(*points.T, label=f"parameter {parameter:.2f}")
        axes.axhline(-1.5, color="k", ls="--", label="JKR")
        axes.axhline(-2.0, color="k", ls=":", label="DMT")
        axes.set(xlabel="height / $a_0$", ylabel=r"force / $\pi w R$", ylim=(-2.2, 2))
        axes.legend().figure.savefig(options.picture, dpi=200)
    return loops


if __name__ == "__main__":
    main()
