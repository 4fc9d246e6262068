"""Ensembles: every step once, whoever calculates it and whatever is killed."""

import csv
import multiprocessing
import os
import signal
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import zip_longest

import numpy as np
import pytest
from ase.db import connect

from ase_roughcontact._util import kernels as parallel
from ase_roughcontact.ensemble import (
    case_of,
    fill_database,
    product,
    read_ensemble,
    read_table,
    run,
    run_ensemble,
    worker,
    write_table,
)
from ase_roughcontact.ensemble import ledger as ledgers
from ase_roughcontact.ensemble.ledger import Ledger, Standing
from ase_roughcontact.ensemble.progress import Meter, costs_of
from ase_roughcontact.scene import InteractionConfig, PathConfig, Scene

SMALL = """
[sphere]
radius = 60.0
[roughness]
long_wavelength = 16.0
[path]
control = "penetration"
first = 0.2
last = 0.6
steps = 3
scale = "linear"
"""
WALLS = [
    InteractionConfig("repulsive"),
    InteractionConfig("adhesive", {"work_of_adhesion": 0.05}),
]
SCENE = Scene.parse(SMALL)
LONG = replace(SCENE, path=replace(SCENE.path, first=0.02, last=0.8, steps=20))
SCENES = [
    *product(SCENE, {"roughness.seed": range(2), "interaction": WALLS}),
    *product(LONG, {"interaction": WALLS}),
]
STEPS = 4 * 3 + 2 * 20
# Of a case that is stopped in the middle and goes on: the state is the same within the
# tolerance of the solver, 1e-4 of the mean force.
RESUMED = {"rtol": 1e-3}
# What differs from run to run, and what a path that goes on in the middle takes.
TIMES = {"seconds"}
EFFORT = TIMES | {"max_force", "tolerance", "iterations", "pairs", "window", "grid"}


def finish(scenes, database, **options):
    """Run with one thread, and return the last progress."""
    with ThreadPoolExecutor(1) as pool:
        options = {"executor": pool, "interval": 0.02, **options}
        return list(run_ensemble(scenes, database, **options))[-1]


def rows(database, **query):
    return list(connect(database).select(**query))


def kill_one(database):
    """Kill a process that is at work, if there is one."""
    for row in rows(database, record="case", state="running")[:1]:
        os.kill(int(row.holder.split(":")[1]), signal.SIGKILL)
        return True
    return False


def die(scenes, database, part, count):
    """Run until a part of the ledger is called so many times, and die in it."""
    calls, original = iter(range(1, count + 1)), getattr(ledgers, part)

    def deadly(*arguments):
        result = original(*arguments)
        if next(calls) == count:
            os.kill(os.getpid(), signal.SIGKILL)
        return result

    setattr(ledgers, part, deadly)
    finish(scenes, database)


def dead_after(*arguments):
    """Do that in a process of its own."""
    process = multiprocessing.get_context("spawn").Process(target=die, args=arguments)
    process.start()
    process.join(60)
    assert process.exitcode == -signal.SIGKILL


def assert_same(columns, others, but=TIMES, **tolerance):
    assert columns.keys() == others.keys()
    for name in columns.keys() - but:
        if tolerance and columns[name].dtype.kind == "f":
            np.testing.assert_allclose(columns[name], others[name], **tolerance)
        else:
            np.testing.assert_array_equal(columns[name], others[name], name)


def new_ledger(folder, **options):
    ledger = Ledger(str(folder / "e.db"), **options)
    ledger.prepare()
    return ledger


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """All cases, calculated one after the other."""
    database = tmp_path_factory.mktemp("undisturbed") / "e.db"
    assert finish(SCENES, database).steps == STEPS
    return database


def test_product_takes_all_values_of_keys_and_tables_the_last_fastest():
    scenes = product(SCENE, {"sphere.radius": [50.0, 60.0], "interaction": WALLS})
    got = [(scene.sphere.radius, scene.interaction) for scene in scenes]
    assert got == [(radius, wall) for radius in (50.0, 60.0) for wall in WALLS]
    assert {scene.roughness for scene in scenes} == {SCENE.roughness}


def test_product_does_not_make_a_smooth_sphere_rough():
    smooth = replace(SCENE, roughness=None)
    with pytest.raises(ValueError, match=r"has no \[roughness\]"):
        product(smooth, {"roughness.seed": [3]})


