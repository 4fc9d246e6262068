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
    coarse_residual : float
        Residual pressure at which coarse grids stop, in contact moduli.
    coarse_steps : int
        Maximum number of steps on a coarse grid.
    max_load_change : float
        Change of a repulsive wall's load, relative to the new one, above which a
        start on coarser grids replaces the given start.
    max_indenter_move : float
        The same for walls with attraction: the distance by which the change of load
        would move the indenter, in spacings. Their state depends on the start.
    forcing : float
        Residual of the linear system that its solution may leave, relative to the
        residual of the state.
    krylov_steps : int
        Maximum number of Krylov steps with the circulant model.
    dense_atoms, dense_window : int
        Largest number of atoms in contact with a repulsive wall, and longest side of
        the window, for which the linear system is solved by dense matrices.
    exact_residual : float
        If the solution of the model leaves a larger relative residual of the exact
        system, it preconditions Krylov steps with the exact Green's function.
    exact_krylov_steps : int
        Maximum number of such steps.
    inverse_residual : float
        If a step with the inverse of a repulsive wall leaves more than this part of the
        residual, the exact system is solved by such Krylov steps.
    inverse_forcing : float
        Residual that they may leave, relative to that of the state.
    attraction_residual : float
        Residual pressure below which the negative stiffness of an attractive wall is
        included, in contact moduli.
    history : int
        Number of earlier increments that are combined with the present one under walls
        with attraction.
    least_curvature : float
        Lower bound to the curvatures of the combination, relative to the curvature
        along one increment.
    remaining_slope : float
        Slope at which the line search stops, relative to the initial one.
    load_steps : int
        Maximum number of steps of the indenter alone after each Newton step.
    largest_gap : float
        Largest overlap with a hard wall, or gap of an atom under its reaction, in
        spacings, whatever the tolerance of the force.
    first_violation : float
        Under a hard wall, the first update of its reaction takes place when the largest
        force is that of such a violation of the constraint, in spacings, times
        `reaction_forcing`.
    reaction_forcing : float
        The same for the next updates, relative to the violation at the last one.
    watchdog : int
        Number of steps with the inverse of a repulsive wall that need not decrease the
        residual before one must lower the energy.
    patience : int
        Number of steps without progress after which the solver stops.
    stagnation_steps : int
        Interval at which slow progress is checked.
    stagnation_fall : float
        Smallest decrease of the energy in this interval, in units of its rounding
        error, unless the largest force has halved.
    """

    coarsest: int = 32
    coarse_residual: float = 0.1
    coarse_steps: int = 300
    max_load_change: float = 0.25
    max_indenter_move: float = 3.0
    forcing: float = 0.1
    krylov_steps: int = 40
    dense_atoms: int = 200
    dense_window: int = 64
    exact_residual: float = 1.0
    exact_krylov_steps: int = 10
    inverse_residual: float = 0.3
    inverse_forcing: float = 0.09
    attraction_residual: float = 0.3
    history: int = 6
    least_curvature: float = 0.003
    remaining_slope: float = 0.3
    load_steps: int = 3
    largest_gap: float = 1e-6
    first_violation: float = 0.03
    reaction_forcing: float = 3.0
    watchdog: int = 10
    patience: int = 5
    stagnation_steps: int = 50
    stagnation_fall: float = 1e8

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
    coarse_gap : float
        The same on coarse grids.
    full_contact : float
        Part of the atoms whose pressure in a full contact is positive above which
        this pressure is the start.
    largest_crop : float
        Largest part of the window for which a half space of its own is made.
    dense_atoms : int
        Largest number of atoms in contact for which the contact problem of a window of
        up to `exact_size` atoms is solved by dense matrices. Without a start, which
        takes more steps, a third of this number.
    exact_size : int
        Windows of up to this number of atoms have an exact model.
    exact_contact : float
        The same from this part of the window in contact on.
    contraction : float
        Violation of the contact conditions that the solution for the model may leave,
        relative to the present one.
    exact_contraction : float
        The same of a model that is exact, in units of its rounding error.
    forcing, plastic_forcing : float
        Violation that the conjugate gradients may leave before the set of atoms in
        contact is updated, relative to the present one, for elastic and for plastic
        contact.
    loose_updates : int
        Number of updates of the set with this violation. At each further one it is
        halved, so that the set cannot cycle.
    inner_steps : int
        Maximum number of steps of conjugate gradients and updates of the set for a
        correction.
    slow_contraction : float
        If the violation has decreased by less than this factor, the correction is
        combined with the last one.
    patience : int
        Number of steps without progress after which the solver stops.
    """

    coarsest: int = 64
    largest_gap: float = 1e-6
    coarse_gap: float = 0.07
    full_contact: float = 0.8
    largest_crop: float = 0.5
    dense_atoms: int = 200
    exact_size: int = 64 * 64
    exact_contact: float = 0.5
    contraction: float = 0.07
    exact_contraction: float = 1000.0
    forcing: float = 0.4
    plastic_forcing: float = 0.25
    loose_updates: int = 6
    inner_steps: int = 300
    slow_contraction: float = 0.15
    patience: int = 10

    def __post_init__(self) -> None:
        """Check the numbers."""
        check_options(self)
