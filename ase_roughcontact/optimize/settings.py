r"""Settings for ASE's optimizers of a contact, and checks that an optimizer is suited.

ASE's defaults are for molecules and crystals of a few hundred atoms. In a contact the
largest curvature of the energy of a single atom is about

.. math:: k = a_0^2\,[\max_q K(q) + 3\, V''(g_0)]

with the stiffness K of the half space and the stiffness of the wall where it begins to
repel. A free indenter touches :math:`n` atoms at once, and its curvature is :math:`3 n
a_0^2 V''(g_0)`. Time steps of FIRE, FIRE2 and MDMin above :math:`2 k^{-1/2}` are
unstable, so that ASE's defaults do not converge under a load. Quasi-Newton methods
start from k as the curvature of all coordinates. In a step no coordinate should change
by more than the range in which the force of the wall changes.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from ase import Atoms
from ase.optimize import (
    BFGS,
    FIRE,
    FIRE2,
    LBFGS,
    BFGSLineSearch,
    CellAwareBFGS,
    GoodOldQuasiNewton,
    GPMin,
    LBFGSLineSearch,
    MDMin,
)
from ase.optimize.precon import PreconFIRE, PreconLBFGS, PreconODE12r
from ase.optimize.precon.precon import SparsePrecon
from ase.optimize.sciopt import SciPyFmin, SciPyFminBFGS, SciPyFminPowell

from ase_roughcontact.atoms.constraints import soft_contact_of
from ase_roughcontact.atoms.sticking import indenter_fixed
from ase_roughcontact.contact import Contact
from ase_roughcontact.optimize.modes import FourierModes
from ase_roughcontact.optimize.precon import HalfSpacePrecon
from ase_roughcontact.optimize.tolerance import solution

# Largest time step, relative to the stability limit.
_RELATIVE_TIME_STEP = 0.5
# First time step, relative to the largest one.
_RELATIVE_FIRST_STEP = 0.2
# Stiffness of the wall under pressure, relative to its stiffness where it begins to
# repel.
_RELATIVE_STIFFNESS = 3.0
# Largest change of a coordinate in a step, in spacings.
_MAX_CHANGE_PER_SPACING = 0.1
# Largest change of a coordinate in a step, in ranges of the attraction.
_MAX_CHANGE_PER_RANGE = 0.5
# Number of vectors that LBFGS keeps.
_MEMORY = 20
# Largest number of coordinates for methods that solve a dense matrix in each step: this
# takes about 1 s.
_MAX_DENSE_COORDINATES = 1_000

# Optimizers that integrate equations of motion.
_DYNAMICS = FIRE, FIRE2, MDMin
# Optimizers that start from a curvature `alpha`.
_QUASI_NEWTON = BFGS, LBFGS, LBFGSLineSearch, BFGSLineSearch
# Optimizers with a preconditioner.
_PRECONDITIONED = PreconFIRE, PreconLBFGS, PreconODE12r
# Optimizers with a dense matrix.
_DENSE = BFGS, BFGSLineSearch, GoodOldQuasiNewton, SciPyFminBFGS
# Optimizers that can't relax a contact, and why.
_UNSUITED = {
    CellAwareBFGS: "relaxes a cell, and the cell of a surface is given",
    GPMin: "fits a dense matrix to all coordinates of all steps",
    SciPyFmin: "does not use forces",
    SciPyFminPowell: "does not use forces",
}
# Advice in errors about optimizers.
_ADVICE = "use LBFGS, FIRE2 or NewtonKrylov"


def settings_for(
    optimizer: Callable[..., Any], atoms: Atoms | FourierModes
) -> dict[str, Any]:
    """Return settings with which an optimizer of ASE relaxes a contact.

    `load_path` uses these settings for classes of ASE.

    Parameters
    ----------
    optimizer : type, or partial of a type
        Class of ASE, such as ``FIRE2`` or ``partial(LBFGS, memory=50)``.
    atoms : Atoms or FourierModes
        Atoms with a `RoughContact` calculator and a soft wall. For a free indenter the
        calculator needs the load: the solver finds the number of atoms in contact.

    Returns
    -------
    dict
        Keyword arguments, including the arguments of a partial; empty if the optimizer
        needs no settings.

    Raises
    ------
    ValueError
        If the optimizer can't relax these coordinates, the calculator is not a
        `RoughContact`, or the wall is hard.

    Examples
    --------
    >>> from ase.optimize import FIRE2
    >>> from ase_roughcontact import RoughContact, RoughSphere
    >>> from ase_roughcontact import settings_for, substrate
    >>> sphere = RoughSphere(radius=200.0)
    >>> atoms = substrate('Cu', (16, 16), sphere, height=1.0)
    >>> atoms.calc = RoughContact(sphere, contact_modulus=0.5)
    >>> settings = settings_for(FIRE2, atoms)
    >>> {name: round(value, 2) for name, value in settings.items()}
    {'maxstep': 4.08, 'dt': 0.08, 'dtmax': 0.41}
    >>> bool(FIRE2(atoms, logfile=None, **settings).run(fmax=1e-3))
    True
    """
    kind, given = class_of(optimizer)
    if kind is None:
        raise ValueError(
            f"optimizer must be a class of ASE, or a partial of one, got {optimizer!r}"
        )
    if isinstance(atoms, FourierModes):
        check_suitable(kind, atoms.ndofs())
        settings = _on_modes(kind, atoms)
    else:
        check_suitable(kind, 3 * len(atoms))
        settings = _on_atoms(kind, atoms, given)
    return settings | given


def on_modes(optimizer: Callable[..., Any], **options: Any) -> Callable[..., Any]:
    """Return a function that makes an optimizer of ASE on the `FourierModes` of atoms.

    Parameters
    ----------
    optimizer : type, or partial of a type
        Class of ASE.
    **options
        Options of the optimizer, which replace settings from `settings_for`.

    Returns
    -------
    callable
        Function ``f(atoms, logfile=None)`` for `load_path` and `compare_optimizers`.

    Raises
    ------
    ValueError
        When the function is called; see `settings_for`.

    Examples
    --------
    >>> from ase.optimize import FIRE2
    >>> from ase_roughcontact import RoughContact, RoughSphere, load_path
    >>> from ase_roughcontact import on_modes, substrate
    >>> sphere = RoughSphere(radius=200.0)
    >>> atoms = substrate('Cu', (16, 16), sphere)
    >>> atoms.calc = RoughContact(sphere, contact_modulus=0.5)
    >>> path = load_path(
    ...     atoms, penetrations=0.5, optimizer=on_modes(FIRE2), accuracy=1e-2
    ... )
    >>> (step,) = path
    >>> step.converged, step.repulsive_atoms
    (True, 61)
    """

    def made(atoms: Atoms, **others: Any) -> Any:
        modes = FourierModes(atoms)
        settings = settings_for(optimizer, modes)
        return optimizer(modes, **(settings | options | others))

    return made


def class_of(optimizer: Any) -> tuple[type | None, dict[str, Any]]:
    """Return the class of an optimizer and its options; None for other functions."""
    options: dict[str, Any] = {}
    if isinstance(optimizer, partial) and not optimizer.args:
        optimizer, options = optimizer.func, optimizer.keywords
    return (optimizer, options) if isinstance(optimizer, type) else (None, {})


def check_suitable(kind: type, coordinates: int) -> None:
    """Raise `ValueError` if an optimizer can't relax a surface.

    Parameters
    ----------
    kind : type
        Class of the optimizer.
    coordinates : int
        Number of coordinates.
    """
    for each, reason in _UNSUITED.items():
        if issubclass(kind, each):
            raise ValueError(f"{kind.__name__} {reason}: {_ADVICE}")
    if issubclass(kind, _DENSE) and coordinates > _MAX_DENSE_COORDINATES:
        size = 8e-9 * coordinates**2
        raise ValueError(
            f"{kind.__name__} keeps a matrix of {coordinates} x {coordinates} numbers, "
            f"{size:.1f} GB, and solves it in each step: {_ADVICE}"
        )


def make_optimizer(optimizer: Callable[..., Any], atoms: Atoms) -> Any:
    """Return an optimizer of atoms; classes of ASE get `settings_for` the atoms.

    Parameters
    ----------
    optimizer : callable
        Class or function, which is called as ``optimizer(atoms, logfile=None)``.
    atoms : Atoms
        The atoms.

    Returns
    -------
    Optimizer
        The optimizer.

    Raises
    ------
    ValueError
        If the optimizer can't be made, or can't relax the atoms.
    """
    kind, _ = class_of(optimizer)
    settings: dict[str, Any] = {}
    if kind is not None and kind.__module__.startswith("ase.optimize."):
        settings = settings_for(optimizer, atoms)
    try:
        made = optimizer(atoms, logfile=None, **settings)
    except (AttributeError, TypeError) as error:
        raise ValueError(
            f"{optimizer} can't be made for these coordinates: {error}; {_ADVICE}"
        ) from error
    if kind is None:
        check_suitable(type(made), made.optimizable.ndofs())
    if isinstance(getattr(made, "precon", None), SparsePrecon):
        raise ValueError(
            f"{type(made).__name__} makes its preconditioner from neighbours in a "
            "strained cell: give precon=HalfSpacePrecon(atoms), or None"
        )
    return made


def _on_modes(kind: type, modes: FourierModes) -> dict[str, Any]:
    """Return the settings of an optimizer on modes."""
    if issubclass(kind, _PRECONDITIONED):
        raise ValueError(
            f"{kind.__name__} needs atoms: give it precon=HalfSpacePrecon(atoms), or "
            "the modes to LBFGS"
        )
    if issubclass(kind, _DYNAMICS):
        return {"maxstep": modes.maxstep}
    if issubclass(kind, _QUASI_NEWTON):
        return {"alpha": 1.0, **_memory(kind)}
    return {}


def _on_atoms(kind: type, atoms: Atoms, given: dict[str, Any]) -> dict[str, Any]:
    """Return the settings of an optimizer on atoms, except the given ones."""
    contact = soft_contact_of(atoms)
    longest, stiffness = _largest_change(contact), _largest_curvature(contact)
    if issubclass(kind, _PRECONDITIONED):
        return {} if "precon" in given else {"precon": HalfSpacePrecon(atoms)}
    if issubclass(kind, _QUASI_NEWTON):
        return {"alpha": stiffness, "maxstep": longest, **_memory(kind)}
    if not issubclass(kind, _DYNAMICS):
        return {}
    if not indenter_fixed(atoms):
        stiffness = max(stiffness, _indenter_curvature(contact, atoms))
    dtmax = 2.0 * _RELATIVE_TIME_STEP / stiffness**0.5
    # FIRE and FIRE2 limit the norm of a step, ABC-FIRE each coordinate
    norm = 1.0 if given.get("use_abc") else contact.heights.size**0.5
    if issubclass(kind, MDMin):
        return {"maxstep": norm * longest, "dt": dtmax}
    dt = _RELATIVE_FIRST_STEP * dtmax
    return {"maxstep": norm * longest, "dt": dt, "dtmax": dtmax}


def _memory(kind: type) -> dict[str, Any]:
    return {"memory": _MEMORY} if issubclass(kind, LBFGS) else {}


def _largest_change(contact: Contact) -> float:
    """Return the largest change of a coordinate in a step (length)."""
    wall = contact.wall
    longest = _MAX_CHANGE_PER_SPACING * contact.halfspace.spacing
    if wall.attractive:
        longest = min(longest, _MAX_CHANGE_PER_RANGE * wall.attraction_range)
    return longest


def _wall_curvature(contact: Contact) -> float:
    """Return the curvature of the energy of the wall on an atom (force per length)."""
    stiffness = _RELATIVE_STIFFNESS * contact.wall.stiffness_at_contact
    return contact.halfspace.cell_area * stiffness


def _largest_curvature(contact: Contact) -> float:
    """Return the largest curvature of the energy of an atom (force per length)."""
    halfspace = contact.halfspace
    elastic = halfspace.cell_area * float(halfspace.stiffness.max())
    return elastic + _wall_curvature(contact)


def _indenter_curvature(contact: Contact, atoms: Atoms) -> float:
    """Return the curvature of the energy with the indenter's height (force/length)."""
    _, run = solution(atoms, error=0.1)
    return run.fields.repulsive_atoms * _wall_curvature(contact)
