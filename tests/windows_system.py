"""Windows as far as another system can show it: `pretend` is to be called first.

The modules and functions that Windows does not have are absent. Open files can't be
removed or replaced, and text files of the package without an encoding are an error.
Locks are those of fcntl, with the name and the error of msvcrt.
"""

import errno
import fcntl
import os
import signal
import sys
import warnings
from importlib import import_module
from types import ModuleType

ABSENT = {"fcntl", "grp", "pwd", "resource", "termios"}


class Absent:
    """Finder that does not find the modules of POSIX."""

    def find_spec(self, name, *_):
        if name in ABSENT:
            raise ModuleNotFoundError(name)


def locking(number, mode, size):
    assert mode == "LK_NBLCK" and size == 1
    try:
        fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise PermissionError(errno.EACCES, "Permission denied") from None


def same_file(one, other):
    return os.path.realpath(one) == os.path.realpath(other)


def refuse_open_files(function):
    def checked(*names, **options):
        for name in names:
            for number in os.listdir("/proc/self/fd"):
                if same_file(f"/proc/self/fd/{number}", name):
                    raise PermissionError(errno.EACCES, "The file is open", name)
        return function(*names, **options)

    return checked


def pretend():
    # Modules that would see which system it is.
    for name in ("concurrent.futures.process", "psutil", "random", "subprocess"):
        import_module(name)
    msvcrt = ModuleType("msvcrt")
    msvcrt.LK_NBLCK, msvcrt.locking = "LK_NBLCK", locking
    sys.modules["msvcrt"] = msvcrt
    sys.meta_path.insert(0, Absent())
    for name in ABSENT:
        sys.modules.pop(name, None)
    for name in ("remove", "rename", "replace", "unlink"):
        setattr(os, name, refuse_open_files(getattr(os, name)))
    del os.register_at_fork, os.sched_getaffinity, signal.pthread_sigmask
    warnings.filterwarnings("ignore", "", EncodingWarning)
    warnings.filterwarnings("error", "", EncodingWarning, "ase_roughcontact")
