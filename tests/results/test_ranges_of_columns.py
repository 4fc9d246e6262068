"""Columns have a number where they are defined, and elsewhere NaN with a reason."""

import json
import math

import numpy as np
import pytest
from ase.constraints import FixAtoms
from ase.optimize import LBFGS
from built import atoms_under
from scipy.integrate import simpson
from sliding_contacts import MU, follow, stepper_of
from small_scene import SMALL

import ase_roughcontact as rc
from ase_roughcontact.analysis import ContactMap
from ase_roughcontact.cli import main
from ase_roughcontact.results.flat_record import FlatStep
from ase_roughcontact.results.record import columns_of
from ase_roughcontact.scene import Scene
from ase_roughcontact.theory import Hertz

pytestmark = pytest.mark.filterwarnings("ignore::ase_roughcontact.ValidityWarning")

RADIUS, HARDNESS = 400.0, 0.01
SPHERE = rc.RoughSphere(RADIUS)
WALLS = {
    "hard": rc.HardWall(),
    "plastic": rc.PlasticWall(HARDNESS),
    "repulsive": rc.LennardJones93.repulsive(1.0, 1.0),
    "adhesive": rc.LennardJones93.adhesive(1.0, 1.0, 0.005),
    "dugdale": rc.DugdaleWall(0.005, 0.5),
}
HARD = ["hard", "plastic", "dugdale"]


def pressed(name="hard", depths=(0.5,), record=rc.LoadStep, atoms=None, **options):
    """Steps of a smooth sphere, and its atoms after the last one."""
    atoms = atoms or atoms_under(SPHERE, WALLS[name], (64, 64))
    options = {"window": "unchecked", **options}
    output = rc.Output(record=record)
    return list(
        rc.load_path(atoms, penetrations=depths, output=output, **options)
    ), atoms


def unknown(step):
    """Columns of a step that are NaN."""
    return {k for k in columns_of(type(step)) if getattr(step, k) != getattr(step, k)}


@pytest.mark.parametrize("name", WALLS)
def test_what_is_not_known_has_a_reason(name):
    for step in pressed(name, (0.5, -5.0))[0]:
        assert step.not_known.keys() == unknown(step)
        assert all(step.not_known.values())


@pytest.mark.parametrize("name", WALLS)
def test_mean_pressure_is_force_over_area_and_not_known_without_contact(name):
    (touching, apart), _ = pressed(name, (0.5, -5.0))
    seen = ContactMap.from_atoms(pressed(name)[1])
    mean = seen.pressure[seen.contact].mean()
    assert touching.mean_pressure == pytest.approx(mean, rel=1e-4)
    assert math.isnan(apart.mean_pressure)
    assert "in contact" in apart.not_known["mean_pressure"]
    assert apart.largest_pressure == 0.0


def test_pressures_of_a_smooth_sphere_agree_with_hertz():
    (step,), _ = pressed(depths=(1.0,))
    hertz = Hertz(RADIUS, 1.0)
    radius = float(hertz.contact_radius(step.normal_force))
    mean = step.normal_force / (math.pi * radius**2)
    assert step.largest_pressure == pytest.approx(1.5 * mean, rel=0.02)
    assert step.mean_pressure == pytest.approx(mean, rel=0.06)  # counted atoms


@pytest.mark.parametrize("name", WALLS)
def test_plastic_columns_are_known_under_walls_with_a_hardness(name):
    (step,), atoms = pressed(name)
    if name != "plastic":
        assert {"plastic_atoms", "plastic_depth"} <= unknown(step)
        assert "hardness" in step.not_known["plastic_atoms"]
        return
    seen = ContactMap.from_atoms(atoms)
    at_hardness = np.count_nonzero(seen.pressure > 0.9999 * HARDNESS)
    assert step.plastic_atoms == at_hardness > 100
    overlap = -atoms.calc.state(atoms).gap.min()
    assert step.plastic_depth == pytest.approx(overlap, rel=1e-6)
    assert overlap > 0.05


def test_a_very_soft_surface_flows_as_deep_as_the_indenter_comes():
    atoms = atoms_under(SPHERE, rc.PlasticWall(1e-6), (64, 64))
    (step,), _ = pressed(atoms=atoms)
    # atoms next to the axis, half a spacing away along x and y
    assert step.plastic_depth == pytest.approx(0.5, abs=1e-3)
    rigid = np.count_nonzero(atoms.calc.state(atoms).gap < 0.0)
    assert step.plastic_atoms == pytest.approx(rigid, abs=8)


@pytest.mark.parametrize("name", WALLS)
def test_gap_error_is_the_largest_one_of_a_hard_wall(name):
    (step,), atoms = pressed(name, accuracy=1e-3)
    state = atoms.calc.state(atoms)
    if name not in HARD:
        assert "hard" in step.not_known["gap_error"]
        return
    elastic = state.pressure < (0.9999 * HARDNESS if name == "plastic" else math.inf)
    error = max(state.gap[state.contact].max(), -state.gap[elastic].min())
    assert step.gap_error == pytest.approx(error, rel=1e-6, abs=1e-15)


