"""Criteria for whether rough surfaces stick."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ase_roughcontact._util.validation import positive
from ase_roughcontact.theory.rough_contact import asperity_radius_from_curvature
from ase_roughcontact.theory.rough_flats import (
    KAPPA_HARD,
    flattening_energy,
    inverse_kappa_attractive,
)
from ase_roughcontact.theory.self_affine import (
    Roughness,
    numbers_of,
    rms_height,
    slope_to_curvature_ratio,
)

# Parameter of Fuller and Tabor at which the pull-off force is 4 % of its largest value.
_FULLER_TABOR_LIMIT = 10.0


@dataclass(frozen=True)
class Criterion:
    """Criterion for whether rough surfaces stick.

    Attributes
    ----------
    name : str
        Authors of the criterion.
    value : float
        Measure of roughness over adhesion (dimensionless).
    limit : float
        Value below which the surfaces stick.
    """

    name: str
    value: float
    limit: float

    @property
    def sticky(self) -> bool:
        """Whether the surfaces stick."""
        return self.value < self.limit

    def __str__(self) -> str:
        """Return the name, the result, the value and the limit."""
        result, sign = ("sticky", "<") if self.sticky else ("not sticky", ">=")
        return f"{self.name}: {result} ({self.value:.3g} {sign} {self.limit:g})"


def stickiness(
    roughness: Roughness,
    contact_modulus: float,
    work_of_adhesion: float,
    attraction_range: float,
    kappa_repulsive: float = KAPPA_HARD,
) -> tuple[Criterion, ...]:
    """Return criteria of the literature for whether rough surfaces stick.

    Parameters
    ----------
    roughness : Roughness
        Roughness, such as `ase_roughcontact.SelfAffine`.
    contact_modulus : float
        Contact modulus E* (force per area).
    work_of_adhesion : float
        Work of adhesion w (energy per area).
    attraction_range : float
        Range D of the attraction (length).
    kappa_repulsive : float
        Constant kappa without the attraction (dimensionless).

    Returns
    -------
    tuple of Criterion
        Fuller and Tabor, for independent asperities and a short range:
        E* sigma^(3/2)/(rho^(1/2) w), with the rms height sigma and the radius
        rho = 2/h'' of asperities. Each asperity is a sphere of JKR. At values of 1, 3
        and 10 their largest total tension is 73, 36 and 4 % of the tension at equal
        heights.

        Persson and Tosatti, for soft solids and a short range: `flattening_energy` over
        w. If the value is below one, full contact has less energy than no contact.

        Pastewka and Robbins, for stiff solids: 1/kappa_rep over
        `inverse_kappa_attractive`. If the value is below one, contact spreads without a
        load.

    Raises
    ------
    ValueError
        If an argument is not finite or out of range, or lambda_L < lambda_s.

    References
    ----------
    K. N. G. Fuller, D. Tabor, Proc. R. Soc. Lond. A 345, 327 (1975); B. N. J. Persson,
    E. Tosatti, J. Chem. Phys. 115, 5597 (2001); L. Pastewka, M. O. Robbins, Proc. Natl.
    Acad. Sci. USA 111, 3298 (2014).

    Examples
    --------
    >>> from ase_roughcontact import SelfAffine
    >>> from ase_roughcontact.theory import stickiness
    >>> surface = SelfAffine(0.1, 0.8, short_wavelength=4.0, long_wavelength=512.0)
    >>> [criterion.sticky for criterion in stickiness(surface, 1.0, 0.02, 0.5)]
    [False, False, True]
    """
    positive(
        contact_modulus=contact_modulus,
        work_of_adhesion=work_of_adhesion,
        kappa_repulsive=kappa_repulsive,
    )
    slope, _, _ = numbers_of(roughness)
    curvature = slope / slope_to_curvature_ratio(roughness)
    asperity = float(asperity_radius_from_curvature(curvature))
    height = rms_height(roughness)
    attraction = inverse_kappa_attractive(
        work_of_adhesion, contact_modulus, attraction_range, slope, curvature
    )
    stretching = contact_modulus * height * math.sqrt(height / asperity)
    flattening = flattening_energy(contact_modulus, roughness)
    return (
        Criterion("Fuller-Tabor", stretching / work_of_adhesion, _FULLER_TABOR_LIMIT),
        Criterion("Persson-Tosatti", flattening / work_of_adhesion, 1.0),
        Criterion("Pastewka-Robbins", float(1.0 / (kappa_repulsive * attraction)), 1.0),
    )
