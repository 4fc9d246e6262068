"""Largest tensions that lie between the states of a loop, for all attractive walls.

In units of the contact modulus and the spacing.
"""

from pathlib import Path

import pytest
from built import atoms_under

from ase_roughcontact import RoughSphere, adhesion_loop
from ase_roughcontact.interactions import ExponentialWall, PowerLawWall
from ase_roughcontact.path_kinds.loop.instabilities import interpolated
from ase_roughcontact.path_kinds.loop.specification import default_step


def pull_off(sphere, wall, deepest, finer=1.0, tolerance=1e-3):
    loop = loop_of(sphere, wall, deepest, finer, tolerance)
    return loop.pull_off_force, len(loop.approach) + len(loop.retraction)


def loop_of(sphere, wall, deepest, finer=1.0, tolerance=1e-3):
    atoms = atoms_under(sphere, wall, (12, 12))
    step = default_step(wall, deepest) / finer
    return adhesion_loop(
        atoms, deepest=deepest, step=step, tolerance=tolerance, window="auto"
    )


@pytest.mark.filterwarnings("ignore:the pull-off force")
def test_a_kink_of_the_force_between_two_states_is_found():
    # the last atom of a rigid tip leaves a hard wall
    sphere = RoughSphere(7.6)
    wall = PowerLawWall(0.024, 0.49, exponent=1.5, relative_cutoff=9.0)
    coarse, states = pull_off(sphere, wall, 0.07)
    fine, others = pull_off(sphere, wall, 0.07, tolerance=1e-4)
    assert coarse == pytest.approx(fine, rel=1e-3)
    assert states < 0.7 * others


@pytest.mark.slow  # a minute: windows of 432 x 432 atoms
def test_a_maximum_far_below_the_largest_step_is_found():
    # a tip of 30 nm, E* of 100 GPa, 50 mJ/m2, in units of 0.25 nm
    wall = PowerLawWall(0.002, 0.6, exponent=2.0, relative_cutoff=60.0)
    coarse, _ = pull_off(RoughSphere(120.0), wall, 1.2)
    fine, _ = pull_off(RoughSphere(120.0), wall, 1.2, tolerance=1e-4)
    assert coarse == pytest.approx(fine, rel=1.5e-3)


@pytest.mark.filterwarnings("ignore:the pull-off force")
@pytest.mark.parametrize(
    "radius, wall",
    [
        (8.35, ExponentialWall(0.0243, 0.492, relative_cutoff=10.4)),
        (6.0, ExponentialWall(0.0108, 0.329, relative_cutoff=39.2)),
    ],
)
def test_kinks_where_atoms_come_into_contact_are_largest_tensions(radius, wall):
    # four atoms around the tip come into contact with a hard wall, and leave it
    coarse, fine = (
        loop_of(RoughSphere(radius), wall, 0.159, **options)
        for options in ({}, {"finer": 4.0, "tolerance": 2e-4})
    )
    for branch in "approach", "retraction":
        least, expected = (
            interpolated(getattr(loop, branch), getattr(loop, f"{branch}_jumps"))[1]
            for loop in (coarse, fine)
        )
        assert least.min() == pytest.approx(expected.min(), rel=1e-3)


@pytest.mark.slow  # a minute
@pytest.mark.parametrize("seed", range(3))
def test_steps_ten_times_finer_give_the_same_largest_tensions(seed, monkeypatch):
    monkeypatch.syspath_prepend(Path(__file__).parents[3] / "examples" / "benchmarks")
    import loop_steps

    for kind in loop_steps.WALLS:  # 40 seeds in loop_steps.csv
        setting = loop_steps.random_setting(kind, seed)
        coarse = loop_steps.values_of(loop_steps.loop_of(*setting))
        fine = loop_steps.values_of(loop_steps.loop_of(*setting, 10.0, 1e-4))
        assert coarse[:2] == pytest.approx(fine[:2], rel=2e-3), (kind, seed)
