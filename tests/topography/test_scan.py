"""Scans of surfaces: roles, units, files, missing points, tilt, places."""

import gc
import warnings
from unittest.mock import patch

import numpy as np
import pytest
from built import atoms_under
from microscope_files import WITH_MISSING, WRITERS
from scipy.integrate import trapezoid

import ase_roughcontact as rc
from ase_roughcontact.topography.raw_scan import RawScan
from ase_roughcontact.topography.scan_files import SCAN_FORMATS, ScanFormat
from ase_roughcontact.topography.spectrum import statistics

RNG = np.random.default_rng(1)
ROUGH = RNG.standard_normal((12, 9))
# A high bump at (4, 10) and a deeper, wider pit at (15, 8), neither symmetric.
X, Y = np.arange(20.0)[:, None], np.arange(16.0)
SCAN = 3 * np.exp(-((X - 4) ** 2) / 4 - (Y - 10) ** 2 / 9 - 0.1 * (X - 4) * (Y - 10))
SCAN -= 4 * np.exp(-((X - 15) ** 2) / 9 - (Y - 8) ** 2 / 16)


def raw(surface):
    """Heights of a map at all its points."""
    x, y = surface.center
    return surface.heights(surface.shape, surface.spacing[0], (-x, -y))


def untouched(scan, role="substrate", **options):
    options = {"spacing": 1.0, "detrend": "none"} | options
    return rc.HeightMap.from_topography(scan, role, **options)


def pressed(surface):
    """Force and places of the atoms in contact, of a map on a copper surface."""
    atoms = atoms_under(surface, shape=surface.shape)
    atoms.positions[-1, 2] = -raw(surface).min()
    assert rc.NewtonKrylov(atoms, logfile=None).run(fmax=1e-7)
    state = atoms.calc.state(atoms)
    return state.normal_force, state.contact


@pytest.mark.parametrize(
    ("role", "lower_side", "bump"),
    [("substrate", -SCAN, (4, 10)), ("indenter", -SCAN[::-1], (15, 10))],
)
def test_the_bumps_of_a_scan_are_pressed_and_not_its_pits(role, lower_side, bump):
    surface = untouched(SCAN, role)
    np.testing.assert_array_equal(raw(surface), lower_side)
    force, contact = pressed(surface)
    direct, _ = pressed(rc.HeightMap(lower_side, 1.0))
    assert force == pytest.approx(direct, rel=1e-9)
    assert force > 0.0
    assert contact[bump]
    i, j = np.nonzero(contact)
    assert np.hypot(i - bump[0], j - bump[1]).max() < 4.0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"role": "Substrate"}, r"unknown role .* Known: indenter, substrate"),
        ({"role": None}, "unknown role"),
        ({"center": "lowest"}, "unknown center"),
        ({"center": 3.0}, "center must be"),
        ({"center": (1.0, np.nan)}, "center must be"),
        ({"center": (25, 0)}, r"which spans 1\.9 x 1\.5 nm, got \(2\.5, 0\) nm"),
        ({"unit": "inch"}, "unknown unit of length 'inch'"),
        ({"detrend": "tilt"}, "detrend 'tilt'"),
        ({"spacing": None}, "give spacing"),
        ({"scan": np.full((4, 4), np.nan)}, "are missing"),
    ],
)
def test_wrong_arguments_are_refused(options, message):
    with pytest.raises(ValueError, match=message):
        untouched(**{"scan": SCAN} | options)


@pytest.mark.parametrize("role", ["substrate", "indenter"])
@pytest.mark.parametrize("center", ["highest", (4.0, 10.0)])
def test_the_center_is_a_place_on_the_scan(role, center):
    surface = untouched(SCAN, role, center=center)
    assert surface.heights((1, 1), 1.0)[0, 0] == -SCAN[4, 10] == -SCAN.max()
    assert untouched(SCAN, role).center == (10.0, 8.0)  # the middle


