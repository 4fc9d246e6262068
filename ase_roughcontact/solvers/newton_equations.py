r"""Newton's equations at states of a contact, solved with a model of the half space.

For the changes :math:`x` of the pressure and :math:`z` of the height; see
`newton_system`:

.. math:: x + D (G x + z) = r, \qquad \sum x - s z = t .

With the circulant model :math:`C` in place of :math:`G` they are solved to a tenth of
the residual, which takes a single exact convolution. If the exact equations are not
satisfied well enough then, they are solved with the model as the preconditioner.
"""

from __future__ import annotations

import numpy as np

from ase_roughcontact._util.kernels import linear_combination, norm, total
from ase_roughcontact.elasticity.circulant import CirculantModel
from ase_roughcontact.solvers.energy import ContactEnergy, EnergyState
from ase_roughcontact.solvers.gcr import gcr
from ase_roughcontact.solvers.increments import Increment
from ase_roughcontact.solvers.newton_system import NewtonSystem

# Largest number of Krylov steps with the model, and with the exact Green's function.
_STEPS, _EXACT_STEPS = 40, 10
# Relative residual of the exact equations that an increment may leave. Beyond it the
# model misleads: of 70 walls with strong attraction, one would stall.
_LARGEST_RESIDUAL = 1.0


class NewtonEquations:
    """Newton's equations at a state of a contact.

    Parameters
    ----------
    energy : ContactEnergy
    state : EnergyState
    model : CirculantModel
        Covers the box of the state.
    convex : bool
        Whether a negative stiffness of the wall counts as zero.
    """

    def __init__(
        self,
        energy: ContactEnergy,
        state: EnergyState,
        model: CirculantModel,
        convex: bool = False,
    ) -> None:
        self._energy, self._state, self._inside = energy, state, state.box.slices
        stiffness, spring, self._load = state.stiffness[self._inside], None, 0.0
        if convex:
            stiffness = np.maximum(stiffness, 0.0)
        if energy.loaded:  # per area of an atom
            spring = energy.spring_stiffness(state.height) / energy.area
            force = energy.external(state.height)[1]
            self._load = -force / energy.area - total(state.pressure)
        self._system = NewtonSystem(model, state.box, stiffness, spring)
        self._right = self._system.scaled(state.residual[self._inside])

    def increment(self, reduction: float) -> Increment | None:
        """Solve the equations at a state that is linearised in the gaps.

        Parameters
        ----------
        reduction : float
            Residual that may be left, relative to that of the state.

        Returns
        -------
        Increment or None
            None if nothing resists a change of height.
        """
        change = self._solution(reduction)
        if change is None:
            return None
        increment = self._increment(change)
        refined = self._refined(change, increment.opening, reduction)
        return increment if refined is change else self._increment(refined)

    def inverse_step(self, reduction: float) -> EnergyState | None:
        """Return the next state of one that is linearised in the pressures.

        Parameters
        ----------
        reduction : float
            Residual that may be left, relative to that of the state.

        Returns
        -------
        EnergyState or None
            None if nothing resists a change of height.
        """
        change = self._solution(reduction)
        if change is None:
            return None
        del self._system, self._right  # their memory is needed
        return self._changed(change)

    def _solution(self, reduction: float) -> np.ndarray | None:
        """Return the flat change that solves the equations of the model."""
        return self._system.solve(self._right, self._load, reduction, _STEPS)

    def _refined(
        self, change: np.ndarray, opening: np.ndarray, reduction: float
    ) -> np.ndarray:
        """Solve the exact equations better, unless their residual is within a limit.

        The change of the opening by the given change is known.
        """
        system, inside = self._system, self._inside
        image = system.applied(change, opening[inside])
        left = linear_combination([(1.0, self._right), (-1.0, image)])
        accepted = _LARGEST_RESIDUAL * max(norm(self._right), norm(image))
        if system.exact or norm(left) <= accepted:
            return change

        def apply(change: np.ndarray) -> np.ndarray:
            return system.applied(change, self._increment(change).opening[inside])

        def precondition(residual: np.ndarray) -> np.ndarray:
            change = system.solve(residual, 0.0, reduction, _STEPS)
            return np.append(residual, 0.0) if change is None else change

        return change + gcr(apply, precondition, left, accepted, _EXACT_STEPS)

    def _increment(self, change: np.ndarray) -> Increment:
        """Return the increment of a flat change of pressure and height."""
        pressure = np.zeros(self._state.pressure.shape)
        pressure[self._inside] = change[:-1].reshape(self._state.box.shape)
        return Increment(pressure, self._energy.opening(pressure), float(change[-1]))

    def _changed(self, change: np.ndarray) -> EnergyState:
        """Return the state after a flat change, without pressure out of contact."""
        state, inside = self._state, self._inside
        pressure = np.zeros(state.pressure.shape)
        held = state.stiffness[inside] > 0.0
        x = change[:-1].reshape(state.box.shape)
        pressure[inside] = (state.pressure[inside] + x) * held
        height = state.height + float(change[-1])
        return self._energy.state(pressure, height, by_pressure=True)
