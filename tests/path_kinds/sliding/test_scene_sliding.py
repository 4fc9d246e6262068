"""Scenes with friction."""

import json
import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from ase.build import bulk
from matplotlib.figure import Figure
from spring_crystal import fcc_springs

from ase_roughcontact import Coulomb, Tresca
from ase_roughcontact._util.files import table_rows
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.analysis import loop_energies, static_friction
from ase_roughcontact.cli import main
from ase_roughcontact.cli.report import table_columns
from ase_roughcontact.elasticity import Crystal, Isotropic
from ase_roughcontact.elasticity.named_materials import combined_poisson
from ase_roughcontact.ensemble import product, read_ensemble, run_ensemble
from ase_roughcontact.path_kinds.sliding import figures
from ase_roughcontact.plot import plot_friction_loop, show_as_scanned, style
from ase_roughcontact.scene import Scene, Sliding
from ase_roughcontact.scene.preview import preview
from ase_roughcontact.scene.reference import reference_for
from ase_roughcontact.tradeoff.tradeoff import tradeoff

NM, NN, GPA = (UNITS[unit] for unit in ("nm", "nN", "GPa"))
TEXT = """
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
[friction]
coefficient = 0.3
[path]
kind = "sliding"
values = [20.0]
displacements = [0, "1 Å", "-0.1 nm", 1]
steps = 4
"""


def scene_with(**values):
    return Scene.parse(TEXT).with_values(
        {key.replace("__", "."): value for key, value in values.items()}
    )


def relaxed(**values):
    """Scene and its steps; keys of the path without their section."""
    keys = {k if "__" in k else f"path__{k}": v for k, v in values.items()}
    scene = scene_with(**keys)
    return scene, list(scene.relax(validity="ignore"))


def test_the_scene_of_the_guide_is_within_the_limits_of_the_model():
    page = Path(__file__).parents[3] / "examples" / "guide" / "friction.md"
    (text,) = re.findall(r"(?s)```toml\n(.*?)```", page.read_text())
    steps = list(Scene.parse(text).relax())
    assert len(steps) == 25
    assert {step.validity for step in steps} == {""}


def test_lateral_targets_are_reached_in_equal_steps():
    _, steps = relaxed()
    x = [*np.linspace(0, 1, 5), *np.linspace(1, -1, 5)[1:], *np.linspace(-1, 1, 5)[1:]]
    assert [step.lateral_x for step in steps] == pytest.approx(x)
    assert {step.lateral_y for step in steps} == {0.0}
    forces = [step.normal_force for step in steps]
    assert forces == pytest.approx([20.0 * NN] * 13, rel=1e-3)
    assert static_friction(steps) == pytest.approx(6.0 * NN, rel=1e-3)
    # the first loading of 1 Å slides less than the loop does
    (energy,) = loop_energies(steps)
    expected = steps[12].dissipated_energy - steps[4].dissipated_energy
    assert energy == expected > 2.0 * steps[4].dissipated_energy


def test_no_loop_and_no_static_friction_without_them():
    _, there = relaxed(displacements=[0, 0.01])
    assert np.isnan(static_friction(there))
    assert loop_energies(there).size == 0
    with pytest.raises(ValueError, match="got none"):
        loop_energies([])


def test_static_friction_is_the_largest_force_of_the_first_slide():
    values = {"friction__coupling": "solved", "path__displacements": [0, 2, -2]}
    _, steps = relaxed(**values, steps=8)
    first = next(s for s in steps if s.stick_area == 0.0)
    assert first.lateral_force_x < 0.9995 * steps[8].lateral_force_x
    assert static_friction(steps) == steps[8].lateral_force_x
    # a higher load is another contact
    loaded = [*steps[:9], replace(steps[8], normal_force=2.0, lateral_force_x=9.0)]
    assert static_friction(loaded) == steps[8].lateral_force_x


@pytest.mark.parametrize("missed, loops", [(5e-4, 1), (2e-3, 0)])
def test_a_loop_is_closed_where_it_misses_its_beginning_by_a_thousandth(missed, loops):
    turns = [0.0, 1.0, missed]  # the last one is the end
    steps = [
        SimpleNamespace(lateral_x=x, lateral_y=0.0, dissipated_energy=2.0 * number)
        for number, x in enumerate(turns)
    ]
    assert loop_energies(steps) == pytest.approx([4.0] * loops)


