"""Theory of Johnson, Kendall and Roberts: a large and soft adhesive sphere."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ase_roughcontact._util.validation import (
    FloatArray,
    finite_array,
    nonnegative_array,
)
from ase_roughcontact.theory.smooth_sphere import CURVE_POINTS, SphereTheory


@dataclass(frozen=True)
class JKR(SphereTheory):
    """Johnson, Kendall and Roberts: a large and soft sphere; see `SphereTheory`.

    The attraction has no range: it acts only inside the contact.

    Parameters
    ----------
    radius : float
        Radius R of the sphere (length).
    contact_modulus : float
        Contact modulus E* (force per area).
    work_of_adhesion : float
        Work of adhesion w (energy per area).

    References
    ----------
    K. L. Johnson, K. Kendall, A. D. Roberts, Proc. R. Soc. Lond. A 324, 301 (1971);
    K. L. Johnson, Contact Mechanics (Cambridge University Press, 1985), section 5.5.
    """

    radius: float
    contact_modulus: float
    work_of_adhesion: float
    name = symbol = "JKR"

    @property
    def pull_off_force(self) -> float:
        """Largest tension of a contact, (3/2) pi w R."""
        return 1.5 * np.pi * self.work_of_adhesion * self.radius

    @property
    def pull_off_penetration(self) -> float:
        """Smallest penetration of a contact, -(3/4) (pi^2 w^2 R/E*^2)^(1/3).

        The contact, with a^3 = pi w R^2/8E*, is lost there under displacement control.
        """
        length = np.pi * self.work_of_adhesion / self.contact_modulus
        return float(-0.75 * np.cbrt(length**2 * self.radius))

    def contact_radius(self, normal_force: ArrayLike) -> FloatArray:
        """Return the radius of the stable contact; see `SphereTheory.contact_radius`.

        a^3 = (3R/4E*) [N + 3 pi w R + sqrt(6 pi w R N + (3 pi w R)^2)].
        """
        # the bracket is the square of sqrt(N + P) + sqrt(P), with P = 1.5 pi w R
        root = np.sqrt(self._above_pull_off(normal_force))
        root += np.sqrt(self.pull_off_force)
        return self._hertz_radius(root**2)

    def contact_radius_from_penetration(self, penetration: ArrayLike) -> FloatArray:
        """Return the radius of the stable contact for a given penetration.

        Notes
        -----
        With the radius a1 at the smallest penetration, -3 a1^2/R, `penetration` is the
        quartic x^4 - 4 x = d of x = sqrt(a/a1), with d = delta R/a1^2. Its resolvent
        m^3 + d m = 2 (Ferrari) has one positive root for d >= -3, and
        x = sqrt(m/2) + sqrt(sqrt(2/m) - m/2).
        """
        least = self.pull_off_penetration
        d = -3 * finite_array("penetration", penetration) / least
        if not np.all(d >= -3 * (1 + 1e-12)):
            raise ValueError(
                f"penetration must be at least {least}, where the contact is lost, "
                f"got {penetration!r}"
            )
        d = np.maximum(d, -3.0)
        u = np.cbrt(1 + np.sqrt(1 + (d / 3) ** 3)) ** 2
        m = 2 / (u + d / 3 + (d / 3) ** 2 / u)
        x = np.sqrt(m / 2) + np.sqrt(np.maximum(np.sqrt(2 / m) - m / 2, 0.0))
        return np.sqrt(-least / 3 * self.radius) * x**2

    def force(self, contact_radius: ArrayLike) -> FloatArray:
        """Return the force for a given radius, N = 4 E* a^3/3R - sqrt(8 pi w E* a^3).

        Contacts with a^3 < 9 pi w R^2/8E* are on the unstable branch at a given force.
        """
        cube = nonnegative_array("contact_radius", contact_radius) ** 3
        repulsive = 4 * self.contact_modulus * cube / (3 * self.radius)
        attraction = 8 * np.pi * self.work_of_adhesion * self.contact_modulus * cube
        return repulsive - np.sqrt(attraction)

    def penetration(self, contact_radius: ArrayLike) -> FloatArray:
        """Return the penetration for a given radius, a^2/R - sqrt(2 pi w a/E*).

        Contacts with a^3 < pi w R^2/8E* are on the unstable branch at a given
        penetration.
        """
        a = nonnegative_array("contact_radius", contact_radius)
        square = 2 * np.pi * self.work_of_adhesion * a / self.contact_modulus
        return a**2 / self.radius - np.sqrt(square)

    def curve(self, largest: float) -> tuple[FloatArray, FloatArray]:
        """Return penetrations and forces; see `SphereTheory.curve`."""
        depth = self.pull_off_penetration
        smallest = float(self.contact_radius_from_penetration(depth))
        a = np.linspace(smallest, max(largest, smallest), CURVE_POINTS)
        return self.penetration(a), self.force(a)
