"""Ensembles of every kind of path: results of whole paths are columns."""

from dataclasses import dataclass
from shutil import copyfile

import numpy as np
import pytest
from ase.db import connect
from ensemble_scenes import Here, assert_same, die, finish, killed, rows
from scipy.stats import t

from ase_roughcontact._util.printing import plain
from ase_roughcontact.analysis.path_values import static_friction
from ase_roughcontact.cli import main
from ase_roughcontact.cli.means import means_table
from ase_roughcontact.ensemble import (
    MeanValue,
    mean_values,
    product,
    read_ensemble,
    sample_ensemble,
    write_csv,
)
from ase_roughcontact.ensemble.means import realisations_needed, standard_error
from ase_roughcontact.ensemble.study import study_points, write_study
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
unit = "a0"
radius = 20.0
[roughness]
unit = "a0"
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
unit = "a0"
radius = 20.0
[roughness]
unit = "a0"
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
unit = "a0"
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

SEEDS = {"roughness.seed": (1, 2)}


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


@pytest.mark.slow  # a scheduler and its process
def test_loops_and_slides_with_dask_have_the_rows_of_this_process(tmp_path):
    from dask.distributed import Client, LocalCluster  # not in every process

    options = {"n_workers": 1, "threads_per_worker": 1, "dashboard_address": ":0"}
    scenes = [*product(LOOP, SEEDS), *product(SLIDING, SEEDS)]
    with LocalCluster(**options) as cluster, Client(cluster) as client:
        finish(scenes, tmp_path / "d.db", executor=client.get_executor(pure=False))
    finish(scenes, tmp_path / "e.db")
    for query in ({}, {"record": "case"}):
        by_dask = read_ensemble(tmp_path / "d.db", **query)
        assert_same(by_dask, read_ensemble(tmp_path / "e.db", **query), rtol=1e-9)
    assert set(by_dask["state"]) == {"done"} and by_dask["state"].size == 4


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


# Means over seeds


def test_means_of_a_result_agree_with_its_values(loops):
    scenes, found, database = loops
    (mean,) = mean_values(scenes, database)
    forces = found["pull_off_force"]
    assert mean.column == "pull_off_force" and np.isnan(mean.target)
    assert (mean.realisations, mean.failed) == (2, 0)
    assert mean.mean == pytest.approx(0.5 * (forces[0] + forces[1]))
    scatter = abs(forces[0] - forces[1]) / np.sqrt(2.0)
    assert mean.scatter == pytest.approx(scatter)
    half = t.ppf(0.975, 1) * scatter / np.sqrt(2.0)
    assert mean.error == pytest.approx(half / 1.959964 / mean.mean)
    (energy,) = mean_values(scenes, database, "dissipated_energy")
    errors = found["dissipation_error"].mean() / abs(energy.mean)
    assert energy.value_error == pytest.approx(errors)
    assert "in 2 of 2" in energy.validity


def test_a_mean_names_realisations_that_it_lacks(loops, tmp_path):
    scenes, found, database = loops
    copyfile(database, tmp_path / "e.db")
    with connect(tmp_path / "e.db") as db:
        row = db.get(record="case", seed=2)
        db.update(row.id, state="failed")
    (mean,) = mean_values(scenes, tmp_path / "e.db")
    assert (mean.realisations, mean.failed) == (1, 1)
    assert mean.mean == found["pull_off_force"][0] and np.isnan(mean.error)
    table, *notes = means_table(scenes[0], [mean])
    assert "1 of 2" in plain(table)
    assert any("1 realisations that failed" in plain(each) for each in notes)


def test_a_seed_that_is_named_several_times_counts_once(loops):
    (one, two), found, database = loops
    (mean,) = mean_values([one, one, one, two], database)
    assert mean.realisations == 2
    assert mean.mean == pytest.approx(found["pull_off_force"].mean())
    assert mean.scatter == pytest.approx(np.std(found["pull_off_force"], ddof=1))


def test_a_mean_of_pull_off_forces_that_are_lower_bounds_says_so(loops, tmp_path):
    assert mean_values(loops[0], loops[2])[0].lower_bounds == 0
    scenes, found = calculated(LOOP.with_values({"path.deepest": -0.2}), tmp_path)
    assert all("lower bound" in message for message in found["message"])
    (mean,) = mean_values(scenes, tmp_path / "e.db")
    assert mean.realisations == mean.lower_bounds == 2
    _, *notes = means_table(scenes[0], [mean])
    assert any("lower bound in 2 of 2" in plain(each) for each in notes)
    write_study(tmp_path / "s.csv", study_points(scenes[0], {}, tmp_path / "e.db"))
    head, row = (tmp_path / "s.csv").read_text().splitlines()
    assert (
        dict(zip(head.split(","), row.split(","), strict=True))["lower_bounds"] == "1"
    )


def test_a_step_column_of_a_loop_has_no_mean(loops):
    with pytest.raises(ValueError, match="pull_off_force"):
        mean_values(loops[0], loops[2], "contact_area")


def test_the_targets_of_a_path_in_time_are_no_loads_for_a_theory(tmp_path):
    finish([TIME], tmp_path / "e.db", executor=Here())
    points = study_points(TIME, {}, tmp_path / "e.db", "contact_area")
    # at the ends of loading (0.1 nN at 2 nN/s) and of the dwell
    assert [point.mean.target for point in points] == pytest.approx([0.05, 0.25])
    assert all(np.isnan(point.theory) and not point.theory_name for point in points)


