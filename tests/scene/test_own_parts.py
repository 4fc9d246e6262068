"""Parts that are defined outside of the package, named in a scene file."""

import math
from dataclasses import dataclass
from unittest.mock import patch

import numpy as np
import pytest
from ase.optimize import FIRE2

from ase_roughcontact import (
    FrictionLaw,
    HardWall,
    RoughContact,
    RoughSphere,
    load_path,
    substrate,
)
from ase_roughcontact._util.registry import Registry
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.cli import main
from ase_roughcontact.elasticity import SOLIDS, ElasticSolid, Isotropic
from ase_roughcontact.elasticity.material import HARDNESS
from ase_roughcontact.interactions import LAWS, Parameter
from ase_roughcontact.optimize.settings import on_modes
from ase_roughcontact.scene import OPTIMIZERS, PathKind, Scene
from ase_roughcontact.scene.path_kind import PATHS
from ase_roughcontact.scene.solid import label_of
from ase_roughcontact.topography import ROUGHNESSES, Topography

SLIDING = """
[substrate]
model = "atoms"
contact_modulus = 80.0
poisson = 0.3
spacing = 2.5
hardness = inf
[sphere]
radius = "20 nm"
[interaction]
kind = "hard"
[path]
kind = "sliding"
values = [20.0]
displacements = [0, 1.0]
steps = 2
[friction]
"""


class Cohesive(FrictionLaw):
    """Friction proportional to pressure beyond a cohesion, within a radius."""

    parameters = {
        "slope": Parameter(),
        "cohesion": Parameter("GPa", default=0.0, above=-1.0),
        "radius": Parameter("a0", default=1e3),
    }

    def __init__(self, slope, cohesion, radius):
        self.slope, self.cohesion, self.radius = slope, cohesion, radius

    def bound(self, pressure, x, y):
        within = np.hypot(x, y) < self.radius
        return within * (self.slope * pressure + self.cohesion)


class Coated(ElasticSolid):
    """Isotropic half space below a thin soft coating (Winkler foundation)."""

    parameters = {
        "modulus": Parameter("GPa"),
        "thickness": Parameter("a0", optional=True),
    }

    def __init__(self, modulus, thickness=0.0):
        self.contact_modulus, self.coating = modulus, thickness / modulus

    def wave_compliance(self, qx, qy):
        return Isotropic(self.contact_modulus).wave_compliance(qx, qy) + self.coating

    def cell_compliance(self, i, j, spacing):
        bare = Isotropic(self.contact_modulus).cell_compliance(i, j, spacing)
        return bare + self.coating * ((np.asarray(i) == 0) & (np.asarray(j) == 0))


class Film(Coated):
    """The same as a layer of finite thickness."""

    thickness = 10.0
    half_space = "on the base of the film"

    def label(self, name):
        return f"film on {super().label(name)}"


class Ripples(Topography):
    """Waves along x; theory takes them for a narrow self-affine spectrum."""

    parameters = {"rms_slope": Parameter(), "wavelength": Parameter("a0")}
    hurst = 0.5

    def __init__(self, rms_slope, wavelength):
        self.rms_slope, self.short_wavelength = rms_slope, wavelength
        self.long_wavelength = 1.01 * wavelength
        self.number = 2.0 * np.pi / wavelength

    def heights(self, shape, spacing, origin=(0.0, 0.0)):
        x = origin[0] + spacing * np.arange(shape[0])
        wave = np.sqrt(2.0) * self.rms_slope / self.number * np.cos(self.number * x)
        return np.repeat(wave[:, None], shape[1], axis=1)

    def lowest(self, spacing, origin=(0.0, 0.0)):
        return -np.sqrt(2.0) * self.rms_slope / self.number


@dataclass(frozen=True)
class Twice(PathKind):
    """Two steps of the same penetration."""

    control = "penetration"
    depth: float = 1.0

    def targets(self, bodies):
        return np.array([self.depth, self.depth])


