"""Options of the solvers; the guide has a table of what was measured for them."""

from __future__ import annotations

from dataclasses import dataclass

from ase_roughcontact._util.validation import check_options


@dataclass(frozen=True)
class NewtonKrylovOptions:
    """Options of the Newton-Krylov solver for soft walls.

    Attributes
    ----------
    coarsest : int
        Windows are not coarsened below this number of atoms along their shorter side.
    max_load_change : float
        Change of a repulsive wall's load, relative to the new one, above which a
        start on coarser grids replaces the given start.
    max_indenter_move : float
        The same for walls with attraction: the distance by which the change of load
        would move the indenter, in spacings. Their state depends on the start.
    forcing : float
        Residual of the linear system that its solution may leave, relative to the
        residual of the state.
    history : int
        Number of earlier increments that are combined with the present one under walls
        with attraction.
    largest_gap : float
        Largest overlap with a hard wall, or gap of an atom under its reaction, in
        spacings, whatever the tolerance of the force.
    """

    coarsest: int = 32
    max_load_change: float = 0.25
    max_indenter_move: float = 3.0
    forcing: float = 0.1
    history: int = 6
    largest_gap: float = 1e-6

    def __post_init__(self) -> None:
        """Check the numbers."""
        check_options(self)


@dataclass(frozen=True)
class ActiveSetOptions:
    """Options of the active-set solver for the hard wall.

    Attributes
    ----------
    coarsest : int
        Windows are not coarsened below this number of atoms along their shorter side.
    largest_gap : float
        Largest gap in contact or overlap of a result, in spacings, whatever the
        tolerance of the force.
    contraction : float
        Violation of the contact conditions that the solution for the model may leave,
        relative to the present one.
    slow_contraction : float
        If the violation has decreased by less than this factor, the correction is
        combined with the last one.
    """

    coarsest: int = 64
    largest_gap: float = 1e-6
    contraction: float = 0.07
    slow_contraction: float = 0.15

    def __post_init__(self) -> None:
        """Check the numbers."""
        check_options(self)
