"""The question of a scene, atoms or continuum, and its grid."""

import numpy as np
import pytest

from ase_roughcontact.cli.description import bodies
from ase_roughcontact.cli.report import table_columns
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.reference import reference_for
from ase_roughcontact.tradeoff.variants import most_accurate

TEXT = """
sphere = {{ unit = "a0", radius = 100.0 }}
roughness = {{ unit = "a0", long_wavelength = 16.0 }}
interaction = {{ kind = "hard" }}
path = {{ values = [10.0] }}
[substrate]
{}
contact_modulus = 100.0
hardness = inf
"""
ATOMS = 'model = "atoms"\n'
CONTINUUM = 'spacing = 2.0\nmodel = "continuum"\n'


def scene(keys="spacing = 2.0"):
    return Scene.parse(TEXT.format(keys))


@pytest.mark.parametrize(
    "text, keys",
    [("a0/2", "refine = 2"), ("2 a0", "coarsen = 2"), ("a0", "refine = 1")],
)
def test_a_grid_relative_to_the_atoms_leaves_their_spacing(text, keys):
    written, meant = (
        scene(f'symbol = "Cu"\nmodel = "continuum"\n{line}')
        for line in (f'grid = "{text}"', keys)
    )
    written.check()
    assert written.spacing == meant.spacing
    assert written.grid_change == meant.grid_change
    older = written.toml.replace("grid = ", "spacing = ")
    assert Scene.parse(older) == written
    both = written.with_values({"substrate.refine": 2})
    with pytest.raises(ValueError, match="not both"):
        both.check()


@pytest.mark.parametrize("spacing", ['"0.2 nm"', '"a0/2"'])
def test_the_most_accurate_grid_leaves_the_atoms_where_they_are(spacing):
    ratio = "" if "a0" in spacing else "\nrefine = 2"
    given = scene(f'symbol = "Cu"\nmodel = "continuum"\nspacing = {spacing}{ratio}')
    best = most_accurate(given)
    assert given.grid_change.refine == 2 != best.grid_change.refine
    assert best.spacing == given.spacing


def test_question_decides_on_the_area_that_is_printed():
    for model, column in (("atoms", "contact_area"), ("continuum", "continuum_area")):
        asked = scene(f'spacing = 2.0\nmodel = "{model}"')
        assert asked.area_column == column
        (step,) = asked.relax()
        reference = reference_for(asked)
        area = getattr(step, column) / 100.0
        columns = {each.head: each for each in table_columns(reference)}
        printed = columns["area (nm²)"].text_of(step)
        assert float(printed) == pytest.approx(area, rel=1e-3)
        part = step.area_error / getattr(step, column)
        assert (part > 1e-3) == (model == "continuum")
        assert ("grid" in bodies(asked)) == (model == "continuum")


FLAT = """[sphere]
radius = inf
[roughness]
unit = "a0"
domain = 64.0
long_wavelength = 16.0
"""
LAYER = "layer_thickness = 20.0\nlayer_modulus = 5.0"
RELAXING = "contact_modulus = 1.0\nrelaxation_moduli = [0.5]\nrelaxation_times = [1.0]"


