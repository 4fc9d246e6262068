"""Transforms of windows against numpy's transforms of whole grids."""

import pickle

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from ase_roughcontact.elasticity import fft_backends
from ase_roughcontact.elasticity.fft import ENGINES, Blocking, RealFFT2, fast_length

every_engine = pytest.mark.parametrize("engine", ENGINES)
grids = pytest.mark.parametrize(
    "window, grid",
    [
        ((8, 8), None),
        ((7, 5), None),
        ((1, 9), None),
        ((6, 1), None),
        ((8, 8), (16, 16)),
        ((5, 7), (9, 15)),
        ((3, 4), (3, 11)),
        ((4, 3), (10, 3)),
        ((1, 1), (2, 3)),
    ],
    ids=str,
)


def transform(window, grid=None, engine="pyfftw", **options):
    pytest.importorskip(engine)
    return RealFFT2(window, grid, engine=engine, **options)


CUT = {"whole_grid_bytes": 0}  # also small grids into blocks


def blocks(rows=20, columns=1, height=10):
    """Return a blocking that cuts small grids as large ones are cut."""
    return Blocking(rows, columns, height, **CUT)


def random(shape):
    return np.random.default_rng(7).standard_normal(shape)


@every_engine
@grids
@pytest.mark.parametrize("cut", [False, True], ids=["whole", "blocks"])
def test_transforms_and_filter_of_a_window_padded_with_zeros(window, grid, engine, cut):
    options = {"threads": 3, "blocking": blocks()} if cut else {}
    fft, shape = transform(window, grid, engine, **options), grid or window
    inside = slice(window[0]), slice(window[1])
    # a kernel that is even in both directions, and so is its spectrum
    i, j = (2 * np.pi * k / n for k, n in zip(np.indices(shape), shape, strict=True))
    kernel = np.cos(i) * (2.0 + np.cos(j)) + 3.0 * np.cos(2 * i) + (i + j == 0)
    factor = np.fft.rfft2(kernel).real
    multiplier = fft.multiplier(factor)
    for scale in (1.0, -2.0):  # nothing is left over from the first
        values = scale * random(window)
        spectrum = np.fft.rfft2(values, shape)
        assert_allclose(fft.forward(values), spectrum, atol=1e-13)
        expected = np.fft.irfft2(spectrum * factor, shape)[inside]
        assert_allclose(fft.filter(values, multiplier), expected, atol=1e-12)
        fft.spectrum[:] = np.fft.rfft2(random(shape))
        assert_allclose(
            fft.inverse() / np.prod(shape), random(shape)[inside], atol=1e-13
        )
    assert fft.filter(values, multiplier, values) is values


@every_engine
def test_filter_leaves_its_arguments_alone_and_returns_a_new_array(engine):
    fft = transform((5, 6), (9, 12), engine)
    values, multiplier = random((5, 6)), fft.multiplier(np.ones((9, 7)))
    before = values.copy(), multiplier.copy()
    first = fft.filter(values, multiplier)
    kept = first.copy()
    fft.filter(2 * values, multiplier)
    assert fft.pairs == 2
    assert_array_equal(first, kept)
    assert_array_equal(values, before[0])
    assert_array_equal(multiplier, before[1])


@pytest.fixture
def three_threads():
    """Threads of ducc0, which it takes from the environment otherwise."""
    misc = getattr(fft_backends.ducc0, "misc", None)
    if not hasattr(misc, "resize_thread_pool"):  # an older version
        yield
        return
    before = misc.thread_pool_size()
    misc.resize_thread_pool(3)
    yield
    misc.resize_thread_pool(before)


