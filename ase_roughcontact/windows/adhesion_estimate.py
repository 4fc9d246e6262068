"""Adhesion-driven contact radius, estimated before anything is calculated.

Full contact presses the roughness flat, at an elastic energy ``U`` per area. If the
work of adhesion ``w`` is larger, the state of least energy is a compact contact, as
large as the contact of a smooth sphere with the work ``w - U``, by JKR. If it is
smaller, the surfaces touch at separate asperities, and adhesion does not extend the
contact.

References
----------
K. L. Johnson, K. Kendall, A. D. Roberts, Proc. R. Soc. A 324, 301 (1971): JKR.
B. N. J. Persson, E. Tosatti, J. Chem. Phys. 115, 5597 (2001): the work ``w - U``.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np

from ase_roughcontact.elasticity.greens import ElasticSolid
from ase_roughcontact.elasticity.halfspace import PeriodicHalfSpace
from ase_roughcontact.interactions import Interaction
from ase_roughcontact.theory import JKR, flattening_energy
from ase_roughcontact.theory.self_affine import band_of
from ase_roughcontact.topography import RoughSphere, SelfAffine, Surface
from ase_roughcontact.topography.topography import topography_of
from ase_roughcontact.windows.expected import contact_radius_on
from ase_roughcontact.windows.memory import check_memory

# Largest side, in spacings, of the piece of a roughness without a known spectrum from
# which the energy of the roughness is calculated.
_MAX_PIECE_SIDE = 1024
# Number of waves over which the modulus of a solid is averaged.
_AVERAGED_WAVES = 200


class AdhesionEstimate:
    """Contact radius of a rough sphere under adhesion, by JKR with the effective work.

    Parameters
    ----------
    sphere : RoughSphere
        The indenter.
    wall : Interaction
        An attractive wall.
    solid : ElasticSolid
        The substrate. Each wave of the roughness sees the modulus at its wavelength,
        and a contact the modulus of waves of its size.
    spacing : float
        Spacing of the atoms (length).

    Attributes
    ----------
    work : float
        Work of adhesion (energy per area).
    """

    def __init__(
        self,
        sphere: RoughSphere,
        wall: Interaction,
        solid: ElasticSolid,
        spacing: float,
    ) -> None:
        self.sphere, self.solid, self.spacing = sphere, solid, spacing
        self.work = wall.work_of_adhesion

    @cached_property
    def effective_work(self) -> float:
        """Work of adhesion less the energy of the flattened roughness, per area."""
        rough = getattr(self.sphere, "roughness", None)  # a user's sphere may lack it
        if rough is None:
            return self.work
        return self.work - _flattening_energy(rough, self.solid, self.spacing)

    def radius(self, depth: float, load: float | None) -> float:
        """Return the radius of the contact; zero without one that adhesion extends.

        Parameters
        ----------
        depth : float
            Distance of the smooth sphere below the height at which it touches (length).
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

        def jkr_radius(modulus: float) -> float:
            jkr = JKR(self.sphere.radius, modulus, self.effective_work)
            if load is not None:
                return float(jkr.contact_radius(load))
            if depth < jkr.pull_off_penetration:
                return 0.0
            return float(jkr.contact_radius_from_penetration(depth))

        radius = contact_radius_on(self.solid, self.spacing, jkr_radius)
        side = 2 * math.ceil(radius / self.spacing)
        try:
            check_memory((side, side))
        except MemoryError as error:
            flattening = self.work - self.effective_work
            raise MemoryError(
                f"the work of adhesion, {self.work:.3g}, is larger than the energy of "
                f"the flattened roughness, {flattening:.3g}, and extends the contact "
                f"to a radius of about {side // 2} spacings: {error}, less adhesion, "
                "more roughness or a fixed window"
            ) from error
        return radius


def _flattening_energy(rough: Surface, solid: ElasticSolid, spacing: float) -> float:
    """Return the elastic energy per area of a roughness in full contact."""
    parts = topography_of(rough).parts
    if len(parts) > 1:  # of independent surfaces
        return sum(_flattening_energy(part, solid, spacing) for part in parts)
    if isinstance(rough, SelfAffine) and rough.long_wavelength > rough.short_wavelength:
        return flattening_energy(_mean_modulus(rough, solid, spacing), rough)
    extent = 2.0 * topography_of(rough).extent / spacing
    side = math.floor(min(_MAX_PIECE_SIDE, extent))
    corner = -spacing * (side // 2)
    heights = rough.heights((side, side), spacing, (corner, corner))
    halfspace = PeriodicHalfSpace((side, side), spacing, solid)
    return -0.5 * float(np.mean(halfspace.elastic_pressure(heights) * heights))


def _mean_modulus(rough: SelfAffine, solid: ElasticSolid, spacing: float) -> float:
    """Return the modulus of waves, averaged over the energy of a roughness."""
    short, long, longest = band_of(rough)
    q = 2.0 * np.pi / np.geomspace(longest or long, short, _AVERAGED_WAVES)
    # q^2 C(q) for each dq, that is q^3 C(q) for each d ln q
    energy = q**3 * np.maximum(q, 2.0 * np.pi / long) ** (-2.0 - 2.0 * rough.hurst)
    modulus = solid.wave_modulus(np.minimum(q, np.pi / spacing))
    return float(energy @ modulus / energy.sum())
