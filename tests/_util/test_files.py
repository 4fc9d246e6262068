"""Locks of files."""

import os
import signal
import sys
from subprocess import PIPE, Popen, check_output

import pytest

from ase_roughcontact._util import files
from ase_roughcontact._util.files import lock

# Without the other modules of the package, whose import takes longer.
LOCK_AND_FORK = """
import os, sys, time
exec(open(sys.argv[2]).read())
with lock(sys.argv[1]) as free:
    begun, tell = os.pipe()
    child = os.fork()
    if child:
        os.read(begun, 1)
        print(free, child, flush=True)
        os.kill(os.getpid(), 9)
    os.write(tell, b"x")
    time.sleep(60)
"""

FORK_AND_END = """
import os, sys
exec(open(sys.argv[2]).read())
with lock(sys.argv[1]):
    child = os.fork()
    if not child:
        sys.exit()
    os.waitpid(child, 0)
    print(os.path.exists(sys.argv[1]))
"""


def test_one_of_two_locks_a_file_and_the_file_is_removed(tmp_path):
    name = tmp_path / "a.lock"
    with lock(name) as first:
        with lock(name) as second:
            assert first and not second
        assert name.exists()
    assert not name.exists()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
def test_forked_child_of_a_killed_process_does_not_keep_its_lock(tmp_path):
    name = tmp_path / "a.lock"
    command = [sys.executable, "-c", LOCK_AND_FORK, name, files.__file__]
    process = Popen(command, stdout=PIPE, text=True)
    free, child = process.stdout.readline().split()
    try:
        process.wait(10)
        assert free == "True" and name.exists()
        with lock(name) as again:
            assert again
    finally:
        os.kill(int(child), signal.SIGKILL)
        process.stdout.close()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
def test_forked_child_that_ends_leaves_the_lock_of_its_parent(tmp_path):
    command = [sys.executable, "-c", FORK_AND_END, tmp_path / "a.lock", files.__file__]
    assert check_output(command, text=True).split() == ["True"]
