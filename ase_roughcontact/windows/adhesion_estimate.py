"""Adhesion-driven contact radius, estimated before anything is calculated.

Full contact presses the roughness flat, at an elastic energy ``U`` per area. If the
work of adhesion ``w`` is larger, the state of least energy is a compact contact of the
size of that of a smooth sphere with the work ``w - U``, by JKR. If it is smaller, the
surfaces touch at separate asperities, and adhesion does not extend the contact.

References
----------
K. L. Johnson, K. Kendall, A. D. Roberts, Proc. R. Soc. A 324, 301 (1971): JKR.
B. N. J. Persson, E. Tosatti, J. Chem. Phys. 115, 5597 (2001): the work ``w - U``.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np

from ase_roughcontact.elasticity.halfspace import PeriodicHalfSpace
from ase_roughcontact.interactions import Interaction
from ase_roughcontact.theory import JKR, flattening_energy
from ase_roughcontact.topography import RoughSphere, SelfAffine, Surface
from ase_roughcontact.windows.memory import check_memory

# Side, in spacings, of the piece of a roughness without a known spectrum of which the
# energy is calculated.
_PIECE = 1024


class AdhesionEstimate:
    """Contact radius of a rough sphere under adhesion, by JKR with the effective work.

    Parameters
    ----------
    sphere : RoughSphere
        The indenter.
    wall : Interaction
        An attractive wall.
    modulus : float
        Contact modulus (pressure).
    spacing : float
        Spacing of the atoms (length).

    Attributes
    ----------
    work : float
        Work of adhesion (energy per area).
    """

    def __init__(
        self, sphere: RoughSphere, wall: Interaction, modulus: float, spacing: float
    ) -> None:
        self.sphere, self.modulus, self.spacing = sphere, modulus, spacing
        self.work = wall.work_of_adhesion

    @cached_property
    def effective_work(self) -> float:
        """Work of adhesion less the energy of the flattened roughness, per area."""
        rough = self.sphere.roughness
        if rough is None:
            return self.work
        return self.work - _flattening_energy(rough, self.modulus, self.spacing)

    def radius(self, depth: float, load: float | None) -> float:
        """Return the radius of the contact; zero without one that adhesion extends.

        Parameters
        ----------
        depth : float
            Of the smooth sphere below the height at which it touches (length).
        load : float, optional
            Positive load (force), instead of the depth.

        Returns
        -------
        float
            Length.

        Raises
        ------
        MemoryError
            If a window of this size exceeds the memory.
        """
        if not self.effective_work > 0.0:
            return 0.0
        jkr = JKR(self.sphere.radius, self.modulus, self.effective_work)
        if load is not None:
            radius = float(jkr.contact_radius(load))
        elif depth < jkr.pull_off_penetration:
            return 0.0
        else:
            radius = float(jkr.contact_radius_from_penetration(depth))
        side = 2 * math.ceil(radius / self.spacing)
        try:
            check_memory((side, side))
        except MemoryError as error:
            flattening = self.work - self.effective_work
            raise MemoryError(
                f"the work of adhesion, {self.work:.3g} per area, exceeds the "
                f"{flattening:.3g} needed to flatten the roughness, and extends the "
                f"contact to a radius of about {side // 2} spacings (JKR): {error}, "
                "less adhesion or more roughness, or use a fixed window if the contact "
                "is known to stay within it"
            ) from error
        return radius


def _flattening_energy(rough: Surface, modulus: float, spacing: float) -> float:
    """Return the elastic energy per area of a roughness in full contact."""
    if isinstance(rough, SelfAffine) and rough.long_wavelength > rough.short_wavelength:
        return flattening_energy(modulus, rough)
    extent = 2.0 * getattr(rough, "extent", math.inf) / spacing
    side = math.floor(min(_PIECE, extent))
    corner = -spacing * (side // 2)
    heights = rough.heights((side, side), spacing, (corner, corner))
    solid = PeriodicHalfSpace((side, side), spacing, modulus, measure=False)
    return -0.5 * float(np.mean(solid.elastic_pressure(heights) * heights))