@pytest.mark.parametrize(
    "change, slides", [(0.009, True), (-0.009, True), (0.02, False)]
)
def test_the_first_slide_ends_where_the_load_changes_by_one_percent(change, slides):
    steps = [
        SimpleNamespace(
            slip_area=1.0,
            stick_area=0.0,
            lateral_x=float(number),
            lateral_y=0.0,
            lateral_force_x=1.0 + number,
            lateral_force_y=0.0,
            normal_force=5.0 * (1.0 + number * change),
        )
        for number in range(2)
    ]
    assert static_friction(steps) == (2.0 if slides else 1.0)


def test_tension_on_a_hard_wall_is_refused_before_the_run():
    for given, shown in ((-20, "-20 nN"), ("-0.02 µN", "-0.02 µN")):
        scene = scene_with(path__values=[given])
        with pytest.raises(ValueError, match=f"loads must be >= 0.*got {shown}$"):
            scene.plan()
    wall = {"interaction__kind": "adhesive", "interaction__work_of_adhesion": 0.1}
    assert scene_with(path__values=[-1], **wall).targets.max() < 0.0


def test_forces_of_rounding_are_printed_as_zero():
    scene = scene_with(path__displacements=[0, 0.1], path__steps=1)
    first, last = scene.relax(validity="ignore")
    noise = replace(first, lateral_force_x=-1e-10 * first.largest_friction)
    (value_of,) = (
        column.text_of
        for column in table_columns(reference_for(scene))
        if "force x" in column.head
    )
    assert value_of(noise) == "0"
    assert value_of(last) != "0"


def test_no_ratio_of_stiffnesses_at_an_instability():
    asked = {"output__columns": ["lateral_stiffness"]}
    scene, steps = relaxed(displacements=[0, 0.01], steps=1, **asked)
    found = scene.path.summary(scene, steps)["stiffness without slip"]
    assert re.fullmatch(r"[\d.]+ N/m, 0\.8\d* times the normal one", found)
    steps[-1] = replace(steps[-1], contact_stiffness=np.nan)
    found = scene.path.summary(scene, steps)["stiffness without slip"]
    assert found.endswith("not defined, as the contact is at an instability")


def test_a_path_without_contact_says_so(tmp_path):
    scene = scene_with(path__control="penetration", path__values=[-5.0], path__steps=1)
    steps = list(scene.run(tmp_path, validity="ignore"))
    assert scene.path.summary(scene, steps) == {
        "static friction": "none: no atom is in contact"
    }
    assert list(scene.path.draw(scene, steps, tmp_path)) == ["friction.png"]


def test_the_bound_that_is_drawn_agrees_with_the_repelled_atoms():
    wall = {"interaction__kind": "adhesive", "interaction__work_of_adhesion": 0.1}
    scene = scene_with(**wall, path__displacements=[0, "3 Å"], path__steps=1)
    (first, last) = steps = list(scene.relax(validity="ignore"))
    assert last.stick_area == 0.0
    assert last.lateral_force_x > 0.3 * 1.5 * last.normal_force
    with style():
        axes = plot_friction_loop(Figure().subplots(), steps, bounds=True)
    upper, lower, force = axes.lines
    # tractions at their bounds are nearly parallel
    assert upper.get_ydata()[1] == pytest.approx(force.get_ydata()[1], rel=1e-4)
    assert lower.get_ydata() == pytest.approx(-upper.get_ydata())
    (arrow,) = axes.texts  # one for each way
    assert arrow.xy == pytest.approx(np.mean(force.get_xydata(), axis=0))
    assert arrow.arrow_patch.get_linewidth() == 0.0  # the head alone, on the line
    assert axes.get_xlabel() == "displacement (nm)"
    # the bound does not depend on whether atoms slip
    assert first.largest_friction == pytest.approx(last.largest_friction, rel=1e-3)


def test_maps_show_stick_beside_slip_on_the_first_way_and_after_a_turn():
    scene, steps = relaxed(displacements=[0, 1, -1, 1, -1], steps=8)
    shown = scene.path.partly_slipping(steps)
    assert [s.step for s in shown] == sorted({s.step for s in shown})
    assert len(shown) == 4
    assert all(s.stick_area > 0.0 and s.slip_area > 0.0 for s in shown)
    first, back = (range(n, n + 8) for n in (1, 9))
    assert {s.step in first for s in shown} == {True, False}
    # the others mirror or repeat the states after the first turn
    assert all(s.step in first or s.step in back for s in shown)

    def partial(state):
        return state.stick_area * state.slip_area

    rest = [s for s in steps if s.step in first and s not in shown]
    most = [partial(s) for s in shown if s.step in first]
    assert min(most) > max(map(partial, rest))


