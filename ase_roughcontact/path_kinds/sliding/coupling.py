r"""Coupling of the normal and the lateral motion of a contact with friction.

Tractions t lift the surface by :math:`\sum_a C_a * t_a`, and the pressure displaces it
sideways by :math:`C_a * p` (see `CrossResponse`): p is solved with heights
:math:`h - \sum_a C_a * t_a`, and atoms that stick resist changes of :math:`C_a * p`
since the last step. The normal and the lateral problem are solved in turn until the
depth by the tractions no longer changes. The next depth is extrapolated from the last
ones.

References
----------
D. G. Anderson, J. ACM 12, 547 (1965).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from ase_roughcontact.contact import Problem, State
from ase_roughcontact.contact.state import TRACTION_DEPTH
from ase_roughcontact.elasticity.lateral import CrossResponse
from ase_roughcontact.elasticity.lattice import Box, carried
from ase_roughcontact.path_kinds.sliding.lateral_state import LateralState
from ase_roughcontact.solvers.status import Status, StatusKind
from ase_roughcontact.stepping.relaxed import RelaxedStep

#: Largest number of alternations of a step.
MAX_ALTERNATIONS = 50
# Change of the depth by the tractions, relative to the largest displacement, at which
# normal and lateral problem agree, in units of the accuracy.
_AGREEMENT = 0.1
# Largest value of this change.
_MAX_AGREEMENT = 1e-5
#: Residual of the first lateral problem; of the others, relative to the change of the
#: depth.
FIRST_RESIDUAL = 0.1
# Number of earlier depths that are mixed.
_MIXED_DEPTHS = 5
# Relative error of their weights.
_WEIGHT_ERROR = 1e-3
# Number of boxes with responses that are kept.
_KEPT_RESPONSES = 3

#: Kind of a status: normal and lateral contact have no common solution.
DISAGREEMENT = StatusKind(
    "normal and lateral motion do not agree after {number} alternations: the depth by "
    "the tractions changes by {change:.2g} of the largest displacement",
    "strong friction, or a bound that jumps at the edge of the contact, may have no "
    "solution: with a shear strength, give a friction coefficient, too",
)


class Coupling:
    """Displacements of the surface across the direction of the tractions.

    Parameters
    ----------
    problem : Problem
    accuracy : float
        Relative error of forces.

    Attributes
    ----------
    agreed : float
        Change of the depth by the tractions, relative to the largest displacement, at
        which the normal and the lateral problem agree.

    Raises
    ------
    NotImplementedError
        If the solid has no coupled components.
    """

    def __init__(self, problem: Problem, accuracy: float) -> None:
        self.agreed = min(_AGREEMENT * accuracy, _MAX_AGREEMENT)

        @lru_cache(_KEPT_RESPONSES)
        def response(shape: tuple[int, int]) -> CrossResponse:
            return CrossResponse(
                shape,
                problem.spacing,
                problem.solid,
                problem.periodic,
                **problem.fft,
            )

        response((2, 2))  # raises if the solid has none
        self._response = response

    def lateral(self, state: State, box: Box) -> np.ndarray:
        """Return the lateral displacement of a box by the pressure, shape (2, n, m)."""
        whole = state.window.union(box)
        pressure = carried(state.pressure, state.window, whole)
        rows, columns = box.slices_in(whole)
        return self._response(whole.shape).lateral(pressure)[:, rows, columns]

    def depth(self, tractions: np.ndarray, box: Box, window: Box) -> np.ndarray:
        """Return the depth of a window by tractions on a box, shape (n, m)."""
        whole = window.union(box)
        given = np.stack([carried(each, box, whole) for each in tractions])
        return -self._response(whole.shape).normal(given)[window.slices_in(whole)]

    def change(
        self, relaxed: RelaxedStep, lateral: LateralState
    ) -> tuple[np.ndarray, float]:
        """Return the depth by the tractions, and its change since the pressure."""
        state = relaxed.state
        depth = self.depth(lateral.solution.tractions, lateral.box, state.window)
        change = abs(depth - state.history.get(TRACTION_DEPTH, 0.0)).max()
        largest = 0.0 if state.displacement is None else abs(state.displacement).max()
        return depth, float(change / largest) if largest else float(change > 0.0)


def mixed(depths: Sequence[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """Return the depth from which to go on, by Anderson's mixing.

    The depth that follows from another one is taken as a linear function of it: weights
    of the earlier ones minimise the difference of both.

    Parameters
    ----------
    depths : sequence of (ndarray, ndarray), each of shape (n, m)
        Depths at which the normal problem was solved, and depths by the tractions that
        followed, in order.

    Returns
    -------
    ndarray, shape (n, m)
    """
    given, found = depths[-1]
    earlier = depths[-1 - _MIXED_DEPTHS : -1]
    others = [pair for pair in earlier if pair[0].shape == given.shape]
    if not others:
        return found
    residual = (found - given).ravel()
    differences = [
        residual - (other_found - other_given).ravel()
        for other_given, other_found in others
    ]
    matrix = np.stack(differences, axis=1)
    weights, *_ = np.linalg.lstsq(matrix, residual, rcond=_WEIGHT_ERROR)
    correction = np.zeros(found.shape)
    for weight, (_, other_found) in zip(weights, others, strict=True):
        correction += weight * (found - other_found)
    return found - correction


def disagreement(number: int, change: float) -> Status:
    """Return that both problems do not agree after a number of alternations."""
    return Status(DISAGREEMENT, {"number": number, "change": change})
