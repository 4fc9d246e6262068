"""Locks of files against other processes, which end with the process that has them."""

from __future__ import annotations

import errno
import os
import warnings
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import IO, Any

from ase_roughcontact._util.files import PathName, is_file_of_name, refuse_link

# What a system raises if another process holds a lock: `BlockingIOError` by fcntl,
# `PermissionError` by msvcrt.
try:
    import fcntl

    def _take(file: IO[Any]) -> None:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)

except ImportError:  # on Windows
    import msvcrt

    def _take(file: IO[Any]) -> None:
        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined]


# Errors of a file system without locks.
_NO_LOCKS = {errno.ENOSYS, errno.ENOLCK, errno.EOPNOTSUPP}


@contextmanager
def locked(*files: PathName) -> Iterator[None]:
    """Lock files against other processes until the end of the context or process.

    The lock is on the file ``file.lock`` in the same folder, which is removed at the
    end. On a file system without locks, a `RuntimeWarning` is given.

    Raises
    ------
    RuntimeError
        If another process is writing one of the files.
    """
    unlocked = list[str]()
    with ExitStack() as stack:
        for name in files:
            file = os.fspath(name)
            try:
                free = stack.enter_context(lock(f"{file}.lock"))
            except OSError as error:
                if error.errno not in _NO_LOCKS:
                    raise
                unlocked.append(f"{file} ({error.strerror})")
                continue
            if not free:
                raise RuntimeError(
                    f"another run is writing {file}: wait for its end, or give another "
                    "name"
                )
        if unlocked:
            warnings.warn(
                f"the file system has no locks for {' and '.join(unlocked)}: make sure "
                "that no other run writes the same files",
                RuntimeWarning,
                stacklevel=2,
            )
        yield


@contextmanager
def lock(name: PathName) -> Iterator[bool]:
    """Lock a file until the end of the context, or of this process for any reason.

    The file is created, and removed at the end, unless it was replaced. The context
    yields true if no other process or thread holds the lock.

    Raises
    ------
    OSError
        If the file system has no locks, or the file is a symbolic link.
    """
    refuse_link(name)
    with open(name, "ab") as file:
        try:
            _take(file)
            # the last process with the lock may have removed the file meanwhile
            free = is_file_of_name(name, file)
        except (BlockingIOError, PermissionError):
            free = False
        except OSError:
            _remove(name, file)
            raise
        try:
            yield free
        finally:
            if free and is_file_of_name(name, file):
                _remove(name, file)


def _remove(name: PathName, file: IO[Any]) -> None:
    """Remove a lock file: before it is closed, or nobody may lock it in between.

    Windows removes files only when no process has them open.
    """
    try:
        Path(name).unlink(missing_ok=True)
    except PermissionError:
        file.close()
        with suppress(PermissionError):  # another process waits for it
            Path(name).unlink(missing_ok=True)
