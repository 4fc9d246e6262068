"""Freed memory is kept for new arrays of the same size, and returned at the end."""

import ctypes
import os

import numpy as np
import pytest

from ase_roughcontact._util.allocation import freed_memory_kept

resource = pytest.importorskip("resource")
M_MMAP_THRESHOLD = -3


def keeps_large_arrays():
    library = ctypes.CDLL(None)
    if not hasattr(library, "gnu_get_libc_version"):
        return False
    kept = library.mallopt(M_MMAP_THRESHOLD, 2**31 - 1)
    library.mallopt(M_MMAP_THRESHOLD, 32 << 20)
    return bool(kept)


pytestmark = pytest.mark.skipif(
    not keeps_large_arrays(), reason="needs a recent C library of GNU"
)

LARGE = 1 << 20
BYTES = 48 << 20


def faults_of_a_second_array(size):
    """Return the page faults of filling an array where another one was freed."""
    with freed_memory_kept(size):
        np.ones(BYTES // 8)
        before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
        np.ones(BYTES // 8)
        return resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before


def resident():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def test_an_array_takes_the_memory_of_a_freed_one():
    assert faults_of_a_second_array(LARGE) == 0


def test_nothing_changes_for_small_arrays():
    assert faults_of_a_second_array(LARGE - 1) > 0


def test_freed_memory_is_returned_at_the_end():
    with freed_memory_kept(LARGE):
        np.ones(BYTES // 8)
        kept = resident()
    assert resident() < kept - 0.9 * BYTES
