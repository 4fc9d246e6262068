"""Grids of squares for pixels that are none."""

import pytest

from ase_roughcontact.topography.square_grid import SquareGrid


@pytest.mark.parametrize(
    ("shape", "spacing", "expected", "strain"),
    [
        ((64, 48), (2.0, 2.0), (64, 48), 0.0),
        ((64, 48), (2.0, 3.0), (64, 72), 0.0),
        ((64, 48), (3.0, 2.0), (96, 48), 0.0),
        # of an interferometer: 1.853393 x 1.854554 µm
        ((960, 600), (1.853393, 1.854554), (960, 600), -6.26e-4),
    ],
)
def test_the_grid_has_the_closer_spacing_and_a_small_strain(
    shape, spacing, expected, strain
):
    grid = SquareGrid.of(shape, spacing)
    assert grid.shape == expected
    assert grid.strain == pytest.approx(strain, abs=1e-6)


@pytest.mark.parametrize("ratio", [0.3, 0.77, 1.0057, 315 / 128])
def test_the_period_along_x_is_kept_and_along_y_but_for_the_strain(ratio):
    shape, spacing = (200, 150), (2.0, 2.0 * ratio)
    grid = SquareGrid.of(shape, spacing)
    assert grid.spacing <= min(spacing) * (1.0 + 1e-9)
    assert grid.shape[0] * grid.spacing == pytest.approx(400.0)
    length = 150 * spacing[1] * (1.0 + grid.strain)
    assert grid.shape[1] * grid.spacing == pytest.approx(length)
    assert abs(grid.strain) < 1.01e-3
