r"""Residuals of a measured force curve to that of a scene, and their derivatives.

For each trial of the parameters the scene is pressed in and pulled off again, in an
`adhesion_loop`. The curve that a cantilever follows through its states, with its
snap-in and pull-off, is compared with the measured forces :math:`F_i` at the heights
:math:`D_i = z_0 - d_i - F_i/k` of the base. The height :math:`z_0`, at which the depth
is zero, is always free: a microscope does not measure where the surface is. A baseline
:math:`b_0 + b_1 (D_i - \max D)` of the measured forces, such as that of an unknown zero
of the deflection, shifts depths and forces together, so that it leaves :math:`D_i` as
it is.

Forces are compared only where both curves are on the same side of a jump. The heights
of the base at the largest jump of each branch, which depend smoothly on the parameters,
are compared as two further points, with the distance of the measured points over
:math:`\sqrt{12}` as their standard error.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from copy import copy
from dataclasses import replace
from typing import Any

import numpy as np

from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import FloatArray
from ase_roughcontact.interactions import Interaction
from ase_roughcontact.paths.output import follow
from ase_roughcontact.paths.record import LoadStep
from ase_roughcontact.scene.fit_parameters import (
    FREE,
    ForceDerivatives,
    changed,
    value_of,
)
from ase_roughcontact.scene.followed import FollowedBranch, FollowedJump
from ase_roughcontact.scene.force_curve import BASELINE, ForceCurve, MeasuredBranch
from ase_roughcontact.scene.least_squares import RANGE_UNCERTAINTY
from ase_roughcontact.scene.loop import Loop
from ase_roughcontact.scene.path_kinds import Steps
from ase_roughcontact.scene.scene import Scene
from ase_roughcontact.windows.regrid import GridChange

_NN, _NM = UNITS["nN"], UNITS["nm"]
# Part of a measured jump from which a calculated one is its counterpart.
_COUNTERPART = 0.3
# Residual of a point between a measured jump and its counterpart, relative to the
# noise: it must not pay to have points there.
_BETWEEN = 3.0
# Limits of a parameter of the scene relative to its first value.
_LEAST, _MOST = 0.05, 20.0


class Residuals:
    """Residuals of a force curve relative to its noise, and their derivatives.

    The unknowns x are the parameters of the scene relative to their first values, and
    the changes of those of the baseline and of z0.

    Parameters
    ----------
    scene : Scene
        First values of the parameters, and all others.
    curve : ForceCurve
    free : sequence of str
        Parameters among `FREE` and `BASELINE`.

    Attributes
    ----------
    names, units : tuple of str
        Of the parameters: those of the scene, of the baseline, and z0.
    start, scale : ndarray, shape (p,)
        First unknowns, and the units of the parameters for one of the unknowns.
    bounds, noise, error, reasons
        See `solve`.
    """

    reasons = (
        "the scene does not describe it, or a column is another quantity (depth = "
        "-(distance + deflection))"
    )

    def __init__(self, scene: Scene, curve: ForceCurve, free: Sequence[str]) -> None:
        self._scene, self._curve, self.noise = scene, curve, curve.noise
        path: Any = scene.path if isinstance(scene.path, Loop) else Loop
        self._tolerance: float = path.tolerance
        self.error = self._tolerance * float(abs(curve.force).max())
        self._free = tuple(name for name in free if name in FREE)
        self._with_range = scene.wall.attractive and "attraction_range" not in free
        self._lines = lines = tuple(name for name in free if name in BASELINE)
        self.names = *self._free, *lines, "height_offset"
        units = {name: unit for name, (_, unit) in FREE.items()} | BASELINE
        self.units = *(units[name] for name in self.names[:-1]), "nm"
        first, others = len(self._free), len(lines) + 1
        self.start = np.repeat([1.0, 0.0], [first, others])
        self.scale = np.ones(first + others)
        self.scale[:first] = [value_of(scene, name) for name in self._free]
        self.bounds = (
            np.repeat([_LEAST, -np.inf], [first, others]),
            np.repeat([_MOST, np.inf], [first, others]),
        )
        self._shift = np.zeros(first + others)
        if "force_offset" in lines:
            self._shift[self.names.index("force_offset")] = curve.far_force / _NN
        self._shift[-1] = _first_height(scene, self._corrected(self._shift)) / _NM
        self._kept: tuple[bytes, list[FollowedBranch]] = b"", []

    def values(self, x: FloatArray) -> FloatArray:
        """Return the parameters in their units."""
        return x * self.scale + self._shift

    def scales(self, x: FloatArray) -> FloatArray:
        """Return the derivatives of the parameters to the unknowns."""
        return np.diag(self.scale)

    def forces(self, x: FloatArray, curve: ForceCurve) -> FloatArray:
        """Return the forces at the points of a curve, with the baseline."""
        values = self.values(x)
        forces = self._baseline_of(values, curve)
        base = curve.base + values[-1] * _NM
        for measured, followed in self._pairs(x, curve):
            forces[measured.points] += followed.at(base[measured.points])[:, 0]
        return forces

    def curves(self, x: FloatArray) -> dict[str, Any]:
        """Return measured and fitted curve, as attributes of `Fit`."""
        curve, drawn = self._curve, self._curve.drawn
        return {
            "distance": curve.base,
            "force": curve.force,
            "fitted": self.forces(x, curve),
            "compared": self.of(x)[2][:-2],
            "far_force": curve.far_force,
            "line": (drawn.base, self.forces(x, drawn)),
        }

    def of(self, x: FloatArray) -> tuple[FloatArray, FloatArray, np.ndarray]:
        """Return residuals of the forces and of the jumps, and their derivatives.

        Parameters
        ----------
        x : ndarray, shape (p,)

        Returns
        -------
        residuals : ndarray, shape (k + 2,)
        derivatives : ndarray, shape (k + 2, p)
        compared : ndarray of bool, shape (k + 2,)
            Points and jumps that are compared.
        """
        residuals, jacobian, compared = self._of(x)
        return residuals, jacobian[:, : len(x)] * self.scale, compared

    def changes(self, x: FloatArray) -> dict[str, FloatArray]:
        """Return changes of the residuals by the range of the wall, and by the grid.

        Parameters
        ----------
        x : ndarray, shape (p,)

        Returns
        -------
        dict of ndarray
            "range": that of its logarithm, in columns for the branches and the jumps,
            whose signs depend on the form of the attraction. "grid": to the limit of a
            fine grid, extrapolated from one of half the spacing, as the error is
            quadratic; zero at points and jumps that are not compared on both, and for
            solids of atoms, which have only one lattice.
        """
        residuals, rows, compared = self._of(x)
        count = len(residuals) - 2
        parts = [branch.points for branch in self._curve.branches]
        parts += [slice(count, count + 1), slice(count + 1, count + 2)]
        by_range = np.zeros((count + 2, len(parts)))
        for column, part in enumerate(parts):
            by_range[part, column] = rows[part, len(x) :].sum(axis=1)
        by_grid = np.zeros((count + 2, 1))
        if not self._scene.substrate.of_atoms:
            fine = copy(self)
            scene, share = on_finer_grid(self._scene)
            fine._scene, fine._kept = scene, (b"", [])
            others, _, too = fine.of(x)
            by_grid[:, 0] = share * np.where(compared & too, others - residuals, 0.0)
        return {"range": RANGE_UNCERTAINTY * by_range, "grid": by_grid}

    def _of(self, x: FloatArray) -> tuple[FloatArray, FloatArray, np.ndarray]:
        """Return residuals, derivatives per unit, also to the range, and comparison."""
        values, first = self.values(x), len(self._free)
        curve, count, z0 = self._curve, len(self._curve.force), values[-1] * _NM
        forces = curve.force - self._baseline_of(values, curve)
        baseline = curve.baseline(self._lines)
        residuals = np.zeros(count + 2)
        jacobian = np.zeros((count + 2, len(x) + self._with_range))
        compared = np.zeros(count + 2, bool)
        for number, (measured, followed) in enumerate(
            self._pairs(x, curve), start=count
        ):
            points, jump = measured.points, followed.jump
            base, force = curve.base[points] + z0, forces[points]
            columns = followed.at(base)
            kept, between = np.ones(len(base), bool), np.zeros(len(base), bool)
            if jump and _are_counterparts(measured, jump, force):
                kept, between = _compared(base, measured, jump.base)
                residuals[number], rows = _of_jump(base, measured, jump)
                of_range = range(len(x), jacobian.shape[1])
                jacobian[number, [*range(first), *of_range, len(x) - 1]] = rows
                compared[number] = True
            misfit = (columns[:, 0] - force) / curve.noise
            residuals[points] = np.where(between, _BETWEEN, np.where(kept, misfit, 0.0))
            parts = (
                columns[:, 2 : 2 + first],
                baseline[points],
                _NM * columns[:, [1]],
                columns[:, 2 + first :],
            )
            jacobian[points] = np.where(kept[:, None], np.hstack(parts), 0.0)
            jacobian[points] /= curve.noise
            compared[points] = kept
        return residuals, jacobian, compared

    def _baseline_of(self, values: FloatArray, curve: ForceCurve) -> FloatArray:
        """Return the forces of the baseline for parameters in their units."""
        return curve.baseline(self._lines) @ values[len(self._free) : -1]

    def _corrected(self, values: FloatArray) -> ForceCurve:
        """Return the curve without the baseline for parameters in their units."""
        return self._curve.less(self._baseline_of(values, self._curve))

    def _pairs(
        self, x: FloatArray, curve: ForceCurve
    ) -> list[tuple[MeasuredBranch, FollowedBranch]]:
        """Return the branches of a curve beside those of the scene."""
        if self._kept[0] != x.tobytes():
            self._kept = x.tobytes(), self._followed(x)
        by_direction = {each.direction: each for each in self._kept[1]}
        return [(each, by_direction[each.direction]) for each in curve.branches]

    def _followed(self, x: FloatArray) -> list[FollowedBranch]:
        """Press the scene in and pull it off again."""
        values = self.values(x)
        scene = changed(self._scene, dict(zip(self._free, values, strict=False)))
        lowest = values[-1] * _NM - self._corrected(values).deepest
        path = _loop(scene.wall, scene.first_contact - lowest, self._tolerance)
        trial = replace(scene, path=path)
        stepper = trial.stepper(trial.frames())
        derivatives = ForceDerivatives(scene, self._free, self._with_range)
        states, rows = list[LoadStep](), dict[int, FloatArray]()
        for state in follow(path.steps_of(trial.bodies, stepper), validity="ignore"):
            states.append(state)
            rows[state.step] = derivatives.of(stepper)[0]
        loop = path.result(trial.bodies, states)
        stiffness = self._curve.stiffness
        down = loop.approach, loop.approach_jumps, rows, stiffness, -1.0
        up = loop.retraction, loop.retraction_jumps, rows, stiffness, 1.0
        return [FollowedBranch.of(*down), FollowedBranch.of(*up)]


def on_finer_grid(scene: Scene) -> tuple[Scene, float]:
    """Return a scene on a grid of half the spacing, and the part of errors it lacks.

    Times the change of a quantity on that grid this is its quadratic error.
    """
    given = scene.grid_change
    if given.coarsen > 1:
        change = GridChange(coarsen=given.coarsen // 2)
    else:
        change = GridChange(refine=2 * given.refine)
    ratio = change.spacing(1.0) / given.spacing(1.0)
    model = scene.with_values({"substrate.model": "continuum"})
    return model.with_grid(change), 1.0 / (1.0 - ratio**2)


def _are_counterparts(
    measured: MeasuredBranch, jump: FollowedJump, force: FloatArray
) -> bool:
    """Return whether a calculated jump is the counterpart of the measured one."""
    if measured.jump is None:
        return False
    before, after = force[measured.jump : measured.jump + 2]
    return bool(abs(jump.change) > _COUNTERPART * abs(after - before))


def _compared(
    base: FloatArray, measured: MeasuredBranch, jump: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the points whose forces are compared, and those between the jumps."""
    last = measured.jump or 0
    numbers = np.arange(len(base))
    passed = measured.direction * (base - jump)
    step = abs(base[last + 1] - base[last])
    at_jump = (numbers == last) | (numbers == last + 1) | (abs(passed) < step)
    between = ((numbers > last) != (passed > 0.0)) & ~at_jump
    return ~between & ~at_jump, between


