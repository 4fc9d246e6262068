"""Sliding paths of atoms, with friction."""

from __future__ import annotations

from collections.abc import Callable, Generator
from typing import Any

import numpy as np
from ase import Atoms
from numpy.typing import ArrayLike

from ase_roughcontact._util.keywords import suggesting
from ase_roughcontact._util.lazy import lazy
from ase_roughcontact._util.validation import instance_of
from ase_roughcontact.atoms.calculator import model_of
from ase_roughcontact.atoms.grid import SurfaceGrid, on_grid, set_lateral_displacement
from ase_roughcontact.atoms.history import (
    check_history,
    creep_of,
    history_of,
    kept_keys,
    set_history,
)
from ase_roughcontact.atoms.info import LATTICE, info_of
from ase_roughcontact.atoms.marks import set_mark
from ase_roughcontact.atoms.sticking import (
    STICKS,
    SlipError,
    Sticking,
    check_released,
    exceeds,
)
from ase_roughcontact.contact.control import control_of
from ase_roughcontact.contact.state import (
    DISPLACEMENTS,
    SLIPPING,
    TRACTION_DEPTH,
    TRACTIONS,
)
from ase_roughcontact.elasticity.lateral import LateralHalfSpace
from ase_roughcontact.interactions.friction import Coupling, FrictionLaw, check_law
from ase_roughcontact.interactions.local_friction import LocalFriction
from ase_roughcontact.interactions.rate_and_state import check_rate, check_without_rate
from ase_roughcontact.loading.load_path import AtomsPath, single_path
from ase_roughcontact.path_kinds.sliding.record import SlidingStep
from ase_roughcontact.path_kinds.sliding.specification import SlidingSpecification
from ase_roughcontact.path_kinds.sliding.steps import SlidingSteps
from ase_roughcontact.path_kinds.sliding.timed_specification import (
    TimedSlidingSpecification,
)
from ase_roughcontact.path_kinds.sliding.timed_steps import TimedSlidingSteps
from ase_roughcontact.paths.output import OutputLike
from ase_roughcontact.paths.path_steps import PathSteps
from ase_roughcontact.paths.schedule import Schedule
from ase_roughcontact.results.validity import Reaction, Validity
from ase_roughcontact.solvers.lateral.friction import solve_friction
from ase_roughcontact.stepping.accuracy import Accuracy
from ase_roughcontact.stepping.options import Window


