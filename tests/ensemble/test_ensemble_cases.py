"""Cases of ensembles: combinations of values, and names that depend on these alone."""

import numpy as np
import pytest
from ensemble_scenes import SCENE, WALLS

from ase_roughcontact.ensemble import case_of, product
from ase_roughcontact.scene import HeterogeneityConfig


def test_product_combines_values_of_keys_and_sections_the_last_fastest():
    scenes = product(SCENE, {"sphere.radius": [50.0, 60.0], "interaction": WALLS})
    got = [(scene.sphere.radius, scene.interaction) for scene in scenes]
    assert got == [(radius, wall) for radius in (50.0, 60.0) for wall in WALLS]
    assert {scene.roughness for scene in scenes} == {SCENE.roughness}


@pytest.mark.parametrize("key", ["sphere.radius", "roughness.rms_slope", "path.last"])
def test_names_of_cases_depend_on_twelve_digits(key):
    values = (3.0, 3.0 * (1.0 + 1e-11), 3.0 * (1.0 + 1e-14))
    names = [case_of(each) for each in product(SCENE, {key: values})]
    assert names[0] == names[2] != names[1]


@pytest.mark.parametrize(
    "choices, message",
    [
        ({"spere.radius": [1.0]}, "unknown section 'spere'.*'sphere'"),
        ({"sphere.radus": [1.0]}, r"\[sphere\] unknown key 'radus'.*'radius'"),
        ({"sphere.radius": []}, "sphere.radius .* one value"),
        ({"roughness": [None], "roughness.seed": [3]}, r"has no \[roughness\]"),
        ({"interaction.kind": ["soft"]}, "'soft'"),
    ],
)
def test_product_rejects_unknown_keys_and_keys_without_values(choices, message):
    with pytest.raises(ValueError, match=message):
        product(SCENE, choices)


def test_case_depends_on_every_value_and_not_on_its_type():
    same = product(SCENE, {"sphere.radius": [60, 60.0, np.float64(60)]})
    assert len({case_of(scene) for scene in same}) == 1
    others = product(SCENE, {"roughness.seed": range(20), "solver.max_steps": [5, 6]})
    assert len({case_of(scene) for scene in others}) == 40


def test_case_of_a_scene_with_a_local_work_of_adhesion_depends_on_its_seed():
    scene = SCENE.with_values({"heterogeneity": HeterogeneityConfig(rms=0.3)})
    others = product(scene, {"heterogeneity.seed": [0, 1]})
    names = [case_of(each) for each in (SCENE, scene, *others)]
    assert names[1] == names[2] and len(set(names)) == 3
