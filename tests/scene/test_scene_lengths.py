"""Quantities with units in scene files."""

import numpy as np
import pytest
from small_scene import SMALL

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.ensemble.columns import scene_columns
from ase_roughcontact.scene import Scene


def scene(text):
    parsed = Scene.parse(text)
    parsed.check()
    return parsed


def test_lengths_may_have_a_unit():
    plain, a0 = scene(SMALL), Scene.parse(SMALL).spacing
    entries = '"15.3 nm"', '"153 Å"', '"0.0153 µm"', f'"{153 / a0} a0"'
    for entry in (*entries, '15.3\nunit = "nm"'):
        given = scene(SMALL.replace("radius = 60.0", f"radius = {entry}"))
        assert given.radius == pytest.approx(153.0, rel=1e-12)
    waves = f'unit = "nm"\nshort_wavelength = {0.4 * a0}\nlong_wavelength = {1.6 * a0}'
    for text in (f'long_wavelength = "{16 * a0} Å"', waves):
        rough = scene(SMALL.replace("long_wavelength = 16.0", text)).rough
        assert rough.short_wavelength == pytest.approx(plain.rough.short_wavelength)
        assert rough.long_wavelength == pytest.approx(plain.rough.long_wavelength)
    text = SMALL.replace("[substrate]", '[substrate]\nspacing = "0.3 nm"')
    assert scene(text).spacing == pytest.approx(3.0)
    path = '[path]\nkind = "loop"\ndeepest = 1.0\ncantilever = "200 mN/m"\n'
    given = scene("[interaction]\nkind = 'adhesive'\nwork_of_adhesion = 0.1\n" + path)
    assert given.cantilever == pytest.approx(0.2 * UNITS["N/m"], rel=1e-12)


def test_targets_may_have_units():
    interval = "first = 0.2\nlast = 0.6\nsteps = 2"
    listed = SMALL.replace(interval, 'values = ["0.02 nm", 0.3, "0.1 a0"]')
    a0 = scene(listed).spacing
    np.testing.assert_allclose(scene(listed).targets, [0.2, 0.3, 0.1 * a0])
    loads = SMALL.replace('"penetration"', '"load"')
    loads = loads.replace(interval, 'first = "1 pN"\nlast = "0.002 µN"\nsteps = 2')
    np.testing.assert_allclose(
        scene(loads).targets, np.array([1e-3, 2.0]) * UNITS["nN"]
    )


MODULI = "[substrate]\nspacing = 3.0\n{}\n[path]\nvalues = [1.0]\n"


@pytest.mark.parametrize("value", ['"0.1 TPa"', '"100 GPa"', '"1e5 MPa"', "100.0"])
def test_moduli_and_hardnesses_may_have_a_unit(value):
    given = scene(MODULI.format(f"contact_modulus = {value}\nhardness = {value}"))
    assert given.contact_modulus == pytest.approx(100 * UNITS["GPa"], rel=1e-12)
    assert given.hardness == pytest.approx(100 * UNITS["GPa"], rel=1e-12)
    assert given.toml == scene(given.toml).toml
    listed = 'elastic_constants = ["165.7 GPa", "63900 MPa", 79.6]'
    plain = "elastic_constants = [165.7, 63.9, 79.6]"
    found = (scene(MODULI.format(text)).contact_modulus for text in (listed, plain))
    assert next(found) == pytest.approx(next(found), rel=1e-12)


@pytest.mark.parametrize("work", ['"50 mJ/m²"', '"0.05 N/m"', "0.05"])
@pytest.mark.parametrize("cutoff", ['"2.4 nm"', '"8 a0"', "8.0"])
def test_parameters_of_walls_may_have_a_unit(work, cutoff):
    section = f'[interaction]\nkind = "full"\nwork_of_adhesion = {work}\n'
    given = scene(MODULI.format("") + section + f"cutoff = {cutoff}\n")
    wall = given.wall
    assert wall.work_of_adhesion == pytest.approx(0.05 * UNITS["J/m²"], rel=1e-12)
    assert wall.cutoff == pytest.approx(24.0, rel=1e-12)
    stored = scene_columns(given)["work_of_adhesion"]
    assert stored == pytest.approx(0.05, rel=1e-12)


@pytest.mark.parametrize(
    "section, line, message",
    [
        ("sphere", 'radius = "15 inch"', r"unknown unit of radius 'inch'\. Known: a0"),
        ("sphere", 'radius = "nm"', 'radius must be a number, or .* such as "3 nm"'),
        ("sphere", 'radius = 15.0\nunit = "miles"', "unknown unit 'miles'"),
        ("path", 'values = ["0.2 nm"]', r"unknown unit of values 'nm'\. Known: nN"),
        ("substrate", 'hardness = "3 GPA"', "hardness 'GPA'; did you mean 'GPa'"),
        ("substrate", 'contact_modulus = "stiff"', "such as \"3 GPa\", got 'stiff'"),
        ("substrate", "contact_modulus = true", "must be a number or a string"),
        ("path", 'kind = "loop"\ncantilever = "5"', "such as \"3 N/m\", got '5'"),
    ],
)
def test_wrong_units_are_errors_of_the_key(section, line, message):
    path = "" if section == "path" else "[path]\nvalues = [1.0]\n"
    with pytest.raises(ValueError, match=rf"\[{section}\] .*{message}"):
        scene(f"[{section}]\n{line}\n{path}")


def test_errors_of_lengths_are_in_the_unit_of_the_section():
    rough = '[roughness]\nunit = "nm"\nshort_wavelength = 0.4\nlong_wavelength = 4.0'
    with pytest.raises(ValueError, match=r"at least 2 a0 = 0\.6 nm .* got 0\.4 nm"):
        scene(MODULI.format("") + rough)
    rough = rough.replace("0.4", "8.0")
    with pytest.raises(ValueError, match=r"short_wavelength = 8\.0, got 4\.0"):
        scene(MODULI.format("") + rough)
