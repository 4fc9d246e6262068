"""Quantities with units in scene files."""

import numpy as np
import pytest
from small_scene import SMALL

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.scene import Scene


def scene(text):
    parsed = Scene.parse(text)
    parsed.check()
    return parsed


def test_a_radius_may_have_a_unit():
    a0 = Scene.parse(SMALL).spacing
    for entry in ('"15.3 nm"', '"153 Å"', '"0.0153 µm"', f'"{153 / a0} a0"'):
        given = scene(SMALL.replace("radius = 60.0", f"radius = {entry}"))
        assert given.radius == pytest.approx(153.0, rel=1e-12)
    table = SMALL.replace("radius = 60.0", 'radius = 15.3\nunit = "nm"')
    assert scene(table).radius == pytest.approx(153.0, rel=1e-12)


def test_wavelengths_may_have_a_unit():
    plain = scene(SMALL).self_affine
    a0 = scene(SMALL).spacing
    value = SMALL.replace("short_wavelength = 4.0", f'short_wavelength = "{4 * a0} Å"')
    table = SMALL.replace(
        "short_wavelength = 4.0\nlong_wavelength = 16.0",
        f'unit = "nm"\nshort_wavelength = {0.4 * a0}\nlong_wavelength = {1.6 * a0}',
    )
    for text in (value, table):
        rough = scene(text).self_affine
        assert rough.short_wavelength == pytest.approx(plain.short_wavelength)
        assert rough.long_wavelength == pytest.approx(plain.long_wavelength)


def test_the_spacing_may_have_a_unit():
    text = SMALL.replace("[substrate]", '[substrate]\nspacing = "0.3 nm"')
    assert scene(text).spacing == pytest.approx(3.0)


def test_targets_may_have_units():
    interval = "first = 0.2\nlast = 0.6\nsteps = 2"
    listed = SMALL.replace(interval, 'values = ["0.02 nm", 0.3, "0.1 a0"]')
    a0 = scene(listed).spacing
    np.testing.assert_allclose(scene(listed).steps, [0.2, 0.3, 0.1 * a0])
    loads = SMALL.replace('"penetration"', '"load"')
    loads = loads.replace(interval, 'first = "1 pN"\nlast = "0.002 µN"\nsteps = 2')
    np.testing.assert_allclose(scene(loads).steps, np.array([1e-3, 2.0]) * UNITS["nN"])


@pytest.mark.parametrize(
    "entry, message",
    [
        ('"15 inch"', r"\[sphere\] unknown unit of radius 'inch'"),
        ('"nm"', r'\[sphere\] radius must be a number, or .* such as "3 nm"'),
        ('"-3 nm"', r"\[sphere\] radius must be a finite number > 0, got '-3 nm'"),
        ('15.0\nunit = "miles"', r"\[sphere\] unknown unit 'miles'"),
    ],
)
def test_wrong_units_are_errors_of_the_key(entry, message):
    with pytest.raises(ValueError, match=message):
        scene(SMALL.replace("radius = 60.0", f"radius = {entry}"))


def test_a_load_has_no_unit_of_length():
    text = SMALL.replace('"penetration"', '"load"').replace("0.2", '"0.2 nm"')
    with pytest.raises(ValueError, match="unknown unit of first 'nm'"):
        scene(text)
