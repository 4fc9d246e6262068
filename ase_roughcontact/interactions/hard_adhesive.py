"""Hard walls with an exponential, a power-law or a constant (Dugdale) attraction."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass

import numpy as np

from ase_roughcontact._util.parameter import Parameter
from ase_roughcontact._util.validation import positive
from ase_roughcontact.interactions.base import WORK_OF_ADHESION, Interaction, Profile

# Range of the attraction, by default one spacing.
_RANGE_PARAMETER = Parameter("a0", default=1.0)
# Smallest relative cutoff. Below it, the difference to a straight line is rounding.
_MIN_CUTOFF = 0.01


class HardAdhesiveWall(Interaction):
    """Impenetrable wall that attracts atoms beyond it: ``g >= 0, p >= p_a(g)``.

    The pressure is the tension of the attraction, :math:`p_a(g) = -V'(g) < 0`, plus the
    reaction to the constraint, which is positive only on atoms that touch the wall.
    These atoms are in contact, also if their total pressure is a tension.

    `evaluate` returns the attraction without the reaction. At negative gaps, which are
    errors of a solver, its energy continues linearly.

    Attributes
    ----------
    work_of_adhesion : float
        Work of adhesion w (energy per area).
    attraction_range : float
        Range D of the attraction (length). The largest tension, at zero gap, is about
        w/D.
    """

    hard = True
    contact_distance = 0.0

    work_of_adhesion: float
    attraction_range: float

    def evaluate(self, gap: np.ndarray) -> Profile:
        """Return values of the attraction; see `Interaction.evaluate`."""
        gap = np.asarray(gap, dtype=float)
        open_gap = gap.clip(0.0, self.cutoff)
        energy, tension, slope = self._attraction(open_gap / self.attraction_range)
        scale = self.work_of_adhesion / self.attraction_range
        energy, pressure = -self.work_of_adhesion * energy, -scale * tension
        stiffness = (gap >= 0.0) * (scale / self.attraction_range) * slope
        energy -= np.minimum(gap, 0.0) * pressure
        near = gap < self.cutoff
        return near * energy, near * pressure, near * stiffness

    @abstractmethod
    def _attraction(self, x: np.ndarray) -> Profile:
        """Return ``-V/w``, the tension ``V' D/w`` and ``V'' D^2/w`` at ``x = g/D``."""

    def __post_init__(self) -> None:
        """Check the parameters."""
        positive(
            work_of_adhesion=self.work_of_adhesion,
            attraction_range=self.attraction_range,
        )


@dataclass(frozen=True)
class DugdaleWall(HardAdhesiveWall):
    r"""Hard wall with a constant tension up to a gap.

    .. math:: p_a = -w/D \qquad \text{for } g < D,

    and zero beyond: a smooth sphere with this wall is the model of Maugis-Dugdale. The
    tension ends linearly, between the gaps :math:`(1 - s) D` and :math:`(1 + s) D`,
    since a sharp end has many metastable states.

    Parameters
    ----------
    work_of_adhesion : float
        Work of adhesion w (energy per area).
    attraction_range : float
        Range D of the attraction (length).
    relative_taper : float
        Relative half width s of the taper, less than one; zero for a sharp end. Atoms
        are not trapped if s is larger than 0.56 times :math:`w a_0/(E^* D^2)`, with the
        spacing :math:`a_0`.

    Raises
    ------
    ValueError
        If a parameter is not a finite number in its range.

    References
    ----------
    D. Maugis, J. Colloid Interface Sci. 150, 243 (1992).

    Examples
    --------
    >>> from ase_roughcontact import DugdaleWall
    >>> wall = DugdaleWall(0.02, attraction_range=0.8)
    >>> round(float(wall.evaluate([0.0])[1][0]), 6)  # tension w/D at zero gap
    -0.025
    """

    kind = "dugdale"
    label = "Dugdale wall"
    parameters = {
        "work_of_adhesion": WORK_OF_ADHESION,
        "attraction_range": _RANGE_PARAMETER,
    }

    work_of_adhesion: float
    attraction_range: float
    relative_taper: float = 0.2

    def __post_init__(self) -> None:
        """Check the parameters."""
        super().__post_init__()
        if not 0.0 <= self.relative_taper < 1.0:
            raise ValueError(
                "relative_taper must be at least 0 and below 1, got "
                f"{self.relative_taper}"
            )

    @property
    def cutoff(self) -> float:  # type: ignore[override]
        """Gap at which the tension ends."""
        return (1.0 + self.relative_taper) * self.attraction_range

    def _attraction(self, x: np.ndarray) -> Profile:
        s = self.relative_taper
        tapered = x > 1.0 - s
        width = 2.0 * s or 1.0
        rest = np.where(tapered, (1.0 + s - x) / width, 1.0)
        energy = np.where(tapered, 0.5 * width * rest**2, 1.0 - x)
        return energy, rest, np.where(tapered, -1.0 / width, 0.0)


