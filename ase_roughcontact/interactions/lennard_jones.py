"""The 9-3 Lennard-Jones wall: without a tail, with a short or with the full one."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass

import numpy as np

from ase_roughcontact._util.parameter import Parameter
from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import nonnegative, positive
from ase_roughcontact.interactions.base import (
    RANGE,
    WORK_OF_ADHESION,
    Interaction,
    Profile,
)
from ase_roughcontact.interactions.forms import (
    nine_three,
    nine_three_inverse,
    smooth_tail,
    switched_off,
    taylor,
)


class LennardJones93(Interaction):
    r"""9-3 Lennard-Jones wall.

    It is the integral of a 12-6 Lennard-Jones pair potential over a half space, with
    the distance :math:`r_0` and the depth :math:`w_0` of its minimum:

    .. math:: V_{93}(g) = \frac{w_0}{2}
              \left[\left(\frac{r_0}{g}\right)^9 - 3\left(\frac{r_0}{g}\right)^3\right],
              \qquad V_{93}''(r_0) = k = \frac{27 w_0}{r_0^2}.

    Three constructors make walls that share this repulsive branch and differ in the
    tail beyond :math:`r_0`:

    `repulsive`
        no tail: the branch is shifted to zero at :math:`r_0`;
    `adhesive`
        a short tail with the cubic pressure :math:`p = -(12 w/D^2) x (1 - x/D)^2` of
        :math:`x = g - r_0` between 0 and the range :math:`D`. The work of adhesion is
        :math:`w` and the largest tension :math:`16 w/9D`. By default :math:`D =
        \sqrt{12 w/k}`, with which also the stiffness is continuous at both ends;
    `full`
        the 9-3 form itself, brought to zero between `onset` and `cutoff` by the factor
        :math:`1 - 10 t^3 + 15 t^4 - 6 t^5`.

    At gaps below `core` the potential is replaced by its second-order Taylor polynomial
    about `core`, so that energy, pressure and stiffness stay finite and continuous when
    a trial step makes the surfaces overlap.

    Attributes
    ----------
    distance : float
        Distance :math:`r_0` of the minimum (length).
    stiffness : float
        Stiffness :math:`k = V''(r_0)` (pressure per length).
    core : float
        Gap below which the potential is extrapolated (length).

    Raises
    ------
    ValueError
        If a parameter is not a finite positive number, or the gaps are not in the
        order core, distance, onset, cutoff.

    References
    ----------
    L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016); the short tail:
    L. Pastewka, M. O. Robbins, Proc. Natl. Acad. Sci. 111, 3298 (2014).

    Examples
    --------
    >>> from ase_roughcontact import LennardJones93
    >>> wall = LennardJones93.repulsive(contact_modulus=1.0, spacing=1.0)
    >>> wall.attractive, wall.contact_distance
    (False, 1.0)
    >>> sticky = LennardJones93.adhesive(1.0, 1.0, work_of_adhesion=0.05)
    >>> round(sticky.attraction_range, 3)
    0.775
    """

    distance: float
    stiffness: float
    core: float

    @property
    def extrapolated_below(self) -> float:
        """The gap `core` (length)."""
        return self.core

    @staticmethod
    def repulsive(
        contact_modulus: float,
        spacing: float,
        *,
        stiffness: float | None = None,
        core: float | None = None,
    ) -> RepulsiveLennardJones93:
        """Return the repulsive wall, by default as stiff as the bulk.

        The potential is cut off at its minimum, one atomic spacing away.

        Parameters
        ----------
        contact_modulus : float
            Contact modulus E* of the substrate (pressure).
        spacing : float
            Atomic spacing a0 (length), which is the distance r0 of the minimum.
        stiffness : float, optional
            Stiffness V''(r0) (pressure per length); by default E*/a0, "the same
            stiffness as the bulk".
        core : float, optional
            Gap below which the potential is extrapolated (length), smaller than the
            spacing; by default half of the spacing.

        Returns
        -------
        RepulsiveLennardJones93
            The wall.
        """
        positive(contact_modulus=contact_modulus, spacing=spacing)
        return RepulsiveLennardJones93(
            distance=spacing,
            stiffness=contact_modulus / spacing if stiffness is None else stiffness,
            core=spacing / 2 if core is None else core,
        )

    @staticmethod
    def adhesive(
        contact_modulus: float,
        spacing: float,
        work_of_adhesion: float,
        *,
        attraction_range: float | None = None,
        stiffness: float | None = None,
        core: float | None = None,
    ) -> LennardJones93:
        """Return a wall with a short attractive tail, by default as stiff as the bulk.

        Parameters
        ----------
        contact_modulus, spacing, stiffness, core : float
            See `repulsive`.
        work_of_adhesion : float
            Work of adhesion w (energy per area); zero gives the repulsive wall.
        attraction_range : float, optional
            Distance D from the minimum to the end of the tail (length); by default
            ``sqrt(12 w/k)`` with the stiffness k.

        Returns
        -------
        LennardJones93
            The wall.
        """
        nonnegative(work_of_adhesion=work_of_adhesion)
        wall = LennardJones93.repulsive(
            contact_modulus, spacing, stiffness=stiffness, core=core
        )
        if work_of_adhesion == 0.0:
            return wall
        if attraction_range is None:
            attraction_range = math.sqrt(12.0 * work_of_adhesion / wall.stiffness)
        return AdhesiveLennardJones93(
            wall.distance, wall.stiffness, work_of_adhesion, wall.core, attraction_range
        )

    @staticmethod
    def full(
        *,
        distance: float,
        work_of_adhesion: float,
        cutoff: float | None = None,
        onset: float | None = None,
        core: float | None = None,
    ) -> FullLennardJones93:
        """Return the full 9-3 wall with its own ``r^-3`` tail.

        Parameters
        ----------
        distance : float
            Distance r0 of the minimum (length).
        work_of_adhesion : float
            Depth w of the minimum (energy per area).
        cutoff : float, optional
            Gap at which the tail ends (length); by default ``10 r0``, where the energy
            of the 9-3 form is 0.15 % of the depth. The cutoff is a part of the model,
            independent of the accuracy of a calculation.
        onset : float, optional
            Gap at which the tail begins to be switched off (length); by default half of
            the cutoff, at least r0.
        core : float, optional
            Gap below which the potential is extrapolated (length); by default half of
            the distance.

        Returns
        -------
        FullLennardJones93
            The wall.

        Notes
        -----
        The force between a paraboloid of radius R and an undeformed solid is 2 pi R
        times the energy at the smallest gap, so the cutoff changes this force only by
        2 pi R times the energy that is cut off. In addition, the cutoff changes the
        deformation: the measured change of the force is C (r0/cutoff)^3 of the
        repulsive force at given height, with C between 0.001 and 0.5, larger at smaller
        load. The number of atoms within the cutoff is proportional to R times the
        cutoff.
        """
        positive(distance=distance, work_of_adhesion=work_of_adhesion)
        cutoff = 10.0 * distance if cutoff is None else cutoff
        positive(cutoff=cutoff)
        return FullLennardJones93(
            distance=distance,
            work_of_adhesion=work_of_adhesion,
            onset=max(distance, 0.5 * cutoff) if onset is None else onset,
            cutoff=cutoff,
            core=distance / 2 if core is None else core,
        )

    @classmethod
    def for_substrate(
        cls, contact_modulus: float, spacing: float, **parameters: float
    ) -> Interaction:
        """Make the wall for a substrate; see `repulsive` and `adhesive`."""
        work = parameters.pop("work_of_adhesion", 0.0)
        return cls.adhesive(contact_modulus, spacing, work, **parameters)

    @property
    def contact_distance(self) -> float:  # type: ignore[override]
        """Gap below which the wall is repulsive: the distance of the minimum."""
        return self.distance

    def evaluate(self, gap: np.ndarray) -> Profile:
        """Return energy, pressure and stiffness; see `Interaction.evaluate`."""
        shape = np.shape(gap)
        gap = np.asarray(gap, dtype=float).reshape(-1)
        depth = self.stiffness * self.distance**2 / 27.0
        rows = nine_three(np.maximum(gap, self.core), self.distance, depth)
        rows[0] -= self.work_of_adhesion
        self._set_tail(rows, gap)
        inside = np.flatnonzero(gap < self.core)
        if inside.size:
            rows[:, inside] = taylor(rows[:, inside], self.core - gap[inside])
        energy, pressure, stiffness = rows.reshape(3, *shape)
        return energy, pressure, stiffness

    @abstractmethod
    def _set_tail(self, rows: np.ndarray, gap: np.ndarray) -> None:
        """Replace the rows beyond the minimum, in place."""

    def __post_init__(self) -> None:
        """Check the parameters of all three walls."""
        positive(distance=self.distance, stiffness=self.stiffness, core=self.core)
        if not self.core < self.distance:
            raise ValueError(
                f"core must be smaller than the distance {self.distance:g}, "
                f"got {self.core:g}"
            )


@dataclass(frozen=True)
class RepulsiveLennardJones93(LennardJones93):
    """Repulsive branch of the 9-3 wall, see `LennardJones93.repulsive`."""

    kind = "repulsive"
    invertible = True
    work_of_adhesion = 0.0
    attraction_range = 0.0

    distance: float
    stiffness: float
    core: float

    @property
    def cutoff(self) -> float:  # type: ignore[override]
        """Gap of the minimum, at which the wall ends."""
        return self.distance

    def inverse(self, pressure: np.ndarray) -> Profile:
        """Return the gaps at given pressures; see `Interaction.inverse`."""
        depth = self.stiffness * self.distance**2 / 27.0
        gap, exact, stiffness = nine_three_inverse(pressure, self.distance, depth)
        inside = np.flatnonzero(gap < self.core)
        if inside.size:
            _, exact[inside], stiffness[inside] = self.evaluate(np.array(self.core))
            gap[inside] = self.core - (pressure - exact)[inside] / stiffness[inside]
            exact[inside] = pressure[inside]
        return gap, exact, stiffness

    def _set_tail(self, rows: np.ndarray, gap: np.ndarray) -> None:
        rows[:, np.flatnonzero(gap >= self.distance)] = 0.0


@dataclass(frozen=True)
class AdhesiveLennardJones93(LennardJones93):
    """9-3 wall with a short tail, see `LennardJones93.adhesive`."""

    kind = "adhesive"
    parameters = {"work_of_adhesion": WORK_OF_ADHESION, "attraction_range": RANGE}

    distance: float
    stiffness: float
    work_of_adhesion: float
    core: float
    attraction_range: float

    def __post_init__(self) -> None:
        """Check the parameters."""
        super().__post_init__()
        positive(
            work_of_adhesion=self.work_of_adhesion,
            attraction_range=self.attraction_range,
        )

    @property
    def cutoff(self) -> float:  # type: ignore[override]
        """Gap at which the tail ends."""
        return self.distance + self.attraction_range

    def _set_tail(self, rows: np.ndarray, gap: np.ndarray) -> None:
        beyond = np.flatnonzero(gap >= self.distance)
        rows[:, beyond] = smooth_tail(
            gap[beyond] - self.distance, self.attraction_range, self.work_of_adhesion
        )


@dataclass(frozen=True)
class FullLennardJones93(LennardJones93):
    """9-3 wall with its own tail, see `LennardJones93.full`."""

    kind = "full"
    label = "Lennard-Jones 9-3 wall"
    parameters = {
        "work_of_adhesion": WORK_OF_ADHESION,
        "attraction_range": RANGE,
        "cutoff": Parameter("a0", optional=True),
    }

    distance: float
    work_of_adhesion: float
    onset: float
    cutoff: float
    core: float

    def __post_init__(self) -> None:
        """Check the parameters."""
        positive(distance=self.distance, work_of_adhesion=self.work_of_adhesion)
        positive(onset=self.onset, cutoff=self.cutoff)
        super().__post_init__()
        if not self.distance <= self.onset < self.cutoff:
            raise ValueError(
                "onset and cutoff must satisfy distance <= onset < cutoff, got "
                f"{self.distance:g}, {self.onset:g}, {self.cutoff:g}"
            )

    @classmethod
    def for_substrate(
        cls, contact_modulus: float, spacing: float, **parameters: float
    ) -> Interaction:
        """Make the wall for a substrate; see `LennardJones93.full`."""
        distance = parameters.pop("attraction_range", spacing)
        cutoff = parameters.get("cutoff", math.inf)
        if cutoff <= distance:
            unit = UNITS["nm"]
            raise ValueError(
                f"cutoff must be larger than attraction_range, {distance / unit:.4g} "
                f"nm, got {cutoff / unit:.4g} nm"
            )
        return cls.full(distance=distance, **parameters)

    @property
    def stiffness(self) -> float:  # type: ignore[override]
        """Curvature of the energy at its minimum (pressure per length)."""
        return 27.0 * self.work_of_adhesion / self.distance**2

    @property
    def attraction_range(self) -> float:  # type: ignore[override]
        """Distance of the minimum, the length in Tabor's parameter."""
        return self.distance

    def _set_tail(self, rows: np.ndarray, gap: np.ndarray) -> None:
        beyond = np.flatnonzero(gap > self.onset)
        rows[:, beyond] = switched_off(
            rows[:, beyond], gap[beyond] - self.onset, self.cutoff - self.onset
        )