@every_engine
@pytest.mark.usefixtures("three_threads")
@pytest.mark.parametrize("dtype", ["float32", "float64"])
@pytest.mark.parametrize("blocking", [Blocking(**CUT), Blocking()], ids=["cut", ""])
@pytest.mark.parametrize("window", [(257, 255), (300, 301), (420, 430), (1011, 1009)])
def test_results_do_not_depend_on_the_number_of_threads(
    window, blocking, dtype, engine
):
    values, results = random(window), []
    for count in (1, 2, 3):
        options = {"dtype": dtype, "threads": count, "blocking": blocking}
        fft = transform(window, engine=engine, **options)
        factors = fft.multiplier(random((window[0], window[1] // 2 + 1)))
        results.append(fft.filter(values, factors))
    assert_array_equal(results[1], results[0])
    assert_array_equal(results[2], results[0])


@every_engine
def test_a_pickled_transform_is_the_same(engine):
    fft = transform((5, 6), (9, 12), engine, threads=2, dtype="float32")
    copy = pickle.loads(pickle.dumps(fft))
    for name in ("window", "grid", "engine", "dtype", "threads", "blocking"):
        assert getattr(copy, name) == getattr(fft, name)
    values, one = random((5, 6)), fft.multiplier(np.ones((9, 7)))
    assert_array_equal(copy.filter(values, one), fft.filter(values, one))


@every_engine
@pytest.mark.parametrize("cut", [False, True], ids=["whole", "blocks"])
@pytest.mark.parametrize("shape", [(5, 7), (9, 15), (3, 4)])
@pytest.mark.parametrize("imaginary", [False, True])
def test_fields_are_multiplied_by_a_matrix_for_each_wave(engine, cut, shape, imaginary):
    options = {"threads": 3, "blocking": blocks()} if cut else {}
    fft, rng = transform((5, 7), (9, 15), engine, **options), np.random.default_rng(3)
    fields = rng.normal(size=(2, 5, 7))
    kernels = np.fft.rfft2(rng.normal(size=(3, 2, 9, 15)))
    matrix = kernels.imag if imaginary else kernels.real
    spectra = np.fft.rfft2(fields, (9, 15))
    products = np.einsum("lknm,knm->lnm", matrix * (1j if imaginary else 1.0), spectra)
    expected = np.fft.irfft2(products, (9, 15))[:, : shape[0], : shape[1]]
    found = fft.filter_fields(fields, matrix, shape, imaginary=imaginary)
    assert_allclose(found, expected, atol=1e-12)
    assert fft.pairs == 3


@every_engine
def test_single_precision_stays_single(engine):
    fft = transform((6, 6), (11, 12), engine, dtype=np.float32)
    values = random((6, 6))
    same = fft.filter(values, fft.multiplier(np.ones((11, 7))))
    assert same.dtype == np.float32
    assert fft.spectrum.dtype == np.complex64
    assert_allclose(same, values, atol=1e-6)


def test_small_grids_are_transformed_by_pyfftw_by_default():
    pytest.importorskip("ducc0")
    small, large = RealFFT2((32, 32), (64, 64)), RealFFT2((32, 40), (64, 80))
    assert (small.engine, large.engine) == ("pyfftw", "ducc0")


@pytest.mark.parametrize("least", [1, 2, 7, 127, 255, 1021, 4095])
def test_fast_length_is_no_shorter_and_has_small_prime_factors(least):
    length = rest = fast_length(least)
    assert least <= length < 1.3 * least + 1
    for prime in (2, 3, 5, 7, 11):
        while rest % prime == 0:
            rest //= prime
    assert rest == 1


@pytest.mark.parametrize("out", [np.zeros((5, 5)), np.zeros((5, 6), np.float32)])
def test_array_for_a_result_that_does_not_fit_is_refused(out):
    fft = transform((5, 6))
    with pytest.raises(ValueError, match=r"\(5, 6\)"):
        fft.filter(random((5, 6)), fft.multiplier(np.ones((5, 4))), out)


@pytest.mark.parametrize(
    "options, message",
    [
        ({"grid": (8, 3)}, r"\(4, 4\) .* \(8, 3\)"),
        ({"engine": "fftpack"}, "unknown engine 'fftpack'.*pyfftw.*ducc0"),
        ({"dtype": "foo"}, "float32 or float64"),
        ({"dtype": 3.5}, "float32 or float64"),
    ],
)
def test_options_that_do_not_exist_are_refused(options, message):
    with pytest.raises(ValueError, match=message):
        RealFFT2((4, 4), **options)


def test_engine_that_is_not_installed_says_how_to_install_it(monkeypatch):
    monkeypatch.setattr(fft_backends, "ducc0", None)
    with pytest.raises(ImportError, match="pip install ducc0"):
        RealFFT2((4, 4), engine="ducc0")
