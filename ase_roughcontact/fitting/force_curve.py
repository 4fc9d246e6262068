"""Measured force curves: branches, position of the base, baseline, noise, jumps."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ase_roughcontact._util.summary import Summarized
from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import FloatArray, finite_array
from ase_roughcontact.fitting.formats.table import Position

#: Parameters of the baseline of a curve, and their units.
BASELINE = {"force_offset": "nN", "force_slope": "nN/nm"}
# Part of the points, furthest from the surface, with the force of a free tip.
_FREE_PART = 0.1
# Standard deviation of the second differences of white noise, relative to the noise.
_SECOND_DIFFERENCE_RATIO = math.sqrt(6.0)
# Median of the absolute value of Gaussian noise of standard deviation one.
_GAUSSIAN_MEDIAN = 0.6745
# Smallest change of the force near the turn, relative to the noise, that shows a wrong
# sign.
_MIN_CHANGE_AT_TURN = 8.0
# Number of points over which the force at the turn is averaged.
_TURN_POINTS = 10
# Smallest tension of an adhesive contact, relative to the noise.
_MIN_TENSION = 5.0
# Smallest standard deviation of heights of the base, for a division (Å).
_MIN_DEVIATION = 1e-12
# Part of the range of the base at either end; an approach leads from end to end.
_END_PART = 0.25
# Smallest change of the force between two points that is a jump, relative to the noise.
_MIN_JUMP = 8.0
# Number of points of a drawn branch.
_DRAWN_POINTS = 2000
# Smallest number of equal extreme forces in a row that show a saturated signal.
_MIN_SATURATED_POINTS = 10
# Smallest distance of a saturated force from the free force, relative to the noise.
_MIN_SATURATED_FORCE = 5.0
#: Rounding error of forces, relative to their range.
FORCE_ROUNDING = 1e-9
# Smallest noise that is assumed, relative to the range of the forces.
_MIN_NOISE = 1e-4


@dataclass(frozen=True, eq=False)
class MeasuredBranch:
    """Approach or retraction of a measured curve.

    Attributes
    ----------
    points : slice
        Points of the branch in the curve.
    direction : float
        Direction of the base: -1 for an approach, 1 for a retraction.
    jump : int or None
        Last point before the snap-in or the pull-off, counted in the branch; None
        without a jump.
    """

    points: slice
    direction: float
    jump: int | None


@dataclass(frozen=True, eq=False)
class ForceCurve(Summarized):
    """Measured force curve.

    Parameters
    ----------
    depth : array_like, shape (k,)
        Depths of the tip, positive into the sample, in the order of the measurement
        (Å). Their zero is arbitrary.
    force : array_like, shape (k,)
        Normal forces, negative in tension (eV/Å).
    stiffness : float
        Stiffness of the cantilever (eV/Å^2); infinite if the depth is prescribed.
    turn : int, optional
        Number of points of the approach, which come first. By default the base is
        lowest at the last of them.
    remarks : tuple of str
        Remarks on what was left out, changed or doubtful in the file.
    position : Position, optional
        Place on the sample.

    Raises
    ------
    ValueError
        If depths and forces are not finite, or not of one shape.
    """

    depth: FloatArray
    force: FloatArray
    stiffness: float = math.inf
    turn: int | None = None
    remarks: tuple[str, ...] = ()
    position: Position | None = None

    def __post_init__(self) -> None:
        """Check and convert the points."""
        depth = finite_array("depth", self.depth)
        force = finite_array("force", self.force)
        if depth.shape != force.shape or depth.ndim != 1:
            raise ValueError(
                "a force curve needs one-dimensional depths and forces of one length, "
                f"got shapes {depth.shape} and {force.shape}"
            )
        object.__setattr__(self, "depth", depth)
        object.__setattr__(self, "force", force)

    @property
    def base(self) -> FloatArray:
        """Height of the base above the tip at zero depth, shape (k,) (Å)."""
        return -self.depth - self.force / self.stiffness

    def baseline(self, names: Sequence[str]) -> FloatArray:
        """Return the forces of baselines of one unit each.

        Parameters
        ----------
        names : sequence of str
            Parameters among `BASELINE`: the force that the instrument shows for a free
            tip with the base at its highest point, and its slope with the height of the
            base.

        Returns
        -------
        ndarray, shape (k, q)
            Forces (eV/Å per unit).
        """
        columns = {
            "force_offset": np.full(len(self.force), UNITS["nN"]),
            "force_slope": (self.base - self.base.max()) * UNITS["nN"] / UNITS["nm"],
        }
        return np.reshape([columns[name] for name in names], (-1, len(self.force))).T

    @property
    def far_force(self) -> float:
        """Median force of the `far` points (eV/Å)."""
        return float(np.median(self.force[self.far]))

    @property
    def far(self) -> np.ndarray:
        """Numbers of the points furthest from the surface, a tenth of all."""
        return np.argsort(self.base)[-self._tenth :]

    @property
    def doubts(self) -> list[str]:
        """Reasons to doubt the points; empty without any."""
        doubts = [self.doubt_of_sign] if self.doubt_of_sign else []
        if self._approaches > 1:
            doubts.append(
                f"the base comes down {self._approaches} times: there seem to be as "
                "many curves in the file; fit one of them"
            )
        return doubts

    @property
    def doubt_of_sign(self) -> str:
        """Reason to doubt the signs of forces and heights; empty without any."""
        upward = np.argsort(self.base)
        near = float(np.median(self.force[upward[:_TURN_POINTS]]))
        rise = self._rise_at_turn(upward)
        is_low = near < self.far_force - _MIN_CHANGE_AT_TURN * self.noise
        if rise < 0.0 or not (is_low or rise > _MIN_CHANGE_AT_TURN * self.noise):
            return ""
        far, low = (f"{force / UNITS['nN']:.3g}" for force in (self.far_force, near))
        return (
            f"the force is {far} nN where the base is highest and {low} nN where it is "
            "lowest: is it negative in tension, the distance positive away from the "
            "surface, and the depth, -(distance + deflection), positive into it?"
        )

    def _rise_at_turn(self, upward: np.ndarray) -> float:
        """Return the rise of the force with the base at its lowest points.

        The rise is the slope of a straight line times the standard deviation of the
        heights (eV/Å). The number of points is doubled until the rise exceeds the
        noise; zero if it never does. A tip may turn in tension, but it turns where the
        force falls with the height of the base.

        Parameters
        ----------
        upward : ndarray of int, shape (k,)
            Points in the order of the base.
        """
        count = _TURN_POINTS
        while count <= max(self._tenth, _TURN_POINTS):
            base, force = self.base[upward[:count]], self.force[upward[:count]]
            rise = float(np.cov(base, force)[0, 1]) / max(base.std(), _MIN_DEVIATION)
            if abs(rise) > self.noise:
                return rise
            count *= 2
        return 0.0

    @property
    def _approaches(self) -> int:
        """Number of times that the base comes down through most of its range."""
        return int(np.sum(np.diff(self._visited_ends) < 0))

    @property
    def _visited_ends(self) -> np.ndarray:
        """Ends of the range of the base in the order of visits: 1 high, -1 low."""
        level = (self.base - self.base.min()) / max(
            np.ptp(self.base), np.finfo(float).tiny
        )
        ends = (level > 1.0 - _END_PART).astype(int) - (level < _END_PART).astype(int)
        ends = ends[ends != 0]
        return ends[np.diff(ends, prepend=0) != 0]

    @property
    def approach_first(self) -> ForceCurve:
        """Curve with the approach first, and a remark if it came after the retraction.

        Without a given turn, the base of such a curve starts low, rises and comes down:
        it is split where the base is highest.
        """
        if self.turn is not None or self._visited_ends.tolist() != [-1, 1, -1]:
            return self
        first = int(np.argmax(self.base)) + 1  # point of the approach
        remark = (
            "the retraction is written before the approach: the curve was split where "
            "the base is highest"
        )
        return replace(
            self,
            depth=np.roll(self.depth, -first),
            force=np.roll(self.force, -first),
            turn=len(self.depth) - first,
            remarks=(*self.remarks, remark),
        )

    @property
    def _tenth(self) -> int:
        return math.ceil(_FREE_PART * len(self.force))

    def less(self, baseline: FloatArray) -> ForceCurve:
        """Return the curve without a baseline of the deflection.

        Parameters
        ----------
        baseline : ndarray, shape (k,)
            Forces (eV/Å).

        Returns
        -------
        ForceCurve
            Curve with the same heights of the base.
        """
        depth = self.depth + baseline / self.stiffness
        return replace(self, depth=depth, force=self.force - baseline)

    def only(self, branch: str) -> ForceCurve:
        """Return one branch of the curve.

        Parameters
        ----------
        branch : {"approach", "retraction"}

        Returns
        -------
        ForceCurve

        Raises
        ------
        ValueError
            If the branch has no points.
        """
        direction = {"approach": -1.0, "retraction": 1.0}[branch]
        for each in self.branches:
            if each.direction == direction:
                depth = self.depth[each.points]
                return replace(
                    self,
                    depth=depth,
                    force=self.force[each.points],
                    turn=len(depth) if direction < 0.0 else 0,
                )
        raise ValueError(f"there are no points of the {branch}: leave out --branch")

    @property
    def pull_off_force(self) -> float:
        """Largest tension on the retraction, relative to the free force there (eV/Å).

        Zero if it is not above the noise, NaN without a retraction.
        """
        branch = self.branches[-1] if self.branches else None
        if branch is None or branch.direction < 0.0:
            return math.nan
        base, force = self.base[branch.points], self.force[branch.points]
        far = np.argsort(base)[-math.ceil(_FREE_PART * len(base)) :]
        tension = float(np.median(force[far]) - force.min())
        return tension if tension > _MIN_TENSION * self.noise else 0.0

    @property
    def drawn(self) -> ForceCurve:
        """Curve of many points on each branch without force, to draw a model."""
        bases, turn = [], 0
        for branch in self.branches:
            measured = self.base[branch.points]
            base = np.linspace(measured.min(), measured.max(), _DRAWN_POINTS)
            if branch.direction < 0.0:
                base = base[::-1]
                turn += _DRAWN_POINTS
            bases.append(base)
        depth = -np.concatenate(bases)
        return ForceCurve(depth, np.zeros_like(depth), self.stiffness, turn)

    @cached_property
    def deepest(self) -> float:
        """Depth of the tip where the base is lowest (Å), without most of the noise."""
        turn = int(np.argmin(self.base))
        near = slice(max(turn - _TURN_POINTS, 0), turn + 1)
        if turn < _TURN_POINTS:
            near = slice(turn, turn + _TURN_POINTS + 1)
        base = self.base[near] - self.base[turn]
        line = np.polynomial.Polynomial.fit(base, self.force[near], 1)
        return float(-self.base[turn] - line(0.0) / self.stiffness)

    @cached_property
    def noise(self) -> float:
        """Standard deviation of the noise of the force."""
        return noise_of(self.force)

    @cached_property
    def saturated(self) -> np.ndarray:
        """Points of a saturated deflection, shape (k,), bool.

        At least ten forces in a row are equal at the largest or the lowest force, which
        is not the free force.
        """
        saturated = np.zeros(len(self.force), bool)
        rounding = FORCE_ROUNDING * float(np.ptp(self.force))
        for extreme in (self.force.max(), self.force.min()):
            distance = abs(extreme - self.far_force)
            if distance < _MIN_SATURATED_FORCE * self.noise:
                continue
            equal = abs(self.force - extreme) <= rounding
            ends = np.flatnonzero(np.diff(equal, prepend=False, append=False))
            for start, stop in zip(ends[::2], ends[1::2], strict=True):
                saturated[start:stop] |= stop - start >= _MIN_SATURATED_POINTS
        return saturated

    @cached_property
    def branches(self) -> list[MeasuredBranch]:
        """Approach and retraction, which are separated by the turn.

        A branch of fewer than two points is ignored.
        """
        first = self.turn  # point of the retraction
        if first is None:
            lowest = int(np.argmin(self.base))
            first = lowest + 1 if lowest else 0
        approach, retraction = slice(0, first), slice(first, len(self.base))
        return [
            MeasuredBranch(points, direction, self._jump(points, direction))
            for points, direction in ((approach, -1.0), (retraction, 1.0))
            if points.stop - points.start > 1
        ]

    def _jump(self, points: slice, direction: float) -> int | None:
        """Return the point before the snap-in or the pull-off; None without a jump.

        The force falls in a snap-in, and rises in a pull-off, contrary to its change
        along a branch in contact.
        """
        change = direction * np.diff(self.force[points])
        largest = int(np.argmax(change))
        return largest if change[largest] > _MIN_JUMP * self.noise else None


def noise_of(values: FloatArray) -> float:
    """Return the standard deviation of the noise of values, from second differences."""
    median = np.median(abs(np.diff(values, 2))) if values.size > 2 else 0.0
    noise = median / _GAUSSIAN_MEDIAN / _SECOND_DIFFERENCE_RATIO
    return float(max(noise, _MIN_NOISE * np.ptp(values)))
