"""Ensembles of every kind of path: results of whole paths are columns."""

from dataclasses import dataclass

import numpy as np
import pytest
from ensemble_scenes import Here, die, finish, killed, rows

from ase_roughcontact.analysis.path_values import static_friction
from ase_roughcontact.ensemble import product, read_ensemble, write_csv
from ase_roughcontact.scene import PathKind, Scene, relax_loop
from ase_roughcontact.scene.path_result import PathResult

LOOP = Scene.parse("""
[substrate]
model = "atoms"
spacing = 2.5
contact_modulus = 100.0
shape = [24, 24]
hardness = inf
[sphere]
radius = 20.0
[roughness]
long_wavelength = 8.0
rms_slope = 0.05
[interaction]
kind = "adhesive"
work_of_adhesion = 0.4
[path]
kind = "loop"
deepest = "0.2 nm"
step = 1.0
tolerance = 0.2
cantilever = 60.0
[solver]
accuracy = "fast"
""")
SLIDING = Scene.parse("""
[substrate]
model = "atoms"
contact_modulus = 100.0
poisson = 0.3
spacing = 2.5
shape = [16, 16]
[sphere]
radius = 20.0
[roughness]
long_wavelength = 8.0
[interaction]
kind = "hard"
[friction]
coefficient = 0.2
[path]
kind = "sliding"
values = 2.0
displacements = [0, 1, -1, 1]
steps = 2
""")
TIME = Scene.parse("""
[substrate]
model = "continuum"
contact_modulus = "2 MPa"
spacing = "4 nm"
shape = [14, 14]
hardness = inf
relaxation_moduli = [0.6]
relaxation_times = [0.5]
[sphere]
radius = "100 nm"
[roughness]
long_wavelength = 8.0
[interaction]
kind = "hard"
[path]
kind = "time"
control = "load"
values = [0, 0.1]
rate = 2.0
dwell = 0.2
tolerance = 0.1
""")


@dataclass(frozen=True)
class Press(PathKind):
    """Two penetrations, with a result of its own."""

    kind = "press twice"
    control = "penetration"
    results = {
        "secant": PathResult(
            lambda done: np.diff([s.normal_force for s in done.steps])[0] / 0.5,
            "secant stiffness between both depths",
            "eV/Å^2",
            "secant",
        ),
        "nowhere": PathResult(
            lambda done: 1.0, "a number", where="other paths", includes=lambda d: False
        ),
    }

    def targets(self, bodies):
        return np.array([0.5, 1.0])


def calculated(scene, folder, seeds=(1, 2)):
    """Return the scenes of some seeds, and their results from a database."""
    scenes = product(scene, {"roughness.seed": seeds})
    progress = finish(scenes, folder / "e.db", executor=Here())
    assert progress.steps == progress.total == len(scenes), progress.failures
    found = read_ensemble(folder / "e.db", record="case")
    order = np.argsort(found["seed"])
    return scenes, {name: values[order] for name, values in found.items()}


@pytest.fixture(scope="module")
def loops(tmp_path_factory):
    folder = tmp_path_factory.mktemp("loops")
    return *calculated(LOOP, folder), folder / "e.db"


def test_each_seed_of_a_loop_has_its_pull_off_force_and_hysteresis(loops):
    scenes, found, _ = loops
    for number, scene in enumerate(scenes):
        loop = relax_loop(scene, validity="ignore")
        # the largest tension of the states, up to the interpolation between them
        lowest = -min(state.normal_force for state in loop.retraction)
        assert found["pull_off_force"][number] == pytest.approx(lowest, rel=0.1)
        assert found["pull_off_force"][number] == loop.pull_off_force
        assert found["dissipated_energy"][number] == loop.dissipated_energy
        assert found["turn_penetration"][number] == pytest.approx(2.0)
        assert found["retraction_jumps"][number] == len(loop.retraction_jumps)
        assert found["steps"][number] == len(loop.approach) + len(loop.retraction) - 1
    first, second = found["pull_off_force"]
    assert first != pytest.approx(second, rel=1e-3)
    assert found["state"].tolist() == ["done", "done"]
    assert found["unconverged"].tolist() == [0, 0]


