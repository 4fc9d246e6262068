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
    load_factor : float
        Normal force over ``E*``, depth and half the side of the overlap; by default
        that of Hertz's contact.
    contact_window_size : int
        Number of atoms above which a window is made for the expected contact only,
        not for all atoms that the rigid indenter overlaps.
    contact_window_scale : float
        Factor by which such a window is larger than the expected contact.
    """

    load_factor: float = math.sqrt(8.0) / 3.0
    contact_window_size: int = 256 * 256
    contact_window_scale: float = 1.03

    def __post_init__(self) -> None:
        """Check the numbers."""
        check_options(self)
