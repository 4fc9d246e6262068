"""Solid, indenter and wall of a scene in ASE's units, and theory for them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ase_roughcontact import theory
from ase_roughcontact._util.units import LENGTHS, UNITS
from ase_roughcontact._util.validation import grid_shape, lookup, positive
from ase_roughcontact.elasticity import ElasticSolid
from ase_roughcontact.elasticity.greens import Isotropic
from ase_roughcontact.elasticity.material import fcc_spacing
from ase_roughcontact.elasticity.named_materials import (
    combined_modulus,
    material,
    work_of_adhesion,
)
from ase_roughcontact.interactions import WALLS, Interaction, make_wall
from ase_roughcontact.paths.accuracy import accuracy_of
from ase_roughcontact.paths.grids import grid_for
from ase_roughcontact.paths.hardness import hardness_of
from ase_roughcontact.scene.config import DEFAULT_RADIUS, SubstrateConfig
from ase_roughcontact.scene.file import SceneFile
from ase_roughcontact.scene.random_fields import local_adhesion, random_field
from ase_roughcontact.scene.section import lengths
from ase_roughcontact.scene.solid import named, solid_of
from ase_roughcontact.topography import (
    HeightMap,
    Heterogeneity,
    RoughSphere,
    SelfAffine,
    Surface,
)
from ase_roughcontact.windows.regrid import GridChange, lost_slope

# Hardness (GPa) above that of any solid: a larger value is in another unit.
_LARGEST_HARDNESS = 1e3
# Least default period of a local work of adhesion, in units of the radius in which a
# sphere that touches is in the range of the wall: room for three times that range.
_ROOM = 4.0


@dataclass(frozen=True)
class Bodies(SceneFile):
    """Solid, indenter and wall of a scene, and theory for them; see `Scene`."""

    @cached_property
    def spacing(self) -> float:
        """Atomic spacing a0 (Å), that of the forces between atoms if they are given."""
        spacing = self.named_substrate.spacing
        if spacing is not None:
            spacing = self.named_substrate.plain(["spacing"], LENGTHS, "Å").spacing
            positive(spacing=spacing)
        if self.substrate.of_atoms:
            crystal: Any = self.solid
            if spacing is not None:
                crystal.check(spacing)
            return crystal.spacing
        if spacing is not None:
            return spacing
        try:
            return fcc_spacing(self.symbol)
        except ValueError as error:
            raise ValueError(f"symbol = {self.symbol!r}: {error}") from error

    @cached_property
    def solid(self) -> ElasticSolid:
        """Elastic solid below the surface."""
        solid = solid_of(self.named_substrate)
        if not self.sphere.material:
            return solid
        if not isinstance(solid, Isotropic):
            raise ValueError(
                "the material of the sphere needs an isotropic substrate, got "
                f"{solid!r}: leave it out"
            )
        tip = material(self.sphere.material).contact_modulus * UNITS["GPa"]
        return Isotropic(combined_modulus(solid.contact_modulus, tip))

    @cached_property
    def named_substrate(self) -> SubstrateConfig:
        """The section of the substrate, with its symbol and values of its material."""
        return named(self.substrate)

    @property
    def symbol(self) -> str:
        """Chemical symbol of the surface atoms."""
        return self.named_substrate.symbol

    @property
    def contact_modulus(self) -> float:
        """Contact modulus E* of the solid's far field (eV/Å^3)."""
        return self.solid.contact_modulus

    @property
    def given_hardness(self) -> float | None:
        """Hardness of the substrate (eV/Å^3); None if the scene does not give it."""
        hardness = self.substrate.hardness
        if hardness not in (None, math.inf) and not 0.0 < hardness <= _LARGEST_HARDNESS:
            raise ValueError(
                f"hardness is in GPa, above 0 and at most {_LARGEST_HARDNESS:g}, or "
                f"inf, got {hardness:g}"
            )
        return None if hardness is None else hardness * UNITS["GPa"]

    @cached_property
    def hardness(self) -> float:
        """Hardness of the surface (eV/Å^3); NaN if it is not known."""
        if "hardness" in self.interaction.parameters:
            return self.wall.hardness
        is_named = self.substrate.name and self.substrate.layer_thickness is None
        if self.given_hardness is None and not is_named:
            return math.nan
        return hardness_of(self.symbol, self.spacing, self.given_hardness)

    @property
    def area_column(self) -> str:
        """Column of the contact area that answers the scene's question."""
        columns = {"atoms": "contact_area", "continuum": "continuum_area"}
        return lookup(self.substrate.model, columns, "model")

    @property
    def is_continuum(self) -> bool:
        """Whether the scene asks for the continuum, and not for the model of atoms."""
        return self.area_column == "continuum_area"

    @property
    def given_grid(self) -> GridChange | None:
        """The grid that the scene gives; None if it is chosen for the accuracy."""
        given = self.substrate
        change = GridChange.of(given.refine, given.coarsen, given.spacing)
        if change and not self.is_continuum:
            raise ValueError(
                'refine, coarsen and a spacing of a0/2 need model = "continuum": the '
                "grid of the model of atoms is their lattice"
            )
        return change

    @cached_property
    def grid_change(self) -> GridChange:
        """The grid relative to that of the atoms, given or chosen for the accuracy."""
        given = self.given_grid
        if given is not None or not self.is_continuum:
            return given or GridChange()
        shape = self.substrate.shape
        return grid_for(
            accuracy_of(self.solver.accuracy, continuum=True).error,
            self.surface,
            self.wall,
            self.spacing,
            None if isinstance(shape, str) else grid_shape(shape),
        )

    @cached_property
    def lost_slope(self) -> float:
        """Part of the rms slope that a coarse grid can't resolve, and that is lost."""
        return lost_slope(self.surface, self.sampled_surface)

    @cached_property
    def sampled_surface(self) -> Surface:
        """Surface of the indenter without waves that a coarse grid can't resolve."""
        return self.grid_change.surface(self.surface, self.spacing)

    @property
    def scan(self) -> HeightMap | None:
        """Scan of one of the bodies; None if there is none."""
        if self.topography is None or self.roughness is not None:
            return None
        return self.topography.surface

    @property
    def whole_tip(self) -> HeightMap | None:
        """Scan that is the whole indenter, for which the radius is infinity."""
        return self.scan if self.sphere.radius == math.inf else None

    @cached_property
    def radius(self) -> float:
        """Radius of the sphere (Å); of a whole tip that of curvature of the scan."""
        tip = self.whole_tip
        if tip is not None:
            return self._radius_of_tip(tip)
        given, units = self.sphere.radius, lengths(self.spacing)
        if given == math.inf:
            raise ValueError(
                "radius = inf needs a section [topography], whose scan is the whole "
                "tip: give that, or a finite radius; flat indenters are made in Python"
            )
        if given is None:
            self._check_default_radius()
            return DEFAULT_RADIUS * self.spacing
        radius = self.sphere.plain(["radius"], units, "a0", self.sphere.unit).radius
        if not (isinstance(given, str) and 0.0 < radius < math.inf):
            positive(radius=given)
        if radius < 1.0:
            raise ValueError(
                f"radius must be at least the spacing a0 = {self.spacing:.4g} Å, got "
                f"{given!r}, {radius:.3g} a0"
            )
        return radius * self.spacing

    def _radius_of_tip(self, tip: HeightMap) -> float:
        role: Any = self.topography and self.topography.role
        if role != "indenter" or tip.periodic:
            raise ValueError(
                "radius = inf means that the scan is the whole tip, for a scan with "
                f'role = "indenter" that is not periodic, got role = "{role}", '
                f"periodic = {str(tip.periodic).lower()}: give the radius of the sphere"
            )
        if tip.tip.radius == math.inf:
            raise ValueError(
                "radius = inf means that the scan is the whole tip, but it is not "
                "convex around its highest point: is the height reversed, or the scan "
                "that of a part of the tip? Else give the radius of the sphere"
            )
        return tip.tip.radius

    def _check_default_radius(self) -> None:
        """Raise an error if a scanned indenter has no given radius."""
        if self.topography is None or self.topography.role != "indenter":
            return
        scan: Any = self.scan
        nm = f"{scan.tip.radius / UNITS['nm']:.3g} nm"
        shape = (
            f"the scan itself has a radius of about {nm} at its highest point"
            if scan.tip.is_tip
            else "the scan does not say whether it is that of a whole tip"
        )
        raise ValueError(
            f"{shape}: give radius = inf if it is the whole tip, or the radius of the "
            "sphere that it is the roughness of"
        )

    @cached_property
    def self_affine(self) -> SelfAffine | None:
        """Self-affine roughness of the sphere; None if it is smooth or measured."""
        if self.roughness is None:
            return None
        if self.topography is not None:
            raise ValueError("give [roughness] or [topography], not both")
        return random_field(self.roughness, self.spacing)

    @property
    def rough(self) -> SelfAffine | HeightMap | None:
        """Roughness of the sphere, self-affine or measured; None if it is smooth.

        None also for a whole tip, for which theory is that of a smooth sphere.
        """
        if self.roughness is None and self.topography is not None:
            return None if self.sphere.radius == math.inf else self.scan
        return self.self_affine

    @cached_property
    def surface(self) -> RoughSphere:
        """Surface of the indenter."""
        profile: Any = self.sphere.profile
        if self.whole_tip is not None:
            return RoughSphere(math.inf, self.whole_tip)
        return RoughSphere(self.radius, self.rough, profile)

    @cached_property
    def wall(self) -> Interaction:
        """Interaction between the indenter and the atoms."""
        kind, parameters = self.interaction.kind, self.interaction.parameters
        missing = lookup(kind, WALLS, "kind of interaction").parameters.keys()
        missing -= parameters.keys()
        materials = self.substrate.material, self.sphere.material
        if "work_of_adhesion" in missing and all(materials):
            work = work_of_adhesion(*materials)
            parameters = {**parameters, "work_of_adhesion": work}
        if "hardness" in missing and not math.isnan(self.hardness):
            hardness = self.hardness / UNITS["GPa"]
            parameters = {**parameters, "hardness": hardness}
        return make_wall(kind, self.contact_modulus, self.spacing, parameters)

    @cached_property
    def local_adhesion(self) -> Heterogeneity | None:
        """Work of adhesion relative to that of the wall; None if it is uniform."""
        if self.heterogeneity is None:
            return None
        if not self.wall.attractive:
            raise ValueError(
                "needs a wall with a work of adhesion, got kind = "
                f"{self.interaction.kind!r}"
            )
        attraction = self.wall.cutoff - self.wall.contact_distance
        in_range = math.sqrt(2.0 * self.radius * attraction)
        return local_adhesion(self.heterogeneity, self.spacing, _ROOM * in_range)

    @property
    def kappa_repulsive(self) -> float:
        """Kappa of the mean contact pressure ``h'rms E*/kappa`` without attraction."""
        wall = self.wall
        if wall.kappa is not None:
            return wall.kappa
        return theory.KAPPA_HARD if wall.hard else theory.KAPPA_REPULSIVE

    @property
    def inverse_kappa(self) -> float:
        """``1/kappa`` of the mean contact pressure ``h'rms E*/kappa`` for this wall.

        Negative or zero if nominally flat surfaces would adhere without a load.
        """
        if self.rough is None:
            return 1.0 / self.kappa_repulsive
        return self.rough_theory.inverse_kappa

    @property
    def rough_theory(self) -> theory.RoughSphereTheory:
        """Theory of the rough sphere."""
        rough: Any = self.rough
        return theory.RoughSphereTheory(
            self.radius,
            self.contact_modulus,
            rough,
            self.wall.work_of_adhesion,
            self.wall.attraction_range,
            self.kappa_repulsive,
        )

    def predicted_area(self, normal_force: ArrayLike) -> np.ndarray:
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
        sphere = self.radius, self.contact_modulus
        if hardness == math.inf:
            return theory.predicted_area(normal_force, *sphere, pressure)

        def fraction(nominal: np.ndarray) -> np.ndarray:
            return theory.plastic_contact_fraction(nominal, pressure, hardness)[0]

        return theory.predicted_area(normal_force, *sphere, fraction)

    def hertz_area(self, normal_force: ArrayLike) -> np.ndarray:
        """Return the contact area of a smooth sphere without adhesion.

        Parameters
        ----------
        normal_force : array_like
            Normal forces (eV/Å).

        Returns
        -------
        ndarray
            Areas (Å^2).
        """
        hertz = theory.Hertz(self.radius, self.contact_modulus)
        return hertz.contact_area(normal_force)
