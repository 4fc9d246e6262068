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
from ase_roughcontact._util.validation import FloatArray, finite_array, unmasked
from ase_roughcontact.theory.indenters import Indenter
from ase_roughcontact.theory.smooth_sphere import CURVE_POINTS

# Smallest depth without adhesion in the search for the pull-off, in units of a depth
# beyond which there is no tension.
_MIN_DEPTH = 1e-6
# Number of depths in this search, and in a curve.
_TABLE_POINTS = 4000
# Ratio of depths in the search for a depth without tension.
_DEPTH_RATIO = 1.25
# Quantities of an adhesive contact, and their positions.
_QUANTITIES = "penetration", "normal_force"
_PENETRATION, _FORCE = 0, 1
# Number of halvings of an interval of depths: to rounding.
_HALVINGS = 60


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
        return -float(self._contact(self._plain_at_pull_off[1])[1])

    @property
    def pull_off_penetration(self) -> float:
        """Penetration at pull-off of a tip at a given height (Å); zero if w is zero."""
        if not self.work_of_adhesion:
            return 0.0
        return float(self._contact(self._plain_at_pull_off[0])[0])

    def penetration_under(self, normal_force: float) -> float:
        """Return the penetration of the stable contact under a force (Å)."""
        if not self.work_of_adhesion:
            return float(self.shape.depth(normal_force / self.contact_modulus))
        return float(self._contact(self._plain_depth(normal_force, _FORCE))[0])

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
        return self.shape.radius(self._plain_depth(force, _FORCE))

    def contact_area(self, normal_force: ArrayLike) -> FloatArray:
        """Return the area of the stable contact; see `SphereTheory.contact_area`."""
        force = unmasked(normal_force).astype(float)
        exists = force >= -self.pull_off_force
        radius = self.contact_radius(np.where(exists, force, 0.0))
        return np.where(exists, self.shape.contact_area(radius), np.nan)

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
        first = self._plain_at_pull_off[0]
        if not penetration > self.pull_off_penetration:
            return np.empty(0), np.empty(0)
        last = float(self._plain_depth(penetration, _PENETRATION))
        return self._contact(np.geomspace(first, last, _TABLE_POINTS))

    @cached_property
    def _plain_at_pull_off(self) -> tuple[float, float]:
        """Depths without adhesion at the least penetration, and at the least force."""
        highest = self.work_of_adhesion / self.contact_modulus
        while self._contact(highest)[_FORCE] < 0.0:
            highest *= _DEPTH_RATIO
        plain = highest * np.geomspace(_MIN_DEPTH, 1.0, _TABLE_POINTS)
        penetration, force = self._contact(plain)
        return float(plain[penetration.argmin()]), float(plain[force.argmin()])

    def _plain_depth(self, values: ArrayLike, quantity: int) -> FloatArray:
        """Return the depths without adhesion of stable contacts by bisection.

        Parameters
        ----------
        values : array_like
            Penetrations (Å) or forces (eV/Å), at least the value at pull-off.
        quantity : int
            Position of the quantity in `_QUANTITIES`.

        Returns
        -------
        ndarray, shape of `values`
            Depths (Å).
        """
        values = finite_array(_QUANTITIES[quantity], values)
        low = np.full(values.shape, self._plain_at_pull_off[quantity])
        high = 2.0 * low
        while np.any(below := self._contact(high)[quantity] < values):
            high = np.where(below, 2.0 * high, high)
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            below = self._contact(middle)[quantity] < values
            low, high = np.where(below, middle, low), np.where(below, high, middle)
        return high

    def _contact(self, plain: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return penetrations (Å) and forces (eV/Å) at depths without adhesion."""
        plain = np.asarray(plain, float)
        modulus, work = self.contact_modulus, self.work_of_adhesion
        radius = self.shape.radius(plain)
        tension = np.sqrt(8.0 * math.pi * modulus * work * radius**3)
        penetration = plain - np.sqrt(2.0 * math.pi * work * radius / modulus)
        return penetration, modulus * self.shape.force(plain) - tension
