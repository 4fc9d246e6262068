"""Laws of theory that a scene is compared with, in ASE's units."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from ase.units import J, m

from ase_roughcontact import theory
from ase_roughcontact.checks import FloatArray
from ase_roughcontact.scene import Scene
from ase_roughcontact.theory.smooth import DMT_BELOW, JKR_ABOVE

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
    """

    name: str
    pull_off_force: float
    radius_of: Callable[[FloatArray], FloatArray]
    curve: Callable[[float], tuple[FloatArray, FloatArray]]

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
    predicts_force : bool
        Whether the smooth law holds for the scene, not only as a reference.
    """

    smooth: Law
    limits: tuple[Law, ...] = ()
    told: str = ""
    predicts_force: bool = True


def laws_of(scene: Scene) -> Laws:
    """Choose the laws for a scene.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    Laws
    """
    attraction_range = scene.attraction_range
    work = getattr(scene.wall, "work_of_adhesion", 0.0)
    rough = scene.surface.roughness
    if attraction_range is None:
        return Laws(_hertz(scene), predicts_force=rough is None)
    if rough is None:
        return _sticky(scene, work, attraction_range)
    if scene.inverse_kappa > 0.0:
        told = f"Eq. (4) with adhesion, 1/kappa = {scene.inverse_kappa:.3g}"
        return Laws(_hertz(scene), (), told, predicts_force=False)
    left = theory.RoughSphereTheory(
        scene.radius,
        scene.contact_modulus,
        rough,  # type: ignore[arg-type]
        work,
        attraction_range,
    ).effective_work_of_adhesion
    if left == 0.0:
        told = (
            f"rough flats stick by themselves (1/kappa = {scene.inverse_kappa:.3g}): "
            "there is no formula; Hertz, without adhesion, for reference"
        )
        return Laws(_hertz(scene), (), told, predicts_force=False)
    laws = _sticky(scene, left, attraction_range)
    told = (
        f"adhesion flattens the roughness, and {left / (J / m**2):.3g} J/m² of it are "
        f"left: {laws.told}"
    )
    return Laws(laws.smooth, laws.limits, told)


def _sticky(scene: Scene, work: float, attraction_range: float) -> Laws:
    """Laws of a smooth sphere with adhesion, by Maugis' parameter."""
    stress = work / attraction_range
    system = scene.radius, scene.contact_modulus, work
    parameter = float(theory.maugis_parameter(*system, stress))
    jkr, dmt = _jkr(*system), _dmt(*system)
    number = f"Maugis' parameter is {parameter:.3g}"
    if parameter > JKR_ABOVE:
        return Laws(jkr, told=f"JKR ({number}, above {JKR_ABOVE:g})")
    if parameter < DMT_BELOW:
        return Laws(dmt, told=f"DMT ({number}, below {DMT_BELOW:g})")
    told = f"Maugis-Dugdale, between DMT and JKR ({number})"
    return Laws(_maugis(*system, stress, parameter), (jkr, dmt), told)


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
    )
