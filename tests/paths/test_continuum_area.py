"""Perimeter, and the area of the continuum from one grid."""

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
from ase_roughcontact.contact import continuum_area, open_sides

WALLS = {"hard": HardWall(), "repulsive": LennardJones93.repulsive(1.0, 1.0)}
ROUGH = SelfAffine(0.1, 0.8, 4.0, 16.0, seed=3, domain=32.0)
# contact of about 10, 50 and 90 %
LOADS = 32**2 * 0.1 * np.array([0.05, 0.3, 0.9])


def steps_on_flat(wall, spacing):
    flat, points = RoughSphere(np.inf, ROUGH), round(32 / spacing)
    atoms = substrate(
        "Cu", (points, points), flat, spacing=spacing, periodic=True, fixed=False
    )
    atoms.calc = RoughContact(flat, 1.0, WALLS[wall])
    return list(load_path(atoms, loads=LOADS, validity="ignore"))


@pytest.mark.parametrize(
    "rows, periodic, sides",
    [
        (["...", ".x.", "..."], False, 4),
        (["...", "xx.", "..."], False, 6),
        (["...", "xxx", "..."], True, 6),
        (["...", "xxx", "..."], False, 8),
        (["xxx", "xxx", "xxx"], True, 0),
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


def test_area_under_a_wall_of_finite_stiffness_needs_no_correction():
    for step in steps_on_flat("repulsive", 1.0):
        assert step.perimeter > 0.0
        assert step.continuum_area == step.contact_area
