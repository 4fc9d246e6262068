"""How far attraction spreads a contact, known before anything is calculated.

Where a rough surface touches everywhere, the roughness is pressed flat. That takes the
elastic energy ``U`` per area, and leaves ``w - U`` of the work of adhesion ``w``. If
this is positive, the state of least energy is a compact contact, as large as that of a
smooth sphere with the work ``w - U``, by JKR. If it is negative, the surfaces touch
here and there, and no contact spreads by itself. Under a load of 1e-3 E* a0^2 spheres
of a rms slope of 0.1 were attracted up to radii of 151 a0 (R = 3000 a0, waves up to
512 a0, w = 0.05 E* a0), 261 and 386 a0 (R = 10 000 a0, waves up to 64 a0, w = 0.02 and
0.05 E* a0); expected were 154, 265 and 394 a0.

References
----------
B. N. J. Persson, E. Tosatti, J. Chem. Phys. 115, 5597 (2001): the work that is left.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np

from ase_roughcontact.elasticity.halfspace import PeriodicHalfSpace
from ase_roughcontact.interactions import Interaction
from ase_roughcontact.theory.jkr import (
    jkr_contact_radius,
    jkr_contact_radius_from_penetration,
    jkr_pull_off_penetration,
)
from ase_roughcontact.theory.rough_flats import flattening_energy
from ase_roughcontact.topography import RoughSphere, SelfAffine, Surface
from ase_roughcontact.windows.memory import available_memory, memory_of

# Side, in spacings, of the piece of a roughness whose energy is taken for that of all
# of it. Cut out and wrapped around, it has 1.01 (waves up to 64 spacings) to 1.27 times
# (512) the energy of its spectrum: the work that is left is not overrated.
_PIECE = 1024


class AdhesionEstimate:
    """Radius over which attraction spreads a contact, refused beyond the memory.

    Parameters
    ----------
    sphere : RoughSphere
        The indenter.
    wall : Interaction
        That attracts.
    modulus : float
        Contact modulus (pressure).
    spacing : float
        Distance of neighbours (length).
    """

    def __init__(
        self, sphere: RoughSphere, wall: Interaction, modulus: float, spacing: float
    ) -> None:
        self.sphere, self.modulus, self.spacing = sphere, modulus, spacing
        at_rest = np.array([wall.contact_distance])
        self.work = -float(wall.evaluate(at_rest)[0][0])

    @cached_property
    def work_left(self) -> float:
        """Work of adhesion less the energy of the pressed roughness, per area."""
        rough = self.sphere.roughness
        if rough is None:
            return self.work
        return self.work - _energy_pressed_flat(rough, self.modulus, self.spacing)

    def radius(self, depth: float, load: float | None) -> float:
        """Radius of the contact of the smooth sphere with the work left, by JKR.

        Parameters
        ----------
        depth : float
            How far the sphere is below the height where it touches (length).
        load : float, optional
            Instead of the depth, positive (force).

        Returns
        -------
        float
            Length; zero if there is no contact.
        """
        if not self.work_left > 0.0:
            return 0.0
        system = self.sphere.radius, self.modulus, self.work_left
        if load is not None:
            return float(jkr_contact_radius(load, *system))
        if depth < jkr_pull_off_penetration(*system):
            return 0.0
        return float(jkr_contact_radius_from_penetration(depth, *system))

    def checked(self, depth: float, load: float | None) -> float:
        """Radius over which a rough contact spreads, if the memory holds that much.

        Parameters
        ----------
        depth, load
            See `radius`.

        Returns
        -------
        float
            Length; zero if the roughness keeps the contact from spreading.

        Raises
        ------
        MemoryError
            With what the attraction gains, and how large the contact becomes.
        """
        radius = self.radius(depth, load)
        atoms = 2 * math.ceil(radius / self.spacing)
        needed, there = memory_of((atoms, atoms)), available_memory()
        if not atoms or needed <= there:
            return radius
        raise MemoryError(
            f"attraction spreads this contact by itself: of its work of adhesion, "
            f"{self.work:.3g} per area, the roughness takes "
            f"{self.work - self.work_left:.3g} to be pressed flat, and the rest holds "
            f"a contact of a radius of about {atoms // 2} spacings together (JKR). A "
            f"window of {atoms} x {atoms} atoms needs about {needed / 1e9:.3g} GB of "
            f"memory, but only {there / 1e9:.3g} GB are free: choose a smaller sphere, "
            "less attraction or more roughness, or give a fixed window if the contact "
            "is known to stay in it"
        )


def _energy_pressed_flat(rough: Surface, modulus: float, spacing: float) -> float:
    """Elastic energy per area of a roughness in full contact, by spectrum or piece."""
    if isinstance(rough, SelfAffine) and rough.long_wavelength > rough.short_wavelength:
        return float(
            flattening_energy(
                rough.rms_slope,
                modulus,
                rough.hurst,
                rough.short_wavelength,
                rough.long_wavelength,
                rough.longest_wavelength,
            )
        )
    known = 2.0 * getattr(rough, "extent", math.inf) / spacing
    side = math.floor(min(_PIECE, known))
    corner = -spacing * (side // 2)
    heights = rough.heights((side, side), spacing, (corner, corner))
    solid = PeriodicHalfSpace((side, side), spacing, modulus, measure=False)
    return -0.5 * float(np.mean(solid.elastic_pressure(heights) * heights))
