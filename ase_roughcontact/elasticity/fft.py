"""Fourier transforms of real grids, with plans and buffers that are reused.

A `RealFFT2` transforms a grid where only a window of leading rows and columns is
nonzero (before the forward transform) or wanted (after the inverse transform). It skips
the transforms of the other rows, a quarter of the work for a grid that is padded to
twice the window in each direction.

Large grids are transformed in blocks of rows and blocks of columns, in buffers that fit
into the cache of a processor. A convolution transforms each block of columns forward,
multiplies it and transforms it back before the next block, so that the spectrum of the
padded grid is never stored as a whole. Several fields, such as tractions along x and y,
are multiplied by a matrix for each wave in the same way.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
from scipy.fft import next_fast_len

from ase_roughcontact._util.kernels import scale
from ase_roughcontact._util.threads import available_threads, split, thread_map
from ase_roughcontact._util.validation import grid_shape, integer
from ase_roughcontact.elasticity import fft_backends
from ase_roughcontact.elasticity.fft_backends import ENGINES, BlockTransform

#: Options of `RealFFT2` that half spaces take as keywords.
FFT_OPTIONS = "dtype", "engine", "threads", "blocking"

# Largest number of points of a grid that pyfftw transforms by default: on small grids
# its calls take less time than calls of ducc0, a sixth for 32 * 32 points.
_MAX_PYFFTW_POINTS = 64 * 64
# Smallest number of points of a grid for which threads share a transform of the whole:
# smaller ones take about as long as it takes to wait for a thread.
_MIN_SHARED_POINTS = 1000 * 1000


@dataclass(frozen=True)
class Blocking:
    """Sizes of the blocks into which large grids are cut.

    Attributes
    ----------
    row_block : int
        Number of entries in a block of rows.
    column_block : int
        Number of columns in a block for every `column_height` rows of the grid, which
        fill one or more cache lines.
    column_height : int
        Number of rows for which `column_block` is given.
    whole_grid_bytes : int
        Size below which a grid is transformed as a whole (bytes).
    """

    row_block: int = 131072
    column_block: int = 8
    column_height: int = 14000
    whole_grid_bytes: int = 8 << 20


class _Work(threading.local):
    """Number of grid points that were transformed forward and back in a thread."""

    points = 0


# Number of grid points that were transformed in this thread.
_WORK = _Work()


def transformed_points() -> int:
    """Return the number of grid points of all FFT pairs of this thread."""
    return _WORK.points


def fast_length(minimum: int) -> int:
    """Return the smallest length >= `minimum` with a fast real FFT."""
    return int(next_fast_len(minimum, real=True))


def _default_engine(grid: tuple[int, int]) -> str:
    """Return "ducc0" if it is installed and the grid is large, otherwise "pyfftw"."""
    small = math.prod(grid) <= _MAX_PYFFTW_POINTS
    return "pyfftw" if fft_backends.ducc0 is None or small else "ducc0"


class RealFFT2:
    """Two-dimensional real transform between a window and the spectrum of its grid.

    Parameters
    ----------
    window : (int, int)
        Shape ``(n, m)`` of the part of the grid with data.
    grid : (int, int), optional
        Shape ``(N, M)`` of the grid, zero outside of the window; by default `window`.
    dtype : dtype
        ``float64`` or ``float32``. Single precision halves the memory of the buffers,
        but relaxations to a tight tolerance may then not converge.
    engine : str, optional
        Library, the name of a `BlockTransform`: "pyfftw", "ducc0", or a class of your
        own; by default ducc0 where it is installed, but pyfftw for small grids.
    threads : int, optional
        Largest number of threads; by default the number of `available_threads`.
    blocking : Blocking, optional
        Sizes of the blocks of large grids.
    memory : RealFFT2, optional
        Transform with an array for the spectra of rows that is shared if it is large
        enough. Only one of the two may transform at a time.

    Attributes
    ----------
    spectrum : ndarray, shape (N, M//2 + 1), complex
        Result of `forward` and input of `inverse`, which overwrites it; `filter` may
        overwrite it, too.
    pairs : int
        Number of forward/inverse pairs of `filter` and `filter_fields`. Callers of
        `forward` and `inverse` add their own pairs.

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
        memory: RealFFT2 | None = None,
    ) -> None:
        self.window = grid_shape(window)
        self.grid = self.window if grid is None else grid_shape(grid)
        if any(n > big for n, big in zip(self.window, self.grid, strict=True)):
            raise ValueError(f"window {window} does not fit into grid {self.grid}")
        self.engine = _default_engine(self.grid) if engine is None else engine
        transform = ENGINES.find(self.engine)
        self.dtype = _float_type(dtype)
        self.threads = available_threads() if threads is None else threads
        integer("threads", self.threads, 1)
        self.blocking = blocking or Blocking()
        self.pairs = 0
        self._memory = memory

        self._row_blocks, self._column_blocks = self._blocks()
        self._whole = len(self._row_blocks) == len(self._column_blocks) == 1
        self.workers = min(
            self.threads, max(len(self._row_blocks), len(self._column_blocks))
        )
        rows, columns = map(_longest, (self._row_blocks, self._column_blocks))
        self._buffers: list[BlockTransform] = [
            transform(self.grid, rows, columns, dtype=self.dtype)
            for _ in range(self.workers)
        ]
        if self._whole and math.prod(self.grid) >= _MIN_SHARED_POINTS:
            self._buffers[0].threads = self.threads

    def __reduce__(self) -> tuple:
        """Pickle the parameters only: plans and buffers are cheaper to rebuild."""
        make = partial(
            type(self),
            dtype=self.dtype.name,
            engine=self.engine,
            threads=self.threads,
            blocking=self.blocking,
        )
        return make, (self.window, self.grid)

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
        if self._memory is not None:
            shape = self.window[0], self.grid[1] // 2 + 1
            kind = self._buffers[0].columns.dtype
            memory = self._memory._row_spectra.reshape(-1).view(kind)
            if memory.size >= math.prod(shape):
                return memory[: math.prod(shape)].reshape(shape)
        return self._complex_rows(self.window[0])

    def forward(self, values: np.ndarray) -> np.ndarray:
        """Transform `values`, shape (n, m), and return `spectrum`."""
        self._transform_rows(values, self.spectrum)

        def forward(buffer: BlockTransform, columns: slice) -> None:
            buffer.columns_forward(_length(columns))

        self._transform_columns(self.spectrum, self.window[0], self.grid[0], forward)
        return self.spectrum

    def inverse(
        self, out: np.ndarray | None = None, spectrum: np.ndarray | None = None
    ) -> np.ndarray:
        """Transform a spectrum back and return an array (n, m), not normalised.

        It is a new array unless `out` is given. The attribute `spectrum` is transformed
        unless another one is given, which is overwritten.
        """
        spectrum = self.spectrum if spectrum is None else spectrum

        def inverse(buffer: BlockTransform, columns: slice) -> None:
            buffer.columns_inverse(_length(columns))

        self._transform_columns(spectrum, self.grid[0], self.window[0], inverse)
        return self._inverse_rows(spectrum, self._result(out))

    def _result(self, out: np.ndarray | None) -> np.ndarray:
        """Return a given array for values on the window, or a new one."""
        if out is None:
            return np.empty(self.window, self.dtype)
        if (out.shape, out.dtype) != (self.window, self.dtype):
            raise ValueError(
                f"out must be of the shape {self.window} and the type {self.dtype}, "
                f"got {out.shape} and {out.dtype}"
            )
        return out

    def multiplier(self, values: np.ndarray, factor: float = 1.0) -> np.ndarray:
        """Prepare a real, even spectrum for `filter`, times a factor and normalised.

        Parameters
        ----------
        values : ndarray, shape (N, M//2 + 1), real
            Spectrum, even in both directions: only the first ``N//2 + 1`` rows are
            read.
        factor : float
            Factor of the spectrum.

        Returns
        -------
        ndarray
            Argument `multiplier` of `filter`.
        """
        rows = self.grid[0] // 2 + 1
        half = np.empty(values[:rows].shape, float if self._whole else self.dtype)
        scale(half, values[:rows], factor / math.prod(self.grid))
        if not self._whole:
            return half
        whole = np.concatenate((half, half[self.grid[0] - rows : 0 : -1]))
        return whole.astype(self.factor_type)

    @property
    def factor_type(self) -> np.dtype:
        """Type of factors for the fastest multiplication of spectra.

        NumPy multiplies complex numbers faster by complex than by real numbers. Real
        numbers take half the memory.
        """
        return self._buffers[0].columns.dtype if self._whole else self.dtype

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
            Values with the multiplied spectrum, on the window.
        """
        if values.shape != self.window:
            raise ValueError(f"expected the shape {self.window}, got {values.shape}")
        self._count(1)
        out = self._result(out)
        if self._whole:
            self._buffers[0].filter(values, multiplier, out)
            return out

        def filter_columns(buffer: BlockTransform, columns: slice) -> None:
            count = _length(columns)
            buffer.columns_forward(count)
            block, rows = buffer.columns[:, :count], len(multiplier)
            block[:rows] *= multiplier[:, columns]
            if rows < len(block):
                block[rows:] *= multiplier[len(block) - rows : 0 : -1, columns]
            buffer.columns_inverse(count)

        spectra, rows = self._row_spectra, self.window[0]
        self._transform_rows(values, spectra)
        self._transform_columns(spectra, rows, rows, filter_columns)
        return self._inverse_rows(spectra, out)

    def filter_fields(
        self,
        fields: np.ndarray,
        matrix: Sequence[Sequence[np.ndarray]],
        shape: tuple[int, int] | None = None,
        *,
        imaginary: bool = False,
    ) -> np.ndarray:
        """Multiply the spectra of several fields by a matrix for each wave.

        The number of pairs is the larger one of the numbers of rows and columns of the
        matrix.

        Parameters
        ----------
        fields : ndarray, shape (k, n, m)
            Values on the first rows and columns of the grid, zero elsewhere.
        matrix : sequence of l sequences of k arrays, shape (N, M//2 + 1)
            Real spectra, fastest if they have the type `factor_type`.
        shape : (int, int), optional
            Numbers of first rows and columns of the grid that are returned; by default
            ``(n, m)``.
        imaginary : bool
            Whether the matrix is multiplied by the imaginary unit.

        Returns
        -------
        ndarray, shape (l, `shape[0]`, `shape[1]`)
            Fields with the multiplied spectra.
        """
        count, given_rows = len(fields), fields.shape[1]
        shape = fields.shape[1:] if shape is None else shape
        largest = max(count, len(matrix))
        self._count(largest)
        kind = self._buffers[0].columns.dtype
        spectra = np.empty(
            (largest, max(given_rows, shape[0]), self.grid[1] // 2 + 1), kind
        )
        for values, spectrum in zip(fields, spectra, strict=False):
            self._transform_rows(values, spectrum[:given_rows])

        def multiply(buffer: BlockTransform, columns: slice) -> None:
            block = buffer.columns[:, : _length(columns)]
            waves = np.empty((count, *block.shape), kind)
            for spectrum, wave in zip(spectra, waves, strict=False):
                block[:given_rows] = spectrum[:given_rows, columns]
                block[given_rows:] = 0.0
                buffer.columns_forward(_length(columns))
                wave[:] = block
            for row, spectrum in zip(matrix, spectra, strict=False):
                np.multiply(row[0][:, columns], waves[0], out=block)
                for entry, wave in zip(row[1:], waves[1:], strict=True):
                    block += entry[:, columns] * wave
                if imaginary:
                    block *= 1j
                buffer.columns_inverse(_length(columns))
                spectrum[: shape[0], columns] = block[: shape[0]]

        self._each(self._column_blocks, multiply)
        found = np.empty((len(matrix), *shape), self.dtype)
        for spectrum, values in zip(spectra, found, strict=False):
            self._inverse_rows(spectrum[: shape[0]], values)
        found /= math.prod(self.grid)
        return found

    def _count(self, pairs: int) -> None:
        """Count forward/inverse pairs."""
        self.pairs += pairs
        _WORK.points += pairs * math.prod(self.grid)

    def _transform_rows(self, values: np.ndarray, spectra: np.ndarray) -> None:
        def work(buffer: BlockTransform, rows: slice) -> None:
            padded, width = buffer.rows[: _length(rows)], values.shape[1]
            padded[:, :width] = values[rows]
            padded[:, width:] = 0.0
            buffer.rows_forward(spectra[rows])

        self._each(self._blocks_of(len(values)), work)

    def _inverse_rows(self, spectra: np.ndarray, out: np.ndarray) -> np.ndarray:
        def work(buffer: BlockTransform, rows: slice) -> None:
            buffer.rows_inverse(spectra[rows])
            out[rows] = buffer.rows[: _length(rows), : out.shape[1]]

        self._each(self._blocks_of(len(out)), work)
        return out

    def _blocks_of(self, rows: int) -> list[slice]:
        """Return the blocks into which a number of rows is cut."""
        if rows == self.window[0]:
            return self._row_blocks
        return split(rows, len(self._buffers[0].rows))

    def _transform_columns(
        self,
        spectra: np.ndarray,
        given_rows: int,
        kept_rows: int,
        operation: Callable[[Any, slice], None],
    ) -> None:
        """Transform columns of `given_rows`, zero beyond them; keep the `kept_rows`."""

        def work(buffer: BlockTransform, columns: slice) -> None:
            block = buffer.columns[:, : _length(columns)]
            block[:given_rows] = spectra[:given_rows, columns]
            block[given_rows:] = 0.0
            operation(buffer, columns)
            spectra[:kept_rows, columns] = block[:kept_rows]

        self._each(self._column_blocks, work)

    def _each(
        self, blocks: list[slice], work: Callable[[BlockTransform, slice], None]
    ) -> None:
        """Call ``work(buffer, block)`` for all blocks, by several threads."""
        idle = self._buffers[::-1]

        def run(block: slice) -> None:
            buffer = idle.pop()
            work(buffer, block)
            idle.append(buffer)

        thread_map(run, blocks, self.workers)

    def _blocks(self) -> tuple[list[slice], list[slice]]:
        """Return the blocks of rows of the window and of columns of the spectrum."""
        rows, (height, width) = self.window[0], self.grid
        columns, blocking = width // 2 + 1, self.blocking
        small = height * width * self.dtype.itemsize < blocking.whole_grid_bytes
        if small or not ENGINES[self.engine].in_blocks:
            return [slice(0, rows)], [slice(0, columns)]
        tall = math.ceil(blocking.column_height / height)
        return (
            split(rows, blocking.row_block // width),
            split(columns, blocking.column_block * tall),
        )

    def _complex_rows(self, rows: int) -> np.ndarray:
        """Return an array for some rows of the spectrum."""
        kind = self._buffers[0].columns.dtype
        return np.zeros((rows, self.grid[1] // 2 + 1), kind)


def _float_type(dtype: object) -> np.dtype:
    """Return one of two precisions, or raise `ValueError`."""
    try:
        kind = np.dtype(dtype)  # type: ignore[call-overload]
    except TypeError:
        kind = None
    if kind not in (np.float32, np.float64):
        raise ValueError(f"dtype must be float32 or float64, got {dtype!r}")
    return kind


def _length(block: slice) -> int:
    """Return the number of rows or columns of a block."""
    return block.stop - block.start


def _longest(blocks: list[slice]) -> int:
    """Return the length of the longest block."""
    return max(map(_length, blocks))
