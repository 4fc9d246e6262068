"""Every key of a scene file is converted to ASE's units and used.

The expected conversion factors follow from the elementary charge.
"""

import json
import math
import re
from collections import defaultdict
from operator import attrgetter

import numpy as np
import pytest

from ase_roughcontact.ensemble.columns import scene_columns
from ase_roughcontact.scene import Scene, default_text

CHARGE = 1.602176634e-19  # eV in J
NN = 1e-19 / CHARGE  # in eV/Å
GPA = 1e-21 / CHARGE  # in eV/Å^3
J_PER_M2 = 1e-20 / CHARGE  # in eV/Å^2
A0, MODULUS = 2.5, 80.0


def scene_with(changes=(), **tables):
    """Return the scene of a file with changed keys or tables; None removes one."""
    document = {k: dict(v) for k, v in (SCENE | tables).items() if v is not None}
    for key, value in dict(changes).items():
        title, _, name = key.partition(".")
        document[title][name] = value
    lines = []
    for title, keys in document.items():
        lines += [f"[{title}]"]
        lines += [f"{k} = {json.dumps(v)}" for k, v in keys.items() if v is not None]
    return Scene.parse("\n".join(lines))


def relaxed_by(scene):
    return type(scene.optimizer(scene.atoms(), logfile=None)).__name__


# Values of keys, the quantities that they define (an attribute or a function of the
# scene) in ASE's units, and other values of the keys.
KEYS = {
    "substrate.material": ("Au", lambda s: s.atoms().symbols[0], "Au", "Cu"),
    "substrate.spacing": (A0, lambda s: s.atoms().positions[1, 1], A0, 3.0),
    "substrate.contact_modulus": (MODULUS, "contact_modulus", MODULUS * GPA, 90.0),
    "substrate.hardness": (0.7, "hardness", 0.7 * GPA, 0.8),
    "substrate.yield_strength": (0.3, "bodies.yield_strength", 0.3 * GPA, 0.4),
    "substrate.shape": ([32, 48], lambda s: s.atoms().cell[0, 0], 32.0 * A0, [36, 48]),
    "substrate.periodic": (True, lambda s: s.atoms().pbc[1], True, False),
    "substrate.model": ("continuum", "area_column", "continuum_area", "atoms"),
    "sphere.radius": ("60 a0", "surface.radius", 60.0 * A0, "70 a0"),
    "sphere.profile": ("sphere", "surface.profile", "sphere", "paraboloid"),
    "roughness.rms_slope": (0.2, "rough.rms_slope", 0.2, 0.1),
    "roughness.hurst": (0.7, "rough.hurst", 0.7, 0.8),
    "roughness.short_wavelength": ("5 a0", "rough.short_wavelength", 5.0 * A0, "4 a0"),
    "roughness.long_wavelength": ("16 a0", "rough.long_wavelength", 16.0 * A0, "20 a0"),
    "roughness.longest_wavelength": (
        "24 a0",
        "rough.longest_wavelength",
        24.0 * A0,
        "30 a0",
    ),
    "roughness.seed": (3, "rough.seed", 3, 4),
    "roughness.random_amplitudes": (True, "rough.random_amplitudes", True, False),
    "roughness.normalise": ("ensemble", "rough.normalise", "ensemble", "realisation"),
    "roughness.domain": ("120 a0", "rough.side", 120.0 * A0, "150 a0"),
    "roughness.anisotropy": (2.0, "rough.anisotropy", 2.0, 3.0),
    "roughness.direction": (30.0, "rough.direction", 30.0, 40.0),
    "interaction.kind": ("full", "wall.attractive", True, "repulsive"),
    "interaction.work_of_adhesion": (0.3, "wall.work_of_adhesion", 0.3 * J_PER_M2, 0.4),
    "interaction.cutoff": ("7 a0", "wall.cutoff", 7.0 * A0, "8 a0"),
    "path.loads": ([2.0, 50.0], lambda s: s.targets[0], 2.0 * NN, [3.0]),
    "solver.optimizer": ("LBFGS", relaxed_by, "LBFGS", "FIRE"),
    "solver.relative_error": (0.001, "grid_model.error", 1e-3, 1e-4),
    "solver.fmax": (1e-05, "fmax", 1e-5, 1e-6),
    "solver.max_steps": (77, "solver.max_steps", 77, 78),
    "solver.engine": ("pyfftw", lambda s: s.problem.fft["engine"], "pyfftw", "ducc0"),
}
SCENE = defaultdict(dict)
for key, (value, *_) in KEYS.items():
    SCENE[key.partition(".")[0]][key.partition(".")[2]] = value
