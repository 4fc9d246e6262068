"""Materials by name: moduli, works of adhesion, sources, and their use in scenes."""

import math
import re
from pathlib import Path

import numpy as np
import pytest
from small_scene import SMALL

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.elasticity.creep import Creep
from ase_roughcontact.elasticity.material import (
    CRYSTALS,
    HARDNESS,
    crystal_modulus,
    poisson_ratio,
)
from ase_roughcontact.elasticity.named_materials import (
    MATERIALS,
    combined_modulus,
    hardness_bound,
    indentation_modulus,
    work_of_adhesion,
)
from ase_roughcontact.scene import Scene

GUIDE = Path(__file__).parents[2] / "examples" / "guide" / "files.md"


def scene(substrate, sphere="", interaction=""):
    text = SMALL.replace('model = "atoms"\n', "")
    text = re.sub(r"contact_modulus = .*\n", substrate + "\n", text)
    text = text.replace("[sphere]\n", f"[sphere]\n{sphere}\n")
    parsed = Scene.parse(text + interaction)
    parsed.check()
    return parsed


def test_every_material_has_a_source_for_each_value():
    for known in MATERIALS.values():
        assert re.search(r"\d{4}|data sheet", known.source)
        assert (known.surface_energy is None) == (known.adhesion_source == "")
        assert np.isnan(known.hardness) == (known.hardness_source == "")
        assert known.spacing is None or 1.5 < known.spacing < 4.0


def test_the_table_of_the_guide_has_the_values_of_the_materials():
    text = GUIDE.read_text().partition("### Hardness")[0]
    cells = r"^\| (\w+)[^|]*\| ([\d.]+) \| ([\d.]*)[^|]*\| (inf|[\d.]*)"
    rows = re.findall(cells, text, re.M)
    table = {name: values for name, *values in rows}
    assert table.keys() == MATERIALS.keys()
    for name, (modulus, energy, hardness) in table.items():
        known = MATERIALS[name]
        assert float(hardness or "nan") == pytest.approx(known.hardness, nan_ok=True)
        assert float(modulus) == pytest.approx(known.contact_modulus, rel=2e-3)
        assert bool(energy) == (known.surface_energy is not None)
        if energy:
            assert float(energy) == pytest.approx(known.surface_energy, rel=0.02)


def test_the_table_of_the_guide_has_the_hardnesses_of_the_elements():
    text = GUIDE.read_text().partition("### Hardness")[2]
    rows = re.findall(r"^\| ([A-Z][a-z]?) \| ([\d.]+) \| ([\d.]*)", text, re.M)
    assert {name: float(value) for name, value, _ in rows} == HARDNESS
    parts = {name: part for name, _, part in rows if part}
    for name, part in parts.items():
        assert part == f"{100 * HARDNESS[name] / crystal_modulus(name):.1f}"
    assert parts.keys() == CRYSTALS.keys()


def test_an_isotropic_solid_across_layers_has_its_own_modulus():
    young, poisson = 100.0, 0.25
    lame = young * poisson / ((1 + poisson) * (1 - 2 * poisson))
    shear = young / (2 * (1 + poisson))
    c11 = lame + 2 * shear
    modulus = indentation_modulus(c11, c11, lame, shear)
    assert modulus == pytest.approx(young / (1 - poisson**2))


def test_the_work_of_adhesion_of_like_materials_is_twice_their_surface_energy():
    assert work_of_adhesion("mica", "mica") == pytest.approx(
        2 * MATERIALS["mica"].surface_energy
    )
    mixed = work_of_adhesion("mica", "PDMS")
    product = work_of_adhesion("mica", "mica") * work_of_adhesion("PDMS", "PDMS")
    assert mixed**2 == pytest.approx(product)


@pytest.mark.parametrize("names", [("Au", "mica"), ("SiO2", "DLC")])
def test_an_unknown_surface_energy_is_an_error(names):
    with pytest.raises(ValueError, match=r"(Au|DLC) .* give work_of_adhesion"):
        work_of_adhesion(*names)


def test_a_scene_takes_modulus_spacing_and_symbol_of_a_material_unless_given():
    mica, known = scene('material = "mica"'), MATERIALS["mica"]
    assert mica.contact_modulus == pytest.approx(known.contact_modulus * UNITS["GPa"])
    assert mica.spacing == known.spacing and mica.atoms().symbols[0] == "O"
    gold = scene('material = "Au"')
    assert (gold.bodies.symbol, gold.spacing) == ("Au", scene('symbol = "Au"').spacing)
    given = scene('material = "mica"\nspacing = 3.0\ncontact_modulus = 50.0')
    assert given.spacing == 3.0
    assert given.contact_modulus == pytest.approx(50.0 * UNITS["GPa"])


