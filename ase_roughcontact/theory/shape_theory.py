r"""Closed forms of indenters of simple shapes, with and without adhesion.

With the depth :math:`d_0`, the contact radius a and the force :math:`N_0` without
adhesion, a contact of the same radius has with adhesion, if the range of the attraction
is small (D. Maugis, M. Barquins, J. Phys. D **11**, 1989 (1978); for a punch
K. Kendall, J. Phys. D **4**, 1186 (1971)),

.. math:: N = N_0 - \sqrt{8 \pi E^* w a^3}, \qquad
          d = d_0 - \sqrt{2 \pi w a/E^*}.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import FloatArray, unmasked
from ase_roughcontact.theory.indenters import Indenter
from ase_roughcontact.theory.smooth_sphere import CURVE_POINTS

# Smallest depth without adhesion of the table of adhesive contacts, in units of the
# depth at which adhesion and elasticity have equal forces.
_MIN_DEPTH = 1e-6
# Largest depth of this table, in the same units.
_MAX_DEPTH = 1e4
# Number of depths in this table.
_TABLE_POINTS = 4000
# Ratio of depths in the search for a depth, and for the end of a curve.
_DEPTH_RATIO = 1.25


@dataclass(frozen=True)
class ShapeTheory:
    """Indenter of a simple shape on an elastic half space; see `SphereTheory`.

    Parameters
    ----------
    shape : Indenter
        Indenter (lengths in Å).
    contact_modulus : float
        Contact modulus E* (eV/Å^3).
    work_of_adhesion : float
        Work of adhesion w (eV/Å^2); zero without adhesion.
    """

    shape: Indenter
    contact_modulus: float
    work_of_adhesion: float = 0.0

    @property
    def name(self) -> str:
        """Name of the theory."""
        return "JKR" if self.work_of_adhesion else "Sneddon"

    @property
    def symbol(self) -> str:
        """Subscript of quantities that follow from the theory."""
        return self.name

    @property
    def sphere(self) -> str:
        """Name of the shape and the work of adhesion in J/m^2, for output."""
        work = self.work_of_adhesion / UNITS["J/m^2"]
        return self.shape.name + (f", w = {work:.3g} J/m²" if work else "")

    @property
    def label(self) -> str:
        """Name and indenter, for legends and printed output."""
        return f"{self.name}: theory, {self.sphere}"

    @cached_property
    def pull_off_force(self) -> float:
        """Largest tension of a contact (eV/Å); zero without adhesion."""
        if not self.work_of_adhesion:
            return 0.0
        return -float(self._contacts[2].min())

    @property
    def pull_off_penetration(self) -> float:
        """Penetration at pull-off of a tip at a given height (Å); zero if w is zero."""
        if not self.work_of_adhesion:
            return 0.0
        return float(self._contacts[1].min())

    def penetration(self, normal_force: float) -> float:
        """Return the penetration of the stable contact under a force (Å)."""
        if not self.work_of_adhesion:
            return float(self.shape.depth(normal_force / self.contact_modulus))
        _, depth, forces = self._contacts
        stable = slice(int(forces.argmin()), None)
        return float(np.interp(normal_force, forces[stable], depth[stable]))

    def contact_radius(self, normal_force: ArrayLike) -> FloatArray:
        """Return the radius of the stable contact.

        Parameters
        ----------
        normal_force : array_like
            Normal forces N, at least the negative pull-off force (eV/Å).

        Returns
        -------
        ndarray
            Contact radii a (Å); NaN if there is no closed form.
        """
        force = unmasked(normal_force).astype(float)
        if not self.work_of_adhesion:
            depth = self.shape.depth(np.maximum(force, 0.0) / self.contact_modulus)
            return self.shape.radius(depth)
        radius, _, forces = self._contacts
        stable = slice(int(forces.argmin()), None)
        return np.interp(force, forces[stable], radius[stable])

    def contact_area(self, normal_force: ArrayLike) -> FloatArray:
        """Return the area of the stable contact; see `SphereTheory.contact_area`."""
        force = unmasked(normal_force).astype(float)
        exists = force >= -self.pull_off_force
        radius = self.contact_radius(np.where(exists, force, 0.0))
        area = self.shape.area_ratio * np.pi * radius**2
        return np.where(exists, area, np.nan)

    def curve_to(self, penetration: float) -> tuple[FloatArray, FloatArray]:
        """Return a curve of force against penetration, for figures.

        Parameters
        ----------
        penetration : float
            Penetration at which the curve ends (Å).

        Returns
        -------
        penetration, force : ndarray
            Penetrations (Å) and forces (eV/Å), from the smallest contact that is stable
            at a given height.
        """
        if not self.work_of_adhesion:
            depth = np.linspace(0.0, max(penetration, 0.0), CURVE_POINTS)
            return depth, self.contact_modulus * self.shape.force(depth)
        _, depth, force = self._contacts
        stable = slice(int(depth.argmin()), None)
        kept = depth[stable] <= penetration
        return depth[stable][kept], force[stable][kept]

    @cached_property
    def _contacts(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Radii, depths and forces of adhesive contacts, in the order of the radii."""
        modulus, work = self.contact_modulus, self.work_of_adhesion

        def tension(radius: FloatArray) -> FloatArray:
            return np.sqrt(8.0 * math.pi * modulus * work * radius**3)

        scale = np.array(work / modulus)
        while tension(self.shape.radius(scale)) > modulus * self.shape.force(scale):
            scale = _DEPTH_RATIO * scale
        plain = float(scale) * np.geomspace(_MIN_DEPTH, _MAX_DEPTH, _TABLE_POINTS)
        radius = self.shape.radius(plain)
        depth = plain - np.sqrt(2.0 * math.pi * work * radius / modulus)
        return radius, depth, modulus * self.shape.force(plain) - tension(radius)
