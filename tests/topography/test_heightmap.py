"""Height maps: interpolation, files, lowest heights, errors."""

import numpy as np
import pytest

from ase_roughcontact import HardWall, PlasticWall, Problem, SelfAffine
from ase_roughcontact.elasticity import Isotropic
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.topography import HeightMap, RoughSphere
from ase_roughcontact.topography.spectrum import (
    power_spectrum,
    smooth_component,
    statistics,
)

BUMPS = np.random.default_rng(0).standard_normal((9, 12))


def test_a_map_returns_its_heights_exactly_at_its_own_points():
    values = BUMPS.copy()
    surface = HeightMap(values, 0.3)
    values += 1.0  # which the map does not share
    window = surface.heights((9, 12), 0.3, (-4 * 0.3, -6 * 0.3))
    np.testing.assert_array_equal(window, BUMPS)


def test_a_periodic_map_wraps():
    window = HeightMap(BUMPS, 1.0, periodic=True).heights((9, 12), 1.0)
    np.testing.assert_array_equal(window, np.roll(BUMPS, (-4, -6), (0, 1)))


def test_interpolation_reproduces_cubic_polynomials():
    x, y = np.arange(-4.0, 5.0)[:, None], np.arange(-4.0, 5.0)[None, :]
    window = HeightMap(x**3 * y**2 - 2 * y**3, 1.0).heights((3, 3), 0.7, (-1.2, 0.4))
    x, y = -1.2 + 0.7 * np.arange(3)[:, None], 0.4 + 0.7 * np.arange(3)[None, :]
    np.testing.assert_allclose(window, x**3 * y**2 - 2 * y**3, rtol=0, atol=1e-11)


def test_a_periodic_map_is_smooth_across_its_edge():
    x = 2 * np.pi / 64 * np.arange(64)
    values = np.sin(x[:, None]) * np.cos(2 * x)
    x, y = 31.6 + 0.66 * np.arange(10), -34.4 + 0.66 * np.arange(10)
    window = HeightMap(values, 1.0, periodic=True).heights((10, 10), 0.66, (x[0], y[0]))
    x, y = 2 * np.pi / 64 * (x + 32), 2 * np.pi / 64 * (y + 32)
    exact = np.sin(x[:, None]) * np.cos(2 * y)
    np.testing.assert_allclose(window, exact, rtol=0, atol=1e-4)


def test_a_map_describes_itself_without_its_heights():
    description = HeightMap(BUMPS, 0.3).todict()
    assert description["shape"] == (9, 12)
    assert description["spacing"] == (0.3, 0.3)
    assert description["center"] == pytest.approx((1.2, 1.8))
    assert description["periodic"] is False
    assert len(description["sha256"]) == 16
    for other in (
        HeightMap(BUMPS + 1, 0.3),
        HeightMap(BUMPS, 0.4),
        HeightMap(BUMPS, 0.3, center=(0.0, 0.0)),
    ):
        assert HeightMap(BUMPS, 0.3) != other


def test_a_map_has_its_own_spacing_along_x_and_y():
    x, y = 0.5 * np.arange(-4, 5)[:, None], 0.2 * np.arange(-6, 6)
    surface = HeightMap(x**2 + x * y, (0.5, 0.2))
    window = surface.heights((3, 3), 0.3, (-1.0, -0.4))
    x, y = -1.0 + 0.3 * np.arange(3)[:, None], -0.4 + 0.3 * np.arange(3)
    np.testing.assert_allclose(window, x**2 + x * y, rtol=0, atol=1e-13)
    assert surface.extent == pytest.approx(1.0)
    assert repr(surface) == "HeightMap(9 x 12, (0.5, 0.2), periodic=False)"


def test_the_center_of_a_map_is_on_the_axis():
    surface = HeightMap(BUMPS, 0.5, center=(1.0, 4.5))
    assert surface.heights((1, 1), 0.5)[0, 0] == BUMPS[2, 9]
    assert surface.extent == pytest.approx(1.0)
    assert surface.lowest(0.5) == BUMPS.min()
    with pytest.raises(ValueError, match=r"y = -1 to 1\.5, .* -4\.5 to 1"):
        surface.heights((1, 6), 0.5, (0.0, -1.0))


