r"""Least-squares fit of a measured force curve by relaxed states of a scene.

The measured forces :math:`F_i` at the depths :math:`d_i` are compared with those of the
scene at the heights :math:`z_0 - d_i`, relaxed one after the other. The height
:math:`z_0`, at which the depth is zero, is always free: a microscope does not know
where the surface is. The derivatives to the parameters come from the adjoint equations
of each relaxed state, see `ase_roughcontact.solvers.response`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import least_squares

from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import FloatArray, finite_array, lookup
from ase_roughcontact.atoms.calculator import contact_of, grid_of
from ase_roughcontact.paths.step import Stepper
from ase_roughcontact.scene.scene import Scene
from ase_roughcontact.solvers.response import force_derivative, height_response
from ase_roughcontact.theory import MaugisDugdale

#: Keys of the parameters that can be free, and their units.
FREE = {
    "work_of_adhesion": ("interaction.work_of_adhesion", "J/m²"),
    "contact_modulus": ("substrate.contact_modulus", "GPa"),
    "radius": ("sphere.radius", "nm"),
}
# Relative change of a parameter for differences of explicit functions.
_CHANGE = 1e-6
# Largest contact radius of the smooth sphere, relative to that of Hertz.
_SMOOTH_EXTENT = 2.0
# Relative residual of the adjoint equations, and accuracy of the relaxed states.
_RESIDUAL, _ACCURACY = 1e-8, 1e-6


@dataclass(frozen=True, eq=False)
class Fit:
    """Result of `fit_curve`.

    Attributes
    ----------
    names : tuple of str
        Free parameters; the last one is the height z0.
    units : tuple of str
    values, errors : ndarray, shape (p,)
        Values and their standard errors.
    correlation : ndarray, shape (p, p)
        Correlations of the errors.
    depth, force, fitted : ndarray, shape (k,)
        Measured depths (Å), measured and fitted forces (eV/Å).
    noise : float
        Standard deviation of the residuals (eV/Å).
    converged : bool
        Whether the least-squares solution has converged.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: FloatArray
    errors: FloatArray
    correlation: FloatArray
    depth: FloatArray
    force: FloatArray
    fitted: FloatArray
    noise: float
    converged: bool

    def __str__(self) -> str:
        """Return parameters with standard errors, correlations and noise."""
        lines = [
            f"{name:<18}{value:12.5g} ± {error:.2g} {unit}"
            for name, value, error, unit in zip(
                self.names, self.values, self.errors, self.units, strict=True
            )
        ]
        lines.append(f"{'noise':<18}{self.noise / UNITS['nN']:12.3g} nN")
        lines += [
            f"correlation of {a} and {b}: {self.correlation[i, j]:.3f}"
            for i, a in enumerate(self.names)
            for j, b in enumerate(self.names[:i])
        ]
        return "\n".join(lines if self.converged else [*lines, "NOT CONVERGED"])


def fit_curve(
    scene: Scene,
    depth: ArrayLike,
    force: ArrayLike,
    free: Sequence[str] = ("work_of_adhesion",),
) -> Fit:
    """Fit parameters of a scene to a measured force curve.

    Parameters
    ----------
    scene : Scene
        Initial values of the parameters, and all others. Its path is not used.
    depth : array_like, shape (k,)
        Depths of the tip, positive into the sample, in the order of the measurement:
        an approach or a retraction (Å). Their zero is arbitrary.
    force : array_like, shape (k,)
        Normal forces, negative in tension (eV/Å).
    free : sequence of str
        Parameters among `FREE`.

    Returns
    -------
    Fit

    Raises
    ------
    ValueError
        If a parameter is unknown, or there are too few points.
    """
    depth, force = finite_array("depth", depth), finite_array("force", force)
    if depth.shape != force.shape or depth.ndim != 1 or depth.size < len(free) + 2:
        raise ValueError(
            f"a fit of {len(free) + 1} parameters needs one-dimensional depths and "
            f"forces of at least {len(free) + 2} points, got shapes {depth.shape} and "
            f"{force.shape}"
        )
    for name in free:
        lookup(name, FREE, "free parameter")
    start = np.array([_value(scene, name) for name in free])
    contact = contact_of(scene.atoms())
    touch = contact.first_contact + depth[np.argmin(abs(force))]
    scale = np.append(start, 1.0)
    kept: dict[bytes, tuple[FloatArray, FloatArray]] = {}

    def model(x: FloatArray) -> tuple[FloatArray, FloatArray]:
        key = x.tobytes()
        if key not in kept:
            kept.clear()
            values = dict(zip(free, x[:-1] * start, strict=True))
            kept[key] = forces_and_derivatives(
                _changed(scene, values), touch + x[-1] - depth, free
            )
        return kept[key]

    solution = least_squares(
        lambda x: model(x)[0] - force,
        np.append(np.ones(len(free)), 0.0),
        jac=lambda x: model(x)[1] * scale,
        bounds=([0.05] * len(free) + [-np.inf], [20.0] * len(free) + [np.inf]),
        x_scale="jac",
    )
    fitted = solution.fun + force
    noise = float(np.sqrt(np.sum(solution.fun**2) / (depth.size - len(scale))))
    covariance = np.linalg.inv(solution.jac.T @ solution.jac) * noise**2
    deviation = np.sqrt(np.diag(covariance))
    values = solution.x * scale + np.append(np.zeros(len(free)), touch)
    return Fit(
        (*free, "height z0"),
        (*(FREE[name][1] for name in free), "Å"),
        values,
        deviation * scale,
        covariance / np.outer(deviation, deviation),
        depth,
        force,
        fitted,
        noise,
        bool(solution.success),
    )


