"""Other realisations of a scan: its spectrum and heights, other phases."""

import numpy as np
import pytest

from ase_roughcontact import HeightMap, RoughSphere, SelfAffine
from ase_roughcontact.topography.realisation import distribution_error
from ase_roughcontact.topography.spectrum import power_spectrum, statistics

SIDE = 96
GAUSSIAN = SelfAffine(0.1, 0.8, 4.0, 24.0, domain=float(SIDE), seed=2).heights(
    (SIDE, SIDE), 1.0
)
GAUSSIAN /= GAUSSIAN.std()
#: Heights that are not Gaussian: worn peaks, and high bumps on a plain.
SCANS = {
    "Gaussian": GAUSSIAN,
    "worn": np.minimum(GAUSSIAN, 0.5),
    "bumps": np.exp(0.7 * GAUSSIAN),
}


def heights_of(surface):
    n, m = surface.shape
    return surface.heights((n, m), surface.spacing[0], tuple(-np.array(surface.center)))


def skewness(heights):
    centred = heights - heights.mean()
    return np.mean(centred**3) / centred.std() ** 3


@pytest.mark.parametrize("kind", SCANS)
def test_amplitudes_and_heights_are_those_of_the_scan(kind):
    scan = SCANS[kind]
    found = heights_of(HeightMap(scan, 1.0, periodic=True).realisation(5))
    amplitudes = (abs(np.fft.fft2(each, norm="forward")) for each in (found, scan))
    got, expected = amplitudes
    assert got == pytest.approx(expected, abs=1e-10)
    assert distribution_error(scan, found) < 0.01
    assert skewness(found) == pytest.approx(skewness(scan), abs=0.03)
    # another surface: heights at the same places are independent
    assert abs(np.corrcoef(found.ravel(), scan.ravel())[0, 1]) < 0.4


def test_random_phases_alone_would_make_the_heights_gaussian():
    scan = SCANS["bumps"]
    noise = np.fft.fft2(np.random.default_rng(5).standard_normal(scan.shape))
    spectrum = abs(np.fft.fft2(scan - scan.mean())) * noise / abs(noise)
    plain = np.fft.ifft2(spectrum).real
    assert distribution_error(scan, plain) > 0.2
    assert abs(skewness(plain)) < 0.5 < 1.5 < skewness(scan)


def test_seeds_are_different_surfaces_and_a_seed_is_always_the_same():
    scan = HeightMap(SCANS["worn"], 1.0, periodic=True)
    first, second = (scan.realisation(seed) for seed in (0, 1))
    assert first == scan.realisation(0)
    assert first != second
    correlation = np.corrcoef(heights_of(first).ravel(), heights_of(second).ravel())
    assert abs(correlation[0, 1]) < 0.4
    with pytest.raises(ValueError, match="seed"):
        scan.realisation(-1)


def test_rounding_errors_of_the_scan_do_not_grow():
    scan = SCANS["bumps"]
    found = [
        heights_of(HeightMap(factor * scan, 1.0, periodic=True).realisation(1))
        for factor in (1.0, 1.0 + 1e-14)
    ]
    assert np.allclose(*found, rtol=0.0, atol=1e-9)


def test_anisotropy_is_kept():
    scan = SelfAffine(0.1, 0.8, 4.0, 16.0, anisotropy=3.0, direction=90.0, domain=96.0)
    heights = heights_of(
        HeightMap(scan.heights((96, 96), 1.0), 1.0, True).realisation(3)
    )
    x, y = (np.mean(each**2) for each in np.gradient(heights))
    assert x > 4.0 * y


def test_a_scan_without_a_period_gives_a_periodic_surface_with_its_slope():
    whole = SelfAffine(0.1, 0.8, 8.0, 48.0, longest_wavelength=96.0, domain=384.0)
    scan = HeightMap(whole.heights((160, 128), 1.0), 1.0)
    found = scan.realisation(2)
    assert found.periods == (160.0, 128.0)
    expected = scan.statistics()
    assert found.statistics().rms_slope == pytest.approx(expected.rms_slope, rel=0.05)
    q, density = power_spectrum(heights_of(found), 1.0)
    inside = q < 0.98 * 2 * np.pi / 8.0
    reference = power_spectrum(heights_of(scan.made_periodic()), 1.0)[1]
    assert density[inside] == pytest.approx(reference[inside], rel=1e-9)


def test_windows_wrap_around_a_realisation_but_do_not_see_it_twice():
    sphere = RoughSphere(500.0, HeightMap(SCANS["worn"], 1.0, True).realisation(1))
    rough = sphere.roughness
    around = rough.heights((8, 8), 1.0, (44.0, 0.0))
    assert around[6:] == pytest.approx(rough.heights((2, 8), 1.0, (-46.0, 0.0)))
    with pytest.raises(ValueError, match="repeated"):
        rough.heights((97, 8), 1.0)


def test_noise_and_filter_of_a_scan_are_kept():
    rng = np.random.default_rng(3)
    noisy = SCANS["worn"] + 0.02 * rng.standard_normal((SIDE, SIDE))
    scan = HeightMap.from_topography(
        noisy, "substrate", spacing=1.0, unit="nm", cutoff_wavelength=5.0
    )
    found = scan.realisation(4)
    assert found.measurement.noise == scan.measurement.noise
    slopes = [each.statistics().rms_slope for each in (scan, found)]
    assert slopes[1] == pytest.approx(slopes[0], rel=0.03)
    assert found.copies().keys() == scan.copies().keys()


@pytest.mark.slow
def test_statistics_of_twenty_realisations_by_surface_topography():
    """Twenty seeds against the package SurfaceTopography."""
    peer = pytest.importorskip("SurfaceTopography", reason="the extra topography")
    scan = HeightMap(SCANS["bumps"], 1.0, periodic=True)

    def of(heights):
        topography = peer.Topography(heights, (float(SIDE),) * 2, periodic=True)
        area = topography.power_spectrum_from_area(reliable=False)
        return [
            topography.rms_gradient(),
            *area[1].compressed(),
        ]

    expected = of(SCANS["bumps"])
    for seed in range(20):
        assert of(heights_of(scan.realisation(seed))) == pytest.approx(
            expected, rel=1e-3
        )


def test_statistics_of_twenty_realisations_are_those_of_the_scan():
    scan = HeightMap(SCANS["worn"][::2, ::2], 1.0, periodic=True)
    expected = vars(statistics(SCANS["worn"][::2, ::2], 1.0))
    for seed in range(20):
        found = vars(statistics(heights_of(scan.realisation(seed)), 1.0))
        assert found == pytest.approx(expected, rel=1e-9)
