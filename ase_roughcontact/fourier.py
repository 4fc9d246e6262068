"""Fourier transforms of real grids, with plans and buffers made once and reused.

A `RealFFT2` transforms a grid of which only a window of leading rows and columns is
not zero (before the forward transform) or wanted (after the inverse one). The row
transforms of the other rows are skipped: for a grid padded to twice the window in each
direction, that is a quarter of the whole work.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import partial

import numpy as np
import pyfftw
from scipy.fft import next_fast_len

from ase_roughcontact.checks import grid_shape, integer

try:
    import ducc0
except ImportError:
    ducc0 = None

ENGINES = ("pyfftw", "ducc0")

# Measuring plans is worth a moment, not more (seconds for each transform).
_PLANNING = 1.0

_THREADS: ContextVar[int] = ContextVar("threads", default=0)


def processors() -> int:
    """Processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def available_threads() -> int:
    """Threads to use: those of `threads`, ``OMP_NUM_THREADS``, or all processors."""
    wanted = os.environ.get("OMP_NUM_THREADS", "")
    usual = int(wanted) if wanted.isdigit() and int(wanted) > 0 else processors()
    return _THREADS.get() or usual


@contextmanager
def threads(count: int) -> Iterator[None]:
    """Choose the number of `available_threads` for what this thread makes meanwhile."""
    before = _THREADS.set(integer("threads", count, 1))
    try:
        yield
    finally:
        _THREADS.reset(before)


def fast_length(least: int) -> int:
    """Smallest length from `least` on whose real transform is fast."""
    return int(next_fast_len(least, real=True))


def _float_type(dtype: object) -> np.dtype:
    """Return one of two precisions, or raise `ValueError`."""
    try:
        known = np.dtype(dtype)  # type: ignore[call-overload]
    except TypeError:
        known = None
    if known not in (np.float32, np.float64):
        raise ValueError(f"dtype must be float32 or float64, got {dtype!r}")
    return known


