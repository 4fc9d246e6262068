r"""Stress and displacement below the surface of a solid, for waves of traction.

The surface carries tractions :math:`(t_x, t_y, t_z) e^{i q \cdot x}` with
:math:`t_z = -p`. At the depth :math:`\zeta` below it, each component of stress and
displacement is a factor of the wave vector and the depth times the tractions. The z
axis points upward, out of the solid, as in ASE, and tension is positive.

In isotropic solids waves along their direction l and across it, t, are independent.
With :math:`\tau = q \zeta`, :math:`n = t_z`, :math:`s = -i t_l` and :math:`D = n - s`
the stress in a half space is

.. math:: \sigma_{zz} &= (n + D \tau) e^{-\tau}, \qquad
          \sigma_{lz} = i (s + D \tau) e^{-\tau}, \\
          \sigma_{ll} &= (2 D - n - D \tau) e^{-\tau}, \qquad
          \sigma_{tt} = 2 \nu D e^{-\tau}, \\
          \sigma_{tz} &= t_t e^{-\tau}, \qquad \sigma_{lt} = i t_t e^{-\tau} .

References
----------
K. L. Johnson, Contact Mechanics (1985), Sec. 3.2 and 3.6; I. N. Sneddon, Fourier
Transforms (1951), Sec. 46.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

#: Names of the components of stress, in the order of ASE (Voigt).
STRESS_COMPONENTS = "xx", "yy", "zz", "yz", "xz", "xy"


class Tractions(NamedTuple):
    """Waves of traction on the surface.

    Attributes
    ----------
    qx, qy : ndarray, shape (...)
        Wave vectors, never both zero (1/length).
    tz : ndarray of complex, shape (...)
        Amplitudes of the normal traction, minus the pressure.
    tx, ty : ndarray of complex, shape (...), optional
        Amplitudes of the lateral tractions; None for zero.
    """

    qx: np.ndarray
    qy: np.ndarray
    tz: np.ndarray
    tx: np.ndarray | None = None
    ty: np.ndarray | None = None


#: Rows of the arrays of all waves.
ALL = slice(None)


class SubsurfaceWaves(ABC):
    """Stress and displacement below the surface that waves of traction cause."""

    @abstractmethod
    def stress(self, depth: float, rows: slice = ALL) -> Iterator[np.ndarray]:
        """Yield the amplitudes of the six `STRESS_COMPONENTS` at a depth.

        Parameters
        ----------
        depth : float
            Depth below the surface (length).
        rows : slice
            Rows of the arrays of waves; by default all. Few rows at a time fit into the
            cache of a processor.

        Yields
        ------
        ndarray of complex, shape (...)
            Amplitudes, tension positive (pressure).
        """

    @abstractmethod
    def displacement(self, depth: float, rows: slice = ALL) -> Iterator[np.ndarray]:
        """Yield the amplitudes of the displacement along x, y and z (length)."""


@dataclass(frozen=True)
class UniformResponse:
    """Response to a uniform traction of a periodic cell, which keeps its size.

    Attributes
    ----------
    stress : ndarray, shape (6, 3)
        Stress per traction along x, y and z.
    displacement : ndarray, shape (3, 3)
        Displacement relative to the surface per traction (length/pressure).
    """

    stress: np.ndarray
    displacement: np.ndarray


def isotropic_uniform(poisson: float, displacement: np.ndarray) -> UniformResponse:
    """Return the response of an isotropic solid; see `UniformResponse`."""
    stress = np.zeros((6, 3))
    stress[(3, 4, 2), (1, 0, 2)] = 1.0
    stress[:2, 2] = poisson / (1.0 - poisson)
    return UniformResponse(stress, displacement)


def uniform_strain(shear_modulus: float, poisson: float) -> np.ndarray:
    """Return the derivatives of the displacement to z per traction, shape (3, 3)."""
    uniaxial = (1.0 - 2.0 * poisson) / (2.0 - 2.0 * poisson)
    return np.diag([1.0, 1.0, uniaxial]) / shear_modulus


class _DirectedStress(NamedTuple):
    """Amplitudes of the stress in the axes l along a wave, t across it, and z.

    Factors i are left out of lz and tz. Without a traction across the wave tz and lt
    are zero, and None. Amplitudes are pairs of their real and imaginary parts.

    Attributes
    ----------
    ll, tt, zz, lz : ndarray, shape (2, ...)
        Stresses in the plane of each wave (pressure).
    tz, lt : ndarray, shape (2, ...), optional
        Shear stresses across it (pressure).
    """

    ll: np.ndarray
    tt: np.ndarray
    zz: np.ndarray
    lz: np.ndarray
    tz: np.ndarray | None = None
    lt: np.ndarray | None = None


class DirectedWaves(SubsurfaceWaves):
    """Waves in isotropic solids: waves along and across a direction are independent.

    Amplitudes are pairs of their real and imaginary parts in this class, as NumPy takes
    less time for the products of two pairs of real arrays than of complex arrays.

    Attributes
    ----------
    q : ndarray, shape (...)
        Wave numbers (1/length).
    normal : ndarray, shape (2, ...)
        Amplitudes n of the normal traction (pressure).
    along, across : ndarray, shape (2, ...), optional
        Amplitudes s along each wave, and across it, of the tractions divided by i
        (pressure); None for zero.
    """

    def __init__(self, tractions: Tractions) -> None:
        qx, qy, tz, tx, ty = tractions
        self.q = np.sqrt(qx * qx + qy * qy)
        self._cosine, self._sine = qx / self.q, qy / self.q
        self.normal = _pair(tz)
        self.along: np.ndarray | None = None
        self.across: np.ndarray | None = None
        if tx is not None and ty is not None:
            x, y = _pair(-1j * tx), _pair(-1j * ty)
            self.along = self._cosine * x + self._sine * y
            self.across = self._cosine * y - self._sine * x

    @abstractmethod
    def _directed_stress(self, depth: float, rows: slice) -> _DirectedStress:
        """Return the stress in the axes of each wave."""

    @abstractmethod
    def _directed_displacement(
        self, depth: float, rows: slice
    ) -> tuple[np.ndarray, np.ndarray | None, np.ndarray]:
        """Return the displacements l and t, without factors i, and z."""

    def stress(self, depth: float, rows: slice = ALL) -> Iterator[np.ndarray]:
        """Yield the six components; see `SubsurfaceWaves`."""
        cosine, sine = self._cosine[rows], self._sine[rows]
        ll, tt, zz, lz, tz, lt = self._directed_stress(depth, rows)
        mean, difference = 0.5 * (ll + tt), 0.5 * (ll - tt)
        # the tensor is turned about z by an angle, and its components xx and xy by two
        double_cosine, double_sine = 2.0 * cosine * cosine - 1.0, 2.0 * sine * cosine
        turned, xy = double_cosine * difference, double_sine * difference
        xz, yz = cosine * lz, sine * lz
        if tz is not None and lt is not None:
            turned -= double_sine * lt
            xy += double_cosine * lt
            xz -= sine * tz
            yz += cosine * tz
        for each in mean + turned, mean - turned, zz:
            yield _complex(*each)
        for each in yz, xz:
            yield _times_i(each)
        yield _complex(*xy)

    def displacement(self, depth: float, rows: slice = ALL) -> Iterator[np.ndarray]:
        """Yield the three components; see `SubsurfaceWaves`."""
        cosine, sine = self._cosine[rows], self._sine[rows]
        along, across, normal = self._directed_displacement(depth, rows)
        x, y = cosine * along, sine * along
        if across is not None:
            x -= sine * across
            y += cosine * across
        yield _times_i(x)
        yield _times_i(y)
        yield _complex(*normal)


def _pair(values: np.ndarray) -> np.ndarray:
    """Return real and imaginary part, shape (2, ...)."""
    return np.stack([values.real, values.imag])


def _complex(real: np.ndarray, imaginary: np.ndarray) -> np.ndarray:
    """Return the complex array of a real and an imaginary part."""
    values = np.empty(real.shape, np.result_type(real, np.complex64))
    values.real, values.imag = real, imaginary
    return values


def _times_i(pair: np.ndarray) -> np.ndarray:
    """Return the complex array of a real and an imaginary part, times i."""
    return _complex(-pair[1], pair[0])


class IsotropicWaves(DirectedWaves):
    """Waves of traction on an isotropic half space.

    Parameters
    ----------
    tractions : Tractions
    shear_modulus : float
        Shear modulus (pressure).
    poisson : float
        Poisson's ratio.
    """

    def __init__(
        self, tractions: Tractions, shear_modulus: float, poisson: float
    ) -> None:
        super().__init__(tractions)
        self._shear_modulus, self._poisson = shear_modulus, poisson

    def _directed_stress(self, depth: float, rows: slice) -> _DirectedStress:
        tau = self.q[rows] * depth
        decay = np.exp(-tau)
        normal = decay * self.normal[:, rows]
        difference = normal
        if self.along is not None:
            difference = normal - decay * self.along[:, rows]
        zz = normal + tau * difference
        lz, ll = zz - difference, 2.0 * difference - zz
        tt = 2.0 * self._poisson * difference
        if self.across is None:
            return _DirectedStress(ll, tt, zz, lz)
        tz = decay * self.across[:, rows]
        return _DirectedStress(ll, tt, zz, lz, tz, -tz)

    def _directed_displacement(
        self, depth: float, rows: slice
    ) -> tuple[np.ndarray, np.ndarray | None, np.ndarray]:
        q, nu = self.q[rows], self._poisson
        tau = q * depth
        scale = 0.5 * np.exp(-tau) / (self._shear_modulus * q)
        n = scale * self.normal[:, rows]
        along, normal = (tau + 2.0 * nu - 1.0) * n, (tau + 2.0 - 2.0 * nu) * n
        if self.along is None or self.across is None:
            return along, None, normal
        s = scale * self.along[:, rows]
        along += (2.0 - 2.0 * nu - tau) * s
        normal += (2.0 * nu - 1.0 - tau) * s
        return along, 2.0 * scale * self.across[:, rows], normal


class LayeredWaves(DirectedWaves):
    r"""Waves of traction on an isotropic layer on an isotropic or rigid base.

    In the layer, waves decay downward from the surface and upward from the base. Each
    is of the form

    .. math:: u_z = (c + d \tau) e^{-\tau}, \qquad
              u_l = i [c - (3 - 4 \nu) d + d \tau] e^{-\tau},

    and the conditions at the surface and at the base determine the coefficients.

    Parameters
    ----------
    tractions : Tractions
    thickness : float
        Thickness of the layer (length).
    shear_modulus, poisson : float
        Shear modulus (pressure) and Poisson's ratio of the layer.
    base : (float, float) or None
        Shear modulus and Poisson's ratio of the base; None for a rigid base.
    bonded : bool
        Whether the layer is bonded to the base, or slides on it without friction.

    References
    ----------
    D. M. Burmister, J. Appl. Phys. 16, 89 (1945).
    """

    def __init__(
        self,
        tractions: Tractions,
        thickness: float,
        shear_modulus: float,
        poisson: float,
        base: tuple[float, float] | None,
        bonded: bool,
    ) -> None:
        super().__init__(tractions)
        self._thickness, self._bonded = thickness, bonded
        self._shear_modulus, self._poisson, self._base = shear_modulus, poisson, base

    @cached_property
    def _coefficients(self) -> np.ndarray:
        """Coefficients c and d of each decaying part, shape (..., 4 or 6, loads)."""
        waves, place = np.unique(self.q, return_inverse=True)
        return self._unit_coefficients(waves)[place.reshape(self.q.shape)]

    def _unit_coefficients(self, q: np.ndarray) -> np.ndarray:
        """Return the coefficients for unit n and s, shape (k, 4 or 6, 2)."""
        x = q * self._thickness
        zero = np.zeros_like(x)
        top = _parts(zero, self._poisson, 1.0, downward=True)
        top_far = _parts(x, self._poisson, 1.0, downward=True)
        bottom = _parts(zero, self._poisson, 1.0, downward=False)
        bottom_far = _parts(x, self._poisson, 1.0, downward=False)
        unknowns = 4 if self._base is None else 6
        matrix = np.zeros((x.size, unknowns, unknowns))
        for row, name in enumerate(("zz", "lz")):  # at the surface
            matrix[:, row, :2], matrix[:, row, 2:4] = top[name], bottom_far[name]
        interface = {
            name: np.concatenate([top_far[name], bottom[name]], axis=-1) for name in top
        }
        if self._base is None:
            conditions = ("l", "z") if self._bonded else ("lz", "z")
            for row, name in enumerate(conditions, 2):
                matrix[:, row] = interface[name]
        else:
            shear_modulus, poisson = self._base
            ratio = shear_modulus / self._shear_modulus
            base = _parts(zero, poisson, ratio, downward=True)
            joined = ("l", "z", "zz", "lz") if self._bonded else ("z", "zz")
            row = 2
            for name in joined:
                scale = max(1.0, ratio) if name in ("zz", "lz") else 1.0
                matrix[:, row, :4] = interface[name] / scale
                matrix[:, row, 4:] = -base[name] / scale
                row += 1
            if not self._bonded:  # no shear on either side
                matrix[:, row, :4] = interface["lz"]
                matrix[:, row + 1, 4:] = base["lz"] / ratio
        loads = np.zeros((x.size, unknowns, 2))
        loads[:, 0, 0] = loads[:, 1, 1] = 1.0
        return np.linalg.solve(matrix, loads)

    def _directed_stress(self, depth: float, rows: slice) -> _DirectedStress:
        ll, tt, zz, lz = self._in_plane(depth, rows, ("ll", "tt", "zz", "lz"))
        if self.across is None:
            return _DirectedStress(ll, tt, zz, lz)
        across = self.across[:, rows]
        tz, lt, _ = self._shear(depth, rows)
        return _DirectedStress(ll, tt, zz, lz, tz * across, -lt * across)

    def _directed_displacement(
        self, depth: float, rows: slice
    ) -> tuple[np.ndarray, np.ndarray | None, np.ndarray]:
        scale = 0.5 / (self._shear_modulus * self.q[rows])
        along, normal = (
            scale * each for each in self._in_plane(depth, rows, ("l", "z"))
        )
        if self.across is None:
            return along, None, normal
        _, _, across = self._shear(depth, rows)
        return along, across * self.across[:, rows], normal

    def _in_plane(
        self, depth: float, rows: slice, names: Sequence[str]
    ) -> list[np.ndarray]:
        """Return components in the plane of each wave, displacements times 2 mu q."""
        normal = self.normal[:, rows]
        totals = [each * normal for each in self._by_load(depth, rows, 0, names)]
        if self.along is not None:
            along = self.along[:, rows]
            parts = self._by_load(depth, rows, 1, names)
            for total, each in zip(totals, parts, strict=True):
                total += each * along
        return totals

    def _by_load(
        self, depth: float, rows: slice, load: int, names: Sequence[str]
    ) -> list[np.ndarray]:
        """Return components under unit n (load 0) or s (load 1)."""
        c, q = self._coefficients[rows, ..., load], self.q[rows]
        if depth <= self._thickness:
            down = _parts(q * depth, self._poisson, 1.0, True)
            height = q * (self._thickness - depth)
            up = _parts(height, self._poisson, 1.0, False)
            return [_sum(down[k], c[..., :2]) + _sum(up[k], c[..., 2:4]) for k in names]
        if self._base is None:
            return [np.zeros_like(q) for _ in names]
        ratio = self._base[0] / self._shear_modulus
        below = q * (depth - self._thickness)
        down = _parts(below, self._base[1], ratio, True)
        return [_sum(down[k], c[..., 4:]) for k in names]

    def _shear(
        self, depth: float, rows: slice
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return tz, lt without i, and the displacement t by a unit traction t."""
        reflected, q = self._reflected, self.q[rows]
        far = np.exp(-q * self._thickness)
        scale = 1.0 / (self._shear_modulus * q)
        top = 1.0 / (1.0 - reflected * far**2)
        if depth <= self._thickness:
            down = top * np.exp(-q * depth)
            up = top * reflected * far * np.exp(-q * (self._thickness - depth))
            return down - up, down + up, scale * (down + up)
        if self._base is None or not self._bonded:
            nothing = np.zeros_like(far)
            return nothing, nothing, nothing
        decay = np.exp(-q * (depth - self._thickness))
        below = (1.0 + reflected) * top * far * decay
        stress = below * self._base[0] / self._shear_modulus
        return stress, stress, scale * below

    @property
    def _reflected(self) -> float:
        """Amplitude of the shear wave that decays upward, relative to the other."""
        if not self._bonded:
            return 1.0
        if self._base is None:
            return -1.0
        ratio = self._base[0] / self._shear_modulus
        return (1.0 - ratio) / (1.0 + ratio)


