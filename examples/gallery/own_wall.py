"""A wall potential of your own, in twenty lines: the electric double layer.

    python examples/gallery/own_wall.py --stiffness 1e-3

V(g) = p0 rho exp(-g/rho). Where the solid hardly deforms the force on a sphere is
Derjaguin's, 2 pi R V. Lengths are in units of rho, pressures in E*.
"""

import argparse

import numpy as np
from matplotlib.figure import Figure

from ase_roughcontact import RoughContact, RoughSphere, load_path, substrate
from ase_roughcontact.interactions import Interaction
from ase_roughcontact.plot import style


class DoubleLayer(Interaction):
    """Pressure p0 exp(-g/rho), up to a gap of 12 rho."""

    work_of_adhesion = attraction_range = 0.0

    def __init__(self, pressure: float, decay: float) -> None:
        self.pressure, self.decay = pressure, decay
        self.cutoff = self.contact_distance = 12 * decay

    def evaluate(self, gap: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return energy, pressure and stiffness of gaps; several threads may ask."""
        end = self.pressure * np.exp(-self.cutoff / self.decay)
        p = self.pressure * np.exp(-np.minimum(gap, self.cutoff) / self.decay)
        inside = gap < self.cutoff
        return (p - end) * self.decay, p * inside, p / self.decay * inside


def main(arguments: list[str] | None = None) -> float:
    """Return the relative error of the force at the largest height."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--stiffness", type=float, default=0.01, help="p0/E*")
    parser.add_argument("--picture", default="own_wall.png")
    options = parser.parse_args(arguments)
    sphere, wall = RoughSphere(50.0), DoubleLayer(options.stiffness, 1.0)
    atoms = substrate("Cu", (84, 84), sphere, spacing=1.0, height=12.0)
    atoms.calc, heights = RoughContact(sphere, 1.0, wall), np.linspace(7.0, -3.0, 21)
    path = load_path(atoms, heights=heights)
    forces = np.array([step.normal_force for step in path])
    derjaguin = 2 * np.pi * sphere.radius * wall.evaluate(heights)[0]
    error = float(forces[0] / derjaguin[0] - 1)
    with style():
        axes = Figure().subplots()
        axes.semilogy(heights, forces, "o", label="simulation")
        axes.semilogy(heights, derjaguin, "k-", label="Derjaguin, rigid")
        axes.set(xlabel=r"height / $\rho$", ylabel=r"force / $E^* \rho^2$")
        axes.legend().figure.savefig(options.picture, dpi=200)
    print(f"force at {heights[0]:g} rho off Derjaguin's by {100 * error:.2f} %")
    return error


if __name__ == "__main__":
    main()