@pytest.mark.parametrize(
    "substrate, others, model",
    [
        ('symbol = "Si"', "", "atoms"),
        ('material = "diamond"', "", "atoms"),
        ('symbol = "Cu"\ncontact_modulus = 100.0', "", "atoms"),
        ('symbol = "Au"\ncalculator = "emt"', "", "atoms"),
        ('symbol = "Si"\nspacing = 3.84', "", "atoms"),
        ('symbol = "Si"\nspacing = "0.384 nm"', "", "atoms"),
        ('symbol = "Si"\nspacing = "a0"', "", "atoms"),
        ('symbol = "W"\nspacing = 3.16\ncontact_modulus = 446.0', "", "atoms"),
        ('symbol = "Si"\nspacing = "1 nm"', "", "continuum"),
        ('symbol = "Si"\nspacing = "a0/2"', "", "continuum"),
        ('symbol = "Si"\nrefine = 2', "", "continuum"),
        ('symbol = "Si"\ncoarsen = 2', "", "continuum"),
        ("contact_modulus = 100.0", "", "continuum"),
        ("elastic_constants = [165.7, 63.9, 79.6]", "", "continuum"),
        *(
            (f'material = "{name}"', "", "continuum")
            for name in ("SiO2", "Si3N4", "DLC", "mica", "PDMS")
        ),
        (f'symbol = "Si"\n{LAYER}', "", "continuum"),
        (f'symbol = "Cu"\n{RELAXING}', "", "continuum"),
        ('symbol = "Si"', FLAT, "continuum"),
        ('symbol = "Si"', '[topography]\nfile = "scan.npy"\n', "continuum"),
        ('symbol = "Au"\ncalculator = "emt"', FLAT, "atoms"),
        ('model = "atoms"\ncontact_modulus = 100.0', "", "atoms"),
        ('model = "continuum"\nsymbol = "Si"', "", "continuum"),
    ],
)
def test_the_grid_is_atoms_where_it_is_the_surface_of_a_crystal(
    substrate, others, model
):
    asked = Scene.parse(f"[substrate]\n{substrate}\n{others}")
    assert asked.model == model
    assert Scene.parse(asked.toml) == asked


def test_a_model_that_is_not_given_follows_from_changed_values():
    silicon = Scene.parse('substrate = { symbol = "Si" }')
    assert silicon.with_values({"substrate.spacing": "1 nm"}).is_continuum
    stated = silicon.with_values({"substrate.model": "atoms"})
    assert not stated.with_values({"substrate.spacing": "1 nm"}).is_continuum
    assert stated.identity == silicon.identity
    assert not stated.changes_from(silicon)
    (change,) = (
        silicon.with_values({"substrate.spacing": "a0"})
        .with_values({"substrate.model": "continuum"})
        .changes_from(silicon.with_values({"substrate.spacing": "a0"}))
    )
    assert "model" in change


def test_refined_scene_has_another_grid_and_all_else_the_same():
    coarse, fine = (scene(f"{CONTINUUM}refine = {ratio}") for ratio in (1, 2))
    assert (fine.spacing, fine.radius, fine.rough) == (2.0, 200.0, coarse.rough)
    assert fine.wall == coarse.wall
    (a,), (b,) = coarse.relax(), fine.relax()
    assert a.contact_area / b.contact_area > 1.08
    assert a.continuum_area == pytest.approx(b.continuum_area, rel=0.04)
    assert a.height == pytest.approx(b.height, abs=0.01)


def test_header_says_grid_and_loss():
    fine = bodies(scene(CONTINUUM + "refine = 2"))
    assert fine["grid"] == "continuum on a grid of spacing a0/2 = 0.1 nm"
    coarse = scene(CONTINUUM + "coarsen = 4")
    text = bodies(coarse)["grid"]
    assert "spacing 4 a0 = 0.8 nm; a grid 4 times as coarse" in text
    assert f"{100 * coarse.lost_slope:.2g} % of the rms slope" in text
    smooth = coarse.atoms().calc.parameters["indenter"].roughness
    expected = smooth.rms_slope / coarse.rough.rms_slope
    assert coarse.lost_slope == pytest.approx(1.0 - expected, rel=1e-9)
    assert np.isclose(smooth.short_wavelength, 16.0)


@pytest.mark.parametrize(
    "keys, message",
    [
        (
            ATOMS + "refine = 2",
            r'\[substrate\] grid, refine and .* need model = "continuum"',
        ),
        (ATOMS + 'grid = "a0/2"', 'need model = "continuum"'),
        (CONTINUUM + 'grid = "2 nm"', 'grid must be relative .* "a0/2" .* "2 a0"'),
        ('model = "atom"', r"\[substrate\] unknown model 'atom'; did you"),
        (CONTINUUM + "refine = 0", "refine must be an integer >= 1"),
    ],
)
def test_contradictions_are_errors(keys, message):
    with pytest.raises(ValueError, match=message):
        scene(keys).check()


def test_lattice_of_a_crystal_is_no_continuum():
    with pytest.raises(ValueError, match="needs moduli"):
        Scene.parse(
            'substrate = { model = "continuum", calculator = "emt", material = "Cu" }'
        ).check()
