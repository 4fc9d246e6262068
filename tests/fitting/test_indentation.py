"""Fits of indenters of simple shapes to force curves of closed forms."""

import math

import numpy as np
import pytest

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.fitting.force_curve import ForceCurve
from ase_roughcontact.fitting.indentation import fit_indentation
from ase_roughcontact.theory.indenters import named_indenter

NM, NN, KPA, N_M = (UNITS[unit] for unit in ("nm", "nN", "kPa", "N/m"))
MODULUS, STIFFNESS, CONTACT = 20.0 * KPA, 0.05 * N_M, 300.0 * NM


def measured(
    indenter, noise=0.02, offset=0.3, slope=1e-4, deepest=800.0, thickness=math.inf
):
    """Approach at equal steps of the base: noise and offset in nN, slope in nN/nm."""
    depth = np.linspace(0.0, deepest * NM, 4001)
    force = MODULUS * indenter.force_on_layer(depth, thickness)
    along = depth + force / STIFFNESS  # of the base, downward
    down = np.linspace(-2000.0 * NM, along[-1], 2000)
    values = np.interp(down, along, force)
    base = -down
    values += (offset + slope * (base - base.max()) / NM) * NN
    values += noise * NN * np.random.default_rng(2).normal(size=len(down))
    return ForceCurve(CONTACT - base - values / STIFFNESS, values, STIFFNESS)


@pytest.mark.parametrize(
    "text",
    [
        "paraboloid 10 um",
        "sphere 2 um",
        "cone 35 deg",
        "pyramid 35 deg",
        "punch 0.3 um",
        "rounded pyramid 35 deg 200 nm",
        "truncated cone 35 deg 200 nm",
    ],
)
def test_modulus_and_contact_point_are_found_within_their_errors(text):
    indenter = named_indenter(text)
    fit = fit_indentation(measured(indenter), indenter)
    assert fit.converged
    assert fit.warnings == ()
    assert abs(fit.contact_modulus - MODULUS) < 3.0 * fit.contact_modulus_error
    assert fit.contact_modulus_error < 0.02 * MODULUS
    assert fit.force_offset == pytest.approx(0.3 * NN, abs=0.01 * NN)
    assert abs(fit.contact_depth - CONTACT) < 3.0 * fit.contact_depth_error


def test_forces_are_compared_at_the_heights_of_the_base():
    # on a stiff sample the noise of the deflection is in the depth, too
    indenter = named_indenter("cone 70 deg")
    fit = fit_indentation(measured(indenter, noise=0.2, deepest=400.0), indenter)
    assert abs(fit.contact_modulus - MODULUS) < 3.0 * fit.contact_modulus_error


def test_a_thin_layer_has_the_modulus_of_the_layer():
    indenter = named_indenter("paraboloid 5 um")
    curve = measured(indenter, thickness=4000.0 * NM, deepest=400.0)
    fit = fit_indentation(curve, indenter, 4000.0 * NM)
    assert fit.contact_modulus == pytest.approx(MODULUS, rel=0.01)
    assert fit.warnings == ()
    assert fit_indentation(curve, indenter).contact_modulus > 1.3 * MODULUS
    warnings = fit_indentation(curve, indenter, 1000.0 * NM).warnings
    assert any("the formula holds up to 0.5" in warning for warning in warnings)


def test_points_below_a_depth_are_left_out():
    # a stiff base below 200 nm
    indenter = named_indenter("paraboloid 5 um")
    curve = measured(indenter)
    deep = curve.depth + 0.3 * NN / STIFFNESS - CONTACT - 200.0 * NM
    force = curve.force + np.where(deep > 0.0, 0.02 * STIFFNESS * deep, 0.0)
    curve = ForceCurve(-curve.base - force / STIFFNESS, force, STIFFNESS)
    fit = fit_indentation(curve, indenter, deepest=180.0 * NM)
    assert fit.contact_modulus == pytest.approx(MODULUS, rel=0.02)
    assert fit.indentation[fit.compared].max() <= 181.0 * NM


@pytest.mark.parametrize("deepest", [math.inf, 300.0 * NM])
def test_saturated_forces_are_left_out(deepest):
    indenter = named_indenter("paraboloid 10 um")
    whole = measured(indenter)
    force = np.minimum(whole.force, 0.4 * whole.force.max())
    curve = ForceCurve(-whole.base - force / STIFFNESS, force, STIFFNESS)
    fit = fit_indentation(curve, indenter, deepest=deepest)
    assert abs(fit.contact_modulus - MODULUS) < 3.0 * fit.contact_modulus_error
    assert not fit.compared[force == force.max()].any()
    (warning,) = fit.warnings
    assert f"{np.sum(force == force.max())} points" in warning


def test_another_shape_is_doubted():
    curve = measured(named_indenter("punch 0.3 um"))
    (warning,) = fit_indentation(curve, named_indenter("cone 35 deg")).warnings
    assert "points in a row" in warning


def test_a_wide_contact_asks_for_a_sphere():
    paraboloid = named_indenter("paraboloid 2 um")
    (warning,) = fit_indentation(measured(paraboloid), paraboloid).warnings
    assert 'give --indenter "sphere' in warning


def test_a_curve_without_a_contact_is_an_error():
    depth = np.linspace(0.0, 100.0, 50)
    noise = np.random.default_rng(0).normal(size=50)
    with pytest.raises(ValueError, match="no contact"):
        fit_indentation(ForceCurve(depth, 1e-3 * noise), named_indenter("cone 35 deg"))
