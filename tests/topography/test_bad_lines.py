"""Bad lines of scans: found, named, and mended on request."""

import warnings

import numpy as np
import pytest

from ase_roughcontact import HeightMap, SelfAffine
from ase_roughcontact.topography.bad_lines import BadLines
from ase_roughcontact.topography.measurement import ScanWarning

SIZE = 128
WHOLE = SelfAffine(0.1, 0.8, 16.0, 64.0, seed=3, domain=SIZE).heights((SIZE, SIZE), 1.0)
HIGH = 5.0 * WHOLE.std()


def with_zeros(scan):
    scan[:, 30:33] = 0.0


def with_copies(scan):
    scan[:, 50:52] = scan[:, 49:50]


def with_offset(scan):
    scan[:, 70] += HIGH


def with_scars(scan):
    scan[40:60, 30] += HIGH
    scan[80:110, 77:79] -= HIGH


def aborted(scan):
    scan[:, 96:] = 0.0


def aborted_with_copies(scan):
    scan[:, 96:] = scan[:, 95:96]


def begun_late(scan):
    scan[:, :20] = scan[:, 20:21]


FAULTS = {
    with_zeros: "all heights equal: lines 30-32",
    with_copies: "the same as the line before: lines 50-51",
    with_offset: "offset from both neighbours: line 70",
    with_scars: "scars, .*: lines 30, 77-78",
    aborted: "only lines 0 to 95 of 128 were measured",
    aborted_with_copies: "only lines 0 to 95 of 128 were measured",
    begun_late: "only lines 20 to 127 of 128 were measured",
}


# Lines that are left of aborted scans.
LEFT = {aborted: slice(96), aborted_with_copies: slice(96), begun_late: slice(20, SIZE)}


def scanned(heights, **options):
    options = {"spacing": 1.0, "detrend": "none"} | options
    return HeightMap.from_topography(heights, "substrate", **options)


def lower_side(surface):
    x, y = surface.center
    return surface.heights(surface.shape, 1.0, (-x, -y))


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_named_with_its_lines(fault):
    scan = WHOLE.copy()
    fault(scan)
    with pytest.warns(ScanWarning, match=FAULTS[fault]):
        scanned(scan)


@pytest.mark.parametrize("fault", FAULTS)
def test_a_removed_fault_leaves_the_surface_and_no_warning(fault):
    scan = WHOLE.copy()
    fault(scan)
    mended = scanned(scan, remove_bad_lines=True)
    kept = {
        aborted: slice(96),
        aborted_with_copies: slice(96),
        begun_late: slice(20, 128),
    }
    whole = -WHOLE[:, kept.get(fault, slice(SIZE))]
    assert mended.shape == whole.shape
    # Laplace's equation across three lines of waves of 16 points and more
    assert abs(lower_side(mended) - whole).max() < 0.15 * whole.std()
    slopes = [each.statistics().rms_slope for each in (mended, scanned(-whole))]
    assert slopes[0] == pytest.approx(slopes[1], rel=0.01)


@pytest.mark.parametrize("hurst", [0.3, 0.8])
@pytest.mark.parametrize("points", [0.0, 0.05])
@pytest.mark.parametrize("lines", [0.0, 0.1])
def test_rough_and_noisy_surfaces_have_no_bad_lines(hurst, points, lines):
    rng = np.random.default_rng(1)
    for seed in range(3):
        rough = SelfAffine(0.1, hurst, 4.0, 64.0, seed=seed, domain=SIZE)
        scan = rough.heights((SIZE, SIZE), 1.0)
        scan = scan + points * rng.standard_normal(scan.shape)
        scan = scan + lines * rng.standard_normal(SIZE)
        found = BadLines.of(scan)
        assert list(found.described()) == []
        assert not found.mask.any()


@pytest.mark.parametrize("axis", [0, 1])
def test_gratings_and_steps_have_no_bad_lines(axis):
    wave = np.sin(np.arange(64) / 3.0) + np.zeros((64, 1))
    step = WHOLE + HIGH * (np.arange(SIZE) > 60)
    for scan in (wave, step):
        found = BadLines.of(np.moveaxis(scan, axis, 0))
        assert list(found.described()) == []


def test_streaks_across_the_lines_are_no_scars():
    scan = WHOLE.copy()
    with_scars(scan)
    assert list(BadLines.of(scan.T).described()) == []


def test_scars_change_the_slope_and_are_counted_point_by_point():
    scan = WHOLE.copy()
    with_scars(scan)
    assert np.count_nonzero(BadLines.of(scan).mask) == pytest.approx(80, abs=4)
    with pytest.warns(ScanWarning, match="scars"):
        assert scanned(scan).statistics().rms_slope > 0.13
    assert scanned(WHOLE).statistics().rms_slope == pytest.approx(0.1, rel=0.01)


def test_clipped_heights_are_named_and_nothing_mends_them():
    scan = np.minimum(WHOLE, np.quantile(WHOLE, 0.7))
    for remove in (False, True):
        with pytest.warns(ScanWarning, match="30 % .* largest"):
            scanned(scan, remove_bad_lines=remove)
    with pytest.warns(ScanWarning, match="smallest height"):
        scanned(-scan)


def test_heights_of_few_levels_are_not_clipped():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scanned(np.round(WHOLE / WHOLE.std()))


def test_lines_along_the_other_axis_ask_for_an_exchange():
    scan = WHOLE.copy()
    with_zeros(scan)
    with pytest.warns(ScanWarning, match=r"lines 30-32 .*\(transpose\)"):
        scanned(scan.T)


def test_a_periodic_scan_that_was_aborted_cannot_be_mended():
    scan = WHOLE.copy()
    aborted(scan)
    with pytest.raises(ValueError, match="give periodic = false"):
        scanned(scan, remove_bad_lines=True, periodic=True)


def test_medians_of_steps_level_lines_past_a_terrace():
    offsets = np.random.default_rng(2).normal(size=SIZE).cumsum()
    scan = 0.01 * WHOLE + offsets
    scan[:50, 40:90] += 20.0  # on less than half of each line
    medians, lines = (
        -lower_side(scanned(scan, detrend=name)) for name in ("medians", "lines")
    )
    for level, least, most in ((medians, 0.0, 0.3), (lines, 3.0, 20.0)):
        assert least <= abs(np.diff(level, axis=1)[120]).max() <= most


def test_points_that_are_removed_do_not_tilt_the_scan():
    flat = 1e-3 * np.random.default_rng(1).standard_normal((32, 32))
    scan = flat.copy()
    scan[2, 3] += 100.0
    level = scanned(scan, detrend="plane", remove_outliers=True)
    np.testing.assert_allclose(lower_side(level), -flat, atol=5e-3)


def test_features_of_a_small_scan_are_no_scars():
    x, y = np.indices((41, 33)) - 8.0
    for width in (2.0, 4.0, 6.0):
        bump = np.exp(-(x**2 + y**2) / (2.0 * width**2))
        assert list(BadLines.of(bump).described()) == []
