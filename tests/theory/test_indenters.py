"""Indenters of simple shapes: integrals of Sneddon, limits, a relaxed pyramid."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.scene import Scene
from ase_roughcontact.theory import ShapeTheory
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
    named_indenter,
)

ANGLE = math.radians(35.0)
LAYER = """
[substrate]
layer_modulus = "1 MPa"
layer_thickness = "20 nm"
layer_poisson = 0.5
rigid_base = true
spacing = "0.8 nm"
model = "continuum"
hardness = inf
[sphere]
radius = "100 nm"
[interaction]
kind = "hard"
[path]
control = "penetration"
values = [1.0]
"""
PYRAMID = """
[substrate]
contact_modulus = "1 GPa"
spacing = "4 nm"
model = "continuum"
hardness = inf
[indenter]
half_angle = 65.0
{indenter}
[interaction]
kind = "hard"
[path]
control = "penetration"
values = [1.0]
"""
TIP = """
[substrate]
contact_modulus = "1 GPa"
spacing = "3 Å"
model = "continuum"
hardness = inf
[sphere]
radius = inf
[topography]
file = "{file}"
role = "indenter"
spacing = 0.3
unit = "nm"
detrend = "none"
center = "highest"
[interaction]
kind = "hard"
[path]
control = "penetration"
values = [1.0]
"""


def sneddon(slope, depth, largest, corner):
    """Force over E* of a profile by numerical integrals over its slope f'(r)."""

    def integral(function, a):
        # r = a sin(t) removes the singularity
        points = [math.asin(corner / a)] if 0.0 < corner < a else None
        return quad(
            lambda t: function(a * math.sin(t)), 0.0, math.pi / 2, points=points
        )[0]

    a = brentq(lambda a: a * integral(slope, a) - depth, corner + 1e-9, largest)
    return 2.0 * integral(lambda r: r**2 * slope(r), a), a


@pytest.mark.parametrize(
    "indenter, slope, largest, corner",
    [
        (Paraboloid(3.0), lambda r: r / 3.0, 50.0, 0.0),
        (Sphere(3.0), lambda r: r / math.sqrt(9.0 - r**2), 2.9999, 0.0),
        (Cone(ANGLE), lambda r: 1.0 / math.tan(ANGLE), 50.0, 0.0),
        (
            TruncatedCone(ANGLE, 0.5),
            lambda r: (r > 0.5) / math.tan(ANGLE),
            50.0,
            0.5,
        ),
        (
            RoundedCone(ANGLE, 0.5),
            lambda r: min(r / 0.5, 1.0 / math.tan(ANGLE)),
            50.0,
            0.5 / math.tan(ANGLE),
        ),
    ],
)
@pytest.mark.parametrize("depth", [1.2, 3.0])
def test_forces_are_integrals_over_the_profile(indenter, slope, largest, corner, depth):
    force, radius = sneddon(slope, depth, largest, corner)
    assert indenter.force(depth) == pytest.approx(force, rel=1e-6)
    assert indenter.radius(depth) == pytest.approx(radius, rel=1e-4)


@pytest.mark.parametrize(
    "made, limit",
    [
        (RoundedCone(ANGLE, 1.0), Paraboloid(1.0)),
        (TruncatedCone(ANGLE, 1.0), Punch(1.0)),
        (Sphere(1.0), Paraboloid(1.0)),
    ],
)
def test_small_contacts_are_at_the_end(made, limit):
    # the sides of a truncated cone add a part of the order of the square root
    assert made.force(1e-6) == pytest.approx(limit.force(1e-6), rel=1e-3)


@pytest.mark.parametrize(
    "made, limit",
    [
        (RoundedCone(ANGLE, 1.0), Cone(ANGLE)),
        (TruncatedCone(ANGLE, 1.0), Cone(ANGLE)),
        (RoundedPyramid(ANGLE, 1.0), Pyramid(ANGLE)),
        (TruncatedPyramid(ANGLE, 1.0), Pyramid(ANGLE)),
    ],
)
def test_large_contacts_are_on_the_sides(made, limit):
    assert made.force(2e3) == pytest.approx(limit.force(2e3), rel=2e-3)


@pytest.mark.parametrize("radius", [3e4, 1e6])
def test_a_truncated_cone_has_any_contact_radius(radius):
    depth = radius * math.acos(1.0 / radius) / math.tan(ANGLE)
    force = (radius**2 * math.acos(1.0 / radius) + radius) / math.tan(ANGLE)
    cone = TruncatedCone(ANGLE, 1.0)
    assert cone.radius(depth) == pytest.approx(radius, rel=1e-6)
    assert cone.force(depth) == pytest.approx(force, rel=1e-6)


def test_a_sphere_far_below_its_equator_is_a_punch():
    sphere, depth = Sphere(3.0), np.array([60.0, 3e3])
    np.testing.assert_allclose(sphere.radius(depth), 3.0)
    np.testing.assert_allclose(sphere.force(depth), 6.0 * depth - 9.0, rtol=1e-8)


