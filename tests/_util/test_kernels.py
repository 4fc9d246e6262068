"""Operations on blocks of rows against operations of NumPy on whole arrays."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from ase_roughcontact._util import kernels
from ase_roughcontact._util.kernels import (
    array_equal,
    dot,
    dots,
    inner,
    linear_combination,
    max_abs,
    norm,
    rowwise,
    scale,
    subtract_and_dot,
    total,
)
from ase_roughcontact._util.threads import threads


@pytest.fixture(params=[1, 2, 3], autouse=True)
def count(request, monkeypatch):
    monkeypatch.setattr(kernels, "BLOCK_SIZE", 16)
    with threads(request.param):
        yield request.param


def random(*shape):
    return np.random.default_rng(3).standard_normal(shape)


@pytest.mark.parametrize("shape", [(1000,), (37, 5), (2, 100), (0, 3)])
def test_a_function_sees_every_row_once(shape):
    @rowwise(np.add)
    def increment(a):
        a += 1.0
        return len(a)

    values = random(*shape)
    done = values.copy()
    assert increment(done) == shape[0]
    assert_array_equal(done, values + 1.0)


def test_arrays_in_lists_are_split_and_other_arguments_are_not():
    @rowwise(np.add)
    def products(pairs, label, numbers):
        assert (label, numbers) == ("label", [1, 2])
        return tuple(float((x * y).sum()) for x, y in pairs)

    a, b = random(40, 5), random(40, 5) + 1.0
    found = products([(a, b), (b, b)], "label", [1, 2])
    assert_allclose(found, [(a * b).sum(), (b * b).sum()], rtol=1e-13)


@pytest.mark.parametrize("shape", [(1000,), (37, 5)])
def test_sums_do_not_depend_on_the_number_of_threads(shape, count):
    a, b = random(*shape), random(*shape) + 1.0
    product, summed = dot(a, b), total(a)
    with threads(1):
        assert (product, summed) == (dot(a, b), total(a))
    assert_allclose(product, np.vdot(a, b), rtol=1e-13)
    assert_allclose(summed, a.sum(), rtol=1e-13)
    assert norm(a) == pytest.approx(np.linalg.norm(a), rel=1e-14)


def test_scalar_products_of_strided_arrays():
    a, b = random(40, 9)[:, 2:7], random(40, 9)[:, 1:6]
    assert_allclose(dots([(a, b), (b, b)]), [(a * b).sum(), (b * b).sum()], rtol=1e-13)


@pytest.mark.parametrize("size", [8192, 20_000])
def test_scalar_product_of_long_vectors(size):
    a, b = random(2, size)
    assert_allclose(inner(a, b), np.vdot(a, b), rtol=1e-11)


@pytest.mark.parametrize(("first", "second"), [(2.0, -3.0), (1.0, -3.0), (1.0, 1.0)])
def test_linear_combination(first, second):
    a, b, c = random(37, 5), random(37, 5) + 1.0, random(37, 5) - 1.0
    expected = first * a + second * b + 0.5 * c
    terms = [(first, a), (second, b), (0.5, c)]
    assert_allclose(linear_combination(terms), expected, rtol=1e-13, atol=1e-15)
    assert linear_combination(terms, out=a) is a
    assert_allclose(a, expected, rtol=1e-13, atol=1e-15)
    single = [(2.0, np.ones((37, 5), np.float32))]
    assert linear_combination(single).dtype == np.float32


def test_scale_rounds_to_the_precision_of_the_result():
    a, out = random(37, 5), np.empty((37, 5), np.float32)
    scale(out, a, 3.0)
    assert_array_equal(out, (3.0 * a).astype(np.float32))


def test_subtract_and_dot_may_return_the_new_square():
    a, b = random(37, 5), random(37, 5) + 1.0
    expected = a - 2.0 * b
    product = subtract_and_dot(a, 2.0, b, a)
    assert_allclose(a, expected, rtol=1e-14)
    assert product == pytest.approx((expected**2).sum(), rel=1e-13)


@pytest.mark.parametrize("row", [0, 36])
def test_max_abs_is_nan_if_an_entry_is(row):
    values = random(37, 5)
    values[3, 3] = -9.0
    assert max_abs(values) == 9.0
    values[row, 1] = np.nan
    assert np.isnan(max_abs(values))


def test_arrays_are_equal_if_shape_and_entries_are():
    a = random(37, 5)
    b = a.copy()
    assert array_equal(a, b) and not array_equal(a, b[:36])
    b[36, 4] += 1e-15
    assert not array_equal(a, b)
