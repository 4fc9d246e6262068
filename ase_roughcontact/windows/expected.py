"""Size of a contact by the theory of smooth spheres, without evaluating the roughness.

The rigid sphere reaches into the range of the wall within a radius that is a lower
bound of that of a rough one: shifted down by the depth of the roughness, the smooth
sphere contains the rough one, and carries at least its load at the same height.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ase_roughcontact.elasticity.greens import ElasticSolid
from ase_roughcontact.interactions import Interaction
from ase_roughcontact.theory import Hertz
from ase_roughcontact.theory.self_affine import rms_height
from ase_roughcontact.topography import RoughSphere, SelfAffine
from ase_roughcontact.windows.footprint import BeyondSurfaceError
from ase_roughcontact.windows.memory import check_memory
from ase_roughcontact.windows.prediction import contact_level

# No height of a roughness is below its mean by more than this many rms heights.
_DEEPEST = 6.0
#: Points along a side up to which a roughness is synthesised for a plan.
LARGEST_DOMAIN = 2048
# Points along a side up to which windows are planned on the lattice of the atoms.
_LARGEST_SIDE = 2048
# Wave numbers among which the stiffest is searched, from this part of the largest on.
_LONGEST, _WAVES = 1e-5, 60


@dataclass(frozen=True)
class ExpectedContact:
    """Bounds for the contact of a rough sphere.

    Parameters
    ----------
    indenter : RoughSphere
    wall : Interaction
    solid : ElasticSolid
        A homogeneous solid as stiff as its stiffest waves is indented least.
    spacing : float
        Of the atoms (length).
    """

    indenter: RoughSphere
    wall: Interaction
    solid: ElasticSolid
    spacing: float

    def check(self, control: str, target: float, memory: bool = True) -> None:
        """Raise an error if a contact certainly can't be calculated.

        Parameters
        ----------
        control : {"penetrations", "heights", "loads"}
        target : float
            Of the step.
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

    def coarsening(self, control: str, target: float) -> int:
        """Return the ratio of the spacings of a lattice for a plan and of the atoms.

        Parameters
        ----------
        control, target
            See `check`.

        Returns
        -------
        int
            Power of two: one unless window or roughness have very many points.
        """
        level = self._level(control, target, self.solid.contact_modulus)
        level += 2.0 * self._depth_of_roughness
        side = 2.0 * self._reach(level) / self.spacing / _LARGEST_SIDE
        rough = self.indenter.roughness
        if isinstance(rough, SelfAffine):
            side = max(side, rough.side / self.spacing / LARGEST_DOMAIN)
        return 2 ** max(0, math.ceil(math.log2(side))) if side > 1.0 else 1

    @cached_property
    def _depth_of_roughness(self) -> float:
        rough = self.indenter.roughness
        if isinstance(rough, SelfAffine):
            return _DEEPEST * rms_height(rough)
        lowest = getattr(rough, "lowest", None)
        return -float(lowest(self.spacing)) if lowest else 0.0

    @cached_property
    def _smooth(self) -> RoughSphere:
        return replace(self.indenter, roughness=None)

    @cached_property
    def _stiffest(self) -> float:
        """Modulus of the stiffest waves."""
        waves = np.geomspace(_LONGEST, 1.0, _WAVES) * np.pi / self.spacing
        return float(self.solid.wave_modulus(waves).max())

    def _level(self, control: str, target: float, modulus: float) -> float:
        """Return a height below which the rigid sphere is in the range of the wall."""
        if control == "heights":
            return self.wall.cutoff - target
        level = self.wall.cutoff - self.wall.contact_distance
        level -= self._depth_of_roughness  # by which asperities hold the sphere up
        if control == "penetrations":
            return level + target
        if self.indenter.radius == math.inf:
            return level
        sphere = Hertz(self.indenter.radius, modulus)
        radius = float(sphere.contact_radius(np.maximum(target, 0.0)))
        return level + radius**2 / self.indenter.radius

    def _reach(self, level: float) -> float:
        if self.indenter.radius == math.inf:  # of a whole tip nothing is known
            return 0.0
        return self._smooth.reach(level, self.spacing)


def coarsened(
    indenter: RoughSphere, spacing: float, factor: int
) -> tuple[RoughSphere, float]:
    """Return an indenter without its short waves, and a spacing that resolves it.

    The long waves, which most of the height is due to, are the same.

    Parameters
    ----------
    indenter : RoughSphere
    spacing : float
        Of the atoms (length).
    factor : int
        From `ExpectedContact.coarsening`.

    Returns
    -------
    indenter : RoughSphere
        Smooth if all waves of the roughness are short.
    spacing : float
        About `factor` times as large.
    """
    rough = indenter.roughness
    if factor == 1 or not isinstance(rough, SelfAffine):
        return indenter, factor * spacing
    points = math.ceil(rough.side / spacing / factor)
    coarse = rough.side / points
    short = max(rough.short_wavelength, 2.0 * coarse)
    if short >= rough.long_wavelength:
        return replace(indenter, roughness=None), coarse
    longer = replace(rough, short_wavelength=short)
    slope = rough.rms_slope * rms_height(rough) / rms_height(longer)
    return replace(indenter, roughness=replace(longer, rms_slope=slope)), coarse
