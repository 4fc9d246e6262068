"""Arguments of all closed forms: units, and values that are refused."""

from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ase_roughcontact import RoughSphere, SelfAffine, theory

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
    with pytest.raises(ValueError, match=message):
        function(bad)


def test_masked_forces_have_no_area():
    forces = np.ma.array([1.0, 2.0], mask=[False, True])
    for sphere in (theory.Hertz(R, E), theory.JKR(R, E, W), theory.DMT(R, E, W)):
        areas = sphere.contact_area(forces)
        assert_allclose(areas, [sphere.contact_area(1.0), np.nan])
    for function in (theory.Hertz(R, E).force, theory.JKR(R, E, W).penetration):
        with pytest.raises(ValueError, match="finite"):
            function(forces)


ROUGH = SelfAffine(SLOPE, HURST, SHORT, 512.0)
SPHERE = RoughSphere(100.0, ROUGH)


def rough(**changes):
    """An object with the parameters of a roughness that does not check them."""
    return SimpleNamespace(**vars(ROUGH) | changes)


@pytest.mark.parametrize(
    "function, arguments, message",
    [
        (theory.yield_load, (1.0, 1.0, 0.0), "hardness"),
        (theory.plastic_crossover_load, (1.0, 1.0, 0.0), "hardness"),
        (
            theory.flattening_energy,
            (E, rough(long_wavelength=3.0)),
            r"4\.0, got 3",
        ),
        (
            theory.flattening_energy,
            (E, rough(long_wavelength=64.0, longest_wavelength=32.0)),
            r"64\.0, got 32\.0",
        ),
        (theory.compliant_kappa, (E, E, rough(long_wavelength=4.0)), "long_wavelength"),
        (theory.stickiness, (ROUGH, -1.0, 0.005, 0.245), "> 0"),
        (theory.stickiness, (ROUGH, 1.0, -1.0, 0.245), "> 0"),
        (theory.stickiness, (ROUGH, 1.0, 0.005, -1.0), "> 0"),
        (theory.stickiness, (SPHERE, 1.0, 0.02, 0.5), "roughness of a RoughSphere"),
        (theory.regime, (1.0, 100.0, 1.0, SPHERE), "roughness of a RoughSphere"),
        (theory.regime, (np.nan, R, E), "normal_force"),
        (theory.regime, (-1.0, R, E, ROUGH), "normal_force"),
        (partial(theory.regime, work_of_adhesion=W), (1.0, R, E), "attraction_range"),
        (partial(theory.regime, kappa_repulsive=0.0), (1.0, R, E, ROUGH), "kappa_rep"),
        (theory.Hertz(R, E).contact_radius, (-20.0,), "-20"),
        (theory.JKR(R, E, W).contact_radius, (-20.0,), "-20"),
        (theory.DMT(R, E, W).contact_radius, (-20.0,), "-20"),
        (theory.MaugisDugdale(R, E, W, W).contact_radius, (-20.0,), "-20"),
        (theory.MaugisDugdale(R, E, W, W).state, (1.0,), "zone_ratio"),
        (theory.MaugisDugdale(R, E, W, W).state, (np.nan,), "zone_ratio"),
        (
            theory.MaugisDugdale(R, E, W, W).stability_limit,
            ("speed",),
            "'load' or 'displacement'",
        ),
        (
            theory.JKR(R, E, W).contact_radius_from_penetration,
            (-100.0,),
            "-100",
        ),
    ],
)
def test_what_has_no_answer_is_refused(function, arguments, message):
    with pytest.raises(ValueError, match=message):
        function(*arguments)


@pytest.mark.parametrize(
    "name, bad",
    [
        *(("hurst", bad) for bad in (0.0, 1.0, np.nan)),
        *(("rms_slope", bad) for bad in (0.0, np.inf)),
        *(("short_wavelength", bad) for bad in (-4.0, np.nan)),
    ],
)
@pytest.mark.parametrize(
    "function",
    [
        theory.asperity_radius,
        partial(theory.first_contact_radius, 1e4),
        partial(theory.compliant_kappa, 1.0, 1.0),
    ],
)
def test_unphysical_roughness_is_refused(function, name, bad):
    with pytest.raises(ValueError, match=name):
        function(rough(**{name: bad}))


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