@pytest.mark.parametrize(
    "choices, message",
    [
        ({"spere.radius": [1.0]}, "unknown table 'spere'.*'sphere'"),
        ({"sphere.radus": [1.0]}, r"\[sphere\]: unknown key 'radus'.*'radius'"),
        ({"sphere.radius": []}, "at least one value"),
    ],
)
def test_product_names_what_it_does_not_know(choices, message):
    with pytest.raises(ValueError, match=message):
        product(SCENE, choices)


def test_case_depends_on_every_value_and_not_on_how_it_is_written():
    same = product(SCENE, {"sphere.radius": [60, 60.0, np.float64(60)]})
    assert len({case_of(scene) for scene in same}) == 1
    others = product(SCENE, {"roughness.seed": range(20), "solver.max_steps": [5, 6]})
    assert len({case_of(scene) for scene in others}) == 40


def test_case_does_not_depend_on_the_rounding_of_whole_numbers():
    near = np.nextafter(3.0, 4.0)
    scenes = product(SCENE, {"path.values": [(1.0, 3.0), (1.0, near)]})
    assert scenes[0].path != scenes[1].path
    assert len({case_of(scene) for scene in scenes}) == 1


def test_steps_are_those_of_the_scenes_alone(undisturbed):
    columns = read_ensemble(undisturbed)
    for scene in SCENES:
        of_case = columns["case"] == case_of(scene)
        for name in ("step", "normal_force", "energy", "contact_area"):
            alone = [getattr(record, name) for record in scene.relax()]
            np.testing.assert_array_equal(columns[name][of_case], alone)
        np.testing.assert_array_equal(columns["target"][of_case], scene.steps)


def test_rows_can_be_queried_by_input_and_hold_it_all(undisturbed):
    columns = read_ensemble(undisturbed, "penetration>0.3,kind=adhesive", seed=1)
    assert set(columns["work_of_adhesion"]) == {0.05}
    assert len(columns["step"]) == 2
    (row,) = rows(undisturbed, kind="repulsive", seed=1, step=2)
    assert row.case == case_of(SCENES[2])
    assert row.data["scene"]["roughness"]["seed"] == 1
    assert row.positions[0, 2] == row.height
    assert row.converged and row.max_force < row.tolerance


def test_run_again_calculates_nothing(undisturbed):
    before = [row.unique_id for row in rows(undisturbed, record="step")]

    class Unused:
        def submit(self, *_):
            raise AssertionError("something was calculated")

    (progress,) = run_ensemble(SCENES, undisturbed, Unused())
    assert progress.steps == progress.total == STEPS
    assert [row.unique_id for row in rows(undisturbed, record="step")] == before


def test_result_does_not_depend_on_the_number_of_processes(undisturbed, tmp_path):
    seen = list(run_ensemble(SCENES, tmp_path / "e.db", workers=2, interval=0.05))
    assert [p.steps for p in seen] == sorted(p.steps for p in seen)
    assert (seen[0].steps, seen[-1].steps, seen[-1].left) == (0, STEPS, 0.0)
    assert_same(read_ensemble(tmp_path / "e.db"), read_ensemble(undisturbed))


def test_two_runs_at_once_share_the_cases(undisturbed, tmp_path):
    database = tmp_path / "e.db"
    with ThreadPoolExecutor(1) as one, ThreadPoolExecutor(1) as other:
        runs = [run_ensemble(SCENES, database, x, interval=0.02) for x in (one, other)]
        *_, last = zip_longest(*runs)
    assert [p.steps for p in last if p] == [STEPS] * sum(map(bool, last))
    assert_same(read_ensemble(database), read_ensemble(undisturbed))


def test_only_one_of_many_workers_gets_a_case(tmp_path):
    ledger = new_ledger(tmp_path)
    with ThreadPoolExecutor(8) as pool:
        tries = pool.map(lambda _: ledger.claim("c", SCENE), range(24))
        claims = [claim for claim in tries if claim]
    assert [claim.missing for claim in claims] == [[0, 1, 2]]


@pytest.mark.parametrize(
    "number, part, count",
    [
        pytest.param(-2, "_add_step", 7, id="repulsive-after-a-step"),
        pytest.param(-1, "_add_step", 7, id="adhesive-after-a-step"),
        pytest.param(-1, "_data", 8, id="adhesive-before-a-step"),
    ],
)
def test_killed_in_the_middle_of_a_transaction_it_goes_on(
    undisturbed, tmp_path, number, part, count
):
    scene, database = SCENES[number], tmp_path / "e.db"
    dead_after([scene], database, part, count)
    before = {row.step: row.unique_id for row in rows(database, record="step")}
    assert 0 < len(before) < 20
    assert finish([scene], database).steps == 20
    after = {row.step: row.unique_id for row in rows(database, record="step")}
    assert before.items() <= after.items()
    whole = read_ensemble(undisturbed, case=case_of(scene))
    assert_same(read_ensemble(database), whole, EFFORT, **RESUMED)
    assert not list(tmp_path.rglob("*.traj"))


