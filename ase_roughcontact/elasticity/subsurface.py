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
from enum import Enum
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


class SubsurfaceWaves(ABC):
    """Stress and displacement below the surface that waves of traction cause."""

    @abstractmethod
    def stress(self, depth: float) -> Iterator[np.ndarray]:
        """Yield the amplitudes of the six `STRESS_COMPONENTS` at a depth.

        Parameters
        ----------
        depth : float
            Depth below the surface (length).

        Yields
        ------
        ndarray of complex, shape (...)
            Amplitudes, tension positive (pressure). The next one may overwrite it.
        """

    @abstractmethod
    def displacement(self, depth: float) -> Iterator[np.ndarray]:
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


class Load(Enum):
    """Unit loads on the surface in the plane of a wave: ``n = 1`` and ``s = 1``."""

    NORMAL = 0
    ALONG = 1


class _Sagittal(NamedTuple):
    """Amplitudes in the plane of a wave; factors i are left out of l and lz.

    Attributes
    ----------
    ll, tt, zz, lz : ndarray
        Stresses along the wave, across it, normal and shear (pressure).
    """

    ll: np.ndarray
    tt: np.ndarray
    zz: np.ndarray
    lz: np.ndarray


class _Amplitude(NamedTuple):
    """Amplitude of a load for each wave, and the same times i."""

    load: Load
    amplitude: np.ndarray
    turned: np.ndarray


