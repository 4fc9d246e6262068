"""Isotropic layers, against finite elements and their limits."""

import numpy as np
import pytest
from depth_elements import compliance, isotropic
from numpy.polynomial.legendre import leggauss
from scipy.fft import irfft2

from ase_roughcontact import RoughContact, RoughSphere, load_path, substrate
from ase_roughcontact.elasticity import (
    Creep,
    FreeHalfSpace,
    Isotropic,
    Layer,
    PeriodicHalfSpace,
    Viscoelastic,
)

THICKNESS = 2.0
LAYER = np.linspace(0.0, THICKNESS, 60)
BASE = THICKNESS + np.concatenate([np.linspace(0, 6, 80), np.linspace(6.2, 60, 150)])


@pytest.mark.parametrize("bonded", [True, False], ids=["bonded", "sliding"])
@pytest.mark.parametrize("base", [None, 0.1, 4.0])
@pytest.mark.parametrize("q", [0.3, 1.0])
def test_wave_compliance_agrees_with_finite_elements(base, bonded, q):
    stack = [(isotropic(1.0, 0.3), LAYER)]
    if base is not None:
        stack.append((isotropic(base, 0.2), BASE))
    layer = Layer(1.0, THICKNESS, base, 0.3, 0.2, bonded)
    expected = compliance(stack, q, bonded=bonded)
    assert layer.wave_compliance(q, 0.0) == pytest.approx(expected, rel=1e-5)
    assert layer.wave_compliance(0.6 * q, 0.8 * q) == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("bonded", [True, False], ids=["bonded", "sliding"])
@pytest.mark.parametrize("poisson", [0.0, 0.3, 0.5])
def test_limits_of_thin_and_thick_layers(poisson, bonded):
    q = 1.0
    wave = {"qx": np.array(q), "qy": np.array(0.0)}
    thick = Layer(1.0, 30.0, 5.0, poisson, 0.3, bonded).wave_compliance(**wave)
    assert thick == pytest.approx(2.0 / q, rel=1e-12)
    thin = Layer(1.0, 1e-6, 5.0, poisson, 0.3, bonded).wave_compliance(**wave)
    assert thin == pytest.approx(2.0 / (5.0 * q), rel=1e-4)
    # on a rigid base, uniaxial strain (bonded), or plane strain, in which the layer
    # may expand along the wave (sliding); without a change of volume, Johnson (5.80)
    rigid = Layer(1.0, 1e-3, None, poisson, bonded=bonded).wave_compliance(**wave)
    if not bonded:
        expected = 1e-3
    elif poisson < 0.5:
        expected = 1e-3 * (1 - 2 * poisson) / (1 - poisson) ** 2
    else:
        expected = 4 / 3 * 1e-9 * q**2
    assert rigid == pytest.approx(expected, rel=1e-4)


def test_uniform_compression_of_a_layer():
    long_waves = Layer(2.0, 3.0, poisson=0.3).wave_compliance(1e-6, 0.0)
    for bonded in (True, False):  # a periodic cell keeps its size
        layer = Layer(2.0, 3.0, poisson=0.3, bonded=bonded)
        assert layer.uniform_compliance == pytest.approx(long_waves, rel=1e-6)
    assert Layer(2.0, 3.0).uniform_compliance == 0.0  # incompressible
    assert Layer(2.0, 3.0, 1.0, poisson=0.3).uniform_compliance == 0.0
    plane = PeriodicHalfSpace((8, 8), 1.0, layer).displacement(np.ones((8, 8)))
    np.testing.assert_allclose(plane, 0.0, atol=1e-15)


SOLIDS = {
    "hard layer": Layer(1.0, 5.0, 0.05, 0.3, 0.3),
    "soft layer": Layer(1.0, 5.0, 10.0, 0.3, 0.3),
    "sliding": Layer(1.0, 5.0, 3.0, 0.3, 0.3, bonded=False),
    "rigid base": Layer(1.0, 5.0, None, 0.5),
}


@pytest.mark.parametrize("layer", SOLIDS.values(), ids=SOLIDS)
def test_free_kernel_is_the_limit_of_large_periodic_cells(layer):
    # the difference to a half space is smooth, so that a grid resolves it
    bare = Isotropic(layer.layer_modulus)
    at = np.array([0, 3, 8, 20]), np.array([0, 1, 8, 3])
    with_layer, without = (s.cell_compliance(*at, 1.0) for s in (layer, bare))
    expected = np.diff(with_layer - without)
    errors = []
    for n in (256, 512):
        spectra = (PeriodicHalfSpace((n, n), 1.0, s).compliance for s in (layer, bare))
        uniform = np.outer(np.sinc(np.fft.fftfreq(n)), np.sinc(np.fft.rfftfreq(n)))
        change = np.diff(irfft2(np.subtract(*spectra) * uniform, (n, n))[at])
        errors.append(abs(change - expected).max() / abs(expected).max())
    assert errors[1] < max(0.15 * errors[0], 1e-7) < 1e-3


