r"""Newton's equations at states of a contact, solved with a model of the half space.

For the changes :math:`x` of the pressure and :math:`z` of the height; see
`newton_system`:

.. math:: x + D (G x + z) = r, \qquad \sum x - s z = t .

With the circulant model :math:`C` in place of :math:`G` they are solved to a tenth of
the residual, which takes a single exact convolution. If the exact equations are not
satisfied well enough then, they are solved with the model as the preconditioner.
"""

from __future__ import annotations

import math

import numpy as np

from ase_roughcontact._util.kernels import linear_combination, norm, total
from ase_roughcontact.elasticity.circulant import CirculantModel, covering_model
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.solvers.dense import DenseContact
from ase_roughcontact.solvers.energy import ContactEnergy, EnergyState
from ase_roughcontact.solvers.gcr import gcr
from ase_roughcontact.solvers.increments import Increment
from ase_roughcontact.solvers.newton_system import NewtonSystem
from ase_roughcontact.solvers.options import NewtonKrylovOptions


class NewtonEquations:
    """Newton's equations of a contact.

    Parameters
    ----------
    energy : ContactEnergy
    options : NewtonKrylovOptions
    """

    def __init__(self, energy: ContactEnergy, options: NewtonKrylovOptions) -> None:
        self._energy, self._options = energy, options
        self._halfspace = energy.contact.halfspace
        self._model: CirculantModel | None = None
        self._model_work = 0
        small = max(self._halfspace.shape) <= options.dense_window
        self._most_dense = options.dense_atoms if small else 0
        self._dense = DenseContact(energy.contact, self._most_dense)

    @property
    def pairs(self) -> float:
        """FFT pairs so far, normalised to one pair on the grid of the half space."""
        full = math.prod(self._halfspace.grid)
        return self._halfspace.pairs + self._model_work / full

    def increment(
        self, state: EnergyState, convex: bool, reduction: float
    ) -> Increment | None:
        """Solve the equations at a state that is linearised in the gaps.

        Parameters
        ----------
        state : EnergyState
        convex : bool
            Whether a negative stiffness of the wall counts as zero.
        reduction : float
            Residual that may be left, relative to that of the state.

        Returns
        -------
        Increment or None
            None if nothing resists a change of height.
        """
        stiffness = state.stiffness[state.box.slices]
        if convex:
            stiffness = np.maximum(stiffness, 0.0)
        system, right, change = self._solve(state, stiffness, reduction)
        if change is None:
            return None
        increment = self._increment(state, change)
        if system.exact:
            return increment
        refined = self._refined(
            system,
            state,
            right,
            change,
            increment.opening,
            reduction,
            self._options.exact_residual,
        )
        return increment if refined is change else self._increment(state, refined)

    def inverse_step(
        self, state: EnergyState, reduction: float, tolerance: float
    ) -> EnergyState | None:
        """Return the state that solves the equations, linearised in the pressures.

        Parameters
        ----------
        state : EnergyState
            Linearised in the pressures.
        reduction : float
            Residual that may be left, relative to that of the state.
        tolerance : float
            Force at which the solver will stop.

        Returns
        -------
        EnergyState or None
            None if nothing resists a change of height.
        """
        if 0 < np.count_nonzero(state.stiffness) <= self._most_dense:
            new = self._dense_step(state, tolerance)
            if new is not None:
                return new
        stiffness = state.stiffness[state.box.slices]
        system, right, change = self._solve(state, stiffness, reduction)
        if change is None:
            return None
        new = self._changed(state, change)
        enough = self._options.inverse_residual * state.residual_norm
        if system.exact or new.residual_norm < enough:
            return new
        refined = self._refined(
            system,
            state,
            right,
            change,
            new.opening - state.opening,
            reduction,
            self._options.inverse_forcing,
        )
        return new if refined is change else self._changed(state, refined)

    def _dense_step(self, state: EnergyState, tolerance: float) -> EnergyState | None:
        """Return the state found by dense matrices; None without a step."""
        area, energy = self._halfspace.cell_area, self._energy

        def support(height: float) -> tuple[float, float]:
            force = energy.external(height)[1]
            return energy.spring_stiffness(height) / area, -force / area

        found = self._dense.solve(
            state.pressure,
            state.opening,
            state.height,
            support if energy.loaded else None,
            0.5 * tolerance / area,
        )
        if found.pressure is state.pressure:
            return None
        return energy.state(
            found.pressure,
            found.height,
            found.opening,
            exact=True,
            by_pressure=not found.converged,
        )

    def _solve(
        self, state: EnergyState, stiffness: np.ndarray, reduction: float
    ) -> tuple[NewtonSystem, np.ndarray, np.ndarray | None]:
        """Return the equations, their right-hand side, and the solution of the model.

        The solution is None if nothing resists a change of height.
        """
        spring, load = self._support(state)
        model = self._covering_model(state.box)
        work = model.work
        system = NewtonSystem(model, state.box, stiffness, spring)
        right = system.scaled(state.residual[state.box.slices])
        change = system.solve(right, load, reduction, self._options.krylov_steps)
        self._model_work += model.work - work
        return system, right, change

    def _support(self, state: EnergyState) -> tuple[float | None, float]:
        """Return the stiffness of springs per area of an atom, and the missing load."""
        if not self._energy.loaded:
            return None, 0.0
        area = self._halfspace.cell_area
        spring = self._energy.spring_stiffness(state.height) / area
        force = self._energy.external(state.height)[1]
        return spring, -force / area - total(state.pressure)

    def _covering_model(self, box: Box) -> CirculantModel:
        """Return a model that covers a box, the last one if it does."""
        if self._model is None or not self._model.box.contains(box):
            self._model = covering_model(self._halfspace, box)
        return self._model

    def _refined(
        self,
        system: NewtonSystem,
        state: EnergyState,
        right: np.ndarray,
        change: np.ndarray,
        opening: np.ndarray,
        reduction: float,
        limit: float,
    ) -> np.ndarray:
        """Solve the exact equations better, unless their residual is within a limit.

        The change of the opening by the given change is known.
        """
        box, options = state.box, self._options
        image = system.applied(change, opening[box.slices])
        accepted = limit * max(norm(right), norm(image))
        residual = linear_combination([(1.0, right), (-1.0, image)])
        if norm(residual) <= accepted:
            return change

        def apply(change: np.ndarray) -> np.ndarray:
            opening = self._increment(state, change).opening
            return system.applied(change, opening[box.slices])

        def precondition(residual: np.ndarray) -> np.ndarray:
            change = system.solve(residual, 0.0, reduction, options.krylov_steps)
            return np.append(residual, 0.0) if change is None else change

        work = system.work
        steps = options.exact_krylov_steps
        refined = change + gcr(apply, precondition, residual, accepted, steps)
        self._model_work += system.work - work
        return refined

    def _increment(self, state: EnergyState, change: np.ndarray) -> Increment:
        """Return the increment of a flat change of pressure and height."""
        pressure = np.zeros(state.pressure.shape)
        pressure[state.box.slices] = change[:-1].reshape(state.box.shape)
        return Increment(pressure, self._energy.opening(pressure), float(change[-1]))

    def _changed(self, state: EnergyState, change: np.ndarray) -> EnergyState:
        """Return the state after a flat change, without pressure out of contact."""
        box = state.box
        pressure = np.zeros(state.pressure.shape)
        held = state.stiffness[box.slices] > 0.0
        x = change[:-1].reshape(box.shape)
        pressure[box.slices] = (state.pressure[box.slices] + x) * held
        height = state.height + float(change[-1])
        return self._energy.state(pressure, height, by_pressure=True)
