"""What a contact needs to know of an indenter: its heights on a grid of atoms."""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

from ase_roughcontact._util.validation import FloatArray


class Surface(Protocol):
    """What a contact needs to know of an indenter."""

    def heights(
        self,
        shape: tuple[int, int],
        spacing: float,
        origin: tuple[float, float] = (0.0, 0.0),
    ) -> FloatArray:
        """Sample the lower side of the indenter on a grid.

        Parameters
        ----------
        shape : tuple of int
            Grid points (n, m) along x and y.
        spacing : float
            Distance between grid points.
        origin : tuple of float
            Position (x, y) of grid point (0, 0) relative to the indenter's axis.

        Returns
        -------
        ndarray, shape (n, m)
            Heights, positive upward, away from the substrate.
        """
        ...

    def todict(self) -> dict[str, Any]:
        """Return the name and the parameters of the surface, for files only.

        Returns
        -------
        dict
            Of strings and numbers, the same for the same surface: a trajectory keeps
            it, and a path is resumed only with the same one.
        """
        ...


@runtime_checkable
class BoundedSurface(Surface, Protocol):
    """A surface that rises out of reach, so that windows can be chosen for it."""

    def reach(
        self, level: float, spacing: float, origin: tuple[float, float] = (0.0, 0.0)
    ) -> float:
        """Distance from the axis beyond which no atom is lower than a level."""
        ...

    @property
    def extent(self) -> float:
        """Distance from the axis, along x and y, up to which heights are known once."""
        ...

    @property
    def repeats(self) -> bool:
        """Whether the surface goes on, repeating itself, beyond the extent."""
        ...
