r"""Elastic solids, each given by the Green's function of its flat surface.

A solid gives the displacement of its surface along the normal by a normal pressure, and
for friction the lateral displacement by lateral tractions. The response to a plane wave
of pressure is a compliance :math:`G(q)`,

.. math:: \tilde u(q) = -G(q)\, \tilde p(q),

and the response to a uniform pressure on one square cell of the grid is a compliance at
every lattice vector. Half spaces, solvers and windows need nothing else: a new material
is a new subclass of `ElasticSolid`. Pressure also displaces the surface laterally, and
tractions displace it along its normal, by the same odd function: see
`cross_wave_compliance`.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ase_roughcontact._util.registry import Registered, Registry
from ase_roughcontact._util.units import pressure_unit, with_unit
from ase_roughcontact._util.validation import check_poisson, finite, positive
from ase_roughcontact.elasticity.creep import Creep
from ase_roughcontact.elasticity.harmonics import Component, Harmonics
from ase_roughcontact.elasticity.love import love_kernel
from ase_roughcontact.elasticity.material import plane_strain_modulus
from ase_roughcontact.elasticity.subsurface import (
    IsotropicWaves,
    SubsurfaceWaves,
    Tractions,
    UniformResponse,
    isotropic_uniform,
    uniform_strain,
)

# Largest relative difference of a response along mirrored directions.
_MAX_ASYMMETRY = 1e-6
# Directions over which a modulus is averaged, in the middle of equal sectors (rad).
_DIRECTIONS = np.pi / 16.0 * np.arange(1, 8, 2)
# Components xx, yy and xy of a `ComponentSolid`.
_LATERAL = slice(1, 4)
# Components zx and zy of a `ComponentSolid`.
_CROSS = slice(4, 6)
# Wave number of a long wave (1/length).
_LONG_WAVE_NUMBER = 1e-9


#: Solids of one's own by their `kind`; filled by the definition of subclasses.
SOLIDS: Registry[type[ElasticSolid]] = Registry("kind of substrate")


class ElasticSolid(Registered, ABC):
    """Normal response of a flat surface to normal pressure.

    The response must be even in x and in y, as it is for every isotropic solid and for
    the (100) surface of a cubic crystal with x and y along symmetry directions.
    A subclass with a `kind` can be used in scene files, too; its `parameters` are keys
    of the section ``[substrate]``.

    Attributes
    ----------
    contact_modulus : float
        Modulus E* of the far field: a distant point force F displaces the surface by
        ``F/(pi E* r)``. Theory, tolerances and reports use it (pressure).
    bulges : bool
        Whether a pressure lifts the surface somewhere, as around the contact with a
        thin layer on a rigid base. Atoms can then touch also where the undeformed
        gap is open.
    uniform_compliance : float
        Depth per uniform pressure on all of the surface (length/pressure); zero for
        half spaces, where it is not finite. Periodic boundaries leave it out: heights
        are measured from the mean plane of the surface, which a mean pressure p lowers
        by ``uniform_compliance p``.
    coupling : float
        Lateral over normal displacement by a point force along the normal, averaged
        over directions; NaN if it is not known.
    creep : Creep or None
        Creep compliance of a viscoelastic solid; None for an elastic one.
    thickness : float
        Thickness of a layer at the surface (length); infinity for a half space. The
        hardness of the element of the atoms is not the hardness of a layer.
    half_space : str
        Half space with the modulus `contact_modulus` as labels of theory name it, such
        as "on the base without a layer"; empty if it is the solid.
    """

    registry = SOLIDS
    contact_modulus: float
    creep: Creep | None = None
    bulges: bool = False
    uniform_compliance: float = 0.0
    coupling: float = math.nan
    thickness: float = math.inf
    half_space: str = ""

    @abstractmethod
    def wave_compliance(self, qx: np.ndarray, qy: np.ndarray) -> np.ndarray:
        """Return ``G(q) = -u(q)/p(q)`` for plane waves.

        Parameters
        ----------
        qx, qy : ndarray
            Components of the wave vector, broadcast together (1/length). They are never
            both zero.

        Returns
        -------
        ndarray, shape of the broadcast
            Compliances, positive (length/pressure).
        """

    def cell_compliance(
        self, i: np.ndarray, j: np.ndarray, spacing: float
    ) -> np.ndarray:
        """Return the depth of the surface under unit pressure on one cell.

        Only free boundaries need this method.

        Parameters
        ----------
        i, j : ndarray of int
            Lattice vectors from the loaded cell, broadcast together.
        spacing : float
            Side of a cell (length).

        Returns
        -------
        ndarray, shape of the broadcast
            Compliances, positive (length/pressure).
        """
        raise NotImplementedError(
            f"{type(self).__name__} has no cell_compliance, which free boundaries "
            "need: define this method, or use periodic boundaries along x and y"
        )

    def lateral_wave_compliance(self, qx: np.ndarray, qy: np.ndarray) -> np.ndarray:
        """Return the lateral displacement by plane waves of lateral traction.

        Only friction needs this method.

        Parameters
        ----------
        qx, qy : ndarray
            Components of the wave vector, see `wave_compliance`.

        Returns
        -------
        ndarray, 3 in front of the shape of the broadcast
            Components xx, yy and xy of a positive definite matrix (length/pressure).

        Raises
        ------
        NotImplementedError
            If the solid has no lateral components.
        """
        raise self._not_lateral("lateral_wave_compliance")

    def lateral_cell_compliance(
        self, i: np.ndarray, j: np.ndarray, spacing: float
    ) -> np.ndarray:
        """Return the lateral displacement by unit lateral traction on one cell.

        See `cell_compliance` for the parameters, and `lateral_wave_compliance` for the
        components that are returned and for errors.
        """
        raise self._not_lateral("lateral_cell_compliance")

    def cross_wave_compliance(self, qx: np.ndarray, qy: np.ndarray) -> np.ndarray:
        r"""Return the lateral displacement by plane waves of pressure.

        .. math:: \tilde u_a = i C_a \tilde p, \qquad
                  \tilde u_z = i \sum_a C_a \tilde t_a

        Only the coupling of normal and lateral motion needs this method.

        Parameters
        ----------
        qx, qy : ndarray
            Components of the wave vector, see `wave_compliance`.

        Returns
        -------
        ndarray, 2 in front of the shape of the broadcast
            Components x and y, each odd along its axis and even along the other one
            (length/pressure).

        Raises
        ------
        NotImplementedError
            If the solid has no such components.
        """
        raise self._not_lateral("cross_wave_compliance")

    def cross_cell_compliance(
        self, i: np.ndarray, j: np.ndarray, spacing: float
    ) -> np.ndarray:
        """Return the lateral displacement by unit pressure on one cell.

        See `cell_compliance` for the parameters, and `cross_wave_compliance` for the
        components that are returned and for errors.
        """
        raise self._not_lateral("cross_cell_compliance")

    def subsurface(self, tractions: Tractions) -> SubsurfaceWaves:
        """Return stress and displacement below the surface, for waves of traction.

        Only stresses need this method, and `uniform_response`.

        Parameters
        ----------
        tractions : Tractions
            Waves of traction on the surface.

        Returns
        -------
        SubsurfaceWaves

        Raises
        ------
        NotImplementedError
            If the solid does not have what stresses need.
        """
        raise self._no_stress()

    def uniform_response(self, depth: float) -> UniformResponse:
        """Return the response to a uniform traction of a periodic cell at a depth."""
        raise self._no_stress()

    @property
    def has_subsurface(self) -> bool:
        """Whether stresses are known: by `subsurface` and `uniform_response`."""
        kind = type(self)
        return (
            kind.subsurface is not ElasticSolid.subsurface
            and kind.uniform_response is not ElasticSolid.uniform_response
        )

    def _no_stress(self) -> NotImplementedError:
        return NotImplementedError(
            f"{self!r} has no stresses below its surface: use "
            "Isotropic(contact_modulus, poisson=0.3), Layer, Cubic, or a Crystal as "
            "from_calculator makes it, or define `subsurface` and `uniform_response`"
        )

    def _not_lateral(self, method: str) -> NotImplementedError:
        return NotImplementedError(
            f"{self!r} has no {method}, which friction needs: use "
            "Isotropic(contact_modulus, poisson=0.3), Cubic, or a Crystal as "
            "from_calculator makes it, or define this method"
        )

    @property
    def has_cell_compliance(self) -> bool:
        """Whether the solid defines `cell_compliance`."""
        return type(self).cell_compliance is not ElasticSolid.cell_compliance

    @property
    def elastic(self) -> ElasticSolid:
        """The solid itself, or the instantaneous solid of a viscoelastic one."""
        return self

    @property
    def layered(self) -> bool:
        """Whether there is a layer at the surface."""
        return self.thickness < math.inf

    def modulus_at_surface(self, spacing: float) -> float:
        """Return the contact modulus of the material at the surface.

        Parameters
        ----------
        spacing : float
            Distance of neighbours (length).

        Returns
        -------
        float
            Modulus of the shortest waves of a layered solid, and else of the far field
            (pressure).
        """
        if self.layered:
            return float(self.wave_modulus(math.pi / spacing))
        return self.contact_modulus

    def label(self, name: str) -> str:
        """Return a description of the solid with its contact modulus.

        Parameters
        ----------
        name : str
            Name of the material, such as "Cu".

        Returns
        -------
        str
            A part of a line, such as "Cu, E* = 144.6 GPa".
        """
        return f"{name}, {modulus_label(self.contact_modulus)}"

    def check(self, spacing: float) -> None:
        """Raise an error if the solid can't be used with a square grid of atoms.

        Parameters
        ----------
        spacing : float
            Distance of neighbours (length).

        Raises
        ------
        ValueError
            If the compliance of a wave is not positive, or the response is not even in
            x and in y.
        """
        q = np.array([0.3, 1.1]) / spacing
        signs = np.array([[1, 1], [-1, 1], [1, -1]])
        waves = self.wave_compliance(*(signs * q).T)
        if not waves.min() > 0.0:
            raise ValueError(
                f"the compliance of {self!r} must be positive, got {waves.min():g} for "
                f"a wave of length {2 * np.pi / np.hypot(*q):.4g}"
            )
        responses = [(waves, waves.max(), "plane waves")]
        if self.has_cell_compliance:
            cells = self.cell_compliance(signs[:, 0], 2 * signs[:, 1], spacing)
            # relative to the loaded cell: next to it, a thin layer hardly responds
            responses.append((cells, self.self_compliance(spacing), "single cells"))
        for values, largest, load in responses:
            if np.ptp(values) > _MAX_ASYMMETRY * largest:
                raise ValueError(
                    f"the response of {self!r} to {load} must be even in x and in y: "
                    "turn its axes to symmetry directions of the surface"
                )

    def wave_modulus(self, wave_number: np.ndarray | float) -> np.ndarray:
        """Return ``E*(q)``, the inverse of the mean of ``1/E*`` over all directions.

        Parameters
        ----------
        wave_number : ndarray or float
            Magnitude ``|q|``, on a lattice at most pi over the spacing (1/length).

        Returns
        -------
        ndarray, shape of the wave numbers
            Modulus of the waves (pressure).
        """
        q = np.asarray(wave_number)[..., None]
        compliance = self.wave_compliance(
            q * np.cos(_DIRECTIONS), q * np.sin(_DIRECTIONS)
        )
        return 2.0 / (q[..., 0] * compliance.mean(axis=-1))

    def self_compliance(self, spacing: float) -> float:
        """Return the depth of a cell under unit pressure on this cell alone.

        A solid without `cell_compliance` is replaced by an isotropic one with the
        modulus of the shortest waves.
        """
        origin = np.zeros(1, dtype=int)
        if self.has_cell_compliance:
            return float(self.cell_compliance(origin, origin, spacing)[0])
        modulus = float(self.wave_modulus(np.pi / spacing))
        return Isotropic(modulus).self_compliance(spacing)

    def todict(self) -> dict[str, Any]:
        """Return the name and the parameters, which identify the solid in files."""
        parameters = {k: v for k, v in vars(self).items() if not k.startswith("_")}
        return {"name": type(self).__name__, **parameters}


def modulus_label(modulus: float) -> str:
    """Return a contact modulus (eV/Å^3) as text, such as "E* = 144.6 GPa"."""
    return f"E* = {with_unit(modulus, pressure_unit(modulus))}"


class ComponentSolid(ElasticSolid):
    """Solid given by components of its Green's function.

    The components are zz; xx, yy and xy; and zx and zy, the coupling of lateral and
    normal motion. A solid may have the first one, the first four, or all.
    """

    #: What error messages call the components that a solid does not have.
    _missing = "lateral components"

    @property
    @abstractmethod
    def _components(self) -> Sequence[Component]:
        """Components of the solid: one, four or six."""

    @property
    def coupling(self) -> float:  # type: ignore[override]
        """Lateral over normal displacement, of long waves; see `ElasticSolid`."""
        if len(self._components) < _CROSS.stop:
            return math.nan
        q = _LONG_WAVE_NUMBER * np.stack([np.cos(_DIRECTIONS), np.sin(_DIRECTIONS)])
        lateral = np.hypot(*self.cross_wave_compliance(*q))
        return float(lateral.mean() / self.wave_compliance(*q).mean())

    def wave_compliance(self, qx: np.ndarray, qy: np.ndarray) -> np.ndarray:
        """Return ``2/(E*(q) |q|)``; see `ElasticSolid`."""
        normal = self._components[0].waves(*self._in_zone(qx, qy))
        return 2.0 * normal / np.hypot(qx, qy)

    def cell_compliance(
        self, i: np.ndarray, j: np.ndarray, spacing: float
    ) -> np.ndarray:
        """Return the depth under unit pressure on a cell; see `ElasticSolid`."""
        return spacing * self._components[0].cells(i, j)

    def lateral_wave_compliance(self, qx: np.ndarray, qy: np.ndarray) -> np.ndarray:
        """Return the lateral components; see `ElasticSolid`."""
        return self._waves(_LATERAL, qx, qy)

    def lateral_cell_compliance(
        self, i: np.ndarray, j: np.ndarray, spacing: float
    ) -> np.ndarray:
        """Return the displacement by lateral traction on a cell; see `ElasticSolid`."""
        return self._cells(_LATERAL, i, j, spacing)

    def cross_wave_compliance(self, qx: np.ndarray, qy: np.ndarray) -> np.ndarray:
        """Return the components of the coupling; see `ElasticSolid`."""
        return self._waves(_CROSS, qx, qy)

    def cross_cell_compliance(
        self, i: np.ndarray, j: np.ndarray, spacing: float
    ) -> np.ndarray:
        """Return the coupling by traction on a cell; see `ElasticSolid`."""
        return self._cells(_CROSS, i, j, spacing)

    def _in_zone(self, qx: np.ndarray, qy: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return wave vectors in the unit of the components."""
        return qx, qy

    def _waves(self, part: slice, qx: np.ndarray, qy: np.ndarray) -> np.ndarray:
        q = self._in_zone(qx, qy)
        parts = [each.waves(*q) for each in self._components_in(part)]
        return 2.0 * np.stack(parts) / np.hypot(qx, qy)

    def _cells(
        self, part: slice, i: np.ndarray, j: np.ndarray, spacing: float
    ) -> np.ndarray:
        cells = [each.cells(i, j) for each in self._components_in(part)]
        return spacing * np.stack(cells)

    def _components_in(self, part: slice) -> Sequence[Component]:
        if len(self._components) < part.stop:
            raise self._not_lateral(self._missing)
        return self._components[part]