def test_there_is_no_force_above_the_surface():
    for indenter in (Paraboloid(1.0), Sphere(1.0), Punch(1.0), RoundedCone(0.5, 1.0)):
        np.testing.assert_array_equal(indenter.force([-1.0, 0.0]), 0.0)
        np.testing.assert_array_equal(indenter.radius([-1.0, 0.0]), 0.0)


def test_a_thin_layer_is_stiffer():
    sphere = Paraboloid(10.0)
    ratio = sphere.force_on_layer(0.4, 4.0) / sphere.force(0.4)
    assert ratio == pytest.approx(1.0 + 0.5665 + 0.37425 + 0.183625 + 0.0471875)
    assert sphere.force_on_layer(0.4, math.inf) == sphere.force(0.4)
    with pytest.raises(ValueError, match=r"thickness must be .* got 0\.0"):
        sphere.force_on_layer(0.4, 0.0)
    with pytest.raises(ValueError, match="layer_thickness"):
        RoundedCone(ANGLE, 1.0).force_on_layer(0.4, 4.0)


@pytest.mark.parametrize(
    "text, made",
    [
        ("sphere 5 um", Sphere(5e4)),
        ("cone 35 deg", Cone(ANGLE)),
        ("punch 2 µm", Punch(2e4)),
        ("flat punch 2 um", Punch(2e4)),
        ("cylinder 2 um", Punch(2e4)),
        ("rounded pyramid 35 deg 20 nm", RoundedPyramid(ANGLE, 200.0)),
    ],
)
def test_indenters_are_found_by_name(text, made):
    assert named_indenter(text) == made


@pytest.mark.parametrize(
    "text, message",
    [
        ("ball 5 um", "unknown indenter 'ball'"),
        ("cone", "a cone needs angle with units"),
        ("rounded cone 35 deg", "needs angle and length"),
        ("cone 35 nm", "unknown unit of angle"),
        ("cone 95 deg", "below 90 degrees"),
        ("sphere -1 nm", "tip_radius must be .* got -10.0"),
    ],
)
def test_wrong_names_and_dimensions_are_errors(text, message):
    with pytest.raises(ValueError, match=message):
        named_indenter(text)


@pytest.mark.parametrize("ratio, error", [(0.25, 0.003), (0.5, 0.01), (1.0, 0.15)])
def test_a_relaxed_layer_has_the_force_of_the_polynomial(ratio, error):
    radius, thickness = 1000.0, 200.0
    depth = (ratio * thickness) ** 2 / radius
    scene = Scene.parse(LAYER)
    (step,) = scene.relax(np.array([depth]), validity="ignore")
    force = UNITS["MPa"] * Paraboloid(radius).force_on_layer(depth, thickness)
    assert step.normal_force == pytest.approx(force, rel=error)


def test_a_relaxed_pyramid_has_the_force_of_the_formula(tmp_path):
    count, angle = 129, math.radians(70.0)
    x = 0.3 * (np.arange(count) - 64.0)  # nm
    lower = np.maximum(abs(x)[:, None], abs(x)[None, :]) / math.tan(angle)
    np.save(file := tmp_path / "tip.npy", -lower)  # seen from outside
    scene = Scene.parse(TIP.format(file=file))
    (step,) = scene.relax(np.array([20.0]), validity="ignore", scan_errors=False)
    force = UNITS["GPa"] * Pyramid(angle).force(20.0)
    assert step.normal_force == pytest.approx(force, rel=0.005)
    # G. G. Bilodeau, J. Appl. Mech. 59, 519 (1992), an estimate from above
    bilodeau = 0.7453 * UNITS["GPa"] * math.tan(angle) * 20.0**2
    assert force == pytest.approx(bilodeau, rel=0.011)
    assert force < bilodeau


@pytest.mark.parametrize(
    "made, area",
    [
        (RoundedPyramid(ANGLE, 1000.0), math.pi * 1000.0 * 1.0),
        (TruncatedPyramid(ANGLE, 1000.0), math.pi * 1000.0**2),
    ],
)
def test_the_contact_of_a_blunt_pyramid_is_its_end_at_a_small_depth(made, area):
    theory = ShapeTheory(made, 0.5)
    assert theory.contact_area(0.5 * made.force(1.0)) == pytest.approx(area, rel=1e-3)


@pytest.mark.parametrize(
    "indenter, depth",
    [
        ('kind = "rounded pyramid"\ntip_radius = "200 nm"', 400.0),
        ('kind = "truncated pyramid"\nend_radius = "80 nm"', 350.0),
    ],
    ids=["rounded", "truncated"],
)
def test_the_contact_of_a_relaxed_blunt_pyramid_has_the_area(indenter, depth):
    scene = Scene.parse(PYRAMID.format(indenter=indenter))
    (step,) = scene.relax(np.array([depth]), validity="ignore")
    theory = scene.bodies.nonadhesive
    area = float(theory.contact_area(step.normal_force))
    ends = math.pi * theory.contact_radius(step.normal_force) ** 2
    assert area != pytest.approx(float(ends), rel=0.01)
    assert step.continuum_area == pytest.approx(area, rel=0.01)
