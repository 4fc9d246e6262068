"""Closed forms for smooth and rough spheres on an elastic half space.

Smooth spheres: `Hertz`, `JKR`, `DMT` and `MaugisDugdale`, with the interface of
`SphereTheory`, and `sphere_theory`, which chooses between them; other shapes:
`indenters` and `ShapeTheory`. Rough surfaces: `self_affine` (spectral moments),
`rough_flats` (kappa, macroscopic adhesion), `stickiness` (criteria of adhesion),
`rough_contact` (first contact and area of rough spheres), `rough_sphere`
(characteristic numbers of a rough sphere), `plastic` (contact at the hardness) and
`regime`, which determines the law of contact.
"""

from ase_roughcontact.theory.jkr import JKR
from ase_roughcontact.theory.maugis import (
    DMT_BELOW,
    JKR_ABOVE,
    MaugisDugdale,
    sphere_theory,
)
from ase_roughcontact.theory.plastic import (
    plastic_area,
    plastic_contact_fraction,
    plastic_crossover_load,
    yield_load,
)
from ase_roughcontact.theory.regime import regime
from ase_roughcontact.theory.rough_contact import (
    ASPERITY_FACTOR_REPULSIVE,
    asperity_radius,
    asperity_radius_from_curvature,
    crossover_load,
    first_contact_radius,
    first_contact_radius_from_height,
    low_load_plateau,
    predicted_area,
)
from ase_roughcontact.theory.rough_flats import (
    KAPPA_HARD,
    KAPPA_PERSSON,
    KAPPA_REPULSIVE,
    compliant_kappa,
    contact_fraction,
    flattening_energy,
    inverse_kappa,
    inverse_kappa_attractive,
    mean_contact_pressure,
)
from ase_roughcontact.theory.rough_sphere import RoughSphereTheory
from ase_roughcontact.theory.self_affine import Roughness, slope_to_curvature_ratio
from ase_roughcontact.theory.shape_theory import ShapeTheory
from ase_roughcontact.theory.smooth_sphere import DMT, Hertz, SphereTheory
from ase_roughcontact.theory.stickiness import Criterion, stickiness

__all__ = [
    "ASPERITY_FACTOR_REPULSIVE",
    "DMT",
    "DMT_BELOW",
    "JKR",
    "JKR_ABOVE",
    "KAPPA_HARD",
    "KAPPA_PERSSON",
    "KAPPA_REPULSIVE",
    "Criterion",
    "Hertz",
    "MaugisDugdale",
    "RoughSphereTheory",
    "Roughness",
    "ShapeTheory",
    "SphereTheory",
    "asperity_radius",
    "asperity_radius_from_curvature",
    "compliant_kappa",
    "contact_fraction",
    "crossover_load",
    "first_contact_radius",
    "first_contact_radius_from_height",
    "flattening_energy",
    "inverse_kappa",
    "inverse_kappa_attractive",
    "low_load_plateau",
    "mean_contact_pressure",
    "plastic_area",
    "plastic_contact_fraction",
    "plastic_crossover_load",
    "predicted_area",
    "regime",
    "slope_to_curvature_ratio",
    "sphere_theory",
    "stickiness",
    "yield_load",
]