def test_workers_change_the_database_one_after_the_other(tmp_path):
    ledger = new_ledger(tmp_path)
    with ThreadPoolExecutor(1) as pool:
        with ledger._alone():
            claim = pool.submit(ledger.claim, "c", SCENE)
            time.sleep(0.2)
            assert not claim.done()
        assert claim.result().missing == [0, 1, 2]


@pytest.mark.parametrize("ahead", [True, False])
def test_a_last_frame_that_is_no_use_is_not_used(undisturbed, tmp_path, ahead):
    scene, database = SCENES[1], tmp_path / "e.db"
    frame = tmp_path / "e-checkpoints" / f"{case_of(scene)}.traj"
    frame.parent.mkdir()
    if ahead:  # of the steps in the database, which has none
        assert len(list(scene.relax(trajectory=frame, keep="last"))) == 3
    else:
        frame.write_bytes(b"half a frame")
    assert finish([scene], database).steps == 3
    whole = read_ensemble(undisturbed, case=case_of(scene))
    assert_same(read_ensemble(database), whole)


def test_a_last_frame_that_another_worker_still_writes_is_left_to_it(
    undisturbed, tmp_path
):
    scene, database = SCENES[1], tmp_path / "e.db"
    frame = tmp_path / "e-checkpoints" / f"{case_of(scene)}.traj"
    frame.parent.mkdir()
    other = scene.relax(trajectory=frame, keep="last")
    assert next(other).step == 0
    assert finish([scene], database).steps == 3
    whole = read_ensemble(undisturbed, case=case_of(scene))
    assert_same(read_ensemble(database), whole)
    assert [record.step for record in other] == [1, 2]


def test_a_killed_process_is_told_of_and_nothing_is_lost(undisturbed, tmp_path):
    database = tmp_path / "e.db"
    with pytest.raises(RuntimeError, match=r"a worker died.*start again to go on"):
        for progress in run_ensemble(SCENES, database, workers=2, interval=0.02):
            if progress.steps:
                kill_one(database)
    before = {row.unique_id for row in rows(database, record="step")}
    assert 0 < len(before) < STEPS
    assert finish(SCENES, database).steps == STEPS
    assert before <= {row.unique_id for row in rows(database, record="step")}
    again = read_ensemble(database)
    assert_same(again, read_ensemble(undisturbed), EFFORT, **RESUMED)


def test_processes_end_with_the_one_that_started_them(tmp_path):
    database = tmp_path / "e.db"
    path = replace(LONG.path, steps=100_000)
    target, options = drive, ([replace(LONG, path=path)], database)
    driver = multiprocessing.get_context("spawn").Process(target=target, args=options)
    driver.start()
    wait_for(lambda: database.exists() and rows(database, record="step"))
    (row,) = rows(database, record="case")
    worker = int(row.holder.split(":")[1])
    assert worker != driver.pid
    driver.kill()
    driver.join(10)
    wait_for(lambda: not os.path.exists(f"/proc/{worker}"))


def drive(scenes, database):
    list(run_ensemble(scenes, database, workers=1, interval=0.05))


def wait_for(happened, seconds=30.0):
    end = time.monotonic() + seconds
    while not happened():
        assert time.monotonic() < end
        time.sleep(0.02)


def test_results_with_dask_are_the_same_though_a_worker_is_killed(
    undisturbed, tmp_path
):
    from dask.distributed import Client, LocalCluster  # not in every process

    database, killed = tmp_path / "e.db", False
    options = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None}
    with LocalCluster(**options) as cluster, Client(cluster) as client:
        executor = client.get_executor()
        for progress in run_ensemble(SCENES, database, executor, interval=0.02):
            killed = killed or (progress.steps > 0 and kill_one(database))
    assert killed
    assert progress.steps == progress.total == STEPS
    again = read_ensemble(database)
    assert_same(again, read_ensemble(undisturbed), EFFORT, **RESUMED)


def test_closing_the_generator_leaves_no_case_in_work(tmp_path):
    database = tmp_path / "e.db"
    with ThreadPoolExecutor(2) as pool:
        progress = run_ensemble(SCENES, database, pool, interval=0.02)
        while next(progress).steps == 0:
            pass
        progress.close()
        done = len(rows(database, record="step"))
    assert 0 < len(rows(database, record="step")) == done < STEPS
    states = {row.state for row in rows(database, record="case")}
    assert states <= {"waiting", "done"}
    assert finish(SCENES, database).steps == STEPS