def test_the_margin_is_a_length_along_both_axes():
    scan = 0.1 * RNG.standard_normal((20, 9))
    scan[2, 4], scan[10, 7], scan[11, 6] = 4.0, 3.0, 2.0
    options = {"spacing": (1.0, 4.0), "unit": "nm", "center": "highest"}
    assert untouched(scan, **options, margin=8.0).center == (110.0, 240.0)
    with pytest.raises(ValueError, match=r"20 x 36 nm.* 17 nm"):
        untouched(scan, **options, margin=17.0)


@pytest.mark.parametrize(
    ("unit", "angstrom"), [("nm", 10.0), ("µm", 1e4), ("m", 1e10), ("Å", 1.0)]
)
def test_units_are_converted_to_angstrom(unit, angstrom):
    surface = untouched(ROUGH, spacing=(2.0, 3.0), unit=unit, center=(4.0, 6.0))
    assert surface.spacing == pytest.approx((2 * angstrom, 3 * angstrom))
    assert surface.center == pytest.approx((4 * angstrom, 6 * angstrom))
    lowest = surface.lowest(angstrom, (0.0, 0.0))
    assert surface.statistics().rms_height == pytest.approx(ROUGH.std() * angstrom)
    assert lowest <= -ROUGH.max() * angstrom


def test_masked_points_and_nans_are_interpolated_harmonically():
    x, y = np.arange(8.0)[:, None], np.arange(7.0)
    plane = 0.5 * x - 0.25 * y
    mask = np.zeros(plane.shape, bool)
    mask[2:5, 3:5] = mask[0, 6] = True
    nan = np.where(mask, np.nan, plane)
    masked = np.ma.array(np.where(mask, 1e9, plane), mask=mask)
    for scan in (nan, masked):
        filled = raw(untouched(scan))
        inner = (slice(1, -1),) * 2
        np.testing.assert_allclose(filled[inner], -plane[inner], rtol=0, atol=1e-12)
        assert abs(filled[0, 6] + plane[0, 6]) < 0.5


def test_missing_points_of_a_periodic_scan_are_filled_across_its_edge():
    scan = np.ones((4, 4))
    scan[2], scan[0, 0] = 5.0, np.nan
    once, periodic = (raw(untouched(scan, periodic=p))[0, 0] for p in (False, True))
    assert once == pytest.approx(-1.0)
    scan[3] = 5.0
    assert raw(untouched(scan, periodic=True))[0, 0] == pytest.approx(-2.0)
    assert periodic == pytest.approx(-1.0)


@pytest.mark.parametrize(
    ("detrend", "added"),
    [
        ("mean", 7.0),
        ("plane", 3.0 + 0.4 * np.arange(12)[:, None] - 0.7 * np.arange(9)),
        (None, 3.0 + 0.4 * np.arange(12)[:, None] - 0.7 * np.arange(9)),
        ("curvature", 0.1 * (np.arange(12.0)[:, None] - 3) ** 2 + 0.2 * np.arange(9.0)),
        ("lines", np.sin(np.arange(9)) + np.arange(12)[:, None] * np.cos(np.arange(9))),
    ],
)
def test_detrending_subtracts_what_its_name_says(detrend, added):
    def kept(scan):
        return raw(untouched(scan, detrend=detrend))

    np.testing.assert_allclose(kept(ROUGH + added), kept(ROUGH), rtol=0, atol=1e-11)
    holes = added + np.zeros_like(ROUGH)
    holes[:6, ::2] = holes[9:, 1] = np.nan
    np.testing.assert_allclose(kept(holes), 0.0, atol=1e-11)


def test_the_curvature_has_no_terms_of_third_order():
    x, y = np.arange(12.0)[:, None] - 5.5, np.arange(9.0) - 4.0
    cubic = x * (y**2 - np.mean(y**2))  # orthogonal to all terms of second order
    kept, whole = (raw(untouched(cubic, detrend=d)) for d in ("curvature", "none"))
    np.testing.assert_allclose(kept, whole, rtol=0, atol=1e-11)


