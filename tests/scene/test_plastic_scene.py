"""Scenes with a plastic wall: hardness, errors, theory, runs and plans."""

import csv

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.elasticity.material import HARDNESS
from ase_roughcontact.interactions import PlasticWall
from ase_roughcontact.scene import Scene, relax_loop
from ase_roughcontact.scene.reference import reference_for
from ase_roughcontact.theory import plastic_area

TEXT = """
substrate = {{ {substrate} }}
sphere = {{ unit = "a0", radius = 200.0 }}
{roughness}
interaction = {{ kind = "plastic", {interaction} }}
path = {{ {path} }}
"""


def scene_of(
    substrate='symbol = "Cu"',
    interaction="permanent = false",
    path='control = "penetration", values = [0.5, 1.0, 0.5]',
    roughness='roughness = { rms_slope = 0.02, long_wavelength = "16 a0" }',
):
    scene = Scene.parse(TEXT.format(**locals()), "plastic.toml")
    scene.check()
    return scene


def test_hardness_is_from_the_table_or_given_once_in_either_section():
    scene = scene_of()
    assert scene.wall == PlasticWall(HARDNESS["Cu"] * UNITS["GPa"])
    assert scene.hardness == scene.wall.hardness
    harder = 0.9 * UNITS["GPa"]
    assert scene_of('symbol = "Cu", hardness = 0.9').wall.hardness == harder
    scene = scene_of(interaction="hardness = 0.9")
    assert scene.wall.hardness == scene.hardness == harder


@pytest.mark.parametrize(
    "substrate, interaction, message",
    [
        ('symbol = "Cu"', "hardness = -1.0", r"\[interaction\] hardness must be > 0"),
        (
            'symbol = "Cu", hardness = -1.0',
            "permanent = true",
            "hardness must be .*> 0",
        ),
        ('symbol = "Cu"', "permanent = 1", "permanent must be true or false, got 1"),
        (
            "contact_modulus = 100.0",
            "permanent = true",
            r"\[interaction\] .*needs hardness \(GPa\)",
        ),
    ],
)
def test_a_wrong_or_missing_hardness_is_named(substrate, interaction, message):
    with pytest.raises(ValueError, match=message):
        scene_of(substrate, interaction)


def test_run_counts_atoms_in_plastic_contact(tmp_path):
    scene = scene_of(interaction="permanent = true")
    steps = list(scene.run(tmp_path, validity="raise"))
    assert steps[1].plastic_atoms > 0 == steps[2].plastic_atoms
    assert steps[2].normal_force < 0.2 * steps[0].normal_force
    with (tmp_path / "curve.csv").open() as file:
        rows = list(csv.DictReader(line for line in file if line[0] != "#"))
    atoms = [step.plastic_atoms for step in steps]
    assert [int(row["plastic_atoms"]) for row in rows] == atoms
    forces = [step.normal_force for step in steps]
    assert [step.normal_force for step in scene.run(tmp_path)] == forces


def test_loads_beyond_the_elastic_range_are_planned():
    scene = scene_of(path='control = "load", values = [1.0, 20.0]')
    plan, steps = scene.plan(), list(scene.relax(validity="raise"))
    assert all(step.converged for step in steps)
    windows = steps[-1].window, plan.steps[-1].window
    sides = [int(window.split("x")[0]) for window in windows]
    assert 0.5 < sides[0] / sides[1] < 2.0


def test_theory_is_plastic_where_the_contact_is():
    rough, smooth = scene_of(), scene_of(roughness="")
    loads = np.array([1e-3, 1.0, 1e3]) * UNITS["nN"]
    plastic = plastic_area(loads, rough.wall.hardness)
    for scene in (rough, smooth):
        assert_allclose(scene.bodies.predicted_area(loads)[-1], plastic[-1], rtol=1e-6)
        assert "hardness of 0.369 GPa" in reference_for(scene).explanation
    elastic = smooth.bodies.predicted_area(loads)[0]
    assert_allclose(elastic, smooth.bodies.hertz_area(loads[0]))
    softer = rough.bodies.predicted_area(loads[1])
    harder = scene_of(interaction="hardness = 100.0").bodies.predicted_area(loads[1])
    assert harder < softer <= plastic[1] * (1 + 1e-9)


def test_loop_dissipates_energy():
    path = 'kind = "loop", deepest = 1.0, step = 0.3, tolerance = 1e-2'
    scene = scene_of(interaction="permanent = true", path=path, roughness="")
    loop = relax_loop(scene, validity="ignore")
    assert loop.dissipated_energy > 0.5 * loop.approach[-1].energy