@pytest.fixture(autouse=True)
def known():
    """Registries with these parts, which other tests do not have."""
    Cohesive.kind, Twice.kind, Coated.kind = "cohesive", "twice", "coated"
    Ripples.kind, Film.kind = "ripples", "film"
    optimizers = {"Own": on_modes(FIRE2)}
    with (
        patch.dict(LAWS, cohesive=Cohesive),
        patch.dict(SOLIDS, coated=Coated, film=Film),
        patch.dict(ROUGHNESSES, ripples=Ripples),
        patch.dict(PATHS, twice=Twice),
        patch.dict(OPTIMIZERS, optimizers),
    ):
        yield


def lateral_forces(law):
    """Forces of the steps of sliding under a friction law."""
    return [step.lateral_force_x for step in Scene.parse(SLIDING + law).relax()]


def test_a_friction_law_has_keys_with_units_of_its_own():
    text = 'kind = "cohesive"\nslope = 0.2\ncohesion = "30 MPa"\nradius = "1 nm"\n'
    law = Scene.parse(SLIDING + text).friction.law_on(2.5)
    assert law.slope == 0.2
    assert law.cohesion == pytest.approx(0.03 * UNITS["GPa"])
    assert law.radius == pytest.approx(10.0)


def test_a_friction_law_of_ones_own_slides_like_the_same_law_of_the_package():
    own = lateral_forces('kind = "cohesive"\nslope = 0.3\n')
    assert own == lateral_forces("coefficient = 0.3\n")
    assert own[-1] > 0.0
    assert own[-1] > lateral_forces('kind = "cohesive"\nslope = 0.2\n')[-1]


@pytest.mark.usefixtures("no_pictures")
def test_the_command_runs_a_scene_with_a_friction_law_of_ones_own(tmp_path, capsys):
    file, out = tmp_path / "own.toml", tmp_path / "results"
    file.write_text(SLIDING + 'kind = "cohesive"\nslope = 0.3\ncohesion = 0.1\n')
    assert main(["run", str(file), "--out", str(out)]) == 0
    assert "cohesive, slope 0.3, cohesion 0.1 GPa" in capsys.readouterr().out
    assert Scene.read(out / "scene.toml").friction.parameters["cohesion"] == 0.1


@pytest.mark.parametrize(
    ("law", "message"),
    [
        ('kind = "cohesive"', "kind = .cohesive. needs slope"),
        ('kind = "cohesive"\nslope = -1.0', "slope must be > 0"),
        ('kind = "cohesive"\ncoefficient = 0.3', "has no coefficient"),
        ('kind = "cohesion"', "did you mean .cohesive."),
        ("slop = 0.3", "did you mean .slope."),
    ],
)
def test_wrong_keys_of_a_friction_law_are_refused_by_name(law, message):
    with pytest.raises(ValueError, match=rf"\[friction\].*{message}"):
        Scene.parse(SLIDING + law).check()


def test_a_scene_file_names_an_optimizer_and_a_kind_of_path():
    text = """
    [substrate]
    contact_modulus = 80.0
    shape = [12, 12]
    [sphere]
    radius = "5 nm"
    [path]
    kind = "twice"
    depth = 0.5
    [solver]
    optimizer = "Own"
    """
    own = list(Scene.parse(text).relax())
    usual = list(Scene.parse(text.replace('"Own"', '"NewtonKrylov"')).relax())
    assert len(own) == 2
    assert own[0].normal_force == pytest.approx(usual[0].normal_force, rel=1e-2)


def test_a_layer_of_ones_own_names_itself_and_has_no_hardness_of_the_element():
    text = '[substrate]\nkind = "{}"\nsymbol = "Cu"\nmodulus = 80\n'
    text += '[sphere]\nradius = "9 a0"'
    half_space = Scene.parse(text.format("coated"))
    film = Scene.parse(text.format("film"))
    assert half_space.hardness == HARDNESS["Cu"] * UNITS["GPa"]
    assert math.isnan(film.hardness)
    assert label_of(film.substrate, film.solid) == "film on film, E* = 80 GPa"
    assert film.bodies.labelled("Hertz") == "Hertz, on the base of the film"


