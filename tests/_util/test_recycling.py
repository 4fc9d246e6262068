"""Arrays in memory that is used again."""

import gc

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from ase_roughcontact._util import recycling
from ase_roughcontact._util.recycling import empty, recycled, zeros

LARGE = (600, 500)


@pytest.fixture(autouse=True)
def recycling_goes_on():
    with recycled():
        yield
    assert not recycling._SPARE


def address(array):
    return array.__array_interface__["data"][0]


def test_memory_of_an_array_that_is_gone_is_used_again():
    first = empty(LARGE)
    there = address(first)
    del first
    again = zeros(LARGE)
    assert address(again) == there
    assert again.shape == LARGE
    assert again.dtype == float
    assert_array_equal(again, 0.0)


def test_memory_is_not_used_again_while_a_view_of_it_is_left():
    first = zeros(LARGE, np.float32)
    part = first[10:20].T[3]
    del first
    gc.collect()
    other = empty(LARGE, np.float32)
    other[:] = 1.0
    assert_array_equal(part, 0.0)
    assert not np.shares_memory(part, other)


def test_arrays_of_one_size_share_memory_whatever_they_hold():
    first = empty(LARGE)
    there = address(first)
    del first
    flat = empty(2 * LARGE[0] * LARGE[1], np.float32)
    assert address(flat) == there
    assert flat.ndim == 1


def test_small_arrays_are_left_to_numpy():
    assert empty((3, 4), bool).base is None
    assert zeros(5).tolist() == [0.0] * 5
    assert not recycling._SPARE


def test_memory_is_kept_until_the_last_who_recycles_ends():
    with recycled():
        kept = empty(LARGE)
        gone = empty(LARGE)
        del gone
    assert len(recycling._SPARE[kept.nbytes]) == 1


def test_memory_goes_back_to_the_system_when_nobody_recycles(monkeypatch):
    monkeypatch.setattr(recycling, "_USERS", [])
    with recycled():
        kept, gone = empty(LARGE), empty(LARGE)
        del gone
    assert not recycling._SPARE
    del kept
    assert not recycling._SPARE
    assert empty(LARGE).base is None


def test_sizes_that_are_not_asked_for_any_more_are_not_kept():
    for rows in range(400, 420):
        empty((rows, 500))
    assert len(recycling._SPARE) == recycling._SIZES
    assert 419 * 500 * 8 in recycling._SPARE
    assert 400 * 500 * 8 not in recycling._SPARE
