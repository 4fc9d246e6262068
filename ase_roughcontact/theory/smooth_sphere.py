"""Smooth rigid spheres on an elastic half space: base class, Hertz and DMT."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import (
    FloatArray,
    finite_array,
    nonnegative_array,
    positive,
    unmasked,
)

#: Number of points of a curve of force against penetration.
CURVE_POINTS = 400

#: Relative increase of the area by adhesion below which the law is called Hertz.
NEGLIGIBLE_ADHESION = 0.1


class SphereTheory(ABC):
    """Theory of a smooth rigid sphere on an elastic half space.

    Any consistent system of units will do; only `label` and `sphere` assume the units
    of ASE. Methods accept numbers and arrays, return arrays of the same shape, and
    raise `ValueError` for an argument that is not finite, of the wrong sign, or without
    a contact.

    Attributes
    ----------
    radius : float
        Radius R of the sphere (length).
    contact_modulus : float
        Contact modulus E* = E/(1 - nu^2) (force per area).
    work_of_adhesion : float
        Work of adhesion w (energy per area); zero for Hertz.
    name : str
        Name of the theory.
    symbol : str
        Subscript of quantities that follow from the theory, as in A_Hertz.
    """

    radius: float
    contact_modulus: float
    work_of_adhesion: float
    name: ClassVar[str]
    symbol: ClassVar[str]

    def __post_init__(self) -> None:
        """Check the parameters."""
        positive(**vars(self))

    @property
    @abstractmethod
    def pull_off_force(self) -> float:
        """Largest tension of a contact, zero without adhesion."""

    @property
    @abstractmethod
    def pull_off_penetration(self) -> float:
        """Smallest penetration of a contact that is stable at a given height."""

    @abstractmethod
    def contact_radius(self, normal_force: ArrayLike) -> FloatArray:
        """Return the radius of the stable contact.

        Parameters
        ----------
        normal_force : array_like
            Normal force N (force), at least the negative pull-off force.

        Returns
        -------
        ndarray
            Contact radius a (length).
        """

    @abstractmethod
    def contact_radius_from_penetration(self, penetration: ArrayLike) -> FloatArray:
        """Return the radius of the contact that is stable at a given height.

        Parameters
        ----------
        penetration : array_like
            Penetration delta (length), at least `pull_off_penetration`.

        Returns
        -------
        ndarray
            Contact radius a (length).
        """

    @abstractmethod
    def force(self, contact_radius: ArrayLike) -> FloatArray:
        """Return the force for a given contact radius.

        Parameters
        ----------
        contact_radius : array_like
            Contact radius a >= 0 (length).

        Returns
        -------
        ndarray
            Normal force N (force).
        """

    @abstractmethod
    def penetration(self, contact_radius: ArrayLike) -> FloatArray:
        """Return the penetration for a given contact radius.

        Parameters
        ----------
        contact_radius : array_like
            Contact radius a >= 0 (length).

        Returns
        -------
        ndarray
            Penetration delta (length).
        """

    def penetration_under(self, normal_force: ArrayLike) -> FloatArray:
        """Return the penetration of the stable contact under a force.

        Parameters
        ----------
        normal_force : array_like
            Normal force N (force), at least the negative pull-off force.

        Returns
        -------
        ndarray
            Penetration delta (length).
        """
        return self.penetration(self.contact_radius(normal_force))

    @abstractmethod
    def curve(self, largest: float) -> tuple[FloatArray, FloatArray]:
        """Return a curve of force against penetration, for figures.

        The curve begins at the smallest contact that is stable at a given height.

        Parameters
        ----------
        largest : float
            Contact radius at which the curve ends (length).

        Returns
        -------
        penetration, force : ndarray
            Penetrations (length) and normal forces (force) of the points.
        """

    def contact_area(self, normal_force: ArrayLike) -> FloatArray:
        """Return the area of the stable contact.

        Parameters
        ----------
        normal_force : array_like
            Normal force N (force).

        Returns
        -------
        ndarray
            Contact area A = pi a^2 (area); NaN for tensions above the pull-off force.
        """
        force = unmasked(normal_force).astype(float)
        exists = force >= -self.pull_off_force
        radius = self.contact_radius(np.where(exists, force, 0.0))
        return np.where(exists, np.pi * radius**2, np.nan)

    def law(self, normal_force: float) -> str:
        """Return the name of the simplest theory that is accurate at a force.

        Parameters
        ----------
        normal_force : float
            Normal force N (force), at least the negative pull-off force.

        Returns
        -------
        str
            "Hertz" if adhesion increases the area by less than a tenth, else `name`.
        """
        hertz = self._hertz_radius(max(normal_force, 0.0))
        square = self.contact_radius(normal_force) ** 2
        negligible = square < (1 + NEGLIGIBLE_ADHESION) * hertz**2
        return "Hertz" if negligible else self.name

    @property
    def sphere(self) -> str:
        """Words for the sphere and its work of adhesion in J/m^2, for output."""
        work = self.work_of_adhesion / UNITS["J/m^2"]
        return "smooth sphere" + (f", w = {work:.3g} J/m²" if work else "")

    @property
    def label(self) -> str:
        """Name and sphere, for legends and printed output."""
        return f"{self.name}: theory, {self.sphere}"

    def _hertz_radius(self, normal_force: ArrayLike) -> FloatArray:
        scaled = 0.75 * unmasked(normal_force).astype(float) * self.radius
        return np.cbrt(scaled / self.contact_modulus)

    def _above_pull_off(self, normal_force: ArrayLike) -> FloatArray:
        """Return the force above pull-off; rounding at pull-off counts as zero."""
        excess = finite_array("normal_force", normal_force) + self.pull_off_force
        if not np.all(excess >= -1e-12 * self.pull_off_force):
            raise ValueError(
                "normal_force must not be below the negative pull-off force "
                f"{-self.pull_off_force}, got {normal_force!r}"
            )
        return np.maximum(excess, 0.0)


@dataclass(frozen=True)
class Hertz(SphereTheory):
    """Hertz: a smooth sphere without adhesion; see `SphereTheory`.

    Parameters
    ----------
    radius : float
        Radius R of the sphere (length).
    contact_modulus : float
        Contact modulus E* (force per area).

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

    @property
    def pull_off_penetration(self) -> float:
        """Smallest penetration of a contact: zero."""
        return 0.0

    def contact_radius(self, normal_force: ArrayLike) -> FloatArray:
        """Return the contact radius, a = [3 (N + N_pull-off) R/4E*]^(1/3)."""
        return self._hertz_radius(self._above_pull_off(normal_force))

    def contact_radius_from_penetration(self, penetration: ArrayLike) -> FloatArray:
        """Return the contact radius at a penetration, a = sqrt(R delta)."""
        return np.sqrt(self.radius * nonnegative_array("penetration", penetration))

    def force(self, contact_radius: ArrayLike) -> FloatArray:
        """Return the force at a contact radius, N = 4 E* a^3/3R - N_pull-off."""
        cube = nonnegative_array("contact_radius", contact_radius) ** 3
        repulsive = 4 * self.contact_modulus * cube / (3 * self.radius)
        return repulsive - self.pull_off_force

    def penetration(self, contact_radius: ArrayLike) -> FloatArray:
        """Return the penetration at a contact radius, delta = a^2/R."""
        return nonnegative_array("contact_radius", contact_radius) ** 2 / self.radius

    def pressure(self, distance: ArrayLike, contact_radius: float) -> FloatArray:
        """Return the pressure in the contact, p(r) = (2 E* a/pi R) sqrt(1 - r^2/a^2).

        Parameters
        ----------
        distance : array_like
            Distance r >= 0 from the axis of the sphere (length).
        contact_radius : float
            Contact radius a (length).

        Returns
        -------
        ndarray
            Pressure p (force per area), zero beyond a.
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

    The attraction acts outside of the contact, and its force adds to the load of a
    contact after Hertz.

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
    B. V. Derjaguin, V. M. Muller, Y. P. Toporov, J. Colloid Interface Sci. 53, 314
    (1975); D. Maugis, J. Colloid Interface Sci. 150, 243 (1992).
    """

    work_of_adhesion: float
    name = symbol = "DMT"

    @property
    def pull_off_force(self) -> float:
        """Largest tension of a contact, 2 pi w R."""
        return 2 * np.pi * self.work_of_adhesion * self.radius