SCENE["substrate"]["refine"] = 1
# The same of the parameters of other walls, with the kind and all parameters.
POWER_LAW = {"kind": "power-law", "work_of_adhesion": 0.3, "attraction_range": "1.5 a0"}
POWER_LAW |= {"exponent": 2.5, "relative_cutoff": 12.0}
PLASTIC = {"kind": "plastic", "permanent": True, "hardness": 0.4}
OF_WALLS = {
    "interaction.attraction_range": (POWER_LAW, "attraction_range", 1.5 * A0),
    "interaction.exponent": (POWER_LAW, "exponent", 2.5),
    "interaction.relative_cutoff": (POWER_LAW, "cutoff", 12.0 * 1.5 * A0),
    "interaction.permanent": (PLASTIC, "permanent", True),
    "interaction.hardness": (PLASTIC, "hardness", 0.4 * GPA),
}
# Keys that replace others, or choose columns or frames, tested separately.
INSTEAD = {
    "output.columns",
    "output.keep",
    "substrate.elastic_constants",
    "path.penetrations",
    "path.heights",
    "sphere.unit",
    "solver.accuracy",
    "roughness.unit",
}


def keys_of(text):
    """Return the keys of a scene file with their tables, including commented keys."""
    _, *parts = re.split(r"^\[(\w+)\]", text, flags=re.M)
    keys = [re.findall(r"^#?(\w+) = ", part, re.M) for part in parts[1::2]]
    found = zip(parts[::2], keys, strict=True)
    return {f"{title}.{key}" for title, names in found for key in names}


def test_the_table_has_every_key_of_a_scene_file():
    assert keys_of(default_text()) == KEYS.keys() | OF_WALLS.keys() | INSTEAD


def value_of(key, scene):
    read = KEYS[key][1]
    return (attrgetter(read) if isinstance(read, str) else read)(scene)


def expected_of(key):
    expected = KEYS[key][2]
    return pytest.approx(expected, rel=1e-7) if type(expected) is float else expected


@pytest.mark.parametrize("key", KEYS)
def test_keys_are_converted_to_the_units_of_ase(key):
    assert value_of(key, scene_with()) == expected_of(key)
    changes = {key: KEYS[key][3]}
    if key == "interaction.kind":  # which has neither work of adhesion nor cutoff
        changes |= {"interaction.work_of_adhesion": None, "interaction.cutoff": None}
    assert value_of(key, scene_with(changes)) != expected_of(key)


@pytest.mark.parametrize(
    "key, values",
    [
        ("sphere.radius", ["15 nm", "150 Å", "0.015 µm", "60 a0"]),
        ("substrate.spacing", ["0.25 nm", "2.5 Å"]),
        ("substrate.contact_modulus", ["0.08 TPa", "80 GPa", "8e4 MPa"]),
        ("substrate.hardness", ["0.7 GPa", "700 MPa"]),
        ("roughness.long_wavelength", ["4 nm", "40 Å", "16 a0"]),
        ("interaction.work_of_adhesion", ["300 mJ/m²", "0.3 N/m"]),
        ("interaction.cutoff", ["1.75 nm", "7 a0"]),
        ("solver.fmax", [f"{1e-5 / NN} nN", "1e-5 eV/Å"]),
        ("path.loads", [["2 nN"], ["2000 pN"], ["0.002 µN"]]),
    ],
)
def test_quantities_may_have_a_unit(key, values):
    for value in values:
        given = scene_with({key: value})
        given.check()
        assert value_of(key, given) == expected_of(key)
        assert Scene.parse(given.toml) == given
        assert scene_columns(given)["work_of_adhesion"] == pytest.approx(0.3)


def test_units_of_sections_and_of_listed_values():
    rough = {"short_wavelength": 1.25, "long_wavelength": 4.0, "unit": "nm"}
    path = {"control": "penetration", "values": ["0.02 nm", 0.3, "0.1 a0"]}
    given = scene_with(
        sphere={"radius": 15.0, "unit": "nm"}, roughness=rough, path=path
    )
    assert given.radius == pytest.approx(150.0)
    assert given.rough.short_wavelength == pytest.approx(12.5)
    assert given.rough.long_wavelength == pytest.approx(40.0)
    np.testing.assert_allclose(given.targets, [0.2, 0.3, 0.1 * A0])
    soft = {"kind": "loop", "deepest": 1.0, "cantilever": "200 mN/m"}
    assert scene_with(path=soft).cantilever == pytest.approx(0.2 * J_PER_M2)


@pytest.mark.parametrize(
    "section, line, message",
    [
        ("sphere", 'radius = "15 inch"', r"unknown unit of radius 'inch'\. Known: a0"),
        ("sphere", 'radius = "nm"', 'radius must be a number, or .* such as "3 nm"'),
        ("sphere", 'radius = 15.0\nunit = "miles"', "unknown unit 'miles'"),
        ("path", 'values = ["0.2 nm"]', r"unknown unit of loads 'nm'\. Known: nN"),
        ("substrate", 'hardness = "3 GPA"', "hardness 'GPA'; did you mean 'GPa'"),
        ("substrate", 'contact_modulus = "stiff"', "such as \"3 GPa\", got 'stiff'"),
        ("substrate", "contact_modulus = true", "must be a number or a string"),
        ("path", 'kind = "loop"\ncantilever = "5"', "such as \"3 N/m\", got '5'"),
        (
            "roughness",
            'unit = "nm"\nshort_wavelength = 0.4\nlong_wavelength = 4.0',
            r"at least 0\.51\d+ nm, .* got 0\.4 nm",
        ),
        (
            "roughness",
            'unit = "nm"\nshort_wavelength = 8.0\nlong_wavelength = 4.0',
            r"short_wavelength = 8 nm, got 4",
        ),
    ],
)
def test_wrong_units_are_errors_of_the_key_in_its_unit(section, line, message):
    path = "" if section == "path" else "[path]\nvalues = [1.0]\n"
    solid = "" if section == "substrate" else '[substrate]\nmaterial = "Cu"\n'
    with pytest.raises(ValueError, match=rf"\[{section}\] .*{message}"):
        Scene.parse(f"{solid}[{section}]\n{line}\n{path}").check()


