"""Characteristic loads, lengths and energies of a rough sphere, and its law."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from ase_roughcontact._util.validation import positive
from ase_roughcontact.theory.maugis import sphere_theory
from ase_roughcontact.theory.rough_contact import (
    asperity_radius,
    crossover_load,
    first_contact_radius,
    predicted_area,
)
from ase_roughcontact.theory.rough_flats import (
    KAPPA_HARD,
    flattening_energy,
    inverse_kappa,
    mean_contact_pressure,
)
from ase_roughcontact.theory.self_affine import Roughness, numbers_of
from ase_roughcontact.theory.smooth_sphere import SphereTheory


@dataclass(frozen=True)
class RoughSphereTheory:
    """Characteristic loads, lengths and energies of a rough sphere.

    Parameters
    ----------
    radius : float
        Radius R of the sphere (length).
    contact_modulus : float
        Contact modulus E* (force per area).
    roughness : Roughness
        Roughness of the sphere, such as `ase_roughcontact.SelfAffine`.
    work_of_adhesion : float
        Work of adhesion w (energy per area).
    attraction_range : float, optional
        Range D of the attraction (length); required with adhesion.
    kappa_repulsive : float
        Constant kappa without the attraction: `KAPPA_HARD`, `KAPPA_REPULSIVE` or
        `compliant_kappa`.
    asperity_factor : float
        Factor by which the compliance of the wall increases rho: 1 for the hard wall,
        `ASPERITY_FACTOR_REPULSIVE` for the repulsive 9-3 wall.

    Raises
    ------
    ValueError
        If a number is not finite or out of range, or `attraction_range` is missing.

    References
    ----------
    L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016).
    """

    radius: float
    contact_modulus: float
    roughness: Roughness
    work_of_adhesion: float = 0.0
    attraction_range: float | None = None
    kappa_repulsive: float = KAPPA_HARD
    asperity_factor: float = 1.0

    def __post_init__(self) -> None:
        """Check the parameters."""
        positive(
            kappa_repulsive=self.kappa_repulsive, asperity_factor=self.asperity_factor
        )
        numbers_of(self.roughness)
        self._sphere(self.radius, self.work_of_adhesion)

    @cached_property
    def inverse_kappa(self) -> float:
        """Value of 1/kappa_adh; 1/kappa_rep without adhesion."""
        wall = self.work_of_adhesion, self.attraction_range, self.kappa_repulsive
        return inverse_kappa(self.contact_modulus, self.roughness, *wall)

    @property
    def sticky(self) -> bool:
        """Whether rough flats adhere macroscopically."""
        return self.inverse_kappa <= 0

    @property
    def kappa(self) -> float:
        """Value of kappa_adh; kappa_rep if rough flats adhere macroscopically."""
        return self.kappa_repulsive if self.sticky else 1 / self.inverse_kappa

    @property
    def rough_pressure(self) -> float:
        """Mean pressure p_rough in the contacts, with `kappa` (force per area)."""
        slope = self.roughness.rms_slope
        return float(mean_contact_pressure(slope, self.contact_modulus, self.kappa))

    @property
    def crossover_load(self) -> float:
        """Load N_c, with `kappa`, above which the sphere behaves as if smooth."""
        slope = self.roughness.rms_slope
        load = crossover_load(self.radius, self.contact_modulus, slope, self.kappa)
        return float(load)

    @property
    def asperity_radius(self) -> float:
        """Radius rho of the first asperity, at most R (length)."""
        return min(self.asperity_factor * asperity_radius(self.roughness), self.radius)

    @property
    def single_asperity(self) -> bool:
        """Whether the sphere is as sharp as an asperity of its roughness, R <= rho."""
        return self.asperity_radius == self.radius

    @property
    def asperity_load(self) -> float:
        """Load N_c(rho) below which one asperity carries the load."""
        return self.crossover_load * (self.asperity_radius / self.radius) ** 2

    @property
    def first_contact_radius(self) -> float:
        """Radius a' around the axis of the expected first contact (length)."""
        return float(first_contact_radius(self.radius, self.roughness))

    @property
    def effective_work_of_adhesion(self) -> float:
        """Work of adhesion minus `flattening_energy`, at least zero."""
        if self.single_asperity:
            return self.work_of_adhesion
        energy = flattening_energy(self.contact_modulus, self.roughness)
        return max(self.work_of_adhesion - energy, 0.0)

    @cached_property
    def smooth(self) -> SphereTheory:
        """Theory of the sphere if adhesion flattens its roughness."""
        return self._sphere(self.radius, self.effective_work_of_adhesion)

    def law(self, normal_force: float) -> str:
        """Return the name of the law at a force.

        Parameters
        ----------
        normal_force : float
            Normal force N >= 0 (force).

        Returns
        -------
        str
            "first asperity", "rough, linear", "sticky rough", or the name of a law of
            smooth spheres.
        """
        flattened = self.sticky and self.effective_work_of_adhesion > 0
        smooth = flattened or normal_force >= self.crossover_load
        if smooth or self.single_asperity:
            return self.smooth.law(normal_force)
        if self.sticky:
            return "sticky rough"
        if normal_force < self.asperity_load:
            return "first asperity"
        return "rough, linear"

    def area(self, normal_force: float) -> float | None:
        """Return the contact area at a force.

        Parameters
        ----------
        normal_force : float
            Normal force N >= 0 (force).

        Returns
        -------
        float or None
            Contact area A (area); None if rough flats adhere macroscopically, where
            `predicted_area` needs a tabulated contact fraction.

        Notes
        -----
        With adhesion, the first asperity is treated as a smooth adhesive sphere of
        radius rho, which underestimates the area at small loads.
        """
        law = self.law(normal_force)
        if self.single_asperity or law in ("JKR", "DMT", "Maugis-Dugdale"):
            return float(self.smooth.contact_area(normal_force))
        if law == "sticky rough":
            return None
        first = self._sphere(self.asperity_radius, self.work_of_adhesion)
        return float(
            predicted_area(
                normal_force,
                self.radius,
                self.contact_modulus,
                self.rough_pressure,
                asperity_radius=self.asperity_radius,
                asperity_area=first.contact_area(normal_force),
            )
        )

    def _sphere(self, radius: float, work: float) -> SphereTheory:
        return sphere_theory(radius, self.contact_modulus, work, self.attraction_range)
