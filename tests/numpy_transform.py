"""A transform that is defined outside of the package, by NumPy."""

from unittest.mock import patch

import numpy as np

from ase_roughcontact.elasticity.fft_backends import ENGINES, BlockTransform

with patch.dict(ENGINES):  # other tests have the transforms of the package alone

    class NumpyTransform(BlockTransform):
        """Transforms by NumPy, which counts the blocks of columns."""

        engine = "numpy"
        forward = inverse = 0
        precisions: set = set()

        def rows_forward(self, spectra):
            self.precisions.add(self.rows.dtype.name)
            spectra[:] = np.fft.rfft(self.rows[: len(spectra)], axis=1)

        def rows_inverse(self, spectra):
            width = self.rows.shape[1]
            rows = np.fft.irfft(spectra, width, axis=1, norm="forward")
            self.rows[: len(spectra)] = rows

        def columns_forward(self, count):
            NumpyTransform.forward += 1
            self.columns[:, :count] = np.fft.fft(self.columns[:, :count], axis=0)

        def columns_inverse(self, count):
            NumpyTransform.inverse += 1
            columns = self.columns[:, :count]
            columns[:] = np.fft.ifft(columns, axis=0, norm="forward")


def with_numpy():
    """Return a context in which the transform is known, with counts of zero."""
    NumpyTransform.forward = NumpyTransform.inverse = 0
    NumpyTransform.precisions.clear()
    return patch.dict(ENGINES, numpy=NumpyTransform)
