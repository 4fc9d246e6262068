"""Bad lines of a scan: not recorded, repeated, offset, or with scars.

Found are lines of equal heights, as where nothing was recorded, lines that repeat the
one before, lines that are offset from both neighbours, and scars: parts of a few lines
that are higher or lower than the lines on both sides. A run of the first two up to an
edge is the rest of a scan that was aborted. Plateaus of equal heights at the largest or
smallest height are heights that were clipped.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ase_roughcontact._util.validation import FloatArray
from ase_roughcontact.topography.levelling import median_steps
from ase_roughcontact.topography.noise import deviation

# Standard deviations of the offsets of lines beyond which one is a bad line.
_BAD_LINE_DEVIATIONS = 8.0
# Least number of points of a line that is judged, and of a scar for each of its lines.
_MIN_POINTS = 8
# Largest number of lines of a scar.
_MAX_SCAR_WIDTH = 3
# Least height of a scar in standard deviations of differences of neighbouring lines.
_SCAR_TO_DIFFERENCES = 3.0
# Least height of a scar over the largest feature of the same shape along y.
_SCAR_TO_ACROSS = 2.0
# Least height of a scar over the median of features of the same shape along x.
_SCAR_TO_MEDIAN = 6.0
# Signs of scars, and of heights that are clipped: high and low.
_SIGNS = (1.0, -1.0)
# Share of the range of the heights that is negligible.
_NEGLIGIBLE_RANGE = 1e-6
# Largest number of runs of lines that are named.
_MAX_NAMED_RUNS = 8
# Least number of points of the largest height that are clipped.
_MIN_CLIPPED_POINTS = 10
# Least ratio of this number to the mean number of points of one height.
_MIN_CLIPPED_RATIO = 5.0


@dataclass(frozen=True, eq=False)
class BadLines:
    """Bad lines (constant y) of a scan, and heights that are clipped.

    Attributes
    ----------
    constant, repeated, offset : tuple of int
        Numbers of lines of equal heights, of lines that repeat the one before, and of
        lines that are offset from both neighbours.
    scars : ndarray of bool, shape (n, m)
        Points of lines that are higher or lower than both neighbours.
    highest, lowest : float
        Parts of the points that have the largest and the smallest height, if they are
        clipped, else zero.
    lines : int
        Number of lines.
    """

    constant: tuple[int, ...]
    repeated: tuple[int, ...]
    offset: tuple[int, ...]
    scars: NDArray[np.bool_]
    highest: float
    lowest: float
    lines: int

    @classmethod
    def of(cls, heights: FloatArray) -> BadLines:
        """Find the bad lines of heights, shape (n, m), NaN at missing points."""
        constant, repeated = not_recorded(heights)
        rest = np.where(constant | repeated, np.nan, heights)
        steps = median_steps(rest)
        known = heights[~np.isnan(heights)]
        least = _NEGLIGIBLE_RANGE * float(np.ptp(known)) if known.size else 0.0
        difference = max(deviation(np.diff(rest, axis=1)), least)
        offset = _offset(steps, difference)
        level = np.append(0.0, np.nan_to_num(steps).cumsum())
        scars = _scars(np.where(offset, np.nan, rest - level), difference)
        highest, lowest = (_clipped(sign * rest) for sign in _SIGNS)
        return cls(
            _numbers(constant),
            _numbers(repeated),
            _numbers(offset),
            scars,
            highest,
            lowest,
            heights.shape[1],
        )

    @property
    def kept(self) -> slice:
        """Lines without the rest of an aborted scan at the first or the last edge."""
        constant, repeated = np.zeros((2, self.lines), bool)
        constant[list(self.constant)] = repeated[list(self.repeated)] = True
        before_next = np.append(repeated[1:], False)  # lines that the next repeats
        first = int(np.argmin(constant | before_next))
        last = self.lines - 1 - int(np.argmin((constant | repeated)[::-1]))
        return slice(
            first if first > 1 else 0,
            last + 1 if last < self.lines - 2 else self.lines,
        )

    @property
    def mask(self) -> NDArray[np.bool_]:
        """Points of bad lines and scars, shape (n, m)."""
        found = self.scars.copy()
        for lines in self._inside.values():
            found[:, lines] = True
        return found

    @property
    def _inside(self) -> dict[str, list[int]]:
        """Bad lines of the kept part of the scan, by their kind of fault."""
        kept = self.kept
        first = kept.start
        # the first kept line is good, as the lines before are copies of it
        repeated = [line for line in self.repeated if line != first]
        kinds = {
            "all heights equal": self.constant,
            "the same as the line before": repeated,
            "offset from both neighbours": self.offset,
        }
        return {
            kind: [line for line in lines if kept.start <= line < kept.stop]
            for kind, lines in kinds.items()
        }

    def described(self) -> Iterator[str]:
        """Yield what is wrong, for each kind of fault."""
        kept = self.kept
        if kept != slice(0, self.lines):
            yield (
                f"only lines {kept.start} to {kept.stop - 1} of {self.lines} were "
                "measured, the scan was aborted"
            )
        for kind, lines in self._inside.items():
            if lines:
                yield f"{kind}: {listed(lines)}"
        if self.scars.any():
            lines = np.flatnonzero(self.scars.any(axis=0)).tolist()
            yield f"scars, which are streaks along a line: {listed(lines)}"

    def clipped(self) -> Iterator[str]:
        """Yield which heights are clipped."""
        for name, share in (("largest", self.highest), ("smallest", self.lowest)):
            if share:
                yield f"{100.0 * share:.2g} % of the points have the {name} height"


def not_recorded(heights: FloatArray) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return which lines have equal heights, and which repeat the line before.

    There are no such lines on a surface that varies along x or along y only.
    """
    constant, repeated = _constant(heights), _repeated(heights)
    good = ~(constant | repeated) & (_count(heights) >= _MIN_POINTS)
    if not good[1:].any():
        constant[:] = repeated[:] = False
    return constant, repeated


