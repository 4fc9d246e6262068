"""Laws of theory that a scene is compared with, in ASE's units."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from ase.units import J, m

from ase_roughcontact import theory
from ase_roughcontact._util.validation import FloatArray
from ase_roughcontact.scene import NANONEWTON, Scene
from ase_roughcontact.theory import DMT_BELOW, JKR_ABOVE

# Points of a curve of force against penetration.
_POINTS = 400
# Ratios m = c/a of Maugis and Dugdale, less one: from large forces to a point contact.
_LEAST_RATIO, _LARGEST_RATIO = 1e-8, 1e4


@dataclass(frozen=True)
class Law:
    """A law of smooth spheres.

    Attributes
    ----------
    name : str
    pull_off_force : float
        Least force of a contact (eV/Å): zero without adhesion.
    radius_of : callable
        Contact radius (Å) of forces that are not below pull-off (eV/Å).
    curve : callable
        Penetration (Å) and force (eV/Å) of contacts up to a radius (Å), from the one
        that parts when the height is held.
    work_of_adhesion : float
        eV/Å^2.
    """

    name: str
    pull_off_force: float
    radius_of: Callable[[FloatArray], FloatArray]
    curve: Callable[[float], tuple[FloatArray, FloatArray]]
    work_of_adhesion: float = 0.0

    @property
    def sphere(self) -> str:
        """What it is the theory of."""
        work = self.work_of_adhesion / (J / m**2)
        return "smooth sphere" + (f", w = {work:.3g} J/m²" if work else "")

    @property
    def label(self) -> str:
        """Name, and what it is the theory of."""
        return f"{self.name}: theory, {self.sphere}"

    def area(self, normal_force: FloatArray) -> FloatArray:
        """Contact area, NaN below pull-off.

        Parameters
        ----------
        normal_force : array_like
            eV/Å.

        Returns
        -------
        ndarray
            Å^2.
        """
        force = np.asarray(normal_force, dtype=float)
        held = force >= self.pull_off_force
        radius = self.radius_of(np.where(held, force, max(self.pull_off_force, 0.0)))
        return np.where(held, np.pi * radius**2, np.nan)


@dataclass(frozen=True)
class Laws:
    """What theory says of a scene.

    Attributes
    ----------
    smooth : Law
        Of the sphere as it is or, where adhesion flattens its roughness, as if it were
        smooth.
    limits : tuple of Law
        JKR and DMT, where the law lies between them.
    told : str
        Which law it is, and why.
    rough_from : float or None
        Force from which on Eq. (4) of the paper is told (eV/Å); None if it is not.
    """

    smooth: Law
    limits: tuple[Law, ...] = ()
    told: str = ""
    rough_from: float | None = None

    def rough_area(self, scene: Scene, normal_force: FloatArray) -> FloatArray:
        """Contact area by Eq. (4) of the paper, NaN where it is not told.

        Parameters
        ----------
        scene : Scene
            That the laws are of.
        normal_force : array_like
            eV/Å.

        Returns
        -------
        ndarray
            Å^2.
        """
        force = np.asarray(normal_force, dtype=float)
        least = math.inf if self.rough_from is None else self.rough_from
        told = (force > 0.0) & (force >= least)
        return np.where(told, scene.predicted_area(np.where(told, force, 1.0)), np.nan)


def laws_of(scene: Scene) -> Laws:
    """Choose the laws for a scene.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    Laws
    """
    wall, given = scene.wall, scene.roughness
    work, attraction_range = wall.work_of_adhesion, wall.attraction_range
    if not wall.attractive:
        return Laws(_hertz(scene), rough_from=None if given is None else 0.0)
    laws = _sticky(scene, work, attraction_range)
    if given is None:
        return laws
    system = theory.RoughSphereTheory(
        scene.radius,
        scene.contact_modulus,
        scene.surface.roughness,  # type: ignore[arg-type]
        work,
        attraction_range,
        scene.kappa_repulsive,
    )
    number = f"1/kappa = {scene.inverse_kappa:.3g}"
    smooth = f"for orientation {laws.told}"
    if scene.inverse_kappa > 0.0:
        end, factor = system.crossover_load, theory.ASPERITY_FACTOR_REPULSIVE
        begin = min(replace(system, asperity_factor=factor).asperity_load, end)
        told = (
            f"Eq. (4) with adhesion, {number}, too low below about "
            f"{end / NANONEWTON:.2g} nN, not told below {begin / NANONEWTON:.2g} nN; "
            f"{smooth}"
        )
        return replace(laws, told=told, rough_from=begin)
    left = system.effective_work_of_adhesion
    if left == 0.0:
        told = (
            f"no closed form, as rough flats stick by themselves ({number}); {smooth}"
        )
        return replace(laws, told=told)
    radius = math.sqrt(float(laws.smooth.area(np.array(0.0))) / math.pi)
    longest = given.longest_wavelength or given.long_wavelength
    half = 0.5 * longest * scene.spacing
    if radius < half:
        told = (
            f"no closed form, as the contact without load (radius {radius / 10:.2g} "
            f"nm) is smaller than half the longest wave ({half / 10:.2g} nm); {smooth}"
        )
        return replace(laws, told=told)
    flattened = _sticky(scene, left, attraction_range)
    told = (
        f"adhesion of w = {work / (J / m**2):.3g} J/m² flattens the roughness, and "
        f"{left / (J / m**2):.3g} J/m² of it are left: {flattened.told}"
    )
    return replace(flattened, told=told)


def _sticky(scene: Scene, work: float, attraction_range: float) -> Laws:
    """Laws of a smooth sphere with adhesion, by Maugis' parameter."""
    stress = work / attraction_range
    system = scene.radius, scene.contact_modulus, work
    parameter = float(theory.maugis_parameter(*system, stress))
    jkr, dmt = _jkr(*system), _dmt(*system)
    number = f"Maugis' parameter is {parameter:.3g}"
    if parameter > JKR_ABOVE:
        return Laws(
            jkr, told=f"{jkr.name}, {jkr.sphere} ({number}, above {JKR_ABOVE:g})"
        )
    if parameter < DMT_BELOW:
        return Laws(
            dmt, told=f"{dmt.name}, {dmt.sphere} ({number}, below {DMT_BELOW:g})"
        )
    between = _maugis(*system, stress, parameter)
    told = f"{between.name}, {between.sphere} ({number}, between DMT and JKR)"
    return Laws(between, (jkr, dmt), told)


