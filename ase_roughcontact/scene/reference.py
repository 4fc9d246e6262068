"""Theory with which the results of a scene are compared."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ase_roughcontact import theory
from ase_roughcontact._util.summary import Summarized
from ase_roughcontact._util.units import UNITS, with_unit
from ase_roughcontact._util.validation import FloatArray, unmasked
from ase_roughcontact.scene.scene import Scene

# Explanation for a sphere that touches with one asperity at all loads.
_SINGLE_ASPERITY = (
    "no Eq. (4), as the sphere is as sharp as an asperity of its roughness; for "
    "comparison, {}"
)


@dataclass(frozen=True)
class NominalArea:
    """The nominal contact area, in place of the theory of a smooth sphere.

    Attributes
    ----------
    nominal_area : float
        A0 of the cell (Å^2).
    """

    nominal_area: float
    pull_off_force: ClassVar[float] = 0.0
    name: ClassVar[str] = "nominal area"
    symbol: ClassVar[str] = "0"
    sphere: ClassVar[str] = "area of the cell"
    label: ClassVar[str] = "nominal area"

    def contact_area(self, normal_force: ArrayLike) -> FloatArray:
        """Return the area A0 for each force, shape of the forces (Å^2)."""
        return np.full(np.shape(normal_force), self.nominal_area)


@dataclass(frozen=True)
class Reference(Summarized):
    """Theory with which the results of a scene are compared.

    Attributes
    ----------
    scene : Scene
    smooth : SphereTheory or NominalArea
        Theory of the sphere without its roughness; the area of a rough flat. Where
        adhesion flattens the roughness, its work of adhesion is reduced by the elastic
        energy of the flattened roughness.
    limits : tuple of SphereTheory
        JKR and DMT, if `smooth` lies between them.
    explanation : str
        Which theory applies and why, for printed output; empty without adhesion.
    rough_above : float or None
        Force above which Eq. (4) of the paper is shown (eV/Å); None if it does not
        apply.
    criteria : tuple of Criterion
        Whether rough flats stick, by several theories; empty without adhesion.
    plateau : float
        Area relative to the smooth sphere while the first asperity carries the load:
        (rho/R)^(2/3), or (3 rho/R)^(2/3) under a soft wall; NaN with adhesion.

    References
    ----------
    L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016).
    """

    scene: Scene = field(repr=False)
    smooth: theory.SphereTheory
    limits: tuple[theory.SphereTheory, ...] = ()
    explanation: str = ""
    rough_above: float | None = None
    criteria: tuple[theory.Criterion, ...] = ()
    plateau: float = math.nan

    def relative_area(self, normal_force: ArrayLike) -> FloatArray:
        """Return the contact area by theory, relative to the smooth sphere.

        It is the area of Eq. (4), or of the first asperity if this is larger.

        Parameters
        ----------
        normal_force : array_like
            Normal forces (eV/Å).

        Returns
        -------
        ndarray
            Ratios of areas, shape of the forces; NaN where neither theory applies.
        """
        smooth = self.smooth.contact_area(normal_force)
        return np.fmax(self.rough_area(normal_force) / smooth, self.plateau)

    def rough_area(self, normal_force: ArrayLike) -> FloatArray:
        """Return the contact area by Eq. (4) of the paper.

        Parameters
        ----------
        normal_force : array_like
            Normal forces (eV/Å).

        Returns
        -------
        ndarray
            Areas (Å^2); NaN for forces that are not positive or below `rough_above`.
        """
        force = unmasked(normal_force).astype(float)
        smallest = math.inf if self.rough_above is None else self.rough_above
        valid = (force > 0.0) & (force >= smallest)
        area = self.scene.bodies.predicted_area(np.where(valid, force, 1.0))
        return np.where(valid, area, np.nan)


def reference_for(scene: Scene) -> Reference:
    """Choose the theory with which the results of a scene are compared.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    Reference
    """
    if scene.is_flat:
        return _flat(scene)
    if scene.bodies.shape is not None:
        return _of_shape(scene)
    if not scene.wall.attractive:
        return _repulsive(scene)
    reference = _rough(_adhesive(scene, scene.wall.work_of_adhesion))
    return replace(reference, criteria=scene.bodies.criteria)


def _flat(scene: Scene) -> Reference:
    """Return the theory of rough flats."""
    area = scene.bodies.nominal_area
    explanation = (
        "Persson, A/A_0 = erf(sqrt(2) p/(h' E*)), and A = kappa p A_0/(h' E*) at "
        f"small pressures, with the rms slope h' = {scene.rough.rms_slope:.4g} and the "
        f"nominal area A_0 = {with_unit(area, 'nm²')}; kappa is about "
        f"{theory.KAPPA_HARD:g} for hard walls, {theory.KAPPA_PERSSON:.2g} by Persson"
    )
    smooth: Any = NominalArea(area)
    return Reference(scene, smooth, (), explanation, 0.0, scene.bodies.criteria)


def _of_shape(scene: Scene) -> Reference:
    """Return the closed form of an indenter of another shape, with its limits."""
    wall, hardness = scene.wall, scene.wall.hardness
    smooth = scene.bodies.smooth_theory(scene.contact_modulus, wall.work_of_adhesion)
    explanation = f"{smooth.name}, {smooth.shape.label}"
    if smooth.shape.area_ratio != 1.0:
        explanation += ", by the cone with the force of a pyramid"
    if wall.attractive:
        explanation += "; for a range of the attraction much smaller than the contact"
    if hardness < math.inf:
        explanation += (
            f"; elastic, without the hardness of {hardness / UNITS['GPa']:.3g} GPa"
        )
    return Reference(scene, smooth, explanation=explanation)


def _repulsive(scene: Scene) -> Reference:
    """Choose the theory without adhesion, and explain its limits at light loads."""
    smooth = theory.Hertz(scene.radius, scene.contact_modulus)
    rough, hardness, nn = scene.rough, scene.wall.hardness, UNITS["nN"]
    if rough is not None and scene.bodies.rough_theory.single_asperity:
        return Reference(
            scene, smooth, explanation=_SINGLE_ASPERITY.format(smooth.name)
        )
    found = Reference(scene, smooth, rough_above=None if rough is None else 0.0)
    if hardness < math.inf:
        sphere = scene.radius, scene.contact_modulus, hardness
        explanation = (
            f"pressures up to the hardness of {hardness / UNITS['GPa']:.3g} GPa; a "
            "smooth sphere would be fully plastic, A = N/H, above about "
            f"{float(theory.plastic_crossover_load(*sphere)) / nn:.2g} nN"
        )
        return replace(found, explanation=explanation)
    if rough is None:
        return found
    explanation, plateau = "Eq. (4) of Pastewka & Robbins (2016)", math.nan
    factor = scene.wall.asperity_factor
    system = replace(scene.bodies.rough_theory, asperity_factor=factor)
    if not system.single_asperity:
        plateau = float(theory.low_load_plateau(system.asperity_radius, scene.radius))
        explanation += (
            f" above about {system.asperity_load / nn:.2g} nN; at lighter loads the "
            f"first asperity, A/A_Hertz = {plateau:.3g}, about which a single "
            "realisation scatters"
        )
    return replace(found, explanation=explanation, plateau=plateau)


def _adhesive(scene: Scene, work: float) -> Reference:
    """Choose the theory of the smooth adhesive sphere, by Maugis' parameter."""
    sphere = scene.radius, scene.contact_modulus, work
    attraction_range = scene.wall.attraction_range
    smooth = theory.sphere_theory(*sphere, attraction_range)
    number = theory.MaugisDugdale(*sphere, attraction_range).parameter
    parameter = f"Maugis' parameter is {number:.3g}"
    limits: tuple[theory.SphereTheory, ...] = ()
    if isinstance(smooth, theory.JKR):
        reason = f"above {theory.JKR_ABOVE:g}"
    elif isinstance(smooth, theory.DMT):
        reason = f"below {theory.DMT_BELOW:g}"
    else:
        reason = "between DMT and JKR"
        limits = theory.JKR(*sphere), theory.DMT(*sphere)
    explanation = f"{smooth.name}, {smooth.sphere} ({parameter}, {reason})"
    return Reference(scene, smooth, limits, explanation)


