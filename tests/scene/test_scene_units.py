"""Every key of a scene file is converted to ASE's units and used.

The expected conversion factors follow from the elementary charge.
"""

import json
import math
import re

import numpy as np
import pytest

from ase_roughcontact.scene import Scene, default_text

CHARGE = 1.602176634e-19  # eV in J
NN = 1e-19 / CHARGE  # in eV/Å
GPA = 1e-21 / CHARGE  # in eV/Å^3
J_PER_M2 = 1e-20 / CHARGE  # in eV/Å^2
A0, MODULUS = 2.5, 80.0

SCENE = {
    "substrate": {
        "symbol": "Au",
        "spacing": A0,
        "contact_modulus": MODULUS,
        "hardness": 0.7,
        "shape": [32, 48],
        "periodic": True,
        "model": "continuum",
        "refine": 1,
    },
    "sphere": {"radius": 60.0, "profile": "sphere"},
    "roughness": {
        "rms_slope": 0.2,
        "hurst": 0.7,
        "short_wavelength": 5.0,
        "long_wavelength": 16.0,
        "longest_wavelength": 24.0,
        "seed": 3,
        "random_amplitudes": True,
        "normalise": "ensemble",
        "domain": 120.0,
    },
    "interaction": {"kind": "full", "work_of_adhesion": 0.3, "cutoff": 7.0},
    "path": {
        "control": "load",
        "first": 2.0,
        "last": 50.0,
        "steps": 3,
        "scale": "linear",
    },
    "solver": {
        "optimizer": "LBFGS",
        "accuracy": 1e-3,
        "fmax": 1e-5,
        "max_steps": 77,
    },
}


def scene_with(changes=(), **tables):
    """Return the scene of a file with changed keys or tables; None removes one."""
    text = ""
    for title, keys in (SCENE | tables).items():
        if keys is None:
            continue
        others = {
            key.partition(".")[2]: value
            for key, value in dict(changes).items()
            if key.startswith(f"{title}.")
        }
        given = {key: v for key, v in (keys | others).items() if v is not None}
        lines = [f"{key} = {json.dumps(value)}" for key, value in given.items()]
        text += "\n".join([f"[{title}]", *lines, ""])
    return Scene.parse(text)


def rough(scene):
    return scene.surface.roughness