class RealFFT2:
    """Two-dimensional real transform between a window and the spectrum of its grid.

    Parameters
    ----------
    window : (int, int)
        Shape ``(n, m)`` of the part of the grid that carries data.
    grid : (int, int), optional
        Shape ``(N, M)`` of the grid, zero outside of the window; by default `window`.
    dtype : dtype
        ``float64``, or ``float32`` for half the buffers' memory and, on grids of 200,
        540 and 1080, 0.80, 0.70 and 0.59 of the time of a pair. In a relaxation that
        saves nothing (0.96 to 0.99 of the time, 0.83 of the memory), and contacts of
        100 atoms' radius did not converge to a relative tolerance of 1e-4, nor one
        with a hard wall to any.
    engine : {"pyfftw", "ducc0"}, optional
        By default ducc0 where it is installed: it needs no planning, and its threads
        do not wait for each other on a busy machine. Else pyfftw with measured plans.
    threads : int, optional
        By default one for pyfftw and for grids below 256 x 256, else as many as
        `available_threads` tells.
    measure : bool
        Whether pyfftw may take up to a second to find the fastest plan; not worth it
        for a few transforms only.

    Raises
    ------
    ValueError
        If the window is larger than the grid, or an option is not what it should be.

    Attributes
    ----------
    spectrum : ndarray, shape (N, M//2 + 1), complex
        What `forward` wrote and what `inverse` reads (and destroys).
    pairs : int
        Number of pairs of transforms: those of `filter`, and those that a caller of
        `forward` and `inverse` adds.
    """

    def __init__(
        self,
        window: tuple[int, int],
        grid: tuple[int, int] | None = None,
        *,
        dtype: type | str = np.float64,
        engine: str | None = None,
        threads: int | None = None,
        measure: bool = True,
    ) -> None:
        self.window = grid_shape(window)
        self.grid = self.window if grid is None else grid_shape(grid)
        if any(n > big for n, big in zip(self.window, self.grid, strict=True)):
            raise ValueError(f"window {window} does not fit into grid {self.grid}")
        fastest = "pyfftw" if ducc0 is None else "ducc0"
        self.engine = fastest if engine is None else engine
        if self.engine not in ENGINES:
            raise ValueError(f"engine must be one of {ENGINES}, got {engine!r}")
        self.dtype = _float_type(dtype)
        self.threads = self._threads() if threads is None else threads
        integer("threads", self.threads, 1)
        self.measure = bool(measure)
        self.pairs = 0

        rows, (height, width) = self.window[0], self.grid
        complex_type = np.result_type(self.dtype, np.complex64)
        self._real = pyfftw.zeros_aligned((rows, width), self.dtype)
        self.spectrum = pyfftw.zeros_aligned((height, width // 2 + 1), complex_type)
        self._plan_pyfftw() if self.engine == "pyfftw" else self._plan_ducc()

    def __reduce__(self) -> tuple:
        """Plans can't be pickled: make them anew."""
        make = partial(
            RealFFT2,
            dtype=self.dtype.type,
            engine=self.engine,
            threads=self.threads,
            measure=self.measure,
        )
        return make, (self.window, self.grid)

    def forward(self, values: np.ndarray) -> np.ndarray:
        """Transform `values`, shape of the window; return the spectrum's buffer."""
        if values.shape != self.window:
            raise ValueError(f"expected the shape {self.window}, got {values.shape}")
        columns = self.window[1]
        self._real[:, :columns] = values
        self._real[:, columns:] = 0.0
        self._rows_forward()
        self.spectrum[self.window[0] :] = 0.0
        self._columns_forward()
        return self.spectrum

    def inverse(self) -> np.ndarray:
        """Transform the spectrum back, not normalised; return a new array."""
        self._columns_inverse()
        self._rows_inverse()
        return self._real[:, : self.window[1]].copy()

    def multiplier(self, values: np.ndarray) -> np.ndarray:
        """Prepare real values on the spectrum for `filter`, norm included.

        Parameters
        ----------
        values : ndarray, shape (N, M//2 + 1), real
            Even in both directions, like the kernel that they belong to; no more than
            the first ``N//2 + 1`` rows are read, or need to be there.

        Returns
        -------
        ndarray, shape (N//2 + 1, 2 (M//2 + 1))
            Each value twice: the product with a complex array is then one pass over
            real numbers.
        """
        half = values[: self.grid[0] // 2 + 1] * (1.0 / math.prod(self.grid))
        twice = np.empty((*half.shape, 2), self.dtype)
        twice[..., 0] = half
        twice[..., 1] = half
        return twice.reshape(len(twice), -1)

    def filter(self, values: np.ndarray, multiplier: np.ndarray) -> np.ndarray:
        """Multiply the spectrum of `values`: one forward and one inverse transform."""
        self.pairs += 1
        flat = self.forward(values).view(self.dtype)
        rows = len(multiplier)
        flat[:rows] *= multiplier
        flat[rows:] *= multiplier[len(flat) - rows : 0 : -1]
        return self.inverse()

    def _threads(self) -> int:
        # FFTW's threads spin: on busy processors two are slower than one, up to 400 x
        small = self.grid[0] * self.grid[1] < 256 * 256
        return 1 if small or self.engine == "pyfftw" else available_threads()

    def _plan_pyfftw(self) -> None:
        rows = self.spectrum[: self.window[0]]
        plan = partial(pyfftw.FFTW, threads=self.threads, planning_timelimit=_PLANNING)
        effort = "FFTW_MEASURE" if self.measure else "FFTW_ESTIMATE"
        once = (effort, "FFTW_DESTROY_INPUT")
        back = {"direction": "FFTW_BACKWARD"}
        self._rows_forward = plan(self._real, rows, axes=(1,), flags=once).execute
        self._rows_inverse = plan(
            rows, self._real, axes=(1,), flags=once, **back
        ).execute
        columns = partial(
            plan, self.spectrum, self.spectrum, axes=(0,), flags=(effort,)
        )
        self._columns_forward = columns().execute
        self._columns_inverse = columns(**back).execute

    def _plan_ducc(self) -> None:
        if ducc0 is None:
            raise ImportError(
                "engine 'ducc0' needs the package ducc0: pip install ducc0"
            )
        rows = self.spectrum[: self.window[0]]
        back = {"forward": False, "nthreads": self.threads}
        self._rows_forward = partial(
            ducc0.fft.r2c, self._real, axes=(1,), out=rows, nthreads=self.threads
        )
        self._rows_inverse = partial(
            ducc0.fft.c2r,
            rows,
            axes=(1,),
            lastsize=self.grid[1],
            out=self._real,
            **back,
        )
        columns = partial(ducc0.fft.c2c, self.spectrum, axes=(0,), out=self.spectrum)
        self._columns_forward = partial(columns, nthreads=self.threads)
        self._columns_inverse = partial(columns, **back)
