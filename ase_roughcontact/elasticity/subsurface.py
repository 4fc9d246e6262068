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
from collections.abc import Iterator
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


class DirectedWaves(SubsurfaceWaves):
    """Waves in isotropic solids: those along and across a wave are independent."""

    def __init__(self, tractions: Tractions) -> None:
        qx, qy, tz, tx, ty = tractions
        self.q = np.hypot(qx, qy)
        self._cosine, self._sine = qx / self.q, qy / self.q
        self._normal = tz
        self._along: np.ndarray | None = None
        self._across: np.ndarray | None = None
        if tx is not None and ty is not None:
            self._along = -1j * (self._cosine * tx + self._sine * ty)
            self._across = self._cosine * ty - self._sine * tx

    @cached_property
    def _square(self) -> np.ndarray:
        return self._cosine**2

    @cached_property
    def _product(self) -> np.ndarray:
        return self._cosine * self._sine

    @abstractmethod
    def _sagittal(self, depth: float) -> _Sagittal:
        """Return the stresses in the plane of each wave."""

    @abstractmethod
    def _sagittal_displacement(self, depth: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the displacements l, without its factor i, and z (length)."""

    @abstractmethod
    def _shear(
        self, depth: float, across: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return tz, lt without its factor i, and the displacement along t."""

    def stress(self, depth: float) -> Iterator[np.ndarray]:
        """Yield the six components; see `SubsurfaceWaves`."""
        ll, tt, zz, lz = self._sagittal(depth)
        difference = ll - tt
        xx = tt + self._square * difference
        if self._across is None:
            yield xx
            yield ll + tt - xx
            yield zz
            lz = 1j * lz
            yield self._sine * lz
            yield self._cosine * lz
            yield self._product * difference
            return
        tz, lt, _ = self._shear(depth, self._across)
        lz, lt = 1j * lz, 1j * lt
        turned = 2.0 * self._product * lt
        yield xx - turned
        yield ll + tt - xx + turned
        yield zz
        yield self._sine * lz + self._cosine * tz
        yield self._cosine * lz - self._sine * tz
        yield self._product * difference + (2.0 * self._square - 1.0) * lt

    def displacement(self, depth: float) -> Iterator[np.ndarray]:
        """Yield the three components; see `SubsurfaceWaves`."""
        along, normal = self._sagittal_displacement(depth)
        along = 1j * along
        across: np.ndarray | float = 0.0
        if self._across is not None:
            across = self._shear(depth, self._across)[2]
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

    def _decayed(self, depth: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return n, D and D tau times the decay."""
        tau = self.q * depth
        decay = np.exp(-tau)
        normal = self._normal * decay
        difference = normal
        if self._along is not None:
            difference = normal - self._along * decay
        return normal, difference, difference * tau

    def _sagittal(self, depth: float) -> _Sagittal:
        normal, difference, product = self._decayed(depth)
        lz = product if self._along is None else normal - difference + product
        return _Sagittal(
            ll=2.0 * difference - normal - product,
            tt=2.0 * self._poisson * difference,
            zz=normal + product,
            lz=lz,
        )

    def _sagittal_displacement(self, depth: float) -> tuple[np.ndarray, np.ndarray]:
        normal, difference, product = self._decayed(depth)
        scale = 0.5 / (self._shear_modulus * self.q)
        nu = self._poisson
        along = normal - (2.0 - 2.0 * nu) * difference + product
        return scale * along, scale * (normal + (1.0 - 2.0 * nu) * difference + product)

    def _shear(
        self, depth: float, across: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        across = across * np.exp(-self.q * depth)
        return across, across, across / (self._shear_modulus * self.q)


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
        """Coefficients c and d of each decaying part, shape (..., 4 or 6)."""
        waves, place = np.unique(self.q, return_inverse=True)
        unit = self._unit_coefficients(waves)[place.reshape(self.q.shape)]
        total = unit[..., 0] * self._normal[..., None]
        if self._along is not None:
            total = total + unit[..., 1] * self._along[..., None]
        return total

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

    def _part(self, depth: float, name: str) -> np.ndarray:
        """Return a component at a depth, displacements times twice mu q."""
        c = self._coefficients
        if depth <= self._thickness:
            down = _parts(self.q * depth, self._poisson, 1.0, True)[name]
            height = self.q * (self._thickness - depth)
            up = _parts(height, self._poisson, 1.0, False)[name]
            return (down * c[..., :2]).sum(-1) + (up * c[..., 2:4]).sum(-1)
        if self._base is None:
            return np.zeros_like(self._normal)
        ratio = self._base[0] / self._shear_modulus
        below = self.q * (depth - self._thickness)
        down = _parts(below, self._base[1], ratio, True)[name]
        return (down * c[..., 4:]).sum(-1)

    def _sagittal(self, depth: float) -> _Sagittal:
        return _Sagittal(*(self._part(depth, name) for name in _Sagittal._fields))

    def _sagittal_displacement(self, depth: float) -> tuple[np.ndarray, np.ndarray]:
        scale = 0.5 / (self._shear_modulus * self.q)
        return scale * self._part(depth, "l"), scale * self._part(depth, "z")

    def _shear(
        self, depth: float, across: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        reflected = -1.0  # of a bonded rigid base
        if not self._bonded:
            reflected = 1.0
        elif self._base is not None:
            ratio = self._base[0] / self._shear_modulus
            reflected = (1.0 - ratio) / (1.0 + ratio)
        far = np.exp(-self.q * self._thickness)
        down = across / (1.0 - reflected * far**2)
        scale = 1.0 / (self._shear_modulus * self.q)
        if depth <= self._thickness:
            down = down * np.exp(-self.q * depth)
            up = across * reflected * far / (1.0 - reflected * far**2)
            up = up * np.exp(-self.q * (self._thickness - depth))
            return down - up, down + up, scale * (down + up)
        moved = self._bonded and self._base is not None
        factor = (1.0 + reflected) if moved else 0.0
        decay = far * np.exp(-self.q * (depth - self._thickness))
        below = factor * down * decay
        ratio = self._base[0] / self._shear_modulus if self._base else 1.0
        return ratio * below, ratio * below, scale * below


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
