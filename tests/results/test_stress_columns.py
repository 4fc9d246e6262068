"""Largest stresses below the surface, and where the solid yields, as columns."""

import math

import numpy as np
import pytest
from built import atoms_under

import ase_roughcontact as rc
from ase_roughcontact.elasticity import Isotropic, Layer
from ase_roughcontact.elasticity.greens import ElasticSolid
from ase_roughcontact.results.record import STRESS_COLUMNS
from ase_roughcontact.scene import Scene
from ase_roughcontact.theory import Hertz

RADIUS, MODULUS = 2000.0, 1.0
SPHERE, SOLID = rc.RoughSphere(RADIUS), Isotropic(MODULUS, 0.3)
COLUMNS = sorted(STRESS_COLUMNS)
LOAD = 40.0


def pressed(solid=SOLID, wall=None, columns=COLUMNS, load=LOAD, **options):
    """Step of a smooth sphere under a load."""
    atoms = atoms_under(
        SPHERE, wall or rc.HardWall(), (64, 64), solid=solid, fixed=False
    )
    output = rc.Output(columns=columns)
    (step,) = rc.load_path(atoms, loads=[load], output=output, window="auto", **options)
    return step


# Johnson, Contact Mechanics (1985), Sec. 6.1
def test_stresses_below_a_smooth_sphere():
    step, hertz = pressed(), Hertz(RADIUS, MODULUS)
    radius = float(hertz.contact_radius(LOAD))
    largest = 1.5 * LOAD / (math.pi * radius**2)
    assert step.largest_von_mises == pytest.approx(0.62 * largest, rel=0.01)
    assert step.largest_tresca == pytest.approx(0.62 * largest, rel=0.01)
    assert step.von_mises_depth == pytest.approx(0.48 * radius, rel=0.03)
    assert step.tresca_depth == pytest.approx(0.48 * radius, rel=0.03)
    assert abs(step.von_mises_x) < 1.0 and abs(step.von_mises_y) < 1.0
    # the largest tension is around the contact, at the surface: (1 - 2 nu) p0/3
    assert 0.04 < step.largest_tension / largest < 0.4 / 3
    assert 1.0 < math.hypot(step.tension_x, step.tension_y) / radius < 1.3


def test_stresses_are_not_known_without_the_poisson_ratio():
    step = pressed(Isotropic(MODULUS))
    assert all(math.isnan(getattr(step, name)) for name in COLUMNS)
    assert "Poisson's ratio" in step.not_known["largest_von_mises"]


class HalfKnown(Isotropic):
    """Solid without a response to the mean pressure of a periodic cell."""

    uniform_response = ElasticSolid.uniform_response
    has_subsurface = ElasticSolid.has_subsurface


def test_stresses_are_not_known_without_the_response_to_uniform_tractions():
    step = pressed(HalfKnown(MODULUS, 0.3), columns=["largest_von_mises"])
    assert math.isnan(step.largest_von_mises)


def test_places_of_stresses_are_not_known_without_contact():
    atoms = atoms_under(SPHERE, rc.HardWall(), (32, 32), solid=SOLID)
    output = rc.Output(columns=COLUMNS)
    (step,) = rc.load_path(atoms, penetrations=[-1.0], output=output)
    assert step.largest_von_mises == step.largest_tension == 0.0
    assert math.isnan(step.von_mises_depth) and math.isnan(step.tension_x)
    assert "pressure" in step.not_known["von_mises_depth"]


def test_stress_on_a_layer_of_the_same_material_is_the_stress_of_the_half_space():
    layer = Layer(MODULUS, 9.0, MODULUS, 0.3, 0.3)
    columns = ["largest_von_mises"]
    expected, found = pressed(columns=columns), pressed(layer, columns=columns)
    assert found.largest_von_mises == pytest.approx(expected.largest_von_mises, 1e-3)


def test_friction_brings_the_largest_stress_to_the_surface():
    found = {}
    for friction in (0.05, 0.6):
        atoms = atoms_under(SPHERE, rc.HardWall(), (96, 96), solid=SOLID, fixed=False)
        *_, step = rc.sliding_path(
            atoms,
            rc.Coulomb(friction),
            loads=[LOAD, LOAD],
            displacements=[0.0, 5.0],
            output=rc.Output(columns=["von_mises_depth", "tension_x"]),
        )
        found[friction] = step
    assert found[0.05].von_mises_depth > 8.0
    assert found[0.6].von_mises_depth < 2.0
    assert found[0.6].tension_x < -15.0  # behind the sphere, which moves along x


def test_step_that_yields_below_the_surface_is_marked():
    largest = pressed().largest_von_mises
    for factor, marked in ((0.9, True), (1.1, False)):
        limits = rc.Validity("ignore", math.inf, yield_strength=factor * largest)
        validity = pressed(validity=limits, columns=None).validity
        assert ("largest von Mises stress/yield strength = 1.11" in validity) == marked


SCENE = """
[substrate]
contact_modulus = 100.0
poisson = 0.3
hardness = inf
yield_strength = "1 GPa"
[sphere]
unit = "a0"
radius = 1000.0
[interaction]
kind = "hard"
[path]
values = [500.0]
[output]
columns = ["largest_von_mises"]
"""


@pytest.mark.filterwarnings("ignore::ase_roughcontact.ValidityWarning")
def test_scene_asks_for_stresses_and_marks_what_yields(tmp_path):
    file = tmp_path / "scene.toml"
    file.write_text(SCENE)
    (step,) = Scene.read(file).relax()
    assert step.largest_von_mises == pytest.approx(0.62 * step.largest_pressure, 0.01)
    assert "largest von Mises stress/yield strength" in step.validity


def test_scene_needs_the_poisson_ratio_for_stresses(tmp_path):
    file = tmp_path / "scene.toml"
    file.write_text(SCENE.replace("poisson = 0.3\n", ""))
    with pytest.raises(ValueError, match="give poisson"):
        Scene.read(file)


def test_yield_strength_must_be_positive():
    with pytest.raises(ValueError, match="yield_strength"):
        rc.Validity(yield_strength=-np.float64(1.0))


@pytest.mark.filterwarnings("ignore::ase_roughcontact.ValidityWarning")
def test_run_is_resumed_with_a_column_of_stress(tmp_path):
    values = "values = [500.0]", "values = [500.0, 600.0]"
    without = SCENE.replace('columns = ["largest_von_mises"]', "")
    without = without.replace('yield_strength = "1 GPa"', "")
    (first,) = Scene.parse(without).run(tmp_path)
    steps = list(Scene.parse(SCENE.replace(*values)).run(tmp_path))
    assert steps[0].normal_force == first.normal_force
    assert math.isnan(steps[0].largest_von_mises) and steps[1].largest_von_mises > 0.0