@pytest.mark.parametrize("name", WALLS)
def test_contact_stiffness_agrees_with_differences_on_loading(name):
    d = 1e-4  # in which no atom comes to the hardness
    (low, middle, high), _ = pressed(name, (0.5 - d, 0.5, 0.5 + d), accuracy=1e-7)
    slope = (high.normal_force - middle.normal_force) / d
    if name != "plastic":
        slope = (high.normal_force - low.normal_force) / (2.0 * d)
    assert middle.contact_stiffness == pytest.approx(slope, rel=0.01)


def test_contact_stiffness_of_a_solid_that_creeps_is_the_instantaneous_one():
    solid = rc.Viscoelastic(1.0, rc.Creep.standard_solid(relaxed=0.2, time=1.0))
    atoms = atoms_under(rc.RoughSphere(200.0), rc.HardWall(), (48, 48), solid=solid)
    schedule = rc.Schedule(0.0).step(1.0).hold(1.0).step(1.001)
    *_, held, last = rc.time_path(atoms, penetrations=schedule, tolerance=0.05)
    slope = (last.normal_force - held.normal_force) / 1e-3
    assert held.contact_stiffness == pytest.approx(slope, rel=0.01)


def test_stiffness_and_errors_are_not_known_if_atoms_of_the_surface_are_held():
    atoms = atoms_under(rc.RoughSphere(20.0), None, (8, 8))
    atoms.set_constraint([*atoms.constraints, FixAtoms([27])])
    (step,), _ = pressed(depths=(0.3,), atoms=atoms, optimizer=LBFGS, fmax=1e-4)
    assert {"contact_stiffness", "force_error", "area_error"} <= unknown(step)
    assert "constraint" in step.not_known["contact_stiffness"]
    assert step.not_known["force_error"] == step.unknown_errors


def test_memory_is_estimated_for_the_solvers_of_the_package():
    for optimizer, is_known in ((None, True), (LBFGS, False)):
        atoms = atoms_under(rc.RoughSphere(20.0), None, (8, 8))
        (step,), _ = pressed(
            depths=(0.1,), atoms=atoms, optimizer=optimizer, max_steps=3
        )
        assert math.isfinite(step.memory) is is_known
        assert ("memory" in step.not_known) is not is_known


@pytest.mark.parametrize("name", WALLS)
def test_energy_is_the_work_done_on_the_indenter(name):
    depths = np.linspace(0.3, 1.3, 41)
    steps, _ = pressed(name, depths, accuracy=1e-7)
    work = simpson([step.normal_force for step in steps], x=depths)
    # atoms of an attractive wall jump into contact one by one
    error = 0.01 if WALLS[name].attractive else 1e-3
    assert steps[-1].energy - steps[0].energy == pytest.approx(work, rel=error)


def test_energy_of_a_surface_that_has_flowed_includes_the_work_of_the_flow():
    wall = rc.PlasticWall(HARDNESS, permanent=True)
    atoms = atoms_under(SPHERE, wall, (64, 64))
    depths = np.concatenate([np.linspace(0.0, 0.6, 61), np.linspace(0.6, 0.2, 41)[1:]])
    steps, _ = pressed(depths=depths, atoms=atoms, accuracy=1e-6)
    forces = np.array([step.normal_force for step in steps])
    work = np.sum(0.5 * (forces[1:] + forces[:-1]) * np.diff(depths))
    assert steps[-1].energy - steps[0].energy == pytest.approx(work, rel=2e-3)
    lost = HARDNESS * ContactMap.from_atoms(atoms).plastic_depth.sum()
    assert steps[-1].normal_force == 0.0  # what is left is the work of the flow
    assert steps[-1].energy == pytest.approx(lost, rel=1e-12)


def test_nominal_pressure_and_mean_gap_agree_with_a_periodic_cell():
    roughness = rc.SelfAffine(0.1, 0.8, 4.0, 16.0, domain=32.0, seed=1)
    rough = rc.RoughSphere(math.inf, roughness)
    for periodic in (True, False):
        atoms = atoms_under(rough, rc.HardWall(), (32, 32), periodic=periodic)
        (step,), _ = pressed(depths=(0.2,), atoms=atoms, record=FlatStep)
        if periodic:
            nominal = step.normal_force / 32.0**2
            assert step.nominal_pressure == pytest.approx(nominal, rel=1e-12)
            gap = atoms.calc.state(atoms).gap
            assert step.mean_gap == pytest.approx(gap.mean(), rel=1e-3)
        else:
            assert {"nominal_pressure", "mean_gap"} <= unknown(step)
            assert "periodic" in step.not_known["mean_gap"]


