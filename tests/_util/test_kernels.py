"""Arithmetic in parts and in threads against numpy's own."""

import os
import threading
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from ase_roughcontact._util import kernels as parallel
from ase_roughcontact._util.kernels import (
    available_threads,
    by_rows,
    combined,
    dot,
    largest,
    parts,
    processors,
    same,
    threads,
    together,
)


@pytest.fixture(params=[1, 2, 3])
def count(request):
    with threads(request.param):
        yield request.param


@pytest.fixture
def small_parts(monkeypatch):
    monkeypatch.setattr(parallel, "_PART", 16)


def random(*shape):
    return np.random.default_rng(3).standard_normal(shape)


@pytest.mark.parametrize("length, most", [(1, 5), (5, 5), (6, 5), (97, 10), (3, 0)])
def test_parts_cover_a_length_once_and_in_order(length, most):
    found = parts(length, most)
    indices = np.concatenate([np.arange(length)[part] for part in found])
    assert_array_equal(indices, np.arange(length))
    assert all(part.stop - part.start <= max(most, 1) for part in found)
    assert len(found) == 1 or len(found) > length / (max(most, 1) + 1)


def test_work_is_done_by_all_threads_and_its_results_keep_their_order(count):
    met = threading.Barrier(count)  # broken unless all are there at the same time

    def work(k):
        met.wait(timeout=30)
        return k

    assert together(work, count) == list(range(count))


def test_work_within_work_is_done_without_other_threads():
    def work(k):
        return together(lambda _: threading.get_ident(), 3)

    for found in together(work, 2):
        assert len(set(found)) == 1


def test_work_sees_the_settings_of_numpy(count):
    with np.errstate(over="raise", under="call"):
        here = np.geterr()
        assert together(lambda _: np.geterr(), count) == count * [here]


def test_an_interrupt_waits_for_the_work_of_others():
    begun, done = threading.Event(), threading.Event()

    def work(k):
        if k == 0:
            begun.wait(timeout=30)
            raise KeyboardInterrupt
        begun.set()
        time.sleep(0.1)
        done.set()

    with pytest.raises(KeyboardInterrupt):
        together(work, 2)
    assert done.is_set()


def test_work_whose_thread_can_not_begin_is_done_once(monkeypatch):
    done = []

    class Full(ThreadPoolExecutor):
        """Queues a task, then finds that there is no thread for it."""

        def submit(self, *arguments):
            queued.append(arguments)
            raise RuntimeError("can't start new thread")

    queued = []
    monkeypatch.setattr(parallel, "_POOL", Full())
    assert together(lambda k: done.append(k) or k, 3) == [0, 1, 2]
    for work, *arguments in queued:  # a thread comes free
        work(*arguments)
    assert done == [0, 1, 2]


def test_where_no_thread_begins_any_more_the_work_is_done_in_one(monkeypatch):
    pool = ThreadPoolExecutor(2)
    pool.shutdown()
    monkeypatch.setattr(parallel, "_POOL", pool)
    assert together(lambda k: k, 3) == [0, 1, 2]


def test_an_error_of_any_thread_is_raised(count):
    def work(k):
        if k == count - 1:
            raise ZeroDivisionError("of the last thread")
        return k

    with pytest.raises(ZeroDivisionError, match="of the last thread"):
        together(work, count)
    assert together(lambda k: k, count) == list(range(count))


@pytest.mark.parametrize("shape", [(1000,), (37, 5), (2, 100), (0, 3)])
def test_every_row_is_worked_on_once(small_parts, count, shape):
    values = random(*shape)
    done = values.copy()

    def work(rows):
        done[rows] += 1.0
        return len(done[rows])

    assert sum(by_rows(work, shape)) == shape[0]
    assert_array_equal(done, values + 1.0)


@pytest.mark.parametrize("shape", [(1000,), (37, 5)])
def test_scalar_product(small_parts, shape):
    a, b = random(*shape), random(*shape) + 1.0
    results = set()
    for count in (1, 2, 3):
        with threads(count):
            results.add(dot(a, b))
    (result,) = results  # to the last digit
    assert_allclose(result, np.vdot(a, b), rtol=1e-13)


def test_scalar_product_of_parts_of_arrays(small_parts):
    a, b = random(40, 9)[:, 2:7], random(40, 9)[:, 1:6]
    assert_allclose(dot(a, b), (a * b).sum(), rtol=1e-13)


def test_combination(small_parts, count):
    a, b, c = random(37, 5), random(37, 5) + 1.0, random(37, 5) - 1.0
    expected = 2.0 * a - 3.0 * b + 0.5 * c
    terms = [(2.0, a), (-3.0, b), (0.5, c)]
    assert_allclose(combined(terms), expected, rtol=1e-13, atol=1e-15)
    assert combined(terms, out=b) is b
    assert_allclose(b, expected, rtol=1e-13, atol=1e-15)


@pytest.mark.parametrize("row", [0, 36])
def test_largest_magnitude_tells_of_a_number_that_is_none(small_parts, count, row):
    values = random(37, 5)
    values[3, 3] = -9.0
    assert largest(values) == 9.0
    values[row, 1] = np.nan
    assert np.isnan(largest(values))


def test_arrays_are_the_same_if_shape_and_entries_are(small_parts, count):
    a = random(37, 5)
    assert same(a, a.copy())
    assert not same(a, a[:36])
    b = a.copy()
    b[36, 4] += 1e-15
    assert not same(a, b)


def test_combination_keeps_single_precision():
    assert combined([(2.0, np.ones(4, np.float32))]).dtype == np.float32


def _forked(count):
    return together(lambda k: os.getpid(), count)


@pytest.mark.filterwarnings("ignore:.*multi-threaded.*:DeprecationWarning")
@pytest.mark.skipif(not hasattr(os, "fork"), reason="no processes are forked here")
def test_threads_work_in_a_process_that_was_forked_after_they_were_used():
    together(lambda k: k, 2)
    with ProcessPoolExecutor(1, mp_context=get_context("fork")) as pool:
        found = pool.submit(_forked, 2).result(timeout=30)
    assert len(set(found)) == 1
    assert found[0] != os.getpid()


def test_number_of_threads_follows_the_environment(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    assert available_threads() == 3
    for value in ("", "many", "0"):
        monkeypatch.setenv("OMP_NUM_THREADS", value)
        assert available_threads() == processors() >= 1


def test_threads_can_be_chosen_for_a_while_in_one_thread_only(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    with threads(2), ThreadPoolExecutor(1) as pool:
        with threads(7):
            assert available_threads() == 7
        assert available_threads() == 2
        assert pool.submit(available_threads).result() == 3
    assert available_threads() == 3


def test_number_of_threads_must_be_positive():
    with pytest.raises(ValueError, match="threads must be an integer >= 1"), threads(0):
        pass
