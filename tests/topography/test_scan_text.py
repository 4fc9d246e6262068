"""Texts of scans: headers, points, cells that are missing, and formats that mislead."""

import gzip

import numpy as np
import pytest

from ase_roughcontact import HeightMap

RNG = np.random.default_rng(4)
HEIGHTS = RNG.standard_normal((8, 6))
LINE, ROW = (each.ravel() for each in np.indices(HEIGHTS.shape))
POINTS = np.stack([0.5 * LINE, 2.0 + 0.25 * ROW, HEIGHTS.ravel()], axis=1)


def read(path, **options):
    return HeightMap.from_topography(path, "substrate", detrend="none", **options)


def lower_side(surface):
    """Heights at the points of a map with squares as pixels (nm)."""
    x, y = surface.center
    return -surface.heights(surface.shape, surface.spacing[0], (-x, -y)) / 10.0


HOLOGRAPHIC = """h=6 w=8
pixel size=3.0e-007 m
data unit=rad
height conversion factor (-> m)=2.0e-008
"""


def test_scales_in_the_header_of_a_holographic_microscope_are_used(
    tmp_path, topography
):
    file = tmp_path / "dhm.txt"
    lines = "\n".join(" ".join(f"{z:.9f}" for z in line) for line in HEIGHTS.T)
    file.write_text(HOLOGRAPHIC + lines)
    surface = read(file)
    assert surface.spacing == pytest.approx((3e3, 3e3))
    np.testing.assert_allclose(lower_side(surface), 20.0 * HEIGHTS, atol=1e-6)
    packed = tmp_path / "dhm.txt.gz"
    packed.write_bytes(gzip.compress(file.read_bytes()))
    assert read(packed).spacing == pytest.approx((3e3, 3e3))


def test_scales_that_are_not_understood_are_a_warning(tmp_path):
    file = tmp_path / "other.txt"
    np.savetxt(file, HEIGHTS.T, header="Pixel factor: 2.5")
    with pytest.warns(UserWarning, match=r"'# Pixel factor: 2\.5'.* scale them"):
        read(file, spacing=1.0, unit="nm")


@pytest.mark.parametrize(
    ("name", "width", "height"),
    [("Channel", "Width", "Height"), ("Kanal", "Breite", "Höhe")],
)
@pytest.mark.parametrize("columns", [4, 3])
def test_a_gwyddion_export_has_its_sizes_in_english_and_german(
    tmp_path, topography, name, width, height, columns
):
    heights = np.resize(HEIGHTS, (columns, 6))
    file = tmp_path / "scan.txt"
    head = f"{name}: Z\n{width}: {columns}.0 µm\n{height}: 6000.0 nm\nValue units: nm"
    np.savetxt(file, heights.T, header=head, encoding="utf-8")
    surface = read(file)  # three columns are no list of points, either
    assert surface.spacing == pytest.approx((1e4, 1e4))
    np.testing.assert_allclose(lower_side(surface), heights, atol=1e-6)


def test_an_infinite_height_is_a_missing_point(tmp_path):
    heights = HEIGHTS.copy()
    heights[2, 3] = np.inf
    np.savetxt(tmp_path / "scan.txt", heights.T)
    surface = read(tmp_path / "scan.txt", spacing=1.0, unit="nm")
    assert surface.measurement.missing == 1
    known = np.isfinite(heights)
    np.testing.assert_allclose(lower_side(surface)[known], HEIGHTS[known])


@pytest.mark.parametrize("absent", [[4], [1, 2, 6]])
def test_absent_lines_of_a_list_of_points_are_missing(tmp_path, absent):
    points = POINTS[~np.isin(LINE, absent)]
    np.savetxt(tmp_path / "scan.xyz", points)
    surface = read(tmp_path / "scan.xyz", unit="nm")
    assert surface.shape == HEIGHTS.shape
    assert surface.spacing == pytest.approx((5.0, 2.5))
    assert surface.measurement.missing == 6 * len(absent)


def test_places_with_few_digits_are_on_a_grid(tmp_path):
    points = POINTS.copy()
    points[:, :2] = np.round(points[:, :2] / 0.35 * 1.2345, 2)
    np.savetxt(tmp_path / "scan.xyz", points, fmt="%.4g")
    surface = read(tmp_path / "scan.xyz", unit="nm")
    assert surface.spacing[0] == pytest.approx(5.0 / 0.35 * 1.2345, rel=2e-3)
    assert surface.measurement.missing == 0