@pytest.mark.parametrize("name", ["SiO2", "Si3N4", "DLC", "diamond", "mica", "PDMS"])
def test_the_hardness_of_a_compound_is_its_own(name):
    substrate = f'material = "{name}"\nspacing = 3.84'  # the spacing of silicon
    hardness = MATERIALS[name].hardness * UNITS["GPa"]
    assert scene(substrate).hardness == pytest.approx(hardness, nan_ok=True)


def test_a_pressure_of_30_gpa_on_silica_is_marked():
    text = re.sub(r"contact_modulus = .*\n", 'material = "SiO2"\n', SMALL)
    (step,) = Scene.parse(text).relax([3.0], validity="ignore")
    assert step.largest_pressure > 7.3 * UNITS["GPa"]
    assert "largest pressure/hardness" in step.validity


@pytest.mark.parametrize(
    "substrate, sphere, modulus",
    [
        ('material = "mica"', "", 55.8),
        (
            'material = "mica"',
            'material = "Si3N4"',
            55.8,
        ),  # which is harder than 0.1 E*
        ('material = "Si"', 'material = "mica"', 55.8),
        ('material = "mica"\ncontact_modulus = 20.0', "", 20.0),
        ('symbol = "Nb"\nspacing = 3.3\ncontact_modulus = 120.0', "", 120.0),
        ("contact_modulus = 0.11", "", 0.11),
        ("contact_modulus = 120.0", 'material = "mica"', 55.8),
        ("contact_modulus = 20.0", 'material = "Si"', 20.0),
        ("contact_modulus = 20.0", 'material = "PDMS"', 20.0),
        ('material = "Si"\nlayer_thickness = "9 nm"\nlayer_modulus = 20.0', "", 20.0),
    ],
)
def test_a_body_of_unknown_hardness_bears_at_most_the_largest_part_of_the_table(
    substrate, sphere, modulus
):
    dlc = MATERIALS["DLC"]
    bound = modulus * dlc.hardness / dlc.contact_modulus * UNITS["GPa"]
    found = scene(substrate, sphere).bodies.hardness_bound
    assert found == pytest.approx(bound, rel=1e-3)


@pytest.mark.parametrize(
    "substrate",
    [
        'material = "PDMS"',
        "contact_modulus = 0.09",
        'youngs_modulus = "1 MPa"\npoisson = 0.5',
        'material = "Si"\nlayer_thickness = "9 nm"\nlayer_modulus = 0.002',
    ],
)
def test_no_pressure_on_a_rubber_is_compared_with_a_hardness(substrate):
    bodies = scene(substrate).bodies
    assert math.isnan(bodies.hardness_bound)
    assert math.isnan(bodies.hardness) or bodies.hardness == math.inf


@pytest.mark.parametrize("relaxing, bound", [(0.5, 0.2053), (0.96, math.nan)])
def test_a_viscoelastic_solid_is_a_rubber_if_its_relaxed_modulus_is_small(
    relaxing, bound
):
    creep = Creep.of_relaxation([relaxing], [1.0])
    assert hardness_bound(2.0, creep) == pytest.approx(bound, rel=1e-3, nan_ok=True)


@pytest.mark.parametrize(
    "lines, compared",
    [
        ('material = "mica"', True),
        ('material = "mica"\nhardness = 50.0', False),
        ('material = "mica"\nhardness = inf', False),
        ("contact_modulus = 55.8", True),
        ("contact_modulus = 55.8\nhardness = inf", False),
        ('material = "Si"\nlayer_thickness = "9 nm"\nlayer_modulus = 55.8', True),
    ],
)
def test_a_pressure_above_a_tenth_of_the_modulus_is_marked_without_a_hardness(
    lines, compared
):
    text = re.sub(r"contact_modulus = .*\n", lines + "\n", SMALL)
    (step,) = Scene.parse(text).relax([3.0], validity="ignore")
    assert step.largest_pressure > 0.13 * 55.8 * UNITS["GPa"]
    assert ("bound of the hardness" in step.validity) == compared


OTHER_KEYS = (
    'spacing = "1 nm"',
    'spacing = "a0/2"',
    "spacing = 2.0",
    "contact_modulus = 90.0",
    "elastic_constants = [165.7, 63.9, 79.6]",
    "poisson = 0.25",
    "refine = 2",
    "periodic = true",
)


@pytest.mark.parametrize("keys", OTHER_KEYS)
@pytest.mark.parametrize("name", ["Si", "Cu"])
def test_a_material_keeps_its_hardness_beside_any_other_key(name, keys):
    for section in ("material", "symbol"):
        named = scene(f'{section} = "{name}"\n{keys}')
        assert named.hardness == HARDNESS[name] * UNITS["GPa"]


@pytest.mark.parametrize("keys", OTHER_KEYS)
def test_a_material_keeps_its_work_of_adhesion_beside_any_other_key(keys):
    adhesive = '[interaction]\nkind = "adhesive"\n'
    named = scene(f'material = "Si"\n{keys}', 'material = "SiO2"', adhesive)
    expected = work_of_adhesion("Si", "SiO2") * UNITS["J/m^2"]
    assert named.wall.work_of_adhesion == pytest.approx(expected)


