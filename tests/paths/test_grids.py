"""Grid of the continuum for a wanted error of the area."""

import pytest

import ase_roughcontact as rc
from ase_roughcontact.paths.accuracy import grid_for

SOFT = rc.LennardJones93.repulsive(1.0, 1.0)
ADHESIVE = rc.DugdaleWall(0.01, 0.5)


def spacing(error, wave=4.0, wall=SOFT, domain=64.0, shape=None):
    """Return the spacing of the grid in units of that of the atoms."""
    rough = rc.SelfAffine(0.1, 0.8, wave, max(wave, 32.0), domain=domain)
    return grid_for(error, rc.RoughSphere(100.0, rough), wall, 1.0, shape).spacing(1.0)


@pytest.mark.parametrize(
    "error, points",
    [(0.05, 4), (0.049, 8), (0.01, 8), (0.002, 16), (0.001, 32), (0.0005, 64)],
)
def test_smaller_errors_need_more_points_on_the_shortest_wave(error, points):
    assert spacing(error) == 4.0 / points


def test_errors_below_the_smallest_are_not_attempted():
    with pytest.raises(ValueError, match="at least"):
        spacing(0.0004)


@pytest.mark.parametrize(
    "wall, largest", [(rc.HardWall(), 8), (SOFT, 2), (ADHESIVE, 1)]
)
def test_grids_are_coarser_only_as_far_as_the_wall_is_resolved(wall, largest):
    assert spacing(0.05, wave=64.0, wall=wall) == largest


@pytest.mark.parametrize("domain, coarsest", [(128.0, 8), (132.0, 4), (130.0, 2)])
def test_coarser_grids_divide_the_period_of_the_roughness(domain, coarsest):
    assert spacing(0.05, wave=32.0, wall=rc.HardWall(), domain=domain) == coarsest


@pytest.mark.parametrize("shape, coarsest", [((64, 96), 8), ((64, 100), 4), (None, 8)])
def test_coarser_grids_divide_a_fixed_window(shape, coarsest):
    assert spacing(0.05, wave=32.0, wall=rc.HardWall(), shape=shape) == coarsest