@dataclass(frozen=True)
class Isotropic(ComponentSolid):
    r"""Isotropic half space.

    .. math:: G(q) = \frac{2}{E^* |q|}

    for plane waves; for a square cell see `love_kernel`.

    Parameters
    ----------
    contact_modulus : float
        Contact modulus ``E* = E/(1 - nu^2)`` (pressure).
    poisson : float, optional
        Poisson's ratio nu, which matters to lateral displacements and to stresses below
        the surface.
    dundurs : float, optional
        Dundurs' second parameter, if the solid stands for two elastic bodies; by
        default ``(1 - 2 nu)/(2 - 2 nu)``, its value under a rigid indenter. Its
        magnitude is the attribute `coupling`.

    Raises
    ------
    ValueError
        If the modulus is not positive, Poisson's ratio is not above -1 and at most 1/2,
        or Dundurs' parameter is not finite.

    References
    ----------
    K. L. Johnson, Contact Mechanics (1985), Sec. 3.3 and 13.2.
    """

    _missing = "Poisson's ratio"

    contact_modulus: float
    poisson: float | None = None
    dundurs: float | None = None

    def __post_init__(self) -> None:
        positive(contact_modulus=self.contact_modulus)
        if self.poisson is not None:
            check_poisson(poisson=self.poisson)
        if self.dundurs is not None:
            finite(dundurs=self.dundurs)
        object.__setattr__(self, "contact_modulus", float(self.contact_modulus))

    @classmethod
    def from_young(cls, youngs_modulus: float, poisson: float) -> Isotropic:
        """Return the half space of Young's modulus E (pressure) and Poisson's ratio."""
        return cls(plane_strain_modulus(youngs_modulus, poisson), poisson)

    @cached_property
    def _components(self) -> list[Component]:
        modulus, nu, beta = self.contact_modulus, self.poisson, self.dundurs
        normal = Harmonics([1.0 / modulus])
        if nu is None:
            return [normal]
        if beta is None:
            beta = (1.0 - 2.0 * nu) / (2.0 - 2.0 * nu)
        mean, part = 1.0 - 0.5 * nu, 0.5 * nu
        lateral = np.array([[mean, -part], [mean, part], [0.0, 1j * part]])
        cross = np.array([[1.0], [-1j]]) * beta / modulus
        return [
            normal,
            *map(Harmonics, lateral / (modulus * (1.0 - nu))),
            *(Harmonics(c, odd=True) for c in cross),
        ]

    def wave_compliance(self, qx: np.ndarray, qy: np.ndarray) -> np.ndarray:
        """Return ``2/(E* |q|)``; see `ElasticSolid`."""
        return 2.0 / self.contact_modulus / np.hypot(qx, qy)

    def cell_compliance(
        self, i: np.ndarray, j: np.ndarray, spacing: float
    ) -> np.ndarray:
        """Return the depth under unit pressure on a cell; see `love_kernel`."""
        return love_kernel(i, j, spacing, self.contact_modulus)

    @property
    def has_subsurface(self) -> bool:
        """Whether Poisson's ratio, and so the stress below the surface, is known."""
        return self.poisson is not None

    @property
    def shear_modulus(self) -> float:
        """Shear modulus E*(1 - nu)/2 (pressure); NaN without Poisson's ratio."""
        nu = math.nan if self.poisson is None else self.poisson
        return 0.5 * self.contact_modulus * (1.0 - nu)

    def subsurface(self, tractions: Tractions) -> IsotropicWaves:
        """Return the stress below the surface; see `ElasticSolid`."""
        if self.poisson is None:
            raise self._no_stress()
        return IsotropicWaves(tractions, self.shear_modulus, self.poisson)

    def uniform_response(self, depth: float) -> UniformResponse:
        """Return the response to a uniform traction; see `ElasticSolid`."""
        if self.poisson is None:
            raise self._no_stress()
        strain = uniform_strain(self.shear_modulus, self.poisson)
        return isotropic_uniform(self.poisson, -depth * strain)

    def wave_modulus(self, wave_number: np.ndarray | float) -> np.ndarray:
        """Return E* for all waves; see `ElasticSolid`."""
        return np.full(np.shape(wave_number), self.contact_modulus)

    def todict(self) -> dict[str, Any]:
        """Return name and parameters, without those that are not given."""
        return {k: v for k, v in super().todict().items() if v is not None}
