"""Options of the solvers; the guide has a table of measured steps for them."""

from __future__ import annotations

from dataclasses import dataclass

from ase_roughcontact._util.validation import check_options


@dataclass(frozen=True)
class NewtonKrylovOptions:
    """Options of the Newton-Krylov solver for soft walls.

    Attributes
    ----------
    coarsest : int
        Smallest number of atoms along the shorter side of a coarsened window.
    max_load_change : float
        Largest change of the load of a repulsive wall, relative to the new load, at
        which the given start is used; otherwise coarser grids give a start.
    max_indenter_move : float
        Largest distance, in spacings, by which a change of load may move the indenter
        for the given start to be used with a wall with attraction, where the state
        depends on the start.
    forcing : float
        Largest residual of the solution of a linear system, relative to the residual of
        the state.
    history : int
        Number of earlier increments that are combined with the present one under walls
        with attraction.
    largest_gap : float
        Largest overlap with a hard wall, or gap of an atom under its reaction, in
        spacings, for any tolerance of the force.
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
        Smallest number of atoms along the shorter side of a coarsened window.
    largest_gap : float
        Largest gap in contact or overlap of a result, in spacings, for any tolerance of
        the force.
    contraction : float
        Largest violation of the contact conditions by the solution for the model,
        relative to the present violation.
    slow_contraction : float
        Ratio of the present violation to the last one, above which a correction is
        combined with the last correction.
    """

    coarsest: int = 64
    largest_gap: float = 1e-6
    contraction: float = 0.07
    slow_contraction: float = 0.15

    def __post_init__(self) -> None:
        """Check the numbers."""
        check_options(self)
