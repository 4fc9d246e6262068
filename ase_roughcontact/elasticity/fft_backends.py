"""Transforms of a few rows and columns of a grid, in buffers, by FFTW or by ducc0."""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import partial

import numpy as np
import pyfftw

try:
    import ducc0
except ImportError:
    ducc0 = None

# Measuring plans is worth a moment, not more (seconds for each transform).
_PLANNING = 1.0


class Lines(ABC):
    """Buffers for a few rows and a few columns, and their transforms.

    Parameters
    ----------
    grid : (int, int)
        Shape ``(N, M)``.
    rows, columns : int
        Numbers of rows of the grid, and of columns of its spectrum, in the buffers.
    dtype : dtype
        Of the rows.
    threads : int
        Threads that one transform of ducc0 may take.
    measure : bool
        Whether to look for the fastest plan.

    Attributes
    ----------
    rows : ndarray, shape (rows, M)
        Buffer of rows of the grid.
    columns : ndarray, shape (N, columns), complex
        Buffer of columns of the spectrum.
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
        """Transform the first rows into some spectra, shape (k, M//2 + 1)."""

    @abstractmethod
    def rows_inverse(self, spectra: np.ndarray) -> None:
        """Transform some spectra, shape (k, M//2 + 1), back into the first rows."""

    @abstractmethod
    def columns_forward(self) -> None:
        """Transform all columns, in place."""

    @abstractmethod
    def columns_inverse(self) -> None:
        """Transform all columns back, in place and not normalised."""


class PyfftwLines(Lines):
    """Transforms by FFTW, whose plans are bound to the buffers.

    One thread each: those of FFTW spin while they wait for each other.
    """

    def _plan(self, threads: int, measure: bool) -> None:
        width = self.rows.shape[1] // 2 + 1
        self._spectra = pyfftw.zeros_aligned(
            (len(self.rows), width), self.columns.dtype
        )
        effort = "FFTW_MEASURE" if measure else "FFTW_ESTIMATE"
        plan = partial(pyfftw.FFTW, threads=1, planning_timelimit=_PLANNING)
        once = {"axes": (1,), "flags": (effort, "FFTW_DESTROY_INPUT")}
        back = {"direction": "FFTW_BACKWARD"}
        columns = {"axes": (0,), "flags": (effort,)}
        both = self.columns, self.columns
        self._rows_forward = plan(self.rows, self._spectra, **once)
        self._rows_inverse = plan(self._spectra, self.rows, **once, **back)
        self._columns_forward = plan(*both, **columns)
        self._columns_inverse = plan(*both, **columns, **back)

    def rows_forward(self, spectra: np.ndarray) -> None:
        """See `Lines`."""
        self._rows_forward.execute()
        spectra[:] = self._spectra[: len(spectra)]

    def rows_inverse(self, spectra: np.ndarray) -> None:
        """See `Lines`."""
        self._spectra[: len(spectra)] = spectra
        self._rows_inverse.execute()

    def columns_forward(self) -> None:
        """See `Lines`."""
        self._columns_forward.execute()

    def columns_inverse(self) -> None:
        """See `Lines`."""
        self._columns_inverse.execute()


class DuccLines(Lines):
    """Transforms by ducc0, which needs no plans.

    Raises
    ------
    ImportError
        If it is not installed.
    """

    def _plan(self, threads: int, measure: bool) -> None:
        if ducc0 is None:
            raise ImportError(
                "engine 'ducc0' needs the package ducc0: pip install ducc0"
            )
        self._threads = threads

    def rows_forward(self, spectra: np.ndarray) -> None:
        """See `Lines`."""
        rows = self.rows[: len(spectra)]
        ducc0.fft.r2c(rows, axes=(1,), out=spectra, nthreads=self._threads)

    def rows_inverse(self, spectra: np.ndarray) -> None:
        """See `Lines`."""
        ducc0.fft.c2r(
            spectra,
            axes=(1,),
            lastsize=self.rows.shape[1],
            forward=False,
            out=self.rows[: len(spectra)],
            nthreads=self._threads,
        )

    def columns_forward(self) -> None:
        """See `Lines`."""
        ducc0.fft.c2c(self.columns, axes=(0,), out=self.columns, nthreads=self._threads)

    def columns_inverse(self) -> None:
        """See `Lines`."""
        ducc0.fft.c2c(
            self.columns,
            axes=(0,),
            forward=False,
            out=self.columns,
            nthreads=self._threads,
        )