def foreign_claim(database, age):
    """Write that a worker on another machine has the first case."""
    fill = connect(database)
    fill.write(
        None,
        record="case",
        case=case_of(SCENE),
        state="running",
        holder="elsewhere:1:x",
        run="r",
        renewed=time.time() - age,
        finished=0,
        message="",
    )


def test_a_case_of_another_machine_is_left_alone_until_it_is_silent(tmp_path):
    database = tmp_path / "e.db"
    foreign_claim(database, age=9.5)
    started = time.monotonic()
    assert finish([SCENE], database, lease=10.0).steps == 3
    assert 0.2 < time.monotonic() - started < 9.0


def test_a_worker_is_heard_of_however_long_its_step_takes(tmp_path):
    ledger = new_ledger(tmp_path, lease=0.8)
    claim = ledger.claim("c", SCENE)
    with worker._heartbeat(ledger, claim):
        time.sleep(1.2)
        assert ledger.claim("c", SCENE) is None
    time.sleep(0.9)
    assert ledger.claim("c", SCENE) is not None


def test_a_worker_that_was_taken_for_dead_writes_nothing(tmp_path):
    ledger = new_ledger(tmp_path, lease=1e-3)
    silent = ledger.claim("c", SCENE)
    time.sleep(0.01)
    other = ledger.claim("c", SCENE)
    record = next(SCENE.relax())
    assert not ledger.write(silent, record)
    assert ledger.write(other, record)
    ledger.renew(silent, state="done")
    (row,) = rows(ledger.database, record="case")
    assert (row.state, row.finished) == ("running", 1)
    assert len(rows(ledger.database, record="step")) == 1


def test_a_case_that_fails_stops_no_other_and_is_tried_again(tmp_path):
    database = tmp_path / "e.db"
    # deeper than the roughness is wide
    deep = replace(SCENE, path=replace(SCENE.path, last=100.0))
    for _ in range(2):
        progress = finish([deep, SCENE], database)
        assert progress.steps == 4
        assert list(progress.failures) == [case_of(deep)]
        assert "ValueError: " in progress.failures[case_of(deep)]
        assert str(progress) == "4/6 steps, 1 failed, about 0:00:00 left"
    (row,) = rows(database, state="failed")
    assert row.case == case_of(deep)
    assert len(read_ensemble(database, case=case_of(SCENE))["step"]) == 3


def test_time_left_is_that_of_the_expected_cost_of_what_is_left():
    meter = Meter({"a": np.array([0.0, 1.0, 4.0]), "b": np.array([0.0, 2.0])}, 0.0)
    none = Standing()
    assert np.isnan(meter.read({"a": none, "b": none}).left)
    half = meter.read({"a": Standing(finished=1), "b": none})
    assert half.left == pytest.approx(5.0 * half.elapsed)
    assert (half.steps, half.total) == (1, 3)


def test_large_loads_are_expected_to_cost_more():
    path = PathConfig("load", values=(1.0, 1e6))
    start, light, both = costs_of(replace(SCENE, path=path))
    assert start == 0.0
    assert both - light > 2 * light


def test_processes_share_the_processors_unless_the_user_has_said_how(monkeypatch):
    name = "OMP_NUM_THREADS"
    monkeypatch.setattr(run, "processors", lambda: 6)
    with run._processes(2) as shared, run._processes(2) as told:
        monkeypatch.delenv(name, raising=False)
        share = shared.submit(os.getenv, name)
        monkeypatch.setenv(name, "5")
        choice = told.submit(os.getenv, name)
        assert (share.result(), choice.result()) == ("3", "5")


def test_cases_in_threads_take_one_thread_unless_the_user_has_said_how(
    monkeypatch, tmp_path
):
    seen, relax = [], Scene.relax

    def spied(*arguments):
        seen.append(parallel.available_threads())
        return relax(*arguments)

    monkeypatch.setattr(Scene, "relax", spied)
    monkeypatch.setattr(parallel, "processors", lambda: 6)
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    finish([SCENE], tmp_path / "one.db")
    monkeypatch.setenv("OMP_NUM_THREADS", "5")
    finish([SCENE], tmp_path / "five.db")
    assert seen == [1, 5]


def test_table_holds_ten_digits(undisturbed, tmp_path):
    write_table(undisturbed, tmp_path / "e.csv")
    columns = read_table(tmp_path / "e.csv")
    assert_same(columns, read_ensemble(undisturbed), but=set(), rtol=5e-10)
    assert len(columns["case"]) == STEPS


