"""Perimeter, and the area of the continuum from one grid."""

import numpy as np
import pytest
from built import atoms_under

import ase_roughcontact as rc
from ase_roughcontact.analysis import extrapolate
from ase_roughcontact.theory.counted_area import continuum_area, grid_error, open_sides

WALLS = {"hard": rc.HardWall(), "repulsive": rc.LennardJones93.repulsive(1.0, 1.0)}
ROUGH = rc.SelfAffine(0.1, 0.8, 4.0, 16.0, seed=3, domain=32.0)
# contact of about 10, 50 and 90 %
LOADS = 32**2 * 0.1 * np.array([0.05, 0.3, 0.9])


def steps_on_flat(wall, spacing, loads=LOADS, **options):
    flat, shape = rc.RoughSphere(np.inf, ROUGH), 2 * (round(32 / spacing),)
    cell = {"spacing": spacing, "periodic": True, "fixed": False}
    atoms = atoms_under(flat, WALLS.get(wall, wall), shape, **cell)
    return list(rc.load_path(atoms, loads=loads, validity="ignore", **options))


@pytest.mark.parametrize(
    "rows, periodic, sides",
    [
        (["...", ".x.", "..."], False, 4),
        (["...", "xx.", "..."], False, 6),
        (["...", "xxx", "..."], True, 6),
        (["...", "xxx", "..."], False, 8),
        (["xxx", "xxx", "xxx"], True, 0),
        (["x..", "...", "x.."], True, 6),
        (["xx.", "...", "..."], True, 6),
        (["xxx", "x.x", "xxx"], False, 16),
    ],
)
def test_open_sides_of_small_contacts(rows, periodic, sides):
    contact = np.array([[site == "x" for site in row] for row in rows])
    assert open_sides(contact, periodic).sum() == sides
    assert not open_sides(contact, periodic)[~contact].any()


def test_correction_is_the_published_one():
    area = continuum_area(10.0, 6.0, 0.5)
    assert area == 10.0 - (np.pi - 1.0 + np.log(2.0)) / 24.0 * 6.0 * 0.5


def test_corrected_area_under_a_hard_wall_depends_on_the_grid_less():
    coarse, fine = (steps_on_flat("hard", spacing) for spacing in (1.0, 0.25))
    counted, corrected = (
        np.divide(*([getattr(s, name) for s in steps] for steps in (coarse, fine)))
        for name in ("contact_area", "continuum_area")
    )
    assert (counted - 1.0 > [0.1, 0.04, 0.005]).all()
    assert (abs(corrected - 1.0) < [0.04, 0.02, 0.002]).all()
    for step in coarse:
        lines = continuum_area(step.contact_area, step.perimeter, 1.0)
        assert step.continuum_area == lines < step.contact_area


def test_corrected_area_of_plastic_contact_is_at_least_load_over_hardness():
    loads = 0.02 * 32**2 * np.array([0.05, 0.3, 0.7])
    coarse, fine = (
        steps_on_flat(rc.PlasticWall(0.02), spacing, loads) for spacing in (1.0, 0.25)
    )
    for step, limit in zip(coarse, fine, strict=True):
        corrected = continuum_area(step.contact_area, step.perimeter, 1.0)
        assert corrected < step.normal_force / 0.02 == step.continuum_area
        assert step.continuum_area == pytest.approx(limit.continuum_area, rel=0.02)
        assert step.contact_area > 1.02 * limit.continuum_area
    (light, *_) = steps_on_flat(rc.PlasticWall(0.02), 1.0, loads[:1], grid="continuum")
    assert light.continuum_area == light.normal_force / 0.02


def test_area_under_a_wall_of_finite_stiffness_needs_no_correction():
    for step in steps_on_flat("repulsive", 1.0):
        assert step.perimeter > 0.0
        assert step.continuum_area == step.contact_area


def test_area_by_the_edge_where_the_continuum_is_asked_for():
    """Exact within 1 % on the grid of a0, where that by the perimeter is within 4 %."""
    options = {"grid": "a0", "accuracy": 1e-6}
    areas = [
        [step.continuum_area for step in steps_on_flat("hard", spacing, **options)]
        for spacing in (1.0, 0.5, 0.25)
    ]
    errors = abs(np.divide(areas[:2], areas[2]) - 1.0)
    assert (errors[0] < [0.025, 0.025, 0.01]).all()
    assert (errors[1] < 0.4 * errors[0].max()).all()


