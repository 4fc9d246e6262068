"""Theory with which the results of a scene are compared."""

import numpy as np
import pytest
from small_scene import ROUGH, SMOOTH, adhesive

from ase_roughcontact.cli.description import theory
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.reference import reference_for

# Smooth spheres


@pytest.mark.parametrize(
    "radius, work, kind, name",
    [
        (60.0, 0.5, "adhesive", "Maugis-Dugdale"),
        (1e6, 5.0, "full", "JKR"),
        (5.0, 0.05, "full", "DMT"),
    ],
)
def test_maugis_parameter_selects_the_theory_of_an_adhesive_sphere(
    radius, work, kind, name
):
    text = SMOOTH.replace("radius = 60.0", f"radius = {radius}")
    reference = reference_for(adhesive(text, work, kind))
    assert reference.smooth.name == name and reference.rough_above is None
    limits = ["JKR", "DMT"] if name == "Maugis-Dugdale" else []
    assert [limit.name for limit in reference.limits] == limits


def test_without_adhesion_the_theory_is_hertz():
    scene = Scene.parse(SMOOTH)
    reference = reference_for(scene)
    hertz = reference.smooth
    assert reference.rough_above is None
    assert (hertz.name, hertz.pull_off_force) == ("Hertz", 0.0)
    area = hertz.contact_area([-1.0, 0.0, 2.0])
    np.testing.assert_array_equal(area[1:], scene.bodies.hertz_area([0.0, 2.0]))
    assert np.isnan(area[0])
    depth, force = hertz.curve(10.0)
    expected = 4 / 3 * scene.contact_modulus * np.sqrt(scene.radius) * depth**1.5
    np.testing.assert_allclose(force, expected, rtol=1e-13)
    assert depth[-1] == pytest.approx(100.0 / scene.radius)


def test_areas_and_curves_agree_and_the_smallest_force_is_pull_off():
    reference = reference_for(adhesive(SMOOTH, 0.5))
    for sphere in (reference.smooth, *reference.limits):
        depth, force = sphere.curve(40.0)
        assert force.min() == pytest.approx(-sphere.pull_off_force, rel=1e-4)
        stable = slice(int(force.argmin()) + 1, None)
        assert (np.diff(depth[stable]) > 0).all() and (np.diff(force[stable]) > 0).all()
        last = np.sqrt(sphere.contact_area(force[-1:]) / np.pi)
        assert last == pytest.approx([40.0], rel=0.02)
        assert np.isnan(sphere.contact_area(-1.01 * sphere.pull_off_force))


# Rough spheres


@pytest.mark.parametrize(
    "longest, work, explanation, remaining",
    [
        (16.0, 0.05, "Eq. (4) with adhesion", 0.05),
        (256.0, 0.2, "none for this contact, as flat surfaces with", 0.2),
        (40.0, 0.5, "none for this contact, as the contact at zero load", 0.5),
        (8.0, 0.5, "adhesion of w = 0.5 J/m² flattens the roughness", 0.442),
    ],
)
def test_theory_of_a_rough_adhesive_sphere(longest, work, explanation, remaining):
    scene = adhesive(ROUGH.replace("16.0", str(longest)), work)
    reference = reference_for(scene)
    assert reference.explanation.startswith(explanation)
    assert reference.smooth.pull_off_force > 0.0
    assert reference.smooth.sphere == f"smooth sphere, w = {remaining:.3g} J/m²"
    assert reference.smooth.sphere in reference.explanation
    has_closed_form = explanation.startswith("Eq. (4)")
    assert (reference.rough_above is not None) == has_closed_form
    assert (scene.bodies.inverse_kappa > 0.0) == has_closed_form


def test_flats_adhere_by_one_formula_in_theory_and_criteria():
    """Next to the limit, where another rms curvature would give another answer."""

    def found(work):
        scene = adhesive(ROUGH, work)
        *_, criterion = reference_for(scene).criteria
        assert criterion.sticky == (scene.bodies.inverse_kappa <= 0.0)
        return criterion.sticky

    low, high = 0.01, 1.0
    assert not found(low) and found(high)
    while high - low > 1e-4 * high:
        work = 0.5 * (low + high)
        low, high = (low, work) if found(work) else (work, high)


def test_equation_4_with_adhesion_is_not_shown_below_its_range():
    scene = adhesive(ROUGH, 0.05)
    reference = reference_for(scene)
    smallest = reference.rough_above
    area = reference.rough_area(smallest * np.array([-1.0, 0.99, 1.0, 9.0]))
    assert list(np.isnan(area)) == [True, True, False, False]
    assert area[3] == scene.bodies.predicted_area(9.0 * smallest)
    assert "too small below about" in reference.explanation


def test_description_of_a_rough_adhesive_scene_lists_criteria_of_stickiness():
    reference = reference_for(adhesive(ROUGH, 0.5))
    names = ["Fuller-Tabor", "Persson-Tosatti", "Pastewka-Robbins"]
    assert [criterion.name for criterion in reference.criteria] == names
    assert theory(reference)["stickiness of flats"].startswith("Fuller-Tabor: ")
    assert reference_for(adhesive(SMOOTH, 0.5)).criteria == ()
    one_wave = ROUGH + "short_wavelength = 16.0\n"
    assert len(reference_for(adhesive(one_wave, 0.5)).criteria) == 3