def stick(atoms: Atoms, friction: FrictionLaw) -> Sticking:
    r"""Let the atoms in contact move sideways with the indenter, for ASE's optimizers.

    Parameters
    ----------
    atoms : Atoms
        Atoms from `substrate`, with a `RoughContact` calculator, relaxed or after a
        sliding path in which no atom slips. They get the constraint that is returned.
    friction : FrictionLaw
        Law of friction. The atoms on which it acts at the present pressure stick. Best
        `Tresca`: with `Coulomb`, atoms at the edge, of almost no pressure, slip after a
        short way.

    Returns
    -------
    Sticking
        Constraint of ASE; its method `move` moves the indenter. Keep it in the list
        if you set others: ``atoms.set_constraint([sticking, ...])``.

    Raises
    ------
    ValueError
        If there are no such atoms, they stick already, their path has coupled normal
        and lateral motion, or a free half space has no padding; at a calculation, if
        the constraint was removed without `release`.
    TypeError
        If friction is no law.
    SlipError
        If atoms slip.
    NotImplementedError
        If the solid has no lateral components.

    Notes
    -----
    All surface atoms have lateral forces then. With the inverse K of the lateral
    Green's function, the elastic energy of lateral displacements u and minus its
    gradient,

    .. math:: U_\text{lateral} = \frac{a_0^2}{2} \sum u \cdot K u, \qquad
              f = -a_0^2 K u,

    are part of the results. Minus the sum of the forces on the atoms that stick is the
    ``lateral_force`` of the indenter, which `FixAtoms` or ``FixCartesian`` hold or a
    `Hookean` pulls: under the constraint it has the forces on these atoms. Bounds of
    friction follow from the present pressure. `release` ends it.

    Examples
    --------
    >>> from ase.optimize import LBFGS
    >>> from ase_roughcontact import HardWall, RoughContact, RoughSphere, Tresca
    >>> from ase_roughcontact import load_path, stick, substrate
    >>> from ase_roughcontact.elasticity import Isotropic
    >>> sphere = RoughSphere(radius=500.0)
    >>> atoms = substrate("Cu", (16, 16), sphere, spacing=2.5)
    >>> solid = Isotropic(0.8, poisson=0.3)
    >>> atoms.calc = RoughContact(sphere, solid=solid, wall=HardWall())
    >>> (step,) = load_path(atoms, penetrations=[0.5])
    >>> stick(atoms, Tresca(0.01)).move(atoms, (0.05, 0.0))
    >>> bool(LBFGS(atoms, logfile=None).run(fmax=1e-5))
    True
    """
    check_law(friction)
    check_without_rate(friction)
    instance_of(Atoms, atoms=atoms)
    check_released(atoms)
    model = model_of(atoms)
    if model.problem.solid.creep is not None:
        raise ValueError(
            "atoms can't stick on a viscoelastic solid, which creeps in time: use an "
            "elastic limit, solid.solid or solid.relaxed"
        )
    grid, halfspace = model.grid, model.lateral
    if grid.shape != halfspace.grid:
        raise ValueError(
            "lateral forces need the padding of the half space, which the atoms do not "
            "have: use restore(snapshot(atoms), solid)"
        )
    state, history = atoms.calc.state(atoms), history_of(atoms, grid)
    if TRACTION_DEPTH in history:
        raise ValueError(
            "atoms that stick have no coupling of normal and lateral motion in their "
            'energy, but their path has: use coupling="neglected"'
        )
    local = LocalFriction(
        friction, state.pressure, state.contact, grid.spacing, grid.origin, history
    )
    bounds = local.bounds()
    sticks, none = bounds > 0.0, np.zeros(grid.window)
    if not sticks.any():
        raise ValueError(
            "friction acts on no atom: relax the atoms first, or lower the indenter"
        )
    displacement = np.stack([history.get(key, none) for key in DISPLACEMENTS])
    tractions = _tractions(halfspace, sticks, displacement)
    # changes of the tractions by unit displacements along x and y
    units = np.eye(2)[:, :, None, None] * np.ones(grid.window)
    changes = [_tractions(halfspace, sticks, unit) for unit in units]
    index = on_grid(sticks, grid).ravel().nonzero()[0]
    slips = (history.get(SLIPPING, none) > 0.0) | exceeds(tractions, bounds)
    if slips[sticks].any():
        raise SlipError(index[slips[sticks]], len(index), "already")
    moved = halfspace.displacement(on_grid(tractions, grid))
    set_lateral_displacement(atoms, grid, moved)
    for key in (*TRACTIONS, SLIPPING):  # the constraint has them
        atoms.arrays.pop(key, None)
    atoms.info[LATTICE] |= {"axis": atoms.positions[-1, :2].tolist(), STICKS: True}
    sticking = Sticking(
        atoms,
        index,
        grid.spacing**2 * bounds[sticks],
        grid.spacing**2 * tractions[:, sticks].T,
        grid.spacing**2 * np.stack([each[:, sticks].T for each in changes], axis=-1),
    )
    atoms.set_constraint([*atoms.constraints, sticking])
    set_mark(atoms, len(kept_keys(atoms)))
    return sticking


def release(atoms: Atoms) -> None:
    """Release atoms that `stick`; they keep their friction, and a path can continue.

    Parameters
    ----------
    atoms : Atoms
        Atoms, changed in place: the indenter goes back above the middle of the lattice,
        which represents its displacement.
    """
    instance_of(Atoms, atoms=atoms)
    if LATTICE not in info_of(atoms):
        check_history(atoms)
    grid = SurfaceGrid.of(atoms)
    history = history_of(atoms, grid)
    others = [each for each in atoms.constraints if not isinstance(each, Sticking)]
    atoms.set_constraint(others)
    set_history(atoms, grid, history, creep_of(atoms))


def _tractions(
    halfspace: LateralHalfSpace, sticks: np.ndarray, imposed: np.ndarray
) -> np.ndarray:
    """Return the tractions by which atoms that stick have a displacement."""
    found = solve_friction(halfspace, np.where(sticks, np.inf, 0.0), imposed)
    if not found.converged:
        raise RuntimeError(found.message)
    return found.tractions


