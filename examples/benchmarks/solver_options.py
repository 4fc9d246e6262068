"""Cost of each option of the solvers: FFT pairs with other values than the default.

    python solver_options.py                   # all, a few minutes
    python solver_options.py --size 128        # smaller windows
    python solver_options.py --solver hard     # the solver for the hard wall alone

prints a table in Markdown: one line for each value of an option, one column for each
contact, and the number of FFT pairs (normalised to one pair on the full padded grid).
It is left out where it is that of the defaults, and a dash stands for a solver that
does not converge. Pairs do not depend on the machine.
"""

import argparse
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from itertools import islice
from typing import Any

import numpy as np

from ase_roughcontact import HardWall, LennardJones93, RoughSphere, SelfAffine
from ase_roughcontact.contact import Contact
from ase_roughcontact.elasticity.greens import Isotropic
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace, PeriodicHalfSpace
from ase_roughcontact.interactions import Interaction
from ase_roughcontact.solvers.hard.active_set import active_set
from ase_roughcontact.solvers.options import ActiveSetOptions, NewtonKrylovOptions
from ase_roughcontact.solvers.soft.newton import newton_krylov

# Other values of the options than the default.
NEWTON = {
    "coarsest": (16, 64, 10_000),
    "max_load_change": (0.05, 1.0),
    "forcing": (0.01, 0.3, 0.5),
    "history": (0, 3, 12),
}
ACTIVE_SET = {
    "coarsest": (32, 128, 10_000),
    "contraction": (0.03, 0.1, 0.3),
    "slow_contraction": (0.0, 0.3, 1.0),
}
TOLERANCE = 1e-6  # E* a0^2, about 2e-5 of the mean force on an atom in contact
MOST_STEPS = 2000


def sphere_contact(size: int, wall: Interaction) -> tuple[Contact, float]:
    """Return a rough sphere above a free half space, and its load."""
    rough = SelfAffine(0.1, 0.8, 4.0, min(512.0, size), seed=1)
    sphere = RoughSphere(10.0 * size, rough)
    heights = sphere.heights((size, size), 1.0, (-(size // 2),) * 2)
    halfspace = FreeHalfSpace((size, size), 1.0, Isotropic(1.0))
    return Contact(halfspace, heights, wall), 4.0 * (0.3 * size) ** 3 / (30.0 * size)


def flat_contact(size: int, wall: Interaction) -> tuple[Contact, float]:
    """Return a rough flat above a periodic half space, and its load."""
    rough = SelfAffine(0.1, 0.8, 4.0, min(512.0, size), seed=1, domain=float(size))
    heights = rough.heights((size, size), 1.0)
    halfspace = PeriodicHalfSpace((size, size), 1.0, Isotropic(1.0))
    return Contact(halfspace, heights, wall), 4e-3 * size**2


def cold_start(solver: Callable, contact: Contact, load: float, options: Any) -> float:
    """Return the FFT pairs of a solution without a start, NaN if there is none."""
    return pairs_of(solver, contact, load, contact.first_contact, None, options)


def warm_start(
    part: float, solver: Callable, contact: Contact, load: float, options: Any
) -> float:
    """Return the same from the solution at a part of the load."""
    before = list(
        solver(
            contact,
            height=contact.first_contact,
            external=partial(external, part * load),
            start=None,
            tolerance=TOLERANCE,
        )
    )[-1]
    return pairs_of(solver, contact, load, before.height, before.pressure, options)


def external(load: float, height: float) -> tuple[float, float]:
    """Return energy and force of a load."""
    return load * height, -load


def pairs_of(
    solver: Callable,
    contact: Contact,
    load: float,
    height: float,
    start: np.ndarray | None,
    options: Any,
) -> float:
    """Return the FFT pairs of a solution, NaN if the solver does not converge."""
    states = solver(
        contact,
        height=height,
        external=partial(external, load),
        start=start,
        tolerance=TOLERANCE,
        options=options,
    )
    pairs = 0.0
    for state in islice(states, MOST_STEPS):
        pairs += state.pairs
    return pairs if state.converged else np.nan


def table(
    size: int, solver: Callable, default: Any, values: dict[str, tuple]
) -> Iterator[str]:
    """Yield the lines of the table of one solver."""
    hard = solver is active_set
    wall = HardWall() if hard else LennardJones93.repulsive(1.0, 1.0)
    sphere, flat = sphere_contact(size, wall), flat_contact(size, wall)
    cases = {
        "sphere": partial(cold_start, solver, *sphere),
        "flat": partial(cold_start, solver, *flat),
        "from 97 %": partial(warm_start, 0.97, solver, *sphere),
        "from 80 %": partial(warm_start, 0.8, solver, *sphere),
    }
    if not hard:
        for work in (0.005, 0.05):
            sticky = sphere_contact(size, LennardJones93.adhesive(1.0, 1.0, work))
            cases[f"w = {work:g}"] = partial(cold_start, solver, *sticky)
    yield f"| option | value | {' | '.join(cases)} |"
    yield f"|{'---|' * (2 + len(cases))}"

    def cells(options: Any) -> list[str]:
        pairs = [case(options) for case in cases.values()]
        return [f"{count:.1f}" if np.isfinite(count) else "-" for count in pairs]

    usual = cells(default)
    yield f"| all default | | {' | '.join(usual)} |"
    for name, others in values.items():
        option = f"`{name}` ({getattr(default, name):g})"
        for value in others:
            row = cells(replace(default, **{name: value}))
            new = [
                "" if one == other else one
                for one, other in zip(row, usual, strict=True)
            ]
            yield f"| {option} | {value:g} | {' | '.join(new)} |"
            option = ""


def main(arguments: list[str] | None = None) -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--size", type=int, default=256, help="atoms along a side")
    parser.add_argument("--solver", choices=("hard", "soft"))
    options = parser.parse_args(arguments)
    solvers = {
        "hard": (active_set, ActiveSetOptions(), ACTIVE_SET),
        "soft": (newton_krylov, NewtonKrylovOptions(), NEWTON),
    }
    for name, solver in solvers.items():
        if options.solver in (None, name):
            for line in table(options.size, *solver):
                print(line, flush=True)
            print()


if __name__ == "__main__":
    main()