@pytest.mark.parametrize("keys", [key for key in OTHER_KEYS if "poisson" not in key])
def test_a_material_keeps_its_poisson_ratio_beside_any_other_key(keys):
    path = '[path]\nkind = "sliding"\nvalues = [1.0]\ndisplacements = [0.1]\n'
    text = SMALL.partition("[path]")[0] + path + "[friction]\ncoefficient = 0.5\n"
    text = re.sub(r"contact_modulus = .*\n", f'material = "Si"\n{keys}\n', text)
    named = Scene.parse(text)
    assert named.solid.poisson == poisson_ratio(CRYSTALS["Si"])


def test_pressures_above_the_hardness_of_silicon_are_marked_on_a_grid_in_nm():
    text = re.sub(r"contact_modulus = .*\n", 'material = "Si"\n', SMALL)
    text = text.replace("shape", 'spacing = "1 nm"\nshape')
    (step,) = Scene.parse(text).relax([20.0], validity="ignore")
    assert step.largest_pressure > HARDNESS["Si"] * UNITS["GPa"]
    assert "largest pressure/hardness" in step.validity


@pytest.mark.parametrize(
    "substrate, sphere, hardness",
    [
        ("Si", "Cu", "Cu"),
        ("Cu", "Si", "Cu"),
        ("PDMS", "Si", "Si"),
        ("Si", "PDMS", "Si"),
    ],
)
def test_pressures_are_compared_with_the_hardness_of_the_softer_body(
    substrate, sphere, hardness
):
    both = scene(f'material = "{substrate}"', f'material = "{sphere}"')
    assert both.hardness == HARDNESS[hardness] * UNITS["GPa"]


def test_a_plastic_wall_does_not_take_the_hardness_of_a_tip_for_the_substrate():
    plastic = '[interaction]\nkind = "plastic"\n'
    with pytest.raises(ValueError, match="hardness"):
        scene('material = "mica"', 'material = "SiO2"', plastic).check()
    both = scene('material = "Cu"', 'material = "Si"', plastic)
    assert both.wall.hardness == HARDNESS["Cu"] * UNITS["GPa"]


def test_a_plastic_wall_on_a_rubber_needs_a_hardness():
    with pytest.raises(ValueError, match="hardness"):
        scene('material = "PDMS"', "", '[interaction]\nkind = "plastic"\n').check()


def test_an_elastic_tip_reduces_the_modulus():
    both = scene('material = "mica"', 'material = "Si3N4"')
    moduli = (MATERIALS[name].contact_modulus for name in ("mica", "Si3N4"))
    expected = combined_modulus(*moduli) * UNITS["GPa"]
    assert both.contact_modulus == pytest.approx(expected)
    half = scene("contact_modulus = 74.6", 'material = "SiO2"').contact_modulus
    assert half == pytest.approx(37.3 * UNITS["GPa"], rel=1e-3)


def test_an_adhesive_wall_takes_the_work_of_both_materials():
    adhesive = '[interaction]\nkind = "adhesive"\n'
    assert scene('material = "mica"', 'material = "Au"').wall.work_of_adhesion == 0.0
    both = scene('material = "mica"', 'material = "Si3N4"', adhesive)
    expected = work_of_adhesion("mica", "Si3N4") * UNITS["J/m^2"]
    assert both.wall.work_of_adhesion == pytest.approx(expected)
    given = adhesive + "work_of_adhesion = 0.01\n"
    both = scene('material = "mica"', 'material = "Si3N4"', given)
    assert both.wall.work_of_adhesion == pytest.approx(0.01 * UNITS["J/m^2"])


SOLIDS_WITHOUT_MODULUS = (
    "rigid_base = true",
    "anisotropic = true",
    'calculator = "emt"',
    'potential = "Cu.eam.alloy"',
    'crystal = "copper.json"',
)


@pytest.mark.parametrize(
    "substrate, sphere, message",
    [
        ('material = "wood"', "", r"\[substrate\] .* 'wood'; Known: Ag"),
        ('material = "Si"', 'material = "wood"', "'wood'"),
        ('material = "copper"', "", "did you mean 'Cu'[?] Known: .*Au.*mica"),
        ('material = "aluminum"', "", "did you mean 'Al'"),
        ('material = "MICA"', "", "did you mean 'mica'"),
        *(
            (f'material = "mica"\n{key}', "", f"'mica' .* which {key.split()[0]}")
            for key in SOLIDS_WITHOUT_MODULUS
        ),
        (
            'symbol = "Cu"\nanisotropic = true',
            'material = "Si"',
            "needs an isotropic substrate",
        ),
    ],
)
def test_wrong_materials_are_errors(substrate, sphere, message):
    with pytest.raises(ValueError, match=message):
        scene(substrate, sphere)