def _constant(heights: FloatArray) -> NDArray[np.bool_]:
    """Return which lines have equal heights."""
    known = ~np.isnan(heights)
    highest = np.where(known, heights, -np.inf).max(axis=0)
    lowest = np.where(known, heights, np.inf).min(axis=0)
    return (_count(heights) >= _MIN_POINTS) & (highest == lowest)


def _count(heights: FloatArray) -> NDArray[np.intp]:
    """Return the number of known points on each line."""
    return np.count_nonzero(~np.isnan(heights), axis=0)


def _repeated(heights: FloatArray) -> NDArray[np.bool_]:
    """Return which lines repeat the line before."""
    before, after = heights[:, :-1], heights[:, 1:]
    same = (before == after) | (np.isnan(before) & np.isnan(after))
    known = ~np.isnan(after).all(axis=0)
    several = ~_constant(after)
    return np.append(False, same.all(axis=0) & known & several)


def _offset(steps: FloatArray, difference: float) -> NDArray[np.bool_]:
    """Return which lines are far from both neighbours.

    They are if steps between lines are larger than usual ones, and than the standard
    deviation of differences of neighbouring points.
    """
    far = max(_BAD_LINE_DEVIATIONS * deviation(steps), difference)
    up, down = steps[:-1], -steps[1:]
    between = (np.minimum(abs(up), abs(down)) > far) & (up * down > 0.0)
    return np.concatenate([[False], between, [False]])


def _scars(heights: FloatArray, difference: float) -> NDArray[np.bool_]:
    """Return which points are on streaks that are higher or lower than both sides."""
    found = np.zeros(heights.shape, bool)
    for width in range(1, min(_MAX_SCAR_WIDTH, min(heights.shape) // _MIN_POINTS) + 1):
        length = width * _MIN_POINTS
        across = 0.0
        for sign in _SIGNS:
            along_y = _runs(_stroke(sign * heights.T, width), length)
            across = max(across, float(along_y.max(initial=0.0)))
        for sign in _SIGNS:
            along = _stroke(sign * heights, width)
            threshold = max(
                _SCAR_TO_DIFFERENCES * difference,
                _SCAR_TO_ACROSS * across,
                _SCAR_TO_MEDIAN * float(np.median(_runs(along, length))),
            )
            scar = ndimage.binary_opening(along > threshold, np.ones((length, 1)))
            for line in range(width):
                found[:, 1 + line : 1 + line + scar.shape[1]] |= scar
    return found


def _stroke(heights: FloatArray, width: int) -> FloatArray:
    """Return by how much strips of some lines are higher than the lines beside them.

    It is zero where the lines beside a strip differ more from each other.
    """
    m = heights.shape[1]
    count = m - width - 1
    before, after = heights[:, :count], heights[:, width + 1 :]
    strip = heights[:, 1 : 1 + count]
    for line in range(2, width + 1):
        strip = np.minimum(strip, heights[:, line : line + count])
    stroke = strip - np.maximum(before, after)
    return np.where(stroke > abs(before - after), stroke, 0.0)


def _runs(strokes: FloatArray, length: int) -> FloatArray:
    """Return the smallest value along x of the points of a scar of a length."""
    smallest: FloatArray = ndimage.minimum_filter1d(strokes, length, axis=0)
    return smallest


def _clipped(heights: FloatArray) -> float:
    """Return the part of the points that have the largest height, if it is clipped."""
    values, counts = np.unique(heights[~np.isnan(heights)], return_counts=True)
    if len(values) < 2:
        return 0.0
    count, total = int(counts[-1]), int(counts.sum())
    least = max(_MIN_CLIPPED_POINTS, _MIN_CLIPPED_RATIO * total / len(values))
    return count / total if count > least else 0.0


def _numbers(lines: NDArray[np.bool_]) -> tuple[int, ...]:
    """Return the numbers of lines that are marked."""
    return tuple(np.flatnonzero(lines).tolist())


def listed(lines: Sequence[int]) -> str:
    """Return numbers of lines as text: ``lines 3, 7-9``."""
    runs: list[list[int]] = []
    for line in lines:
        if runs and line == runs[-1][-1] + 1:
            runs[-1].append(line)
        else:
            runs.append([line])
    names = [f"{run[0]}-{run[-1]}" if len(run) > 1 else f"{run[0]}" for run in runs]
    if len(names) > _MAX_NAMED_RUNS:
        names[_MAX_NAMED_RUNS:] = [f"... ({len(lines)} lines)"]
    return f"line{'s' if len(lines) > 1 else ''} {', '.join(names)}"
