"""Runs of ensembles: every step once, whoever calculates it and whatever is killed."""

import concurrent.futures
import itertools
import multiprocessing
import os
import signal
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from functools import partial
from itertools import zip_longest
from pathlib import Path

import numpy as np
import pytest
from ase.db.core import Database
from ensemble_scenes import (
    LONG,
    SCENE,
    SCENES,
    SPAWN,
    STEPS,
    Here,
    assert_same,
    assert_same_states,
    finish,
    killed,
    rows,
    wait_for,
)

from ase_roughcontact._util import threads
from ase_roughcontact._util.workers import worker_pool
from ase_roughcontact.ensemble import case_of, product, read_ensemble, run_ensemble
from ase_roughcontact.ensemble.columns import step_columns
from ase_roughcontact.ensemble.database import EnsembleDatabase
from ase_roughcontact.scene import Scene

slow = partial(pytest.param, marks=pytest.mark.slow)  # processes of their own


def new_database(folder):
    database = EnsembleDatabase(str(folder / "e.db"))
    database.create()
    return database


# Results


def test_steps_agree_with_the_scenes_alone(undisturbed):
    columns = read_ensemble(undisturbed)
    for scene in SCENES:
        of_case = columns["case"] == case_of(scene)
        for name in ("step", "normal_force", "energy", "contact_area"):
            alone = [getattr(record, name) for record in scene.relax()]
            np.testing.assert_array_equal(columns[name][of_case], alone)
        np.testing.assert_array_equal(columns["target"][of_case], scene.targets)


def test_a_complete_ensemble_is_not_calculated_again(undisturbed):
    before = [row.unique_id for row in rows(undisturbed, record="step")]
    executor = Here()
    (progress,) = run_ensemble(SCENES, undisturbed, executor)
    assert progress.steps == progress.total == STEPS and not executor.count
    assert [row.unique_id for row in rows(undisturbed, record="step")] == before


def test_result_does_not_depend_on_the_number_of_processes(undisturbed, tmp_path):
    seen = list(run_ensemble(SCENES, tmp_path / "e.db", workers=2, interval=0.05))
    assert [p.steps for p in seen] == sorted(p.steps for p in seen)
    assert (seen[0].steps, seen[-1].steps, seen[-1].left) == (0, STEPS, 0.0)
    assert_same(read_ensemble(tmp_path / "e.db"), read_ensemble(undisturbed))
    assert [path.name for path in tmp_path.rglob("*.*")] == ["e.db"]


def test_a_failed_case_stops_no_other_and_is_tried_again(tmp_path):
    database = tmp_path / "e.db"
    # deeper than the roughness is wide
    deep = SCENE.with_values({"path.last": 100.0})
    for _ in range(2):
        with pytest.warns(UserWarning, match="1 of . .*100.0.* domain of"):
            progress = finish([deep, SCENE], database)
        assert progress.steps == 4
        assert list(progress.failures) == [case_of(deep)]
        assert "Error: atoms can touch beyond" in progress.failures[case_of(deep)]
        assert list(progress.named_failures) == ["path.penetrations.last = 100.0"]
        assert str(progress) == "4/6 steps, 1 failed, about 0:00:00 left"
    (row,) = rows(database, record="case", state="failed")
    assert row.case == case_of(deep)
    assert row.message == progress.failures[row.case]
    assert row.radius == 60.0
    assert len(read_ensemble(database, case=case_of(SCENE))["step"]) == 3


def test_a_case_that_succeeds_keeps_nothing_of_an_earlier_failure(tmp_path):
    finish([SCENE], tmp_path / "new.db")
    database = EnsembleDatabase(str(tmp_path / "e.db"))
    database.create()
    earlier = {"message": "MemoryError: too large", "pull_off_force": 3.0}
    database.set_state(case_of(SCENE), "failed", {}, **earlier)
    finish([SCENE], tmp_path / "e.db")
    found = read_ensemble(tmp_path / "e.db", record="case")
    assert_same(found, read_ensemble(tmp_path / "new.db", record="case"))
    assert list(found["message"]) == [""]


