"""Options of automatic windows."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ase_roughcontact._util.validation import check_options


@dataclass(frozen=True)
class WindowOptions:
    """Options of automatic windows; they change the cost of a path, not its results.

    Attributes
    ----------
    largest_excess : float
        A window is kept for the next step while it has at most this many times the
        atoms that are needed.
    largest_deepening : float
        Largest factor by which the depth of the overlap, for which a window is made,
        increases at once when a window is too small.
    restart_growth : float
        With a repulsive wall, a step starts from flat atoms if this many times more
        atoms overlap than at the last one.
    load_factor : float
        Normal force over ``E*``, depth and half the side of the overlap, before any
        step is known; by default that of Hertz's contact.
    contact_window_size : int
        Number of atoms above which a window is made for the expected contact only,
        not for all atoms that the rigid indenter overlaps.
    contact_window_scale : float
        Factor by which such a window is larger than the expected contact.
    """

    largest_excess: float = 2.0
    largest_deepening: float = 2.0
    restart_growth: float = 1.1
    load_factor: float = math.sqrt(8.0) / 3.0
    contact_window_size: int = 256 * 256
    contact_window_scale: float = 1.03

    def __post_init__(self) -> None:
        """Check the numbers."""
        check_options(self)
