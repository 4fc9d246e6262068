r"""Forces of an elastic semi-infinite crystal on the lowest layers of a slab of atoms.

The atoms :math:`B` that feel the cut below the slab carry

.. math:: \Delta U = -f_B \cdot u_B + \tfrac12\, u_B \cdot D\, u_B, \qquad
          D = H_\text{crystal} - H_\text{slab},

where the crystal is condensed onto the slab and :math:`f_B` is minus the force from the
slab's own calculator at rest. For each wave vector, :math:`D` is a matrix of the
layers.

References
----------
L. Pastewka, T. A. Sharp, M. O. Robbins, Phys. Rev. B 86, 075459 (2012).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ase_roughcontact.elasticity.crystals.lattice_greens import (
    LatticeGreensFunction,
    dynamical_matrices,
)
from ase_roughcontact.elasticity.fft import RealFFT2
from ase_roughcontact.foundation.surface import CrystalSurface

# Wave number, times the spacing, from which the limit of long waves is extrapolated.
_LONG_WAVE_NUMBER = 1e-4
# Number of wave vectors with matrices that are calculated at once.
_WAVES_AT_ONCE = 256


class Coupling:
    """Energy and forces of the semi-infinite crystal below a periodic slab.

    Parameters
    ----------
    surface : CrystalSurface
        Surface of the crystal.
    calculator : Calculator
        ASE calculator of the slab.
    shape : (int, int)
        Numbers of surface cells (n, m).
    layers : int
        Number of layers of the slab.
    **fft
        Options of `RealFFT2`.

    Attributes
    ----------
    layers : int
        Number k of coupled layers, the lowest ones.
    forces : ndarray, shape (k, 3)
        Forces ``f_B`` at rest (eV/Å).
    matrices : ndarray, shape (n, m // 2 + 1, 3 k, 3 k)
        Matrix D for Fourier transforms over the cells (eV/Å^2).
    transform : RealFFT2
        Transform over the cells.
    """

    def __init__(
        self,
        surface: CrystalSurface,
        calculator: Any,
        shape: tuple[int, int],
        layers: int,
        **fft: Any,
    ) -> None:
        self.transform = RealFFT2(shape, **fft)
        # a thick slab is replaced by a thinner one that ends with the same sublattice,
        # where the surface does not act on the lowest layers either
        bulk_depth = surface.bulk_depth
        bulk_depth += (layers - bulk_depth) % surface.constants.sublattices
        depth = min(layers, bulk_depth)
        self.layers = min(layers, surface.constants.reach)
        self.shape = shape
        slab = surface.column(depth).repeat((surface.size, surface.size, 1))
        slab.calc = calculator
        forces = -slab.get_forces()[depth - self.layers : depth]
        self.forces = forces - forces.mean(axis=0)
        cut = surface.cut_couplings(calculator, depth, self.layers)
        greens = LatticeGreensFunction(surface.constants, depth)
        lowest = slice(-3 * self.layers, None)

        def difference(q: np.ndarray) -> np.ndarray:
            matrix = greens.stiffness(q, depth)[:, lowest, lowest]
            for (a, b), block in dynamical_matrices(q, cut).items():
                matrix[:, 3 * a : 3 * a + 3, 3 * b : 3 * b + 3] -= block
            return (matrix + matrix.conj().swapaxes(-1, -2)) / 2

        column = surface.column(layers)[layers - self.layers :]
        self.matrices = on_cells(difference, column, shape, surface.constants.spacing)
        self._impose_sum_rule()

    def _impose_sum_rule(self) -> None:
        """Remove the residual forces under a uniform displacement."""
        k = self.layers
        uniform = np.tile(np.eye(3), (k, 1))
        resultant = (self.matrices[0, 0].real @ uniform).reshape(k, 3, 3)
        for a, total in enumerate(resultant):
            block = slice(3 * a, 3 * a + 3)
            self.matrices[:, :, block, block] -= (total + total.T) / 2
        relative = np.eye(3 * k) - uniform @ uniform.T / k
        self.matrices[0, 0] = relative @ self.matrices[0, 0].real @ relative

    def evaluate(self, displacement: np.ndarray) -> tuple[float, np.ndarray]:
        """Return energy (eV) and forces (eV/Å) for a displacement from rest (Å).

        Displacement and forces have the shape (k, n, m, 3), the lowest layer last.
        """
        elastic = apply(self.matrices, displacement, self.transform)
        rest = self.forces[:, None, None]
        energy = np.vdot(displacement, 0.5 * elastic - rest)
        return float(energy), rest - elastic


def on_cells(
    matrix: Any, column: Any, shape: tuple[int, int], spacing: float
) -> np.ndarray:
    """Return matrices that act on Fourier transforms over the cells of a slab.

    Parameters
    ----------
    matrix : callable
        Function of wave vectors, shape (q, 2), none of them zero, that returns matrices
        of the shape (q, 3 k, 3 k) for waves ``exp(i q.r)``.
    column : Atoms
        The k atoms of one cell.
    shape : (int, int)
        Numbers of cells (n, m).
    spacing : float
        Distance of neighbours (length).

    Returns
    -------
    ndarray, shape (n, m // 2 + 1, 3 k, 3 k)
        Matrices; the one of the wave vector zero is the limit of long waves.
    """
    n, m = shape
    reciprocal = 2.0 * np.pi * np.linalg.inv(column.cell.array[:2, :2])
    numbers = np.stack(
        np.meshgrid(np.fft.fftfreq(n), np.fft.rfftfreq(m), indexing="ij"), axis=-1
    )
    q = numbers.reshape(-1, 2) @ reciprocal.T
    positions = np.repeat(column.positions[:, :2], 3, axis=0)
    matrices = np.empty((len(q), len(positions), len(positions)), complex)
    for start in range(1, len(q), _WAVES_AT_ONCE):
        part = slice(start, start + _WAVES_AT_ONCE)
        phases = np.exp(1j * q[part] @ positions.T)
        matrices[part] = phases[:, :, None] * matrix(q[part]) * phases[:, None].conj()
    long = np.array([[1.0, 0.0], [2.0, 0.0]]) * _LONG_WAVE_NUMBER / spacing
    once, twice = matrix(long).real
    matrices[0] = 2.0 * once - twice  # extrapolated linearly to |q| = 0
    return matrices.reshape(n, m // 2 + 1, len(positions), len(positions))


def apply(matrices: np.ndarray, field: np.ndarray, transform: RealFFT2) -> np.ndarray:
    """Return the product of matrices of `on_cells` and a field, shape (k, n, m, 3)."""
    components = list(np.ndindex(len(field), 3))  # layer, and x, y or z
    waves = np.empty((*transform.spectrum.shape, len(components), 1), complex)
    for number, (layer, axis) in enumerate(components):
        waves[:, :, number, 0] = transform.forward(field[layer, :, :, axis])
    transform.pairs += len(components)
    products = matrices @ waves
    result = np.empty(field.shape)
    for number, (layer, axis) in enumerate(components):
        transform.spectrum[:] = products[:, :, number, 0]
        result[layer, :, :, axis] = transform.inverse()
    result /= math.prod(transform.grid)
    return result
