"""Controlled quantities of a path: penetration, height, load, or height of a base."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ase_roughcontact._util.validation import lookup


@dataclass(frozen=True, kw_only=True)
class Control:
    """Quantity that a path prescribes.

    Attributes
    ----------
    name : str
        Name in scenes, tables and frames.
    plural : str
        Name of arguments that take the targets.
    unit : {"nN", "Å"}
        Unit of targets that are given as numbers in a scene.
    column : str
        Column of a result with the value of the quantity.
    prescribed : tuple of str
        Columns of a result that have no error, as they are given.
    free : bool
        Whether the indenter is free to move.
    deeper : {1.0, -1.0}
        Sign of a change of the target that presses the indenter deeper.
    from_contact : bool
        Whether targets are measured from the height of the first contact.
    """

    name: str
    plural: str
    unit: str
    column: str
    prescribed: tuple[str, ...]
    free: bool
    deeper: float
    from_contact: bool = False

    def height(self, target: float, first_contact: float) -> float:
        """Return the height of a fixed indenter at a target (length).

        Parameters
        ----------
        target : float
            Penetration or height (length).
        first_contact : float
            Height at which the indenter begins to repel the flat surface (length).
        """
        return self._origin(first_contact) - self.deeper * target

    def target(self, height: float, first_contact: float) -> float:
        """Return the target at which a fixed indenter is at a height (length).

        Parameters
        ----------
        height, first_contact : float
            See `height`.
        """
        return self.deeper * (self._origin(first_contact) - height)

    def _origin(self, first_contact: float) -> float:
        return first_contact if self.from_contact else 0.0

    def depths(self, targets: np.ndarray) -> np.ndarray:
        """Return the depths of targets that are lengths.

        A penetration is a depth; the depth of a height is counted from the largest one.
        """
        return targets if self.from_contact else targets.max() - targets

    def conjugate(self, force: float, height: float) -> float:
        """Return the derivative of the energy with respect to the target.

        The energy under a load includes the potential of the load.

        Parameters
        ----------
        force : float
            Normal force on the indenter, positive in compression (force).
        height : float
            Height of the indenter (length).

        Returns
        -------
        float
            Height of the indenter under a load (length), otherwise the force that does
            work on the target (force).
        """
        return height if self == LOAD else self.deeper * force


PENETRATION = Control(
    name="penetration",
    plural="penetrations",
    unit="Å",
    column="penetration",
    prescribed=("height", "penetration"),
    free=False,
    deeper=1.0,
    from_contact=True,
)
HEIGHT = Control(
    name="height",
    plural="heights",
    unit="Å",
    column="height",
    prescribed=("height",),
    free=False,
    deeper=-1.0,
)
LOAD = Control(
    name="load",
    plural="loads",
    unit="nN",
    column="normal_force",
    prescribed=("normal_force",),
    free=True,
    deeper=1.0,
)
#: Height of the base of a cantilever that holds the indenter.
BASE = Control(
    name="base",
    plural="bases",
    unit="Å",
    column="base",
    prescribed=(),
    free=True,
    deeper=-1.0,
)
#: Controlled quantities by name.
CONTROLS = {each.name: each for each in (PENETRATION, HEIGHT, LOAD, BASE)}


def control_of(control: Control | str) -> Control:
    """Return a controlled quantity.

    Parameters
    ----------
    control : Control or str
        Name such as "load", or name of the targets such as "loads".

    Raises
    ------
    ValueError
        If the name is unknown.
    """
    if isinstance(control, Control):
        return control
    plurals = {each.plural: each for each in CONTROLS.values()}
    return lookup(control, CONTROLS | plurals, "control")
