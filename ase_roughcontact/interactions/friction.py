r"""Friction laws: the largest lateral traction of an atom in contact.

An atom sticks while the magnitude of its traction is below this bound, and slips when
the magnitude is equal to the bound. A law with memory declares `histories`, on which
the bound depends; a bound that depends on the slip declares `SLIP`.
"""

from __future__ import annotations

import inspect
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar, Literal, TypeAlias, get_args

import numpy as np

from ase_roughcontact._util.history import HistoryEntry, declare
from ase_roughcontact._util.parameter import Parameter
from ase_roughcontact._util.registry import Registered, Registry
from ase_roughcontact._util.validation import positive, shown

#: Whether the coupling of normal and lateral motion is neglected (Goodman), or solved
#: for.
Coupling: TypeAlias = Literal["neglected", "solved"]
COUPLINGS = get_args(Coupling)
#: Friction laws by their `kind`; filled by the definition of subclasses.
LAWS: Registry[type[FrictionLaw]] = Registry("kind of friction law")
#: Length of the way that an atom has slipped since it came into contact.
SLIP = declare(HistoryEntry("slip", "Å", in_frames=True))
# Arguments of `FrictionLaw.bound`, and arguments of laws without memory.
_ARGUMENTS = ("pressure", "slip", "rate", "time", "history", "x", "y")
_PLACE_ARGUMENTS = ("pressure", "x", "y")


class FrictionLaw(Registered, ABC):
    """Base class of friction laws; a subclass defines `bound`.

    A law without memory may define ``bound(pressure, x, y)``. A subclass with a `kind`
    can be used in scene files, too; its `parameters` are keys of the section
    ``[friction]``.

    Attributes
    ----------
    histories : tuple of HistoryEntry
        What the law remembers of each atom in contact, kept in files; by default
        nothing. The definition of the class declares the entries. `SLIP`, the length of
        the way that an atom has slipped, is kept by the path; other entries change by
        `evolved`. An atom that leaves the contact has their `HistoryEntry.entering`.

    Raises
    ------
    TypeError
        By the definition of a subclass, if `bound` has other arguments.
    """

    registry = LAWS
    histories: ClassVar[tuple[HistoryEntry, ...]] = ()

    def __init_subclass__(cls) -> None:
        """Check `bound`, declare the histories, and register a class with a kind."""
        forms = (_ARGUMENTS, _PLACE_ARGUMENTS)
        if not any(_accepts(cls.bound, arguments) for arguments in forms):
            raise TypeError(
                f"{cls.__name__}.bound has the arguments "
                f"{inspect.signature(cls.bound)}, expected (self, "
                f"{', '.join(_ARGUMENTS)}), or without memory (self, "
                f"{', '.join(_PLACE_ARGUMENTS)})"
            )
        super().__init_subclass__()
        for entry in cls.histories:
            declare(entry)

    @property
    def weakens(self) -> bool:
        """Whether the bound depends on the slip."""
        return SLIP in self.histories

    @abstractmethod
    def bound(
        self,
        pressure: np.ndarray,
        slip: np.ndarray,
        rate: np.ndarray,
        time: float,
        history: Mapping[str, np.ndarray],
        x: np.ndarray,
        y: np.ndarray,
    ) -> np.ndarray:
        """Return the largest magnitude of the traction.

        Parameters
        ----------
        pressure : ndarray, shape (k,)
            Pressures on the atoms in contact, negative where a hard wall attracts
            (pressure).
        slip : ndarray, shape (k,)
            Length of the way that each atom has slipped since it came into contact; NaN
            unless the law has the history `SLIP` (length).
        rate : ndarray, shape (k,)
            Slip per time; NaN on sliding paths, which are without time (length/time).
        time : float
            Time; NaN on sliding paths (time).
        history : mapping of str to ndarray of shape (k,)
            Histories of the law at the start of the step.
        x, y : ndarray, shape (k,)
            Positions of these atoms from the indenter's axis (length).

        Returns
        -------
        ndarray, shape (k,)
            Bounds (pressure); negative values count as zero.
        """

    def evolved(
        self,
        pressure: np.ndarray,
        slip: np.ndarray,
        rate: np.ndarray,
        time: float,
        history: Mapping[str, np.ndarray],
        x: np.ndarray,
        y: np.ndarray,
    ) -> Mapping[str, np.ndarray]:
        """Return the histories at the end of a step; by default they do not change.

        Parameters
        ----------
        pressure, slip, rate, time, history, x, y
            See `bound`; pressure and slip at the end of the step.

        Returns
        -------
        mapping of str to ndarray of shape (k,)
            Values of the histories, but of `SLIP`.
        """
        return history

    def todict(self) -> dict[str, Any]:
        """Return the name and the parameters, which identify the law in files."""
        return {"name": type(self).__name__, **vars(self)}