def _hertz(scene: Scene) -> Law:
    system = scene.radius, scene.contact_modulus

    def curve(largest: float) -> tuple[FloatArray, FloatArray]:
        depth = np.linspace(0.0, largest**2 / scene.radius, _POINTS)
        return depth, theory.hertz_force(depth, *system)

    return Law(
        "Hertz", 0.0, lambda force: theory.hertz_contact_radius(force, *system), curve
    )


def _jkr(radius: float, modulus: float, work: float) -> Law:
    system = radius, modulus, work
    depth = theory.jkr_pull_off_penetration(radius, modulus, work)
    parting = float(theory.jkr_contact_radius_from_penetration(depth, *system))

    def curve(largest: float) -> tuple[FloatArray, FloatArray]:
        a = np.linspace(parting, max(largest, parting), _POINTS)
        return theory.jkr_penetration(a, *system), theory.jkr_force(a, *system)

    return Law(
        "JKR",
        float(theory.jkr_pull_off_force(radius, work)),
        lambda force: theory.jkr_contact_radius(force, *system),
        curve,
        work,
    )


def _dmt(radius: float, modulus: float, work: float) -> Law:
    system = radius, modulus, work

    def curve(largest: float) -> tuple[FloatArray, FloatArray]:
        a = np.linspace(0.0, largest, _POINTS)
        return theory.dmt_penetration(a, radius), theory.dmt_force(a, *system)

    return Law(
        "DMT",
        float(theory.dmt_pull_off_force(radius, work)),
        lambda force: theory.dmt_contact_radius(force, *system),
        curve,
        work,
    )


def _maugis(
    radius: float, modulus: float, work: float, stress: float, parameter: float
) -> Law:
    unit_force = np.pi * work * radius
    unit = float(theory.hertz_contact_radius(unit_force, radius, modulus))
    last = theory.maugis_dugdale_stability_limit(parameter, "displacement")

    def curve(largest: float) -> tuple[FloatArray, FloatArray]:
        most = min(last - 1.0, _LARGEST_RATIO)
        ratio = 1.0 + np.geomspace(most, _LEAST_RATIO, 4 * _POINTS)
        a, force, depth = theory.maugis_dugdale(ratio, parameter)
        seen = unit * a <= largest
        return unit**2 / radius * depth[seen], unit_force * force[seen]

    return Law(
        "Maugis-Dugdale",
        unit_force * theory.maugis_dugdale_pull_off_force(parameter),
        lambda force: theory.maugis_dugdale_contact_radius(
            force, radius, modulus, work, stress
        ),
        curve,
        work,
    )