@pytest.mark.filterwarnings("ignore::ase_roughcontact.ValidityWarning")
def test_a_loop_without_hysteresis_gets_no_seeds_beyond_the_pilot(tmp_path, capsys):
    scene = LOOP.with_values({"interaction.work_of_adhesion": 0.02})
    options = {"column": "dissipated_energy", "pilot": 2, "most": 6}
    *_, last = sample_ensemble(scene, tmp_path / "e.db", 0.05, Here(), **options)
    (mean,) = last.means
    assert mean.realisations == 2
    assert mean.value_error >= 1.0
    assert mean.error > 0.05
    assert not last.done and last.missing == 0
    assert "zero within the errors" in plain(*means_table(scene, last.means, last))


def test_seeds_of_a_path_in_time_are_added_until_the_creep_depth_is_known(tmp_path):
    options = {"column": "creep_depth", "pilot": 2, "most": 3, "interval": 0.01}
    *_, last = sample_ensemble(TIME, tmp_path / "e.db", 1e-3, Here(), **options)
    (mean,) = last.means
    assert not last.done and mean.realisations == last.progress.total == 3
    depths = read_ensemble(tmp_path / "e.db", record="case")["creep_depth"]
    assert mean.mean == pytest.approx(depths.mean())
    *_, last = sample_ensemble(TIME, tmp_path / "e.db", 5.0, Here(), **options)
    assert last.done and last.means[0].realisations == 2


def test_errors_of_few_values_are_students_and_of_many_the_normal_ones():
    for count in (2, 8, 17, 1000):
        half = t.interval(0.95, count - 1, scale=3.0 / np.sqrt(count))[1]
        assert standard_error(3.0, count) == pytest.approx(half / 1.959964)
        assert realisations_needed(3.0, standard_error(3.0, count)) == count


@pytest.mark.parametrize("mean", [0.0, 1e-200, 1e-17])
def test_a_mean_that_is_zero_within_rounding_has_no_relative_error(mean):
    found = MeanValue.of(0.0, np.array([-1.0, 1.0, 3.0 * mean]), 0.05)
    assert np.isnan(found.error) and found.expected == 0
    assert "zero" in found.unknown and found.scatter == pytest.approx(1.0)


def test_intervals_of_adaptive_samples_contain_the_mean_nearly_as_often_as_they_say():
    """Simulated values: 1.96 errors hold above 93 %, without Student's t 90 %."""
    rng, hits = np.random.default_rng(0), []
    for values in rng.normal(1.0, 0.15, (2000, 200)):
        count = 8
        while True:
            mean = MeanValue.of(0.0, values[:count], 0.05)
            if mean.error <= 0.05:
                break
            count = min(max(mean.expected, count + 1), 2 * count)
        hits.append(abs(mean.mean - 1.0) <= 1.96 * mean.error * mean.mean)
    assert np.mean(hits) > 0.93


@pytest.mark.filterwarnings("always:2 of 4 will probably fail")
def test_the_command_prints_all_results_and_names_what_failed(
    tmp_path, capsys, monkeypatch
):
    pool = "ase_roughcontact.ensemble.run.worker_pool"
    monkeypatch.setattr(pool, lambda executor, workers: Here())
    file, database = tmp_path / "loop.toml", tmp_path / "e.db"
    file.write_text(LOOP.toml)
    command = ["ensemble", str(file), "--database", str(database), "--workers", "1"]
    # the window of 8 x 8 atoms is too small for the loop
    shapes = "--set", "substrate.shape=[24,24],[8,8]", "--set", "roughness.seed=1,2"
    assert main([*command, *shapes, "--results", str(tmp_path / "r.csv")]) == 1
    printed = capsys.readouterr()
    assert "dissipated" in printed.out
    warning, *_ = printed.err.splitlines()
    assert "2 of 4" in warning and "larger shape" in warning
    names = [line.partition(": RuntimeError")[0] for line in printed.err.splitlines()]
    assert "substrate.shape = [8, 8], roughness.seed = 2" in names[-1]
    lines = (tmp_path / "r.csv").read_text().splitlines()
    states = [line.split(",")[1] for line in lines]
    assert sorted(states) == ["done", "done", "failed", "failed", "state"]
    assert main([*command, "--column", "contact_area"]) == 2
    assert "pull_off_force" in capsys.readouterr().err


def test_a_static_friction_that_no_seed_reaches_is_shown_as_not_known(
    tmp_path, capsys, monkeypatch
):
    pool = "ase_roughcontact.ensemble.run.worker_pool"
    monkeypatch.setattr(pool, lambda executor, workers: Here())
    stuck = SLIDING.with_values({"friction.coefficient": 5.0})
    (tmp_path / "my.toml").write_text(stuck.toml)
    given = [str(tmp_path / "my.toml"), "--database", str(tmp_path / "e.db")]
    main(["ensemble", *given, "--set", "roughness.seed=1,2"])
    lines = capsys.readouterr().out.splitlines()
    (row,) = (line for line in lines if line.startswith("static friction"))
    assert "0 of 2" in row


def test_a_column_of_a_sliding_path_has_a_mean_at_each_step(tmp_path):
    scenes = product(SLIDING, {"roughness.seed": (1, 2)})
    finish(scenes, tmp_path / "e.db", executor=Here())
    means = mean_values(scenes, tmp_path / "e.db", "stick_area")
    steps = read_ensemble(tmp_path / "e.db")
    assert len(means) == steps["step"].max() + 1 == 7
    for number, mean in enumerate(means):
        areas = steps["stick_area"][steps["step"] == number]
        assert mean.mean == pytest.approx(0.5 * areas.sum())
    (lost,) = mean_values(scenes, tmp_path / "e.db", "stiffness_without_slip")
    assert (lost.realisations, lost.failed) == (0, 2)  # not asked for in [output]
