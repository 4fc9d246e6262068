"""Arguments of all closed forms: units, and values that are refused."""

from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ase_roughcontact import SelfAffine, theory

R, E, W = 30.0, 2.0, 0.05
SLOPE, HURST, SHORT = 0.1, 0.8, 4.0


@pytest.mark.parametrize("bad", [-1.0, np.inf])
@pytest.mark.parametrize(
    "function, message",
    [
        (theory.Hertz(R, E).force, "finite and >= 0"),
        (theory.JKR(R, E, W).penetration, "finite and >= 0"),
        (lambda bad: theory.contact_fraction(bad, 1.0), "finite and >= 0"),
        (lambda bad: theory.Hertz(bad, E), "a finite number > 0"),
        (lambda bad: theory.DMT(R, bad, W), "a finite number > 0"),
        (lambda bad: theory.JKR(R, E, bad), "a finite number > 0"),
        (lambda bad: theory.MaugisDugdale(R, E, W, bad), "a finite number > 0"),
    ],
)
def test_unphysical_arguments_are_refused(function, message, bad):
    with pytest.raises(ValueError, match=f"must be {message}, got"):
        function(bad)


@pytest.mark.parametrize(
    "name, bad",
    [("hurst", bad) for bad in (0.0, 1.0, -0.2, np.nan)]
    + [("rms_slope", bad) for bad in (0.0, -0.1, np.inf)]
    + [("short_wavelength", bad) for bad in (0.0, -4.0, np.nan)],
)
@pytest.mark.parametrize(
    "function",
    [
        theory.asperity_radius,
        theory.slope_to_curvature_ratio,
        partial(theory.first_contact_radius, 1e4),
        partial(theory.flattening_energy, 1.0),
        partial(theory.compliant_kappa, 1.0, 1.0),
    ],
)
def test_unphysical_roughness_is_refused(function, name, bad):
    rough = vars(SelfAffine(SLOPE, HURST, SHORT, 512.0)) | {name: bad}
    with pytest.raises(ValueError, match=f"{name} must"):
        function(SimpleNamespace(**rough))


def test_results_do_not_depend_on_the_system_of_units():
    def dimensionless(length, pressure):
        radius, modulus = R * length, E * pressure
        load, work = 3.0 * length**2 * pressure, W * length * pressure
        short = SHORT * length
        surface = SelfAffine(SLOPE, HURST, short, 128 * short)
        rough = theory.mean_contact_pressure(SLOPE, modulus)
        sphere = radius, modulus, work
        maugis = theory.MaugisDugdale(*sphere, 0.5 * length)
        curvature = SLOPE / theory.slope_to_curvature_ratio(surface)
        return [
            theory.predicted_area(load, radius, modulus, rough) / length**2,
            theory.crossover_load(radius, modulus, SLOPE) / (length**2 * pressure),
            theory.first_contact_radius(radius, surface) / length,
            theory.compliant_kappa(modulus / short, modulus, surface),
            theory.inverse_kappa_attractive(work, modulus, length, SLOPE, curvature),
            theory.JKR(*sphere).contact_radius(load) / length,
            maugis.contact_radius(load) / length,
            maugis.tabor_parameter,
        ]

    units = dimensionless(2.9e-10, 1.6e11)
    assert_allclose(units, dimensionless(1.0, 1.0), rtol=1e-12)
