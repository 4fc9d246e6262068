"""Locks of files."""

import os
import signal
import sys
from subprocess import PIPE, Popen

import pytest

from ase_roughcontact._util import files
from ase_roughcontact._util.files import lock

# Without the other modules of the package, whose import takes longer.
LOCK_AND_FORK = """
import os, sys, time
exec(open(sys.argv[2]).read())
with lock(sys.argv[1]) as free:
    child = os.fork()
    if child:
        print(free, child, flush=True)
        os.kill(os.getpid(), 9)
    time.sleep(60)
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
