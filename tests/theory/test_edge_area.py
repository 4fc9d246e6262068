"""Contact area of the continuum from the fields at the edge of a hard contact."""

from dataclasses import dataclass

import numpy as np
import pytest

from ase_roughcontact import (
    HardWall,
    HeightMap,
    RoughContact,
    RoughSphere,
    load_path,
    substrate,
)
from ase_roughcontact.elasticity.layer import Layer
from ase_roughcontact.theory import Hertz
from ase_roughcontact.theory.counted_area import continuum_area, open_sides
from ase_roughcontact.theory.edge_area import EdgeArea, edge_area, edge_error
from ase_roughcontact.topography import BoundedSurface


def fields(depth, modulus):
    """Return pressure and gap next to a straight edge, at distances inside."""
    strength = 0.3
    pressure = strength * np.sqrt(depth.clip(0.0))
    gap = 4.0 / 3.0 * strength / modulus * (-depth).clip(0.0) ** 1.5
    return pressure, gap


@pytest.mark.parametrize(
    "shape, normal",
    [((24, 24), n) for n in ((1, 0), (0, 1), (1, 1), (1, 2), (3, -1))]
    + [((25, 35), (1, 0)), ((25, 35), (0, 1))],
)
def test_straight_edges_are_found_between_the_points(shape, normal):
    """Periodic strips at angles to the grid, which wrap around odd windows, too."""
    spacing, modulus, (a, b) = 0.5, 7.0, normal
    period = np.gcd(a * shape[0], b * shape[1])
    lines = a * np.arange(shape[0])[:, None] + b * np.arange(shape[1])
    half = shape[0] * shape[1] * spacing**2 / 2
    errors = []
    for shift in np.arange(0.0, 2.0, 0.1):
        across = (lines - shift + period / 2) % period - period / 2
        depth = (period / 4 - abs(across)) * spacing / np.hypot(a, b)
        pressure, gap = fields(depth, modulus)
        edges = open_sides(pressure > 0.0, True).sum() * spacing
        found = edge_area(pressure, gap, edges, spacing, modulus, periodic=True)
        errors.append((found.area - half) / (edges * spacing))
    # counting errs by up to 0.5, and the mean of counts for curved edges by 0.12
    assert max(map(abs, errors)) < 0.03
    assert abs(np.mean(errors)) < 0.011


def test_full_contact_and_the_correction_by_the_perimeter():
    pressure, gap = np.ones((6, 6)), np.zeros((6, 6))
    full = edge_area(pressure, gap, 0.0, 0.5, 1.0, periodic=True)
    assert full == (9.0, 0.0, 0.0)
    # 0.0158 S_d dx by all points, twice that by every other one
    shifted = edge_area(pressure, gap, 10.0, 0.5, 1.0, periodic=True)
    assert shifted.change == pytest.approx(0.0158 * 10.0 * 0.5)
    assert shifted.area == pytest.approx(9.0 - 0.0158 * 5.0 * (1.0 - 1.0 / 3.0))


def test_error_adds_up_change_perimeter_and_half_a_point():
    expected = 0.25 * 3.0 + 0.006 * 40.0 * 0.5 + 0.125
    found = EdgeArea(area=100.0, change=-3.0)
    assert edge_error(found, 40.0, 0.5) == pytest.approx(expected)
    assert edge_error(found, 40.0, 0.5, 2.0) == pytest.approx(expected)
    coarse = edge_error(found, 40.0, 0.5, 1.9)
    assert coarse == pytest.approx(expected + 0.036 * 40.0 * 0.5)
    punch = edge_error(found._replace(corners=20.0), 40.0, 0.5)
    assert punch == pytest.approx(expected + 0.25 * 20.0 * 0.5)


@pytest.mark.parametrize(
    "radius, error", [(2.0, 0.06), (4.0, 0.02), (8.0, 0.005), (16.0, 0.0015)]
)
def test_smooth_spheres_of_few_points(radius, error):
    """At any contact radius, and within twice the estimate."""
    sphere = RoughSphere(1000.0)
    law = Hertz(sphere.radius, 1.0)
    for offset in (0.0, 0.11, 0.27):
        contact = radius * (1.0 + offset)
        atoms = substrate("Cu", (8, 8), sphere, spacing=1.0, fixed=False)
        atoms.calc = RoughContact(sphere, 1.0, HardWall())
        (step,) = load_path(
            atoms,
            loads=[law.force(contact)],
            window="auto",
            model="continuum",
            refine=1,
            accuracy=1e-6,
        )
        difference = abs(step.continuum_area - np.pi * contact**2)
        assert difference < error * step.continuum_area
        assert difference < 2.0 * step.area_error


