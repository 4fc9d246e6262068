"""Accuracy of a path: an allowed relative error, and the force tolerance it requires.

The error is that of the answer to the question asked: for the model of atoms that of
the solver, for the continuum also that of the grid, see `grid_for`. It does not cover
the wall and its cutoff.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ase_roughcontact._util.validation import positive, unknown
from ase_roughcontact.contact import ContactState

# Largest ratio of the relative error in the normal force to the relative tolerance of
# the forces on atoms. No ratio is safe at an instability.
_ERROR_PER_TOLERANCE = 4.0
# Force on an atom in contact before any is known, in units of E* a0^2: about that on
# self-affine surfaces of a rms slope of 0.1.
_TYPICAL_FORCE = 0.05
# Smallest tolerance in units of E* a0^2: rounding errors of the forces.
_ROUNDING = 1e-13
# A tolerance is this part of the one that the mean force in the last state requires,
# since that of the next state may be smaller. A reduced tolerance is this part of the
# required one, so that the next state does not need another reduction.
_MARGIN = 0.8
_REDUCTION = 0.5


@dataclass(frozen=True)
class Accuracy:
    """Allowed error, and the relative tolerance of forces for it.

    Attributes
    ----------
    error : float
        Largest error of the normal force, relative to the sum of the magnitudes of the
        forces in contact, and of the contact area, relative to it, beyond one atom.
        States at an instability are excepted, and for the continuum contacts of few
        grid points.
    tolerance : float
        Largest remaining force on any atom, relative to the mean force on the atoms in
        contact.
    """

    error: float
    tolerance: float


#: Relative errors of the area of the continuum by name, at contact radii above 32 times
#: the shortest wavelength.
LEVELS = {"fast": 0.05, "normal": 0.01, "high": 0.002}
#: Relative error of force and area for the model of atoms, where nothing but the
#: tolerance is numerical.
OF_ATOMS = 1e-4
# Part of the error of the continuum that the solver may contribute.
_SOLVER_PART = 0.1


def accuracy_of(wanted: str | float, continuum: bool = False) -> Accuracy:
    """Return the accuracy of a name, or for a relative error in force and area.

    Parameters
    ----------
    wanted : {"fast", "normal", "high"} or float
        A number is a relative error, from 1e-12 to below 1.
    continuum : bool
        Whether the continuum is asked for. For the model of atoms all names mean the
        same.

    Returns
    -------
    Accuracy

    Raises
    ------
    ValueError
        If the name is unknown, or the error out of range.
    """
    if isinstance(wanted, str):
        if wanted not in LEVELS:
            raise ValueError(unknown(wanted, list(LEVELS), "accuracy"))
        error = LEVELS[wanted] if continuum else OF_ATOMS
    else:
        positive(accuracy=wanted)
        if not 1e-12 <= wanted < 1.0:
            raise ValueError(
                f"accuracy must be a relative error from 1e-12 to 1, got {wanted:g}"
            )
        error = float(wanted)
    part = _SOLVER_PART if continuum else 1.0
    return Accuracy(error, part * error / _ERROR_PER_TOLERANCE)


class ForceTolerance:
    r"""Tolerance of forces relative to the mean magnitude of those in contact.

    .. math:: f_\max = \max\left(t \, \frac{\sum_{i \le n} |p_i| a_0^2}{n},\,
              10^{-13} E^* a_0^2\right)

    with the relative tolerance :math:`t` and the :math:`n` atoms in contact, some of
    which are under tension if a hard wall attracts, or all atoms on which the wall acts
    if their mean force is larger. The mean force is that of the state relaxed last.

    Parameters
    ----------
    relative : float
        The relative tolerance.
    unit : float
        ``E* a0^2`` (force).
    """

    def __init__(self, relative: float, unit: float) -> None:
        self._relative = relative
        self._mean_force = _TYPICAL_FORCE * unit
        self._smallest = _ROUNDING * unit

    def expected(self, load: float) -> float:
        """Return the tolerance for a state that is not known yet.

        Parameters
        ----------
        load : float
            Load on the indenter, if positive: a single atom carries no more.

        Returns
        -------
        float
        """
        mean_force = _MARGIN * self._mean_force
        return self._for(min(mean_force, load) if load > 0.0 else mean_force)

    def reduced(self, tolerance: float, state: ContactState) -> float | None:
        """Return the tolerance with which to continue; None if the last one suffices.

        Parameters
        ----------
        tolerance : float
            To which the state was relaxed.
        state : ContactState

        Returns
        -------
        float or None
        """
        if not state.repulsive_atoms:
            return None
        # atoms that are about to lose contact carry nothing
        magnitude = abs(state.pressure)
        mean = float(magnitude.sum()) / max(int(np.count_nonzero(magnitude)), 1)
        self._mean_force = max(state.contact_pressure, mean) * state.cell_area
        required = self._for(self._mean_force)
        if tolerance <= required:
            return None
        return max(_REDUCTION * required, self._smallest)

    def _for(self, mean_force: float) -> float:
        return max(self._relative * mean_force, self._smallest)