def _rough(smooth: Reference) -> Reference:
    """Choose the theory of a rough adhesive sphere, given the smooth theory."""
    scene, rough = smooth.scene, smooth.scene.rough
    if rough is None:
        return smooth
    system = scene.bodies.rough_theory
    if system.single_asperity:
        return replace(smooth, explanation=_SINGLE_ASPERITY.format(smooth.explanation))
    inverse_kappa = f"1/kappa = {scene.bodies.inverse_kappa:.3g}"
    comparison = f"for comparison, {smooth.explanation}"
    if scene.bodies.inverse_kappa > 0.0:
        accurate = system.crossover_load
        compliant = replace(system, asperity_factor=theory.ASPERITY_FACTOR_REPULSIVE)
        shown = min(compliant.asperity_load, accurate)
        explanation = (
            f"Eq. (4) with adhesion ({inverse_kappa}), too small below about "
            f"{accurate / UNITS['nN']:.2g} nN and not shown below "
            f"{shown / UNITS['nN']:.2g} nN; {comparison}"
        )
        return replace(smooth, explanation=explanation, rough_above=shown)

    work = system.effective_work_of_adhesion
    radius = math.sqrt(float(smooth.smooth.contact_area(0.0)) / math.pi)
    half_wave = 0.5 * (rough.longest_wavelength or rough.long_wavelength)
    if work > 0.0 and radius >= half_wave:
        flattened = _adhesive(scene, work)
        total = scene.wall.work_of_adhesion / UNITS["J/m^2"]
        explanation = (
            f"adhesion of w = {total:.3g} J/m² flattens the roughness, which reduces "
            f"it to {work / UNITS['J/m^2']:.3g} J/m²: {flattened.explanation}"
        )
        return replace(flattened, explanation=explanation)
    reason = f"flat surfaces with this roughness adhere ({inverse_kappa})"
    if work > 0.0:
        reason = (
            f"the contact at zero load (radius {radius / UNITS['nm']:.2g} nm) is "
            "smaller than half the longest wavelength "
            f"({half_wave / UNITS['nm']:.2g} nm)"
        )
    explanation = f"none for this contact, as {reason}; {comparison}"
    return replace(smooth, explanation=explanation)