def test_direction_forces_and_changing_loads():
    keys = {"displacements": None, "forces": ["1 nN", 3], "values": [20, "40 nN"]}
    asked = {"output__columns": ["lateral_stiffness"]}
    scene, steps = relaxed(**keys, direction="30 deg", **asked)
    forces = np.array([[s.lateral_force_x, s.lateral_force_y] for s in steps]) / NN
    turned = np.linspace(1, 3, 5)[:, None] * [np.sqrt(0.75), 0.5]
    assert forces == pytest.approx(turned, rel=1e-4)
    assert scene.targets == pytest.approx(np.linspace(20, 40, 5) * NN)
    assert steps[2].normal_force == pytest.approx(30.0 * NN, rel=1e-3)
    stiffness = scene.path.summary(scene, steps)["stiffness without slip"]
    assert " N/m along x, " in stiffness
    axes = plot_friction_loop(Figure().subplots(), steps, scene.path.towards)
    assert axes.get_xlabel() == "displacement at 30\N{DEGREE SIGN} from x (nm)"


def test_bases_move_a_spring():
    keys = {"displacements": None, "bases": [0, "5 nm"], "spring": "10 N/m"}
    _, steps = relaxed(**keys, steps=2)
    for step, base in zip(steps, [0, 25, 50], strict=True):
        assert (step.base_x, step.base_y) == (base, 0.0)
        force = 10.0 * UNITS["N/m"] * (base - step.lateral_x)
        assert step.lateral_force_x == pytest.approx(force, abs=1e-4)


@pytest.mark.parametrize("direction", [0.0, 30.0])
def test_the_table_has_the_base_where_there_is_one(direction):
    keys = {"displacements": None, "bases": [0, 1], "spring": 10.0, "steps": 1}
    path = scene_with(**{f"path__{k}": v for k, v in keys.items()}).path
    columns = replace(path, direction=direction).columns
    assert columns["base_x"] == "base x"
    assert ("base_y" in columns) == bool(direction)
    assert "base_x" not in replace(path, bases=None).columns
    (step, *_) = scene_with(path__steps=1).relax(validity="ignore")
    assert np.isnan([step.base_x, step.base_y]).all()


def test_maps_of_tractions_are_turned_as_the_scan(tmp_path, monkeypatch):
    rng = np.random.default_rng(1)
    np.save(tmp_path / "scan.npy", 0.1 * rng.standard_normal((64, 64)))
    scan = f'file = "{tmp_path}/scan.npy"\nrole = "indenter"\nunit = "Å"\nspacing = 2.5'
    scene = Scene.parse(f"{TEXT}\n[topography]\n{scan}\nnoise = 0.0\n")
    scene = scene.with_values({"path.displacements": [0, 0.5], "path.steps": 1})
    drawn = {}
    monkeypatch.setattr(
        figures, "draw_tractions", lambda *args: drawn.update(scanned=args[3])
    )
    steps = list(scene.run(tmp_path / "out", validity="ignore"))
    assert "tractions.png" in scene.path.draw(scene.bodies, steps, tmp_path / "out")
    assert drawn["scanned"] == "indenter"
    for scanned, turned in (("substrate", False), ("indenter", True)):
        axes = Figure().subplots()
        show_as_scanned(axes, scanned)
        assert (axes.yaxis_inverted(), axes.xaxis_inverted()) == (True, turned)


def test_laws_of_a_scene():
    def law(**values):
        return scene_with(**values).friction.law_on(2.5)

    strength = {"friction__shear_strength": "500 MPa"}
    assert law() == law(friction__kind="coulomb") == Coulomb(0.3)
    assert law(**strength) == Coulomb(0.3, strength=0.5 * GPA)
    assert law(**strength, friction__coefficient=None) == Tresca(0.5 * GPA)
    with pytest.raises(ValueError, match=r"'tresca' has no coefficient, got 0\.3"):
        law(**strength, friction__kind="tresca")


def test_poissons_ratio_agrees_with_the_substrate():
    assert scene_with().solid == Isotropic(80.0 * GPA, 0.3)
    named = Scene.parse(TEXT).with_values(
        {
            "substrate.contact_modulus": None,
            "substrate.poisson": None,
            "substrate.material": "Cu",
        }
    )
    values = {"substrate.material": "SiO2", "substrate.spacing": None}
    assert named.with_values(values).solid.poisson == 0.16
    # Hill's average of copper: bulk 137.1 GPa, shear 47.2 GPa
    assert named.solid.poisson == pytest.approx(0.345, abs=1e-3)
    # without friction it is known for stresses below the surface
    without = named.with_values({"friction": None})
    assert without.solid.poisson == named.solid.poisson
    # stresses are of the substrate: a tip of unknown ratio does not matter
    steps = TEXT.partition("[path]")[0] + "[path]\nvalues = [1.0]\n"
    mica = Scene.parse(steps).with_values({"friction": None, "sphere.material": "mica"})
    assert mica.solid.poisson == mica.substrate.poisson == 0.3