# Quantity defined by a key, its value in ASE's units, and another value of the key.
KEYS = {
    "substrate.symbol": (lambda s: s.atoms().symbols[0], "Au", "Cu"),
    "substrate.spacing": (lambda s: s.atoms().positions[1, 1], A0, 3.0),
    "substrate.contact_modulus": (
        lambda s: s.atoms().calc.parameters["contact_modulus"],
        MODULUS * GPA,
        90.0,
    ),
    "substrate.hardness": (lambda s: s.hardness, 0.7 * GPA, 0.8),
    "substrate.shape": (
        lambda s: (np.diag(s.atoms().cell)[:2] / A0).tolist(),
        [32.0, 48.0],
        [36, 48],
    ),
    "substrate.periodic": (
        lambda s: s.atoms().pbc.tolist(),
        [True, True, False],
        False,
    ),
    "substrate.model": (lambda s: s.area_column, "continuum_area", "atoms"),
    "sphere.radius": (lambda s: s.surface.radius, 60.0 * A0, 70.0),
    "sphere.profile": (lambda s: s.surface.profile, "sphere", "paraboloid"),
    "roughness.rms_slope": (lambda s: rough(s).rms_slope, 0.2, 0.1),
    "roughness.hurst": (lambda s: rough(s).hurst, 0.7, 0.8),
    "roughness.short_wavelength": (
        lambda s: rough(s).short_wavelength,
        5.0 * A0,
        4.0,
    ),
    "roughness.long_wavelength": (lambda s: rough(s).long_wavelength, 16.0 * A0, 20.0),
    "roughness.longest_wavelength": (
        lambda s: rough(s).longest_wavelength,
        24.0 * A0,
        30.0,
    ),
    "roughness.seed": (lambda s: rough(s).seed, 3, 4),
    "roughness.random_amplitudes": (lambda s: rough(s).random_amplitudes, True, False),
    "roughness.normalise": (lambda s: rough(s).normalise, "ensemble", "realisation"),
    "roughness.domain": (lambda s: rough(s).side, 120.0 * A0, 150.0),
    "interaction.kind": (lambda s: s.wall.attractive, True, "repulsive"),
    "interaction.work_of_adhesion": (
        lambda s: -float(s.wall.evaluate(A0)[0]),
        0.3 * J_PER_M2,
        0.4,
    ),
    "interaction.cutoff": (lambda s: s.wall.cutoff, 7.0 * A0, 8.0),
    "path.control": (lambda s: s.control, "loads", "height"),
    "path.first": (lambda s: s.targets[0], 2.0 * NN, 3.0),
    "path.last": (lambda s: s.targets[-1], 50.0 * NN, 60.0),
    "path.steps": (lambda s: len(s.targets), 3, 4),
    "path.scale": (lambda s: s.targets[1], 26.0 * NN, "geometric"),
    "solver.optimizer": (lambda s: type(relaxed_by(s)).__name__, "LBFGS", "FIRE"),
    "solver.accuracy": (lambda s: s.accuracy.error, 1e-3, 1e-4),
    "solver.fmax": (lambda s: s.fmax, 1e-5 * MODULUS * GPA * A0**2, 1e-6),
    "solver.max_steps": (lambda s: s.solver.max_steps, 77, 78),
}
# The same of the parameters of other walls, with the kind and all parameters.
POWER_LAW = {
    "kind": "power-law",
    "work_of_adhesion": 0.3,
    "attraction_range": 1.5,
    "exponent": 2.5,
    "relative_cutoff": 12.0,
}
PLASTIC = {"kind": "plastic", "permanent": True, "hardness": 0.4}
OF_WALLS = {
    "interaction.attraction_range": (
        POWER_LAW,
        lambda wall: wall.attraction_range,
        1.5 * A0,
    ),
    "interaction.exponent": (POWER_LAW, lambda wall: wall.exponent, 2.5),
    "interaction.relative_cutoff": (
        POWER_LAW,
        lambda wall: wall.cutoff,
        12.0 * 1.5 * A0,
    ),
    "interaction.permanent": (PLASTIC, lambda wall: wall.permanent, True),
    "interaction.hardness": (PLASTIC, lambda wall: wall.hardness, 0.4 * GPA),
}
# Keys that replace others, tested separately.
INSTEAD = {
    "substrate.elastic_constants",
    "sphere.unit",
    "roughness.unit",
    "path.values",
}


def relaxed_by(scene):
    return scene.optimizer(scene.atoms(), logfile=None)


def keys_of(text):
    """Return the keys of a scene file with their tables, including commented keys."""
    found, title = set(), None
    for line in text.splitlines():
        title = (re.match(r"\[(\w+)\]", line) or [None, title])[1]
        key = re.match(r"#?(\w+) = ", line)
        found |= {f"{title}.{key[1]}"} if key else set()
    return found


def test_the_table_has_every_key_of_a_scene_file():
    assert keys_of(default_text()) == KEYS.keys() | OF_WALLS.keys() | INSTEAD


@pytest.mark.parametrize("key", KEYS)
def test_keys_are_converted_to_the_units_of_ase(key):
    read, expected, other = KEYS[key]
    if isinstance(expected, float):
        expected = pytest.approx(expected, rel=1e-7)
    assert read(scene_with()) == expected
    changes = {key: other}
    if key == "interaction.kind":  # which has neither work of adhesion nor cutoff
        changes |= {"interaction.work_of_adhesion": None, "interaction.cutoff": None}
    assert read(scene_with(changes)) != expected


