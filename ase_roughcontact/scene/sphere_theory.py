"""Theories of smooth spheres with the same interface: Hertz, JKR, DMT, Maugis-Dugdale.

All quantities are in ASE's units.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ase_roughcontact import theory
from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import FloatArray

# Points of a curve of force against penetration.
_POINTS = 400
# Range of m - 1 = c/a - 1 along a curve of Maugis-Dugdale, from large forces to a
# contact that is almost a point.
_SMALLEST, _LARGEST = 1e-8, 1e4


@dataclass(frozen=True)
class SphereTheory(ABC):
    """Theory of a smooth sphere on an elastic half space.

    Attributes
    ----------
    radius : float
        R of the sphere (Å).
    contact_modulus : float
        E* (eV/Å^3).
    work_of_adhesion : float
        w (eV/Å^2), zero for Hertz.
    name : str
        Name of the theory.
    symbol : str
        Subscript of quantities that follow from it, as in A_Hertz.
    """

    radius: float
    contact_modulus: float
    work_of_adhesion: float = 0.0
    name: ClassVar[str]
    symbol: ClassVar[str]

    @property
    def sphere(self) -> str:
        """The system that the theory describes, with its work of adhesion in J/m^2."""
        work = self.work_of_adhesion / UNITS["J/m^2"]
        return "smooth sphere" + (f", w = {work:.3g} J/m²" if work else "")

    @property
    def label(self) -> str:
        """Name and system, for legends and printed output."""
        return f"{self.name}: theory, {self.sphere}"

    @property
    @abstractmethod
    def pull_off_force(self) -> float:
        """Smallest force of a contact (eV/Å): zero without adhesion."""

    @abstractmethod
    def contact_radius(self, normal_force: FloatArray) -> FloatArray:
        """Return the contact radius (Å) at forces not below pull-off (eV/Å)."""

    @abstractmethod
    def curve(self, largest: float) -> tuple[FloatArray, FloatArray]:
        """Return penetrations (Å) and forces (eV/Å) up to a contact radius (Å).

        The curve begins at the smallest contact that is stable at a given height.
        """

    def contact_area(self, normal_force: ArrayLike) -> FloatArray:
        """Return the contact area.

        Parameters
        ----------
        normal_force : array_like
            eV/Å.

        Returns
        -------
        ndarray
            Å^2, NaN below the pull-off force.
        """
        force = np.asarray(normal_force, dtype=float)
        exists = force >= self.pull_off_force
        radius = self.contact_radius(np.where(exists, force, 0.0))
        return np.where(exists, np.pi * radius**2, np.nan)

    @property
    def _sphere(self) -> tuple[float, float]:
        return self.radius, self.contact_modulus

    @property
    def _adhesive_sphere(self) -> tuple[float, float, float]:
        return self.radius, self.contact_modulus, self.work_of_adhesion


class Hertz(SphereTheory):
    """Hertz: no adhesion."""

    name = symbol = "Hertz"
    pull_off_force = 0.0

    def contact_radius(self, normal_force: FloatArray) -> FloatArray:
        """Return the contact radius."""
        return theory.hertz_contact_radius(normal_force, *self._sphere)

    def curve(self, largest: float) -> tuple[FloatArray, FloatArray]:
        """Return penetrations and forces."""
        depth = np.linspace(0.0, largest**2 / self.radius, _POINTS)
        return depth, theory.hertz_force(depth, *self._sphere)


class JKR(SphereTheory):
    """Johnson, Kendall and Roberts: attraction of short range."""

    name = symbol = "JKR"

    @property
    def pull_off_force(self) -> float:
        """Smallest force of a contact."""
        return float(theory.jkr_pull_off_force(self.radius, self.work_of_adhesion))

    def contact_radius(self, normal_force: FloatArray) -> FloatArray:
        """Return the contact radius."""
        return theory.jkr_contact_radius(normal_force, *self._adhesive_sphere)

    def curve(self, largest: float) -> tuple[FloatArray, FloatArray]:
        """Return penetrations and forces."""
        sphere = self._adhesive_sphere
        depth = theory.jkr_pull_off_penetration(*sphere)
        smallest = float(theory.jkr_contact_radius_from_penetration(depth, *sphere))
        a = np.linspace(smallest, max(largest, smallest), _POINTS)
        return theory.jkr_penetration(a, *sphere), theory.jkr_force(a, *sphere)


class DMT(SphereTheory):
    """Derjaguin, Muller and Toporov: attraction of long range."""

    name = symbol = "DMT"

    @property
    def pull_off_force(self) -> float:
        """Smallest force of a contact."""
        return float(theory.dmt_pull_off_force(self.radius, self.work_of_adhesion))

    def contact_radius(self, normal_force: FloatArray) -> FloatArray:
        """Return the contact radius."""
        return theory.dmt_contact_radius(normal_force, *self._adhesive_sphere)

    def curve(self, largest: float) -> tuple[FloatArray, FloatArray]:
        """Return penetrations and forces."""
        a = np.linspace(0.0, largest, _POINTS)
        force = theory.dmt_force(a, *self._adhesive_sphere)
        return theory.dmt_penetration(a, self.radius), force


@dataclass(frozen=True, kw_only=True)
class MaugisDugdale(SphereTheory):
    """Maugis and Dugdale: constant tension ``w/D`` over the range of the attraction.

    Attributes
    ----------
    attraction_range : float
        D (Å).
    """

    attraction_range: float
    name = "Maugis-Dugdale"
    symbol = "MD"

    @property
    def tension(self) -> float:
        """Tension between the surfaces outside of the contact (eV/Å^3)."""
        return self.work_of_adhesion / self.attraction_range

    @property
    def parameter(self) -> float:
        """Maugis' parameter: small in the limit of DMT, large in that of JKR."""
        return float(theory.maugis_parameter(*self._adhesive_sphere, self.tension))

    @cached_property
    def pull_off_force(self) -> float:
        """Smallest force of a contact."""
        return self._unit_force * theory.maugis_dugdale_pull_off_force(self.parameter)

    def contact_radius(self, normal_force: FloatArray) -> FloatArray:
        """Return the contact radius."""
        return theory.maugis_dugdale_contact_radius(
            normal_force, *self._adhesive_sphere, self.tension
        )

    def curve(self, largest: float) -> tuple[FloatArray, FloatArray]:
        """Return penetrations and forces."""
        unit = float(theory.hertz_contact_radius(self._unit_force, *self._sphere))
        limit = theory.maugis_dugdale_stability_limit(self.parameter, "displacement")
        end = min(limit - 1.0, _LARGEST)
        ratio = 1.0 + np.geomspace(end, _SMALLEST, 4 * _POINTS)
        a, force, depth = theory.maugis_dugdale(ratio, self.parameter)
        inside = unit * a <= largest
        depth, force = unit**2 / self.radius * depth, self._unit_force * force
        return depth[inside], force[inside]

    @property
    def _unit_force(self) -> float:
        return np.pi * self.work_of_adhesion * self.radius
