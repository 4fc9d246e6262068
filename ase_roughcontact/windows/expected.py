r"""Size of a contact that is expected before it is calculated.

A rigid sphere at a depth :math:`d` overlaps the flat surface within a radius
:math:`s = \sqrt{2 R d}`; by Hertz it touches the elastic one within
:math:`a = \sqrt{R d} = s/\sqrt 2` under the load

.. math:: N = \tfrac43 E^* \sqrt R\, d^{3/2} = c\, E^* d\, s, \qquad c = \sqrt 8/3.

Bounds for rough spheres need no roughness: the rigid sphere reaches into the range of
the wall within a radius that is a lower bound for the rough sphere. Shifted down by
the depth of the roughness, the smooth sphere contains the rough one, and carries at
least its load at the same height.

References
----------
K. L. Johnson, Contact Mechanics (Cambridge, 1985), Section 4.2: force and gap.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from ase_roughcontact.contact import Problem
from ase_roughcontact.contact.control import HEIGHT, PENETRATION, Control
from ase_roughcontact.elasticity import Crystal, ElasticSolid, Isotropic
from ase_roughcontact.interactions import Interaction
from ase_roughcontact.theory import Hertz
from ase_roughcontact.topography import RandomWaves
from ase_roughcontact.topography.topography import Topography, topography_of
from ase_roughcontact.windows.footprint import BeyondSurfaceError, Footprint
from ase_roughcontact.windows.memory import check_memory

# Largest depth of a roughness below its mean, in rms heights.
_MAX_RELATIVE_DEPTH = 6.0
#: Points along a side up to which a roughness is synthesised for a plan.
LARGEST_DOMAIN = 2048
# Largest side of a window that is planned on the lattice of the atoms, in atoms.
_MAX_PLANNED_SIDE = 2048
# Smallest wave number of the waves among which the stiffest is searched, relative to
# the largest one.
_MIN_RELATIVE_WAVE_NUMBER = 1e-5
# Number of these waves.
_SEARCHED_WAVES = 60

#: Normal force over ``E*``, depth and half the side of the overlap, by Hertz.
LOAD_FACTOR = math.sqrt(8.0) / 3.0
# First depth of a search, in units of the spacing.
_FIRST_DEPTH = 1e-3
# Ratio of two depths of a search.
_DEPTH_RATIO = 1.2
# Wave number that represents a contact, times the radius of the contact.
_RELATIVE_WAVE_NUMBER = math.pi
# Number of corrections of the modulus of a solid that is not homogeneous.
_MODULUS_CORRECTIONS = 12
# Gap at a radius a (1 + e) beside a Hertzian contact of radius a, for small e, in units
# of e^(3/2) a^2/(pi R).
_GAP_FACTOR = 8.0 * math.sqrt(2.0) / 3.0


class ExpectedContact:
    """Bounds for the contact of a rough sphere.

    Parameters
    ----------
    problem : Problem
        A contact problem of a `RoughSphere`. A homogeneous solid as stiff as the
        stiffest waves of its solid is indented least.
    """

    def __init__(self, problem: Problem) -> None:
        self.indenter: Any = problem.indenter
        self.wall, self.solid = problem.wall, problem.solid
        self.spacing = problem.spacing

    def check(self, control: Control, target: float, memory: bool = True) -> None:
        """Raise an error if a contact certainly can't be calculated.

        Parameters
        ----------
        control : Control
        target : float
            Penetration or height (length), or load (force), of the step.
        memory : bool
            Whether the memory is checked, too.

        Raises
        ------
        BeyondSurfaceError
            If atoms touch where the surface is not defined.
        MemoryError
            If the contact exceeds the free memory.
        """
        level = self._level(control, target, self._stiffest)
        radius = self._reach(level)
        if radius > self.indenter.extent:
            raise BeyondSurfaceError(self.indenter, self.spacing, radius)
        if memory:
            level = contact_level(level, 0.0, self.wall, 1.0)
            side = math.ceil(2.0 * self._reach(level) / self.spacing)
            check_memory((side, side), self.wall, self.solid, bound="at least ")

    def coarsening(self, control: Control, target: float) -> int:
        """Return the spacing of a lattice for a plan, in units of the atoms' spacing.

        Parameters
        ----------
        control, target
            See `check`.

        Returns
        -------
        int
            Power of two: one unless window or roughness have very many points, and for
            the roughness of two bodies.
        """
        level = self._level(control, target, self.solid.contact_modulus)
        level += 2.0 * self._depth_of_roughness
        side = 2.0 * self._reach(level) / self.spacing / _MAX_PLANNED_SIDE
        rough = self.indenter.roughness
        if len(topography_of(self.indenter).rough.parts) > 1:
            return 1
        if isinstance(rough, RandomWaves):
            side = max(side, rough.side / self.spacing / LARGEST_DOMAIN)
        return 2 ** max(0, math.ceil(math.log2(side))) if side > 1.0 else 1

    @cached_property
    def _depth_of_roughness(self) -> float:
        rough = topography_of(self.indenter).rough
        return sum(_depth_of(part, self.spacing) for part in rough.parts)

    @cached_property
    def _smooth(self) -> Any:
        return replace(self.indenter, roughness=None)

    @cached_property
    def _stiffest(self) -> float:
        """Modulus of the stiffest waves."""
        relative = np.geomspace(_MIN_RELATIVE_WAVE_NUMBER, 1.0, _SEARCHED_WAVES)
        wave_numbers = relative * np.pi / self.spacing
        return float(self.solid.wave_modulus(wave_numbers).max())

    def _level(self, control: Control, target: float, modulus: float) -> float:
        """Return a height below which the rigid sphere is in the range of the wall."""
        if control == HEIGHT:
            return self.wall.cutoff - target
        level = self.wall.reach
        level -= self._depth_of_roughness  # asperities hold the sphere up
        if control == PENETRATION:
            return level + target
        if self.indenter.radius == math.inf:
            return level
        sphere = Hertz(self.indenter.radius, modulus)
        radius = float(sphere.contact_radius(np.maximum(target, 0.0)))
        return level + radius**2 / self.indenter.radius

    def _reach(self, level: float) -> float:
        if self.indenter.radius == math.inf:  # no bound for a whole tip
            return 0.0
        return self._smooth.reach(level, self.spacing)


def _depth_of(rough: Topography, spacing: float) -> float:
    """Return the largest depth of a roughness; zero if it is not known."""
    if isinstance(rough, RandomWaves):
        return _MAX_RELATIVE_DEPTH * rough.expected_height
    lowest = rough.lowest(spacing)
    return 0.0 if lowest == -math.inf else -lowest


def coarser(problem: Problem, factor: int) -> Problem:
    """Return a problem on a coarser lattice, on which windows are about as large.

    Short waves are left out; the long ones, which most of the height is due to, are the
    same.

    Parameters
    ----------
    problem : Problem
        A contact problem of a `RoughSphere`.
    factor : int
        Approximate ratio of the spacings, from `ExpectedContact.coarsening`.

    Returns
    -------
    Problem
        The coarser problem, with a smooth sphere if all waves of the roughness are
        short.
    """
    indenter: Any = problem.indenter
    rough, spacing, solid = indenter.roughness, factor * problem.spacing, problem.solid
    if isinstance(rough, RandomWaves):
        spacing = rough.side / math.ceil(rough.side / spacing)
        longer = rough.without_short_waves(2.0 * spacing)
        indenter = replace(indenter, roughness=longer)
    if isinstance(solid, Crystal):  # defined at its own spacing only
        solid = Isotropic(solid.contact_modulus)
    return Problem(indenter, solid, problem.wall, spacing, fft=problem.fft)


def predicted_depth(
    load: float,
    footprint: Footprint,
    wall: Interaction,
    solid: ElasticSolid,
    power: int = 0,
) -> tuple[float, int]:
    """Return a depth at which the indenter carries at least a load, ``N = c E* d s``.

    ``c`` is `LOAD_FACTOR`, and ``s`` half the side of the box of the atoms that the
    rigid indenter overlaps. With a hardness the load is at most ``pi H s^2``.

    Parameters
    ----------
    load : float
        Positive load (force).
    footprint : Footprint
        The footprint of the indenter.
    wall : Interaction
    solid : ElasticSolid
        The substrate, with the modulus of waves of the size of the overlap.
    power : int
        Number of factors 1.2 at which the search begins: the result for a smaller load.

    Returns
    -------
    depth : float
        At most 1.2 times the depth of the equation, or the depth at which the overlap
        leaves the domain of the roughness (length). It is searched from small depths
        on, as the surface is then evaluated only where the indenter overlaps.
    power : int
        Number of factors 1.2 at which the search ended.
    """
    spacing = footprint.spacing

    def carried(depth: float, half_side: float) -> float:
        radius = half_side * spacing
        elastic = LOAD_FACTOR * modulus_under(radius, solid, spacing) * depth * radius
        return min(elastic, wall.hardness * math.pi * radius**2)

    level = wall.reach + footprint.lowest
    largest = math.inf if wall.plastic else load / carried(1.0, 0.5)
    # ends at the latest where the domain does, or where the depth is infinite
    while (depth := _FIRST_DEPTH * spacing * _DEPTH_RATIO**power) < largest:
        box = footprint.box_below(level + depth)
        half_side = 0.25 * sum(box.shape)
        if carried(depth, half_side) > load or footprint.clip(box) != box:
            break
        power += 1
    return min(depth, largest), power


def modulus_under(radius: float, solid: ElasticSolid, spacing: float) -> float:
    """Return the modulus of waves of the size of a contact.

    Parameters
    ----------
    radius : float
        Radius of the contact (length).
    solid : ElasticSolid
    spacing : float
        Spacing of the atoms (length).

    Returns
    -------
    float
        The modulus (pressure).
    """
    return float(solid.wave_modulus(_RELATIVE_WAVE_NUMBER / max(radius, spacing)))


def contact_radius_on(
    solid: ElasticSolid, spacing: float, radius: Callable[[float], float]
) -> float:
    """Return the radius of a contact from the radius on homogeneous solids.

    Parameters
    ----------
    solid : ElasticSolid
        The substrate, with a modulus that depends on the wavelength.
    spacing : float
        Spacing of the atoms (length).
    radius : callable
        Function of the modulus that returns the radius on an isotropic solid (length).

    Returns
    -------
    float
        The radius for the modulus of waves of its own size (length).
    """
    result = radius(solid.contact_modulus)
    for _ in range(_MODULUS_CORRECTIONS):
        corrected = radius(modulus_under(result, solid, spacing))
        # on a thin incompressible layer E* is proportional to the cube of the radius,
        # and the corrected radius to 1/radius: without the mean it would alternate
        result = math.sqrt((result or spacing) * corrected)
    return result


def contact_level(
    level: float, lowest: float, wall: Interaction, scale: float
) -> float:
    r"""Return the height below which atoms are expected to touch.

    Atoms beside the Hertzian contact touch where its gap is smaller than the depth
    :math:`\delta` of the roughness and the range of the wall. With the depth
    :math:`d` of the smooth sphere, as :math:`a^2/R = d`, these are the atoms within
    :math:`a (1 + e)`,

    .. math:: \frac{8 \sqrt 2}{3\pi}\, e^{3/2}\, d = \delta.

    The side of a paraboloid's footprint is proportional to the root of its depth.

    Parameters
    ----------
    level : float
        Height below which the rigid indenter overlaps (length).
    lowest : float
        Lowest height of the indenter at an atom (length).
    wall : Interaction
    scale : float
        Factor by which the side is enlarged.

    Returns
    -------
    float
        The level, at most `level` (length).
    """
    roughness = max(-lowest, 0.0) + wall.reach
    depth = level - lowest
    smooth_depth = depth - roughness
    if smooth_depth <= 0.0:
        return level
    beside = (math.pi * roughness / (_GAP_FACTOR * smooth_depth)) ** (2.0 / 3.0)
    side = scale * (1.0 + beside) * math.sqrt(smooth_depth / (2.0 * depth))
    return lowest + depth * min(side, 1.0) ** 2