@pytest.mark.parametrize("key", OF_WALLS)
def test_parameters_of_walls_are_converted_to_the_units_of_ase(key):
    interaction, read, expected = OF_WALLS[key]
    assert read(scene_with(interaction=interaction).wall) == pytest.approx(expected)
    usual = {k: v for k, v in interaction.items() if f"interaction.{k}" != key}
    assert read(scene_with(interaction=usual).wall) != pytest.approx(expected)


@pytest.mark.parametrize("control", ["load", "penetration", "height"])
def test_targets_are_in_nanonewton_or_in_angstrom(control):
    unit = NN if control == "load" else 1.0
    scene = scene_with({"path.control": control})
    np.testing.assert_allclose(scene.targets, unit * np.array([2.0, 26.0, 50.0]))
    listed = scene_with(path={"control": control, "values": [1.5, 3.0]})
    np.testing.assert_allclose(listed.targets, unit * np.array([1.5, 3.0]))
    geometric = scene_with({"path.control": control, "path.scale": "geometric"})
    np.testing.assert_allclose(geometric.targets, unit * np.array([2.0, 10.0, 50.0]))


def test_elastic_constants_are_in_gigapascal_by_default_those_of_the_crystal():
    crystal = scene_with(substrate={"symbol": "Au"})
    crystal = crystal.with_values({"substrate.hardness": math.inf})
    assert Scene.parse(crystal.toml) == crystal
    assert crystal.spacing == pytest.approx(4.08 / 2**0.5)
    assert 80.0 * GPA < crystal.contact_modulus < 110.0 * GPA
    # isotropic: E = mu (3 lambda + 2 mu)/(lambda + mu), nu = lambda/2(lambda + mu)
    mu, lame = 20.0, 40.0
    constants = [lame + 2.0 * mu, lame, mu]
    scene = scene_with(substrate={"symbol": "Au", "elastic_constants": constants})
    nu = 0.5 * lame / (lame + mu)
    young = mu * (3.0 * lame + 2.0 * mu) / (lame + mu)
    assert scene.contact_modulus == pytest.approx(young / (1.0 - nu**2) * GPA)


@pytest.mark.parametrize("shape", ["auto", [40, 40]], ids=str)
@pytest.mark.parametrize("control", ["load", "penetration"])
def test_a_given_window_is_kept_and_an_automatic_one_follows_the_contact(
    shape, control
):
    scene = scene_with(
        {"substrate.shape": shape, "substrate.periodic": False},
        roughness=None,
        interaction={},
        path={"control": control, "values": [0.5, 4.0]},
        solver={},
    )
    windows = {record.window for record in scene.relax()}
    assert len(windows) == (2 if shape == "auto" else 1)
    assert ("40x40" in windows) == (shape != "auto")


def relaxed_with(**solver):
    """Return the result of a step with the given keys of [solver]."""
    changes = {"shape": [40, 40], "periodic": False, "model": "atoms"}
    (record,) = scene_with(
        {f"substrate.{key}": value for key, value in changes.items()},
        roughness=None,
        interaction={},
        path={"control": "penetration", "values": [2.0]},
        solver=solver,
    ).relax()
    return record


@pytest.mark.parametrize("accuracy", [1e-1, 1e-5])
def test_steps_have_accuracy_tolerance_and_iterations_of_the_scene(accuracy):
    record = relaxed_with(accuracy=accuracy)
    mean = record.normal_force / record.repulsive_atoms
    assert 0.02 * accuracy < record.tolerance / mean < 0.2501 * accuracy
    tolerance = relaxed_with(accuracy=1e-1, fmax=1e-7).tolerance
    assert tolerance == pytest.approx(1e-7 * MODULUS * GPA * A0**2)
    record = relaxed_with(optimizer="LBFGS", max_steps=3)
    assert (record.iterations, record.converged) == (3, False)
