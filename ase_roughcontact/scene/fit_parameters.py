"""Parameters of a scene that a fit can change, and derivatives of forces to them.

The derivatives come from the adjoint equations of a relaxed state, see
`ase_roughcontact.solvers.response`; those of heights, wall and compliance, which are
explicit functions of the parameters, are differences.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import FloatArray
from ase_roughcontact.contact import ContactState
from ase_roughcontact.elasticity.named_materials import material
from ase_roughcontact.interactions import Interaction, scaled_attraction
from ase_roughcontact.interactions.base import Profile
from ase_roughcontact.paths.step import Stepper
from ase_roughcontact.scene.scene import Scene
from ase_roughcontact.solvers.response import force_derivative, height_response

#: Keys of the parameters that can be free, and their units.
FREE = {
    "work_of_adhesion": ("interaction.work_of_adhesion", "J/m²"),
    "contact_modulus": ("substrate.contact_modulus", "GPa"),
    "radius": ("sphere.radius", "nm"),
    "attraction_range": ("interaction.attraction_range", "nm"),
}
# Relative change of a parameter for differences of explicit functions.
_CHANGE = 1e-6
# Relative residual of the adjoint equations.
_RESIDUAL = 1e-8


def value_of(scene: Scene, name: str) -> float:
    """Return a parameter of `FREE` in its unit.

    Parameters
    ----------
    scene : Scene
    name : str

    Returns
    -------
    float
    """
    if name == "radius" and scene.whole_tip is not None:
        raise ValueError(
            "radius can't be fitted: the scan is the whole tip (radius = inf)"
        )
    values = {
        "work_of_adhesion": scene.wall.work_of_adhesion,
        "contact_modulus": _of_sample(scene),
        "radius": scene.radius,
        "attraction_range": scene.wall.attraction_range,
    }
    return values[name] / UNITS[FREE[name][1]]


def _of_sample(scene: Scene) -> float:
    """Return E* of the sample, without that of an elastic tip (eV/Å^3)."""
    if not scene.sphere.material:
        return scene.contact_modulus
    tip = material(scene.sphere.material).contact_modulus * UNITS["GPa"]
    return 1.0 / (1.0 / scene.contact_modulus - 1.0 / tip)


def changed(scene: Scene, values: Mapping[str, float]) -> Scene:
    """Return a scene with other values of parameters.

    Parameters
    ----------
    scene : Scene
    values : mapping of str to float
        In the units of `FREE`.

    Returns
    -------
    Scene
    """
    return scene.with_values(
        {FREE[name][0]: f"{v:.17g} {FREE[name][1]}" for name, v in values.items()}
    )


class ForceDerivatives:
    """Derivatives of the normal force of relaxed states to parameters of a scene.

    Parameters
    ----------
    scene : Scene
    free : sequence of str
        Parameters among `FREE`.
    with_range : bool
        Whether the logarithm of the range of the attraction is a further parameter.
    """

    def __init__(
        self, scene: Scene, free: Sequence[str], with_range: bool = False
    ) -> None:
        self._changes = [_Change(scene, name).of for name in free]
        if with_range:
            self._changes.append(_by_range)

    def of(self, stepper: Stepper) -> tuple[FloatArray, float]:
        """Return the derivatives at the last state of a path.

        Parameters
        ----------
        stepper : Stepper
            Its targets are heights.

        Returns
        -------
        derivatives : ndarray, shape (p,)
            To the parameters in the units of `FREE`, at fixed height (eV/Å per unit).
        to_height : float
            To the height (eV/Å^2). All are NaN at an instability.
        """
        contact, state = stepper.contact, _fields(stepper)
        response = height_response(contact, state, _RESIDUAL)
        row = [
            force_derivative(contact, state, response, **change(stepper))
            for change in self._changes
        ]
        return np.array(row), response.force


class _Change:
    """Derivatives of heights, wall and compliance to a parameter, by differences."""

    def __init__(self, scene: Scene, name: str) -> None:
        value = value_of(scene, name)
        self._step = 2.0 * _CHANGE * value
        self._low, self._high = (
            changed(scene, {name: value * factor})
            for factor in (1.0 - _CHANGE, 1.0 + _CHANGE)
        )
        low, high = self._low.contact_modulus, self._high.contact_modulus
        self._compliance = -2.0 * (high - low) / (high + low) / self._step
        self._walls = self._low.wall, self._high.wall
        self._same_wall = self._walls[0] == self._walls[1]
        self._same_surface = self._low.surface == self._high.surface

    def of(self, stepper: Stepper) -> dict[str, Any]:
        """Return the arguments of `force_derivative`."""
        problem, window = stepper.problem, stepper.state.window
        changes: dict[str, Any] = {"compliance": self._compliance}
        if not self._same_surface:
            low, high = (
                replace(problem, indenter=scene.surface).heights(window)
                for scene in (self._low, self._high)
            )
            changes["heights"] = (high - low) / self._step
        if not self._same_wall:
            low, high = (_profile(stepper, wall)[1] for wall in self._walls)
            changes["wall_pressure"] = (high - low) / self._step
        return changes


def _by_range(stepper: Stepper) -> dict[str, Any]:
    r"""Return the derivative of the wall to the logarithm of its range, at one work.

    The attraction of the range :math:`s D` has the pressure :math:`P(g/s)/s` at the gap
    g, counted from the contact distance.
    """
    wall = stepper.problem.wall
    _, pressure, stiffness = _profile(stepper, wall)
    gap = _fields(stepper).gap - wall.contact_distance
    change = np.where(gap >= 0.0, gap * stiffness - pressure, 0.0)
    return {"wall_pressure": change}


def _profile(stepper: Stepper, wall: Interaction) -> Profile:
    """Return energy, pressure and stiffness of a wall at the last state of a path."""
    return scaled_attraction(wall, _fields(stepper).gap, stepper.contact.adhesion)


def _fields(stepper: Stepper) -> ContactState:
    if stepper.run is None:
        raise ValueError("there is no state before the first step")
    return stepper.run.fields
