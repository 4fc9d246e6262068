"""Law of contact for a sphere of given size, roughness and adhesion."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from typing import Any

from ase_roughcontact._util.validation import finite, nonnegative, positive
from ase_roughcontact.theory.maugis import MaugisDugdale, sphere_theory
from ase_roughcontact.theory.rough_flats import KAPPA_HARD
from ase_roughcontact.theory.rough_sphere import RoughSphereTheory
from ase_roughcontact.theory.self_affine import Roughness
from ase_roughcontact.theory.smooth_sphere import Hertz
from ase_roughcontact.theory.stickiness import Criterion, stickiness

#: Description of each law of contact, by its name.
LAWS = {
    "Hertz": "smooth sphere without adhesion, A = pi (3 N R/4E*)^(2/3)",
    "JKR": "smooth sphere, short-ranged adhesion, theory.JKR",
    "DMT": "smooth sphere, long-ranged adhesion, theory.DMT",
    "Maugis-Dugdale": "smooth sphere, intermediate, theory.MaugisDugdale",
    "first asperity": "smooth sphere with the radius rho of the first asperity",
    "rough, linear": "many asperities as on rough flats, A = N/p_rough",
    "sticky rough": "macroscopic adhesion of rough flats, f(p) must be tabulated",
}


def _number(description: str) -> Any:
    return field(default=None, metadata={"description": description})


@dataclass(frozen=True, kw_only=True)
class Regime:
    """Law of contact and the characteristic numbers that determine it.

    ``str()`` of the object describes all of them. A number that is not defined for the
    sphere is None.

    Attributes
    ----------
    law : str
        One of "first asperity", "rough, linear", "Hertz", "JKR", "DMT",
        "Maugis-Dugdale" and "sticky rough".
    contact_area : float
        Predicted contact area A (area); None for "sticky rough", see `predicted_area`.
    mean_pressure : float
        Mean pressure N/A in the contact (force per area).
    hertz_radius : float
        Contact radius of a smooth sphere without adhesion (length).
    tabor_parameter, maugis_parameter : float
        Parameters of a smooth sphere with the effective work of adhesion.
    pull_off_force : float
        Pull-off force of a smooth sphere with the effective work of adhesion (force).
    effective_work_of_adhesion : float
        Work of adhesion w minus the energy of flattening the roughness (energy per
        area).
    inverse_kappa : float
        Inverse 1/kappa_adh; rough flats adhere macroscopically if it is not positive.
    rough_pressure : float
        Mean pressure p_rough in the contacts of rough flats (force per area).
    asperity_radius : float
        Radius rho of the first asperity (length).
    first_contact_radius : float
        Radius a' around the axis of the expected first contact (length).
    crossover_ratio : float
        Ratio N/N_c; above one the sphere behaves as if smooth.
    asperity_ratio : float
        Ratio N/N_c(rho); below one a single asperity carries the load.
    linear_decades : float
        Number of decades of load from N_c(rho) to N_c, where the area is linear in
        load.
    criteria : tuple of Criterion
        Criteria for `stickiness` of a rough sphere with adhesion, by several theories.
    """

    law: str
    contact_area: float | None = _number("predicted contact area")
    mean_pressure: float | None = _number("mean pressure in the contact")
    hertz_radius: float | None = _number("contact radius of Hertz' theory")
    tabor_parameter: float | None = _number("Tabor's parameter")
    maugis_parameter: float | None = _number("Maugis' parameter (DMT < 0.1, JKR > 5)")
    pull_off_force: float | None = _number("pull-off force")
    effective_work_of_adhesion: float | None = _number("effective work of adhesion")
    inverse_kappa: float | None = _number("1/kappa (rough flats adhere if <= 0)")
    rough_pressure: float | None = _number("mean pressure p_rough of rough flats")
    asperity_radius: float | None = _number("radius rho of the first asperity")
    first_contact_radius: float | None = _number("radius a' of first contact")
    crossover_ratio: float | None = _number("N/N_c (like a smooth sphere if > 1)")
    asperity_ratio: float | None = _number("N/N_c(rho) (one asperity if < 1)")
    linear_decades: float | None = _number("decades of load with A ~ N")
    criteria: tuple[Criterion, ...] = ()

    def __str__(self) -> str:
        """Return the law and its numbers, one on each line."""
        lines = [f"{self.law}: {LAWS[self.law]}"]
        for each in fields(self):
            value = getattr(self, each.name)
            if each.metadata and value is not None:
                lines.append(f"  {each.metadata['description']:<40s} {value:.4g}")
        return "\n".join([*lines, *(f"  {criterion}" for criterion in self.criteria)])


def regime(
    normal_force: float,
    radius: float,
    contact_modulus: float,
    roughness: Roughness | None = None,
    *,
    work_of_adhesion: float = 0.0,
    attraction_range: float | None = None,
    kappa_repulsive: float = KAPPA_HARD,
    asperity_factor: float = 1.0,
) -> Regime:
    """Determine the law of contact of a sphere.

    Parameters
    ----------
    normal_force : float
        Normal force N (force); negative only for a smooth sphere with adhesion.
    radius, contact_modulus, roughness, work_of_adhesion, attraction_range
        See `RoughSphereTheory`; without a roughness the sphere is smooth.
    kappa_repulsive, asperity_factor : float
        See `RoughSphereTheory`.

    Returns
    -------
    Regime
        The law, and the numbers that determine it.

    Raises
    ------
    ValueError
        If an argument is out of range or missing, or the force is below the pull-off
        force.

    Notes
    -----
    `sphere_theory` describes smooth spheres, rough spheres above N_c, and rough spheres
    that are sharper than their roughness, R <= rho. Below N_c(rho) one asperity carries
    the load; between N_c(rho) and N_c the area is linear in load. Adhesion changes
    kappa. If the work of adhesion exceeds `flattening_energy`, a sticky rough sphere
    behaves like a smooth one with the difference as work of adhesion. Otherwise there
    is no closed form for a sticky sphere below the N_c of the wall without attraction.

    References
    ----------
    L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016).

    Examples
    --------
    An AFM tip on a polymer in nm, nN and GPa, with 50 mJ/m^2 over a range of 0.3 nm:

    >>> tip = regime(10, 30, 10, work_of_adhesion=0.05, attraction_range=0.3)
    >>> print(str(tip).splitlines()[0])
    Maugis-Dugdale: smooth sphere, intermediate, theory.MaugisDugdale
    """
    positive(kappa_repulsive=kappa_repulsive, asperity_factor=asperity_factor)
    finite(normal_force=normal_force)
    nonnegative(work_of_adhesion=work_of_adhesion)
    reach = attraction_range if work_of_adhesion > 0 else None
    numbers: dict[str, Any]
    if roughness is None:
        smooth = sphere_theory(
            radius, contact_modulus, work_of_adhesion, attraction_range
        )
        area = float(smooth.contact_area(normal_force))
        numbers = {"law": smooth.law(normal_force), "contact_area": area}
    else:
        nonnegative(normal_force=normal_force)
        sphere = RoughSphereTheory(
            radius,
            contact_modulus,
            roughness,
            work_of_adhesion,
            attraction_range,
            kappa_repulsive,
            asperity_factor,
        )
        smooth, numbers = sphere.smooth, _rough_numbers(sphere, normal_force)
        if reach is not None:
            numbers["criteria"] = stickiness(
                roughness, contact_modulus, work_of_adhesion, reach, kappa_repulsive
            )
    work = smooth.work_of_adhesion
    if reach is not None:
        numbers["effective_work_of_adhesion"] = work
    if reach is not None and work > 0:
        general = MaugisDugdale(radius, contact_modulus, work, reach)
        numbers["tabor_parameter"] = general.tabor_parameter
        numbers["maugis_parameter"] = general.parameter
        numbers["pull_off_force"] = smooth.pull_off_force
    area = numbers["contact_area"]
    hertz = Hertz(radius, contact_modulus).contact_radius(max(normal_force, 0.0))
    return Regime(
        mean_pressure=normal_force / area if area else None,
        hertz_radius=float(hertz),
        **numbers,
    )


def _rough_numbers(sphere: RoughSphereTheory, normal_force: float) -> dict[str, Any]:
    """Return the attributes of `Regime` for a rough sphere."""
    numbers = {
        "law": sphere.law(normal_force),
        "contact_area": sphere.area(normal_force),
        "inverse_kappa": sphere.inverse_kappa,
        "asperity_radius": sphere.asperity_radius,
        "first_contact_radius": sphere.first_contact_radius,
        "crossover_ratio": normal_force / sphere.crossover_load,
    }
    if not sphere.sticky:
        ratio = sphere.asperity_load / sphere.crossover_load
        numbers["rough_pressure"] = sphere.rough_pressure
        numbers["asperity_ratio"] = normal_force / sphere.asperity_load
        numbers["linear_decades"] = -math.log10(ratio)
    return numbers