def test_two_elastic_bodies_slide_as_their_compliances_add_up():
    scene = scene_with(sphere__material="SiO2")
    tip = Isotropic(72.7 / (1.0 - 0.16**2) * GPA, 0.16)
    both = scene.solid
    q = np.array([0.3]), np.array([0.2])
    expected = Isotropic(80.0 * GPA, 0.3).lateral_wave_compliance(*q)
    expected = expected + tip.lateral_wave_compliance(*q)
    assert both.lateral_wave_compliance(*q) == pytest.approx(expected)
    assert combined_poisson((80.0, 0.3), (80.0, 0.3)) == pytest.approx(0.3)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"path.displacements": None}, "displacements, forces or bases, .* none of"),
        ({"path.forces": [0, 1]}, "got displacements and forces"),
        ({"path.displacements": [0]}, "displacements must be two or more"),
        ({"path.displacements": [0, "1 nN"]}, "unknown unit of displacements 'nN'"),
        ({"path.values": None}, "give loads, penetrations or heights while"),
        ({"path.values": [1, 2]}, "one of loads, or .* each of the 4 displ"),
        (
            {"path.values": [1, "1 nm"]},
            "unknown unit of loads 'nm'.*; lengths are given as penetrations",
        ),
        (
            {"path.values": ["1 nN"], "path.control": "height"},
            "unknown unit of heights 'nN'.*; forces are given as loads",
        ),
        ({"path.control": "base"}, "control 'base'.* Known: load, penetration, height"),
        ({"path.spring": 1.0}, "a spring needs bases"),
        ({"path.steps": 0}, "steps_per_move must be"),
        ({"path.first": 1.0}, "first"),
        ({"friction": None}, r'"sliding" needs a section \[friction\]'),
        ({"friction.coefficient": None}, "give coefficient, shear_strength, or both"),
        ({"friction.coefficient": -0.1}, r"coefficient must be > 0, got -0\.1"),
        ({"friction.shear_strength": 0.0}, "shear_strength must be > 0 GPa"),
        ({"substrate.poisson": None}, "give poisson"),
        ({"substrate.poisson": 0.7}, "poisson must be above -1 and at most 1/2"),
        (
            {"substrate.contact_modulus": None, "substrate.anisotropic": True},
            "has elastic_constants instead of poisson",
        ),
        ({"sphere.material": "mica"}, "Poisson's ratio of the material 'mica'"),
    ],
)
def test_errors_name_section_key_and_unit(values, message):
    with pytest.raises(ValueError, match=message):
        Scene.parse(TEXT).with_values(values).check()


def test_friction_needs_a_sliding_path_and_a_solid_with_lateral_response():
    steps = TEXT[: TEXT.index("[path]")] + "[path]\nvalues = [1.0]\n"
    with pytest.raises(ValueError, match=r'\[friction\] needs \[path\] kind = "slid'):
        Scene.parse(steps).check()
    layer = {"layer_thickness": 20.0, "layer_modulus": 5.0}
    with pytest.raises(ValueError, match="Layer"):
        scene_with(**{f"substrate__{k}": v for k, v in layer.items()}).check()
    creep = {"relaxation_moduli": (0.5,), "relaxation_times": (1.0,)}
    with pytest.raises(ValueError, match="viscoelastic"):
        scene_with(**{f"substrate__{k}": v for k, v in creep.items()}).check()


def test_a_preview_and_what_needs_single_steps():
    scene = scene_with(path__steps=1000, path__values=[2000.0])
    coarse = preview(scene)
    assert isinstance(coarse.path, Sliding)
    assert coarse.grid_change.coarsen > 1
    with pytest.raises(ValueError, match=r"deepest state.* \[friction\]"):
        tradeoff(scene_with(), 0.1)


def test_a_preview_on_a_crystal_has_its_mean_lateral_compliance(tmp_path):
    calculator, _ = fcc_springs(3.6)
    crystal = Crystal.from_calculator(calculator, bulk("Cu", a=3.6), layers=11, size=5)
    crystal.write(tmp_path / "springs.json")
    scene = scene_with(
        substrate__contact_modulus=None,
        substrate__poisson=None,
        substrate__spacing=None,
        substrate__crystal=str(tmp_path / "springs.json"),
        path__steps=3000,
        path__values=[2000.0],
    )
    coarse = preview(scene)
    coarse.check()
    angles = np.linspace(0.0, np.pi, 50, endpoint=False)
    q = 1e-4 * np.cos(angles), 1e-4 * np.sin(angles)
    found, expected = (
        solid.lateral_wave_compliance(*q)[:2].mean()
        for solid in (coarse.solid, crystal)
    )
    assert isinstance(coarse.solid, Isotropic)
    assert found == pytest.approx(expected, rel=1e-3)


