"""Solid, indenter and wall of a scene in ASE's units, and theory for them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ase_roughcontact import theory
from ase_roughcontact._util.summary import Summarized
from ase_roughcontact._util.validation import FloatArray, Shape, unmasked
from ase_roughcontact.contact import Problem
from ase_roughcontact.elasticity import ElasticSolid
from ase_roughcontact.interactions import Interaction
from ase_roughcontact.results.record import LoadStep
from ase_roughcontact.theory.indenters import Indenter
from ase_roughcontact.topography import HeightMap

# Ratio of the largest contact radius, or depth, of a theoretical curve to the steps.
_EXTENT_RATIO = 1.2


@dataclass(frozen=True, eq=False)
class Bodies(Summarized):
    """Solid, indenter and wall, and theory for them.

    Attributes
    ----------
    problem : Problem
        Contact problem on the lattice of the surface atoms.
    symbol : str
        Chemical symbol of these atoms.
    hardness : float
        The hardness of the surface (eV/Å^3); NaN if it is not known.
    hardness_bound : float
        Upper bound of the hardness of bodies of unknown hardness (eV/Å^3); NaN without
        such a body, and for rubbers.
    yield_strength : float
        Yield strength, with which the largest von Mises stress below the surface is
        compared (eV/Å^3); NaN if it is not given.
    radius : float
        The radius of the sphere (Å); for a whole tip the radius of curvature of its
        scan, for a rough flat infinity, for an indenter of another shape NaN.
    rough : Topography or None
        Roughness of the sphere and the substrate, None if both are smooth. The scan of
        a whole tip is no part of it: it is compared with the theory of a sphere.
    shape : Indenter or None
        Closed form of an indenter of another shape; None for spheres, tips and flats.
    tip : ElasticTip or None
        Elastic solid of the indenter; None if it is rigid.
    parts : tuple of RoughBody
        Roughness of each body that is rough, the tip first.
    cell : (int, int) or None
        Shape of the periodic cell of a rough flat, on the lattice of the problem.
    whole_tip : HeightMap or None
        Scan that is a whole tip, for which the radius in the file is infinity.
    friction : FrictionConfig or None
        Section on friction.
    scanned : str
        Role of the scanned body; empty without a scan.
    fitted : bool
        Whether the spacing is one that fits the contact, see `fitting_spacing`.
    """

    problem: Problem
    symbol: str
    hardness: float
    hardness_bound: float
    yield_strength: float
    radius: float
    rough: Any
    shape: Indenter | None = None
    tip: Any = None
    parts: tuple[Any, ...] = ()
    cell: Shape | None = None
    whole_tip: HeightMap | None = None
    friction: Any = None
    scanned: str = ""
    fitted: bool = False

    @property
    def spacing(self) -> float:
        """Atomic spacing a0 (Å), from the forces between atoms if they are given."""
        return self.problem.spacing

    @property
    def solid(self) -> ElasticSolid:
        """Elastic solid below the surface."""
        return self.problem.solid

    @property
    def wall(self) -> Interaction:
        """Interaction between the indenter and the atoms."""
        return self.problem.wall

    @property
    def is_flat(self) -> bool:
        """Whether the indenter is nominally flat, without a sphere."""
        return self.cell is not None

    @property
    def nominal_area(self) -> float:
        """Nominal contact area A0 of a rough flat; NaN for other indenters (Å^2)."""
        if self.cell is None:
            return math.nan
        return math.prod(self.cell) * self.spacing**2

    @property
    def contact_modulus(self) -> float:
        """Contact modulus E* of the solid's far field (eV/Å^3)."""
        return self.solid.contact_modulus

    def labelled(self, label: str) -> str:
        """Return a label of theory with its half space, if the solid is another one."""
        half_space = self.solid.half_space
        return f"{label}, {half_space}" if half_space else label

    @property
    def kappa_repulsive(self) -> float:
        """Kappa of the mean contact pressure ``h'rms E*/kappa`` without attraction."""
        return self.wall.kappa_repulsive

    @property
    def inverse_kappa(self) -> float:
        """``1/kappa`` of the mean contact pressure ``h'rms E*/kappa`` for this wall.

        Negative or zero if nominally flat surfaces would adhere without a load.
        """
        if self.rough is None:
            return 1.0 / self.kappa_repulsive
        return theory.inverse_kappa(
            self.contact_modulus, self.rough, *self._wall_parameters
        )

    @property
    def rough_theory(self) -> theory.RoughSphereTheory:
        """Theory of the rough sphere."""
        return theory.RoughSphereTheory(
            self.radius, self.contact_modulus, self.rough, *self._wall_parameters
        )

    @property
    def criteria(self) -> tuple[theory.Criterion, ...]:
        """Whether rough flats stick; empty without adhesion, and if smooth."""
        if self.rough is None or not self.wall.attractive:
            return ()
        return theory.stickiness(
            self.rough, self.contact_modulus, *self._wall_parameters
        )

    @property
    def _wall_parameters(self) -> tuple[float, float, float]:
        """Work of adhesion, range of the attraction, and kappa without attraction."""
        wall = self.wall
        return wall.work_of_adhesion, wall.attraction_range, self.kappa_repulsive

    @property
    def nonadhesive(self) -> theory.Hertz | theory.ShapeTheory:
        """Theory of the smooth indenter without adhesion."""
        if self.shape is not None:
            return theory.ShapeTheory(self.shape, self.contact_modulus)
        return theory.Hertz(self.radius, self.contact_modulus)

    def smooth_theory(self, modulus: float, work: float) -> Any:
        """Return the theory of the smooth indenter.

        Parameters
        ----------
        modulus : float
            Contact modulus (eV/Å^3).
        work : float
            Work of adhesion (eV/Å^2); zero without adhesion.

        Returns
        -------
        SphereTheory or ShapeTheory
        """
        if self.shape is not None:
            return theory.ShapeTheory(self.shape, modulus, work)
        return theory.sphere_theory(
            self.radius, modulus, work, self.wall.attraction_range
        )

    def area_at(self, penetration: ArrayLike) -> FloatArray:
        """Return the contact area of the smooth indenter without adhesion at a depth.

        Parameters
        ----------
        penetration : array_like
            Penetrations (Å).

        Returns
        -------
        ndarray
            Areas (Å^2).
        """
        depth = np.maximum(unmasked(penetration), 0.0)
        if self.shape is not None:
            return self.shape.contact_area(self.shape.radius(depth))
        return np.pi * self.radius * depth

    def force_at(self, penetration: float) -> float:
        """Return the force of the smooth indenter without adhesion at a depth.

        Parameters
        ----------
        penetration : float
            Penetration (Å).

        Returns
        -------
        float
            Normal force (eV/Å).
        """
        depth = max(penetration, 0.0)
        if self.shape is not None:
            return self.contact_modulus * float(self.shape.force(depth))
        hertz = theory.Hertz(self.radius, self.contact_modulus)
        return float(hertz.force(hertz.contact_radius_from_penetration(depth)))

    def hertz_area(self, normal_force: ArrayLike) -> FloatArray:
        """Return the contact area of the smooth indenter without adhesion.

        Parameters
        ----------
        normal_force : array_like
            Normal forces (eV/Å).

        Returns
        -------
        ndarray
            Areas (Å^2).
        """
        return self.nonadhesive.contact_area(normal_force)

    def predicted_area(self, normal_force: ArrayLike) -> FloatArray:
        """Return the contact area predicted by Eq. (4), by Hertz for a smooth sphere.

        Adhesion changes kappa. The area is NaN if `inverse_kappa` is not positive. With
        a hardness of the wall the contact fraction is `plastic_contact_fraction`, and
        the area of a smooth sphere at least N/H.

        Parameters
        ----------
        normal_force : array_like
            Normal forces (eV/Å).

        Returns
        -------
        ndarray
            Areas (Å^2).

        References
        ----------
        L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016), Eq. (4).
        """
        rough, hardness = self.rough, self.wall.hardness
        if rough is None:
            area = self.hertz_area(normal_force)
            if hardness < math.inf:
                area = np.maximum(area, theory.plastic_area(normal_force, hardness))
            return area
        if self.inverse_kappa <= 0.0:
            return np.full(np.shape(normal_force), np.nan)
        pressure = theory.mean_contact_pressure(
            rough.rms_slope, self.contact_modulus, 1.0 / self.inverse_kappa
        )

        def fraction(nominal: FloatArray) -> FloatArray:
            if hardness == math.inf:
                return theory.contact_fraction(nominal, pressure)
            return theory.plastic_contact_fraction(nominal, pressure, hardness)[0]

        if self.cell is not None:
            nominal = self.nominal_area
            return nominal * fraction(unmasked(normal_force) / nominal)
        sphere = self.radius, self.contact_modulus
        return theory.predicted_area(normal_force, *sphere, fraction)

    @property
    def sphere_limits(self) -> dict[str, Any]:
        """Theories with the instantaneous and the relaxed modulus, by these words.

        There are none for an elastic solid or a flat, and a fluid has no relaxed
        modulus.
        """
        creep, work = self.solid.creep, self.wall.work_of_adhesion
        if creep is None or self.is_flat:
            return {}
        limits = {}
        for name, part in ("instantaneous", 1.0), ("relaxed", creep.relaxed):
            if part:
                limits[name] = self.smooth_theory(part * self.contact_modulus, work)
        return limits

    def forces_over_depth(
        self, theories: Mapping[str, Any], steps: Sequence[LoadStep]
    ) -> dict[str, tuple[FloatArray, FloatArray]]:
        """Return penetrations (Å) and forces (eV/Å) of theories in the range of steps.

        There are none for a rough sphere: its penetration is relative to its highest
        peak, not its mean.
        """
        if self.rough is not None or self.whole_tip is not None:
            return {}
        if self.shape is not None:
            deepest = _EXTENT_RATIO * max(step.penetration for step in steps)
            return {name: each.curve_to(deepest) for name, each in theories.items()}
        area = max(getattr(step, step.area_column) for step in steps)
        largest_force = max(step.normal_force for step in steps)
        found = {}
        for label, each in theories.items():
            # wider than the atoms under pressure: with the rim under tension
            highest = max(largest_force, -each.pull_off_force)
            radius = max(float(each.contact_radius(highest)), math.sqrt(area / math.pi))
            found[label] = each.curve(_EXTENT_RATIO * radius + self.spacing)
        return found
