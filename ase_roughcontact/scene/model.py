"""What the tables of a scene stand for, in ASE's units, and what theory says of it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace

import numpy as np
from ase.units import GPa
from numpy.typing import ArrayLike
from scipy.fft import next_fast_len

from ase_roughcontact import theory
from ase_roughcontact._util.validation import positive
from ase_roughcontact.atoms.build import fcc_spacing
from ase_roughcontact.elasticity.material import contact_modulus, crystal_modulus
from ase_roughcontact.interactions import Interaction, make_wall
from ase_roughcontact.scene.config import (
    InteractionConfig,
    PathConfig,
    RoughnessConfig,
    SolverConfig,
    SphereConfig,
    SubstrateConfig,
)
from ase_roughcontact.topography import RoughSphere, SelfAffine

# Modulus that no solid has (GPa): one beyond it is in other units.
_STIFFEST = 1e4
# Part of a spacing that a domain may differ from a whole number of them.
_WHOLE = 1e-6
# Keys of [roughness] in units of the spacing.
_LENGTHS = "short_wavelength", "long_wavelength", "longest_wavelength", "domain"


@dataclass(frozen=True)
class Model:
    """Sphere, material and wall of a scene; see `Scene`."""

    substrate: SubstrateConfig = field(default_factory=SubstrateConfig)
    sphere: SphereConfig = field(default_factory=SphereConfig)
    roughness: RoughnessConfig | None = None
    interaction: InteractionConfig = field(default_factory=InteractionConfig)
    path: PathConfig = field(default_factory=PathConfig)
    solver: SolverConfig = field(default_factory=SolverConfig)

    @property
    def spacing(self) -> float:
        """Atomic spacing a0 (Å)."""
        given = self.substrate.spacing
        if given is None:
            return _of_crystal(fcc_spacing, self.substrate.symbol, "spacing")
        positive(spacing=given)
        return given

    @property
    def contact_modulus(self) -> float:
        """E* (eV/Å^3): given, from elastic constants, or of the crystal."""
        given = self.substrate
        if given.contact_modulus is not None and given.elastic_constants is not None:
            raise ValueError("give contact_modulus or elastic_constants, not both")
        if given.elastic_constants is not None:
            return contact_modulus(given.elastic_constants) * GPa
        if given.contact_modulus is not None:
            positive(contact_modulus=given.contact_modulus)
            if given.contact_modulus > _STIFFEST:
                raise ValueError(
                    f"contact_modulus is in GPa, at most {_STIFFEST:g}, got "
                    f"{given.contact_modulus:g}"
                )
            return given.contact_modulus * GPa
        symbol, instead = given.symbol, "contact_modulus or elastic_constants"
        return _of_crystal(crystal_modulus, symbol, instead) * GPa

    @property
    def radius(self) -> float:
        """Radius of the sphere (Å)."""
        positive(radius=self.sphere.radius)
        return self.sphere.radius * self.spacing

    @property
    def surface(self) -> RoughSphere:
        """The indenter's surface."""
        given = self.sphere
        return RoughSphere(self.radius, self.self_affine, given.profile)

    @property
    def wall(self) -> Interaction:
        """The interaction."""
        given = self.interaction
        return make_wall(
            given.kind, self.contact_modulus, self.spacing, given.parameters
        )

    @property
    def kappa_repulsive(self) -> float:
        """Kappa of the mean contact pressure ``h'rms E*/kappa``, without attraction."""
        wall = self.wall
        if wall.kappa is not None:
            return wall.kappa
        return theory.KAPPA_HARD if wall.hard else theory.KAPPA_REPULSIVE

    @property
    def inverse_kappa(self) -> float:
        """``1/kappa`` of the mean contact pressure ``h'rms E*/kappa``, for this wall.

        Not positive where rough flats would stick to each other.
        """
        wall, surface = self.wall, self.self_affine
        if not wall.attractive or surface is None:
            return 1.0 / self.kappa_repulsive
        rough = surface.statistics()
        attraction = theory.inverse_kappa_attractive(
            wall.work_of_adhesion,
            self.contact_modulus,
            wall.attraction_range,
            rough.rms_slope,
            rough.rms_curvature,
        )
        return float(theory.inverse_kappa_adhesive(self.kappa_repulsive, attraction))

    def predicted_area(self, normal_force: ArrayLike) -> np.ndarray:
        """Contact area by Eq. (4) of the paper, or of Hertz for a smooth sphere.

        Adhesion is in it as a change of kappa; NaN where it is so strong that the law
        does not hold.

        Parameters
        ----------
        normal_force : array_like
            eV/Å.

        Returns
        -------
        ndarray
            Å^2.

        References
        ----------
        L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016), Eq. (4).
        """
        if self.roughness is None:
            return self.hertz_area(normal_force)
        if self.inverse_kappa <= 0.0:
            return np.full(np.shape(normal_force), np.nan)
        pressure = theory.mean_contact_pressure(
            self.roughness.rms_slope, self.contact_modulus, 1.0 / self.inverse_kappa
        )
        return theory.contact_area(
            normal_force, self.radius, self.contact_modulus, pressure
        )

    def hertz_area(self, normal_force: ArrayLike) -> np.ndarray:
        """Contact area of the smooth sphere, without adhesion.

        Parameters
        ----------
        normal_force : array_like
            eV/Å.

        Returns
        -------
        ndarray
            Å^2.
        """
        return theory.hertz_contact_area(
            normal_force, self.radius, self.contact_modulus
        )

    @property
    def self_affine(self) -> SelfAffine | None:
        """Roughness of the sphere; None if it is smooth."""
        if self.roughness is None:
            return None
        given = SelfAffine(**asdict(self.roughness))  # checked in units of the file
        given = replace(given, domain=_domain(given))
        lengths = {
            name: getattr(given, name) * self.spacing
            for name in _LENGTHS
            if getattr(given, name) is not None
        }
        return replace(given, **lengths)


def _domain(rough: SelfAffine) -> float | None:
    """Return the domain as it is, or one of whole spacings where none is given (a0)."""
    if rough.short_wavelength < 2.0 - _WHOLE:
        raise ValueError(
            "short_wavelength must be at least 2 a0, or atoms a0 apart can't show it, "
            f"got {rough.short_wavelength:g}"
        )
    whole = abs(rough.side - round(rough.side)) <= _WHOLE
    if whole:
        return rough.domain
    points = math.ceil(rough.side)
    if rough.domain is not None:
        raise ValueError(
            f"domain must be a whole number of a0, got {rough.domain:g}: give {points}"
        )
    return float(next_fast_len(points))


def _of_crystal(known: Callable[[str], float], symbol: str, instead: str) -> float:
    """Return a number of a crystal, or say what to give where it is not known."""
    try:
        return known(symbol)
    except ValueError as error:
        raise ValueError(f"symbol = {symbol!r}: give {instead}: {error}") from error
