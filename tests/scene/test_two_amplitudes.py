"""Two of rms height, slope and curvature; a Hurst exponent or a wavelength follows."""

import re

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
[path]
values = [1.0]
[roughness]
"""


def scene_with(keys):
    scene = Scene.parse(SCENE + "\n".join(keys))
    scene.check()
    return scene


HEIGHT, SLOPE = 'rms_height = "0.06 nm"', "rms_slope = 0.1"
CURVATURE = 'rms_curvature = "0.35 /nm"'
_RANGE = re.compile(r"can be (\S+) to (\S+) nm")
ROLL_OFF = "longest_wavelength = '128 a0'"


@pytest.mark.parametrize(
    ("keys", "numbers", "values", "tolerance"),
    [
        ([HEIGHT, SLOPE, 'hurst = "free"'], [0, 1], [0.6, 0.1], 1e-4),
        ([HEIGHT, SLOPE, 'hurst = "free"', "anisotropy = 2"], [0, 1], [0.6, 0.1], 1e-4),
        ([SLOPE, CURVATURE, 'hurst = "free"'], [1, 2], [0.1, 0.035], 1e-4),
        (
            [HEIGHT, SLOPE, 'long_wavelength = "free"', ROLL_OFF],
            [0, 1],
            [0.6, 0.1],
            1e-4,
        ),
        ([SLOPE, CURVATURE, 'short_wavelength = "free"'], [1, 2], [0.1, 0.035], 1e-3),
        # a few waves at the long end are a step of the height
        ([HEIGHT, SLOPE, 'long_wavelength = "free"'], [0, 1], [0.6, 0.1], 0.03),
    ],
)
def test_each_realisation_has_both_amplitudes(keys, numbers, values, tolerance):
    if not any("long_wavelength" in key for key in keys):
        keys = [*keys, "long_wavelength = '64 a0'"]
    for seed in (0, 7):
        found = amplitudes(scene_with([*keys, f"seed = {seed}"]))
        got = [found[number] for number in numbers]
        assert got == pytest.approx(values, rel=tolerance)


def test_what_follows_is_printed():
    scene = scene_with([HEIGHT, SLOPE, 'hurst = "free"', "long_wavelength = '64 a0'"])
    text = bodies(scene)["roughness"]
    assert f"hurst = {scene.rough.hurst:.4g} follows" in text
    assert 0.05 < scene.rough.hurst < 0.95


def test_a_height_that_few_long_waves_do_not_have_is_refused():
    keys = ['rms_height = "0.09 nm"', SLOPE, 'long_wavelength = "free"']
    with pytest.raises(ValueError, match=r"missed by 11 %.*larger domain"):
        scene_with([*keys, "domain = '128 a0'"])
    assert amplitudes(scene_with(keys))[0] == pytest.approx(0.9, rel=0.03)


def test_an_impossible_amplitude_is_refused_with_the_possible_ones():
    keys = [SLOPE, 'hurst = "free"', "long_wavelength = '64 a0'"]
    with pytest.raises(ValueError, match=r"rms_height can be .* nm") as error:
        scene_with(['rms_height = "3 nm"', *keys])
    low, high = map(float, _RANGE.search(str(error.value)).groups())
    for value in (1.05 * low, 0.95 * high):
        found = amplitudes(scene_with([f'rms_height = "{value} nm"', *keys]))
        assert found[0] == pytest.approx(10.0 * value, rel=1e-3)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ([HEIGHT, SLOPE], '"free"'),
        ([HEIGHT, 'hurst = "free"'], "needs two of"),
        ([HEIGHT, SLOPE, CURVATURE, 'hurst = "free"'], "needs two of"),
        ([HEIGHT, SLOPE, 'hurst = "free"', 'short_wavelength = "free"'], "only one"),
        (['hurst = "loose"'], "hurst must be a number"),
        (['long_wavelength = "loose"'], "long_wavelength must be a number"),
    ],
)
def test_wrong_choices_are_refused(keys, message):
    with pytest.raises(ValueError, match=message):
        scene_with(keys)


def test_a_free_exponent_survives_its_file():
    scene = scene_with([HEIGHT, SLOPE, 'hurst = "free"', "long_wavelength = '64 a0'"])
    again = Scene.parse(scene.toml)
    assert again.identity == scene.identity
    assert again.rough == scene.rough


@pytest.mark.parametrize(
    ("name", "advice"),
    [
        ("Sq", "rms_height"),
        ("Rq", "rms_height"),
        ("rms", "rms_height, rms_slope or rms_curvature"),
        ("Sa", "1.25"),
        ("Sdq", "rms_slope"),
        ("H", "hurst"),
        ("cutoff", "short_wavelength"),
        ("roll_off", "longest_wavelength"),
        ("correlation_length", "long_wavelength"),
        ("psd", 'kind = "spectrum"'),
        ("Str", "anisotropy = 1/Str"),
        ("Std", "direction"),
    ],
)
def test_other_names_of_roughness_are_answered_with_the_key(name, advice):
    with pytest.raises(ValueError, match=rf"{name}.*give .*{re.escape(advice)}"):
        Scene.parse(SCENE + f"{name} = 1.0")


def test_a_modulus_under_another_name_is_not_mistaken_for_the_contact_modulus():
    text = SCENE.replace("contact_modulus", "{}")
    for name in ("E", "modulus", "Youngs_modulus"):
        with pytest.raises(ValueError, match=r"give youngs_modulus .*poisson"):
            Scene.parse(text.format(name))