def test_a_topography_object_has_its_own_sizes_unit_period_and_mask(topography):
    mask = np.zeros(ROUGH.shape, bool)
    mask[3, 3] = True
    scan = topography.Topography(np.ma.array(ROUGH, mask=mask), (24.0, 27.0), unit="nm")
    got = rc.HeightMap.from_topography(scan, "substrate", detrend="none")
    expected = untouched(np.where(mask, np.nan, ROUGH), spacing=(2.0, 3.0), unit="nm")
    assert got == expected
    assert not got.periodic
    periodic = topography.Topography(ROUGH, (24.0, 27.0), periodic=True, unit="µm")
    assert rc.HeightMap.from_topography(periodic, "indenter").periodic


def test_lengths_have_the_given_unit_or_the_unit_of_the_scan(topography):
    scan = topography.Topography(ROUGH, (24.0, 27.0))
    with pytest.raises(ValueError, match="give unit"):
        rc.HeightMap.from_topography(scan, "substrate")
    got = rc.HeightMap.from_topography(scan, "substrate", unit="nm", detrend="none")
    assert got == untouched(ROUGH, spacing=(2.0, 3.0), unit="nm")
    line = topography.UniformLineScan(ROUGH[0], 9.0)
    with pytest.raises(ValueError, match="map of heights"):
        rc.HeightMap.from_topography(line, "substrate")
    scan = topography.Topography(ROUGH, (24.0, 27.0), unit="nm")
    got = rc.HeightMap.from_topography(
        scan, "substrate", unit="µm", detrend="none", center=(0.004, 0.006)
    )
    expected = untouched(ROUGH, spacing=(2.0, 3.0), unit="nm", center=(4.0, 6.0))
    assert got.todict() == expected.todict() | {"center": pytest.approx((40.0, 60.0))}


@pytest.mark.parametrize("missing", [False, True])
@pytest.mark.parametrize("name", WRITERS)
def test_files_have_the_units_axes_and_missing_points_of_their_format(
    tmp_path, topography, name, missing
):
    heights = ROUGH.copy()
    if missing:
        if name not in WITH_MISSING:
            pytest.skip("the format has no missing points")
        heights[3, 5] = np.nan
    WRITERS[name](tmp_path / name, heights, (2.0, 3.0))
    got = untouched(tmp_path / name, spacing=None)
    expected = untouched(heights, spacing=(2.0, 3.0), unit="nm")
    assert got.spacing == pytest.approx((20.0, 30.0), rel=1e-6)
    window = {"shape": (12, 5), "spacing": 20.0, "origin": (-120.0, -120.0)}
    np.testing.assert_allclose(
        got.heights(**window), expected.heights(**window), rtol=0, atol=2e-3
    )


HEADER = """# Channel: Height
# Width: 24.0 nm
# Height: 0.027 µm
# Value units: nm
"""


def matrix(heights, delimiter=" "):
    rows = (delimiter.join(f"{z:.17g}" for z in line) for line in heights.T)
    return "\n".join(rows) + "\n"


@pytest.mark.parametrize("delimiter", [" ", ",", ", ", "\t", ";"])
@pytest.mark.parametrize("mark", ["# ", ""], ids=["comment", "plain"])
def test_text_files_have_lines_of_constant_y_and_sizes_in_the_header(
    tmp_path, delimiter, mark
):
    file = tmp_path / "scan.txt"
    file.write_text(HEADER.replace("# ", mark) + matrix(ROUGH, delimiter))
    got = rc.HeightMap.from_topography(str(file), "substrate", detrend="none")
    assert got.spacing == pytest.approx((20.0, 30.0))
    window = got.heights((12, 9), 20.0, (-120.0, -120.0))[:, ::3]
    np.testing.assert_allclose(window, -10 * ROUGH[:, :6:2], rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    "text",
    [
        "0,5;1;NaN\n-2,5;3;4e-1\n",
        "0,5\t1\t\n-2,5\t3\t4e-1\n",
        "0,5 1 --\n-2,5 3 4e-1\n",
        "0.5,1,\n-2.5,3,4e-1\n",
        "0.5;1;BAD;\n-2.5;3;4e-1;\n",
    ],
)
def test_decimal_commas_and_missing_cells_of_text_are_recognised(tmp_path, text):
    file = tmp_path / "scan.csv"
    header = "Width: 3\nWidth: 7,5 nm\nHeight: 5,0 nm\nValue units: nm\n"
    file.write_text(header + text)
    got = untouched(file, spacing=None)
    assert got.spacing == pytest.approx((25.0, 25.0))
    expected = untouched(
        [[0.5, -2.5], [1.0, 3.0], [np.nan, 0.4]], spacing=2.5, unit="nm"
    )
    np.testing.assert_allclose(raw(got), raw(expected), rtol=0, atol=1e-9)