@pytest.mark.parametrize("poisson", [0.3, 0.5])
@pytest.mark.parametrize("thickness", [0.25, 1.0])
def test_kernel_of_a_thin_layer_is_the_integral_over_its_waves(thickness, poisson):
    layer, bare = Layer(1.0, thickness, poisson=poisson), Isotropic(1.0)
    at = np.array([0, 1, 1, 2, 5]), np.array([0, 0, 1, 1, 3])
    # the difference to a half space decays as exp(-2 q h)
    (q, dq), (angle, weight) = leggauss(600), leggauss(400)
    q, dq = 8.0 / thickness * (q + 1.0), 8.0 / thickness * dq
    angle, weight = np.pi / 4 * (angle + 1.0), weight / 2
    x, y = q[:, None] * np.cos(angle), q[:, None] * np.sin(angle)
    dq = dq * q * (layer.wave_compliance(q, 0.0) - bare.wave_compliance(q, 0.0))
    cell = np.sinc(x / (2 * np.pi)) * np.sinc(y / (2 * np.pi))
    change = [
        dq @ (cell * np.cos(x * i) * np.cos(y * j)) @ weight / (2 * np.pi)
        for i, j in zip(*at, strict=True)
    ]
    found = layer.cell_compliance(*at, 1.0)
    expected = bare.cell_compliance(*at, 1.0) + change
    np.testing.assert_allclose(found, expected, atol=1e-8 * expected[0])


def test_far_field_is_determined_by_the_base():
    far = np.array([20000]), np.array([15000])
    for layer in (SOLIDS["hard layer"], SOLIDS["soft layer"], SOLIDS["sliding"]):
        base = Isotropic(layer.contact_modulus)
        assert layer.contact_modulus == layer.base_modulus
        np.testing.assert_allclose(
            layer.cell_compliance(*far, 1.0), base.cell_compliance(*far, 1.0), rtol=1e-5
        )
    kernel = SOLIDS["hard layer"].cell_compliance(np.arange(31, 35), np.array(7), 1.0)
    assert abs(np.diff(kernel, 3)) < 2e-4 * kernel[0]  # between its forms
    assert SOLIDS["rigid base"].contact_modulus == 1.0
    assert abs(SOLIDS["rigid base"].cell_compliance(*far, 1.0)) < 1e-8


@pytest.mark.parametrize("thickness", [0.02, 0.1])
def test_a_layer_thinner_than_the_spacing_is_a_foundation(thickness):
    layer = Layer(1.0, thickness, poisson=0.3)
    before = layer.todict()
    layer.check(1.0)
    assert layer.todict() == before  # what identifies it does not change by use
    pressed = FreeHalfSpace((6, 5), 1.0, layer).displacement(np.eye(6, 5))
    expected = -layer.uniform_compliance * np.eye(6, 5)
    np.testing.assert_allclose(pressed, expected, atol=0.2 * abs(expected).max())


@pytest.mark.parametrize(
    "name, value", [("thickness", 0.0), ("poisson", 0.6), ("base_modulus", 0.0)]
)
def test_impossible_layers_are_refused(name, value):
    with pytest.raises(ValueError, match=name):
        Layer(**{"layer_modulus": 1.0, "thickness": 1.0, name: value})


def test_stiff_layer_on_a_soft_base_needs_an_automatic_window():
    sphere, solid = RoughSphere(40.0), Layer(1.0, 5.0, 0.01, 0.3, 0.3)
    fixed, atoms = (substrate("Cu", (16, 16), sphere, spacing=1.0) for _ in range(2))
    fixed.calc, atoms.calc = (RoughContact(sphere, solid=solid) for _ in range(2))
    fixed.positions[:4, 2] -= 0.1
    with pytest.raises(ValueError, match="window='auto'"):
        fixed.get_forces()
    (step,) = load_path(atoms, penetrations=[0.3], window="auto", accuracy="high")
    again = atoms.copy()
    again.calc = RoughContact(sphere, solid=solid)
    assert again.get_potential_energy() == pytest.approx(step.energy, rel=1e-9)
    assert abs(again.get_forces()[:-1]).max() < 1e-6 * step.normal_force


@pytest.mark.parametrize("bonded", [True, False])
def test_the_stiffest_layer_bends_as_a_plate_on_its_base(bonded):
    thickness, base = 5.0, 1e-6
    layer = Layer(1.0, thickness, base, 0.3, 0.3, bonded)
    origin = np.zeros(1), np.zeros(1)
    # A. H. A. Hogg, Phil. Mag. 25, 576 (1938): the deflection below a unit force
    bending, foundation = thickness**3 / 12.0, 0.5 * base
    if bonded:  # the plate keeps the surface of the base from moving sideways
        foundation *= 4.0 * (1.0 - 0.3) ** 2 / (3.0 - 4.0 * 0.3)
    plate = foundation ** (-2 / 3) * bending ** (-1 / 3) / (3.0 * np.sqrt(3.0))
    assert layer.cell_compliance(*origin, 1.0) == pytest.approx(plate, rel=3e-3)


def test_a_layer_too_stiff_for_rounding_is_refused():
    with pytest.raises(ValueError, match=r"1e\+06"):
        Layer(1.0, 5.0, 0.9e-6)


def test_limits_of_a_viscoelastic_layer_are_layers_of_its_thickness():
    solid = Viscoelastic(Layer(1.0, THICKNESS, 5.0), Creep([1.0], [2.0]))
    assert solid.thickness == solid.relaxed.thickness == THICKNESS
    assert solid.relaxed.half_space == solid.solid.half_space != ""
    assert not Viscoelastic(1.0, solid.creep).relaxed.layered
