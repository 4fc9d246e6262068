"""The 9-3 Lennard-Jones wall: repulsive, with a smooth tail, or with its own."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ase_roughcontact._util.validation import nonnegative, positive
from ase_roughcontact.interactions.base import Interaction, Profile
from ase_roughcontact.interactions.forms import (
    continued,
    nine_three,
    smooth_tail,
    switched_off,
)

# Gaps that are evaluated at once: few enough for the cache.
_CHUNK = 1 << 13


@dataclass(frozen=True)
class LennardJones93(Interaction):
    r"""9-3 Lennard-Jones wall, with one of three tails.

    The half-space integral of a 12-6 Lennard-Jones pair potential, written with the
    distance :math:`r_0` and depth :math:`w_0` of its minimum:

    .. math:: V_{93}(g) = \frac{w_0}{2}
              \left[\left(\frac{r_0}{g}\right)^9 - 3\left(\frac{r_0}{g}\right)^3\right],
              \qquad V_{93}''(r_0) = k = \frac{27 w_0}{r_0^2}.

    Below :math:`r_0` every form follows this branch. Beyond it the tail is

    ``"none"``
        nothing: the branch is shifted to zero at :math:`r_0`, purely repulsive;
    ``"smooth"``
        the cubic pressure :math:`p = -k x (1 - x/D)^2`, :math:`x = g - r_0`,
        between 0 and :math:`D = \sqrt{12 w/k}`, and zero beyond. Energy, pressure and
        stiffness are continuous at both ends, the work of adhesion is :math:`w`
        and the largest tension :math:`4kD/27`;
    ``"full"``
        the 9-3 form itself, brought to zero between `onset` and `cutoff` by
        the factor :math:`1 - 10 t^3 + 15 t^4 - 6 t^5`.

    Below the `core` gap the potential goes on as its second-order Taylor polynomial:
    trial steps may overlap, and energy, force and stiffness stay finite and
    continuous there.

    Use the constructors `repulsive`, `adhesive` and `full`.

    Parameters
    ----------
    distance : float
        :math:`r_0` (length).
    stiffness : float
        :math:`k = V''(r_0)` (pressure per length).
    tail : {"none", "smooth", "full"}
        Form beyond :math:`r_0`.
    work_of_adhesion : float
        :math:`w` (energy per area): zero with tail "none", and
        :math:`k r_0^2/27` with tail "full".
    onset, cutoff : float
        Gaps between which the full form is switched off, and the gap beyond which the
        wall is zero. With the other tails both follow from the other parameters.
    core : float
        Gap of the continuation (length), smaller than `distance`.

    Raises
    ------
    ValueError
        If a parameter is not a finite positive number, or the gaps are not in order.

    References
    ----------
    L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016); the smooth tail:
    L. Pastewka, M. O. Robbins, Proc. Natl. Acad. Sci. 111, 3298 (2014).
    """

    distance: float
    stiffness: float
    tail: str
    work_of_adhesion: float
    onset: float
    cutoff: float
    core: float

    def __post_init__(self) -> None:
        """Check the parameters."""
        positive(distance=self.distance, stiffness=self.stiffness, core=self.core)
        nonnegative(work_of_adhesion=self.work_of_adhesion)
        if self.tail not in ("none", "smooth", "full"):
            raise ValueError(
                f"tail must be 'none', 'smooth' or 'full', got {self.tail!r}"
            )
        if not self.core < self.distance:
            raise ValueError(
                f"core must be smaller than the distance {self.distance:g}, "
                f"got {self.core:g}"
            )
        positive(onset=self.onset, cutoff=self.cutoff)
        if self.tail == "full":
            depth = self.stiffness * self.distance**2 / 27.0
            if not math.isclose(self.work_of_adhesion, depth):
                raise ValueError(
                    f"the full form of this stiffness has work_of_adhesion {depth:g}, "
                    f"got {self.work_of_adhesion:g}"
                )
            if not self.distance <= self.onset < self.cutoff:
                raise ValueError(
                    "onset and cutoff must satisfy distance <= onset < cutoff, got "
                    f"{self.distance:g}, {self.onset:g}, {self.cutoff:g}"
                )
        else:
            reach = math.sqrt(12.0 * self.work_of_adhesion / self.stiffness)
            if self.tail == "none" and reach > 0.0:
                raise ValueError(
                    "a wall without tail has work_of_adhesion 0, got "
                    f"{self.work_of_adhesion:g}"
                )
            if not math.isclose(self.cutoff, self.distance + reach):
                raise ValueError(
                    f"this tail ends at {self.distance + reach:g}, got a cutoff of "
                    f"{self.cutoff:g}"
                )

    @classmethod
    def repulsive(
        cls,
        contact_modulus: float,
        spacing: float,
        *,
        stiffness: float | None = None,
        core: float | None = None,
    ) -> LennardJones93:
        """Purely repulsive wall, by default as stiff as the bulk.

        The potential is cut at its minimum, which lies one atomic spacing away.

        Parameters
        ----------
        contact_modulus : float
            E* of the substrate (pressure).
        spacing : float
            Atomic spacing a0 (length), the distance of the minimum.
        stiffness : float, optional
            V''(r0); by default E*/a0, "the same stiffness as the bulk".
        core : float, optional
            Gap of the continuation; by default half of the spacing. With 0.7
            spacings it took 0.8 to 1.3 times the transforms; with 0.3 rough contacts
            of 100 atoms' radius did not converge, and with 0.9 their largest pressure,
            above 0.2 E*, was wrong by 2e-4.

        Returns
        -------
        LennardJones93
        """
        positive(contact_modulus=contact_modulus, spacing=spacing)
        return cls(
            distance=spacing,
            stiffness=contact_modulus / spacing if stiffness is None else stiffness,
            tail="none",
            work_of_adhesion=0.0,
            onset=spacing,
            cutoff=spacing,
            core=spacing / 2 if core is None else core,
        )

    @classmethod
    def adhesive(
        cls,
        contact_modulus: float,
        spacing: float,
        work_of_adhesion: float,
        *,
        stiffness: float | None = None,
        core: float | None = None,
    ) -> LennardJones93:
        """Wall of the paper's adhesive calculations: bulk-matched, with a smooth tail.

        Parameters
        ----------
        contact_modulus : float
            E* of the substrate (pressure).
        spacing : float
            Atomic spacing a0 (length), the distance of the minimum.
        work_of_adhesion : float
            Energy w gained per area (energy per area); zero gives `repulsive`.
        stiffness, core : float, optional
            As for `repulsive`.

        Returns
        -------
        LennardJones93
        """
        positive(contact_modulus=contact_modulus, spacing=spacing)
        nonnegative(work_of_adhesion=work_of_adhesion)
        if work_of_adhesion == 0.0:
            return cls.repulsive(
                contact_modulus, spacing, stiffness=stiffness, core=core
            )
        stiffness = contact_modulus / spacing if stiffness is None else stiffness
        positive(stiffness=stiffness)
        cutoff = spacing + math.sqrt(12.0 * work_of_adhesion / stiffness)
        return cls(
            distance=spacing,
            stiffness=stiffness,
            tail="smooth",
            work_of_adhesion=work_of_adhesion,
            onset=spacing,
            cutoff=cutoff,
            core=spacing / 2 if core is None else core,
        )

    @classmethod
    def full(
        cls,
        distance: float,
        work_of_adhesion: float,
        *,
        cutoff: float | None = None,
        onset: float | None = None,
        core: float | None = None,
    ) -> LennardJones93:
        """9-3 wall with its own ``r^-3`` tail.

        Parameters
        ----------
        distance : float
            r0, the gap of lowest energy (length).
        work_of_adhesion : float
            Depth w of the minimum (energy per area).
        cutoff : float, optional
            Gap where the wall ends; by default ``10 r0``, where 0.15 % of the depth
            is left to be switched off. It is a part of the model, whatever the accuracy
            of a calculation; see the notes for what it changes.
        onset : float, optional
            Gap where the switch begins; by default half of the cutoff, at least r0.
        core : float, optional
            Gap of the continuation; by default half of the distance.

        Returns
        -------
        LennardJones93

        Notes
        -----
        Below a paraboloid of radius R the switch takes nothing from the force, only
        moves it: between two gaps an undeformed solid is pulled by 2 pi R times the
        difference of their energies, and that at the cutoff is zero. What is left is
        the error in the deformation. Measured against 300 r0, at a given height,
        relative to the push on the atoms in contact (spheres of R = 100 and 300 r0,
        w/E* of 1/27 and 1/270 r0, pressed in by 0.3 to 4 r0): C (r0/cutoff)^3, with C
        from 0.001 to 0.5, the more the lighter the load. A rough sphere (h'rms = 0.1)
        came to 6e-2 with a cutoff of 3 r0, 4e-3 with 5, 3e-4 with 10, 5e-6 with 30. The
        atoms in reach fill a square of area 8 R times the cutoff: a tenth of the error
        takes twice as many.
        """
        positive(distance=distance, work_of_adhesion=work_of_adhesion)
        cutoff = 10.0 * distance if cutoff is None else cutoff
        positive(cutoff=cutoff)
        if onset is None:
            onset = max(distance, 0.5 * cutoff)
        return cls(
            distance=distance,
            stiffness=27.0 * work_of_adhesion / distance**2,
            tail="full",
            work_of_adhesion=work_of_adhesion,
            onset=onset,
            cutoff=cutoff,
            core=distance / 2 if core is None else core,
        )

    @property
    def contact_distance(self) -> float:  # type: ignore[override]
        """Gap below which the wall repels: the distance of the minimum."""
        return self.distance

    @property
    def attractive(self) -> bool:  # type: ignore[override]
        """Whether there is a tail that pulls."""
        return self.work_of_adhesion > 0.0

    @property
    def attraction_range(self) -> float:
        """Distance D from the minimum to the end of the tail (length)."""
        return self.cutoff - self.distance

    def evaluate(self, gap: np.ndarray) -> Profile:
        """Energy, pressure and stiffness at the given gaps.

        Parameters
        ----------
        gap : ndarray, any shape
            Local gaps (length), also negative ones.

        Returns
        -------
        energy, pressure, stiffness : ndarray, shape of `gap`
        """
        values = np.asarray(gap, dtype=float)
        flat = values.reshape(-1)
        result = np.empty((3, flat.size))
        for start in range(0, flat.size, _CHUNK):
            part = slice(start, start + _CHUNK)
            result[:, part] = self._evaluate(flat[part])
        energy, pressure, stiffness = result.reshape(3, *values.shape)
        return energy, pressure, stiffness

    def todict(self) -> dict:
        """Parameters as plain numbers and strings."""
        return {"kind": "lennard-jones-9-3", **vars(self)}

    def _evaluate(self, gap: np.ndarray) -> np.ndarray:
        """Rows of `evaluate` at a list of gaps that fits into the cache."""
        depth = self.stiffness * self.distance**2 / 27.0
        rows = nine_three(np.maximum(gap, self.core), self.distance, depth)
        if self.tail == "full":
            rows[0] -= depth
            far = np.flatnonzero(gap > self.onset)
            rows[:, far] = switched_off(
                rows[:, far], gap[far] - self.onset, self.cutoff - self.onset
            )
        else:
            # the branch reaches up to r0 and is shifted to meet the tail there
            rows[0] -= self.work_of_adhesion
            far = np.flatnonzero(gap >= self.distance)
            rows[:, far] = smooth_tail(
                gap[far] - self.distance,
                self.attraction_range,
                self.stiffness,
                self.work_of_adhesion,
            )
        inside = np.flatnonzero(gap < self.core)
        if inside.size:
            rows[:, inside] = continued(rows[:, inside], self.core - gap[inside])
        return rows
