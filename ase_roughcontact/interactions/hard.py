"""Hard walls of elastic and of elastic-plastic solids, without attraction."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ase_roughcontact._util.parameter import Parameter
from ase_roughcontact._util.validation import boolean, positive
from ase_roughcontact.interactions.base import Interaction, Profile


@dataclass(frozen=True)
class HardWall(Interaction):
    """Impenetrable wall: ``g >= 0, p >= 0, g p = 0``.

    The pressure is the reaction to the constraint, not a function of the gap, so that
    relaxation needs a solver for constraints, `ActiveSet`.

    Examples
    --------
    >>> from ase_roughcontact import HardWall, RoughContact, RoughSphere
    >>> RoughContact(RoughSphere(100.0), 1.0, HardWall()).parameters['wall'].hard
    True
    """

    kind = "hard"
    hard = True
    cutoff = 0.0
    contact_distance = 0.0
    work_of_adhesion = 0.0
    attraction_range = 0.0

    def evaluate(self, gap: np.ndarray) -> Profile:
        """Return zero, and infinity at negative gaps; see `Interaction.evaluate`."""
        wall = np.where(np.asarray(gap, dtype=float) < 0.0, np.inf, 0.0)
        return wall, wall.copy(), wall.copy()


@dataclass(frozen=True)
class PlasticWall(HardWall):
    """Hard wall with pressures up to the hardness of a perfectly plastic solid.

    An atom is out of contact, ``g >= 0, p = 0``, in elastic contact, ``g = 0, 0 <= p <=
    H``, or in plastic contact, ``g <= 0, p = H``. The overlap in plastic contact is the
    plastic depth, by which the material has flowed. The energy of the wall is the work
    of the flow, H times the depth. The load is at most H times the area.

    Parameters
    ----------
    hardness : float
        Hardness H (pressure; for atoms in eV/Å^3, where 1 GPa is `ase.units.GPa`).
    permanent : bool
        Whether a path keeps the plastic shape: after each step the surface is lowered
        by its plastic depth, so that it unloads elastically. By default each state is
        the state of a single loading.

    Raises
    ------
    ValueError
        If the hardness is not a positive number or infinity.

    References
    ----------
    A. Almqvist, F. Sahlin, R. Larsson, S. Glavatskih, Tribol. Int. 40, 574 (2007).

    Examples
    --------
    >>> from ase_roughcontact import PlasticWall, RoughContact, RoughSphere, load_path
    >>> from ase_roughcontact import substrate
    >>> sphere = RoughSphere(radius=200.0)
    >>> atoms = substrate('Cu', (16, 16), sphere, spacing=1.0, fixed=False)
    >>> atoms.calc = RoughContact(sphere, 1.0, PlasticWall(hardness=0.02))
    >>> (step,) = load_path(atoms, loads=[2.0])
    >>> round(step.largest_pressure, 3), step.plastic_atoms > 0
    (0.02, True)
    """

    kind = "plastic"
    label = "hard wall with plastic flow"
    parameters = {
        "hardness": Parameter("GPa"),
        "permanent": Parameter(default=False),
    }

    hardness: float = field()  # without the default of the base class, infinity
    permanent: bool = False

    def __post_init__(self) -> None:
        """Check the hardness."""
        boolean(permanent=self.permanent)
        if self.plastic:
            positive(hardness=self.hardness)

    def evaluate(self, gap: np.ndarray) -> Profile:
        """Return the work of the plastic flow, the hardness and zero at negative gaps.

        All three are zero at positive gaps. At a gap of zero the pressure is the
        reaction of the wall, which the gap does not determine.
        """
        if not self.plastic:
            return super().evaluate(gap)
        overlap = np.maximum(-np.asarray(gap, dtype=float), 0.0)
        pressure = self.hardness * (overlap > 0.0)
        return self.hardness * overlap, pressure, np.zeros(overlap.shape)