def test_a_spacing_that_differs_from_the_file_is_reported(tmp_path):
    file = tmp_path / "scan.txt"
    file.write_text("# Width: 10 nm\n# Height: 10 nm\n# Value units: nm\n0 1\n2 3\n")
    with pytest.warns(UserWarning, match=r"2 x 2 nm .* 5 x 5 nm"):
        assert untouched(file, spacing="2 nm").spacing == pytest.approx((20.0, 20.0))
    assert untouched(file, spacing="5.02 nm").spacing[0] == pytest.approx(50.2)


def test_sizes_of_an_exchanged_file_are_exchanged_with_its_heights(tmp_path):
    file = tmp_path / "scan.txt"
    file.write_text("# Width: 9 nm\n# Height: 4 nm\n# Value units: nm\n0 1 5\n2 3 8\n")
    given, turned = (untouched(file, spacing=None, transpose=k) for k in (False, True))
    assert given.spacing == turned.spacing[::-1] == pytest.approx((30.0, 20.0))
    assert given.shape == turned.shape[::-1] == (3, 2)


def test_text_without_header_needs_unit_and_spacing(tmp_path):
    file = tmp_path / "scan.txt"
    file.write_text("# nothing about lengths\n" + matrix(ROUGH))
    with pytest.raises(ValueError, match=r"scan\.txt.* give unit"):
        rc.HeightMap.from_topography(file, "substrate")
    np.save(tmp_path / "scan.npy", ROUGH)
    options = {"spacing": (2.0, 3.0), "unit": "nm"}
    for each in (file, tmp_path / "scan.npy"):
        assert untouched(each, **options) == untouched(ROUGH, **options)


def test_a_list_of_points_becomes_a_map_whatever_its_order(tmp_path):
    x, y = 0.5 * np.arange(12), 2.0 + 0.25 * np.arange(9)
    points = np.array([(x[i], y[j], ROUGH[i, j]) for i in range(12) for j in range(9)])
    points = RNG.permutation(points[:-1])  # one is missing
    file = tmp_path / "scan.xyz"
    np.savetxt(file, points, header="x y z, units: nm")
    got = untouched(file, spacing=None)
    assert got.shape == (12, 9)
    assert got.spacing == pytest.approx((5.0, 2.5))
    np.testing.assert_allclose(
        got.heights((12, 1), 5.0, (-30.0, 0.0))[:, 0], -10 * ROUGH[:, 4], rtol=1e-12
    )


def test_points_that_are_not_on_a_grid_are_refused(tmp_path):
    file = tmp_path / "scan.xyz"
    np.savetxt(file, RNG.uniform(size=(40, 3)))
    with pytest.raises(ValueError, match="along x: interpolate"):
        untouched(file, spacing=None, unit="nm")


@pytest.mark.parametrize(
    ("name", "content", "cause"),
    [
        ("empty.txt", b"", "no rows of numbers"),
        ("words.txt", b"high low\n", "no rows of numbers"),
        ("ragged.txt", b"1 2\n3\n", "different numbers of columns"),
        ("text.txt", b"x\n1 2\n3 4\n5 ?\n", r"line 4 .*'5 \?'"),
        ("column.txt", b"0 0 1\n0 1 1\n0 2 3\n0 3 4\n", "all points have the same x"),
        ("not.npy", b"1 2\n3 4\n", ""),
        ("empty.npy", b"", ""),
        ("absent.npy", None, "No such file"),
        ("absent.ibw", None, "no such file"),
        ("binary.dat", b"\x93\xff\xfe\x00", ""),
        ("broken.gwy", b"GWYP\x00", ""),
    ],
)
def test_an_unreadable_file_is_refused_by_name(
    tmp_path, topography, name, content, cause
):
    if content is not None:
        (tmp_path / name).write_bytes(content)
    message = f"cannot read a scan from .*{name}.*{cause}"
    with pytest.raises(ValueError, match=message):
        untouched(tmp_path / name, unit="nm")


