"""Hertz by five optimizers: one contact, one force, different roads to it.

    python examples/gallery/hertz_optimizers.py --size 32

relaxes a smooth sphere on a stiff wall with FIRE and LBFGS on the atoms, with FIRE2 and
LBFGS on the scaled modes of the half space, and with NewtonKrylov.
"""

import argparse
from functools import partial

from ase.optimize import FIRE, FIRE2, LBFGS
from matplotlib.figure import Figure

from ase_roughcontact import RoughContact, RoughSphere, substrate
from ase_roughcontact.interactions import LennardJones93
from ase_roughcontact.optimize import FourierModes, NewtonKrylov
from ase_roughcontact.plot import plot_convergence, style
from ase_roughcontact.theory import hertz_force


def main(arguments: list[str] | None = None) -> dict[str, float]:
    """Return the relative errors of the force by optimizer."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--size", type=int, default=32, help="atoms along a side")
    parser.add_argument("--picture", default="hertz_optimizers.png")
    options = parser.parse_args(arguments)
    size, depth = options.size, options.size / 32  # lengths in a0, forces in E* a0^2
    optimizers = {
        "FIRE": partial(FIRE, maxstep=0.2 * size),
        "LBFGS": LBFGS,
        "FIRE2, modes": lambda atoms, **kw: FIRE2(
            modes := FourierModes(atoms), maxstep=modes.maxstep, **kw
        ),
        "LBFGS, modes": lambda atoms, **kw: LBFGS(FourierModes(atoms), alpha=1.0, **kw),
        "NewtonKrylov": NewtonKrylov,
    }
    sphere, curves, errors = RoughSphere(5.0 * size), {}, {}
    wall = LennardJones93.repulsive(1.0, 1.0, stiffness=10.0)
    for name, optimizer in optimizers.items():
        atoms = substrate("Cu", (size, size), sphere, spacing=1.0, height=1.0 - depth)
        atoms.calc = RoughContact(sphere, 1.0, wall)
        dynamics, left = optimizer(atoms, logfile=None), []
        for _ in dynamics.irun(fmax=1e-5, steps=5000):
            gradient = dynamics.optimizable.get_gradient()
            left.append(dynamics.optimizable.gradient_norm(gradient))
        next(dynamics.optimizable.iterimages())  # the atoms follow
        force = atoms.calc.state(atoms).normal_force
        errors[name] = float(force / hertz_force(depth, sphere.radius, 1.0)) - 1
        curves[name] = range(1, len(left) + 1), left
        print(f"{name:13s}{len(left) - 1:5d} steps, off by {100 * errors[name]:.4f} %")
    with style():
        axes = Figure().subplots()
        plot_convergence(axes, curves, ylabel="largest force / $E^* a_0^2$").loglog()
        axes.figure.savefig(options.picture, dpi=200)
    return errors


if __name__ == "__main__":
    main()
