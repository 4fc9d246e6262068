"""Displacement at the centre of regions under a uniform pressure.

Over that of a circle of the same area, 2 p a/E*. Regions are unions of grid cells.
"""

import math

import numpy as np
from published import Value, run

from ase_roughcontact.elasticity.halfspace import FreeHalfSpace

SHAPES = "square", "triangle", "rhombus"
FIELDS = "shape", "points", "ratio"
CASES = [(n, points) for n in range(len(SHAPES)) for points in (257, 513, 1025)]
QUICK = [(n, 257) for n in range(len(SHAPES))]
DIAGONALS = 7.114  # of Knoop's indenter


def region(shape, points):
    """Return which cells are inside a region around the middle one."""
    half = 0.45 * points
    x = np.arange(points)[:, None] - points // 2
    y = np.arange(points)[None, :] - points // 2
    if shape == "square":
        return (abs(x) < half) & (abs(y) < half)
    if shape == "rhombus":
        return abs(x) / half + abs(y) * DIAGONALS / half < 1.0
    inner = 0.5 * half  # radius of the circle in an equilateral triangle
    sides = (0.5 * math.sqrt(3.0) * x - 0.5 * y, -0.5 * math.sqrt(3.0) * x - 0.5 * y)
    return (y < inner) & (sides[0] < inner) & (sides[1] < inner)


def calculate(number, points):
    """Yield the displacement of a circle over that of a region."""
    inside = region(SHAPES[number], points)
    halfspace = FreeHalfSpace((points, points), 1.0, 1.0)
    middle = halfspace.displacement(1.0 * inside)[points // 2, points // 2]
    yield number, points, abs(2.0 * math.sqrt(inside.sum() / math.pi) / middle)


def reported(rows):
    """Return the ratios on the finest grid, with the change of the last refinement."""
    found = {}
    for number, name in enumerate(SHAPES):
        ratios = [row["ratio"] for row in rows if row["shape"] == number]
        change = abs(ratios[-1] - ratios[-2]) if len(ratios) > 1 else math.nan
        found[name] = Value(ratios[-1], change)
    return found


if __name__ == "__main__":
    run(__file__, FIELDS, CASES, calculate)
