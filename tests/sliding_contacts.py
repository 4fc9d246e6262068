"""Contacts with friction, and paths of them that are interrupted."""

import pytest

from ase_roughcontact import (
    Coulomb,
    HardWall,
    Output,
    Problem,
    RoughContact,
    RoughSphere,
    StepOptions,
    Stepper,
    sliding_path,
    substrate,
)
from ase_roughcontact.elasticity import Isotropic
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.path_kinds.sliding.specification import SlidingSpecification
from ase_roughcontact.path_kinds.sliding.steps import SlidingSteps
from ase_roughcontact.paths import follow as paths

MU = 0.3


def stepper_of(
    n,
    solid=None,
    wall=None,
    control="penetrations",
    indenter=None,
    periodic=False,
    offset=0.5,
    **options,
):
    """Stepper on a window of n x n atoms, by default under a smooth sphere."""
    indenter, solid = indenter or RoughSphere(10.0 * n), solid or Isotropic(1.0, 0.0)
    wall, offset = wall or HardWall(), (offset, offset)
    problem = Problem(indenter, solid, wall, 1.0, periodic, offset)
    options = StepOptions(**{"window": "unchecked"} | options)
    return Stepper(problem, control, Box((-(n // 2), -(n // 2)), (n, n)), options)


def followed(stepper, *args, **options):
    """Steps of a sliding path with their states."""
    return list(
        paths.follow_states(
            SlidingSteps(stepper, SlidingSpecification(*args, **options))
        )
    )


def follow(stepper, *args, **options):
    return [step for step, _ in followed(stepper, *args, **options)]


def atoms_on(solid):
    sphere = RoughSphere(radius=200.0)
    atoms = substrate("Cu", (32, 32), sphere, spacing=2.5)
    atoms.calc = RoughContact(sphere, solid=solid, wall=HardWall())
    return atoms


def assert_resumed(folder, solid, depths, keep, names, **lateral):
    """Compare a path that is stopped after three steps and resumed with a whole one."""

    def steps(**options):
        return sliding_path(
            atoms_on(solid), Coulomb(MU), penetrations=depths, **lateral, **options
        )

    files = {"trajectory": folder / "p.traj", "csv": folder / "p.csv", "keep": keep}
    stopped = steps(output=Output(**files))
    for _ in range(3):
        next(stopped)
    stopped.close()
    rest = list(steps(output=Output(**files, resume=True)))
    for step, expected in zip(rest[3 - len(depths) :], list(steps())[3:], strict=True):
        for name in names:
            found = getattr(step, name)
            assert found == pytest.approx(getattr(expected, name), rel=1e-4), name
