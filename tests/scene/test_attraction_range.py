"""Range of the attraction as a length: independent of the grid, resolved, fitted."""

import numpy as np
import pytest
from force_curves import sampled

from ase_roughcontact import cantilever_curve
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.elasticity.named_materials import ATTRACTION_RANGE
from ase_roughcontact.fitting.fit import fit_curve
from ase_roughcontact.fitting.force_curve import ForceCurve
from ase_roughcontact.scene import Scene, relax_loop

NM, NN = UNITS["nm"], UNITS["nN"]
SCENE = """
sphere = {{ radius = "30 nm" }}
path = {{ kind = "loop", deepest = "0.1 nm", tolerance = 5e-3, cantilever = 20.0 }}
[substrate]
model = "atoms"
spacing = "{spacing} nm"
contact_modulus = {modulus}
hardness = inf
[interaction]
kind = "{kind}"
work_of_adhesion = 0.05
attraction_range = "{reach} nm"
"""
SOFT_KINDS = "adhesive", "full"


def scene(kind, spacing=0.4, modulus=100.0, reach=0.165):
    return Scene.parse(
        SCENE.format(kind=kind, spacing=spacing, modulus=modulus, reach=reach)
    )


@pytest.mark.parametrize("kind", SOFT_KINDS)
def test_range_and_energy_do_not_depend_on_grid_and_modulus(kind):
    gaps = np.linspace(0.0, 5.0, 200)
    tails = []
    for spacing, modulus in (0.25, 100.0), (1.0, 0.01):
        wall = scene(kind, spacing, modulus).wall
        assert wall.attraction_range == pytest.approx(0.165 * NM)
        tails.append(wall.evaluate(wall.contact_distance + gaps))
    np.testing.assert_allclose(*tails, rtol=1e-9, atol=1e-15)
    tension = -tails[0][1].min() * wall.attraction_range / wall.work_of_adhesion
    assert 1.0 < tension < 1.8


@pytest.mark.parametrize("kind", SOFT_KINDS)
def test_the_pull_off_force_does_not_depend_on_the_grid(kind):
    fine, coarse = (
        relax_loop(scene(kind, spacing), validity="ignore").pull_off_force
        for spacing in (0.25, 0.6)
    )
    assert coarse == pytest.approx(fine, rel=0.01)


def test_the_cutoff_of_the_full_wall_is_relative_to_its_range():
    wall = scene("full", spacing=1.0).wall
    assert wall.cutoff == pytest.approx(10.0 * wall.attraction_range)
    given = scene("full").with_values({"interaction.cutoff": "0.1 nm"})
    message = r"cutoff must be larger than attraction_range, 0\.165 nm, got 0\.1 nm"
    with pytest.raises(ValueError, match=message):
        given.check()


MATERIALS = """
substrate = {{ model = "atoms", material = "{}" }}
sphere = {{ material = "SiO2", radius = "1 um" }}
[interaction]
kind = "{}"
"""


@pytest.mark.parametrize("material", ["SiO2", "PDMS"])
@pytest.mark.parametrize("kind", [*SOFT_KINDS, "dugdale", "exponential", "power-law"])
def test_materials_bring_a_range(material, kind):
    read = Scene.parse(MATERIALS.format(material, kind))
    assert read.wall.attraction_range == pytest.approx(ATTRACTION_RANGE * NM)
    given = read.with_values({"interaction.attraction_range": "0.3 nm"})
    assert given.wall.attraction_range == pytest.approx(3.0)


def test_a_grid_that_does_not_resolve_the_range_is_reported_with_one_it_resolves():
    assert scene("adhesive").warnings == []
    (warning,) = Scene.parse(MATERIALS.format("PDMS", "adhesive")).warnings
    assert "0.234 nm" in warning
    advised = warning.split('attraction_range = "')[1].split('"')[0]
    longer = MATERIALS.format("PDMS", "adhesive") + f'attraction_range = "{advised}"'
    assert Scene.parse(longer).warnings == []


def test_the_range_can_be_fitted():
    true = scene("full", spacing=0.6, reach=0.3)
    curve = cantilever_curve(relax_loop(true, validity="ignore"), true.cantilever)
    both = sampled(curve, 25.0, 60, 0.01 * NN, zero=30.0)
    measured = ForceCurve(both.depth[:60], both.force[:60], true.cantilever)
    free = ["work_of_adhesion", "attraction_range"]
    found = fit_curve(scene("full", spacing=0.6, reach=0.25), measured, free)
    assert found.converged
    np.testing.assert_allclose(found.values[:2], [0.05, 0.3], rtol=0.02)
    assert found.units[1] == "nm"
    assert not found.contributions["range"].any()  # it is not assumed
