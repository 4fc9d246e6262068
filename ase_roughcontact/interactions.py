"""Interaction between the surfaces: energy, pressure and stiffness of a gap.

An interaction is an energy per area ``V(g)`` of the local gap ``g`` between the
rigid indenter and an atom of the substrate. From it follow

::

    pressure   p(g) = -V'(g)     positive in compression (repulsion)
    stiffness  k(g) =  V''(g)

Everything here is free of units: any consistent set of them will do.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from ase_roughcontact.checks import nonnegative, positive

# Gaps that are evaluated at once: few enough for the cache.
_CHUNK = 1 << 13

Profile = tuple[np.ndarray, np.ndarray, np.ndarray]


class Interaction(ABC):
    """What a wall has to know: a function of the gap, and its range.

    A potential of your own needs the three attributes and `evaluate`; with attributes
    that are not numbers or strings also `todict`.

    Attributes
    ----------
    cutoff : float
        Gap beyond which energy, pressure and stiffness are all zero.
    contact_distance : float
        Gap below which the wall repels; an atom closer than this is in contact.
    attractive : bool
        Whether the wall pulls at any gap.
    """

    cutoff: float
    contact_distance: float
    attractive: bool

    @abstractmethod
    def evaluate(self, gap: np.ndarray) -> Profile:
        """Energy, pressure and stiffness at the given gaps.

        Parameters
        ----------
        gap : ndarray, any shape
            Local gaps (length), also negative ones.

        Returns
        -------
        energy, pressure, stiffness : ndarray, shape of `gap`
            ``V`` (energy per area), ``-V'`` (pressure) and ``V''`` (pressure per
            length).
        """

    def todict(self) -> dict:
        """Parameters as plain numbers and strings."""
        return {"kind": type(self).__name__, **vars(self)}


@dataclass(frozen=True)
class HardWall(Interaction):
    """Impenetrable wall: ``g >= 0, p >= 0, g p = 0``.

    Its pressure is a reaction, not a function of the gap: where the gap is open it
    is zero, and where the atoms overlap energy, pressure and stiffness are infinite.
    Only a solver that knows the constraint can relax it.
    """

    cutoff = 0.0
    contact_distance = 0.0
    attractive = False

    def evaluate(self, gap: np.ndarray) -> Profile:
        """Zero at every allowed gap, infinite at a negative one."""
        wall = np.where(np.asarray(gap, dtype=float) < 0.0, np.inf, 0.0)
        return wall, wall.copy(), wall.copy()

    def todict(self) -> dict:
        """Parameters as plain numbers and strings."""
        return {"kind": "hard"}


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
        return self.tail != "none"

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

    @property
    def _depth(self) -> float:
        return self.stiffness * self.distance**2 / 27.0

    def _evaluate(self, gap: np.ndarray) -> Profile:
        """Evaluate a list of gaps that fits into the cache."""
        energy, pressure, stiffness = self._branch(np.maximum(gap, self.core))
        if self.tail == "full":
            energy -= self._depth
            self._switch_off(gap, energy, pressure, stiffness)
        else:
            # the branch reaches up to r0 and is shifted to meet the tail there
            energy -= self.work_of_adhesion
            self._replace_tail(gap, energy, pressure, stiffness)
        self._continue_core(gap, energy, pressure, stiffness)
        return energy, pressure, stiffness

    def _branch(self, gap: np.ndarray) -> Profile:
        """Energy above the minimum, pressure and stiffness of the 9-3 form."""
        inverse = self.distance / gap
        cube = inverse * inverse * inverse
        ninth = cube * cube * cube
        half = 0.5 * self._depth
        scale = half / self.distance
        return (
            half * (cube - 1.0) ** 2 * (cube + 2.0),  # no difference near the minimum
            9.0 * scale * (ninth - cube) * inverse,
            scale / self.distance * (90.0 * ninth - 36.0 * cube) * inverse**2,
        )

    def _replace_tail(
        self,
        gap: np.ndarray,
        energy: np.ndarray,
        pressure: np.ndarray,
        stiffness: np.ndarray,
    ) -> None:
        beyond = gap >= self.distance
        reach = self.attraction_range
        if reach == 0.0:
            energy[beyond] = pressure[beyond] = stiffness[beyond] = 0.0
            return
        x = np.minimum((gap[beyond] - self.distance) / reach, 1.0)
        left = 1.0 - x
        k = self.stiffness
        # integral of -p from x to the end of the tail, w = k D^2/12
        energy[beyond] = -self.work_of_adhesion * left**3 * (1.0 + 3.0 * x)
        pressure[beyond] = -k * reach * x * left**2
        stiffness[beyond] = k * left * (1.0 - 3.0 * x)

    def _switch_off(
        self,
        gap: np.ndarray,
        energy: np.ndarray,
        pressure: np.ndarray,
        stiffness: np.ndarray,
    ) -> None:
        far = gap > self.onset
        width = self.cutoff - self.onset
        t = np.minimum((gap[far] - self.onset) / width, 1.0)
        factor = 1.0 - t**3 * (10.0 - 15.0 * t + 6.0 * t**2)
        slope = -30.0 * (t * (1.0 - t)) ** 2 / width
        bend = -60.0 * t * (1.0 - t) * (1.0 - 2.0 * t) / width**2
        v, p, k = energy[far], pressure[far], stiffness[far]
        energy[far] = factor * v
        pressure[far] = factor * p - slope * v
        stiffness[far] = factor * k - 2.0 * slope * p + bend * v

    def _continue_core(
        self,
        gap: np.ndarray,
        energy: np.ndarray,
        pressure: np.ndarray,
        stiffness: np.ndarray,
    ) -> None:
        inside = gap < self.core
        if not inside.any():
            return
        overlap = self.core - gap[inside]
        rise = stiffness[inside] * overlap
        energy[inside] += overlap * (pressure[inside] + 0.5 * rise)
        pressure[inside] += rise
