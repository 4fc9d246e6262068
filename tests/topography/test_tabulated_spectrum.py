"""Random surfaces with a power spectrum from a table, and conventions of tables."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import beta

from ase_roughcontact import HeightMap, SelfAffine, TabulatedSpectrum
from ase_roughcontact.topography.spectrum_files import read_spectrum, two_dimensional

SIDE = 128.0
Q = np.geomspace(2 * np.pi / SIDE, 2 * np.pi / 4.0, 40)
HURST = 0.7
C2D = 0.01 * np.maximum(Q, 0.15) ** (-2 - 2 * HURST)
ROUGH = TabulatedSpectrum(Q, C2D, domain=SIDE, seed=4)


def density_of(heights):
    """Return |q| and C(q) of heights on a grid of spacing one, by an FFT."""
    n, m = heights.shape
    q = 2 * np.pi * np.hypot(np.fft.fftfreq(n)[:, None], np.fft.fftfreq(m))
    return q, heights.size * abs(np.fft.fft2(heights, norm="forward")) ** 2


def test_a_surface_has_the_densities_of_its_table():
    q, density = density_of(ROUGH.heights((128, 128), 1.0))
    band = (q > 1.001 * Q[0]) & (q < 0.999 * Q[-1])
    expected = np.exp(np.interp(np.log(q[band]), np.log(Q), np.log(C2D)))
    assert density[band] == pytest.approx(expected, rel=1e-9)
    assert density[q > 1.001 * Q[-1]].max() < 1e-20


def test_random_amplitudes_have_them_on_average_over_seeds():
    random = replace(ROUGH, random_amplitudes=True, normalise="ensemble")
    total = 0.0
    for seed in range(40):
        q, density = density_of(replace(random, seed=seed).heights((128, 128), 1.0))
        band = (q > 1.001 * Q[0]) & (q < 0.999 * Q[-1])
        expected = np.exp(np.interp(np.log(q[band]), np.log(Q), np.log(C2D)))
        total += np.mean(density[band] / expected)
    assert total / 40 == pytest.approx(1.0, abs=0.01)


def test_a_seed_is_the_same_surface_in_all_windows():
    whole = ROUGH.heights((128, 128), 1.0)
    part = ROUGH.heights((20, 30), 1.0, (120.0, -5.0))
    columns = np.arange(-5, 25) % 128
    assert np.array_equal(part, whole[np.arange(120, 140) % 128][:, columns])
    with pytest.raises(ValueError, match="period"):
        ROUGH.heights((129, 8), 1.0)


def test_heights_are_scaled_to_a_given_slope_and_cut_at_a_wavelength():
    cut = replace(ROUGH, rms_slope=0.25, shortest=8.0)
    heights = cut.heights((128, 128), 1.0)
    q, density = density_of(heights)
    assert np.sqrt((q**2 * density).sum()) / 128 == pytest.approx(0.25, rel=1e-12)
    assert density[q > 1.001 * 2 * np.pi / 8.0].max() < 1e-20


def test_theory_has_the_statistics_of_the_spectrum():
    fit, found = ROUGH.self_affine, replace(ROUGH, domain=8 * SIDE).statistics()
    assert fit.hurst == pytest.approx(HURST, abs=0.06)
    assert fit.rms_curvature == pytest.approx(found.rms_curvature, rel=0.01)
    assert ROUGH.expected_height == pytest.approx(found.rms_height, rel=0.03)


#: The same spectrum in each convention, without an end of the power law.
POWER_LAW = 0.01 * Q ** (-2 - 2 * HURST)
OF_PROFILES = POWER_LAW * Q * beta(HURST + 0.5, 0.5) / (2 * np.pi)
TABLES = {
    "C2D": POWER_LAW,
    "q/pi C2D": POWER_LAW * Q / np.pi,
    "C1D": OF_PROFILES,
    "C1D+": 2 * OF_PROFILES,
}


@pytest.mark.parametrize("convention", TABLES)
def test_each_convention_is_the_same_surface(tmp_path, convention):
    power = 4 if convention == "C2D" else 3
    file = tmp_path / "table.csv"
    table = np.stack([10 * Q, TABLES[convention] / 10**power], axis=1)
    np.savetxt(file, table, header=f"q (nm^-1); {convention} (nm{power})", comments="")
    for named in ("", convention):
        q, density = read_spectrum(str(file), named)
        assert q == pytest.approx(Q, rel=1e-12)
        # the spectrum of profiles is inverted to about 1 %
        assert density == pytest.approx(POWER_LAW, rel=0.03)


def test_a_noisy_spectrum_of_profiles_gives_a_positive_one_of_about_its_size():
    noise = np.exp(np.random.default_rng(0).normal(size=len(Q)))
    density = two_dimensional(Q, OF_PROFILES * noise, "C1D")
    assert density.min() > 0.0
    ratio = (Q**2 * density).sum() / (Q**2 * POWER_LAW * noise).sum()
    assert ratio == pytest.approx(1.0, abs=0.5)


def test_the_mean_square_height_is_as_the_convention_says():
    spectrum = replace(ROUGH, domain=16 * SIDE).statistics().rms_height ** 2
    integral = np.trapezoid(Q**2 * C2D, np.log(Q)) / (2 * np.pi)
    assert spectrum == pytest.approx(integral, rel=0.01)


@pytest.mark.parametrize("more", [0.0, 0.02])
def test_the_default_period_has_about_the_rms_height_of_the_table(more):
    rough = TabulatedSpectrum(Q, C2D)
    wider = replace(rough, domain=(1.0 + more) * rough.side)
    integral = np.trapezoid(Q**2 * C2D, np.log(Q)) / (2 * np.pi)
    assert wider.statistics().rms_height == pytest.approx(integral**0.5, rel=0.05)


HEAD = "Subject type;Subject name;Creator;Instrument name;Instrument type;"
HEAD += "Instrument parameters;Function name;Data series;Wavevector (1/m);PSD (m³);"
HEAD += "standard error of PSD (m³);comment"


def test_a_table_of_contact_engineering_is_read_with_its_series(tmp_path):
    lines, scale = [HEAD], {"1D PSD along x": 1.0, "q/π × 2D PSD": 2.0}
    for name, factor in scale.items():
        for q in (1e6, 1e7, 1e8):
            row = f"measurement;scan;me;;;;Power spectrum;{name};{q};{factor / q**3};;"
            lines.append(row)
    file = tmp_path / "power-spectrum.csv"
    file.write_text("\n".join(lines), encoding="utf-8")
    q, density = read_spectrum(str(file))
    assert q == pytest.approx([1e-4, 1e-3, 1e-2])
    # C2D = pi/q times the series, and 1 m^4 = 1e40 Å^4
    assert density == pytest.approx(2 * np.pi * (1e10 * q) ** -4 * 1e40)
    profiles = read_spectrum(str(file), series="1D PSD along x")[1]
    assert profiles[0] < 0.7 * density[0]
    with pytest.raises(ValueError, match="convention"):
        read_spectrum(str(file), "C2D")


def test_a_text_of_contact_engineering_is_read_with_its_series(tmp_path):
    text = "# Power spectrum\n# ==============\n# Version of 'numpy': 1.2.3\n"
    for name, value in (("1D PSD along y", 3.0), ("q/π × 2D PSD", 1.0)):
        text += f"# {name}\n# ----\n# Columns: Wavevector (1/m), PSD (m³)\n"
        text += f"1e6 {value}e-20\n1e7 {value}e-22\n1e8 nan\n1e9 {value}e-25\n\n"
    file = tmp_path / "power-spectrum.txt"
    file.write_text(text, encoding="utf-8")
    q, density = read_spectrum(str(file))
    assert q == pytest.approx([1e-4, 1e-3, 1e-1])  # without the missing bin
    assert density[0] == pytest.approx(np.pi / 1e6 * 1e-20 * 1e40)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("q (1/nm), PSD (nm^4)\n1 2\n2 3\n3 1\n", "give convention"),
        ("q (1/nm), C2D (nm^3)\n1 2\n2 3\n3 1\n", "power 4"),
        ("q (1/ft), C2D (ft^4)\n1 2\n2 3\n3 1\n", "unit '1/ft'"),
        ("C2D (nm^4)\n", "no table"),
        ("q (1/nm), C2D (nm^4)\n1 2\n2 0\n3 1\n", "2 rows"),
        ("q (1/nm), C2D (nm^4)\n1 2\n2 -3\n3 1\n4 1\n", "-3 at q = 2"),
        ("q (1/nm), C2D (nm^4)\n1 2\n2 1\n3 inf\n4 1\n", "inf at q = 3"),
    ],
)
def test_tables_that_can_not_be_understood_are_refused(tmp_path, text, message):
    file = tmp_path / "table.csv"
    file.write_text(text)
    with pytest.raises(ValueError, match=message):
        read_spectrum(str(file))


def test_a_part_of_a_surface_gives_the_spectrum_of_the_whole(tmp_path):
    # a scan that is not periodic: its edges are windowed
    whole = SelfAffine(0.1, 0.8, 8.0, 64.0, longest_wavelength=256.0, domain=1024.0)
    statistics = []
    for seed in range(2):
        scan = HeightMap(replace(whole, seed=seed).heights((512, 512), 1.0), 1.0)
        rough = TabulatedSpectrum.of_scan(scan, domain=1024.0)
        statistics.append([*vars(rough.statistics()).values()])
    mean = np.sqrt(np.mean(np.square(statistics), axis=0))
    assert mean[1:] == pytest.approx([*vars(whole.statistics()).values()][1:], rel=0.05)
    assert mean[0] == pytest.approx(whole.statistics().rms_height, rel=0.15)
    rough.write(tmp_path / "scan.csv")
    again = TabulatedSpectrum.read(tmp_path / "scan.csv", domain=1024.0)
    assert again.rms_slope == pytest.approx(rough.rms_slope, rel=1e-8)


@pytest.mark.slow
def test_profiles_and_areas_have_the_spectrum_by_surface_topography():
    """Twenty seeds against the spectra of the package SurfaceTopography."""
    peer = pytest.importorskip("SurfaceTopography", reason="the extra topography")
    domain, n = 512.0, 256
    of_profiles, of_areas, slopes = [], [], []
    for seed in range(20):
        rough = replace(ROUGH, domain=domain, seed=seed, random_amplitudes=True)
        heights = rough.heights((n, n), 2.0)
        topography = peer.Topography(heights, (domain, domain), periodic=True)
        options = {"resampling_method": None, "reliable": False}
        of_profiles.append(topography.power_spectrum_from_profile(**options)[1])
        options = {"collocation": "log", "nb_points_per_decade": 6, "reliable": False}
        q, density = topography.power_spectrum_from_area(**options)
        of_areas.append(density)
        slopes.append(rough.statistics().rms_slope)
    k = 2 * np.pi / domain * np.arange(n // 2)
    # the sum over q_y of the table is the spectrum of profiles
    across = 2 * np.pi / domain * np.arange(-n, n)
    number = np.hypot(k[:, None], across)
    inside = (number >= 0.999 * Q[0]) & (number <= 1.001 * Q[-1])
    table = np.exp(np.interp(np.log(np.maximum(number, Q[0])), np.log(Q), np.log(C2D)))
    expected = (table * inside).sum(axis=1) / domain
    part = slice(4, 120)
    ratio = np.mean(of_profiles, axis=0)[part] / expected[part]
    assert ratio.mean() == pytest.approx(1.0, abs=0.02)
    assert abs(ratio - 1.0).max() < 0.2
    areas = np.mean(of_areas, axis=0)
    inner = (q > 1.3 * Q[0]) & (q < 0.7 * Q[-1])
    expected = np.exp(np.interp(np.log(q[inner]), np.log(Q), np.log(C2D)))
    assert areas[inner] == pytest.approx(expected, rel=0.1)
    assert slopes == pytest.approx(20 * [slopes[0]], rel=1e-9)


def test_rows_with_the_same_wave_number_are_averaged_with_a_warning(tmp_path):
    file = tmp_path / "rows.txt"
    file.write_text("q (1/nm), C2D (nm^4)\n1, 8\n2, 3\n2, 5\n3, 1\n3, 1\n")
    with pytest.warns(UserWarning, match="1 wave numbers more than once"):
        q, density = read_spectrum(str(file))
    assert q == pytest.approx([0.1, 0.2, 0.3])
    assert density == pytest.approx([8e4, 4e4, 1e4])
