"""One of rms height, slope and curvature of a roughness; the others follow."""

import numpy as np
import pytest
from fourier_amplitudes import amplitudes

from ase_roughcontact.cli.description import bodies
from ase_roughcontact.scene import Scene

SCENE = """
[substrate]
spacing = 2.0
contact_modulus = 100.0
[sphere]
unit = "a0"
radius = 60.0
[roughness]
{keys}
[path]
values = [1.0]
"""


def scene_with(keys):
    scene = Scene.parse(SCENE.format(keys=keys))
    scene = scene.with_values({"roughness.long_wavelength": "3.2 nm"})
    scene.check()
    return scene


@pytest.mark.parametrize(
    ("key", "number", "value"),
    [
        ('rms_height = "0.15 nm"', 0, 1.5),
        ("rms_height = '0.5 a0'", 0, 1.0),
        ('unit = "nm"\nshort_wavelength = 0.8\nrms_height = 0.2', 0, 2.0),
        ("rms_slope = 0.3", 1, 0.3),
        ('rms_curvature = "0.2 /nm"', 2, 0.02),
        ('rms_curvature = "2.0 µm^-1"', 2, 2e-4),
        ("rms_curvature = '0.1 /a0'", 2, 0.05),
    ],
)
def test_each_realisation_has_the_given_amplitude(key, number, value):
    for seed in (0, 5):
        scene = scene_with(f"{key}\nrandom_amplitudes = true\nseed = {seed}")
        assert amplitudes(scene)[number] == pytest.approx(value, rel=1e-9)


def test_all_realisations_together_have_the_given_height():
    keys = 'rms_height = "1 a0"\nnormalise = "ensemble"\nrandom_amplitudes = true\n'
    squares = []
    for seed in range(60):
        squares.append(amplitudes(scene_with(f"{keys}seed = {seed}"))[0] ** 2)
    error = np.std(squares) / np.sqrt(60)
    assert np.mean(squares) == pytest.approx(4.0, abs=3.0 * error)
    assert error < 0.2


def test_two_amplitudes_are_refused():
    with pytest.raises(ValueError, match="rms_slope and rms_height"):
        scene_with('rms_slope = 0.1\nrms_height = "1 a0"')


def test_a_changed_amplitude_replaces_another_one():
    scene = scene_with("rms_slope = 0.1").with_values({"roughness.rms_height": "1 a0"})
    assert amplitudes(scene)[0] == pytest.approx(2.0)
    again = Scene.parse(scene.toml)
    assert again.identity == scene.identity != scene_with("").identity


def test_the_default_slope_given_is_the_same_scene():
    assert scene_with("rms_slope = 0.1").identity == scene_with("").identity


def test_all_three_amplitudes_are_printed():
    scene = scene_with('rms_height = "0.15 nm"')
    height, slope, curvature = amplitudes(scene)
    text = bodies(scene)["roughness"]
    for word in (f"{height / 10:.4g} nm", f"{slope:.4g}", f"{curvature * 10:.4g} /nm"):
        assert word in text