class DirectedWaves(SubsurfaceWaves):
    """Waves in isotropic solids: those along and across a wave are independent.

    Real factors of all waves are combined before they are multiplied by amplitudes,
    which takes less time than sums of complex amplitudes.
    """

    def __init__(self, tractions: Tractions) -> None:
        qx, qy, tz, tx, ty = tractions
        self.q = np.hypot(qx, qy)
        self._cosine, self._sine = qx / self.q, qy / self.q
        self._square, self._product = self._cosine**2, self._cosine * self._sine
        self._loads = [_Amplitude(Load.NORMAL, tz, 1j * tz)]
        self._across: np.ndarray | None = None
        if tx is not None and ty is not None:
            along = self._cosine * tx + self._sine * ty
            self._loads.append(_Amplitude(Load.ALONG, -1j * along, along))
            self._across = self._cosine * ty - self._sine * tx
        # memory that all depths share: new arrays take longer than the arithmetic
        self._factor = np.empty(qx.shape)
        self._total, self._part = np.empty((2, *qx.shape), complex)

    @abstractmethod
    def _sagittal(self, depth: float, load: Load) -> _Sagittal:
        """Return the stresses in the plane of each wave under a unit load."""

    @abstractmethod
    def _moved(self, depth: float, load: Load) -> tuple[np.ndarray, np.ndarray]:
        """Return the displacements l, without its factor i, and z by a unit load."""

    @abstractmethod
    def _shear(self, depth: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return tz, lt without i, and the displacement t by a unit traction t."""

    def stress(self, depth: float) -> Iterator[np.ndarray]:
        """Yield the six components; see `SubsurfaceWaves`."""
        parts = {each.load: self._sagittal(depth, each.load) for each in self._loads}
        lateral: list[np.ndarray | float] = [0.0] * 6
        if self._across is not None:
            lateral = self._across_components(depth, self._across)
        total, part = self._total, self._part
        for k, name in enumerate(STRESS_COMPONENTS):
            for number, each in enumerate(self._loads):
                factor = self._real_factor(name, parts[each.load])
                wave = each.turned if name in ("yz", "xz") else each.amplitude
                out = part if number else total
                np.multiply(factor, wave, out=out)
                if number:
                    total += part
            if self._across is not None:
                total += lateral[k]
            yield total

    def _real_factor(self, name: str, parts: _Sagittal) -> np.ndarray:
        """Return a component of a unit load, without a factor i of yz and xz."""
        if name == "zz":
            return parts.zz
        out = self._factor
        if name in ("yz", "xz"):
            direction = self._sine if name == "yz" else self._cosine
            return np.multiply(direction, parts.lz, out=out)
        np.subtract(parts.ll, parts.tt, out=out)
        if name == "xy":
            out *= self._product
            return out
        out *= self._square
        if name == "xx":
            out += parts.tt
            return out
        return np.subtract(parts.ll, out, out=out)

    def _across_components(
        self, depth: float, across: np.ndarray
    ) -> list[np.ndarray | float]:
        """Return the six components by tractions across the waves."""
        tz, lt, _ = self._shear(depth)
        tz, lt = tz * across, 1j * lt * across
        turned = 2.0 * self._product * lt
        xy = (2.0 * self._square - 1.0) * lt
        return [-turned, turned, 0.0, self._cosine * tz, -self._sine * tz, xy]

    def displacement(self, depth: float) -> Iterator[np.ndarray]:
        """Yield the three components; see `SubsurfaceWaves`."""
        along, normal = np.zeros_like(self._total), np.zeros_like(self._total)
        for load, amplitude, turned in self._loads:
            factors = self._moved(depth, load)
            along += factors[0] * turned
            normal += factors[1] * amplitude
        across: np.ndarray | float = 0.0
        if self._across is not None:
            across = self._shear(depth)[2] * self._across
        yield self._cosine * along - self._sine * across
        yield self._sine * along + self._cosine * across
        yield normal


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
        # memory for each load, as for the sums of components
        self._memory = {each.load: np.empty((4, *self.q.shape)) for each in self._loads}

    def _sagittal(self, depth: float, load: Load) -> _Sagittal:
        tau, decay, ll, tt = self._memory[load]
        np.multiply(self.q, depth, out=tau)
        np.negative(tau, out=decay)
        np.exp(decay, out=decay)
        tau *= decay
        if load is Load.NORMAL:
            np.subtract(decay, tau, out=ll)
            np.multiply(decay, 2.0 * self._poisson, out=tt)
            decay += tau
            return _Sagittal(ll=ll, tt=tt, zz=decay, lz=tau)
        np.multiply(decay, -2.0, out=ll)
        ll += tau
        np.multiply(decay, -2.0 * self._poisson, out=tt)
        decay -= tau
        np.negative(tau, out=tau)
        return _Sagittal(ll=ll, tt=tt, zz=tau, lz=decay)

    def _moved(self, depth: float, load: Load) -> tuple[np.ndarray, np.ndarray]:
        tau, nu = self.q * depth, self._poisson
        scale = 0.5 * np.exp(-tau) / (self._shear_modulus * self.q)
        if load is Load.NORMAL:
            return scale * (tau + 2.0 * nu - 1.0), scale * (tau + 2.0 - 2.0 * nu)
        return scale * (2.0 - 2.0 * nu - tau), scale * (2.0 * nu - 1.0 - tau)

    def _shear(self, depth: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        decay = np.exp(-self.q * depth)
        return decay, decay, decay / (self._shear_modulus * self.q)


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

    def _at(self, depth: float, load: Load, names: Sequence[str]) -> list[np.ndarray]:
        """Return components at a depth, displacements times twice mu q."""
        c = self._coefficients[..., load.value]
        if depth <= self._thickness:
            down = _parts(self.q * depth, self._poisson, 1.0, True)
            height = self.q * (self._thickness - depth)
            up = _parts(height, self._poisson, 1.0, False)
            return [_sum(down[k], c[..., :2]) + _sum(up[k], c[..., 2:4]) for k in names]
        if self._base is None:
            return [np.zeros_like(self.q) for _ in names]
        ratio = self._base[0] / self._shear_modulus
        below = self.q * (depth - self._thickness)
        down = _parts(below, self._base[1], ratio, True)
        return [_sum(down[k], c[..., 4:]) for k in names]

    def _sagittal(self, depth: float, load: Load) -> _Sagittal:
        return _Sagittal(*self._at(depth, load, _Sagittal._fields))

    def _moved(self, depth: float, load: Load) -> tuple[np.ndarray, np.ndarray]:
        scale = 0.5 / (self._shear_modulus * self.q)
        along, normal = self._at(depth, load, ("l", "z"))
        return scale * along, scale * normal

    def _shear(self, depth: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        reflected = self._reflected
        far = np.exp(-self.q * self._thickness)
        scale = 1.0 / (self._shear_modulus * self.q)
        top = 1.0 / (1.0 - reflected * far**2)
        if depth <= self._thickness:
            down = top * np.exp(-self.q * depth)
            up = top * reflected * far * np.exp(-self.q * (self._thickness - depth))
            return down - up, down + up, scale * (down + up)
        if self._base is None or not self._bonded:
            nothing = np.zeros_like(far)
            return nothing, nothing, nothing
        decay = np.exp(-self.q * (depth - self._thickness))
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

    def stress(self, depth: float) -> Iterator[np.ndarray]:
        """Yield the six components; see `SubsurfaceWaves`."""
        return self._waves.stress(depth)

    def displacement(self, depth: float) -> Iterator[np.ndarray]:
        """Yield the three components; see `SubsurfaceWaves`."""
        for each in self._waves.displacement(depth):
            yield self._factor * each