def test_places_listed_twice_with_two_heights_are_refused(tmp_path):
    again = POINTS + np.array([0.0, 0.0, 5.0])
    np.savetxt(tmp_path / "scan.xyz", np.concatenate([POINTS, again]))
    with pytest.raises(ValueError, match=r"48 points .* by up to 5:"):
        read(tmp_path / "scan.xyz", unit="nm")
    np.savetxt(tmp_path / "scan.xyz", np.concatenate([POINTS, POINTS]))
    assert read(tmp_path / "scan.xyz", unit="nm").shape == HEIGHTS.shape


def test_numbers_of_points_in_the_first_column_are_left_out(tmp_path):
    np.savetxt(tmp_path / "scan.txt", np.c_[1 : len(POINTS) + 1, POINTS])
    np.savetxt(tmp_path / "scan.xyz", POINTS)
    numbered, plain = (read(tmp_path / f"scan{k}", unit="nm") for k in (".txt", ".xyz"))
    assert numbered == plain


def test_numbers_of_rows_before_a_matrix_are_refused(tmp_path):
    np.savetxt(tmp_path / "scan.txt", np.c_[np.arange(6), HEIGHTS.T])
    with pytest.raises(ValueError, match=r"first column .*\(0, 1,"):
        read(tmp_path / "scan.txt", spacing=1.0, unit="nm")


def test_units_of_places_and_of_heights_may_differ(tmp_path):
    head = "Lateral units: µm\nValue units: nm"
    np.savetxt(tmp_path / "scan.xyz", POINTS, header=head, encoding="utf-8")
    surface = read(tmp_path / "scan.xyz")
    assert surface.spacing == pytest.approx((5e3, 2.5e3))
    assert surface.statistics().rms_height == pytest.approx(10 * HEIGHTS.std())


def test_sizes_are_used_if_only_the_unit_of_the_heights_is_missing(tmp_path):
    head = "Width: 16 nm\nHeight: 0.006 µm"
    np.savetxt(tmp_path / "scan.txt", HEIGHTS.T, header=head, encoding="utf-8")
    surface = read(tmp_path / "scan.txt", unit="pm")
    assert surface.spacing == pytest.approx((20.0, 10.0))
    assert surface.statistics().rms_height == pytest.approx(0.01 * HEIGHTS.std())


def test_decimal_commas_between_commas_are_refused(tmp_path):
    rows = (",".join(f"{z:.4f}".replace(".", ",") for z in row) for row in HEIGHTS)
    (tmp_path / "scan.csv").write_text("\n".join(rows))
    with pytest.raises(ValueError, match="export the scan with another separator"):
        read(tmp_path / "scan.csv", spacing=1.0, unit="nm")


def test_whole_numbers_between_commas_are_heights(tmp_path):
    counts = RNG.integers(0, 255, size=(8, 6))
    np.savetxt(tmp_path / "scan.csv", counts.T, fmt="%d", delimiter=",")
    surface = read(tmp_path / "scan.csv", spacing=1.0, unit="nm")
    np.testing.assert_allclose(lower_side(surface), counts, atol=1e-9)


def test_a_line_along_which_nothing_was_measured_is_no_end_of_rows(tmp_path):
    heights = HEIGHTS.copy()
    heights[-1] = np.nan
    head = "Width: 16 nm\nHeight: 6 nm\nValue units: nm"
    np.savetxt(tmp_path / "scan.csv", heights.T, header=head, delimiter=",")
    surface = read(tmp_path / "scan.csv")
    assert surface.shape == HEIGHTS.shape
    assert surface.spacing == pytest.approx((20.0, 10.0))


def test_an_unknown_format_is_refused_in_one_line(tmp_path, topography):
    (tmp_path / "scan.abc").write_bytes(bytes(range(256)))
    with pytest.raises(ValueError, match="export the scan as text") as error:
        read(tmp_path / "scan.abc")
    assert "\n" not in str(error.value)
    assert len(str(error.value)) < 300