def continuum_steps(sphere, spacing, loads, window=None, **solid):
    """Return the steps of a path on a grid, in a free half space of spacing 1."""
    shape = window or (8, 8)
    atoms = substrate("Cu", shape, sphere, spacing=spacing, fixed=False)
    atoms.calc = RoughContact(sphere, interaction=HardWall(), **solid)
    return list(
        load_path(
            atoms,
            loads=loads,
            window="fixed" if window else "auto",
            model="continuum",
            refine=1,
            accuracy=1e-6,
            edge="ignore",
            validity="ignore",
        )
    )


@pytest.mark.parametrize("modulus, load", [(0.1, 20.0), (10.0, 3.0), (10.0, 20.0)])
def test_edge_on_a_layer_has_the_modulus_of_the_layer(modulus, load):
    sphere = RoughSphere(200.0)
    solid = Layer(modulus, 1.0, 1.0)
    coarse, fine = (
        continuum_steps(sphere, spacing, [load], solid=solid)[0]
        for spacing in (1.0, 0.25)
    )
    error = abs(coarse.continuum_area - fine.continuum_area)
    assert error < 2.0 * coarse.area_error
    assert error < 0.02 * fine.continuum_area


def test_area_of_a_lightly_loaded_atom_is_not_negative():
    for load in (1e-8, 1e-4):
        (step,) = continuum_steps(RoughSphere(1000.0), 1.0, [load], contact_modulus=1.0)
        assert step.repulsive_atoms == 1
        assert 0.0 <= step.continuum_area < 2.0 * step.area_error


def test_contact_that_ends_at_the_window_has_no_edge_of_its_own():
    """A flat punch: the correction by the perimeter, as for the model of atoms."""
    heights = np.zeros((16, 16))
    punch = HeightMap(heights, 1.0)
    (step,) = continuum_steps(punch, 1.0, [10.0], (16, 16), contact_modulus=1.0)
    assert step.contact_area == 256.0
    expected = continuum_area(256.0, step.perimeter, 1.0)
    assert step.continuum_area == pytest.approx(expected)


@dataclass(frozen=True)
class Axial(BoundedSurface):
    """Flat punch of a radius, or a cone."""

    radius: float = 0.0
    cone: bool = False

    def heights(self, shape, spacing, origin=(0.0, 0.0)):
        x, y = (o + spacing * np.arange(n) for o, n in zip(origin, shape, strict=True))
        distance = np.hypot(x[:, None], y)
        return 0.05 * distance if self.cone else 1e3 * (distance > self.radius)

    def reach(self, level, spacing, origin=(0.0, 0.0)):
        return max(level, 0.0) / 0.05 if self.cone else self.radius


@pytest.mark.parametrize("radius", [6.0, 6.3, 12.0, 12.4, 24.0])
def test_edge_of_a_flat_punch_is_known_to_half_a_spacing(radius):
    """The pressure rises to the edge, where the equations of the edge do not hold."""
    punch = Axial(radius)
    (step,) = continuum_steps(punch, 1.0, [30.0], (64, 64), contact_modulus=1.0)
    error = abs(step.continuum_area - np.pi * radius**2)
    assert error < 2.0 * step.area_error
    # both are too small by 0.3 to 0.4 of the perimeter without regard to the corner
    assert error < 0.15 * step.perimeter
    assert 0.2 * step.perimeter < step.area_error < 0.4 * step.perimeter


@pytest.mark.parametrize("load", [1.0, 5.0, 30.0])
def test_contact_of_a_cone_has_a_smooth_edge(load):
    """N = E* cot(alpha) a^2 pi/2 (Sneddon), though the pressure is singular inside."""
    area = 2.0 * load / 0.05
    (step,) = continuum_steps(Axial(cone=True), 1.0, [load], contact_modulus=1.0)
    error = abs(step.continuum_area - area)
    assert error < 2.0 * step.area_error < 0.07 * area
