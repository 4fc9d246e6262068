r"""Friction laws: the largest lateral traction of an atom in contact.

An atom sticks while the magnitude of its traction is below this bound, and slips when
the magnitude is equal to the bound.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ase_roughcontact._util.parameter import Parameter
from ase_roughcontact._util.registry import Registered, Registry
from ase_roughcontact._util.validation import positive, shown

#: Whether the coupling of normal and lateral motion is neglected (Goodman), or solved
#: for.
COUPLINGS = ("neglected", "solved")
#: Friction laws by their `kind`; filled by the definition of subclasses.
LAWS: Registry[type[FrictionLaw]] = Registry("kind of friction law")


class FrictionLaw(Registered, ABC):
    """Base class of friction laws; a subclass defines `bound`.

    A subclass with a `kind` can be used in scene files, too; its `parameters` are keys
    of the section ``[friction]``.
    """

    registry = LAWS

    @abstractmethod
    def bound(self, pressure: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the largest magnitude of the traction.

        Parameters
        ----------
        pressure : ndarray, shape (k,)
            Pressures on the atoms in contact, negative where a hard wall attracts
            (pressure).
        x, y : ndarray, shape (k,)
            Positions of these atoms from the indenter's axis (length).

        Returns
        -------
        ndarray, shape (k,)
            Bounds (pressure); negative values count as zero.
        """

    def bounds(
        self,
        pressure: np.ndarray,
        contact: np.ndarray,
        spacing: float,
        origin: tuple[float, float],
    ) -> np.ndarray:
        """Return the largest magnitude of the traction of each atom of a window.

        Parameters
        ----------
        pressure : ndarray, shape (n, m)
            Pressures of the atoms, see `bound`.
        contact : ndarray of bool, shape (n, m)
            Whether each atom is in contact.
        spacing : float
            Distance of the atoms (length).
        origin : (float, float)
            Position of the first atom from the indenter's axis (length).

        Returns
        -------
        ndarray, shape (n, m)
            Bounds (pressure), at least zero; zero for atoms out of contact.

        Raises
        ------
        ValueError
            If `bound` does not return a number for each atom in contact.
        """
        bounds = np.zeros(pressure.shape)
        i, j = contact.nonzero()
        x, y = origin[0] + spacing * i, origin[1] + spacing * j
        values = np.asarray(self.bound(pressure[i, j], x, y), dtype=float)
        if values.shape not in ((), i.shape) or np.isnan(values).any():
            raise ValueError(
                f"{type(self).__name__}.bound must return a number for each of the "
                f"{i.size} atoms in contact, got {values.size} with "
                f"{np.isnan(values).sum()} of NaN"
            )
        bounds[i, j] = np.maximum(values, 0.0)
        return bounds

    def todict(self) -> dict[str, Any]:
        """Return the name and the parameters, which identify the law in files."""
        return {"name": type(self).__name__, **vars(self)}


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

    def bound(self, pressure: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
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

    def bound(self, pressure: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the strength; see `FrictionLaw`."""
        return np.full(pressure.shape, self.strength)
