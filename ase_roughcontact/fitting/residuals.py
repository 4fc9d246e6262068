r"""Residuals between a measured and a calculated force curve, and their derivatives.

For each trial of the parameters the scene is pressed in and pulled off again, in an
`adhesion_loop`. The curve that a cantilever follows through its states, with its
snap-in and pull-off, is compared with the measured forces :math:`F_i` at the heights
:math:`D_i = z_0 - d_i - F_i/k` of the base. The height :math:`z_0`, at which the depth
is zero, is always free: a microscope does not measure where the surface is. A baseline
:math:`b_0 + b_1 (D_i - \max D)` of the measured forces, for example by an unknown zero
of the deflection, shifts depths and forces together and does not change :math:`D_i`.

Forces are compared only where both curves are on the same side of a jump. The heights
of the base at the largest jump of each branch, which depend smoothly on the parameters,
are compared as two further points, with the distance of the measured points over
:math:`\sqrt{12}` as their standard error.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import FloatArray
from ase_roughcontact.fitting.followed import FollowedBranch, FollowedJump
from ase_roughcontact.fitting.force_curve import BASELINE, ForceCurve, MeasuredBranch
from ase_roughcontact.fitting.least_squares import RANGE_UNCERTAINTY, Trial
from ase_roughcontact.fitting.parameters import (
    FREE,
    FREE_UNITS,
    ForceDerivatives,
    changed,
    value_of,
)
from ase_roughcontact.path_kinds.loop.scene import Loop
from ase_roughcontact.results.record import LoadStep
from ase_roughcontact.scene.path_kind import Steps
from ase_roughcontact.scene.scene import Scene
from ase_roughcontact.windows.regrid import GridChange

_NN, _NM = UNITS["nN"], UNITS["nm"]
# Smallest calculated jump, relative to the measured jump, that is its counterpart.
_MIN_RELATIVE_JUMP = 0.3
# Smallest penetration of a wall that only repels, in spacings.
_MIN_PENETRATION = 1e-3
# Smallest value of a parameter of the scene, relative to its first value.
_MIN_FACTOR = 0.05
# Largest value of a parameter of the scene, relative to its first value.
_MAX_FACTOR = 20.0


@dataclass(frozen=True, eq=False)
class CurveTrial(Trial):
    """Trial with residuals of k points and two jumps.

    Attributes
    ----------
    by_range : ndarray, shape (k + 2,)
        Derivatives of the residuals to the logarithm of the range of the attraction,
        zero if the range is free, or without attraction.
    followed : dict of FollowedBranch
        Calculated branches by their directions.
    """

    by_range: FloatArray
    followed: dict[float, FollowedBranch]


class Residuals:
    """Residuals of a force curve relative to its noise, and their derivatives.

    The unknowns x are the parameters of the scene relative to their first values, and
    the changes of the parameters of the baseline and of z0.

    Parameters
    ----------
    scene : Scene
        Scene with first values of the free parameters, and the fixed ones.
    curve : ForceCurve
        Measured force curve.
    free : sequence of str
        Parameters among `FREE` and `BASELINE`.
    """

    abscissa, ordinate = ("distance of the base", "nm"), ("normal force $N$", "nN")
    reasons = (
        "the scene does not describe it, or a column is another quantity (depth = "
        "-(distance + deflection))"
    )

    def __init__(self, scene: Scene, curve: ForceCurve, free: Sequence[str]) -> None:
        self._scene, self._curve, self.noise = scene, curve, curve.noise
        self.measured = curve.base, curve.force
        path: Any = scene.path if isinstance(scene.path, Loop) else Loop
        self._tolerance: float = path.tolerance
        self.error = self._tolerance * float(abs(curve.force).max())
        self._free = [name for name in free if name in FREE]
        self._lines = [name for name in free if name in BASELINE]
        self.names = *self._free, *self._lines, "height_offset"
        self.units = tuple(FREE_UNITS[name] for name in self.names)
        counts = len(self._free), len(self._lines) + 1
        self.start = np.repeat([1.0, 0.0], counts)
        self.bounds = np.repeat(
            [[_MIN_FACTOR, -np.inf], [_MAX_FACTOR, np.inf]], counts, axis=1
        )
        first = [value_of(scene, name) for name in self._free]
        self._scale = np.append(first, np.ones(counts[1]))
        offsets = {"force_offset": curve.far_force / _NN}
        self._shift = np.array([offsets.get(name, 0.0) for name in self.names])
        self._shift[-1] = _first_height(scene, self._corrected(self._shift)) / _NM

    def values(self, x: FloatArray) -> FloatArray:
        """Return the parameters in their units."""
        return x * self._scale + self._shift

    def trial(self, x: FloatArray, scene: Scene | None = None) -> CurveTrial:
        """Return the trial for some unknowns, by default with the scene of the fit."""
        values, curve, count = self.values(x), self._curve, len(self._curve.force)
        followed = self._followed(values, scene or self._scene)
        forces, base = self._corrected(values).force, curve.base + values[-1] * _NM
        # force, and its derivatives to the height of the base and to the parameters
        rows = np.zeros((count + 2, followed[1.0].columns.shape[1]))
        unit, target = np.full(count + 2, curve.noise), np.append(forces, [0.0, 0.0])
        compared = np.append(np.ones(count, bool), [False, False])
        for number, measured in enumerate(curve.branches, start=count):
            points, jump = measured.points, followed[measured.direction].jump
            rows[points] = followed[measured.direction].at(base[points])
            if jump and _are_counterparts(measured, jump, forces[points]):
                here = base[points]
                compared[points] = _on_one_side(here, measured, jump.base)
                # the height of the base in place of a force
                around = here[measured.jump :][:2]
                rows[number] = jump.base, -1.0, *jump.derivatives
                target[number] = around.mean()
                # both points may be at one height of the base
                distance = max(np.ptp(around), np.ptp(here) / len(here))
                unit[number] = distance / math.sqrt(12.0)
                compared[number] = True
        baseline = np.zeros((count + 2, len(self._lines)))
        baseline[:count] = curve.baseline(self._lines)
        parts = np.split(rows, [1, 2, 2 + len(self._free)], axis=1)
        force, by_height, by_free, by_range = parts
        slopes = np.hstack([by_free, baseline, _NM * by_height]) * self._scale
        residuals = np.where(compared, (force[:, 0] - target) / unit, 0.0)
        return CurveTrial(
            x,
            residuals,
            slopes * (compared / unit)[:, None],
            compared,
            rows[:count, 0] + curve.force - forces,
            by_range.sum(axis=1) * compared / unit,
            followed,
        )

    def line(self, trial: CurveTrial) -> tuple[FloatArray, FloatArray]:
        """Return heights of the base and fitted forces on many points."""
        values, drawn = self.values(trial.unknowns), self._curve.drawn
        forces = self._baseline_of(values, drawn)
        base = drawn.base + values[-1] * _NM
        for branch in drawn.branches:
            followed = trial.followed[branch.direction]
            forces[branch.points] += followed.at(base[branch.points])[:, 0]
        return drawn.base, forces

    def changes(self, trial: CurveTrial) -> dict[str, FloatArray]:
        """Return changes of the residuals by the range of the wall, and by the grid.

        Parameters
        ----------
        trial : CurveTrial

        Returns
        -------
        dict of ndarray
            "range": changes by the logarithm of the range, in a column for each branch
            and jump, as their signs depend on the form of the attraction. "grid":
            changes to the limit of a fine grid, extrapolated from a grid of half the
            spacing, as the error is quadratic; zero at points and jumps that are not
            compared on both, and for solids of atoms, which have only one lattice.
        """
        count = len(trial.residuals) - 2
        parts: list[Any] = [branch.points for branch in self._curve.branches]
        parts += [count, count + 1]
        by_range = np.zeros((count + 2, len(parts)))
        for column, part in enumerate(parts):
            by_range[part, column] = RANGE_UNCERTAINTY * trial.by_range[part]
        by_grid = np.zeros((count + 2, 1))
        if not self._scene.substrate.of_atoms:
            scene, share = on_finer_grid(self._scene)
            fine = self.trial(trial.unknowns, scene)
            both = trial.compared & fine.compared
            change = fine.residuals - trial.residuals
            by_grid[:, 0] = share * np.where(both, change, 0.0)
        return {"range": by_range, "grid": by_grid}

    def _baseline_of(self, values: FloatArray, curve: ForceCurve) -> FloatArray:
        """Return the forces of the baseline for parameters in their units."""
        return curve.baseline(self._lines) @ values[len(self._free) : -1]

    def _corrected(self, values: FloatArray) -> ForceCurve:
        """Return the curve without the baseline for parameters in their units."""
        return self._curve.less(self._baseline_of(values, self._curve))

    def _followed(
        self, values: FloatArray, scene: Scene
    ) -> dict[float, FollowedBranch]:
        """Press the scene in and pull it off again."""
        free = self._free
        scene = changed(scene, dict(zip(free, values, strict=False)))
        lowest = values[-1] * _NM - self._corrected(values).deepest
        # at least into the range of the wall, or to a contact with a hard one
        least = _MIN_PENETRATION * scene.spacing - 0.5 * scene.wall.reach
        deepest = max(float(scene.first_contact - lowest), least)
        path = Loop(deepest, tolerance=self._tolerance)
        trial = replace(scene, path=path)
        stepper = trial.stepper(trial.frames())
        with_range = scene.wall.attractive and "attraction_range" not in free
        derivatives = ForceDerivatives(scene, free, with_range)
        states, rows = list[LoadStep](), dict[int, FloatArray]()
        steps = path.steps_of(trial.bodies, stepper)
        for step, left in steps.steps(steps.start(stepper.start), steps.kind):
            states.append(step.record)
            rows[step.number] = derivatives.of(left)
        loop, stiffness = path.result(trial.bodies, states), self._curve.stiffness
        approach = FollowedBranch.of(
            loop.approach, loop.approach_jumps, rows, stiffness, -1.0
        )
        retraction = FollowedBranch.of(
            loop.retraction, loop.retraction_jumps, rows, stiffness, 1.0
        )
        return {-1.0: approach, 1.0: retraction}


def on_finer_grid(scene: Scene) -> tuple[Scene, float]:
    """Return a scene on a grid of half the spacing, and Richardson's factor.

    The factor times the change of a quantity on the finer grid is the error of the
    quantity on the given grid, if the error is quadratic in the spacing.
    """
    given = scene.grid_change
    if given.coarsen % 2:
        change = GridChange(2 * given.refine, given.coarsen)
    else:
        change = GridChange(given.refine, given.coarsen // 2)
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
    return bool(abs(jump.change) > _MIN_RELATIVE_JUMP * abs(after - before))


def _on_one_side(base: FloatArray, measured: MeasuredBranch, jump: float) -> np.ndarray:
    """Return which points are on the same side of both jumps, and not at a jump."""
    last = measured.jump or 0
    numbers = np.arange(len(base))
    passed = measured.direction * (base - jump)
    step = abs(base[last + 1] - base[last])
    at_jump = (numbers == last) | (numbers == last + 1) | (abs(passed) < step)
    return ((numbers > last) == (passed > 0.0)) & ~at_jump


def _first_height(scene: Scene, curve: ForceCurve) -> float:
    """Return z0 at which the scene has the largest measured force at its position."""
    force, depth = curve.force, curve.depth
    largest = int(np.argmax(force))
    if force[largest] <= 0.0:
        return scene.first_contact + depth[np.argmin(abs(force))]
    loaded = replace(scene, path=Steps())
    (step,) = loaded.relax(force[[largest]], validity="ignore", scan_errors=False)
    return step.height + depth[largest]