class _CutTail(HardAdhesiveWall):
    r"""Hard wall with a tail :math:`\varphi(g/D)`, cut off at :math:`c D`.

    A straight line is subtracted, which makes energy and pressure zero at the cutoff,
    and the rest is scaled to the work of adhesion:

    .. math:: V(g) = -w\, \frac{\varphi(x) - \varphi(c) - \varphi'(c)\,(x - c)}
              {1 - \varphi(c) + \varphi'(c)\, c}, \qquad x = g/D .
    """

    relative_cutoff: float

    @property
    def cutoff(self) -> float:  # type: ignore[override]
        """Gap beyond which the wall is zero."""
        return self.relative_cutoff * self.attraction_range

    def __post_init__(self) -> None:
        """Check the parameters."""
        super().__post_init__()
        positive(relative_cutoff=self.relative_cutoff)
        if self.relative_cutoff < _MIN_CUTOFF:
            raise ValueError(
                f"relative_cutoff must be at least {_MIN_CUTOFF:g}, got "
                f"{self.relative_cutoff:g}"
            )

    def _attraction(self, x: np.ndarray) -> Profile:
        c = self.relative_cutoff
        end, end_slope, _ = self._tail(np.array(c))
        value, slope, curvature = self._tail(x)
        scale = 1.0 / (1.0 - end + end_slope * c)
        value = scale * (value - end - end_slope * (x - c))
        return value, scale * (end_slope - slope), -scale * curvature

    @abstractmethod
    def _tail(self, x: np.ndarray) -> Profile:
        """Return the tail and its first and second derivative, 1 and -1 at x = 0."""


@dataclass(frozen=True)
class ExponentialWall(_CutTail):
    r"""Hard wall with an exponential attraction.

    .. math:: V(g) = -w\, e^{-g/D}, \qquad p_a(g) = -\frac{w}{D}\, e^{-g/D},

    cut off at `relative_cutoff` times D: a straight line is subtracted that makes
    energy and pressure zero at the cutoff, and the difference is scaled to the work of
    adhesion.

    Parameters
    ----------
    work_of_adhesion : float
        Work of adhesion w (energy per area).
    attraction_range : float
        Range D of the attraction (length).
    relative_cutoff : float
        Gap beyond which the wall is zero, in units of D. At the default of 10 the
        tension that is cut off is 5e-5 of the largest one. At least 0.01.

    Raises
    ------
    ValueError
        If a parameter is not a finite positive number.
    """

    kind = "exponential"
    parameters = {
        "work_of_adhesion": WORK_OF_ADHESION,
        "attraction_range": _RANGE_PARAMETER,
        "relative_cutoff": Parameter(default=10.0, above=_MIN_CUTOFF),
    }

    work_of_adhesion: float
    attraction_range: float
    relative_cutoff: float = 10.0

    def _tail(self, x: np.ndarray) -> Profile:
        tail = np.exp(-x)
        return tail, -tail, tail


@dataclass(frozen=True)
class PowerLawWall(_CutTail):
    r"""Hard wall with an attraction by a power law.

    .. math:: V(g) = -w \left(1 + \frac{g}{n D}\right)^{-n}, \qquad
              p_a(g) = -\frac{w}{D} \left(1 + \frac{g}{n D}\right)^{-n-1},

    cut off like `ExponentialWall`, which is the limit of large n.

    Parameters
    ----------
    work_of_adhesion : float
        Work of adhesion w (energy per area).
    attraction_range : float
        Range D of the attraction (length).
    exponent : float
        Exponent n: 2 for van der Waals forces between two half spaces, 3 (the default)
        between a half space and a layer of atoms, as in the 9-3 wall.
    relative_cutoff : float
        Gap beyond which the wall is zero, in units of D. At the default of 20 the
        energy of the exponent 3 has fallen to 0.2 % of w.

    Raises
    ------
    ValueError
        If a parameter is not a finite positive number.

    References
    ----------
    J. N. Israelachvili, Intermolecular and Surface Forces (2011), Ch. 11 (exponents).
    """

    kind = "power-law"
    parameters = {
        "work_of_adhesion": WORK_OF_ADHESION,
        "attraction_range": _RANGE_PARAMETER,
        "exponent": Parameter(default=3.0),
        "relative_cutoff": Parameter(default=20.0, above=_MIN_CUTOFF),
    }

    work_of_adhesion: float
    attraction_range: float
    exponent: float = 3.0
    relative_cutoff: float = 20.0

    def __post_init__(self) -> None:
        """Check the parameters."""
        super().__post_init__()
        positive(exponent=self.exponent)

    def _tail(self, x: np.ndarray) -> Profile:
        n = self.exponent
        base = 1.0 + x / n
        tail = base**-n
        return tail, -tail / base, (1.0 + 1.0 / n) * tail / base**2
