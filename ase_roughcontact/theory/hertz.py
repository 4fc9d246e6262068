"""Hertz, without adhesion, and DMT, with an attraction outside of the contact."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ase_roughcontact._util.validation import FloatArray, nonnegative_array
from ase_roughcontact.theory.smooth_sphere import CURVE_POINTS, SphereTheory


@dataclass(frozen=True)
class Hertz(SphereTheory):
    """Hertz: a smooth sphere without adhesion; see `SphereTheory`.

    Parameters
    ----------
    radius : float
        R of the sphere, length.
    contact_modulus : float
        E*, force per area.

    References
    ----------
    K. L. Johnson, Contact Mechanics (Cambridge University Press, 1985), section 4.2.

    Examples
    --------
    >>> from ase_roughcontact.theory import Hertz
    >>> hertz = Hertz(radius=1000.0, contact_modulus=1.0)
    >>> round(float(hertz.contact_radius(10.0)), 3)
    19.574
    """

    radius: float
    contact_modulus: float
    work_of_adhesion = 0.0
    name = symbol = "Hertz"

    @property
    def pull_off_force(self) -> float:
        """Largest tension of a contact: zero."""
        return 0.0

    def contact_radius(self, normal_force: ArrayLike) -> FloatArray:
        """Return the contact radius, a = [3 (N + N_pull-off) R/4E*]^(1/3)."""
        return self._hertz_radius(self._above_pull_off(normal_force))

    def contact_radius_from_penetration(self, penetration: ArrayLike) -> FloatArray:
        """Return the contact radius for a given penetration, a = sqrt(R delta).

        Parameters
        ----------
        penetration : array_like
            delta >= 0, length.

        Returns
        -------
        ndarray
            a, length.
        """
        return np.sqrt(self.radius * nonnegative_array("penetration", penetration))

    def force(self, contact_radius: ArrayLike) -> FloatArray:
        """Return the force for a given contact radius, N = 4 E* a^3/3R - N_pull-off.

        Parameters
        ----------
        contact_radius : array_like
            a >= 0, length.

        Returns
        -------
        ndarray
            N, force.
        """
        cube = nonnegative_array("contact_radius", contact_radius) ** 3
        repulsive = 4 * self.contact_modulus * cube / (3 * self.radius)
        return repulsive - self.pull_off_force

    def penetration(self, contact_radius: ArrayLike) -> FloatArray:
        """Return the penetration for a given contact radius, delta = a^2/R.

        Parameters
        ----------
        contact_radius : array_like
            a >= 0, length.

        Returns
        -------
        ndarray
            delta, length.
        """
        return nonnegative_array("contact_radius", contact_radius) ** 2 / self.radius

    def pressure(self, distance: ArrayLike, contact_radius: float) -> FloatArray:
        """Return the pressure in the contact, p(r) = (2 E* a/pi R) sqrt(1 - r^2/a^2).

        Parameters
        ----------
        distance : array_like
            r >= 0 from the axis of the sphere, length.
        contact_radius : float
            a, length.

        Returns
        -------
        ndarray
            p, force per area, zero beyond a.
        """
        distance = nonnegative_array("distance", distance)
        radius = nonnegative_array("contact_radius", contact_radius)
        chord = np.sqrt(np.maximum(radius**2 - distance**2, 0.0))
        return 2 * self.contact_modulus / (np.pi * self.radius) * chord

    def curve(self, largest: float) -> tuple[FloatArray, FloatArray]:
        """Return penetrations and forces; see `SphereTheory.curve`."""
        a = np.linspace(0.0, largest, CURVE_POINTS)
        return self.penetration(a), self.force(a)


@dataclass(frozen=True)
class DMT(Hertz):
    """Derjaguin, Muller and Toporov: a small and stiff sphere; see `SphereTheory`.

    The attraction acts outside of the contact and adds its force to the load, while the
    contact remains that of Hertz.

    Parameters
    ----------
    radius : float
        R of the sphere, length.
    contact_modulus : float
        E*, force per area.
    work_of_adhesion : float
        w, energy per area.

    References
    ----------
    B. V. Derjaguin, V. M. Muller, Y. P. Toporov, J. Colloid Interface Sci. 53, 314
    (1975); D. Maugis, J. Colloid Interface Sci. 150, 243 (1992).
    """

    work_of_adhesion: float
    name = symbol = "DMT"

    @property
    def pull_off_force(self) -> float:
        """Largest tension of a contact, 2 pi w R."""
        return 2 * np.pi * self.work_of_adhesion * self.radius