@pytest.mark.parametrize(
    "wall",
    [rc.PlasticWall(0.05)]
    + [w(0.005, 0.3) for w in (rc.DugdaleWall, rc.ExponentialWall, rc.PowerLawWall)],
)
def test_area_by_the_edge_under_walls_with_attraction_or_hardness(wall):
    options, found = {"grid": "a0", "accuracy": 1e-4}, []
    for spacing in (1.0, 0.5, 0.125):
        (step,) = steps_on_flat(wall, spacing, LOADS[1:2], **options)
        area = step.continuum_area, step.area_error
        found.append((*area, step.height, step.height_error))
    areas, errors, heights, height_errors = np.transpose(found)
    assert (abs(areas - areas[2])[:2] < 2.0 * errors[:2]).all()
    assert (abs(heights - heights[2])[:2] < 2.0 * height_errors[:2]).all()
    assert (errors[:2] < [0.06 * areas[2], 0.02 * areas[2]]).all()


def test_estimate_of_the_error_agrees_with_the_edge():
    (step, *_) = steps_on_flat("hard", 0.5, grid="a0")
    at_edge = 0.006 * step.perimeter * 0.5 + 0.125
    assert at_edge < step.area_error < at_edge + 0.03 * step.continuum_area
    (coarse, *_) = steps_on_flat("hard", 1.0, grid="2 a0")
    assert coarse.area_error > 0.042 * coarse.perimeter * 2.0
    (of_atoms, *_) = steps_on_flat("hard", 0.5)
    assert of_atoms.area_error < 1e-3 * of_atoms.contact_area


def test_wall_is_soft_on_grids_that_are_fine_for_its_compliance():
    """From a quarter of the correction to all of it, half where dx^2 = 6 l^2."""
    correction = 100.0 - continuum_area(100.0, 40.0, 2.0)
    parts = [
        (grid_error(40.0, 4.0, compliance=2.0 / np.sqrt(ratio)) - 2.0) / correction
        for ratio in (1e-3, 1.0, 6.0, 54.0, 1e9)
    ]
    assert parts == pytest.approx([0.25, 0.25, 0.5, 0.9, 1.0])
    for compliance in (0.0, 1e300, np.inf):
        error = grid_error(40.0, 4.0, compliance)
        assert error == pytest.approx(0.25 * correction + 2.0)


@pytest.mark.parametrize("wall", WALLS)
def test_limit_of_two_coarse_grids_agrees_with_finer_ones_within_its_error(wall):
    areas = {
        spacing: [step.contact_area for step in steps_on_flat(wall, spacing)]
        for spacing in (1.0, 0.5, 0.25)
    }
    two = extrapolate([0.5, 1.0], [areas[0.5], areas[1.0]])
    three = extrapolate(list(areas), list(areas.values()))
    assert (abs(two.value - three.value) < 2.0 * two.error).all()
    assert (three.error < 0.05 * three.value).all()


def test_extrapolation_is_exact_for_a_power_of_the_spacing():
    h = np.array([0.5, 2.0, 1.0])
    for order in (1.0, 2.0):
        values = 3.0 + np.outer(h**order, [0.0, 1.0, -2.0])
        for grids in ([0, 1, 2], [1, 2]):
            limit = extrapolate(h[grids], values[grids], order)
            np.testing.assert_allclose(limit.value, 3.0, rtol=1e-12)
            smallest = abs(values[grids][np.argmin(h[grids])] - 3.0)
            share = 0.5 if len(grids) == 3 else 1.0
            np.testing.assert_allclose(limit.error, share * smallest, atol=1e-12)


@pytest.mark.parametrize(
    "spacings, values, message",
    [
        ([1.0], [1.0], "spacings"),
        ([1.0, 0.5], [1.0, 2.0, 3.0], "rows"),
        ([1.0, 1.0], [1.0, 2.0], "must differ"),
        ([1.0, -1.0], [1.0, 2.0], "spacing must be"),
        ([1.0, 0.5], [1.0, np.nan], "values"),
    ],
)
def test_extrapolation_rejects(spacings, values, message):
    with pytest.raises(ValueError, match=message):
        extrapolate(spacings, values)
