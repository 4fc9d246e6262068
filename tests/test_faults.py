"""Faults: files of a calculation that is killed, stopped or has no space on the disk.

Tests of interrupted ensembles are in `tests/ensemble`.
"""

import errno
import fcntl
import os
import re
import signal
import subprocess
import sys
import time
from contextlib import suppress
from functools import partial
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory
from unittest.mock import Mock

import numpy as np
import pytest
from ase import Atoms
from ase.io import read
from hypothesis import given, settings
from hypothesis import strategies as st
from small_scene import SMALL

from ase_roughcontact._util.files import table_rows
from ase_roughcontact.cli import main
from ase_roughcontact.paths.restart import read_steps, restart_file
from ase_roughcontact.scene import Scene, default_text

STEPS = 24
TEXT = SMALL.partition("[solver]")[0].replace("steps = 2", f"steps = {STEPS}")
TEXT = TEXT.replace("first = 0.2", "first = 0.01")
SCENE = Scene.parse(TEXT)
slow = partial(pytest.param, marks=pytest.mark.slow)  # a process of its own each
# Runs a scene, and sends itself a signal when a function that writes files is called.
SIGNALLED = """
import importlib, os, signal, sys
from ase_roughcontact.cli import main

signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored in the background
scene, folder, part, last, number = sys.argv[1:]
module, _, name = part.partition(".")
module = importlib.import_module(module)
left, write = int(last), getattr(module, name)

def counted(*args, **kwargs):
    global left
    left -= 1
    if not left:
        os.kill(os.getpid(), int(number))
    return write(*args, **kwargs)

setattr(module, name, counted)
sys.exit(main(["run", scene, "--out", folder]))
"""


@pytest.fixture
def file(tmp_path):
    file = tmp_path / "scene.toml"
    file.write_text(TEXT)
    return file


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "out"


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    return list(SCENE.run(tmp_path_factory.mktemp("undisturbed")))


def signalled(file, folder, part, call, number):
    """Run the command, which sends itself a signal at a call of a method."""
    arguments = [str(file), str(folder), part, str(call), str(int(number))]
    return subprocess.run(
        [sys.executable, "-c", SIGNALLED, *arguments], capture_output=True, text=True
    )


def rows(folder):
    with open(folder / "curve.csv", newline="") as file:
        return list(table_rows(file))


def assert_resumes(folder, undisturbed, before):
    """Resume, and compare with an undisturbed run."""
    records = list(SCENE.run(folder))
    assert records[: len(before)] == before
    assert [record.step for record in records] == list(range(STEPS))
    for name in ("height", "normal_force", "contact_area", "energy"):
        ours = [getattr(record, name) for record in records]
        theirs = [getattr(record, name) for record in undisturbed]
        assert ours == theirs
    assert [int(row["step"]) for row in rows(folder)] == list(range(STEPS))
    # the frame of a finished step may be lost, as on a full disk
    frames = read(folder / "sweep.traj", ":")
    assert len(frames) >= STEPS - 1
    assert frames[-1].info["load_step"]["step"] == STEPS - 1


def kept(folder):
    """Results of the finished steps."""
    file = restart_file(folder / "sweep.traj")
    return read_steps(file) if file.exists() else []


# Kills


@pytest.mark.parametrize(
    "part, call",
    [
        slow("zlib.compress", 1),
        ("zlib.compress", 14),
        slow("numpy.savez", 1),
        ("numpy.savez", 5),
        slow("os.replace", 2),
        ("os.replace", 12),
    ],
)
def test_run_killed_while_writing_a_file_resumes(file, folder, undisturbed, part, call):
    assert signalled(file, folder, part, call, signal.SIGKILL).returncode < 0
    before = kept(folder)
    # a step is in the restart file before its row is written
    written = len(rows(folder)) if (folder / "curve.csv").exists() else 0
    assert written <= len(before) < STEPS
    assert_resumes(folder, undisturbed, before)


def test_single_frame_is_replaced_completely_or_not_at_all(tmp_path, monkeypatch):
    movie = tmp_path / "last.traj"
    path = SCENE.relax(trajectory=movie, keep="last")
    record = next(path)
    monkeypatch.setattr(os, "replace", Mock(side_effect=KeyboardInterrupt))
    with pytest.raises(KeyboardInterrupt):
        next(path)
    assert read_steps(restart_file(movie)) == [record]


# Ctrl-C and SIGTERM

SIGNALS = {
    signal.SIGINT: (130, "interrupted"),
    signal.SIGTERM: (143, "terminated"),
}