def _of_jump(
    base: FloatArray, measured: MeasuredBranch, jump: FollowedJump
) -> tuple[float, FloatArray]:
    """Return the residual of the height of the base at a jump, and its derivatives.

    The derivatives are those to the parameters of the scene, to the range, and to z0
    (1/nm).
    """
    last = measured.jump or 0
    # both points of a jump may be at one height of the base
    step = max(abs(base[last + 1] - base[last]), np.ptp(base) / len(base))
    unit = step / math.sqrt(12.0)
    place = 0.5 * (base[last] + base[last + 1])
    return (jump.base - place) / unit, np.append(jump.derivatives, -_NM) / unit


def _loop(wall: Interaction, deepest: float, tolerance: float) -> Loop:
    """Return a loop to a penetration (Å), at least into the range of the wall."""
    least = -0.5 * (wall.cutoff - wall.contact_distance)
    return Loop(max(float(deepest), least), tolerance=tolerance)


def _first_height(scene: Scene, curve: ForceCurve) -> float:
    """Return z0 at which the scene has the largest measured force where it was."""
    force, depth = curve.force, curve.depth
    largest = int(np.argmax(force))
    if force[largest] <= 0.0:
        return scene.first_contact + depth[np.argmin(abs(force))]
    loaded = replace(scene, path=Steps())
    (step,) = loaded.relax(force[[largest]], validity="ignore", scan_errors=False)
    return step.height + depth[largest]
