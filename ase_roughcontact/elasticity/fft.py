"""Fourier transforms of real grids, with plans and buffers that are reused.

A `RealFFT2` transforms a grid of which only a window of leading rows and columns is
nonzero (before the forward transform) or wanted (after the inverse one). It skips the
transforms of the other rows, a quarter of the work for a grid that is padded to twice
the window in each direction.

Large grids are transformed in blocks of rows and blocks of columns, in buffers that fit
the cache of a processor. A convolution transforms each block of columns forward,
multiplies it and transforms it back before it turns to the next one, so that the
spectrum of the padded grid is never stored as a whole.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.fft import next_fast_len

from ase_roughcontact._util.kernels import scale
from ase_roughcontact._util.threads import available_threads, split, thread_map
from ase_roughcontact._util.validation import grid_shape, integer, one_of
from ase_roughcontact.elasticity import fft_backends
from ase_roughcontact.elasticity.fft_backends import (
    BlockTransform,
    DuccTransform,
    PyfftwTransform,
)

# Most numbers in a SIMD vector of any processor: 64 bytes in single precision.
_LONGEST_VECTOR = 16
# Grids up to this number of points are transformed by pyfftw, whose calls take less
# time: with 32 * 32 points a sixth.
_SMALL = 64 * 64

ENGINES = {"pyfftw": PyfftwTransform, "ducc0": DuccTransform}


@dataclass(frozen=True)
class Blocking:
    """How large grids are cut into blocks, and which grids are.

    Attributes
    ----------
    row_block : int
        Numbers in a block of rows.
    column_block : int
        Columns in a block, for every `column_height` rows of the grid: as many as make
        up a cache line, or a multiple of it.
    column_height : int
        See `column_block`.
    single_thread_points : int
        Grids with fewer points are transformed by one thread, as a whole.
    whole_grid_bytes : int
        Smaller grids are transformed by ducc0 in one buffer, a part by each thread.
    """

    row_block: int = 131072
    column_block: int = 8
    column_height: int = 14000
    single_thread_points: int = 432 * 432
    whole_grid_bytes: int = 8 << 20


def fast_length(minimum: int) -> int:
    """Return the smallest length >= `minimum` whose real FFT is fast."""
    return int(next_fast_len(minimum, real=True))


def _default_engine(grid: tuple[int, int]) -> str:
    """Return ducc0 where it is installed and the grid is not small, else pyfftw."""
    small = math.prod(grid) <= _SMALL
    return "pyfftw" if fft_backends.ducc0 is None or small else "ducc0"


class RealFFT2:
    """Two-dimensional real transform between a window and the spectrum of its grid.

    Parameters
    ----------
    window : (int, int)
        Shape ``(n, m)`` of the part of the grid that carries data.
    grid : (int, int), optional
        Shape ``(N, M)`` of the grid, zero outside of the window; by default `window`.
    dtype : dtype
        ``float64`` or ``float32``. Single precision halves the memory of the buffers,
        but relaxations to a tight tolerance may then not converge.
    engine : {"pyfftw", "ducc0"}, optional
        Library; by default ducc0 where it is installed, but pyfftw for small grids.
    threads : int, optional
        Maximum number of threads; by default that of `available_threads`.
    blocking : Blocking, optional
        How large grids are cut into blocks.

    Attributes
    ----------
    spectrum : ndarray, shape (N, M//2 + 1), complex
        Result of `forward` and input of `inverse`, which overwrites it, as `filter`
        may.
    pairs : int
        Number of forward/inverse pairs: those of `filter`, plus those that a caller of
        `forward` and `inverse` adds.

    Raises
    ------
    ValueError
        If the window is larger than the grid, or an option is not valid.
    """

    def __init__(
        self,
        window: tuple[int, int],
        grid: tuple[int, int] | None = None,
        *,
        dtype: type | str = np.float64,
        engine: str | None = None,
        threads: int | None = None,
        blocking: Blocking | None = None,
    ) -> None:
        self.window = grid_shape(window)
        self.grid = self.window if grid is None else grid_shape(grid)
        if any(n > big for n, big in zip(self.window, self.grid, strict=True)):
            raise ValueError(f"window {window} does not fit into grid {self.grid}")
        self.engine = _default_engine(self.grid) if engine is None else engine
        one_of(tuple(ENGINES), engine=self.engine)
        self.dtype = _float_type(dtype)
        self.threads = available_threads() if threads is None else threads
        integer("threads", self.threads, 1)
        self.blocking = blocking or Blocking()
        self.pairs = 0

        self._whole, self._row_blocks, self._column_blocks = self._blocks()
        self.workers = min(
            self.threads, max(len(self._row_blocks), len(self._column_blocks))
        )
        rows, columns = self.window[0], self.grid[1] // 2 + 1
        if not self._whole:
            rows, columns = _longest(self._row_blocks), _longest(self._column_blocks)
        self._buffers: list[BlockTransform] = [
            ENGINES[self.engine](self.grid, rows, columns, dtype=self.dtype)
            for _ in range(1 if self._whole else self.workers)
        ]

    def twin(self) -> RealFFT2:
        """Return a transform with the same plans and buffers that counts its pairs."""
        twin = object.__new__(RealFFT2)
        vars(twin).update(vars(self), pairs=0)
        return twin

    @cached_property
    def spectrum(self) -> np.ndarray:
        """Array for `forward` and `inverse`; `filter` does not need it."""
        return self._complex_rows(self.grid[0])

    @cached_property
    def _row_spectra(self) -> np.ndarray:
        """Transforms of the rows of the window, shape (n, M//2 + 1)."""
        return self._complex_rows(self.window[0])

    def forward(self, values: np.ndarray) -> np.ndarray:
        """Transform `values`, shape (n, m), and return `spectrum`."""
        self._transform_rows(values, self.spectrum)
        self._each(self._column_blocks, self._forward_columns)
        return self.spectrum

    def inverse(self) -> np.ndarray:
        """Transform `spectrum` back and return a new array (n, m), not normalised."""
        self._each(self._column_blocks, self._inverse_columns)
        return self._inverse_rows(self.spectrum)

    def multiplier(self, values: np.ndarray, factor: float = 1.0) -> np.ndarray:
        """Prepare a real, even spectrum for `filter`, times a factor and normalised.

        Parameters
        ----------
        values : ndarray, shape (N, M//2 + 1), real
            Even in both directions, so that only the first ``N//2 + 1`` rows are read.
        factor : float

        Returns
        -------
        ndarray
        """
        rows = self.grid[0] // 2 + 1
        half = np.empty(values[:rows].shape, float if self._whole else self.dtype)
        scale(half, values[:rows], factor / math.prod(self.grid))
        if not self._whole:
            return half
        # NumPy multiplies complex numbers faster by complex than by real ones
        whole = np.concatenate((half, half[self.grid[0] - rows : 0 : -1]))
        return whole.astype(self._buffers[0].columns.dtype)

    def filter(
        self,
        values: np.ndarray,
        multiplier: np.ndarray,
        out: np.ndarray | None = None,
    ) -> np.ndarray:
        """Multiply the spectrum of `values`: one forward/inverse pair.

        Parameters
        ----------
        values : ndarray, shape (n, m)
            Values on the window.
        multiplier : ndarray
            Result of the method `multiplier`.
        out : ndarray, shape (n, m), optional
            Array for the result, which may be `values`.

        Returns
        -------
        ndarray, shape (n, m)
        """
        if out is not None and (out.shape, out.dtype) != (self.window, self.dtype):
            raise ValueError(
                f"out must be of the shape {self.window} and the type {self.dtype}, "
                f"got {out.shape} and {out.dtype}"
            )
        self.pairs += 1
        if self._whole and self.workers == 1:
            self._check(values)
            if out is None:
                out = np.empty(self.window, self.dtype)
            self._buffers[0].filter(values, multiplier, out)
            return out
        self._transform_rows(values, self._row_spectra)
        self._each(self._column_blocks, self._filter_columns, multiplier)
        return self._inverse_rows(self._row_spectra, out)

    def _transform_rows(self, values: np.ndarray, spectra: np.ndarray) -> None:
        self._check(values)
        self._each(self._row_blocks, self._forward_row_block, values, spectra)

    def _check(self, values: np.ndarray) -> None:
        if values.shape != self.window:
            raise ValueError(f"expected the shape {self.window}, got {values.shape}")

    def _inverse_rows(
        self, spectra: np.ndarray, out: np.ndarray | None = None
    ) -> np.ndarray:
        result = np.empty(self.window, self.dtype) if out is None else out
        self._each(self._row_blocks, self._inverse_row_block, spectra, result)
        return result

    def _forward_row_block(
        self, buffer: BlockTransform, rows: slice, values: np.ndarray, out: np.ndarray
    ) -> None:
        part, width = self._part(rows), self.window[1]
        padded = buffer.rows[part]
        padded[:, :width] = values[rows]
        padded[:, width:] = 0.0
        buffer.rows_forward(part, out[rows])

    def _inverse_row_block(
        self, buffer: BlockTransform, rows: slice, spectra: np.ndarray, out: np.ndarray
    ) -> None:
        part = self._part(rows)
        buffer.rows_inverse(part, spectra[rows])
        out[rows] = buffer.rows[part, : self.window[1]]

    def _forward_columns(self, buffer: BlockTransform, columns: slice) -> None:
        part = self._part(columns)
        block = self._load(buffer, part, self.spectrum[: self.window[0], columns])
        buffer.columns_forward(part)
        self._store(block, self.spectrum[:, columns])

    def _inverse_columns(self, buffer: BlockTransform, columns: slice) -> None:
        part = self._part(columns)
        block = self._load(buffer, part, self.spectrum[:, columns])
        buffer.columns_inverse(part)
        self._store(block, self.spectrum[: self.window[0], columns])

    def _filter_columns(
        self, buffer: BlockTransform, columns: slice, multiplier: np.ndarray
    ) -> None:
        part = self._part(columns)
        block = self._load(buffer, part, self._row_spectra[:, columns])
        buffer.columns_forward(part)
        rows = len(multiplier)
        block[:rows] *= multiplier[:, columns]
        if rows < len(block):
            block[rows:] *= multiplier[len(block) - rows : 0 : -1, columns]
        buffer.columns_inverse(part)
        self._store(block, self._row_spectra[:, columns])

    def _part(self, block: slice) -> slice:
        """Return the part of a buffer for a block of the grid."""
        return block if self._whole else slice(0, block.stop - block.start)

    def _load(
        self, buffer: BlockTransform, part: slice, spectra: np.ndarray
    ) -> np.ndarray:
        """Return a part of the buffer of columns with spectra of rows, and zeros."""
        block = buffer.columns[:, part]
        if not self._whole:
            block[: len(spectra)] = spectra
        block[len(spectra) :] = 0.0
        return block

    def _store(self, block: np.ndarray, spectra: np.ndarray) -> None:
        """Copy the leading rows of the buffer of columns back."""
        if not self._whole:
            spectra[:] = block[: len(spectra)]

    def _each(
        self, blocks: list[slice], work: Callable[..., None], *arrays: np.ndarray
    ) -> None:
        """Call ``work(buffer, block, *arrays)`` for all blocks, shared by threads."""
        if len(blocks) == 1:
            work(self._buffers[0], blocks[0], *arrays)
            return
        idle = self._buffers * self.workers if self._whole else self._buffers[::-1]

        def run(block: slice) -> None:
            buffer = idle.pop()
            work(buffer, block, *arrays)
            idle.append(buffer)

        thread_map(run, blocks, self.workers)

    def _blocks(self) -> tuple[bool, list[slice], list[slice]]:
        """Return the blocks of rows of the window and of columns of the spectrum.

        Before them, whether the buffers are for the whole grid.
        """
        rows, (height, width) = self.window[0], self.grid
        columns, points = width // 2 + 1, height * width
        size = points * self.dtype.itemsize
        if points < self.blocking.single_thread_points:
            return True, [slice(0, rows)], [slice(0, columns)]
        if self.engine == "ducc0" and size < self.blocking.whole_grid_bytes:
            return True, _shares(rows, self.threads), _shares(columns, self.threads)
        tall = math.ceil(self.blocking.column_height / height)
        return (
            False,
            split(rows, self.blocking.row_block // width),
            split(columns, self.blocking.column_block * tall),
        )

    def _complex_rows(self, rows: int) -> np.ndarray:
        """Return an array for some rows of the spectrum: the buffer if it is whole."""
        buffer = self._buffers[0].columns
        if self._whole:
            return buffer[:rows]
        return np.zeros((rows, self.grid[1] // 2 + 1), buffer.dtype)


def _shares(length: int, threads: int) -> list[slice]:
    """Cut a length into a piece for each thread.

    All but the last are multiples of the lengths of SIMD vectors. Where a line is in
    its vector, which may change the rounding of its transform, then does not depend on
    the number of threads.
    """
    vectors = math.ceil(length / _LONGEST_VECTOR)
    ends = [vectors * k // threads * _LONGEST_VECTOR for k in range(threads + 1)]
    return [slice(a, min(b, length)) for a, b in pairwise(ends) if a < b]


def _float_type(dtype: object) -> np.dtype:
    """Return one of two precisions, or raise `ValueError`."""
    try:
        known = np.dtype(dtype)  # type: ignore[call-overload]
    except TypeError:
        known = None
    if known not in (np.float32, np.float64):
        raise ValueError(f"dtype must be float32 or float64, got {dtype!r}")
    return known


def _longest(blocks: list[slice]) -> int:
    return max(block.stop - block.start for block in blocks)
