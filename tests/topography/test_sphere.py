"""Spheres and paraboloids, smooth and rough."""

import math

import numpy as np
import pytest

from ase_roughcontact.topography import RoughSphere, SelfAffine

# Waves of 4 to 32 on a domain of 128.
SURFACE = SelfAffine(0.1, 0.8, 4.0, 32.0, seed=7)
BUMPS = np.random.default_rng(0).standard_normal((9, 12))


def test_a_paraboloid_rises_with_the_square_of_the_distance():
    heights = RoughSphere(100.0).heights((3, 2), 0.5, origin=(-0.5, 1.0))
    expected = [[1.25, 2.5], [1.0, 2.25], [1.25, 2.5]]
    np.testing.assert_allclose(heights, np.array(expected) / 200, rtol=1e-15)


def test_a_sphere_has_its_radius_everywhere():
    heights = RoughSphere(5.0, profile="sphere").heights((7, 7), 1.0, (-3.0, -3.0))
    x = np.arange(-3.0, 4.0)
    distance = np.sqrt(x[:, None] ** 2 + x[None, :] ** 2 + (heights - 5.0) ** 2)
    np.testing.assert_allclose(distance, 5.0, rtol=1e-15)
    # without cancellation for a large one
    large = RoughSphere(1e9, profile="sphere").heights((4, 4), 1.0)
    paraboloid = RoughSphere(1e9).heights((4, 4), 1.0)
    np.testing.assert_allclose(large, paraboloid, rtol=1e-15)


@pytest.mark.parametrize("profile", ["paraboloid", "sphere"])
def test_an_infinite_radius_is_flat(profile):
    heights = RoughSphere(math.inf, SURFACE, profile).heights((4, 4), 1.0)
    np.testing.assert_array_equal(heights, SURFACE.heights((4, 4), 1.0))


def test_roughness_is_added_to_the_sphere():
    window = (4, 6), 1.0, (-2.0, 0.5)
    np.testing.assert_array_equal(
        RoughSphere(50.0, SURFACE).heights(*window),
        RoughSphere(50.0).heights(*window) + SURFACE.heights(*window),
    )


def test_a_window_beyond_the_sphere_is_refused():
    with pytest.raises(ValueError, match=r"r = 7\.07107 .* sphere of radius 5"):
        RoughSphere(5.0, profile="sphere").heights((6, 6), 1.0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((0.0,), "radius must be a finite number > 0"),
        ((-math.inf,), "radius must be a finite number > 0"),
        ((math.nan,), "radius must be a finite number > 0"),
        ((1.0, BUMPS), "roughness must be .* heights"),
        ((1.0, SelfAffine), "roughness must be .* heights"),
        ((1.0, None, "cone"), "'paraboloid' or 'sphere', got 'cone'"),
    ],
)
def test_wrong_parameters_of_a_sphere_are_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        RoughSphere(*arguments)


@pytest.mark.parametrize("profile", ["paraboloid", "sphere"])
@pytest.mark.parametrize("rough", [False, True], ids=["smooth", "rough"])
def test_no_atom_beyond_the_reach_is_below_the_level(profile, rough):
    roughness = SelfAffine(0.3, 0.8, 4.0, 16.0, domain=64.0) if rough else None
    sphere = RoughSphere(100.0, roughness, profile)
    heights = sphere.heights((64, 64), 1.0, (-32.0, -32.0))
    x = np.arange(-32.0, 32.0)
    distance = np.hypot(x[:, None], x)
    for level in (-0.5, 0.0, 0.1, 1.0, 3.0):
        reach = sphere.reach(level, 1.0)
        assert (heights[distance > reach] >= level).all()
    if not rough:
        edge = sphere.heights((1, 1), 1.0, (reach, 0.0))
        assert edge[0, 0] == pytest.approx(level)
