"""FFT libraries: transforms of a block of rows or columns, by FFTW or by ducc0."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
import pyfftw

try:
    import ducc0
except ImportError:
    ducc0 = None


class BlockTransform(ABC):
    """Buffers for a block of rows and a block of columns, and their transforms.

    Each transform uses one thread. A block that is smaller than the buffers fills their
    first rows or columns.

    Parameters
    ----------
    grid : (int, int)
        Shape ``(N, M)``.
    rows, columns : int
        Number of rows of the grid and of columns of its spectrum in the buffers.
    dtype : dtype
        Type of the rows.

    Attributes
    ----------
    rows : ndarray, shape (rows, M)
        Buffer for rows of the grid.
    columns : ndarray, shape (N, columns), complex
        Buffer for columns of the spectrum.
    """

    def __init__(
        self, grid: tuple[int, int], rows: int, columns: int, *, dtype: np.dtype
    ) -> None:
        complex_type = np.result_type(dtype, np.complex64)
        self.rows = pyfftw.zeros_aligned((rows, grid[1]), dtype)
        self.columns = pyfftw.zeros_aligned((grid[0], columns), complex_type)
        self._plan()

    def filter(
        self, values: np.ndarray, multiplier: np.ndarray, out: np.ndarray
    ) -> None:
        """Multiply the spectrum of the values on a window, in buffers for all of it.

        The array for the result may be the values.
        """
        rows, columns = self.rows, self.columns
        (n, m), every = values.shape, slice(0, columns.shape[1])
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
    def _plan(self) -> None:
        """Prepare the transforms."""

    @abstractmethod
    def rows_forward(self, spectra: np.ndarray) -> None:
        """Transform the first k rows into `spectra`, shape (k, M//2 + 1)."""

    @abstractmethod
    def rows_inverse(self, spectra: np.ndarray) -> None:
        """Transform `spectra`, shape (k, M//2 + 1), back into the first k rows."""

    @abstractmethod
    def columns_forward(self, block: slice) -> None:
        """Transform the first columns, as many as a block has, in place."""

    @abstractmethod
    def columns_inverse(self, block: slice) -> None:
        """Transform the first columns back in place, not normalised."""


class PyfftwTransform(BlockTransform):
    """Transforms by FFTW, whose plans are bound to the buffers.

    Plans are estimated: measured ones are up to 1.6 times faster, but finding them
    costs as much time as hundreds of transforms, and they differ from run to run. The
    threads of FFTW spin while they wait for each other, which is slow on busy
    processors, so that they are not used.
    """

    def _plan(self) -> None:
        width = self.rows.shape[1] // 2 + 1
        self._spectra = pyfftw.zeros_aligned(
            (len(self.rows), width), self.columns.dtype
        )
        plan, inverse = pyfftw.FFTW, {"direction": "FFTW_BACKWARD"}
        rows = {"axes": (1,), "flags": ("FFTW_ESTIMATE", "FFTW_DESTROY_INPUT")}
        columns = {"axes": (0,), "flags": ("FFTW_ESTIMATE",)}
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

    def columns_forward(self, block: slice) -> None:
        """See `BlockTransform`."""
        self._columns_forward.execute()

    def columns_inverse(self, block: slice) -> None:
        """See `BlockTransform`."""
        self._columns_inverse.execute()


class DuccTransform(BlockTransform):
    """Transforms by ducc0, which needs no plans."""

    def _plan(self) -> None:
        if ducc0 is None:
            raise ImportError(
                "engine 'ducc0' needs the package ducc0: pip install ducc0"
            )

    def rows_forward(self, spectra: np.ndarray) -> None:
        """See `BlockTransform`."""
        ducc0.fft.r2c(self.rows[: len(spectra)], axes=(1,), out=spectra)

    def rows_inverse(self, spectra: np.ndarray) -> None:
        """See `BlockTransform`."""
        rows, width = self.rows[: len(spectra)], self.rows.shape[1]
        ducc0.fft.c2r(spectra, axes=(1,), lastsize=width, forward=False, out=rows)

    def columns_forward(self, block: slice) -> None:
        """See `BlockTransform`."""
        self._columns(block, forward=True)

    def columns_inverse(self, block: slice) -> None:
        """See `BlockTransform`."""
        self._columns(block, forward=False)

    def _columns(self, block: slice, forward: bool) -> None:
        columns = self.columns[:, : block.stop - block.start]
        ducc0.fft.c2c(columns, axes=(0,), forward=forward, out=columns)