def test_a_run_that_has_lost_its_lock_says_so(tmp_path):
    def remove_locks():
        for file in tmp_path.glob("*.lock"):
            file.unlink()

    database = tmp_path / "e.db"
    with pytest.raises(RuntimeError, match="start the ensemble again"):
        list(run_ensemble([SCENE], database, Here(remove_locks)))
    assert finish([SCENE], database).steps == 3


@pytest.mark.parametrize(
    "scenes, database, options, message",
    [
        ([], "e.db", {}, "one scene"),
        ([SCENE], "e.json", {}, "ends in .db.*e.json"),
        ([SCENE], "e.db", {"workers": 0}, "workers .* 1"),
        ([SCENE], "e.db", {"interval": 0.0}, "interval"),
        ([SCENE], "e.db", {"steps": [[0, 3]]}, "2, got 3"),
        (product(SCENE, {"path.values": [()]}), "e.db", {}, "give loads"),
        (product(SCENE, {"solver.optimizer": ["LFBGS"]}), "e.db", {}, "'LFBGS'"),
    ],
)
def test_bad_input_is_rejected_at_once(tmp_path, scenes, database, options, message):
    name = database if "://" in database else tmp_path / database
    with pytest.raises(ValueError, match=message):
        run_ensemble(scenes, name, **options)
    assert not list(tmp_path.iterdir())


# Threads


