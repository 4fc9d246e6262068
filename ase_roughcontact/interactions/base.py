"""Base class of the walls, and the kinds of wall that scene files can name."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from ase_roughcontact._util.parameter import Parameter
from ase_roughcontact._util.registry import Registered, Registry, types_of_parameters
from ase_roughcontact.theory import (
    ASPERITY_FACTOR_REPULSIVE,
    KAPPA_HARD,
    KAPPA_REPULSIVE,
)

# Energy, pressure and stiffness of a wall at some gaps.
Profile = tuple[np.ndarray, np.ndarray, np.ndarray]

#: Walls by their `kind`; filled by the definition of a subclass of `Interaction`.
WALLS: Registry[type[Interaction]] = Registry("kind of interaction")
#: Work of adhesion. Values of metals are about 1 J/m^2: above the limit the unit is
#: wrong.
WORK_OF_ADHESION = Parameter("J/m^2", below=10.0)
#: Range of the attraction, which materials by name may determine.
RANGE = Parameter("a0", optional=True)


class Interaction(Registered, ABC):
    """Base class of walls: energy per area, pressure and stiffness of a gap.

    A subclass defines `evaluate` and the first four attributes, as class attributes,
    fields of a dataclass or properties. A subclass with a `kind` can be used in scene
    files, too.

    Attributes
    ----------
    cutoff : float
        Gap above which energy, pressure and stiffness are zero (length).
    contact_distance : float
        Gap below which the wall is repulsive (length). An atom is in contact if its gap
        is smaller.
    work_of_adhesion : float
        Depth of the minimum of the energy (energy per area); zero for a repulsive wall.
    attraction_range : float
        Range of the attraction in closed-form theories (length): the work of adhesion
        over this range is a typical tension. Zero for a repulsive wall.
    attractive : bool
        Whether the wall is attractive at any gap; by default true if it has a work of
        adhesion.
    depends_on_history : bool
        Whether a relaxed state depends on the states before it; by default true if the
        wall is attractive, as its states are metastable, or `permanent`.
    invertible : bool
        Whether the wall is repulsive and defines `inverse`, which saves steps of the
        solvers; by default False.
    hard : bool
        Whether the wall is a constraint, ``g >= 0, p >= 0, g p = 0``, instead of a
        function of the gap; by default False.
    hardness : float
        Largest pressure of a hard wall (pressure), at which the solid flows and atoms
        overlap with the indenter; by default infinity.
    permanent : bool
        Whether a path keeps the plastic shape of the surface from step to step; by
        default False.
    kappa : float or None
        Ratio ``h'rms E*/p`` for nominally flat rough surfaces without attraction, with
        the mean pressure p in the contacts. None, the default, stands for
        `theory.KAPPA_HARD` or `theory.KAPPA_REPULSIVE`.
    kind : str
        Name in scene files: ``kind = "..."`` in the table ``[interaction]``. The
        definition of a subclass with a `kind` registers it in `WALLS`.
    label : str
        Name in reports and plots; by default the kind with the word "wall".
    parameters : mapping of str to Parameter
        Keys in scene files, with units, defaults and limits; by default none.
    """

    cutoff: float
    contact_distance: float
    work_of_adhesion: float
    attraction_range: float
    invertible: ClassVar[bool] = False
    hard: ClassVar[bool] = False
    hardness: float = math.inf
    permanent: bool = False
    kappa: float | None = None
    registry = WALLS
    label: ClassVar[str] = ""

    def __init_subclass__(cls) -> None:
        """Register a wall that has a `kind`, and give it a label."""
        super().__init_subclass__()
        if "label" not in vars(cls):
            kind = vars(cls).get("kind")
            cls.label = f"{kind} wall" if kind else cls.__name__

    @classmethod
    def for_substrate(
        cls, contact_modulus: float, spacing: float, **parameters: float
    ) -> Interaction:
        """Make the wall for a substrate, as scene files do.

        By default modulus and spacing do not matter: the class is called with the
        values of its `parameters` only, in ASE's units.
        """
        return cls(**parameters)

    @property
    def reach(self) -> float:
        """Height above first contact at which the wall begins to act (length)."""
        return self.cutoff - self.contact_distance

    @abstractmethod
    def evaluate(self, gap: np.ndarray) -> Profile:
        """Return energy, pressure and stiffness at the given gaps.

        Several threads call this method for parts of the atoms: it must not change the
        object, and the result at one gap must not depend on other gaps.

        Parameters
        ----------
        gap : ndarray, any shape
            Local gaps (length), which may be negative.

        Returns
        -------
        energy, pressure, stiffness : ndarray, shape of `gap`
            ``V`` (energy per area), ``-V'`` (pressure) and ``V''`` (pressure per
            length).
        """

    def inverse(self, pressure: np.ndarray) -> Profile:
        """Return the gaps at given pressures, for `invertible` walls.

        Parameters
        ----------
        pressure : ndarray, shape (k,)
            Pressures, not negative (pressure).

        Returns
        -------
        gap, exact, stiffness : ndarray, shape (k,)
            Gaps with small errors, and the exact pressure and stiffness at these gaps.
            At zero pressure the gap, and with it the stiffness, is just within the
            range of the wall.
        """
        raise NotImplementedError(f"{type(self).__name__} has no inverse")

    @property
    def attractive(self) -> bool:
        """Whether the wall is attractive at any gap."""
        return self.work_of_adhesion > 0.0

    @property
    def purely_hard(self) -> bool:
        """Whether the wall is hard without attraction (linear complementarity)."""
        return self.hard and not self.attractive

    @property
    def plastic(self) -> bool:
        """Whether the pressure of the wall is limited by a hardness."""
        return self.hardness != math.inf  # NaN is refused as a hardness

    @property
    def family(self) -> str:
        """Class of walls with the same demands on grids and times.

        It is "attractive", or else "hard" or "soft".
        """
        return "attractive" if self.attractive else "hard" if self.hard else "soft"

    @property
    def kappa_repulsive(self) -> float:
        """Ratio `kappa` of the wall, by default of all hard or of all soft walls."""
        return self.kappa or (KAPPA_HARD if self.hard else KAPPA_REPULSIVE)

    @property
    def asperity_factor(self) -> float:
        """Radius of a first asperity in theory, relative to that under a hard wall."""
        return 1.0 if self.hard else ASPERITY_FACTOR_REPULSIVE

    @property
    def extrapolated_below(self) -> float:
        """Gap below which the potential is extrapolated; NaN without one (length)."""
        return math.nan

    @property
    def compared_with(self) -> str:
        """Kind of the wall with which a trade-off compares this one."""
        return "hard" if self.family == "soft" else "repulsive"

    @property
    def optimizer(self) -> str:
        """Name of the optimizer that relaxes a hard wall."""
        return "ActiveSet" if self.purely_hard else "NewtonKrylov"

    @property
    def stiffness_at_contact(self) -> float:
        """Stiffness where the wall begins to repel; infinity if it is hard."""
        if self.hard:
            return math.inf
        closest = np.nextafter(self.contact_distance, -np.inf)
        return float(self.evaluate(np.array([closest]))[2][0])

    @property
    def depends_on_history(self) -> bool:
        """Whether a state depends on the states before it."""
        return self.attractive or self.permanent

    def todict(self) -> dict:
        """Return kind and parameters as plain numbers and strings.

        By default these are the kind, or the name of a class without a kind, and the
        attributes of the object. Override this method if attributes are not numbers or
        strings.
        """
        return {"kind": vars(type(self)).get("kind", type(self).__name__), **vars(self)}


def scaled_attraction(
    wall: Interaction, gap: np.ndarray, factor: np.ndarray | None
) -> Profile:
    r"""Return energy, pressure and stiffness of a wall with a local work of adhesion.

    The wall is the sum of a repulsion and an attraction. The attraction is :math:`-w`
    up to the minimum of the energy, and the energy of the wall beyond it (Weeks,
    Chandler and Andersen). It is multiplied by the factor; range and repulsion stay the
    same.

    Parameters
    ----------
    wall : Interaction
        The wall.
    gap : ndarray, any shape
        Local gaps (length).
    factor : ndarray, shape of `gap`, or None
        Local work of adhesion relative to the wall's; None stands for one.

    Returns
    -------
    energy, pressure, stiffness : ndarray, shape of `gap`
        Values as from `Interaction.evaluate`.

    References
    ----------
    J. D. Weeks, D. Chandler, H. C. Andersen, J. Chem. Phys. 54, 5237 (1971).
    """
    energy, pressure, stiffness = wall.evaluate(gap)
    if factor is None:
        return energy, pressure, stiffness
    beyond = gap >= wall.contact_distance
    if wall.hard:  # the attraction continues at negative gaps, errors of a solver
        beyond = np.ones_like(beyond)
    scale = np.where(beyond, factor, 1.0)
    offset = np.where(beyond, 0.0, wall.work_of_adhesion * (1.0 - factor))
    return scale * energy + offset, scale * pressure, scale * stiffness


def wall_parameters() -> dict[str, tuple[type, ...]]:
    """Return the types of the parameters of all kinds of wall, by their names."""
    return types_of_parameters(WALLS)


def make_wall(
    kind: str,
    contact_modulus: float,
    spacing: float,
    parameters: Mapping[str, float | str],
) -> Interaction:
    """Make a wall from its kind and the parameters of a scene file.

    Parameters
    ----------
    kind : str
        One of `WALLS`.
    contact_modulus : float
        Contact modulus E* of the substrate (eV/Å^3).
    spacing : float
        Atomic spacing a0 (Å).
    parameters : mapping of str to float or str
        Values by name, in the units of the file, or text with a unit.

    Returns
    -------
    Interaction
        The wall.

    Raises
    ------
    ValueError
        If the kind is unknown, or a parameter is unknown, missing or out of range.
    """
    wall = WALLS.find(kind)
    values = wall.converted_parameters(parameters, spacing)
    return wall.for_substrate(contact_modulus, spacing, **values)
