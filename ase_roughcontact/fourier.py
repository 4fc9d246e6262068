"""Fourier transforms of real grids, with plans and buffers made once and reused.

A `RealFFT2` transforms a grid of which only a window of leading rows and columns is
not zero (before the forward transform) or wanted (after the inverse one). The row
transforms of the other rows are skipped: for a grid padded to twice the window in each
direction, that is a quarter of the whole work.

Rows, and then columns, are transformed a few at a time, in buffers that stay in a
processor's cache. A convolution goes forth and back along the same columns: the
spectrum of the padded grid is never there as a whole.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property, partial
from typing import Any

import numpy as np
import pyfftw
from scipy.fft import next_fast_len

from ase_roughcontact.checks import grid_shape, integer
from ase_roughcontact.parallel import available_threads, parts, together
from ase_roughcontact.recycling import empty

try:
    import ducc0
except ImportError:
    ducc0 = None

ENGINES = ("pyfftw", "ducc0")

# Measuring plans is worth a moment, not more (seconds for each transform).
_PLANNING = 1.0
# Numbers in a buffer of rows; columns in a buffer, as many as make up a line of the
# cache, for so many rows of the grid.
_BUFFER = 131072
_LINE = 8
_TALL = 14000


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
        By default ducc0 where it is installed: it needs no planning. Else pyfftw with
        measured plans.
    threads : int, optional
        At most; by default as many as `available_threads` tells. A grid of 256 x 256
        or less takes one.
    measure : bool
        Whether pyfftw may take up to a second to find each of four plans; not worth it
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
        self.threads = available_threads() if threads is None else threads
        integer("threads", self.threads, 1)
        self.measure = bool(measure)
        self.pairs = 0

        (rows, _), (height, width) = self.window, self.grid
        few = _LINE * math.ceil(_TALL / height)
        self._rows = parts(rows, _BUFFER // width)
        self._columns = parts(width // 2 + 1, few)
        make = _PyfftwLines if self.engine == "pyfftw" else _DuccLines
        shape = _longest(self._rows), _longest(self._columns)
        workers = min(self.threads, max(len(self._rows), len(self._columns)))
        self._lines = [make(self, *shape) for _ in range(workers)]

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

    @cached_property
    def spectrum(self) -> np.ndarray:
        """Buffer for `forward` and `inverse`; `filter` does not need it."""
        return self._complex(self.grid[0])

    @cached_property
    def _half(self) -> np.ndarray:
        """Transforms of the rows of the window."""
        return self._complex(self.window[0])

    def forward(self, values: np.ndarray) -> np.ndarray:
        """Transform `values`, shape of the window; return the spectrum's buffer."""
        spectrum = self.spectrum
        self._rows_forward(values, spectrum)

        def forward(lines: _Lines, columns: slice) -> None:
            block = lines.columns[:, : columns.stop - columns.start]
            self._load(block, spectrum[:, columns])
            lines.columns_forward()
            spectrum[:, columns] = block

        self._share(forward, self._columns)
        return spectrum

    def inverse(self) -> np.ndarray:
        """Transform the spectrum back, not normalised; return a new array."""
        spectrum = self.spectrum

        def inverse(lines: _Lines, columns: slice) -> None:
            block = lines.columns[:, : columns.stop - columns.start]
            block[:] = spectrum[:, columns]
            lines.columns_inverse()
            spectrum[: self.window[0], columns] = block[: self.window[0]]

        self._share(inverse, self._columns)
        return self._rows_inverse(spectrum)

    def multiplier(self, values: np.ndarray) -> np.ndarray:
        """Prepare real values on the spectrum for `filter`, norm included.

        Parameters
        ----------
        values : ndarray, shape (N, M//2 + 1), real
            Even in both directions, like the kernel that they belong to; no more than
            the first ``N//2 + 1`` rows are read, or need to be there.

        Returns
        -------
        ndarray, shape (N//2 + 1, M//2 + 1)
        """
        half = values[: self.grid[0] // 2 + 1] * (1.0 / math.prod(self.grid))
        return half.astype(self.dtype, copy=False)

    def filter(
        self,
        values: np.ndarray,
        multiplier: np.ndarray,
        out: np.ndarray | None = None,
    ) -> np.ndarray:
        """Multiply the spectrum of `values`: one forward and one inverse transform.

        Parameters
        ----------
        values : ndarray, shape (n, m)
            On the window.
        multiplier : ndarray
            By `multiplier`.
        out : ndarray, shape (n, m), optional
            Where to put the result, maybe `values` itself.

        Returns
        -------
        ndarray, shape (n, m)

        Raises
        ------
        ValueError
            If `values` or `out` do not have the shape of the window, or `out` is of
            another type than the transform.
        """
        if out is not None and (out.shape, out.dtype) != (self.window, self.dtype):
            raise ValueError(
                f"out must be of the shape {self.window} and the type {self.dtype}, "
                f"got {out.shape} and {out.dtype}"
            )
        self.pairs += 1
        half, height, rows = self._half, self.window[0], len(multiplier)
        mirrored = multiplier[self.grid[0] - rows : 0 : -1]
        self._rows_forward(values, half)

        def filtered(lines: _Lines, columns: slice) -> None:
            block = lines.columns[:, : columns.stop - columns.start]
            self._load(block, half[:, columns])
            lines.columns_forward()
            block[:rows] *= multiplier[:, columns]
            block[rows:] *= mirrored[:, columns]
            lines.columns_inverse()
            half[:, columns] = block[:height]

        self._share(filtered, self._columns)
        return self._rows_inverse(half, out)

    def _complex(self, rows: int) -> np.ndarray:
        complex_type = np.result_type(self.dtype, np.complex64)
        return np.zeros((rows, self.grid[1] // 2 + 1), complex_type)

    def _load(self, block: np.ndarray, half: np.ndarray) -> None:
        """Columns of the window, and of the zeros below it."""
        rows = self.window[0]
        block[:rows] = half[:rows]
        block[rows:] = 0.0

    def _share(self, work: Callable[[_Lines, slice], None], parts: list[slice]) -> None:
        """Do work on parts, each thread with buffers of its own."""
        shared = iter(parts)

        def some(worker: int) -> None:
            for part in shared:
                work(self._lines[worker], part)

        together(some, min(len(self._lines), len(parts)))

    def _rows_forward(self, values: np.ndarray, half: np.ndarray) -> None:
        if values.shape != self.window:
            raise ValueError(f"expected the shape {self.window}, got {values.shape}")
        width = self.window[1]

        def forward(lines: _Lines, rows: slice) -> None:
            count = rows.stop - rows.start
            lines.rows[:count, :width] = values[rows]
            lines.rows[:count, width:] = 0.0
            lines.rows_forward()
            half[rows] = lines.spectra[:count]

        self._share(forward, self._rows)

    def _rows_inverse(
        self, half: np.ndarray, out: np.ndarray | None = None
    ) -> np.ndarray:
        result = empty(self.window, self.dtype) if out is None else out

        def inverse(lines: _Lines, rows: slice) -> None:
            count = rows.stop - rows.start
            lines.spectra[:count] = half[rows]
            lines.rows_inverse()
            result[rows] = lines.rows[:count, : self.window[1]]

        self._share(inverse, self._rows)
        return result


def _longest(some: list[slice]) -> int:
    return max(part.stop - part.start for part in some)


class _Lines:
    """Buffers of a thread for a few rows and a few columns, and their transforms.

    Attributes
    ----------
    rows : ndarray, shape (k, M)
        Rows of the padded grid.
    spectra : ndarray, shape (k, M//2 + 1), complex
        Their transforms.
    columns : ndarray, shape (N, l), complex
        Columns of the spectrum.
    """

    def __init__(self, fft: RealFFT2, rows: int, columns: int) -> None:
        height, width = fft.grid
        complex_type = np.result_type(fft.dtype, np.complex64)
        self.rows = pyfftw.zeros_aligned((rows, width), fft.dtype)
        self.spectra = pyfftw.zeros_aligned((rows, width // 2 + 1), complex_type)
        self.columns = pyfftw.zeros_aligned((height, columns), complex_type)
        self._plan(fft)

    rows_forward: Callable[[], Any]
    rows_inverse: Callable[[], Any]
    columns_forward: Callable[[], Any]
    columns_inverse: Callable[[], Any]

    def _plan(self, fft: RealFFT2) -> None:
        raise NotImplementedError


class _PyfftwLines(_Lines):
    """Transforms by FFTW."""

    def _plan(self, fft: RealFFT2) -> None:
        effort = "FFTW_MEASURE" if fft.measure else "FFTW_ESTIMATE"
        plan = partial(pyfftw.FFTW, planning_timelimit=_PLANNING)
        once = {"axes": (1,), "flags": (effort, "FFTW_DESTROY_INPUT")}
        back = {"direction": "FFTW_BACKWARD"}
        columns = {"axes": (0,), "flags": (effort,)}
        self.rows_forward = plan(self.rows, self.spectra, **once).execute
        self.rows_inverse = plan(self.spectra, self.rows, **once, **back).execute
        both = self.columns, self.columns
        self.columns_forward = plan(*both, **columns).execute
        self.columns_inverse = plan(*both, **columns, **back).execute


class _DuccLines(_Lines):
    """Transforms by ducc0."""

    def _plan(self, fft: RealFFT2) -> None:
        if ducc0 is None:
            raise ImportError(
                "engine 'ducc0' needs the package ducc0: pip install ducc0"
            )
        self.rows_forward = partial(
            ducc0.fft.r2c, self.rows, axes=(1,), out=self.spectra
        )
        self.rows_inverse = partial(
            ducc0.fft.c2r,
            self.spectra,
            axes=(1,),
            lastsize=fft.grid[1],
            forward=False,
            out=self.rows,
        )
        columns = partial(ducc0.fft.c2c, self.columns, axes=(0,), out=self.columns)
        self.columns_forward = columns
        self.columns_inverse = partial(columns, forward=False)
