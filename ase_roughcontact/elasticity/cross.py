r"""Coupling of normal and lateral motion of a half space, periodic or free.

Pressure p displaces the surface sideways, and tractions t displace it upward,

.. math:: u_a = C_a * p, \qquad u_z = \sum_a C_a * t_a ,

with the same odd functions :math:`C_a` of the solid (see `greens`), as an elastic
energy :math:`\tfrac12 t \cdot G * t + t \cdot C * p + \tfrac12 p\, G_{zz} * p` has it.
"""

from __future__ import annotations

import numpy as np
from scipy.fft import irfft2, rfft2

from ase_roughcontact._util.validation import grid_shape, positive
from ase_roughcontact.elasticity.greens import ElasticSolid
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace
from ase_roughcontact.elasticity.lateral import cell_vectors, wave_vectors, workers_of


class CrossResponse:
    """Lateral displacement by pressure, and normal displacement by tractions.

    Parameters
    ----------
    shape, spacing, solid, periodic
        See `LateralHalfSpace`; the solid needs `cross_wave_compliance` if periodic, and
        else `cross_cell_compliance`.

    Raises
    ------
    ValueError
        If shape or spacing are not valid.
    NotImplementedError
        If the solid has no coupled components.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        spacing: float,
        solid: ElasticSolid,
        periodic: bool = False,
    ) -> None:
        self.shape = grid_shape(shape)
        positive(spacing=spacing)
        self.grid = n, m = (
            self.shape if periodic else FreeHalfSpace.padded_shape(self.shape)
        )
        if periodic:
            waves = wave_vectors(self.grid, spacing)
            self._compliance = solid.cross_wave_compliance(*waves)
            self._compliance[:, 0, 0] = 0.0  # the mean displaces nothing
            # an odd function has no wave that changes sign from cell to cell
            if n % 2 == 0:
                self._compliance[0, n // 2] = 0.0
            if m % 2 == 0:
                self._compliance[1, :, m // 2] = 0.0
        else:
            cells = solid.cross_cell_compliance(*cell_vectors(self.grid), spacing)
            self._compliance = rfft2(cells).imag  # of the odd part
        self._workers = workers_of(self.grid)

    def lateral(self, pressure: np.ndarray) -> np.ndarray:
        """Return the displacement along x and y by a pressure.

        Parameters
        ----------
        pressure : ndarray, shape (n, m)

        Returns
        -------
        ndarray, shape (2, n, m)
        """
        spectrum = rfft2(pressure, self.grid, workers=self._workers)
        return self._on_window(1j * self._compliance * spectrum)

    def normal(self, tractions: np.ndarray) -> np.ndarray:
        """Return the upward displacement by tractions along x and y.

        Parameters
        ----------
        tractions : ndarray, shape (2, n, m)
            On the surface (pressure).

        Returns
        -------
        ndarray, shape (n, m)
        """
        spectra = rfft2(tractions, self.grid, workers=self._workers)
        return self._on_window(1j * (self._compliance * spectra).sum(axis=0))

    def _on_window(self, spectra: np.ndarray) -> np.ndarray:
        n, m = self.shape
        return irfft2(spectra, self.grid, workers=self._workers)[..., :n, :m]
