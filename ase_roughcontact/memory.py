"""How much memory a window takes, and whether the machine has it."""

from __future__ import annotations

import math
import os

# Measured at the peak of a step: 3.7 GB in a window of 2500 x 2400 atoms, Python and a
# roughness of 0.4 GB included; with its margin, a window of 512 x 512 atoms took
# 0.31 GB beside Python's 0.11 GB.
_PER_ATOM = 560
_PER_ATOM_IN_MARGIN = 1200
# The matrix, its factor, and one on the way.
_PER_PAIR_OF_SITES = 24
# Python and its libraries.
_BASE = 150e6


def memory_of(window: tuple[int, int], *, margin: bool = False) -> float:
    """Memory that a step takes (bytes).

    Parameters
    ----------
    window : (int, int)
        Shape, ``(k, 1)`` for scattered atoms.
    margin : bool
        Whether a free window has its margin.

    Returns
    -------
    float
        Estimate, to be trusted within a third.
    """
    size = math.prod(window)
    if window[1] == 1 and not margin:
        return _BASE + _PER_PAIR_OF_SITES * size**2
    return _BASE + size * (_PER_ATOM_IN_MARGIN if margin else _PER_ATOM)


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


def check_memory(window: tuple[int, int], *, margin: bool = False) -> None:
    """Raise `MemoryError` if a window does not fit into the memory; see `memory_of`."""
    needed, there = memory_of(window, margin=margin), available_memory()
    if needed > there:
        raise MemoryError(
            f"a window of {window[0]} x {window[1]} atoms needs about "
            f"{needed / 1e9:.3g} GB of memory, but only {there / 1e9:.3g} GB are free: "
            "choose a smaller load, sphere or window"
        )