def test_a_case_has_all_limits_that_its_steps_exceed(loops):
    _, found, database = loops
    for validity, case in zip(found["validity"], found["case"], strict=True):
        of_steps = {
            entry.partition(" = ")[0]
            for text in read_ensemble(database, case=case)["validity"]
            for entry in filter(None, text.split("; "))
        }
        assert of_steps and set(validity.split("; ")) == of_steps


def test_a_table_of_cases_has_results_with_units(loops, tmp_path):
    write_csv(loops[2], tmp_path / "cases.csv", record="case")
    head, *lines = (tmp_path / "cases.csv").read_text().splitlines()
    assert "pull_off_force (eV/Å)" in head.split(",") and len(lines) == 2
    assert "creep_depth (Å)" in head.split(",")


def test_a_loop_that_failed_in_a_step_continues_to_the_same_results(
    loops, tmp_path, monkeypatch
):
    (scene, _), expected, _ = loops
    relax = Scene.relax

    def failing(*arguments, **options):
        for step in relax(*arguments, **options):
            yield step
            if step.step == 6:
                raise MemoryError("too large")

    monkeypatch.setattr(Scene, "relax", failing)
    progress = finish([scene], tmp_path / "e.db", executor=Here())
    assert list(progress.failures.values()) == ["MemoryError: too large"]
    failed = read_ensemble(tmp_path / "e.db", record="case")
    assert failed["state"] == ["failed"] and failed["steps"] == [7]
    assert np.isnan(failed["pull_off_force"]).all() and failed["seed"] == [1]
    monkeypatch.setattr(Scene, "relax", relax)
    assert finish([scene], tmp_path / "e.db", executor=Here()).steps == 1
    found = read_ensemble(tmp_path / "e.db", record="case")
    for name in ("pull_off_force", "dissipated_energy", "steps", "message"):
        assert found[name] == expected[name][:1]


@pytest.mark.slow
def test_a_killed_loop_continues_to_the_same_results(loops, tmp_path):
    scenes, expected, _ = loops
    killed(die, scenes[0], tmp_path / "e.db", 6, True)
    assert len(rows(tmp_path / "e.db", record="step")) == 7
    assert finish(scenes[:1], tmp_path / "e.db").steps == 1
    found = read_ensemble(tmp_path / "e.db", record="case")
    for name in ("pull_off_force", "dissipated_energy", "steps"):
        assert found[name] == expected[name][:1]


def test_each_seed_of_a_sliding_path_has_its_friction(tmp_path):
    scenes, found = calculated(SLIDING, tmp_path, [1])
    for number, scene in enumerate(scenes):
        steps = list(scene.relax(validity="ignore"))
        assert found["static_friction"][number] == static_friction(steps)
        # Coulomb's law: all atoms slip, and none is held back by a sideways traction
        largest = 0.2 * steps[0].normal_force
        assert found["static_friction"][number] == pytest.approx(largest, rel=0.01)
        assert found["total_dissipated_energy"][number] == steps[-1].dissipated_energy
    # the section [output] does not ask for it
    assert np.isnan(found["stiffness_without_slip"]).all()


@pytest.mark.filterwarnings("ignore::ase_roughcontact.ValidityWarning")
def test_each_seed_of_a_path_in_time_has_its_creep_depth(tmp_path):
    scenes, found = calculated(TIME, tmp_path, [1])
    for number, _ in enumerate(scenes):
        steps = read_ensemble(tmp_path / "e.db", seed=number + 1)
        begin, end = (np.isclose(steps["time"], t).argmax() for t in (0.05, 0.25))
        depth = steps["penetration"][end] - steps["penetration"][begin]
        assert found["creep_depth"][number] == pytest.approx(depth) and depth > 0.1
    assert np.isnan(found["relaxed_force"]).all()
    assert np.isnan(found["storage_stiffness"]).all()


def test_results_of_a_kind_of_ones_own_are_columns(tmp_path):
    scene = SLIDING.with_values({"friction": None, "path": Press()})
    scenes, found = calculated(scene, tmp_path, [3])
    first, second = scenes[0].relax(validity="ignore")
    secant = (second.normal_force - first.normal_force) / 0.5
    assert found["secant"] == pytest.approx(secant)
    assert np.isnan(found["nowhere"]).all()
    printed = scene.path.summary(scene.bodies, [first, second])
    assert printed["nowhere"] == "not known: defined for other paths"
    assert printed["secant"].endswith(" N/m")
