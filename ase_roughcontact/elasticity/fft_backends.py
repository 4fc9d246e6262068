"""FFT libraries: transforms of a block of rows or columns, by FFTW or by ducc0."""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import partial

import numpy as np
import pyfftw

try:
    import ducc0
except ImportError:
    ducc0 = None

# Time limit for the measurement of one plan of FFTW (s).
_PLANNING_TIME = 1.0


class BlockTransform(ABC):
    """Buffers for a block of rows and a block of columns, and their transforms.

    Parameters
    ----------
    grid : (int, int)
        Shape ``(N, M)``.
    rows, columns : int
        Number of rows of the grid and of columns of its spectrum in the buffers.
    dtype : dtype
        Type of the rows.
    threads : int
        Number of threads of one transform of ducc0.
    measure : bool
        Whether FFTW measures several plans to find the fastest one.

    Attributes
    ----------
    rows : ndarray, shape (rows, M)
        Buffer for rows of the grid.
    columns : ndarray, shape (N, columns), complex
        Buffer for columns of the spectrum.
    """

    def __init__(
        self,
        grid: tuple[int, int],
        rows: int,
        columns: int,
        *,
        dtype: np.dtype,
        threads: int,
        measure: bool,
    ) -> None:
        complex_type = np.result_type(dtype, np.complex64)
        self.rows = pyfftw.zeros_aligned((rows, grid[1]), dtype)
        self.columns = pyfftw.zeros_aligned((grid[0], columns), complex_type)
        self._plan(threads, measure)

    @abstractmethod
    def _plan(self, threads: int, measure: bool) -> None:
        """Prepare the transforms."""

    @abstractmethod
    def rows_forward(self, spectra: np.ndarray) -> None:
        """Transform the first k rows into `spectra`, shape (k, M//2 + 1)."""

    @abstractmethod
    def rows_inverse(self, spectra: np.ndarray) -> None:
        """Transform `spectra`, shape (k, M//2 + 1), back into the first k rows."""

    @abstractmethod
    def columns_forward(self) -> None:
        """Transform all columns in place."""

    @abstractmethod
    def columns_inverse(self) -> None:
        """Transform all columns back in place, not normalised."""


class PyfftwTransform(BlockTransform):
    """Transforms by FFTW, whose plans are bound to the buffers.

    Each plan uses one thread, because the threads of FFTW spin while they wait for each
    other, which is slow on busy processors.
    """

    def _plan(self, threads: int, measure: bool) -> None:
        width = self.rows.shape[1] // 2 + 1
        self._spectra = pyfftw.zeros_aligned(
            (len(self.rows), width), self.columns.dtype
        )
        planner = "FFTW_MEASURE" if measure else "FFTW_ESTIMATE"
        plan = partial(pyfftw.FFTW, threads=1, planning_timelimit=_PLANNING_TIME)
        rows = {"axes": (1,), "flags": (planner, "FFTW_DESTROY_INPUT")}
        inverse = {"direction": "FFTW_BACKWARD"}
        columns = {"axes": (0,), "flags": (planner,)}
        both = self.columns, self.columns
        self._rows_forward = plan(self.rows, self._spectra, **rows)
        self._rows_inverse = plan(self._spectra, self.rows, **rows, **inverse)
        self._columns_forward = plan(*both, **columns)
        self._columns_inverse = plan(*both, **columns, **inverse)

    def rows_forward(self, spectra: np.ndarray) -> None:
        """See `BlockTransform`."""
        self._rows_forward.execute()
        spectra[:] = self._spectra[: len(spectra)]

    def rows_inverse(self, spectra: np.ndarray) -> None:
        """See `BlockTransform`."""
        self._spectra[: len(spectra)] = spectra
        self._rows_inverse.execute()

    def columns_forward(self) -> None:
        """See `BlockTransform`."""
        self._columns_forward.execute()

    def columns_inverse(self) -> None:
        """See `BlockTransform`."""
        self._columns_inverse.execute()


class DuccTransform(BlockTransform):
    """Transforms by ducc0, which needs no plans.

    Attributes
    ----------
    threads : int
        Number of threads of one transform.

    Raises
    ------
    ImportError
        If ducc0 is not installed.
    """

    def _plan(self, threads: int, measure: bool) -> None:
        if ducc0 is None:
            raise ImportError(
                "engine 'ducc0' needs the package ducc0: pip install ducc0"
            )
        self.threads = threads

    def rows_forward(self, spectra: np.ndarray) -> None:
        """See `BlockTransform`."""
        rows = self.rows[: len(spectra)]
        ducc0.fft.r2c(rows, axes=(1,), out=spectra, nthreads=self.threads)

    def rows_inverse(self, spectra: np.ndarray) -> None:
        """See `BlockTransform`."""
        ducc0.fft.c2r(
            spectra,
            axes=(1,),
            lastsize=self.rows.shape[1],
            forward=False,
            out=self.rows[: len(spectra)],
            nthreads=self.threads,
        )

    def columns_forward(self) -> None:
        """See `BlockTransform`."""
        ducc0.fft.c2c(self.columns, axes=(0,), out=self.columns, nthreads=self.threads)

    def columns_inverse(self) -> None:
        """See `BlockTransform`."""
        ducc0.fft.c2c(
            self.columns,
            axes=(0,),
            forward=False,
            out=self.columns,
            nthreads=self.threads,
        )
