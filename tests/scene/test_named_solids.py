"""The solid of a scene: whose hardness it has, and how a run names it."""

import math

import numpy as np
import pytest
from ase.units import GPa
from small_scene import SMALL

import ase_roughcontact as rc
from ase_roughcontact.cli.description import bodies, theory
from ase_roughcontact.elasticity import Layer
from ase_roughcontact.elasticity.material import HARDNESS
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.reference import reference_for

CONSTANTS = "elastic_constants = [165.7, 63.9, 79.6]"
LAYER = 'layer_thickness = "2 nm"\nlayer_modulus = 5.0'


def scene(lines):
    return Scene.parse(SMALL.replace("contact_modulus = 100.0", lines))


@pytest.mark.parametrize(
    "lines, hardness",
    [
        ("", HARDNESS["Cu"]),
        ('material = "Si"\ncontact_modulus = 171.2', HARDNESS["Si"]),
        ("contact_modulus = 100.0", math.nan),
        ("contact_modulus = 100.0\nhardness = 2.0", 2.0),
        ("contact_modulus = 100.0\nhardness = inf", math.inf),
        (f"anisotropic = true\n{CONSTANTS}", math.nan),
        (f"{LAYER}\nrigid_base = true", math.nan),
        (f'symbol = "Si"\n{LAYER}', math.nan),
        (f'symbol = "Si"\n{LAYER}\nhardness = 2.0', 2.0),
    ],
)
def test_the_hardness_of_an_element_is_only_that_of_its_surface(lines, hardness):
    made = scene(lines)
    assert made.hardness / GPa == pytest.approx(hardness, nan_ok=True)
    words = {math.inf: "elastic"}.get(hardness, f"hardness {hardness:.3g} GPa")
    known = "hardness unknown" if math.isnan(hardness) else words
    assert known in first_line(made)
    assert Scene.parse(made.toml) == made


def test_pressures_are_not_compared_with_an_unknown_hardness():
    unknown, copper = (
        list(scene(lines).relax(validity="ignore"))[-1].validity
        for lines in ("contact_modulus = 100.0", 'symbol = "Cu"')
    )
    assert "hardness" in copper and "hardness" not in unknown


def test_the_hardness_of_the_base_is_not_that_of_a_layer_in_python():
    sphere = rc.RoughSphere(60.0)
    atoms = rc.substrate("Cu", (24, 24), sphere)
    atoms.calc = rc.RoughContact(sphere, solid=Layer(0.5, thickness=20.0))
    for hardness in (None, np.nan):
        steps = list(
            rc.load_path(
                atoms, penetrations=[0.5], validity=rc.Validity(hardness=hardness)
            )
        )
        assert "hardness" not in steps[-1].validity
    for step in rc.load_path(atoms, [0.5], validity=rc.Validity("ignore", 1e-4)):
        assert "hardness" in step.validity


def first_line(made):
    return bodies(made)["solid"]


@pytest.mark.parametrize(
    "lines, label",
    [
        ('symbol = "Si"', "Si, E* = 171.2 GPa, spacing"),
        ('material = "mica"', "mica, E* = 55.78 GPa, spacing"),
        ("contact_modulus = 100", "half space of given moduli, E* = 100 GPa, spacing"),
        ("anisotropic = true", "Cu, anisotropic continuum, E* = "),
        (f'symbol = "Si"\n{LAYER}', "layer of 2 nm, E* = 5 GPa, bonded to Si, E* = 1"),
        (
            f"{LAYER}\nrigid_base = true\nsliding = true",
            "layer of 2 nm, E* = 5 GPa, sliding on a rigid base, spacing",
        ),
        (
            f"{LAYER}\nrigid_base = true\nlayer_poisson = 0.3\nperiodic = true",
            "layer of 2 nm, E* = 5 GPa, bonded to a rigid base, heights from the mean "
            "plane of its surface, spacing",
        ),
    ],
)
def test_the_first_line_of_a_run_names_the_solid(lines, label):
    assert first_line(scene(lines)).startswith(label)


@pytest.mark.parametrize(
    "lines, half_space",
    [("", "the base without a layer"), ("rigid_base = true", "material of the layer")],
)
def test_the_theory_beside_a_layer_names_its_half_space(lines, half_space):
    described = theory(reference_for(scene(f"{LAYER}\n{lines}")))
    assert described["A/A_Hertz"].endswith(half_space)