def _sum(parts: np.ndarray, coefficients: np.ndarray) -> np.ndarray:
    """Return the sum of the parts of both coefficients c and d."""
    return np.einsum("...k,...k->...", parts, coefficients)


def _parts(
    tau: np.ndarray, poisson: float, modulus: float, downward: bool
) -> dict[str, np.ndarray]:
    """Return components per coefficient c and d, each of the shape (..., 2).

    Displacements are times ``2 mu q`` of the layer, and moduli relative to it. Factors
    i are left out of l and lz. Waves that decay upward are mirror images: they have the
    opposite displacement along z and the opposite shear.
    """
    decay, nu, sign = np.exp(-tau), poisson, 1.0 if downward else -1.0

    def terms(c: float, d: float, slope: float) -> np.ndarray:
        return np.stack([c * decay, (d + slope * tau) * decay], axis=-1)

    return {
        "l": terms(1.0, 4.0 * nu - 3.0, 1.0),
        "z": sign * terms(1.0, 0.0, 1.0),
        "zz": modulus * terms(1.0, 2.0 * nu - 1.0, 1.0),
        "lz": sign * modulus * terms(1.0, 2.0 * nu - 2.0, 1.0),
        "ll": modulus * terms(-1.0, 3.0 - 2.0 * nu, -1.0),
        "tt": modulus * terms(0.0, 2.0 * nu, 0.0),
    }


class ScaledWaves(SubsurfaceWaves):
    """Waves in a solid with a factor of the compliance: the stress is the same."""

    def __init__(self, waves: SubsurfaceWaves, factor: float) -> None:
        self._waves, self._factor = waves, factor

    def stress(self, depth: float, rows: slice = ALL) -> Iterator[np.ndarray]:
        """Yield the six components; see `SubsurfaceWaves`."""
        return self._waves.stress(depth, rows)

    def displacement(self, depth: float, rows: slice = ALL) -> Iterator[np.ndarray]:
        """Yield the three components; see `SubsurfaceWaves`."""
        for each in self._waves.displacement(depth, rows):
            yield self._factor * each