@pytest.mark.parametrize("number", SIGNALS)
@pytest.mark.parametrize("count", [slow(2), 8])
def test_interrupted_run_says_that_it_can_be_resumed(
    file, folder, undisturbed, count, number
):
    process = signalled(file, folder, "numpy.savez", count, number)
    status, word = SIGNALS[number]
    assert process.returncode == status
    assert process.stderr.strip() == (
        f"{word}; finished steps are saved in {folder}; to continue, give the same "
        f"command again; to draw them: ase-roughcontact figure {folder}"
    )
    assert_resumes(folder, undisturbed, kept(folder))


def test_terminated_ensemble_says_that_it_can_be_continued(
    tmp_path, monkeypatch, capsys
):
    def terminated(*_, **__):
        yield os.kill(os.getpid(), signal.SIGTERM)

    monkeypatch.setattr("ase_roughcontact.cli.ensembles.run_ensemble", terminated)
    before, database = signal.getsignal(signal.SIGTERM), str(tmp_path / "e.db")
    assert main(["ensemble", "--database", database]) == 143
    assert signal.getsignal(signal.SIGTERM) is before
    message = f"terminated; finished steps are saved in {database}; to continue"
    assert message in capsys.readouterr().err


@pytest.mark.parametrize("number", SIGNALS)
def test_error_that_hides_a_signal_is_printed_as_an_interruption(
    file, folder, undisturbed, monkeypatch, capsys, request, number
):
    handler = signal.signal(signal.SIGINT, signal.default_int_handler)
    request.addfinalizer(partial(signal.signal, signal.SIGINT, handler))
    # as `numpy.ndarray.tofile` does with what a handler raises
    whole, calls = np.savez, count(1)

    def hides(*args, **arrays):
        if next(calls) < 8:
            return whole(*args, **arrays)
        with suppress(KeyboardInterrupt):
            os.kill(os.getpid(), number)
            time.sleep(1.0)  # until the handler was called
        raise TypeError("expected str, bytes or os.PathLike object")

    monkeypatch.setattr(np, "savez", hides)
    status, word = SIGNALS[number]
    assert main(["run", str(file), "--out", str(folder)]) == status
    printed = capsys.readouterr().err.strip()
    assert printed.startswith(f"{word}; finished steps are saved in {folder}; ")
    monkeypatch.undo()
    assert_resumes(folder, undisturbed, kept(folder))


# Damaged and foreign files


def test_trajectory_of_another_program_is_not_changed(folder):
    folder.mkdir()
    Atoms("Cu").write(folder / "sweep.traj")
    written = (folder / "sweep.traj").read_bytes()
    with pytest.raises(ValueError, match="no frame of"):
        next(SCENE.run(folder))
    assert (folder / "sweep.traj").read_bytes() == written


@pytest.mark.parametrize("name", ["sweep.traj", "sweep.restart.npz"])
def test_a_file_that_is_cut_off_at_its_beginning_is_an_error_and_kept(folder, name):
    next(SCENE.run(folder))
    file = folder / name
    file.write_bytes(file.read_bytes()[:20])
    with pytest.raises(ValueError, match=name):
        next(SCENE.run(folder))
    assert file.stat().st_size == 20


@settings(max_examples=100, deadline=None, derandomize=True, database=None)
@given(st.text(max_size=60) | st.integers(0, len(default_text())))
def test_any_or_truncated_text_is_a_scene_or_an_error(text):
    if isinstance(text, int):
        text = default_text()[:text]
    try:
        assert isinstance(Scene.parse(text), Scene)
    except ValueError as error:
        assert "scene" in str(error) or "TOML" in str(error)


# File systems without locks


def test_run_on_a_file_system_without_locks_warns_and_works(
    folder, undisturbed, monkeypatch
):
    missing = OSError(errno.ENOSYS, "Function not implemented")
    monkeypatch.setattr(fcntl, "flock", Mock(side_effect=missing))
    with pytest.warns(
        RuntimeWarning, match=r"no locks for .*sweep\.traj.*no other run"
    ):
        path = SCENE.run(folder)
        before = [next(path) for _ in range(2)]
    path.close()
    monkeypatch.undo()
    assert not list(folder.glob("*.lock"))
    assert_resumes(folder, undisturbed, before)


def test_other_errors_of_locking_are_raised_and_leave_no_trajectory(
    folder, monkeypatch
):
    error = OSError(errno.EIO, "Input/output error")
    monkeypatch.setattr(fcntl, "flock", Mock(side_effect=error))
    with pytest.raises(OSError, match="Input/output"):
        next(SCENE.run(folder))
    assert not (folder / "sweep.traj").exists()


# Full disks and missing permissions