def test_table_goes_into_a_database_and_comes_back_once(undisturbed, tmp_path):
    database, table, again = (tmp_path / name for name in ("e.db", "e.csv", "f.csv"))
    write_table(undisturbed, table)
    assert fill_database(database, table) == STEPS
    assert fill_database(database, table) == 0
    write_table(database, again)
    assert again.read_text() == table.read_text()


def test_a_table_that_has_a_step_twice_does_not_go_into_a_database(
    undisturbed, tmp_path
):
    database, table = tmp_path / "e.db", tmp_path / "e.csv"
    write_table(undisturbed, table)
    with open(table, "a") as file:
        file.write(table.read_text().splitlines()[3] + "\n")
    with pytest.raises(
        ValueError, match=r"e\.csv must .* got step 2 of case c\w+ again"
    ):
        fill_database(database, table)
    assert not database.exists()


def test_table_of_every_digit_is_read_to_the_last(undisturbed, tmp_path):
    columns = read_ensemble(undisturbed)
    with open(tmp_path / "e.csv", "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows(zip(*(x.tolist() for x in columns.values()), strict=True))
    assert_same(read_table(tmp_path / "e.csv"), columns, but=set())


def test_a_run_goes_on_from_a_table_alone(undisturbed, tmp_path):
    database, table = tmp_path / "e.db", tmp_path / "e.csv"
    write_table(undisturbed, table, "step<2")
    fill_database(database, table)
    before = {row.unique_id for row in rows(database, record="step")}
    assert len(before) == 2 * len(SCENES)
    assert finish(SCENES[:4], database).steps == 4 * 3
    assert before <= {row.unique_id for row in rows(database, record="step")}
    for scene in SCENES[:4]:
        whole, again = (
            read_ensemble(origin, case=case_of(scene))
            for origin in (undisturbed, database)
        )
        assert_same(again, whole, EFFORT, **RESUMED)


def test_a_table_of_other_columns_or_values_is_refused(undisturbed, tmp_path):
    table = tmp_path / "e.csv"
    table.write_text("case,seed\nc,1\n")
    with pytest.raises(ValueError, match="must have the columns case, step, control"):
        read_table(table)
    table.write_text("case,step,colour\nc,1,red\n")
    with pytest.raises(ValueError, match="got case, step, colour"):
        read_table(table)
    write_table(undisturbed, table)
    table.write_text(table.read_text().replace(",True,", ",yes,"))
    with pytest.raises(ValueError, match="'yes' where a bool is expected"):
        read_table(table)
    table.write_text("case,step\nc,first\n")
    with pytest.raises(ValueError, match="'first' where a int is expected"):
        read_table(table)


def test_a_table_that_is_cut_off_is_refused(undisturbed, tmp_path):
    table = tmp_path / "e.csv"
    write_table(undisturbed, table)
    table.write_text(table.read_text()[:-100])
    with pytest.raises(ValueError, match=r"'' where a .* is expected"):
        read_table(table)


def test_what_a_table_does_not_have_is_missing(tmp_path):
    table = tmp_path / "e.csv"
    table.write_text("case,step\nc,1\n")
    columns = read_table(table)
    assert columns["step"].tolist() == [1]
    assert np.isnan(columns["memory"]).all()


@pytest.mark.parametrize(
    "scenes, database, options, message",
    [
        ([], "e.db", {}, "at least one scene"),
        ([SCENE], "e.json", {}, "with transactions.*e.json"),
        ([SCENE], "mysql://host/e", {}, "with transactions"),
        ([SCENE], "e.db", {"workers": 0}, "workers must be an integer >= 1"),
        ([SCENE], "e.db", {"lease": 0.0}, "lease must be"),
        (product(SCENE, {"path.values": [()]}), "e.db", {}, "at least one step"),
        (product(SCENE, {"interaction.kind": ["soft"]}), "e.db", {}, "kind of inter"),
        (product(SCENE, {"solver.optimizer": ["LFBGS"]}), "e.db", {}, "'LBFGS'"),
    ],
)
def test_bad_input_is_refused_at_once(tmp_path, scenes, database, options, message):
    name = database if "://" in database else tmp_path / database
    with pytest.raises(ValueError, match=message):
        run_ensemble(scenes, name, **options)
    assert not list(tmp_path.iterdir())


def test_a_database_that_is_not_there_is_not_made(tmp_path):
    with pytest.raises(ValueError, match="there is no database"):
        read_ensemble(tmp_path / "e.db")
    assert not list(tmp_path.iterdir())