@pytest.mark.parametrize("workers", [slow(1), 2])
def test_processes_share_the_processors_unless_the_user_set_the_threads(
    workers, monkeypatch
):
    name = "OMP_NUM_THREADS"
    pools = worker_pool(None, workers), worker_pool(None, workers)
    with pools[0] as shared, pools[1] as chosen:
        monkeypatch.delenv(name, raising=False)
        share = shared.submit(os.getenv, name)
        monkeypatch.setenv(name, "5")
        choice = chosen.submit(os.getenv, name)
        expected = max(1, threads.processors() // workers)
        assert (share.result(), choice.result()) == (str(expected), "5")


def test_cases_in_threads_use_one_thread_unless_the_user_set_the_threads(
    monkeypatch, tmp_path
):
    seen, relax = [], Scene.relax

    def spied(*arguments, **options):
        seen.append(threads.available_threads())
        return relax(*arguments, **options)

    monkeypatch.setattr(Scene, "relax", spied)
    monkeypatch.setattr(threads, "processors", lambda: 6)
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    finish([SCENE], tmp_path / "one.db")
    monkeypatch.setenv("OMP_NUM_THREADS", "5")
    finish([SCENE], tmp_path / "five.db")
    assert seen == [1, 5]


# Several workers and several runs


def hold_lock(database, locked):
    with database.lock("c") as free:
        locked.set() if free else None
        time.sleep(60)


def test_the_lock_of_a_killed_process_is_released(tmp_path):
    database, locked = new_database(tmp_path), SPAWN.Event()
    process = SPAWN.Process(target=hold_lock, args=(database, locked))
    process.start()
    assert locked.wait(30) and database.is_locked("c")
    database.create()  # removes lock files, but not of living processes
    assert database.is_locked("c")
    process.kill()
    process.join(10)
    assert list(tmp_path.glob("*.lock"))
    database.create()
    assert not list(tmp_path.glob("*.lock"))
    assert not database.is_locked("c")


def test_of_many_workers_one_locks_a_case_and_one_stores_a_step(tmp_path):
    database, ready = new_database(tmp_path), threading.Barrier(8)
    row = step_columns("c1", SCENE, next(SCENE.relax()))

    def write(_):
        ready.wait(10)
        return database.add_steps([row], {}, case="c1", step=0)

    def try_lock(_):
        with database.lock("c") as free:
            ready.wait(10)
            return free

    with ThreadPoolExecutor(8) as pool:
        assert sum(pool.map(try_lock, range(8))) == 1
        assert sum(pool.map(write, range(8))) == 1
    assert not database.is_locked("c")
    assert len(rows(database.address, record="step")) == 1


def test_two_runs_at_once_share_the_cases(undisturbed, tmp_path):
    database = tmp_path / "e.db"
    with ThreadPoolExecutor(1) as one, ThreadPoolExecutor(1) as other:
        runs = [run_ensemble(SCENES, database, x, interval=0.02) for x in (one, other)]
        *_, last = zip_longest(*runs)
    assert [p.steps for p in last if p] == [STEPS] * sum(map(bool, last))
    assert_same(read_ensemble(database), read_ensemble(undisturbed))


def test_a_case_of_another_run_is_calculated_when_that_run_ends(tmp_path):
    database = new_database(tmp_path)
    with ThreadPoolExecutor(1) as pool:
        with database.lock(case_of(SCENE)):
            run = pool.submit(finish, [SCENE], database.address)
            time.sleep(0.3)
            assert not database.steps()
        assert run.result().steps == 3


# Interruptions


def test_closing_the_generator_stops_the_workers(tmp_path):
    database = tmp_path / "e.db"
    with ThreadPoolExecutor(2) as pool:
        progress = run_ensemble(SCENES, database, pool, interval=0.02)
        while next(progress).steps == 0:
            pass
        progress.close()
        done = len(rows(database, record="step"))
    assert 0 < len(rows(database, record="step")) == done < STEPS
    assert not list(tmp_path.glob("*.lock"))
    assert finish(SCENES, database).steps == STEPS


def die_writing(scene, database, count, after):
    """Run, and be killed before or after the count-th step is written."""
    write, written = Database.write, []

    def deadly(*arguments, **options):
        written.append(True)
        if len(written) < count:
            return write(*arguments, **options)
        if after:
            write(*arguments, **options)
        return os.kill(os.getpid(), signal.SIGKILL)

    Database.write = deadly
    finish([scene], database)


@pytest.mark.parametrize(
    "scene, after",
    [
        slow(SCENES[-2], True, id="repulsive-after-writing"),
        slow(SCENES[-1], True, id="adhesive-after-writing"),
        pytest.param(SCENES[-1], False, id="adhesive-before-writing"),
    ],
)
def test_a_case_continues_that_was_killed_in_the_middle_of_a_transaction(
    undisturbed, tmp_path, scene, after
):
    database = tmp_path / "e.db"
    killed(die_writing, scene, database, 7, after)
    before = {row.step: row.unique_id for row in rows(database, record="step")}
    assert list(before) == list(range(6))
    assert finish([scene], database).steps == 10
    after = {row.step: row.unique_id for row in rows(database, record="step")}
    assert before.items() <= after.items()
    whole = read_ensemble(undisturbed, case=case_of(scene))
    assert_same_states(read_ensemble(database), whole)
    assert not list(tmp_path.rglob("*.npz"))


@pytest.mark.parametrize("file_is", ["of all steps", "damaged", "being written"])
def test_a_restart_file_that_does_not_fit_is_not_used(undisturbed, tmp_path, file_is):
    scene, database = SCENES[1], tmp_path / "e.db"
    file = tmp_path / "e-checkpoints" / f"{case_of(scene)}.npz"
    file.parent.mkdir()
    other = scene.relax(restart=file)
    if file_is == "of all steps":  # the database has none
        assert len(list(other)) == 3
    elif file_is == "damaged":
        other.close()
        file.write_bytes(b"half a file")
    else:  # the case fails once
        assert next(other).step == 0
        (message,) = finish([scene], database).failures.values()
        assert "another run is writing" in message
        assert [record.step for record in other] == [1, 2]
    assert finish([scene], database).steps == 3
    whole = read_ensemble(undisturbed, case=case_of(scene))
    assert_same(read_ensemble(database), whole)


def test_a_killed_process_is_reported_and_loses_no_finished_step(undisturbed, tmp_path):
    database, victims = tmp_path / "e.db", []
    with pytest.raises(RuntimeError, match="start the ensemble again"):
        for progress in run_ensemble(SCENES, database, workers=2, interval=0.02):
            if progress.steps and not victims:  # the others are ended by the pool
                victims = multiprocessing.active_children()[:1]
                victims[0].kill()
    before = {row.unique_id for row in rows(database, record="step")}
    assert 0 < len(before) < STEPS
    assert finish(SCENES, database).steps == STEPS
    assert before <= {row.unique_id for row in rows(database, record="step")}
    assert_same_states(read_ensemble(database), read_ensemble(undisturbed))


def run_in_one_process(scenes, database):
    list(run_ensemble(scenes, database, workers=1, interval=0.05))


def children_of(process):
    return Path(f"/proc/{process}/task/{process}/children").read_text().split()


def test_processes_end_with_the_one_that_started_them(tmp_path):
    database = tmp_path / "e.db"
    scenes = [LONG.with_values({"path.steps": 5000})]
    client = SPAWN.Process(target=run_in_one_process, args=(scenes, database))
    client.start()
    wait_for(lambda: database.exists() and database.stat().st_size)
    wait_for(lambda: rows(database, record="step"))
    processes = children_of(client.pid)
    assert processes
    client.kill()
    client.join(10)
    wait_for(lambda: not any(os.path.exists(f"/proc/{p}") for p in processes))
    assert not EnsembleDatabase(str(database)).is_locked(case_of(*scenes))


@pytest.mark.slow  # a scheduler and its processes
def test_results_with_dask_are_the_same_though_a_worker_is_killed(
    undisturbed, tmp_path
):
    from dask.distributed import Client, LocalCluster  # not in every process

    database, killed = tmp_path / "e.db", []
    options = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": ":0"}
    with LocalCluster(**options) as cluster, Client(cluster) as client:
        workers = client.run(os.getpid)
        for progress in run_ensemble(
            SCENES, database, client.get_executor(pure=False), interval=0.02
        ):
            if progress.steps and not killed:
                killed.append(next(iter(workers.values())))
                os.kill(*killed, signal.SIGKILL)
    assert killed
    assert progress.steps == progress.total == STEPS
    assert_same_states(read_ensemble(database), read_ensemble(undisturbed))


def test_workers_inherit_that_ctrl_c_is_for_the_parent():
    with worker_pool(None, 1) as pool:
        masked = pool.submit(signal.pthread_sigmask, signal.SIG_BLOCK, ()).result()
    assert signal.SIGINT in masked
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, ())


def test_a_task_that_was_cancelled_before_its_pool_breaks_prints_no_error(monkeypatch):
    errors = []
    monkeypatch.setattr(threading, "excepthook", errors.append)
    with worker_pool(None, 1) as pool:
        running, *waiting = [pool.submit(time.sleep, 60.0) for _ in range(4)]
        assert waiting[-1].cancel()
        for process in multiprocessing.active_children():
            process.kill()
        with pytest.raises(BrokenProcessPool):
            running.result(timeout=60.0)
    assert errors == []


def test_slow_queries_of_a_database_are_made_less_often(tmp_path, monkeypatch):
    pauses, ticks = [], itertools.count()
    whole = concurrent.futures.wait

    def wait(tasks, timeout=None):
        pauses.append(timeout)
        return whole(tasks)

    monkeypatch.setattr("ase_roughcontact.ensemble.run.wait", wait)
    monkeypatch.setattr(time, "process_time", lambda: 2.0 * next(ticks))
    list(run_ensemble(SCENES, tmp_path / "e.db", Here(), interval=0.05))
    assert pauses[0] == pytest.approx(100.0)
