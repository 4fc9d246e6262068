"""First contact in ten lines: a smooth sphere, against Hertz.

    python examples/gallery/first_contact.py --size 64

presses a sphere into copper and draws the pressure beside that of Hertz.
"""

import argparse

from ase.units import GPa
from matplotlib.figure import Figure

from ase_roughcontact import ActiveSet, HardWall, RoughContact, RoughSphere, substrate
from ase_roughcontact.analysis.contact_map import ContactMap
from ase_roughcontact.plot import plot_pressure, style
from ase_roughcontact.theory import hertz_contact_radius_from_penetration, hertz_force


def main(arguments: list[str] | None = None) -> float:
    """Return the relative error of the force."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--size", type=int, default=64, help="atoms along a side")
    parser.add_argument("--picture", default="first_contact.png")
    options = parser.parse_args(arguments)
    radius, modulus, depth = 25.0 * options.size, 145 * GPa, options.size / 20

    sphere = RoughSphere(radius)
    atoms = substrate("Cu", (options.size, options.size), sphere, height=-depth)
    atoms.calc = RoughContact(sphere, modulus, HardWall())
    if not ActiveSet(atoms).run(fmax=1e-6):
        raise RuntimeError("the contact did not converge")
    force = atoms.calc.state(atoms).normal_force
    error = force / hertz_force(depth, radius, modulus) - 1
    print(f"force {force:.4f} eV/Å, off Hertz's by {100 * error:.2f} %")

    with style():
        axes = Figure().subplots()
        contact_radius = hertz_contact_radius_from_penetration(depth, radius)
        plot_pressure(axes, ContactMap.from_atoms(atoms), float(contact_radius))
        axes.figure.savefig(options.picture, dpi=200)
    return float(error)


if __name__ == "__main__":
    main()