def forces_and_derivatives(
    scene: Scene, heights: ArrayLike, free: Sequence[str]
) -> tuple[FloatArray, FloatArray]:
    """Return the forces at heights, and their derivatives.

    Parameters
    ----------
    scene : Scene
    heights : array_like, shape (k,)
        Heights of the indenter, relaxed one after the other (Å).
    free : sequence of str
        Parameters among `FREE`.

    Returns
    -------
    forces : ndarray, shape (k,)
        eV/Å.
    derivatives : ndarray, shape (k, p + 1)
        To the parameters in the units of `FREE`, and to the height (eV/Å per unit).
    """
    atoms = replace_control(scene).atoms()
    stepper = Stepper(atoms, "heights", accuracy=_ACCURACY, window=scene.window)
    changes = [_Change(scene, name) for name in free]
    forces, derivatives = [], []
    for number, height in enumerate(np.asarray(heights, dtype=float)):
        stepper.step(number, float(height))
        contact, state = contact_of(atoms), atoms.calc.state(atoms)
        response = height_response(contact, state, _RESIDUAL)
        row = [
            force_derivative(contact, state, response, **change.of(atoms, state.gap))
            for change in changes
        ]
        forces.append(state.normal_force)
        derivatives.append([*row, response.force])
    return np.array(forces), np.array(derivatives)


def replace_control(scene: Scene) -> Scene:
    """Return a scene whose indenter is held at heights."""
    return scene.with_values({"path.control": "height", "path.kind": "steps"})


class _Change:
    """Derivatives of heights, wall and compliance to a parameter, by differences."""

    def __init__(self, scene: Scene, name: str) -> None:
        value = _value(scene, name)
        self._step = 2.0 * _CHANGE * value
        self._low, self._high = (
            _changed(scene, {name: value * factor})
            for factor in (1.0 - _CHANGE, 1.0 + _CHANGE)
        )
        low, high = self._low.contact_modulus, self._high.contact_modulus
        self._compliance = -2.0 * (high - low) / (high + low) / self._step
        self._walls = self._low.wall, self._high.wall
        self._same_wall = self._walls[0] == self._walls[1]
        self._same_surface = self._low.surface == self._high.surface

    def of(self, atoms: Any, gap: np.ndarray) -> dict[str, Any]:
        """Return the arguments of `force_derivative`."""
        changes: dict[str, Any] = {"compliance": self._compliance}
        if not self._same_surface:
            grid = grid_of(atoms)
            low, high = (grid.heights(s.surface) for s in (self._low, self._high))
            changes["heights"] = (high - low) / self._step
        if not self._same_wall:
            low, high = (wall.evaluate(gap)[1] for wall in self._walls)
            changes["wall_pressure"] = (high - low) / self._step
        return changes


def _value(scene: Scene, name: str) -> float:
    """Return a parameter in its unit of `FREE`."""
    values = {
        "work_of_adhesion": lambda: scene.wall.work_of_adhesion / UNITS["J/m²"],
        "contact_modulus": lambda: scene.contact_modulus / UNITS["GPa"],
        "radius": lambda: scene.radius / UNITS["nm"],
    }
    return float(values[name]())


def _changed(scene: Scene, values: dict[str, float]) -> Scene:
    """Return a scene with other parameters, in the units of `FREE`."""
    changes: dict[str, Any] = {}
    for name, value in values.items():
        key, unit = FREE[name]
        changes[key] = f"{value:.17g} nm" if unit == "nm" else value
    return scene.with_values(changes)


@dataclass(frozen=True, eq=False)
class SmoothFit:
    """Fit of the theory of a smooth sphere to the same curve.

    Attributes
    ----------
    work_of_adhesion : float
        J/m².
    fitted : ndarray, shape (k,)
        Forces (eV/Å).
    """

    work_of_adhesion: float
    fitted: FloatArray


def smooth_fit(scene: Scene, depth: ArrayLike, force: ArrayLike) -> SmoothFit:
    """Fit the work of adhesion of a smooth sphere, by the theory of Maugis and Dugdale.

    Parameters
    ----------
    scene : Scene
        Radius, modulus and range of the attraction.
    depth, force : array_like, shape (k,)
        See `fit_curve`.

    Returns
    -------
    SmoothFit

    Raises
    ------
    ValueError
        If the wall of the scene has no attraction.
    """
    depth, force = finite_array("depth", depth), finite_array("force", force)
    reach = scene.wall.attraction_range
    if not scene.wall.attractive:
        raise ValueError("a fit of the work of adhesion needs a wall with attraction")
    size = np.sqrt(scene.radius * np.ptp(depth)) + scene.spacing

    def model(x: FloatArray) -> FloatArray:
        sphere = MaugisDugdale(
            scene.radius,
            scene.contact_modulus,
            abs(x[0]) * UNITS["J/m²"],
            attraction_range=reach,
        )
        along, forces = sphere.curve(_SMOOTH_EXTENT * size)
        stable = slice(int(np.argmin(forces)), None)
        order = np.argsort(along[stable])
        return np.interp(depth + x[1], along[stable][order], forces[stable][order])

    touch = -depth[np.argmin(abs(force))]
    start = [scene.wall.work_of_adhesion / UNITS["J/m²"], touch]
    found = least_squares(lambda x: model(x) - force, start, diff_step=1e-4)
    return SmoothFit(float(abs(found.x[0])), found.fun + force)
