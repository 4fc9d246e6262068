"""Accuracy: errors of force and area stay below the allowed ones.

Spheres, loads and seeds differ from those by which the tolerances were chosen.
"""

from functools import cache

import numpy as np
import pytest
from built import atoms_under

import ase_roughcontact as rc
from ase_roughcontact.scene import Scene
from ase_roughcontact.stepping.accuracy import GridModel, grid_for, points_per_wave
from ase_roughcontact.windows.regrid import GridChange

# In units of the contact modulus and of the spacing.
WALLS = {
    "hard": rc.HardWall(),
    "repulsive": rc.LennardJones93.repulsive(1.0, 1.0),
    "adhesive": rc.LennardJones93.adhesive(1.0, 1.0, 0.01),
    "full": rc.LennardJones93.full(distance=1.0, work_of_adhesion=0.03, cutoff=5.0),
}
SEEDS = (101, pytest.param(102, marks=pytest.mark.slow))
PATHS = {
    "large steps": {"penetrations": (0.3, 1.0, 2.0)},
    "small steps": {"penetrations": tuple(np.linspace(0.8, 1.0, 6))},
    "loads": {"loads": (0.05, 1.0, 10.0)},
}
REFERENCE = 1e-10  # far more accurate


@cache
def states(wall, path, seed, accuracy):
    """Results of a path, and the total repulsive force at each of its steps."""
    rough = rc.SelfAffine(0.1, 0.8, 4.0, 48.0, seed=seed, domain=256.0)
    sphere = rc.RoughSphere(150.0, rough)
    fixed = "loads" not in PATHS[path]
    atoms = atoms_under(sphere, WALLS[wall], fixed=fixed)
    found = []
    for record in rc.load_path(atoms, accuracy=accuracy, window="auto", **PATHS[path]):
        state = atoms.calc.state(atoms)
        found.append((record, float(state.pressure[state.contact].sum())))
    return found


@pytest.mark.parametrize("level", ["fast", "normal"])
@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("path", PATHS)
@pytest.mark.parametrize("wall", WALLS)
def test_errors_of_force_and_area_are_at_most_the_allowed_ones(wall, path, seed, level):
    """Error of the force relative to the repulsion, of the area beyond one atom."""
    allowed, reference = (
        GridModel(accuracy=level).error,
        states(wall, path, seed, REFERENCE),
    )
    for (record, _), (truth, push) in zip(
        states(wall, path, seed, level), reference, strict=True
    ):
        assert record.converged and truth.converged
        assert abs(record.normal_force - truth.normal_force) <= allowed * push
        amiss = abs(record.repulsive_atoms - truth.repulsive_atoms)
        assert amiss <= 1 + allowed * truth.repulsive_atoms


@pytest.mark.parametrize("accuracy", ["fast", 1e-6])
def test_accuracy_does_not_change_the_wall(accuracy):
    def wall(solver):
        kind = "[interaction]\nkind = 'full'\nwork_of_adhesion = 0.05\n"
        solid = "[substrate]\nmaterial = 'Cu'\n"
        return Scene.parse(f"{solid}{kind}[solver]\n{solver}").wall

    assert wall(f"accuracy = {accuracy!r}") == wall("")
    assert wall("").cutoff == pytest.approx(10.0 * wall("").distance)


@pytest.mark.parametrize("depth", [0.3, 4.0])
def test_error_due_to_the_cutoff_of_a_full_wall_is_as_documented(depth):
    def force(cutoff):
        wall = {"distance": 1.0, "work_of_adhesion": 1 / 27, "cutoff": cutoff}
        atoms = atoms_under(rc.RoughSphere(100.0), rc.LennardJones93.full(**wall))
        (record,) = rc.load_path(
            atoms, penetrations=[depth], accuracy=1e-8, window="auto"
        )
        state = atoms.calc.state(atoms)
        return record.normal_force, state.pressure[state.contact].sum()

    whole, push = force(60.0)
    short, long = (abs(force(cutoff)[0] - whole) / push for cutoff in (5.0, 10.0))
    assert short < 0.5 / 5.0**3 and long < 0.5 / 10.0**3
    assert long < short / 6.0


@pytest.mark.parametrize(
    "wanted, message",
    [("fst", "did you mean 'fast'"), (1.0, "from 1e-12 to 1"), (0.0, "> 0")],
)
def test_invalid_accuracy_is_an_error(wanted, message):
    with pytest.raises(ValueError, match=message):
        GridModel(accuracy=wanted)


