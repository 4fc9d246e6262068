"""Parameters of a scene that a fit can change, and derivatives of forces to them.

The derivatives come from the adjoint equations of a relaxed state, see
`ase_roughcontact.solvers.response`. Heights, wall and compliance are explicit functions
of the parameters; their derivatives are differences.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import FloatArray
from ase_roughcontact.elasticity.named_materials import material
from ase_roughcontact.fitting.force_curve import BASELINE
from ase_roughcontact.interactions import Interaction, scaled_attraction
from ase_roughcontact.scene.scene import Scene
from ase_roughcontact.solvers.response import force_derivative, height_response
from ase_roughcontact.stepping.relaxed import RelaxedStep

#: Keys of the parameters that can be free, and their units.
FREE = {
    "work_of_adhesion": ("interaction.work_of_adhesion", "J/m²"),
    "contact_modulus": ("substrate.contact_modulus", "GPa"),
    "radius": ("sphere.radius", "nm"),
    "attraction_range": ("interaction.attraction_range", "nm"),
}
#: Keys of relaxation series that can be free on a path in time, and their units.
SERIES = {
    "relaxation_moduli": ("substrate.relaxation_moduli", ""),
    "relaxation_times": ("substrate.relaxation_times", "s"),
}
#: Units of all parameters of fits, parameters of the measured values included.
FREE_UNITS = {
    **{name: unit for name, (_, unit) in (FREE | SERIES).items()},
    **BASELINE,
    "height_offset": "nm",
}
# Relative change of a parameter for differences of explicit functions.
_DIFFERENCE_STEP = 1e-6
# Relative residual of the adjoint equations.
_ADJOINT_RESIDUAL = 1e-8


def value_of(scene: Scene, name: str) -> float:
    """Return a parameter of `FREE` in its unit.

    Parameters
    ----------
    scene : Scene
        Scene with the parameter.
    name : str
        Name of the parameter.

    Returns
    -------
    float
    """
    if name == "radius" and scene.whole_tip is not None:
        raise ValueError(
            "radius can't be fitted: the scan is the whole tip (radius = inf)"
        )
    if name == "radius" and scene.bodies.shape is not None:
        raise ValueError(
            f"radius can't be fitted: the indenter is a {scene.bodies.shape.name}"
        )
    values = {
        "work_of_adhesion": scene.wall.work_of_adhesion,
        "contact_modulus": _sample_modulus(scene),
        "radius": scene.radius,
        "attraction_range": scene.wall.attraction_range,
    }
    return values[name] / UNITS[FREE[name][1]]


def _sample_modulus(scene: Scene) -> float:
    """Return E* of the sample alone, without the compliance of the tip (eV/Å^3)."""
    if not scene.tip_material:
        return scene.contact_modulus
    tip = material(scene.tip_material).contact_modulus * UNITS["GPa"]
    return 1.0 / (1.0 / scene.contact_modulus - 1.0 / tip)


def changed(scene: Scene, values: Mapping[str, ArrayLike]) -> Scene:
    """Return a scene with other values of parameters.

    Parameters
    ----------
    scene : Scene
        Scene with the old values.
    values : mapping of str to array_like
        Values by name: one number for a parameter of `FREE`, all numbers of a series of
        `SERIES`, in the units given there.

    Returns
    -------
    Scene
    """
    entries: dict[str, Any] = {}
    for name, value in values.items():
        if name in SERIES:
            entries[SERIES[name][0]] = np.asarray(value).tolist()
        else:
            key, unit = FREE[name]
            entries[key] = f"{np.squeeze(value):.17g} {unit}"
    return scene.settled.with_values(entries)


class ForceDerivatives:
    """Derivatives of the normal force of relaxed states to parameters of a scene.

    Parameters
    ----------
    scene : Scene
        Scene of the relaxed states.
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
            self._changes.append(_change_by_range)

    def of(self, relaxed: RelaxedStep) -> FloatArray:
        """Return the derivatives at a relaxed state.

        Parameters
        ----------
        relaxed : RelaxedStep
            Step of a path at given heights.

        Returns
        -------
        ndarray, shape (p,)
            Derivatives to the parameters in the units of `FREE`, at fixed height
            (eV/Å per unit); NaN at an instability.
        """
        contact, state = relaxed.contact, relaxed.fields
        response = height_response(contact, state, _ADJOINT_RESIDUAL)
        changes = (change(relaxed, state.gap) for change in self._changes)
        row = [force_derivative(contact, state, response, **each) for each in changes]
        return np.array(row)


class _Change:
    """Derivatives of heights, wall and compliance to a parameter, by differences."""

    def __init__(self, scene: Scene, name: str) -> None:
        value = value_of(scene, name)
        self._step = 2.0 * _DIFFERENCE_STEP * value
        self._scenes = [
            changed(scene, {name: value * factor})
            for factor in (1.0 - _DIFFERENCE_STEP, 1.0 + _DIFFERENCE_STEP)
        ]

    def of(self, relaxed: RelaxedStep, gap: FloatArray) -> dict[str, Any]:
        """Return the arguments of `force_derivative`."""

        def heights(indenter: Any) -> FloatArray:
            problem = replace(relaxed.problem, indenter=indenter)
            return problem.heights(relaxed.state.window)

        def pressure(wall: Interaction) -> FloatArray:
            return scaled_attraction(wall, gap, relaxed.contact.adhesion)[1]

        return {
            "heights": self._difference("surface", heights),
            "wall_pressure": self._difference("wall", pressure),
            "compliance": -self._difference("contact_modulus", math.log),
        }

    def _difference(self, attribute: str, function: Callable[[Any], Any]) -> Any:
        """Return the derivative of a function of an attribute of the scene."""
        low, high = (getattr(scene, attribute) for scene in self._scenes)
        return 0.0 if low == high else (function(high) - function(low)) / self._step


def _change_by_range(relaxed: RelaxedStep, gap: FloatArray) -> dict[str, Any]:
    r"""Return the derivative of the wall to the logarithm of its range, at one work.

    The attraction of the range :math:`s D` has the pressure :math:`P(g/s)/s` at the gap
    g, counted from the contact distance.
    """
    wall = relaxed.problem.wall
    _, pressure, stiffness = scaled_attraction(wall, gap, relaxed.contact.adhesion)
    beyond = gap - wall.contact_distance
    change = np.where(beyond >= 0.0, beyond * stiffness - pressure, 0.0)
    return {"wall_pressure": change}
