"""How much memory a window takes, and whether the machine has it."""

from __future__ import annotations

import math
import os

# Measured at the peak of a step, above the base, for an atom: 300 bytes (hard wall) and
# 400 (repulsive) in free windows of 2500 x 2400, 970 in 512 x 512 with their margin.
_PER_ATOM = 400
_PER_ATOM_IN_MARGIN = 1050
# Heights and waves of a roughness, while they are made, and as they are kept.
_PER_POINT_MADE = 30
_PER_POINT_KEPT = 11
# Python and its libraries: 116 MB were measured.
_BASE = 130e6


def memory_of(
    window: tuple[int, int], *, margin: bool = False, points: int = 0
) -> float:
    """Peak memory of a process that takes a step (bytes).

    Parameters
    ----------
    window : (int, int)
        Shape.
    margin : bool
        Whether a free window has its margin.
    points : int
        Of a roughness that is made of waves; see `points_of`.

    Returns
    -------
    float
        Estimate, between 3/4 and 4/3 of the largest resident size of a fresh process:
        1.02 to 1.22 of it in windows of 216 x 216 to 512 x 512 atoms, with every kind
        of wall and boundary, smooth and rough, 1.0 to 1.3 in one of 2500 x 2400.
        Measured maps, and what else the process holds, come on top.
    """
    step = math.prod(window) * (_PER_ATOM_IN_MARGIN if margin else _PER_ATOM)
    return _BASE + max(_PER_POINT_MADE * points, _PER_POINT_KEPT * points + step)


def points_of(indenter: object, spacing: float) -> int:
    """Points of the domain on which the roughness of an indenter is kept.

    Parameters
    ----------
    indenter : Surface
        A `RoughSphere`, or a roughness itself.
    spacing : float
        Of the atoms (length).

    Returns
    -------
    int
        Zero for a smooth indenter, and for a map, which is there before.
    """
    side = getattr(getattr(indenter, "roughness", indenter), "side", 0.0)
    return round(side / spacing) ** 2


def available_memory() -> float:
    """Memory that this machine can give now (bytes); infinity if it does not tell."""
    try:
        with open("/proc/meminfo") as file:
            lines = dict(line.split(":") for line in file)
        return 1024.0 * float(lines["MemAvailable"].split()[0])
    except (OSError, KeyError, ValueError):
        pass
    if not hasattr(os, "sysconf") or "SC_PHYS_PAGES" not in os.sysconf_names:
        return math.inf
    return float(os.sysconf("SC_PHYS_PAGES")) * os.sysconf("SC_PAGE_SIZE")


def check_roughness(points: int) -> None:
    """Raise `MemoryError` if a roughness can't be made; see `points_of`."""
    needed, there = memory_of((0, 0), points=points), available_memory()
    if needed > there:
        side = math.isqrt(points)
        raise MemoryError(
            f"a domain of {side} x {side} points needs about {needed / 1e9:.3g} GB of "
            f"memory while its roughness is made, but only {there / 1e9:.3g} GB are "
            "free: choose a smaller domain, by default 4 times the longest wave"
        )


def check_memory(
    window: tuple[int, int], *, margin: bool = False, points: int = 0
) -> None:
    """Raise `MemoryError` if a window does not fit into the memory; see `memory_of`."""
    needed = memory_of(window, margin=margin, points=points)
    there = available_memory()
    if needed > there:
        raise MemoryError(
            f"a window of {window[0]} x {window[1]} atoms needs about "
            f"{needed / 1e9:.3g} GB of memory, but only {there / 1e9:.3g} GB are free: "
            "choose a smaller load, sphere or window"
        )
