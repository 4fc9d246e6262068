"""Closed forms of rough surfaces and spheres against independent calculations."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad

from ase_roughcontact import SelfAffine, theory

R, E = 30.0, 2.0
HERTZ = theory.Hertz(R, E)
LOADS = np.geomspace(1e-12, 1e12, 49)
SLOPE, HURST, SHORT, LONG = 0.1, 0.8, 4.0, 512.0
ROUGH = SelfAffine(SLOPE, HURST, SHORT, LONG)
# the limit of many decades, which closed forms of the literature assume
WIDE = SelfAffine(SLOPE, HURST, SHORT, 1e12)


def spectral_average(function, low, high):
    """Integral of function(q) q C(q) dq over log q, C = q^(-2-2H)."""

    def integrand(x):
        q = np.exp(x)
        return function(q) * q ** (-2 * HURST)

    return quad(integrand, np.log(low), np.log(high), limit=200, epsabs=0)[0]


def test_mean_contact_pressure_is_the_slope_at_zero_load_of_the_contact_fraction():
    pressure = theory.mean_contact_pressure(SLOPE, E)
    assert_allclose(pressure, SLOPE * E / 2)
    assert_allclose(theory.contact_fraction(1e-9, pressure), 1e-9 / pressure)


def test_first_contact_radius_matches_equation_3():
    # Paper's parameters: the brace is 2 * 10000 * 0.1/4 * 0.5 = 250.
    expected = 4 * 250 ** (1 / 1.2)
    assert_allclose(theory.first_contact_radius(1e4, ROUGH), expected)


def test_sphere_rises_by_the_rms_height_at_the_first_contact_radius_from_height():
    a = theory.first_contact_radius_from_height(1e4, ROUGH)
    waves = np.sqrt((1 - HURST) / HURST) * a**HURST * SHORT ** (1 - HURST)
    assert_allclose(a**2 / 2e4, SLOPE / (2 * np.pi) * waves, rtol=1e-13)


def test_contact_area_is_hertz_times_fraction():
    area = HERTZ.contact_area(LOADS)
    expected = area * theory.contact_fraction(LOADS / area, 0.1)
    assert_allclose(theory.predicted_area(LOADS, R, E, 0.1), expected, rtol=1e-13)


@pytest.mark.parametrize("load", [0.0, 1e-300, 1e-30])
def test_contact_area_is_load_over_rough_pressure_at_tiny_load(load):
    area = theory.predicted_area(load, R, E, 0.1)
    assert_allclose(area, load / 0.1, rtol=1e-8)


def test_asperity_radius_from_curvature_agrees_with_a_paraboloid():
    x = np.array([-1e-3, 0.0, 1e-3])
    heights = (x[:, None] ** 2 + x**2) / (2 * 7.0)
    laplacian = heights[[0, 2], 1].sum() + heights[1, [0, 2]].sum()
    assert_allclose(theory.asperity_radius_from_curvature(laplacian / 1e-6), 7.0)


@pytest.mark.parametrize("hurst", [0.2, 0.5, 0.8, 0.99])
@pytest.mark.parametrize("stiffness", [1e-3, 0.3, 1.0, 50.0])
def test_compliant_kappa_is_the_ratio_of_spectral_averages(hurst, stiffness):
    low, high = 2 * np.pi / LONG, 2 * np.pi / SHORT
    rigid = quad(lambda q: q ** (1 - 2 * hurst), low, high, epsabs=0)[0]
    compliant = quad(
        lambda q: q ** (1 - 2 * hurst) / (1 + E * q / (2 * stiffness)) ** 2,
        low,
        high,
        epsabs=0,
    )[0]
    rough = SelfAffine(SLOPE, hurst, SHORT, LONG)
    kappa = theory.compliant_kappa(stiffness, E, rough)
    assert_allclose(kappa, 2 * np.sqrt(rigid / compliant), rtol=1e-8)


def test_compliant_kappa_counts_the_waves_of_the_roll_off():
    low, high = 2 * np.pi / 64.0, 2 * np.pi / SHORT

    def mean(weight):
        flat = quad(lambda q: q**3 * weight(q), low / 8, low, epsabs=0)[0]
        affine = spectral_average(lambda q: q**2 * weight(q), low, high)
        return flat * low ** (-2 - 2 * HURST) + affine

    rough = SelfAffine(SLOPE, HURST, SHORT, 64.0, longest_wavelength=512.0)
    kappa = theory.compliant_kappa(0.3, E, rough)
    compliant = mean(lambda q: (1 + E * q / 0.6) ** -2)
    assert_allclose(kappa, 2 * np.sqrt(mean(lambda q: 1.0) / compliant), rtol=1e-8)


@pytest.mark.parametrize(("work", "expected"), [(0.0005, 0.042), (0.005, 0.28)])
def test_attractive_inverse_kappa_takes_the_known_values(work, expected):
    # Units a0 = E* = 1, wall stiffness k = E*/a0, range sqrt(12 w/k).
    curvature = SLOPE / theory.slope_to_curvature_ratio(WIDE)
    inverse = theory.inverse_kappa_attractive(
        work, 1.0, np.sqrt(12 * work), SLOPE, curvature
    )
    assert_allclose(inverse, expected, rtol=1.5e-2)
