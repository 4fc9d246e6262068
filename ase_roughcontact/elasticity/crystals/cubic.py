r"""Anisotropic half space: a cubic crystal with a (100) surface as a continuum.

.. math:: G(q) = \frac{2}{E^*(\theta) |q|}

with the moduli of waves in each direction, see `impedance`. The displacement by a point
force F in the direction :math:`\phi` is :math:`F/[\pi r E^*(\phi + \pi/2)]`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ase_roughcontact._util.validation import lookup, positive
from ase_roughcontact.elasticity.crystals.impedance import (
    elastic_tensor,
    surface_compliance,
)
from ase_roughcontact.elasticity.crystals.subsurface import (
    AnisotropicWaves,
    anisotropic_uniform,
    turned,
)
from ase_roughcontact.elasticity.greens import ComponentSolid
from ase_roughcontact.elasticity.harmonics import Harmonics, harmonics
from ase_roughcontact.elasticity.material import cubic_stiffness
from ase_roughcontact.elasticity.subsurface import Tractions, UniformResponse

# Number of directions of waves from which compliances are interpolated.
_DIRECTIONS = 320
# Largest anisotropy, at which moduli of waves are accurate to 1e-4, and displacements
# by pressure on one cell to 1e-3.
_MAX_ANISOTROPY = 100.0
# Angle between the x axis and a cube axis, by the direction of the x axis (rad).
_ANGLES = {"110": np.pi / 4, "100": 0.0}


@dataclass(frozen=True)
class Cubic(ComponentSolid):
    r"""Half space of a cubic crystal with a (100) surface, as a continuum.

    .. math:: G(q) = \frac{2}{E^*(\theta) |q|}

    with the moduli of `surface_modulus`. The response to pressure on one cell is the
    integral of the Green's function :math:`1/[\pi r E^*(\phi + \pi/2)]` over the cell.
    The contact modulus is the indentation modulus,
    :math:`1/E^* = \langle 1/E^*(\theta) \rangle`.

    Parameters
    ----------
    c11, c12, c44 : float
        Elastic constants (pressure).
    x : {"110", "100"}
        Crystal direction of the x axis: "110", along the rows of nearest neighbours
        of an fcc crystal, which are a square grid, or "100", along a cube axis.

    Raises
    ------
    ValueError
        If the crystal is not stable, its anisotropy ``2 c44/(c11 - c12)`` is not
        between 1/100 and 100, or the direction is neither.

    References
    ----------
    J. R. Willis, J. Mech. Phys. Solids 14, 163 (1966); J. J. Vlassak, W. D. Nix,
    J. Mech. Phys. Solids 42, 1223 (1994).

    Examples
    --------
    >>> from ase_roughcontact.elasticity import Cubic
    >>> round(Cubic(168.4, 121.4, 75.4).contact_modulus, 1)
    134.0
    """

    c11: float
    c12: float
    c44: float
    x: str = "110"

    def __post_init__(self) -> None:
        positive(c11=self.c11, c44=self.c44)
        lookup(self.x, _ANGLES, "direction of the x axis")
        if not -self.c11 / 2 < self.c12 < self.c11:
            raise ValueError(
                "a stable cubic crystal has -c11/2 < c12 < c11, got c11 = "
                f"{self.c11:g} and c12 = {self.c12:g}"
            )
        anisotropy = 2.0 * self.c44 / (self.c11 - self.c12)
        if not 1.0 / _MAX_ANISOTROPY <= anisotropy <= _MAX_ANISOTROPY:
            raise ValueError(
                "the anisotropy 2 c44/(c11 - c12) must be between "
                f"{1.0 / _MAX_ANISOTROPY:g} and {_MAX_ANISOTROPY:g}, got "
                f"{anisotropy:g}: check the elastic constants"
            )

    def surface_modulus(self, angles: np.ndarray) -> np.ndarray:
        """Return ``E*(theta)`` of waves at angles to the x axis (rad), shape (n,)."""
        return 2.0 / self._surface_compliance(np.asarray(angles))[:, 2, 2].real

    def _surface_compliance(self, angles: np.ndarray) -> np.ndarray:
        """Return the `surface_compliance` in the axes of the cube."""
        stiffness = cubic_stiffness(self.c11, self.c12, self.c44)
        return surface_compliance(stiffness, angles + _ANGLES[self.x])

    @cached_property
    def _components(self) -> list[Harmonics]:
        cosine, sine = np.cos(_ANGLES[self.x]), np.sin(_ANGLES[self.x])
        axes = np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])
        angles = np.pi / _DIRECTIONS * np.arange(_DIRECTIONS // 2)
        half = 0.5 * axes @ self._surface_compliance(angles) @ axes.T
        turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
        compliance = np.concatenate([half, turn @ half @ turn.T])
        direct = harmonics(compliance.real[:, (2, 0, 1, 0), (2, 0, 1, 1)].T)
        cross = harmonics(-compliance.imag[:, :2, 2].T, odd=True)
        return [*map(Harmonics, direct), *(Harmonics(c, odd=True) for c in cross)]

    @property
    def contact_modulus(self) -> float:  # type: ignore[override]
        """Indentation modulus (pressure)."""
        return 1.0 / float(self._components[0].c[0].real)

    def subsurface(self, tractions: Tractions) -> AnisotropicWaves:
        """Return the stress below the surface; see `ElasticSolid`."""
        return AnisotropicWaves(tractions, self._moduli)

    def uniform_response(self, depth: float) -> UniformResponse:
        """Return the response to a uniform traction; see `ElasticSolid`."""
        return anisotropic_uniform(self._moduli, depth)

    @cached_property
    def _moduli(self) -> np.ndarray:
        """Elastic constants in the axes of the surface, shape (3, 3, 3, 3)."""
        stiffness = cubic_stiffness(self.c11, self.c12, self.c44)
        return turned(elastic_tensor(stiffness), _ANGLES[self.x])
