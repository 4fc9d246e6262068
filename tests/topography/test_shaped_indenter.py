"""Heights of cones, pyramids and punches on a grid."""

import math

import numpy as np
import pytest

from ase_roughcontact.theory.indenters import (
    Cone,
    Paraboloid,
    Punch,
    Pyramid,
    RoundedCone,
    RoundedPyramid,
    Sphere,
    TruncatedCone,
    TruncatedPyramid,
)
from ase_roughcontact.topography import RoughSphere, ShapedIndenter

ANGLE = math.radians(70.0)
SLOPE = 1.0 / math.tan(ANGLE)
SHAPES = [
    Paraboloid(5.0),
    Sphere(5.0),
    Cone(ANGLE),
    Pyramid(ANGLE),
    Punch(2.0),
    TruncatedCone(ANGLE, 2.0),
    TruncatedPyramid(ANGLE, 2.0),
    RoundedCone(ANGLE, 5.0),
    RoundedPyramid(ANGLE, 5.0),
]


def heights(shape, count=41, spacing=0.2):
    corner = -spacing * (count // 2)
    surface = ShapedIndenter(shape)
    return surface.heights((count, count), spacing, (corner, corner))


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape.name)
def test_beyond_the_reach_all_heights_exceed_the_level(shape):
    x = 0.2 * np.arange(-20, 21)
    distance, h = np.hypot(x[:, None], x), heights(shape)
    assert h[20, 20] == h.min() == 0.0
    for level in (0.02, 0.3, 0.8):
        reach = ShapedIndenter(shape).reach(level, 0.2)
        assert (h[distance > reach + 1e-9] > level - 1e-9).all()
        assert reach < 1.5 * distance[h <= level].max() + 0.3  # and not much further


def test_a_paraboloid_is_a_sphere_of_a_scene():
    for shape, profile in ((Paraboloid(9.0), "paraboloid"), (Sphere(9.0), "sphere")):
        sphere = RoughSphere(9.0, profile=profile)
        expected = sphere.heights((41, 41), 0.2, (-4.0, -4.0))
        np.testing.assert_allclose(heights(shape), expected, atol=1e-14)


@pytest.mark.parametrize(
    "shape, expected",
    [
        (Cone(ANGLE), SLOPE * math.hypot(4.0, 1.0)),
        (Pyramid(ANGLE), SLOPE * 4.0),
        (TruncatedCone(ANGLE, 2.0), SLOPE * (math.hypot(4.0, 1.0) - 2.0)),
        (TruncatedPyramid(ANGLE, 2.0), SLOPE * (4.0 - math.sqrt(math.pi))),
        (RoundedCone(ANGLE, 5.0), SLOPE * (math.hypot(4.0, 1.0) - 2.5 * SLOPE)),
        (RoundedPyramid(ANGLE, 5.0), SLOPE * (4.0 - 2.5 * SLOPE)),
    ],
    ids=lambda each: getattr(each, "name", ""),
)
def test_sides_rise_with_the_half_angle(shape, expected):
    assert heights(shape)[40, 25] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("made", [RoundedCone, RoundedPyramid])
def test_rounded_tips_are_convex_and_paraboloids_at_the_apex(made):
    h = heights(made(ANGLE, 5.0), count=201, spacing=0.05)
    np.testing.assert_allclose(h[101:104, 100], [0.00025, 0.001, 0.00225], rtol=1e-9)
    for line in (h[:, 100], h[:, 130], np.diag(h)):
        assert np.diff(line, 2).min() > -1e-12
    assert abs(np.diff(h, axis=0)).max() == pytest.approx(0.05 * SLOPE, rel=1e-9)