@lazy
@suggesting
def sliding_path(
    atoms: Atoms,
    friction: FrictionLaw,
    *,
    penetrations: ArrayLike | None = None,
    heights: ArrayLike | None = None,
    loads: ArrayLike | None = None,
    displacements: ArrayLike | Schedule | None = None,
    forces: ArrayLike | Schedule | None = None,
    bases: ArrayLike | Schedule | None = None,
    spring: float | None = None,
    coupling: Coupling = SlidingSpecification.coupling,
    tolerance: float = TimedSlidingSpecification.tolerance,
    optimizer: Callable[..., Any] | None = None,
    fmax: float | None = None,
    accuracy: Accuracy = "normal",
    max_steps: int = 10_000,
    window: Window = "fixed",
    validity: Reaction | Validity = "warn",
    output: OutputLike | None = None,
) -> Generator[SlidingStep, None, None]:
    """Move the indenter sideways against friction, one step after another.

    Parameters
    ----------
    atoms : Atoms
        Atoms from `substrate`, with a `RoughContact` calculator of a solid with lateral
        components: ``Isotropic(contact_modulus, poisson=...)``, with a schedule also a
        `Viscoelastic` solid of it.
    friction : FrictionLaw
        Law of friction: `Coulomb`, `Tresca`, `SlipWeakening`, `RateAndState`, or your
        own.
    penetrations, heights, loads : array_like, shape (steps,), or float
        Exactly one of them; see `load_path`. One number is the target of all steps.
    displacements, forces, bases : array_like, shape (steps,) or (steps, 2), or Schedule
        Exactly one of them, along x or along x and y: lateral displacements of the
        indenter (Å), lateral forces on it (eV/Å), or displacements of the base of a
        spring that moves it (Å). With `RateAndState`, a schedule along x in seconds.
    spring : float, optional
        Stiffness of the spring, for bases (eV/Å^2).
    coupling : {"neglected", "solved"}
        See `SlidingSpecification`.
    tolerance : float
        With a schedule: largest error of a time step, relative to the friction.
    optimizer, fmax, accuracy, max_steps, window, validity, output
        See `load_path`. Results are of the class `SlidingStep`, with a schedule of
        `TimedSlidingStep`.

    Yields
    ------
    SlidingStep
        Result of a step, also if it has not converged, as a contact that slides under a
        force.

    Raises
    ------
    RuntimeError
        If slip becomes unstable in time and its rate grows without limit.
    ValueError
        If not exactly one normal and one lateral path are given, the spring is missing,
        or as `load_path` does.
    TypeError
        If `output.record` is not derived from `SlidingStep`.
    NotImplementedError
        If the solid has no lateral components.

    Notes
    -----
    Lateral displacements leave the heights above the atoms as they are: the indenter
    stays at its x and y. Unless the coupling is solved, they leave the pressure as it
    is, too, which is exact for a Poisson's ratio of 1/2 (Goodman's approximation). The
    atoms move along x and y, but energy and forces depend on z only, unless atoms
    `stick`. They have the arrays ``traction_x``, ``traction_y`` (eV/Å^3) and
    ``slipping`` (1 or 0), which frames have as compressed text in `info`:
    ``ContactMap.from_frame(frame).lateral`` has them and the displacements. The
    calculator's `results` have the ``lateral_force``.

    Examples
    --------
    >>> import numpy as np
    >>> from ase_roughcontact import Coulomb, HardWall, Isotropic, RoughContact
    >>> from ase_roughcontact import RoughSphere, sliding_path, substrate
    >>> sphere = RoughSphere(radius=500.0)
    >>> atoms = substrate("Cu", (32, 32), sphere, spacing=2.5)
    >>> solid = Isotropic(0.8, poisson=0.3)
    >>> atoms.calc = RoughContact(sphere, solid=solid, wall=HardWall())
    >>> path = {"penetrations": 1.0, "displacements": np.linspace(0.0, 2.0, 5)}
    >>> steps = list(sliding_path(atoms, Coulomb(0.3), **path))
    >>> round(steps[-1].lateral_force_x / steps[-1].normal_force, 3)
    0.3
    """
    normal, targets = single_path(
        penetrations=penetrations, heights=heights, loads=loads
    )
    control, lateral = single_path(
        displacements=displacements, forces=forces, bases=bases
    )
    path = AtomsPath(
        atoms,
        control_of(normal),
        optimizer=optimizer,
        fmax=fmax,
        accuracy=accuracy,
        max_steps=max_steps,
        window=window,
        validity=validity,
        output=output,
    )
    steps: PathSteps
    if isinstance(lateral, Schedule):
        if coupling != SlidingSpecification.coupling:
            raise ValueError(
                "sliding in time neglects the coupling of normal and lateral motion, "
                f"got coupling={coupling!r}"
            )
        timed = TimedSlidingSpecification(
            targets, check_rate(friction), lateral, control, spring, tolerance=tolerance
        )
        steps = TimedSlidingSteps(path.stepper, timed)
    else:
        specification = SlidingSpecification(
            targets, friction, lateral, control, spring, coupling
        )
        steps = SlidingSteps(path.stepper, specification)
    return path.follow(steps)
