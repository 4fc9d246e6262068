r"""Stress and displacement below the surface of an anisotropic half space.

The three solutions that decay below the surface under a wave of traction t are the
columns of a matrix exponential,

.. math:: u = \frac{1}{q} e^{-q \zeta \Gamma} C t, \qquad
          \Gamma = T^{-1} (C^{-1} - i R^T),

with the compliance C of the surface, `surface_compliance`, and the matrices R and T of
the module `impedance`. The exponential is Newton's interpolation at the eigenvalues
of :math:`\Gamma`, which needs no eigenvectors: they coincide in isotropic solids.

References
----------
A. N. Stroh, J. Math. Phys. 41, 77 (1962); T. C. T. Ting, Anisotropic Elasticity (1996),
Ch. 5 and 7.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.interpolate import CubicSpline

from ase_roughcontact.elasticity.crystals.impedance import surface_compliance
from ase_roughcontact.elasticity.subsurface import (
    ALL,
    SubsurfaceWaves,
    Tractions,
    UniformResponse,
)

# Number of directions in which the matrices are tabulated.
_DIRECTIONS = 360
# Product of a difference of eigenvalues and q zeta below which a series replaces a
# divided difference.
_SMALL_DIFFERENCE = 1e-4
# Index pairs of the components of stress.
_ROWS, _COLUMNS = (0, 1, 2, 1, 0, 0), (0, 1, 2, 2, 2, 1)


class AnisotropicWaves(SubsurfaceWaves):
    """Waves of traction on an anisotropic half space.

    Parameters
    ----------
    tractions : Tractions
    moduli : ndarray, shape (3, 3, 3, 3)
        Elastic constants in the axes of the surface, see `surface_compliance`.
    """

    def __init__(self, tractions: Tractions, moduli: np.ndarray) -> None:
        qx, qy, tz, tx, ty = tractions
        self._q = np.hypot(qx, qy)
        self._cosine, self._sine = qx / self._q, qy / self._q
        self._moduli = moduli[_ROWS, _COLUMNS]  # (6, 3, 3)
        matrices = _tabulated(moduli)(np.arctan2(qy, qx))
        self._decay = matrices[..., 0, :, :]
        load = np.zeros((*self._q.shape, 3), complex)
        load[..., 2] = tz
        if tx is not None and ty is not None:
            load[..., 0], load[..., 1] = tx, ty
        self._values = _ordered(np.linalg.eigvals(self._decay))
        first = _product(matrices[..., 1, :, :], load)
        second = _product(self._decay, first) - self._values[..., :1] * first
        third = _product(self._decay, second) - self._values[..., 1:2] * second
        self._terms = first, second, third

    def _scaled_displacement(self, depth: float, rows: slice) -> np.ndarray:
        """Return the displacement times q, shape (..., 3)."""
        tau = self._q[rows] * depth
        one, two, three = np.moveaxis(self._values[rows], -1, 0)
        low, high = _difference(one, two, tau), _difference(two, three, tau)
        close = abs(one - three) * tau < _SMALL_DIFFERENCE
        second = np.divide(
            low - high, one - three, where=~close, out=np.zeros_like(low)
        )
        mean = (one + two + three) / 3.0
        second = np.where(close, 0.5 * tau**2 * np.exp(-tau * mean), second)
        factors = np.exp(-tau * one), low, second
        return sum(
            f[..., None] * term[rows]
            for f, term in zip(factors, self._terms, strict=True)
        )

    def stress(self, depth: float, rows: slice = ALL) -> Iterator[np.ndarray]:
        """Yield the six components; see `SubsurfaceWaves`."""
        moved = self._scaled_displacement(depth, rows)
        slope = _product(self._decay[rows], moved)
        along_x = 1j * self._cosine[rows, ..., None] * moved
        along_y = 1j * self._sine[rows, ..., None] * moved
        gradient = np.stack([along_x, along_y, slope], axis=-1)
        for moduli in self._moduli:
            yield np.einsum("kl,...kl->...", moduli, gradient)

    def displacement(self, depth: float, rows: slice = ALL) -> Iterator[np.ndarray]:
        """Yield the three components; see `SubsurfaceWaves`."""
        moved = self._scaled_displacement(depth, rows) / self._q[rows, ..., None]
        yield from np.moveaxis(moved, -1, 0)


def anisotropic_uniform(moduli: np.ndarray, depth: float) -> UniformResponse:
    """Return the response to a uniform traction; see `UniformResponse`."""
    strain = np.linalg.inv(moduli[:, 2, :, 2])  # of each displacement along z
    stress = moduli[_ROWS, _COLUMNS, :, 2] @ strain
    return UniformResponse(stress, -depth * strain)


def turned(moduli: np.ndarray, angle: float) -> np.ndarray:
    """Return moduli in axes that are turned about z by an angle (rad)."""
    cosine, sine = np.cos(angle), np.sin(angle)
    axes = np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    return np.einsum("ai,bj,ck,dl,ijkl->abcd", axes, axes, axes, axes, moduli)


def _tabulated(moduli: np.ndarray) -> CubicSpline:
    """Return Gamma and the compliance C as functions of the direction of the wave."""
    angles = np.pi * np.arange(_DIRECTIONS // 2) / (_DIRECTIONS // 2)
    compliance = surface_compliance(moduli, angles)
    wave = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], -1)
    coupling = np.einsum("ikl,al->aik", moduli[:, 2], wave)  # transpose of R
    normal = moduli[:, 2, :, 2]
    decay = np.linalg.solve(normal, np.linalg.inv(compliance) - 1j * coupling)
    half = np.stack([decay, compliance], axis=1)
    whole = np.concatenate([half, half.conj(), half[:1]])
    turn = np.linspace(0.0, 2.0 * np.pi, _DIRECTIONS + 1)
    return CubicSpline(turn, whole, bc_type="periodic")


def _product(matrices: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Return the products of matrices and vectors, shape (..., 3)."""
    return (matrices @ vectors[..., None])[..., 0]


def _ordered(values: np.ndarray) -> np.ndarray:
    """Return three eigenvalues, of which the first and the last differ most."""
    one, two, three = np.moveaxis(values, -1, 0)
    gaps = np.stack([abs(two - three), abs(one - three), abs(one - two)])
    orders = np.array([[1, 0, 2], [0, 1, 2], [0, 2, 1]])
    return np.take_along_axis(values, orders[gaps.argmax(axis=0)], axis=-1)


def _difference(a: np.ndarray, b: np.ndarray, tau: np.ndarray) -> np.ndarray:
    """Return the divided difference of ``exp(-tau x)`` between a and b."""
    half = 0.5 * tau * (a - b)
    close = abs(half) < _SMALL_DIFFERENCE
    exact = np.exp(-tau * a) - np.exp(-tau * b)
    exact = np.divide(exact, a - b, where=~close, out=np.zeros_like(exact))
    series = -tau * np.exp(-0.5 * tau * (a + b)) * (1.0 + half * half / 6.0)
    return np.where(close, series, exact)
