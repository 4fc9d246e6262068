"""Largest tensions that lie between the states of a loop, for all attractive walls.

In units of the contact modulus and the spacing.
"""

import numpy as np
import pytest

from ase_roughcontact import (
    LennardJones93,
    RoughContact,
    RoughSphere,
    SelfAffine,
    adhesion_loop,
    substrate,
)
from ase_roughcontact.interactions import DugdaleWall, ExponentialWall, PowerLawWall
from ase_roughcontact.paths.hysteresis import default_step

WALLS = ("adhesive", "full", "dugdale", "exponential", "power-law")


def pull_off(sphere, wall, deepest, finer=1.0, tolerance=1e-3):
    atoms = substrate("Cu", (12, 12), sphere, spacing=1.0)
    atoms.calc = RoughContact(sphere, contact_modulus=1.0, interaction=wall)
    step = default_step(wall, deepest) / finer
    loop = adhesion_loop(atoms, deepest, step, tolerance=tolerance, window="auto")
    return loop.pull_off_force, len(loop.approach) + len(loop.retraction)


def random_setting(kind, seed):
    """Sphere, wall and deepest penetration, Tabor numbers from 0.1 to 2.5."""
    rng = np.random.default_rng(seed)
    reach, exponent = 10 ** rng.uniform(-0.7, 0.5), rng.choice([1.5, 2.0, 3.0, 5.0])
    ends = {"full": (0.3, 1.1), "exponential": (0.7, 1.7), "power-law": (0.7, 1.7)}
    cutoff = 10 ** rng.uniform(*ends.get(kind, (0.08, 0.08)))
    radius = max(10 ** rng.uniform(1.2, 1.8) / (cutoff * reach + 0.5), 6.0)
    tabor = 10 ** rng.uniform(-1.0, 0.4)
    work = np.sqrt(tabor**3 * reach**3 / radius)
    work = min(work, reach**2 / (20 if kind == "full" else 10))  # else many jumps
    depth = max(np.cbrt(work**2 * radius), 0.2 * reach)
    walls = {
        "adhesive": lambda: LennardJones93.adhesive(
            1.0, 1.0, work, stiffness=12 * work / reach**2
        ),
        "full": lambda: LennardJones93.full(reach, work, cutoff=cutoff * reach),
        "dugdale": lambda: DugdaleWall(work, reach),
        "exponential": lambda: ExponentialWall(work, reach, cutoff),
        "power-law": lambda: PowerLawWall(work, reach, exponent, cutoff),
    }
    rough = SelfAffine(reach * rng.uniform(0.03, 0.3), 0.8, 4.0, 16.0, seed=seed)
    sphere = RoughSphere(radius, rough if rng.random() < 0.3 else None)
    return sphere, walls[kind](), rng.uniform(0.3, 2.0) * depth


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


@pytest.mark.slow  # half a minute to some minutes for each wall
@pytest.mark.parametrize("kind", WALLS)
def test_steps_ten_times_finer_give_the_same_pull_off_force(kind):
    for seed in range(40):
        setting = random_setting(kind, seed)
        coarse, _ = pull_off(*setting)
        fine, _ = pull_off(*setting, finer=10.0, tolerance=1e-4)
        assert coarse == pytest.approx(fine, rel=1.5e-3), (kind, seed)
