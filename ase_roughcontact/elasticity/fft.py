"""Fourier transforms of real grids, with plans and buffers made once and reused.

A `RealFFT2` transforms a grid of which only a window of leading rows and columns is
not zero (before the forward transform) or wanted (after the inverse one). The row
transforms of the other rows are skipped: for a grid padded to twice the window in each
direction, that is a quarter of the whole work.

Of large grids rows, and then columns, are transformed a few at a time, in buffers that
stay in a processor's cache. A convolution goes forth and back along the same columns:
the spectrum of the padded grid is never there as a whole.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property, partial

import numpy as np
from scipy.fft import next_fast_len

from ase_roughcontact._util.kernels import available_threads, parts, together
from ase_roughcontact._util.validation import grid_shape, integer
from ase_roughcontact.elasticity import fft_backends
from ase_roughcontact.elasticity.fft_backends import DuccLines, Lines, PyfftwLines

ENGINES = {"pyfftw": PyfftwLines, "ducc0": DuccLines}

# Numbers in a buffer of rows; columns in a buffer, as many as make up a line of the
# cache, for so many rows of the grid.
_BUFFER = 131072
_LINE = 8
_TALL = 14000
# Bytes of a grid below which the threads of ducc0 share it better than ours, and
# points of a grid below which one thread is best.
_SMALL = 8 << 20
_TINY = 256 * 256


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
        540 and 1080, 0.81, 0.71 and 0.62 of the time of a pair. In a relaxation that
        saves nothing (0.98 to 1.00 of the time, 0.8 of the memory), and contacts of
        100 atoms' radius did not converge to a relative tolerance of 1e-4, nor one
        with a hard wall to any.
    engine : {"pyfftw", "ducc0"}, optional
        By default ducc0 where it is installed: it needs no planning. Else pyfftw with
        measured plans.
    threads : int, optional
        At most; by default as many as `available_threads` tells. A grid smaller than
        256 x 256 takes one.
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
        What `forward` wrote and what `inverse` reads (and destroys, as `filter` may).
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
        fastest = "pyfftw" if fft_backends.ducc0 is None else "ducc0"
        self.engine = fastest if engine is None else engine
        if self.engine not in ENGINES:
            known = tuple(ENGINES)
            raise ValueError(f"engine must be one of {known}, got {engine!r}")
        self.dtype = _float_type(dtype)
        self.threads = available_threads() if threads is None else threads
        integer("threads", self.threads, 1)
        self.measure = bool(measure)
        self.pairs = 0

        self._rows, self._columns = self._cut()
        self._whole = len(self._columns) == 1
        workers = min(self.threads, max(len(self._rows), len(self._columns)))
        alone = workers == 1 and math.prod(self.grid) >= _TINY
        make = partial(
            ENGINES[self.engine],
            self.grid,
            _longest(self._rows),
            _longest(self._columns),
            dtype=self.dtype,
            threads=self.threads if alone else 1,
            measure=self.measure,
        )
        self._lines: list[Lines] = [make() for _ in range(workers)]

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

        def forward(lines: Lines, columns: slice) -> None:
            block = lines.columns[:, : columns.stop - columns.start]
            self._load(block, spectrum[: self.window[0], columns])
            lines.columns_forward()
            self._store(block, spectrum[:, columns])

        self._share(forward, self._columns)
        return spectrum

    def inverse(self) -> np.ndarray:
        """Transform the spectrum back, not normalised; return a new array."""
        spectrum = self.spectrum

        def inverse(lines: Lines, columns: slice) -> None:
            block = lines.columns[:, : columns.stop - columns.start]
            self._load(block, spectrum[:, columns])
            lines.columns_inverse()
            self._store(block, spectrum[: self.window[0], columns])

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
        half, rows = self._half, len(multiplier)
        mirrored = multiplier[self.grid[0] - rows : 0 : -1]
        self._rows_forward(values, half)

        def filtered(lines: Lines, columns: slice) -> None:
            block = lines.columns[:, : columns.stop - columns.start]
            self._load(block, half[:, columns])
            lines.columns_forward()
            block[:rows] *= multiplier[:, columns]
            block[rows:] *= mirrored[:, columns]
            lines.columns_inverse()
            self._store(block, half[:, columns])

        self._share(filtered, self._columns)
        return self._rows_inverse(half, out)

    def _cut(self) -> tuple[list[slice], list[slice]]:
        """Parts of the window's rows, and of the columns of the spectrum."""
        rows, (height, width) = self.window[0], self.grid
        columns, points = width // 2 + 1, height * width
        small = self.engine == "ducc0" and points * self.dtype.itemsize < _SMALL
        if small or points < _TINY:
            return [slice(0, rows)], [slice(0, columns)]
        few = _LINE * math.ceil(_TALL / height)
        return parts(rows, _BUFFER // width), parts(columns, few)

    def _complex(self, rows: int) -> np.ndarray:
        """Place for so many rows of the spectrum: the buffer, if it holds all."""
        buffer = self._lines[0].columns
        if self._whole:
            return buffer[:rows]
        return np.zeros((rows, self.grid[1] // 2 + 1), buffer.dtype)

    def _load(self, block: np.ndarray, spectrum: np.ndarray) -> None:
        """Take some rows of columns, and zeros below them."""
        if not self._whole:
            block[: len(spectrum)] = spectrum
        block[len(spectrum) :] = 0.0

    def _store(self, block: np.ndarray, spectrum: np.ndarray) -> None:
        """Put the first rows of columns back."""
        if not self._whole:
            spectrum[:] = block[: len(spectrum)]

    def _share(self, work: Callable[[Lines, slice], None], parts: list[slice]) -> None:
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

        def forward(lines: Lines, rows: slice) -> None:
            count = rows.stop - rows.start
            lines.rows[:count, :width] = values[rows]
            lines.rows[:count, width:] = 0.0
            lines.rows_forward(half[rows])

        self._share(forward, self._rows)

    def _rows_inverse(
        self, half: np.ndarray, out: np.ndarray | None = None
    ) -> np.ndarray:
        result = np.empty(self.window, self.dtype) if out is None else out

        def inverse(lines: Lines, rows: slice) -> None:
            count = rows.stop - rows.start
            lines.rows_inverse(half[rows])
            result[rows] = lines.rows[:count, : self.window[1]]

        self._share(inverse, self._rows)
        return result


def _longest(some: list[slice]) -> int:
    return max(part.stop - part.start for part in some)
