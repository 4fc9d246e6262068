"""A rough sphere by its characteristic numbers: when it is rough, sticky, or smooth."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

from ase_roughcontact._util.validation import FloatArray, positive
from ase_roughcontact.theory.rough import crossover_load, predicted_area
from ase_roughcontact.theory.rough_flats import (
    KAPPA_HARD,
    flattening_energy,
    inverse_kappa_adhesive,
    inverse_kappa_attractive,
    mean_contact_pressure,
    sticks,
)
from ase_roughcontact.theory.roughness import (
    asperity_radius,
    first_contact_radius,
    slope_to_curvature_ratio,
)
from ase_roughcontact.theory.smooth import SmoothContact, smooth_contact


class Roughness(Protocol):
    """Self-affine roughness, such as `ase_roughcontact.SelfAffine`.

    A `longest_wavelength` that it has is that of its roll-off, a length or None.
    """

    @property
    def rms_slope(self) -> float:
        """Rms slope h', dimensionless."""

    @property
    def hurst(self) -> float:
        """Hurst exponent H."""

    @property
    def short_wavelength(self) -> float:
        """Lower end lambda_s of the self-affine range, length."""

    @property
    def long_wavelength(self) -> float:
        """Upper end lambda_L of the self-affine range, length."""


@dataclass(frozen=True)
class RoughSphereTheory:
    """Scales of load, length and energy of a rough sphere.

    Parameters
    ----------
    radius : float
        R of the sphere, length.
    contact_modulus : float
        E*, force per area.
    roughness : Roughness
        Of the sphere, such as `ase_roughcontact.SelfAffine`.
    work_of_adhesion : float
        w, energy per area.
    attraction_range : float, optional
        D, gap over which the attraction decays, length; needed with adhesion.
    kappa_repulsive : float
        Without attraction: `KAPPA_HARD`, `KAPPA_REPULSIVE` or `compliant_kappa`.
    asperity_factor : float
        What the wall's compliance makes of rho: 1 for the hard wall,
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
        """Check what the formulas do not."""
        positive(
            kappa_repulsive=self.kappa_repulsive, asperity_factor=self.asperity_factor
        )
        self._smooth(0.0, self.radius, self.work_of_adhesion)

    @cached_property
    def inverse_kappa(self) -> float:
        """1/kappa_adh, dimensionless; 1/kappa_rep without adhesion."""
        if self.attraction_range is None or self.work_of_adhesion == 0:
            return 1 / self.kappa_repulsive
        slope = self.roughness.rms_slope
        width = slope_to_curvature_ratio(
            self.roughness.hurst, self.roughness.short_wavelength
        )
        attraction = inverse_kappa_attractive(
            self.work_of_adhesion,
            self.contact_modulus,
            self.attraction_range,
            slope,
            slope / width,
        )
        return float(inverse_kappa_adhesive(self.kappa_repulsive, attraction))

    @property
    def sticky(self) -> bool:
        """Whether rough flats adhere macroscopically."""
        return bool(sticks(self.inverse_kappa))

    @property
    def kappa(self) -> float:
        """kappa_adh, or where rough flats stick kappa_rep: what resists flattening."""
        return self.kappa_repulsive if self.sticky else 1 / self.inverse_kappa

    @property
    def rough_pressure(self) -> float:
        """p_rough for `kappa`, force per area."""
        slope = self.roughness.rms_slope
        return float(mean_contact_pressure(slope, self.contact_modulus, self.kappa))

    @property
    def crossover_load(self) -> float:
        """N_c for `kappa`, above which the sphere is as good as smooth; force."""
        return float(
            crossover_load(
                self.radius, self.contact_modulus, self.roughness.rms_slope, self.kappa
            )
        )

    @property
    def asperity_radius(self) -> float:
        """Radius rho of the first asperity, but at most R; length."""
        rough = self.roughness
        rho = asperity_radius(rough.rms_slope, rough.hurst, rough.short_wavelength)
        return min(self.asperity_factor * float(rho), self.radius)

    @property
    def single(self) -> bool:
        """Whether the sphere is sharper than its roughness, and its only asperity."""
        return self.asperity_radius == self.radius

    @property
    def asperity_load(self) -> float:
        """N_c(rho), below which one asperity carries the load; force."""
        return self.crossover_load * (self.asperity_radius / self.radius) ** 2

    @property
    def first_contact_radius(self) -> float:
        """Distance a' from the axis at which to find the first asperity, length."""
        rough = self.roughness
        return float(
            first_contact_radius(
                self.radius, rough.rms_slope, rough.hurst, rough.short_wavelength
            )
        )

    @property
    def effective_work_of_adhesion(self) -> float:
        """What flattening the roughness leaves of w, energy per area."""
        if self.single:
            return self.work_of_adhesion
        rough = self.roughness
        cost = flattening_energy(
            rough.rms_slope,
            self.contact_modulus,
            rough.hurst,
            rough.short_wavelength,
            rough.long_wavelength,
            getattr(rough, "longest_wavelength", None),
        )
        return max(self.work_of_adhesion - float(cost), 0.0)

    def smooth(self, normal_force: float) -> SmoothContact:
        """Contact of the sphere with its roughness flattened.

        Parameters
        ----------
        normal_force : float
            N >= 0, force.

        Returns
        -------
        SmoothContact
        """
        return self._smooth(normal_force, self.radius, self.effective_work_of_adhesion)

    def law(self, normal_force: float) -> str:
        """Name of the law that holds under a force.

        Parameters
        ----------
        normal_force : float
            N >= 0, force.

        Returns
        -------
        str
            "first asperity", "rough, linear", "sticky rough", or the name of a law of
            smooth spheres.
        """
        flattened = self.sticky and self.effective_work_of_adhesion > 0
        if self.single or flattened or normal_force >= self.crossover_load:
            return self.smooth(normal_force).law
        if self.sticky:
            return "sticky rough"
        lone = normal_force < self.asperity_load
        return "first asperity" if lone else "rough, linear"

    def area(
        self,
        normal_force: float,
        flat: Callable[[FloatArray], FloatArray] | None = None,
    ) -> float | None:
        """Contact area under a force.

        Parameters
        ----------
        normal_force : float
            N >= 0, force.
        flat : callable, optional
            Tabulated f(p), such as `FlatReference.fraction`.

        Returns
        -------
        float or None
            A, area; None where rough flats stick and `flat` is not given.

        Notes
        -----
        With adhesion, the first asperity is a smooth adhesive sphere of radius rho.
        That is a lower estimate at small loads: for R = 1000 a0, h' = 0.1 and
        w = 0.005 E* a0, three realisations had 780 a0^2 on average, not 102 (repulsive
        wall, rho three times eq. 6).
        """
        law = self.law(normal_force)
        if self.single or law in ("JKR", "DMT", "Maugis-Dugdale"):
            return self.smooth(normal_force).contact_area
        if law == "sticky rough" and flat is None:
            return None
        first = self._smooth(normal_force, self.asperity_radius, self.work_of_adhesion)
        return float(
            predicted_area(
                normal_force,
                self.radius,
                self.contact_modulus,
                self.rough_pressure if flat is None else flat,
                asperity_radius=self.asperity_radius,
                asperity_area=first.contact_area,
            )
        )

    def _smooth(self, normal_force: float, radius: float, work: float) -> SmoothContact:
        return smooth_contact(
            normal_force, radius, self.contact_modulus, work, self.attraction_range
        )
