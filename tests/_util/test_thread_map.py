"""Functions mapped over items by several threads."""

import os
import threading
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from ase_roughcontact._util.threads import (
    available_threads,
    processors,
    split,
    thread_map,
    threads,
)

several = pytest.mark.parametrize("count", [1, 2, 3])


@pytest.mark.parametrize("length, longest", [(1, 5), (5, 5), (6, 5), (97, 10), (3, 0)])
def test_pieces_cover_a_length_once_and_in_order(length, longest):
    pieces = split(length, longest)
    indices = np.concatenate([np.arange(length)[piece] for piece in pieces])
    assert_array_equal(indices, np.arange(length))
    assert all(piece.stop - piece.start <= max(longest, 1) for piece in pieces)
    assert len(pieces) == 1 or len(pieces) > length / (max(longest, 1) + 1)


@several
def test_all_threads_work_at_the_same_time_and_results_keep_their_order(count):
    barrier = threading.Barrier(count)  # raises unless all threads reach it

    def wait_for_others(item):
        barrier.wait(timeout=30)
        return item

    assert thread_map(wait_for_others, list(range(count)), count) == list(range(count))


def test_a_map_within_a_map_uses_one_thread():
    def identify(_):
        return thread_map(wait, [1, 2, 3], 3)

    def wait(_):
        time.sleep(0.01)  # other threads would begin
        return threading.get_ident()

    for identities in thread_map(identify, [1, 2], 2):
        assert len(set(identities)) == 1


@several
def test_error_handling_of_numpy_holds_in_all_threads(count):
    with np.errstate(over="raise", under="call"):
        settings = np.geterr()
        assert thread_map(lambda _: np.geterr(), [0] * count, count) == count * [
            settings
        ]


def test_an_interrupt_waits_for_other_threads():
    begun, done = threading.Event(), threading.Event()
    caller = threading.get_ident()

    def work(_):
        if threading.get_ident() == caller:
            begun.wait(timeout=30)
            raise KeyboardInterrupt
        begun.set()
        time.sleep(0.1)
        done.set()

    with pytest.raises(KeyboardInterrupt):
        thread_map(work, [1, 2], 2)
    assert done.is_set()


def test_no_item_is_begun_after_an_error():
    begun = []

    def fail(item):
        begun.append(item)
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        thread_map(fail, list(range(100)), 2)
    assert len(begun) <= 2


@several
def test_an_error_in_any_thread_is_raised(count):
    barrier = threading.Barrier(count)

    def fail_in_last(item):
        barrier.wait(timeout=30)
        if item == count - 1:
            raise ZeroDivisionError("of the last item")

    with pytest.raises(ZeroDivisionError, match="of the last item"):
        thread_map(fail_in_last, list(range(count)), count)
    assert thread_map(abs, list(range(count)), count) == list(range(count))


def test_items_are_done_once_if_no_thread_can_be_started(monkeypatch):
    queued, done = [], []

    def full(_, *arguments):
        """Queue a task, then find that there is no thread for it."""
        queued.append(arguments)
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(ThreadPoolExecutor, "submit", full)
    assert thread_map(lambda k: done.append(k) or k, [0, 1, 2], 3) == [0, 1, 2]
    for work, *arguments in queued:  # a thread becomes available later
        work(*arguments)
    assert done == [0, 1, 2]


def process_ids(count):
    return thread_map(lambda _: os.getpid(), [0] * count, count)


@pytest.mark.filterwarnings("ignore:.*multi-threaded.*:DeprecationWarning")
@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs os.fork")
def test_threads_work_in_a_process_forked_after_they_were_used():
    thread_map(abs, [1, 2], 2)
    with ProcessPoolExecutor(1, mp_context=get_context("fork")) as pool:
        found = pool.submit(process_ids, 2).result(timeout=30)
    assert len(set(found)) == 1
    assert found[0] != os.getpid()


def test_number_of_threads_follows_the_environment(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    assert available_threads() == 3
    monkeypatch.setenv("OMP_NUM_THREADS", "4,2")  # of nested levels: the outer one
    assert available_threads() == 4
    for value in ("", "many", "0", ",2", "²"):
        monkeypatch.setenv("OMP_NUM_THREADS", value)
        assert available_threads() == processors() >= 1


def test_threads_are_set_for_one_thread_only_and_reset(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    with threads(2), ThreadPoolExecutor(1) as pool:
        with threads(7):
            assert available_threads() == 7
        assert available_threads() == 2
        assert pool.submit(available_threads).result() == 3
    assert available_threads() == 3


def test_number_of_threads_must_be_positive():
    message = "threads must be an integer >= 1, got 0"
    with pytest.raises(ValueError, match=message), threads(0):
        pass