@pytest.mark.parametrize(
    ("options", "shape", "spacing", "message"),
    [
        ({"center": (8.5, 0.0)}, (1, 1), 1.0, r"x = 0 to 8, got 8\.5"),
        ({}, (6, 2), 1.0, "x = 0 to 5, .* -4 to 4"),
        ({"periodic": True}, (10, 2), 1.0, "10 along x .* period 9"),
        ({"heights": BUMPS[:3]}, (2, 2), 0.3, "at least 4 x 4 points, got 3 along"),
    ],
)
def test_windows_that_do_not_fit_are_refused_with_the_numbers(
    options, shape, spacing, message
):
    with pytest.raises(ValueError, match=message):
        HeightMap(**{"heights": BUMPS, "spacing": 1.0} | options).heights(
            shape, spacing
        )


@pytest.mark.parametrize("repeats", [False, True], ids=["once", "periodic"])
@pytest.mark.parametrize("spacing", [1.0, 2.0, 0.5, 0.3])
def test_no_height_of_a_map_is_below_its_lowest_height(repeats, spacing):
    values = np.random.default_rng(4).uniform(-1.0, 1.0, (12, 10))
    surface = HeightMap(values, 1.0, periodic=repeats)
    heights = surface.heights((5, 5), spacing, (-2 * spacing, -2 * spacing))
    assert surface.lowest(spacing) <= heights.min()
    assert (surface.lowest(spacing) == values.min()) == (spacing in (1.0, 2.0))
    assert surface.extent == (5.0 if repeats else 4.0)


def test_masked_points_are_missing_points():
    lowest = BUMPS.min() >= BUMPS
    heights = np.ma.masked_less(np.where(lowest, -9999.0, BUMPS), -999.0)
    assert HeightMap(np.ma.array(BUMPS), 1.0) == HeightMap(BUMPS, 1.0)
    calls = HeightMap, power_spectrum, statistics, smooth_component
    for call, options in zip(calls, [(1.0,), (1.0,), (1.0,), ()], strict=True):
        with pytest.raises(ValueError, match=r"got 1 .*masked"):
            call(heights, *options)


def test_an_indenter_with_masked_heights_is_refused():
    class Holed(RoughSphere):
        def heights(self, shape, spacing, origin=(0.0, 0.0)):
            return np.ma.masked_less(super().heights(shape, spacing, origin), 0.01)

    problem = Problem(Holed(50.0), Isotropic(1.0), HardWall(), spacing=2.0)
    with pytest.raises(ValueError, match="masked"):
        problem.heights(Box((-4, -4), (8, 8)))


@pytest.mark.parametrize(
    ("call", "name"),
    [
        (lambda bad: HeightMap(BUMPS, 1.0, bad), "periodic"),
        (lambda bad: from_scan(periodic=bad), "periodic"),
        (lambda bad: from_scan(transpose=bad), "transpose"),
        (lambda bad: from_scan(remove_outliers=bad), "remove_outliers"),
        (lambda bad: SelfAffine(0.1, 0.8, 4.0, 8.0, random_amplitudes=bad), "random_"),
        (lambda bad: PlasticWall(1.0, permanent=bad), "permanent"),
        (
            lambda bad: Problem(
                RoughSphere(50.0), Isotropic(1.0), HardWall(), 2.0, periodic=bad
            ),
            "periodic",
        ),
    ],
)
@pytest.mark.parametrize("bad", ["abc", 2, None, []])
def test_switches_are_true_or_false(call, name, bad):
    if name == "periodic" and bad is None:
        bad = "no"  # none is the default of scans
    with pytest.raises(ValueError, match=f"{name}.* must be true or false"):
        call(bad)


def from_scan(**options):
    return HeightMap.from_topography(BUMPS, "substrate", spacing=1.0, **options)
