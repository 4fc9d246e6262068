"""Freed memory that the C library keeps for new arrays.

The C library of GNU returns arrays above 32 MB to the system when they are freed, and
the end of its heap. New arrays then cost a page fault for each 4 kB or 2 MB, in which
the system sets the memory to zero, for one thread at a time.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache

# Arrays with fewer elements stay below the sizes that are returned.
_LARGE = 1 << 20
# Parameters of mallopt, see malloc.h: free memory at the end of the heap, and size of
# a piece of memory, from which on they are returned.
_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3
# Values while memory is kept, and those that the library chooses after large pieces.
_KEPT, _USUAL_TRIM, _USUAL_MMAP = 2**31 - 1, 64 << 20, 32 << 20


@contextmanager
def freed_memory_kept(size: int) -> Iterator[None]:
    """Keep freed memory within a ``with`` block, and return it at the end.

    It applies to the whole process, and to forked ones. Nothing happens with other C
    libraries, and with old versions that refuse to keep large arrays. At the end the
    thresholds are fixed at their usual values.

    Parameters
    ----------
    size : int
        Elements of the arrays that are needed again and again; nothing happens for
        small ones.
    """
    library = _library() if size >= _LARGE else None
    if library is None or not library.mallopt(_MMAP_THRESHOLD, _KEPT):
        yield
        return
    library.mallopt(_TRIM_THRESHOLD, _KEPT)
    try:
        yield
    finally:
        library.mallopt(_MMAP_THRESHOLD, _USUAL_MMAP)
        library.mallopt(_TRIM_THRESHOLD, _USUAL_TRIM)
        library.malloc_trim(0)


@cache
def _library() -> ctypes.CDLL | None:
    """Return the C library of GNU; None if there is another one."""
    if os.name != "posix":
        return None
    library = ctypes.CDLL(None)
    return library if hasattr(library, "gnu_get_libc_version") else None
