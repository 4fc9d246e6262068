"""Specification of a sliding path: its control, targets, friction and spring."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ase_roughcontact._util.validation import finite_array, lookup, one_of, positive
from ase_roughcontact.contact.control import Control
from ase_roughcontact.interactions.friction import (
    COUPLINGS,
    Coupling,
    FrictionLaw,
    check_law,
)
from ase_roughcontact.interactions.rate_and_state import check_without_rate


@dataclass(frozen=True, kw_only=True)
class LateralControl:
    """Quantity that a sliding path prescribes laterally.

    Attributes
    ----------
    name : str
        Name of the targets in scenes, arguments and files.
    unit : {"nN", "Å"}
        Unit of targets that are given as numbers in a scene.
    held : bool
        Whether the indenter is held at the targets.
    sprung : bool
        Whether a spring holds the indenter.
    """

    name: str
    unit: str = "Å"
    held: bool = False
    sprung: bool = False

    @property
    def free(self) -> bool:
        """Whether nothing but friction holds the indenter."""
        return not (self.held or self.sprung)


#: Displacement of the indenter.
LATERAL_DISPLACEMENT = LateralControl(name="displacements", held=True)
#: Force on the indenter.
LATERAL_FORCE = LateralControl(name="forces", unit="nN")
#: Displacement of the base of a spring that moves the indenter.
LATERAL_BASE = LateralControl(name="bases", sprung=True)
#: Lateral quantities that a path can prescribe, by name.
LATERAL_CONTROLS = {
    each.name: each for each in (LATERAL_DISPLACEMENT, LATERAL_FORCE, LATERAL_BASE)
}


@dataclass(frozen=True, eq=False)
class SlidingSpecification:
    """Given targets, friction and options of a sliding path.

    Attributes
    ----------
    targets : ndarray, shape (steps,)
        Normal targets; one number is the target of all steps.
    friction : FrictionLaw
    lateral : ndarray, shape (steps, 2)
        Lateral targets along x and y; one column is along x alone.
    control : LateralControl
        Quantity of the lateral targets, which may be given by its name: displacements
        of the indenter (length), forces on it (force), or displacements of the base of
        a spring (length).
    spring : float or None
        Stiffness of the spring, for bases (force/length).
    coupling : {"neglected", "solved"}
        Whether tractions leave the pressure as it is, and the pressure the lateral
        displacement. Where atoms come into contact within a step, they stick as if they
        had been in contact since its beginning: load in several steps.

    Raises
    ------
    ValueError
        If a target is not finite, the numbers of targets differ, a name is unknown, or
        the spring is missing, or friction depends on the slip rate.
    TypeError
        If friction is no law.
    """

    targets: Any
    friction: FrictionLaw
    lateral: Any
    control: Any = LATERAL_DISPLACEMENT
    spring: float | None = None
    coupling: Coupling = "neglected"

    def __post_init__(self) -> None:
        """Check all, and make one pair of lateral targets for each step."""
        control = self.control
        if not isinstance(control, LateralControl):
            control = lookup(control, LATERAL_CONTROLS, "control")
        object.__setattr__(self, "control", control)
        one_of(COUPLINGS, coupling=self.coupling)
        check_spring(control, self.spring)
        check_law(self.friction)
        check_without_rate(self.friction)
        lateral = finite_array(control.name, self.lateral)
        if lateral.ndim == 1:
            lateral = np.stack([lateral, np.zeros(lateral.shape)], axis=1)
        if lateral.ndim != 2 or lateral.shape[1] != 2 or not len(lateral):
            raise ValueError(
                f"{control.name} must be numbers along x, or rows of two along x and "
                f"y, got an array of the shape {lateral.shape}"
            )
        object.__setattr__(self, "lateral", lateral)

    @property
    def coupled(self) -> bool:
        """Whether the coupling of normal and lateral motion is solved for."""
        return self.coupling != COUPLINGS[0]

    @property
    def parameters(self) -> dict[str, Any]:
        """Friction, spring and coupling, on which a state depends."""
        parameters = {
            "friction": self.friction.todict(),
            "spring": self.spring or 0.0,
        }
        if self.coupled:
            parameters["coupling"] = self.coupling
        return parameters

    def normal(self, control: Control) -> np.ndarray:
        """Return the normal targets, one for each step.

        Parameters
        ----------
        control : Control
            Quantity that the normal targets prescribe.

        Raises
        ------
        ValueError
            If a target is not finite, or there are neither one nor as many as steps.
        """
        targets, count = finite_array(control.plural, self.targets), len(self.lateral)
        if targets.shape not in ((), (count,)):
            raise ValueError(
                f"give one of {control.plural} for all {count} {self.control.name}, or "
                f"one for each, got {targets.size}"
            )
        return np.broadcast_to(targets, count)


def check_spring(control: LateralControl, spring: float | None) -> None:
    """Raise an error unless a path that moves a base, and only it, has a spring.

    Parameters
    ----------
    control : LateralControl
    spring : float or None
        Stiffness, None if it is not given (force per length).

    Raises
    ------
    ValueError
    """
    if control.sprung and spring is None:
        raise ValueError(
            "bases need a spring between base and indenter: give its stiffness"
        )
    if not control.sprung and spring is not None:
        raise ValueError(
            f"a spring needs bases as lateral targets, got {control.name}: give bases, "
            "or leave out its stiffness"
        )
    if spring is not None:
        positive(spring=spring)
