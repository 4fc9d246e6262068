"""Closed forms of shapes: depths under forces, JKR of a paraboloid, a pulled punch."""

import math

import numpy as np
import pytest

from ase_roughcontact.theory import JKR, Hertz, ShapeTheory
from ase_roughcontact.theory.indenters import (
    Cone,
    Indenter,
    Paraboloid,
    Punch,
    RoundedCone,
    TruncatedCone,
)

MODULUS, WORK, RADIUS = 0.6, 0.02, 500.0
FORCES = np.array([0.1, 3.0, 200.0])


@pytest.mark.parametrize(
    "shape",
    [Cone(1.2), Punch(30.0), RoundedCone(1.2, 50.0), TruncatedCone(1.2, 20.0)],
    ids=lambda shape: shape.name,
)
def test_the_depth_under_a_force_has_this_force(shape):
    depth = shape.depth(FORCES)
    np.testing.assert_allclose(shape.force(depth), FORCES, rtol=1e-7)
    assert shape.depth(0.0) == 0.0


def test_a_paraboloid_is_the_sphere_of_hertz():
    theory, hertz = ShapeTheory(Paraboloid(RADIUS), MODULUS), Hertz(RADIUS, MODULUS)
    np.testing.assert_allclose(theory.contact_area(FORCES), hertz.contact_area(FORCES))
    depth, force = theory.curve_to(20.0)
    radius = hertz.contact_radius_from_penetration(depth)
    np.testing.assert_allclose(force, hertz.force(radius), atol=1e-12)


def test_an_adhesive_paraboloid_is_the_sphere_of_jkr():
    theory = ShapeTheory(Paraboloid(RADIUS), MODULUS, WORK)
    jkr = JKR(RADIUS, MODULUS, WORK)
    assert theory.pull_off_force == pytest.approx(jkr.pull_off_force, rel=1e-5)
    assert theory.pull_off_penetration == pytest.approx(
        jkr.pull_off_penetration, rel=1e-4
    )
    forces = np.append(-0.9 * jkr.pull_off_force, FORCES)
    found = theory.contact_area(forces)
    np.testing.assert_allclose(found, jkr.contact_area(forces), rtol=1e-4)
    assert np.isnan(theory.contact_area(-1.1 * jkr.pull_off_force))


@pytest.mark.parametrize("ratio", [1e3, 1e6])
def test_an_adhesive_paraboloid_far_above_the_pull_off_is_the_sphere_of_jkr(ratio):
    theory = ShapeTheory(Paraboloid(RADIUS), MODULUS, WORK)
    jkr = JKR(RADIUS, MODULUS, WORK)
    force = ratio * jkr.pull_off_force
    radius = float(jkr.contact_radius(force))
    assert float(theory.contact_radius(force)) == pytest.approx(radius, rel=1e-9)
    assert theory.penetration_under(force) == pytest.approx(
        jkr.penetration(radius), rel=1e-9
    )
    depth, forces = theory.curve_to(theory.penetration_under(force))
    assert depth[-1] == pytest.approx(theory.penetration_under(force))
    assert forces[-1] == pytest.approx(force)


@pytest.mark.parametrize("work", [1e-8, 1e-12, 1e-20])
def test_a_cone_of_vanishing_adhesion_is_the_cone_of_sneddon(work):
    cone = Cone(math.radians(45.0))
    plain, theory = ShapeTheory(cone, MODULUS), ShapeTheory(cone, MODULUS, work)
    np.testing.assert_allclose(
        theory.contact_area(FORCES), plain.contact_area(FORCES), rtol=1e-3
    )
    for force in FORCES:
        assert theory.penetration_under(force) == pytest.approx(
            plain.penetration_under(force), rel=1e-3
        )


def test_a_punch_is_pulled_off_at_the_force_of_kendall():
    theory = ShapeTheory(Punch(30.0), MODULUS, WORK)
    kendall = math.sqrt(8.0 * math.pi * MODULUS * WORK * 30.0**3)
    assert theory.pull_off_force == pytest.approx(kendall, rel=1e-4)
    depth, force = theory.curve_to(5.0)
    np.testing.assert_allclose(force, 2.0 * MODULUS * 30.0 * depth, rtol=1e-9)
    assert theory.penetration_under(10.0) == pytest.approx(
        10.0 / (60.0 * MODULUS), rel=1e-4
    )


def test_a_shape_without_a_closed_form_has_no_area():
    class Wedge(Indenter):
        def profile(self, x, y):
            return abs(x) + 0.0 * y

        def reach(self, level):
            return math.inf

    theory = ShapeTheory(Wedge(), MODULUS)
    assert np.isnan(theory.contact_area(1.0))
    assert np.isnan(theory.curve_to(1.0)[1]).all()