def test_columns_of_time_are_known_on_paths_in_time():
    (step,), _ = pressed(record=rc.TimeStep)
    of_time = {"time", "dissipation", "dissipated_energy", "lost_energy"}
    assert of_time <= unknown(step)
    assert "time" in step.not_known["dissipation"]
    solid = rc.Viscoelastic(1.0, rc.Creep.standard_solid(relaxed=0.5, time=1.0))
    atoms = atoms_under(SPHERE, rc.HardWall(), (48, 48), solid=solid)
    held = rc.Schedule(0.0).step(0.5).hold(3.0)
    steps = list(rc.time_path(atoms, penetrations=held, tolerance=0.01))
    assert not of_time & set().union(*map(unknown, steps))
    # at rest all energy that has gone was dissipated
    lost = sum(step.dissipated_energy for step in steps)
    assert steps[1].energy - steps[-1].energy == pytest.approx(lost, rel=0.01)
    times = [step.time for step in steps[1:]]
    power = [step.dissipation for step in steps[1:]]
    mean = 0.5 * (np.array(power[1:]) + power[:-1])
    assert np.sum(mean * np.diff(times)) == pytest.approx(lost, rel=0.05)


def test_base_and_deflection_are_known_with_a_cantilever():
    solid = rc.Viscoelastic(1.0, rc.Creep.standard_solid(relaxed=0.5, time=1.0))
    atoms = atoms_under(SPHERE, rc.HardWall(), (48, 48), solid=solid, fixed=False)
    bases = rc.Schedule(0.1).ramp(-1.0, rate=10.0)
    *_, last = rc.time_path(atoms, bases=bases, cantilever=5.0, tolerance=0.05)
    assert last.base == -1.0
    assert last.deflection == pytest.approx(last.normal_force / 5.0, rel=1e-3)
    atoms = atoms_under(SPHERE, rc.HardWall(), (48, 48), solid=solid)
    first, *_ = rc.time_path(atoms, penetrations=rc.Schedule(0.1).hold(0.1))
    assert {"base", "deflection"} <= unknown(first)


def test_columns_of_friction_are_known_with_friction_and_a_spring():
    (apart,) = follow(stepper_of(32), -3.0, rc.Coulomb(MU), [0.1])
    assert {"base_x", "base_y", "friction_residual"} <= unknown(apart)
    assert "spring" in apart.not_known["base_x"]
    bases = [0.0, 0.1]
    options = {"control": "bases", "spring": 2.0}
    *_, last = follow(stepper_of(32), 0.5, rc.Coulomb(MU), bases, **options)
    assert (last.base_x, last.base_y) == (0.1, 0.0)
    force = 2.0 * (last.base_x - last.lateral_x)
    assert last.lateral_force_x == pytest.approx(force, rel=1e-4)
    assert 0.0 < last.friction_residual < 1e-4


# As it is printed


APART = SMALL.replace("first = 0.2", "first = -2.0")


def test_reasons_are_in_lines_of_json(tmp_path, capsys):
    (tmp_path / "scene.toml").write_text(APART)
    out = str(tmp_path / "out")
    main(["run", str(tmp_path / "scene.toml"), "--out", out, "--json"])
    apart, touching = map(json.loads, capsys.readouterr().out.splitlines())
    assert apart["mean_pressure"] is None
    assert "in contact" in apart["not_known"]["mean_pressure"]
    assert "mean_pressure" not in touching["not_known"]


def test_infinite_values_in_json_are_not_unknown(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = 'sphere = { radius = inf }\ninteraction = { kind = "hard" }\n'
    text += 'substrate = { contact_modulus = 1.0, hardness = inf, model = "atoms" }\n'
    text += 'path = { values = ["10 GPa"] }\n[roughness]\nunit = "a0"\n'
    text += "long_wavelength = 16.0\n"
    text += "short_wavelength = 8.0\ndomain = 16.0\n"
    (tmp_path / "flat.toml").write_text(text)
    main(["run", "flat.toml", "--out", "out", "--json"])
    line = json.loads(capsys.readouterr().out)
    assert line["conductance"] == line["contact_stiffness"] == "inf"
    assert not {"conductance", "contact_stiffness"} & line["not_known"].keys()


def test_reasons_are_below_the_table_and_on_the_page(tmp_path, capsys):
    (tmp_path / "scene.toml").write_text(APART)
    out = str(tmp_path / "out")
    main(["run", str(tmp_path / "scene.toml"), "--out", out])
    text = " ".join(capsys.readouterr().out.split())
    assert "A/A_Hertz not known in 1 of 2 steps" in text
    main(["report", out])
    page = (tmp_path / "out" / "report.html").read_text()
    assert "<td>not known" in page
    assert "plastic atoms" not in page  # the wall has no hardness


def test_a_run_of_an_elastic_wall_has_nan_in_its_table(tmp_path):
    list(Scene.parse(APART).run(tmp_path, validity="ignore"))
    lines = (tmp_path / "curve.csv").read_text().splitlines()
    heads, first, _ = (line.split(",") for line in lines)
    names = [head.partition(" (")[0] for head in heads]
    row = dict(zip(names, first, strict=True))
    for name in ("plastic_atoms", "plastic_depth", "gap_error", "mean_pressure"):
        assert row[name] == "nan"
