"""Memory of a step in a window, estimated and compared with that of the machine."""

from __future__ import annotations

import math
import os

# Bytes for each atom at the peak of a step, also in a window with its margin.
_PER_ATOM = 400
_PER_ATOM_IN_MARGIN = 1050
# Bytes for each point of a roughness: while it is synthesised, and afterwards.
_PER_POINT_MADE = 30
_PER_POINT_KEPT = 11
# Bytes of Python and its libraries.
_BASE = 130e6


def memory_of(
    window: tuple[int, int], *, margin: bool = False, points: int = 0
) -> float:
    """Estimate the peak memory of a process that calculates a step.

    Parameters
    ----------
    window : (int, int)
        Shape.
    margin : bool
        Whether the window of a free half space has its margin.
    points : int
        Of a roughness synthesised from its spectrum; see `points_of`.

    Returns
    -------
    float
        Bytes, between 3/4 and 4/3 of the largest resident size of a fresh process.
        Measured height maps, and other data of the process, add to it.
    """
    step = math.prod(window) * (_PER_ATOM_IN_MARGIN if margin else _PER_ATOM)
    return _BASE + max(_PER_POINT_MADE * points, _PER_POINT_KEPT * points + step)


def points_of(indenter: object, spacing: float) -> int:
    """Return the number of points on which the roughness of an indenter is stored.

    Parameters
    ----------
    indenter : Surface
        A `RoughSphere`, or a roughness itself.
    spacing : float
        Of the atoms (length).

    Returns
    -------
    int
        Zero for a smooth indenter, and for a height map, which exists already.
    """
    side = getattr(getattr(indenter, "roughness", indenter), "side", 0.0)
    return round(side / spacing) ** 2


def available_memory() -> float:
    """Return the free memory of this machine (bytes); infinity if it is not known."""
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
    """Raise `MemoryError` if a roughness exceeds the free memory; see `points_of`."""
    side = math.isqrt(points)
    _check(
        memory_of((0, 0), points=points),
        f"to synthesise the roughness on a domain of {side} x {side} points",
        "choose a smaller domain (by default 4 times the longest wavelength)",
    )


def check_memory(window: tuple[int, int], *, margin: bool = False) -> None:
    """Raise `MemoryError` if a window exceeds the free memory; see `memory_of`."""
    _check(
        memory_of(window, margin=margin),
        f"for a window of {window[0]} x {window[1]} atoms",
        "choose a smaller load, sphere or window",
    )


def _check(needed: float, purpose: str, advice: str) -> None:
    available = available_memory()
    if needed > available:
        raise MemoryError(
            f"about {needed / 1e9:.3g} GB of memory are needed {purpose}, but only "
            f"{available / 1e9:.3g} GB are free: {advice}"
        )
