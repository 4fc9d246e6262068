"""Pull-off of smooth spheres from DMT to JKR, and the energy that a loop costs.

    python examples/adhesion_loop.py --radius 100 --work 0.02 --stiffness 0.01 0.1 1

brings a smooth sphere into contact and pulls it off again, for walls of some stiffness.
Lengths are in spacings a0, pressures in E*, works of adhesion in E* a0.
"""

import argparse

import numpy as np

from ase_roughcontact import LennardJones93, RoughContact, RoughSphere, substrate
from ase_roughcontact.hysteresis import AdhesionLoop, adhesion_loop
from ase_roughcontact.theory import maugis_dugdale_pull_off_force, maugis_parameter


def loop_of(radius: float, work: float, stiffness: float) -> AdhesionLoop:
    """Loop of a sphere on a wall, in units of E* and a0."""
    sphere = RoughSphere(radius=radius)
    wall = LennardJones93.adhesive(1.0, 1.0, work, stiffness=stiffness)
    atoms = substrate("Cu", (16, 16), sphere, spacing=1.0)
    atoms.calc = RoughContact(sphere, contact_modulus=1.0, interaction=wall)
    depth = np.cbrt(work**2 * radius)  # of JKR's contact
    deepest = 3 * depth + wall.attraction_range / 2
    return adhesion_loop(atoms, deepest, depth / 2, window="auto")


def main(arguments: list[str] | None = None) -> list[AdhesionLoop]:
    """Print a line for every stiffness."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--radius", type=float, default=100.0)
    parser.add_argument("--work", type=float, default=0.02)
    parser.add_argument("--stiffness", type=float, nargs="+", default=[0.01, 0.1, 1.0])
    options = parser.parse_args(arguments)
    radius, work = options.radius, options.work
    unit = np.pi * work * radius
    loops = [loop_of(radius, work, stiffness) for stiffness in options.stiffness]
    print("pull-off/(pi w R): DMT 2, JKR 1.5; energy in w^(5/3) R^(4/3) E*^(-2/3)")
    print("stiffness  parameter  pull-off  Maugis-Dugdale  jump-in jump-out  energy")
    for stiffness, loop in zip(options.stiffness, loops, strict=True):
        # the Dugdale wall of the same work and the same range
        stress = np.sqrt(work * stiffness / 12)
        parameter = float(maugis_parameter(radius, 1.0, work, stress))
        pull_off, theory = loop.pull_off_force, maugis_dugdale_pull_off_force(parameter)
        jumps = [
            "none" if z is None else f"{z:.3f}" for z in (loop.jump_in, loop.jump_out)
        ]
        energy = loop.dissipated_energy / (work**5 * radius**4) ** (1 / 3)
        print(
            f"{stiffness:9g}  {parameter:9.3f}  {pull_off / unit:8.4f}  {-theory:14.4f}"
            f"  {jumps[0]:>7} {jumps[1]:>8}  {energy:6.3f}"
        )
    return loops


if __name__ == "__main__":
    main()