def test_coupling_is_solved_for_if_a_scene_asks_for_it():
    values = {"substrate__poisson": 0.0, "path__steps": 1}
    neglected, solved = (
        scene_with(friction__coupling=coupling, **values)
        for coupling in ("neglected", "solved")
    )
    found, others = ([*s.relax(validity="ignore")] for s in (solved, neglected))
    assert found[-1].converged
    assert found[-1].alternations > 0 == others[-1].alternations
    assert found[0].penetration < others[0].penetration  # tractions lift the surface
    assert "coupled to the pressure" in solved.friction.label
    assert solved.plan().steps[0].memory > neglected.plan().steps[0].memory
    for scene, expected in ((neglected, True), (solved, False)):
        assert ("by lateral tractions" in " ".join(scene.plan().left_out)) == expected
    with pytest.raises(ValueError, match=r"^scene: \[friction\] coupling [^;]*'full'$"):
        scene_with(friction__coupling="full").check()


def test_two_elastic_bodies_have_the_difference_of_their_couplings():
    soft = {"substrate__contact_modulus": None, "substrate__material": "SiO2"}
    rigid, equal = (
        scene_with(substrate__poisson=None, sphere__material=tip, **soft).solid
        for tip in ("", "SiO2")
    )
    assert rigid.coupling > 0.2
    assert equal.coupling == pytest.approx(0.0, abs=1e-12)


def test_the_plan_has_the_memory_of_friction():
    without = scene_with(friction=None).plan().steps[0]
    (with_friction,) = scene_with().plan().steps  # 13 at one load
    assert with_friction.count == 13
    n, m = map(int, without.window.split("x"))
    assert with_friction.memory - without.memory == 900 * n * m
    for scene, expected in ((scene_with(), False), (scene_with(friction=None), True)):
        reasons = " ".join(scene.plan().left_out)
        assert ("displacements along x and y" in reasons) == expected
        assert "images of the contact" in reasons


def test_the_commands_run_resume_and_report_a_sliding_path(tmp_path, capsys):
    file, out = tmp_path / "scene.toml", tmp_path / "out"
    file.write_text(TEXT)
    assert main(["plan", str(file)]) == 0
    assert "Sliding in 13 steps" in capsys.readouterr().out
    steps = Scene.parse(TEXT).run(out, "ignore")
    for _ in range(6):
        next(steps)
    steps.close()  # as when it is killed
    assert main(["run", str(file), "--out", str(out)]) == 0
    printed = capsys.readouterr().out
    for words in ("coefficient 0.3; Poisson's ratio of the solid 0.3", "force x"):
        assert words in printed
    friction = re.search(r"static friction +([\d.]+) nN", printed)
    assert float(friction[1]) == pytest.approx(6.0, rel=1e-3)
    whole = list(Scene.parse(TEXT).relax(validity="ignore"))
    rows = list(table_rows((out / "curve.csv").read_text().splitlines()))
    for name in ("lateral_force_x", "dissipated_energy", "stick_area"):
        expected = [getattr(step, name) for step in whole]
        assert [float(row[name]) for row in rows] == pytest.approx(
            expected, rel=1e-4
        ), name
    for picture in ("friction", "tractions", "contact"):
        assert (out / f"{picture}.png").stat().st_size > 5000
    assert main(["report", str(out)]) == 0
    assert "atoms that slip" in (out / "report.html").read_text()
    assert main(["run", str(file), "--out", str(out), "--json"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert json.loads(lines[-1])["lateral_x"] == 1.0


def test_an_ensemble_of_sliding_paths_agrees_with_its_scenes(tmp_path):
    scene = scene_with(path__displacements=[0, 1], path__steps=2)
    scenes = product(scene, {"friction.coefficient": [0.1, 0.3]})
    database = tmp_path / "friction.db"
    *_, last = run_ensemble(scenes, database, workers=1)
    assert not last.failures
    found = read_ensemble(database)
    expected = [s.lateral_force_x for s in scenes[1].relax(validity="ignore")]
    mine = found["friction_coefficient"] == 0.3
    assert found["lateral_force_x"][mine] == pytest.approx(expected, rel=1e-6)