@pytest.mark.filterwarnings("ignore:frame .* is cut off:RuntimeWarning")
@pytest.mark.parametrize("size", [100, 3_000, slow(15_000), 100_000])
def test_full_disk_is_one_line_with_file_and_cause_and_loses_nothing(
    file, folder, undisturbed, size, capsys, largest_file
):
    with largest_file(size):
        assert main(["run", str(file), "--out", str(folder)]) == 2
    (message,) = capsys.readouterr().err.splitlines()
    assert message.startswith("ase-roughcontact: can't write ")
    assert str(folder) in message
    assert "too large" in message or "disk is full" in message
    # a first frame that does not fit leaves no file
    assert (folder / "sweep.traj").exists() == (size > 10_000)
    before = kept(folder)
    assert bool(before) == (size == 100_000)
    assert not list(folder.glob("*.new"))
    assert_resumes(folder, undisturbed, before)


@pytest.mark.parametrize("name", ["curve.png", "view.traj", "scene.toml"])
def test_what_does_not_fit_is_named_and_the_old_file_is_kept(
    file, folder, name, capsys, largest_file
):
    steps = SCENE.run(folder)
    for _ in range(3):
        next(steps)
    steps.close()
    commands = {
        "curve.png": (1_000, ["figure", str(folder)]),
        "view.traj": (200_000, ["figure", str(folder)]),
        "scene.toml": (90_000, ["run", str(file), "--out", str(folder)]),
    }
    file.write_text(f"{TEXT}#{' ' * 100_000}\n")
    (folder / name).write_text("old")
    size, command = commands[name]
    with largest_file(size):
        assert main(command) == 2
    assert f"can't write {folder / name}: " in capsys.readouterr().err
    assert (folder / name).read_text() == "old"
    assert not list(folder.glob("*.new"))


# Symbolic links


@pytest.mark.parametrize(
    "name", ["curve.csv", "sweep.traj", "sweep.restart.npz", "sweep.traj.lock"]
)
def test_symbolic_links_to_results_are_refused(file, folder, name, capsys):
    other = folder.parent / "other"
    next(SCENE.run(other))
    folder.mkdir()
    target = other / name.removesuffix(".lock")
    before = target.read_bytes()
    (folder / name).symlink_to(target)
    assert main(["run", str(file), "--out", str(folder)]) == 2
    assert f"{folder / name} is a symbolic link" in capsys.readouterr().err
    assert target.read_bytes() == before


NEW = ["scene.toml", "view.traj", "curve.png", "contact.png", "curve.png.new"]


def test_symbolic_links_to_files_that_are_made_anew_are_replaced(file, folder):
    folder.mkdir()
    target = folder.parent / "target"
    target.write_text("precious")
    for name in NEW:
        (folder / name).symlink_to(target)
    assert main(["run", str(file), "--out", str(folder), "--quiet"]) == 0
    assert target.read_text() == "precious"
    assert not [path for path in folder.iterdir() if path.is_symlink()]


def test_folder_of_another_user_is_one_line(capsys):
    with TemporaryDirectory() as place:
        scene, folder = Path(place, "scene.toml"), Path(place, "out")
        scene.write_text(TEXT)
        folder.mkdir(mode=0o555)
        os.chmod(place, 0o755)
        user = os.geteuid()
        try:
            os.seteuid(user or 65534)  # root may write everywhere
            status = main(["run", str(scene), "--out", str(folder)])
        finally:
            os.seteuid(user)
        assert status == 2
        assert "Permission denied" in capsys.readouterr().err
        assert not list(folder.iterdir())


# Hostile scene files

PATHS = ("../evil", "~/evil", "$(touch evil)", "evil\\u0000", "; touch evil")
WORDS = ("__import__('os').system('touch evil')", *PATHS)
KEYS = {
    "substrate": ("symbol", "shape"),
    "sphere": ("profile",),
    "roughness": ("normalise",),
    "interaction": ("kind",),
    "path": ("control", "scale"),
    "solver": ("optimizer", "accuracy"),
}


@pytest.mark.parametrize("table, name", [(t, n) for t in KEYS for n in KEYS[t]])
def test_no_value_of_a_scene_is_executed_or_opened(table, name, tmp_path, monkeypatch):
    work, scene = tmp_path / "work", tmp_path / "s.toml"
    work.mkdir()
    monkeypatch.chdir(work)
    monkeypatch.setenv("HOME", str(work))
    others = re.sub(rf"(?m)^{name} = .*\n", "", TEXT)
    if f"[{table}]" not in others:
        others += f"[{table}]\n"
    for word in WORDS:
        scene.write_text(others.replace(f"[{table}]", f'[{table}]\n{name} = "{word}"'))
        assert main(["run", str(scene), "--out", str(tmp_path / "out")]) == 2
        assert {p.name for p in tmp_path.iterdir()} <= {"s.toml", "out", "work"}
        assert not [p for p in tmp_path.rglob("*") if "evil" in p.name]
