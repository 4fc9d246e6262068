"""What the tables of a scene stand for, in ASE's units, and what theory says of it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace

import numpy as np
from ase.units import GPa, J, m
from numpy.typing import ArrayLike
from scipy.fft import next_fast_len

from ase_roughcontact import theory
from ase_roughcontact._util.validation import finite, positive
from ase_roughcontact.atoms.build import fcc_spacing
from ase_roughcontact.elasticity.material import contact_modulus, crystal_modulus
from ase_roughcontact.interactions import HardWall, Interaction, LennardJones93
from ase_roughcontact.scene.config import (
    InteractionConfig,
    PathConfig,
    RoughnessConfig,
    SolverConfig,
    SphereConfig,
    SubstrateConfig,
    choice,
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
        return RoughSphere(self.radius, self._rough(), given.profile)

    @property
    def wall(self) -> Interaction:
        """The interaction."""
        walls = {
            "hard": HardWall,
            "repulsive": lambda: LennardJones93.repulsive(
                self.contact_modulus, self.spacing
            ),
            "adhesive": lambda: LennardJones93.adhesive(
                self.contact_modulus, self.spacing, self._work
            ),
            "full": lambda: LennardJones93.full(
                self.spacing, self._work, cutoff=self._cutoff
            ),
        }
        kind, work = self.interaction.kind, self.interaction.work_of_adhesion
        make = choice(kind, walls, "kind of interaction")
        if work is not None and kind not in ("adhesive", "full"):
            raise ValueError(f"kind = {kind!r} has no work_of_adhesion, got {work}")
        cutoff = self.interaction.cutoff
        if cutoff is not None and kind != "full":
            raise ValueError(f"cutoff: only a full wall has one, got {cutoff}")
        return make()

    @property
    def _work(self) -> float:
        """Work of adhesion, which the wall needs (eV/Å^2)."""
        kind, work = self.interaction.kind, self.interaction.work_of_adhesion
        if work is None:
            raise ValueError(f"kind = {kind!r} needs a work_of_adhesion, J/m^2")
        positive(work_of_adhesion=work)
        return work * J / m**2

    @property
    def _cutoff(self) -> float | None:
        """Where a full wall ends, if that is given (Å)."""
        cutoff = self.interaction.cutoff
        if cutoff is None:
            return None
        finite(cutoff=cutoff)
        if not cutoff > 1.0:
            raise ValueError(
                f"cutoff must lie beyond 1 a0, where the energy is least, got {cutoff}"
            )
        return cutoff * self.spacing

    @property
    def attraction_range(self) -> float | None:
        """Gap over which the attraction decays, for the theory; None without (Å).

        Of a full wall, whose tail has no end, the distance of its minimum, which is the
        length in Tabor's parameter.
        """
        wall = self.wall
        if not (isinstance(wall, LennardJones93) and wall.attractive):
            return None
        full = self.interaction.kind == "full"
        return self.spacing if full else wall.attraction_range

    @property
    def inverse_kappa(self) -> float:
        """``1/kappa`` of the mean contact pressure ``h'rms E*/kappa``, for this wall.

        Not positive where rough flats would stick to each other.
        """
        wall = self.wall
        if not isinstance(wall, LennardJones93):
            return 1.0 / theory.KAPPA_HARD
        surface = self._rough()
        attraction_range = self.attraction_range
        if attraction_range is None or surface is None:
            return 1.0 / theory.KAPPA_REPULSIVE
        rough = surface.statistics()
        attraction = theory.inverse_kappa_attractive(
            wall.work_of_adhesion,
            self.contact_modulus,
            attraction_range,
            rough.rms_slope,
            rough.rms_curvature,
        )
        return float(theory.inverse_kappa_adhesive(theory.KAPPA_REPULSIVE, attraction))

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

    def _rough(self) -> SelfAffine | None:
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