@pytest.mark.parametrize("key", OF_WALLS)
def test_parameters_of_walls_are_converted_to_the_units_of_ase(key):
    interaction, name, expected = OF_WALLS[key]
    usual = {k: v for k, v in interaction.items() if f"interaction.{k}" != key}
    given, default = (scene_with(interaction=i).wall for i in (interaction, usual))
    assert getattr(given, name) == pytest.approx(expected)
    assert getattr(default, name) != pytest.approx(expected)


@pytest.mark.parametrize("control", ["load", "penetration", "height"])
def test_targets_are_in_nanonewton_or_in_angstrom(control):
    def targets(path):
        scene = Scene.parse(f"[substrate]\ncontact_modulus = 1.0\n[path]\n{path}")
        assert scene.path.control == control
        assert Scene.parse(scene.toml) == scene
        return scene.targets / (NN if control == "load" else 1.0)

    key, ends = f"{control}s", "first = 2, last = 50.0, steps = 3"
    np.testing.assert_allclose(targets(f"{key} = [1.5, 3]"), [1.5, 3.0])
    np.testing.assert_allclose(targets(f"{key} = {{ {ends} }}"), [2.0, 26.0, 50.0])
    geometric = f'{key} = {{ {ends}, scale = "geometric" }}'
    np.testing.assert_allclose(targets(geometric), [2.0, 10.0, 50.0])
    old = f'control = "{control}"\nvalues = [1.5, 3.0]'
    np.testing.assert_allclose(targets(old), [1.5, 3.0])
    old = f'control = "{control}"\n' + ends.replace(", ", "\n")
    np.testing.assert_allclose(targets(old), [2.0, 10.0, 50.0])


def test_elastic_constants_are_in_gigapascal_and_by_default_of_the_crystal():
    crystal = scene_with(substrate={"symbol": "Au"})
    crystal = crystal.with_values({"substrate.hardness": math.inf})
    assert Scene.parse(crystal.toml) == crystal
    assert crystal.spacing == pytest.approx(4.08 / 2**0.5)
    assert 80.0 * GPA < crystal.contact_modulus < 110.0 * GPA
    # isotropic: E = mu (3 lambda + 2 mu)/(lambda + mu), nu = lambda/2(lambda + mu)
    mu, lame = 20.0, 40.0
    constants = [lame + 2.0 * mu, f"{lame} GPa", f"{1e3 * mu} MPa"]
    scene = scene_with(substrate={"symbol": "Au", "elastic_constants": constants})
    nu = 0.5 * lame / (lame + mu)
    young = mu * (3.0 * lame + 2.0 * mu) / (lame + mu)
    assert scene.contact_modulus == pytest.approx(young / (1.0 - nu**2) * GPA)


def relaxed_with(values=(2.0,), shape=(40, 40), **solver):
    """Results of steps in a window with the given keys of [solver]."""
    substrate = {**SCENE["substrate"], "shape": shape, "periodic": False}
    path = {"control": "penetration", "values": values}
    tables = {"roughness": None, "interaction": {}, "path": path, "solver": solver}
    scene = scene_with(substrate=substrate | {"model": "atoms"}, **tables)
    return list(scene.relax())


@pytest.mark.parametrize("shape", ["auto", [40, 40]], ids=str)
def test_a_given_window_is_kept_and_an_automatic_one_follows_the_contact(shape):
    windows = {record.window for record in relaxed_with([0.5, 4.0], shape)}
    assert len(windows) == (2 if shape == "auto" else 1)
    assert ("40x40" in windows) == (shape != "auto")


@pytest.mark.parametrize("accuracy", [1e-1, 1e-5])
def test_steps_have_accuracy_tolerance_and_iterations_of_the_scene(accuracy):
    (record,) = relaxed_with(accuracy=accuracy)
    mean = record.normal_force / record.repulsive_atoms
    assert 0.02 * accuracy < record.tolerance / mean < 0.2501 * accuracy
    (record,) = relaxed_with(accuracy=1e-1, fmax=1e-7)
    assert record.tolerance == pytest.approx(1e-7)
    (record,) = relaxed_with(optimizer="LBFGS", max_steps=3)
    assert (record.iterations, record.converged) == (3, False)