def bound_of(
    law: FrictionLaw,
    pressure: np.ndarray,
    slip: np.ndarray,
    rate: np.ndarray,
    time: float,
    history: Mapping[str, np.ndarray],
    x: np.ndarray,
    y: np.ndarray,
) -> np.ndarray:
    """Return `FrictionLaw.bound`, also of a law without memory."""
    if _accepts(type(law).bound, _ARGUMENTS):
        return law.bound(pressure, slip, rate, time, history, x, y)
    place_only: Callable[..., np.ndarray] = law.bound
    return place_only(pressure, x, y)


@lru_cache
def _accepts(method: Callable[..., Any], arguments: tuple[str, ...]) -> bool:
    """Return whether a method can be called with this number of arguments."""
    try:
        inspect.signature(method).bind(None, *arguments)
    except TypeError:
        return False
    return True


def law_of(kind: str | None, given: Mapping[str, Any]) -> type[FrictionLaw]:
    """Return the class of a friction law of a scene file.

    Parameters
    ----------
    kind : str or None
        One of `LAWS`; None for the first law that the given keys fit.
    given : mapping of str to float or str
        Parameters of the law in the file.

    Raises
    ------
    ValueError
        If there is no such law.
    """
    if kind is not None:
        return LAWS.find(kind)
    fitting = [law for law in LAWS.values() if _fits(given, law)]
    if not fitting:
        raise ValueError("give coefficient, shear_strength, or both")
    return fitting[0]


def make_law(kind: str | None, given: Mapping[str, Any], spacing: float) -> FrictionLaw:
    """Make the friction law of a scene file.

    Parameters
    ----------
    kind, given
        See `law_of`; values in the units of the file, or with a unit.
    spacing : float
        Atomic spacing a0 (Å).

    Raises
    ------
    ValueError
        If there is no such law, or a parameter is unknown, missing or out of range.
    """
    law = law_of(kind, given)
    return law.of_parameters(**law.converted_parameters(given, spacing))


def _fits(given: Mapping[str, Any], law: type[FrictionLaw]) -> bool:
    """Return whether the keys of a section are the parameters of a law."""
    needed = {name for name, each in law.parameters.items() if each.required}
    return needed <= given.keys() <= law.parameters.keys()


def check_law(friction: Any) -> None:
    """Raise `TypeError` if an object is not a friction law."""
    if not isinstance(friction, FrictionLaw):
        raise TypeError(
            f"friction must be a law such as Coulomb(0.3), got {shown(friction)}"
        )


@dataclass(frozen=True)
class Coulomb(FrictionLaw):
    r"""Coulomb friction, proportional to the pressure and limited by a shear strength.

    .. math:: |t| \le \min(\mu p, \tau)

    Parameters
    ----------
    coefficient : float
        Friction coefficient mu.
    strength : float
        Largest traction tau; by default infinity (pressure).

    Raises
    ------
    ValueError
        If a parameter is not positive.
    """

    kind = "coulomb"
    parameters = {
        "coefficient": Parameter(),
        "shear_strength": Parameter("GPa", optional=True),
    }

    coefficient: float
    strength: float = math.inf

    def __post_init__(self) -> None:
        positive(coefficient=self.coefficient)
        if self.strength != math.inf:
            positive(strength=self.strength)

    @classmethod
    def of_parameters(cls, **parameters: float) -> Coulomb:
        """Return the law; the shear strength may be missing."""
        strength = parameters.get("shear_strength", math.inf)
        return cls(parameters["coefficient"], strength)

    def bound(self, pressure: np.ndarray, *others: Any) -> np.ndarray:
        """Return ``min(mu p, tau)``; see `FrictionLaw`."""
        return np.minimum(self.coefficient * pressure, self.strength)


@dataclass(frozen=True)
class Tresca(FrictionLaw):
    """Tresca friction: one shear strength for all atoms in contact, at any pressure.

    The bound jumps at the edge of the contact: steps with ``coupling="solved"`` may
    have no solution, and then do not converge. `Coulomb` with a strength has no jump.

    Parameters
    ----------
    strength : float
        Largest traction (pressure).

    Raises
    ------
    ValueError
        If the strength is not positive.
    """

    kind = "tresca"
    parameters = {"shear_strength": Parameter("GPa")}

    strength: float

    def __post_init__(self) -> None:
        positive(strength=self.strength)

    @classmethod
    def of_parameters(cls, **parameters: float) -> Tresca:
        """Return the law of a shear strength."""
        return cls(parameters["shear_strength"])

    def bound(self, pressure: np.ndarray, *others: Any) -> np.ndarray:
        """Return the strength; see `FrictionLaw`."""
        return np.full(pressure.shape, self.strength)
