"""Databases that are damaged or can't be used: the same results or a clear error."""

import random
import shutil
import sqlite3
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from threading import Timer

import pytest
from ase import Atoms
from ase.cli.main import main as ase
from ase.db import connect
from ensemble_scenes import assert_same, assert_same_states, finish
from small_scene import PERIODIC

from ase_roughcontact.cli import main
from ase_roughcontact.ensemble import product, read_ensemble, run_ensemble
from ase_roughcontact.scene import Scene

SCENE = Scene.parse(PERIODIC)
SCENES = product(SCENE, {"sphere.radius": [60.0, 70.0]})


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Database of all cases, and its columns."""
    database = tmp_path_factory.mktemp("whole") / "e.db"
    assert finish(SCENES, database).steps == 6
    return database, read_ensemble(database)


@pytest.fixture
def database(whole, tmp_path):
    """A copy of the database."""
    return shutil.copy(whole[0], tmp_path / "e.db")


def execute(database, command):
    with closing(sqlite3.connect(database)) as connection:
        connection.execute(command)
        connection.commit()


CHANGES = {
    "value": "UPDATE systems SET key_value_pairs = replace(key_value_pairs, "
    "'60.0', '61.0') WHERE id = 3",
    "energy": "UPDATE systems SET energy = energy + 1e-9 WHERE id = 3",
    "data": "UPDATE systems SET data = substr(data, 1, 20) || 'x' WHERE id = 3",
    "index of texts": "UPDATE text_key_values SET value = 'stop' "
    "WHERE value = 'step' AND id = 3",
    "index of numbers": "UPDATE number_key_values SET value = 7 "
    "WHERE key = 'step' AND id = 3",
    "missing entry": "DELETE FROM number_key_values WHERE key = 'step' AND id = 3",
    "checksum": "UPDATE systems SET key_value_pairs = replace(key_value_pairs, "
    "'checksum', 'chocksum') WHERE id = 3",
}


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES.keys())
def test_a_changed_row_is_named_and_the_database_left_as_it_is(database, change):
    execute(database, change)
    before = database.read_bytes()
    for use in (read_ensemble, lambda file: run_ensemble(SCENES, file)):
        with pytest.raises(ValueError, match=rf"row 3 of {database} is damaged"):
            use(database)
    assert database.read_bytes() == before


def test_a_row_that_is_deleted_as_the_message_says_is_calculated_again(
    whole, database, tmp_path, capsys
):
    execute(database, CHANGES["value"])
    with pytest.raises(ValueError, match="is damaged") as error:
        read_ensemble(database)
    command = f"db {database} id=3 --delete"
    assert f"'ase {command}'" in str(error.value)
    (tmp_path / "my.toml").write_text(SCENE.toml)
    file = str(tmp_path / "my.toml")
    assert main(["ensemble", file, "--database", str(database)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert f"row 3 of {database} is damaged" in line
    ase(args=[*command.split(), "--yes"])
    assert finish(SCENES, database).steps == 6
    assert_same_states(read_ensemble(database), whole[1])


def test_a_reader_waits_for_a_writer_longer_than_ase_does(whole, database, monkeypatch):
    opened = sqlite3.connect

    def impatient(*given, **options):
        return opened(*given, **{**options, "timeout": 0.0})

    monkeypatch.setattr(sqlite3, "connect", impatient)  # ASE gives 20 s
    writer = opened(database, check_same_thread=False)
    writer.execute("BEGIN EXCLUSIVE")
    release = Timer(0.3, writer.rollback)
    release.start()
    found = read_ensemble(database)
    release.join()
    writer.close()
    assert_same(found, whole[1])


def test_rows_of_other_programs_are_not_checked(whole, database):
    with connect(database) as db:
        db.write(Atoms("Cu"), record="other", step=1)
    assert_same(read_ensemble(database), whole[1])


@pytest.mark.parametrize("content", [None, "", "S"])
def test_no_file_or_an_empty_one_is_no_ensemble_without_steps(tmp_path, content):
    database = tmp_path / "e.db"
    if content is not None:
        database.write_text(content)
    with pytest.raises(ValueError, match=str(database)):
        read_ensemble(database)
    assert database.exists() == (content is not None)


@pytest.mark.parametrize("size", [50, 5000, 20_000])
def test_a_truncated_database_is_an_error_with_what_to_do(database, size):
    data = database.read_bytes()[:size]
    database.write_bytes(data)
    for use in (read_ensemble, lambda file: run_ensemble(SCENES, file)):
        with pytest.raises(ValueError, match=rf"{database} is damaged .*: restore"):
            use(database)
    assert database.read_bytes() == data


def damaged(data, rng):
    """Return bytes with one change: a bit, some zeros, a cut, an insertion."""
    used = [place for place, byte in enumerate(data) if byte]
    place = rng.choice(used) if rng.random() < 0.8 else rng.randrange(1, 100)
    before, after = data[:place], data[place:]
    flipped = before + bytes([after[0] ^ (1 << rng.randrange(8))]) + after[1:]
    zeros = before + bytes(min(64, len(after))) + after[64:]
    return rng.choice([flipped, flipped, flipped, zeros, before, before + b"7" + after])


@pytest.mark.parametrize(
    "seed, count", [(1, 40), pytest.param(2, 1000, marks=pytest.mark.slow)]
)
def test_random_damage_is_named_or_changes_nothing(whole, tmp_path, seed, count):
    origin, columns = whole
    rng, database = random.Random(seed), tmp_path / "e.db"
    for _ in range(count):
        data = damaged(origin.read_bytes(), rng)
        database.write_bytes(data)
        try:
            found = read_ensemble(database)
            assert finish(SCENES, database, interval=0.001).steps == 6
            again = read_ensemble(database)
        except (ValueError, OSError) as error:
            assert str(database) in str(error)
            assert database.read_bytes() == data
        else:
            assert_same(found, columns)
            assert_same(again, columns)


# Databases that can't be used


def test_a_full_disk_is_an_error_that_names_the_database(tmp_path, largest_file):
    database = tmp_path / "e.db"
    message = rf"can't use {database}: .*space on the"
    with ThreadPoolExecutor(1) as pool:
        steps = run_ensemble(SCENES, database, pool, interval=0.01)
        size = database.stat().st_size
        with largest_file(size), pytest.raises(OSError, match=message):
            list(steps)
    assert finish(SCENES, database).steps == 6


class NoLocks(sqlite3.Connection):
    """Connection on a file system without locks."""

    def cursor(self, *_):
        raise sqlite3.OperationalError("disk I/O error")


def test_a_file_system_without_locks_is_an_error_that_says_so(tmp_path, monkeypatch):
    open_database = sqlite3.connect
    monkeypatch.setattr(
        sqlite3, "connect", lambda *a, **k: open_database(*a, **k, factory=NoLocks)
    )
    with pytest.raises(OSError, match=r"e\.db: disk I/O error.*locks"):
        run_ensemble(SCENES, tmp_path / "e.db")
