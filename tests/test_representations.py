"""Objects are shown by a line of text, and by a table in notebooks."""

from dataclasses import dataclass, is_dataclass
from html.parser import HTMLParser
from importlib import import_module
from inspect import get_annotations
from pkgutil import walk_packages

import numpy as np
import pytest
from built import atoms_under

import ase_roughcontact as rc
from ase_roughcontact import cantilever_curve
from ase_roughcontact._util.summary import Summarized
from ase_roughcontact.analysis import (
    ContactMap,
    patches,
    pressure_distribution,
    radial_average,
    stress_planes,
    stress_section,
)
from ase_roughcontact.atoms.calculator import problem_of, state_of
from ase_roughcontact.elasticity import Isotropic
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.reference import reference_for

# Packages of results and inputs that users have in their hands.
PACKAGES = "analysis", "contact", "optimize", "path_kinds.loop", "scene"


@dataclass(frozen=True)
class GapStep(rc.LoadStep):
    """Results with a column of a user."""

    largest_gap: float = rc.column(
        lambda s: float(s.fields.gap.max()), "largest gap", "Å", "gap"
    )


@pytest.fixture(scope="module")
def pressed():
    solid = Isotropic(1.0, poisson=0.3)
    atoms = atoms_under(rc.RoughSphere(60.0), rc.HardWall(), (12, 12), solid=solid)
    output = rc.Output(record=GapStep)
    (step,) = rc.load_path(atoms, penetrations=[0.3], validity="ignore", output=output)
    return atoms, step


@pytest.fixture(scope="module")
def loop():
    """States of a spring of stiffness 1 eV/Å^2 that is pulled less than pressed."""
    heights = np.array([1.0, 0.5, 0.0, 0.5, 1.0])
    forces = np.array([0.0, 0.5, 1.0, 0.25, -0.5])
    states = [
        rc.LoadStep.from_columns(
            {"step": i, "height": z, "penetration": 1.0 - z, "normal_force": force}
        )
        for i, (z, force) in enumerate(zip(heights, forces, strict=True))
    ]
    return rc.AdhesionLoop.of(states, 0.01)


@pytest.fixture(scope="module")
def objects(pressed, loop):
    atoms, step = pressed
    seen, solid = ContactMap.from_atoms(atoms), Isotropic(1.0, poisson=0.3)
    scene = Scene.parse(
        'substrate = { material = "Cu" }\ninteraction = { kind = "hard" }\n'
        'path = { values = ["1 nN"] }'
    )
    scan = rc.HeightMap(np.random.default_rng(1).normal(size=(32, 32)), 1.0)
    return [
        step,
        loop,
        cantilever_curve(loop, 1.0),
        cantilever_curve(loop, 1.0).approach,
        seen,
        patches(seen),
        pressure_distribution(seen),
        radial_average(seen),
        *stress_planes(seen, solid, [2.0]),
        stress_section(seen, solid),
        atoms.calc,
        atoms.calc.state(atoms),
        state_of(atoms),
        problem_of(atoms)[0],
        scene,
        scene.bodies,
        scene.plan(),
        scene.path,
        reference_for(scene),
        scan,
        rc.RoughSphere(100.0, scan),
        rc.TabulatedSpectrum.of_scan(scan, domain=64.0),
        rc.Output(csv="curve.csv"),
        rc.StepOptions(),
    ]


class Cells(HTMLParser):
    """Texts of the cells of a table, row by row."""

    def __init__(self, text):
        super().__init__()
        self.rows = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        if tag == "tr":
            self.rows.append([])

    def handle_data(self, data):
        if self.rows and data.strip():
            self.rows[-1].append(data)


def test_objects_are_shown_on_one_line_without_arrays(objects):
    shown = {type(each).__name__: repr(each) for each in objects}
    wrong = {
        name: text
        for name, text in shown.items()
        if len(text) > 500 or "\n" in text or "array(" in text
    }
    assert not wrong


def test_a_step_is_shown_by_its_printed_columns_with_units(pressed):
    _, step = pressed
    assert repr(step).startswith(f"GapStep(step=0, height={step.height:.5g} Å, ")
    assert f"normal_force={step.normal_force:.5g} eV/Å" in repr(step)
    assert f"gap={step.largest_gap:.5g} Å" in repr(step)
    assert "pairs" not in repr(step)


def test_a_table_in_a_notebook_has_the_values_with_units(pressed):
    atoms, _ = pressed
    seen = ContactMap.from_atoms(atoms)
    rows = dict(Cells(seen._repr_html_()).rows)
    assert rows["sites"] == "12 x 12"
    assert rows["contact_area"] == f"{seen.contact_area:.5g} Å^2"


def test_a_loop_is_shown_by_its_pull_off_force_and_energy(loop):
    rows = dict(Cells(loop._repr_html_()).rows)
    assert rows["states"] == f"{len(loop.approach)} + {len(loop.retraction)}"
    assert rows["dissipated_energy"] == f"{loop.dissipated_energy:.5g} eV"
    assert rows["pull_off_force"] == "0.5 eV/Å"
    assert rows["turn_force"] == "1 eV/Å"


def test_a_scene_is_shown_by_the_keys_that_are_given():
    scene = Scene.parse('[sphere]\nradius = "3 nm"\n[topography]\nfile = "<1>.txt"\n')
    assert repr(scene).startswith("Scene(sphere=[radius = '3 nm'], topography=[file")
    assert "<1>.txt" in dict(Cells(scene._repr_html_()).rows)["topography"]


def test_every_class_of_arrays_that_users_see_is_summarized():
    missing = []
    for package in PACKAGES:
        root = import_module(f"ase_roughcontact.{package}")
        for info in walk_packages(root.__path__, f"{root.__name__}."):
            module = import_module(info.name)
            for name, each in vars(module).items():
                if not (isinstance(each, type) and is_dataclass(each)):
                    continue
                if each.__module__ != info.name or name.startswith("_"):
                    continue
                hints = map(str, get_annotations(each).values())
                arrays = [hint for hint in hints if "Array" in hint or "ndarr" in hint]
                if arrays and not issubclass(each, Summarized):
                    missing.append(f"{info.name}.{name}")
    assert missing == []
