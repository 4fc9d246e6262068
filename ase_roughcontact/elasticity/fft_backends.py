"""FFT libraries: transforms of a block of rows or columns, by FFTW or by ducc0.

A subclass of `BlockTransform` with a name is an engine of `RealFFT2`, which transforms
all fields of a contact: for normal displacements, friction and explicit atoms.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import lru_cache
from typing import ClassVar

import numpy as np

from ase_roughcontact._util.hidden import hidden
from ase_roughcontact._util.registry import Registry
from ase_roughcontact._util.threads import usable_threads

with hidden("dask"):  # pyfftw would import it for a part that is not used here
    import pyfftw

try:
    import ducc0
except ImportError:
    ducc0 = None

# Number of rows or columns that fill the vector registers of any processor.
_VECTOR_LENGTH = 16

#: Transforms by their `engine`; filled by the definition of a `BlockTransform`.
ENGINES: Registry[type[BlockTransform]] = Registry("engine")


class BlockTransform(ABC):
    """Buffers for a block of rows and a block of columns, and their transforms.

    A subclass defines the four transforms and a name. A block that is smaller than the
    buffers fills their first rows or columns. Each thread has its own object.

    Parameters
    ----------
    grid : (int, int)
        Shape ``(N, M)`` of the grid.
    rows, columns : int
        Numbers of rows of the grid and of columns of its spectrum in the buffers.
    dtype : dtype
        Type of the rows, single or double precision.

    Attributes
    ----------
    rows : ndarray, shape (rows, M)
        Buffer for rows of the grid.
    columns : ndarray, shape (N, columns), complex
        Buffer for columns of the spectrum.
    engine : str
        Name for the option `engine` of `RealFFT2`; a class without a name is not
        registered.
    threads : int or None
        Largest number of threads that share one transform, which `RealFFT2` sets for
        buffers of a whole large grid; None for blocks and small grids. A transform may
        use fewer. Its result must not depend on the number.
    in_blocks : bool
        Whether large grids are cut into blocks that fit the cache of a processor, which
        threads share. Otherwise the buffers hold the whole grid.

    Raises
    ------
    ValueError
        Where a class is defined, if another class has its name.
    """

    engine: ClassVar[str] = ""
    in_blocks: ClassVar[bool] = True
    threads: int | None = None

    def __init_subclass__(cls) -> None:
        """Add a transform with a name of its own to `ENGINES`."""
        super().__init_subclass__()
        if engine := vars(cls).get("engine"):
            ENGINES.add(engine, cls)

    def __init__(
        self, grid: tuple[int, int], rows: int, columns: int, *, dtype: np.dtype
    ) -> None:
        complex_type = np.result_type(dtype, np.complex64)
        self.rows = self.zeros((rows, grid[1]), dtype)
        self.columns = self.zeros((grid[0], columns), complex_type)

    def zeros(self, shape: tuple[int, int], dtype: np.dtype) -> np.ndarray:
        """Return a new buffer, an array of zeros."""
        return np.zeros(shape, dtype)

    def filter(
        self, values: np.ndarray, multiplier: np.ndarray, out: np.ndarray
    ) -> None:
        """Multiply the spectrum of values on a window, in buffers of the whole grid.

        The array `out` for the result may be the array of the values.
        """
        rows, columns = self.rows, self.columns
        (n, m), every = values.shape, columns.shape[1]
        rows[:, :m] = values
        if m < rows.shape[1]:
            rows[:, m:] = 0.0
        self.rows_forward(columns[:n])
        if n < len(columns):
            columns[n:] = 0.0
        self.columns_forward(every)
        np.multiply(columns, multiplier, out=columns)
        self.columns_inverse(every)
        self.rows_inverse(columns[:n])
        out[:] = rows[:, :m]

    @abstractmethod
    def rows_forward(self, spectra: np.ndarray) -> None:
        """Transform the first k rows into `spectra`, shape (k, M//2 + 1)."""

    @abstractmethod
    def rows_inverse(self, spectra: np.ndarray) -> None:
        """Transform `spectra`, shape (k, M//2 + 1), back into the first k rows."""

    @abstractmethod
    def columns_forward(self, count: int) -> None:
        """Transform the first columns in place, at least as many as counted."""

    @abstractmethod
    def columns_inverse(self, count: int) -> None:
        """Transform the first columns back in place, not normalised."""


class PyfftwTransform(BlockTransform):
    """Transforms by FFTW, with plans for the buffers.

    Plans are estimated. Measured plans are up to 1.6 times faster, but the measurement
    takes as much time as hundreds of transforms, and plans differ from run to run.
    FFTW's threads are not used: they spin while they wait for each other, which is slow
    on busy processors. For windows of 16 to 2048 points along a side, scipy.fft takes
    1.05 to 4.6 times as long (``examples/benchmarks/fft.py --threads 1``).
    """

    engine = "pyfftw"

    def __init__(
        self, grid: tuple[int, int], rows: int, columns: int, *, dtype: np.dtype
    ) -> None:
        super().__init__(grid, rows, columns, dtype=dtype)
        self._spectra = self.zeros((rows, grid[1] // 2 + 1), self.columns.dtype)
        plan, inverse = pyfftw.FFTW, {"direction": "FFTW_BACKWARD"}
        along_rows = {"axes": (1,), "flags": ("FFTW_ESTIMATE", "FFTW_DESTROY_INPUT")}
        along_columns = {"axes": (0,), "flags": ("FFTW_ESTIMATE",)}
        both = self.columns, self.columns
        self._rows_forward = plan(self.rows, self._spectra, **along_rows)
        self._rows_inverse = plan(self._spectra, self.rows, **along_rows, **inverse)
        self._columns_forward = plan(*both, **along_columns)
        self._columns_inverse = plan(*both, **along_columns, **inverse)

    def zeros(self, shape: tuple[int, int], dtype: np.dtype) -> np.ndarray:
        """Return a new buffer, aligned for the vector instructions of FFTW."""
        return pyfftw.zeros_aligned(shape, dtype)

    def rows_forward(self, spectra: np.ndarray) -> None:
        """See `BlockTransform`."""
        self._rows_forward.execute()
        spectra[:] = self._spectra[: len(spectra)]

    def rows_inverse(self, spectra: np.ndarray) -> None:
        """See `BlockTransform`."""
        self._spectra[: len(spectra)] = spectra
        self._rows_inverse.execute()

    def columns_forward(self, count: int) -> None:
        """See `BlockTransform`."""
        self._columns_forward.execute()

    def columns_inverse(self, count: int) -> None:
        """See `BlockTransform`."""
        self._columns_inverse.execute()


class DuccTransform(BlockTransform):
    """Transforms by ducc0, which needs no plans."""

    engine = "ducc0"

    def __init__(
        self, grid: tuple[int, int], rows: int, columns: int, *, dtype: np.dtype
    ) -> None:
        if ducc0 is None:
            raise ImportError(
                "engine 'ducc0' needs the package ducc0: pip install ducc0"
            )
        super().__init__(grid, rows, columns, dtype=dtype)

    def rows_forward(self, spectra: np.ndarray) -> None:
        """See `BlockTransform`."""
        for part, threads in self._parts(len(spectra)):
            out = spectra[part]
            ducc0.fft.r2c(self.rows[part], axes=(1,), out=out, nthreads=threads)

    def rows_inverse(self, spectra: np.ndarray) -> None:
        """See `BlockTransform`."""
        real = {"lastsize": self.rows.shape[1], "forward": False}
        for part, threads in self._parts(len(spectra)):
            out = self.rows[part]
            ducc0.fft.c2r(spectra[part], axes=(1,), out=out, nthreads=threads, **real)

    def columns_forward(self, count: int) -> None:
        """See `BlockTransform`."""
        self._columns(count, forward=True)

    def columns_inverse(self, count: int) -> None:
        """See `BlockTransform`."""
        self._columns(count, forward=False)

    def _columns(self, count: int, forward: bool) -> None:
        for part, threads in self._parts(count):
            columns, axis = self.columns[:, part], {"axes": (0,), "forward": forward}
            ducc0.fft.c2c(columns, out=columns, nthreads=threads, **axis)

    def _parts(self, count: int) -> list[tuple[slice, int]]:
        """Return parts of the rows or columns, and their numbers of threads."""
        if self.threads is None:
            return [(slice(0, count), 1)]
        return _shared_parts(count, usable_threads(self.threads))


@lru_cache
def _shared_parts(count: int, most: int) -> list[tuple[slice, int]]:
    """Return parts of rows or columns, and their numbers of threads.

    Threads of ducc0 share rows evenly, and what does not fill the vector registers is
    rounded differently. So each thread gets whole vectors, and one thread the vectors
    that are left, and then the rest.
    """
    vectors = count // _VECTOR_LENGTH
    threads = min(range(1, most + 1), key=lambda t: vectors // t + vectors % t)
    shared = _VECTOR_LENGTH * (vectors - vectors % threads)
    full = _VECTOR_LENGTH * vectors
    parts = [
        (slice(0, shared), threads),
        (slice(shared, full), 1),
        (slice(full, count), 1),
    ]
    return [(part, number) for part, number in parts if part.start < part.stop]
