"""A work of adhesion that varies over the surface: patterns, windows, calculator."""

import numpy as np
import pytest
from built import atoms_under, force_along, up
from numpy.testing import assert_allclose, assert_array_equal

import ase_roughcontact as rc

FIELD = rc.SelfAffine(1.0, 0.5, short_wavelength=4.0, long_wavelength=16.0, seed=3)
MAP = rc.HeightMap(np.random.default_rng(1).uniform(-0.5, 0.5, (40, 40)), 1.0)


def stripes(x, y):
    return 0.4 * np.cos(0.7 * x) + 0.0 * y


PATTERNS = {
    "map": rc.Heterogeneity(MAP),
    "function": rc.Heterogeneity(stripes),
    "random": rc.Heterogeneity(FIELD, rms=0.2),
}
every_pattern = pytest.mark.parametrize(
    "pattern", PATTERNS.values(), ids=PATTERNS.keys()
)
WALLS = [
    rc.LennardJones93.adhesive(1.0, 1.0, 0.05),
    rc.LennardJones93.full(distance=1.0, work_of_adhesion=0.05, cutoff=3.0),
    rc.ExponentialWall(0.05, 0.7),
    rc.PowerLawWall(0.05, 0.7),
    rc.DugdaleWall(0.05, 0.7),
]
every_wall = pytest.mark.parametrize("wall", WALLS, ids=lambda w: w.kind)


@every_pattern
def test_windows_cut_the_same_infinite_surface(pattern):
    large = pattern.factors((20, 18), 1.0, (-8.0, -6.0))
    small = pattern.factors((5, 7), 1.0, (-3.0, 1.0))
    assert_allclose(small, large[5:10, 7:14], rtol=1e-12)


def test_random_field_has_its_rms_and_the_mean_of_the_wall():
    factors = PATTERNS["random"].factors((64, 64), 1.0)
    assert factors.mean() == pytest.approx(1.0, abs=1e-12)
    assert factors.std() == pytest.approx(0.2, rel=1e-9)
    other = rc.Heterogeneity(rc.SelfAffine(1.0, 0.5, 4.0, 16.0, seed=4), rms=0.2)
    assert abs(other.factors((64, 64), 1.0) - factors).max() > 0.1


def test_map_and_function_are_the_relative_deviation():
    assert_allclose(PATTERNS["map"].factors((1, 1), 1.0), 1 + MAP.heights((1, 1), 1.0))
    factors = PATTERNS["function"].factors((3, 2), 2.0, (1.0, 0.0))
    expected = 1.0 + 0.4 * np.cos(0.7 * np.array([1.0, 3.0, 5.0]))
    assert_allclose(factors, np.column_stack([expected, expected]))
    negative = rc.Heterogeneity(lambda x, y: x - 2.0).factors((3, 1), 1.0)
    assert_array_equal(negative[:, 0], [0, 0, 1])


def test_map_scaled_to_an_rms_has_the_mean_of_the_wall():
    """A map in any unit, such as of the work of adhesion itself."""
    values = 50.0 + 20.0 * MAP.heights((40, 40), 1.0, (-20.0, -20.0))
    scaled = rc.Heterogeneity(rc.HeightMap(values, 1.0), rms=0.1)
    factors = scaled.factors((40, 40), 1.0, (-20.0, -20.0))
    assert factors.std() == pytest.approx(0.1, rel=1e-6)
    assert factors.mean() == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize(
    "arguments, message",
    [
        ((FIELD,), "needs rms"),
        ((stripes, 0.2), "rms .*omit it"),
        ((MAP, -0.2), "rms must be"),
        ((rc.HeightMap(np.ones((8, 8)), 1.0), 0.2), "must not be flat"),
        ((lambda x, y: x * np.nan,), "pattern must"),
        ((0.3,), "pattern must be"),
    ],
)
def test_invalid_patterns_are_errors(arguments, message):
    with pytest.raises(ValueError, match=message):
        rc.Heterogeneity(*arguments).factors((3, 3), 1.0)


def test_window_beyond_the_period_of_a_field_or_a_map_is_an_error():
    with pytest.raises(ValueError, match=r"of adhesion: .* period of 64 .* domain of"):
        PATTERNS["random"].factors((65, 65), 1.0)
    periodic = rc.Heterogeneity(rc.HeightMap(np.eye(8), 1.0, periodic=True))
    with pytest.raises(ValueError, match=r"of adhesion: .* period 8 "):
        periodic.factors((9, 8), 1.0)


# In the calculator


def adhesive_atoms(wall, pattern, shape=(20, 20), **options):
    sphere = rc.RoughSphere(40.0)
    return atoms_under(sphere, wall, shape, heterogeneity=pattern, **options)


@every_wall
def test_uniform_pattern_changes_the_work_of_adhesion_of_every_wall(wall):
    forces = []
    for pattern in (None, rc.Heterogeneity(lambda x, y: 0 * x), PATTERNS["function"]):
        atoms = adhesive_atoms(wall, pattern)
        atoms.positions[-1, 2] = wall.contact_distance - 0.1
        assert rc.NewtonKrylov(atoms, logfile=None).run(fmax=1e-8)
        forces.append(atoms.calc.state(atoms).normal_force)
    assert forces[1] == pytest.approx(forces[0], rel=1e-7)
    assert abs(forces[2] - forces[0]) > 1e-3


@every_wall
def test_forces_are_minus_the_gradient_of_the_energy_with_a_pattern(wall):
    if wall.hard:
        pytest.skip("a hard wall's reaction is not a function of the positions")
    with pytest.raises(ValueError, match="heterogeneity must be"):
        adhesive_atoms(wall, FIELD)
    atoms = adhesive_atoms(wall, PATTERNS["map"], (8, 8))
    atoms.positions[-1, 2] = wall.contact_distance + 0.2
    expected = force_along(atoms, up(atoms, 20), 1e-4)
    assert atoms.get_forces()[20, 2] == pytest.approx(expected, rel=1e-6)


def test_automatic_windows_give_the_result_of_a_fixed_window():
    wall, pattern = rc.ExponentialWall(0.05, 0.7), PATTERNS["random"]
    depths = [-0.1, 0.4]
    fixed, auto = (
        rc.load_path(
            adhesive_atoms(wall, pattern, shape), penetrations=depths, window=window
        )
        for shape, window in (((56, 56), "fixed"), ((8, 8), "auto"))
    )
    for one, other in zip(fixed, auto, strict=True):
        assert one.window != other.window
        assert other.normal_force == pytest.approx(one.normal_force, rel=1e-4)
        assert other.repulsive_atoms == one.repulsive_atoms
