"""An accuracy is what it says: relative errors of force and area, at most.

The spheres, loads and seeds here are others than those from which the levels were set.
"""

from functools import cache

import numpy as np
import pytest

from ase_roughcontact import (
    HardWall,
    LennardJones93,
    RoughContact,
    RoughSphere,
    SelfAffine,
    load_path,
    substrate,
)
from ase_roughcontact.paths.accuracy import LEVELS, accuracy_of
from ase_roughcontact.scene import Scene

# In units of the contact modulus and of the spacing.
WALLS = {
    "hard": HardWall(),
    "repulsive": LennardJones93.repulsive(1.0, 1.0),
    "adhesive": LennardJones93.adhesive(1.0, 1.0, 0.01),
    "full": LennardJones93.full(1.0, 0.03, cutoff=5.0),
}
SEEDS = (101, 102)
PATHS = {
    "far steps": {"penetrations": (0.3, 1.0, 2.0)},
    "small steps": {"penetrations": tuple(np.linspace(0.8, 1.0, 6))},
    "loads": {"loads": (0.05, 1.0, 10.0)},
}
# far below the levels that are judged by it
REFERENCE = 1e-10


@cache
def states(wall, path, seed, accuracy):
    """Records of a path, and the push on the atoms in contact at each of its steps."""
    rough = SelfAffine(0.1, 0.8, 4.0, 48.0, seed=seed, domain=256.0)
    sphere = RoughSphere(150.0, rough)
    fixed = "loads" not in PATHS[path]
    atoms = substrate("Cu", (8, 8), sphere, spacing=1.0, fixed=fixed)
    atoms.calc = RoughContact(sphere, 1.0, WALLS[wall])
    found = []
    for record in load_path(atoms, accuracy=accuracy, window="auto", **PATHS[path]):
        state = atoms.calc.state(atoms)
        found.append((record, float(state.pressure[state.contact].sum())))
    return found


def compared(wall, path, seed, accuracy):
    """Record, reference and push of every step."""
    reference = states(wall, path, seed, REFERENCE)
    for (record, _), (truth, push) in zip(
        states(wall, path, seed, accuracy), reference, strict=True
    ):
        assert record.converged and truth.converged
        yield record, truth, push


each = pytest.mark.parametrize("seed", SEEDS)
along = pytest.mark.parametrize("path", PATHS)
against = pytest.mark.parametrize("wall", WALLS)
of_level = pytest.mark.parametrize("level", ["fast", "normal"])


@of_level
@each
@along
@against
def test_the_force_is_as_accurate_as_promised(wall, path, seed, level):
    promised = accuracy_of(level).error
    for record, truth, push in compared(wall, path, seed, level):
        assert abs(record.normal_force - truth.normal_force) <= promised * push


@of_level
@each
@along
@against
def test_the_area_is_as_accurate_as_promised_but_for_one_atom(wall, path, seed, level):
    promised = accuracy_of(level).error
    for record, truth, _ in compared(wall, path, seed, level):
        amiss = abs(record.repulsive_atoms - truth.repulsive_atoms)
        assert amiss <= 1 + promised * truth.repulsive_atoms


@each
@against
def test_high_accuracy_agrees_with_an_even_higher_one(wall, seed):
    for record, truth, push in compared(wall, "far steps", seed, "high"):
        error = abs(record.normal_force - truth.normal_force)
        assert error <= LEVELS["high"].error * push
        assert record.repulsive_atoms == truth.repulsive_atoms


@pytest.mark.parametrize("pair", [("fast", "normal"), ("normal", "high")])
def test_a_lower_level_takes_fewer_transforms(pair):
    low, high = (
        sum(record.pairs for record, _ in states("repulsive", "loads", 101, level))
        for level in pair
    )
    assert low < high


@pytest.mark.parametrize("accuracy", [*LEVELS, 1e-6])
def test_an_accuracy_leaves_the_wall_as_it_is(accuracy):
    def wall(solver):
        kind = "[interaction]\nkind = 'full'\nwork_of_adhesion = 0.05\n"
        return Scene.parse(f"{kind}[solver]\n{solver}").wall

    assert wall(f"accuracy = {accuracy!r}") == wall("")
    assert wall("").cutoff == pytest.approx(10.0 * wall("").distance)


@pytest.mark.parametrize("depth", [0.3, 4.0])
def test_the_cutoff_of_a_full_wall_costs_what_it_says(depth):
    def force(cutoff):
        sphere = RoughSphere(100.0)
        atoms = substrate("Cu", (8, 8), sphere, spacing=1.0)
        wall = LennardJones93.full(1.0, 1 / 27, cutoff=cutoff)
        atoms.calc = RoughContact(sphere, 1.0, wall)
        (record,) = load_path(atoms, [depth], accuracy=1e-8, window="auto")
        state = atoms.calc.state(atoms)
        return record.normal_force, state.pressure[state.contact].sum()

    whole, push = force(60.0)
    short, long = (abs(force(cutoff)[0] - whole) / push for cutoff in (5.0, 10.0))
    assert short < 0.5 / 5.0**3 and long < 0.5 / 10.0**3
    assert long < short / 6.0


def test_a_number_is_a_promise_as_the_level_of_the_same_error_is():
    for level in LEVELS.values():
        assert accuracy_of(level.error).tolerance == level.tolerance
        assert accuracy_of(level.error).error == level.error


@pytest.mark.parametrize(
    "wanted, told",
    [("fst", "did you mean 'fast'"), (1.0, "from 1e-12 to 1"), (0.0, "> 0")],
)
def test_what_is_no_accuracy_is_refused(wanted, told):
    with pytest.raises(ValueError, match=told):
        accuracy_of(wanted)