def test_tolerance_and_errors_under_tension_agree_with_the_magnitudes():
    """Hard walls with attraction hold atoms in contact under a total tension."""
    sphere = rc.RoughSphere(30.0)
    atoms = atoms_under(sphere, rc.DugdaleWall(0.05, 0.6), (32, 32))
    pressed, pulled = rc.load_path(atoms, penetrations=[0.8, -0.35], validity="ignore")
    assert pressed.mean_pressure > 0.0 > pulled.mean_pressure
    assert pulled.tolerance > 0.1 * pressed.tolerance
    assert pulled.area_error > 0.0


# Grids of the continuum

SOFT = WALLS["repulsive"]


def spacing(error, wave=4.0, wall=SOFT, domain=64.0, shape=None):
    """Return the spacing of the grid in units of the spacing of the atoms."""
    rough = rc.SelfAffine(0.1, 0.8, wave, max(wave, 32.0), domain=domain)
    return grid_for(error, rc.RoughSphere(100.0, rough), wall, 1.0, shape).spacing(1.0)


@pytest.mark.parametrize(
    "error, points",
    [(0.2, 4), (0.05, 4), (0.02, 6), (0.01, 8), (0.002, 16), (0.001, 32), (5e-4, 64)],
)
def test_smaller_errors_need_more_points_on_the_shortest_wave(error, points):
    assert spacing(error) == pytest.approx(4.0 / points)


@pytest.mark.parametrize("wave", [4.0, 5.0, 6.0, 7.0, 9.0, 11.0, 12.5, 14.0])
@pytest.mark.parametrize("error", [0.05, 0.03, 0.02, 0.01, 0.007])
def test_any_wave_and_error_has_at_most_a_third_more_points_than_it_needs(wave, error):
    rough = rc.SelfAffine(0.1, 0.8, wave, 64.0, domain=840.0)
    sphere, needed = rc.RoughSphere(100.0, rough), points_per_wave(error)
    grid = grid_for(error, sphere, rc.HardWall(), 1.0)
    assert 1.0 - 1e-9 <= wave / grid.spacing(1.0) / needed < 1.34
    rough = grid.surface(sphere, 1.0).roughness
    assert rough.short_wavelength == wave


def test_spots_that_flow_have_six_points_on_the_shortest_wave():
    assert spacing(0.05, wall=rc.PlasticWall(0.05)) == pytest.approx(4.0 / 6.0)
    assert spacing(0.01, wall=rc.PlasticWall(0.05)) == 0.5


def test_errors_below_the_smallest_are_not_attempted():
    with pytest.raises(ValueError, match="at least"):
        spacing(0.0004)


@pytest.mark.parametrize(
    "wall, largest", [(rc.HardWall(), 8), (SOFT, 2), (rc.DugdaleWall(0.01, 0.5), 1)]
)
def test_grids_are_coarser_only_as_far_as_the_wall_is_resolved(wall, largest):
    assert spacing(0.05, wave=64.0, wall=wall) == largest


@pytest.mark.parametrize(
    "period_or_window, coarsest",
    [
        ({"domain": 128}, 8),
        ({"domain": 132}, 22 / 3),
        ({"domain": 130}, 6.5),
        ({"shape": (64, 96)}, 8),
        ({"shape": (64, 100)}, 4),
    ],
)
def test_coarser_grids_divide_period_and_fixed_window(period_or_window, coarsest):
    found = spacing(0.05, 32.0, rc.HardWall(), **period_or_window)
    assert found == pytest.approx(coarsest)


@pytest.mark.parametrize(
    ("text", "model", "ratio"),
    [
        ("atoms", "atoms", 1.0),
        ("a0/2", "continuum", 0.5),
        ("3 a0/4", "continuum", 0.75),
        ("a0", "continuum", 1.0),
        ("2 a0", "continuum", 2.0),
        ("continuum", "continuum", 0.5),
    ],
)
def test_a_text_says_what_grid_points_are_and_their_spacing(text, model, ratio):
    found = GridModel.of(text, 0.05)
    assert found.model == model
    # four points on a wave of two spacings
    sphere = rc.RoughSphere(100.0, rc.SelfAffine(0.1, 0.8, 2.0, 32.0))
    assert found.grid(sphere, rc.HardWall(), 1.0).spacing(1.0) == ratio


def test_the_area_of_the_model_is_the_column_of_paths():
    options = rc.StepOptions(continuum=True)
    assert options.grid_model.area_column == "continuum_area"
    assert rc.StepOptions().grid_model.area_column == "contact_area"


def test_a_grid_is_given_only_for_the_continuum():
    with pytest.raises(ValueError, match="continuum"):
        GridModel("atoms", given=GridChange(2, 1))


def test_an_unknown_model_is_refused_with_the_closest_name():
    with pytest.raises(ValueError, match="'continuum'"):
        GridModel("continum")