@pytest.mark.parametrize("hurst", [0.5, 0.8])
@pytest.mark.parametrize("periodic", [True, False])
def test_self_affine_parameters_of_a_scan_agree_with_its_surface(hurst, periodic):
    rough = rc.SelfAffine(0.1, hurst, 4.0, 128.0, seed=2)
    side = int(rough.side)
    heights = rough.heights((side, side), 1.0)
    scan = -heights if periodic else -heights[: side // 2, : side // 2]
    fit = untouched(scan, periodic=periodic).self_affine
    assert fit.hurst == pytest.approx(hurst, abs=0.08)
    if periodic:
        exact = vars(rough.statistics())
        assert vars(statistics(heights, 1.0)) == pytest.approx(exact)
        # pressed are splines, between four points on the shortest wave
        pressed = {name: vars(fit)[name] for name in exact}
        assert pressed == pytest.approx(exact, rel=3e-3)
        assert fit.short_wavelength == pytest.approx(4.0, rel=0.01)
        assert fit.long_wavelength == pytest.approx(128.0, rel=0.07)


def test_a_flat_scan_has_no_self_affine_parameters():
    with pytest.raises(ValueError, match="flat map"):
        _ = untouched(np.zeros((8, 8))).rms_slope


def test_the_spectrum_of_a_scan_that_is_not_periodic_has_its_mean_square():
    rough = rc.SelfAffine(0.1, 0.8, 4.0, 32.0, seed=3)
    scan = untouched(rough.heights((128, 100), 1.0), spacing=(1.0, 1.0))
    q, density = scan.power_spectrum()
    # sum over all wave vectors: each ring has about 2 pi q dq / (2 pi)^2 A
    square = trapezoid(q * density, q) / (2 * np.pi)
    assert square == pytest.approx(scan.statistics().rms_height ** 2, rel=0.15)


def test_files_of_netcdf_are_closed_without_a_warning(tmp_path, topography):
    scan = np.ma.masked_equal(SCAN, SCAN[1, 1])
    topography.Topography(scan, SCAN.shape, unit="nm").to_netcdf(
        str(tmp_path / "scan.nc")
    )
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        rc.HeightMap.from_topography(tmp_path / "scan.nc", "substrate")
        gc.collect()
    assert not [each for each in found if "netcdf" in str(each.message)]


@pytest.mark.parametrize("ending", ["gz", "bz2", "xz"])
def test_a_compressed_text_is_the_text(tmp_path, ending):
    np.savetxt(tmp_path / "scan.txt", SCAN)
    np.savetxt(tmp_path / f"scan.txt.{ending}", SCAN)
    plain, compressed = (
        rc.HeightMap.from_topography(tmp_path / name, "substrate", unit="nm", spacing=1)
        for name in ("scan.txt", f"scan.txt.{ending}")
    )
    assert plain == compressed


@pytest.mark.parametrize("height", [1e300, 1e308, -1e31])
@pytest.mark.parametrize("detrend", ["plane", "none", "lines"])
def test_heights_that_are_no_heights_are_refused(height, detrend):
    scan = SCAN.copy()
    scan[1, 1] = height
    with pytest.raises(ValueError, match=r"above 1e\+30"):
        rc.HeightMap.from_topography(scan, "substrate", spacing=1, detrend=detrend)
    with pytest.raises(ValueError, match=r"above 1e\+30"):
        rc.HeightMap(scan, 1.0)


def test_a_format_of_ones_own_is_read_like_a_format_of_the_package(tmp_path):
    def read(path, channel):
        return RawScan(np.fromfile(path).reshape(SCAN.shape), (1.0, 1.0), "nm")

    own = ScanFormat(lambda path: path.suffix == ".mine", read)
    SCAN.tofile(file := tmp_path / "scan.mine")
    with patch.dict(SCAN_FORMATS, mine=own):
        surface = rc.HeightMap.from_topography(file, "substrate", detrend="none")
    np.testing.assert_allclose(raw(surface), -10.0 * SCAN)