def test_a_registry_names_what_it_has():
    registry = Registry("kind of thing", {"first": 1, "second": 2})
    assert registry.find("first") == 1
    with pytest.raises(ValueError, match=r"kind of thing 'frist'.*first.*second"):
        registry.find("frist")


PRESSED = """
[sphere]
radius = "20 nm"
[interaction]
kind = "hard"
[path]
values = [20.0]
[substrate]
hardness = inf
spacing = 2.5
"""


def area_on(substrate):
    """Contact area under a load."""
    (step,) = Scene.parse(PRESSED + substrate).relax()
    return step.contact_area


def test_a_solid_of_ones_own_has_keys_with_units_of_its_own():
    keys = 'kind = "coated"\nmodulus = "80 GPa"\nthickness = "1 nm"\n'
    solid = Scene.parse(PRESSED + keys).solid
    assert solid.contact_modulus == pytest.approx(80.0 * UNITS["GPa"])
    assert solid.coating == pytest.approx(10.0 / (80.0 * UNITS["GPa"]))


def test_a_solid_of_ones_own_is_pressed_like_the_same_solid_of_the_package():
    own, usual = 'kind = "coated"\nmodulus = 80.0\n', "contact_modulus = 80.0\n"
    assert area_on(own) == area_on(usual)
    assert area_on(own + "thickness = 2.0\n") > 1.1 * area_on(own)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ('kind = "coated"', "kind = .coated. needs modulus"),
        (
            'kind = "coated"\nmodulus = 8.0\npoisson = 0.3',
            "poisson .*omit it",
        ),
        ('kind = "coted"', "did you mean .coated."),
        ("modulus = 80.0", "modulus needs kind"),
    ],
)
def test_wrong_keys_of_a_solid_are_refused_by_name(keys, message):
    with pytest.raises(ValueError, match=rf"\[substrate\].*{message}"):
        Scene.parse(PRESSED + keys).check()


def test_a_roughness_of_ones_own_is_pressed_as_in_a_script():
    keys = '[roughness]\nkind = "ripples"\nrms_slope = 0.05\nwavelength = "2 nm"\n'
    text = PRESSED + 'contact_modulus = 80.0\nmodel = "atoms"\n'
    (step,) = Scene.parse(text + keys).relax(validity="ignore")
    (smooth,) = Scene.parse(text).relax(validity="ignore")
    sphere = RoughSphere(200.0, Ripples(0.05, 20.0))
    atoms = substrate("Cu", (64, 64), sphere, spacing=2.5, fixed=False)
    modulus = 80.0 * UNITS["GPa"]
    atoms.calc = RoughContact(sphere, modulus, HardWall())
    (own,) = load_path(atoms, loads=[20.0 * UNITS["nN"]], validity="ignore")
    assert step.repulsive_atoms == own.repulsive_atoms
    assert step.penetration == pytest.approx(own.penetration, rel=1e-3)
    assert step.contact_area < smooth.contact_area


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ('kind = "ripples"', "kind = .ripples. needs wavelength"),
        ('kind = "ripples"\nwavelength = "8 a0"\nhurst = 0.6', "has no hurst"),
        ('kind = "ripple"', "did you mean .ripples."),
        ("wavelength = '8 a0'", "wavelength needs kind"),
    ],
)
def test_wrong_keys_of_a_roughness_are_refused_by_name(keys, message):
    text = PRESSED + "contact_modulus = 80.0\n[roughness]\n" + keys
    with pytest.raises(ValueError, match=rf"\[roughness\].*{message}"):
        Scene.parse(text).check()
