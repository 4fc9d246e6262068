r"""Settings with which ASE's optimizers relax a contact, and which of them can't.

The defaults of ASE are made for molecules and crystals of a few hundred atoms. Here the
largest curvature of the energy of a single atom is about

.. math:: k = a_0^2\,[\max_q K(q) + 3\, V''(g_0)]

with the stiffness of the half space and that of the wall where it begins to repel. A
free indenter touches :math:`n` atoms at once, and its curvature is :math:`3 n a_0^2
V''(g_0)`. Time steps of FIRE, FIRE2 and MDMin above :math:`2 k^{-1/2}` are unstable, so
that their defaults do not converge under a load; quasi-Newton methods start from k as
the curvature of all coordinates. No coordinate should change in a step by more than the
range in which the wall does.
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
    RFO,
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

# Part of the largest stable time step, and of it the first one.
_STABLE, _FIRST = 0.5, 0.2
# Stiffness of the wall under pressure, relative to its stiffness where it begins to
# repel.
_UNDER_PRESSURE = 3.0
# Largest change of a coordinate, in spacings and in ranges of an attraction.
_PART_OF_SPACING, _PART_OF_RANGE = 0.1, 0.5
# Vectors that LBFGS keeps.
_MEMORY = 20
# Largest number of coordinates of which a matrix is solved in each step: in about 1 s.
_LARGEST_MATRIX = 1_000

_DYNAMICS = FIRE, FIRE2, MDMin
_QUASI_NEWTON = BFGS, LBFGS, LBFGSLineSearch, BFGSLineSearch
_PRECONDITIONED = PreconFIRE, PreconLBFGS, PreconODE12r
_MATRICES = BFGS, BFGSLineSearch, GoodOldQuasiNewton, RFO, SciPyFminBFGS
_UNSUITED = {
    CellAwareBFGS: "relaxes a cell, and the cell of a surface is given",
    GPMin: "fits a dense matrix to all coordinates of all steps",
    SciPyFmin: "does not use forces",
    SciPyFminPowell: "does not use forces",
}
_ADVICE = "use LBFGS, FIRE2 or NewtonKrylov"


def settings_for(
    optimizer: Callable[..., Any], atoms: Atoms | FourierModes
) -> dict[str, Any]:
    """Return settings with which an optimizer of ASE relaxes a contact.

    `load_path` takes them for a class of ASE.

    Parameters
    ----------
    optimizer : type, or partial of a type
        Such as ``FIRE2`` or ``partial(LBFGS, memory=50)``.
    atoms : Atoms or FourierModes
        With a `RoughContact` calculator and a soft wall, and for a free indenter the
        load, for which the solver finds how many atoms will be in contact.

    Returns
    -------
    dict
        Keyword arguments, also those given with a partial; empty for what needs none.

    Raises
    ------
    ValueError
        If the optimizer can't relax these coordinates, with what to use, if the
        calculator is not a `RoughContact`, or the wall is hard.

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
    **options
        Its options, beside those of `settings_for`.

    Returns
    -------
    callable
        Called as ``f(atoms, logfile=None)``, for `load_path` and `compare_optimizers`.

    Raises
    ------
    ValueError
        When it is called: as `settings_for` does.

    Examples
    --------
    >>> from ase.optimize import FIRE2
    >>> from ase_roughcontact import RoughContact, RoughSphere, load_path
    >>> from ase_roughcontact import on_modes, substrate
    >>> sphere = RoughSphere(radius=200.0)
    >>> atoms = substrate('Cu', (16, 16), sphere)
    >>> atoms.calc = RoughContact(sphere, contact_modulus=0.5)
    >>> (step,) = load_path(atoms, [0.5], optimizer=on_modes(FIRE2), accuracy=1e-2)
    >>> step.converged, step.repulsive_atoms
    (True, 61)
    """

    def made(atoms: Atoms, **others: Any) -> Any:
        modes = FourierModes(atoms)
        settings = settings_for(optimizer, modes)
        return optimizer(modes, **(settings | options | others))

    return made


def class_of(optimizer: Any) -> tuple[type | None, dict[str, Any]]:
    """Return the class of an optimizer and its options; None for another function."""
    options: dict[str, Any] = {}
    if isinstance(optimizer, partial) and not optimizer.args:
        optimizer, options = optimizer.func, optimizer.keywords
    return (optimizer, options) if isinstance(optimizer, type) else (None, {})


def check_suitable(kind: type, coordinates: int) -> None:
    """Raise `ValueError` if an optimizer can't relax a surface.

    Parameters
    ----------
    kind : type
    coordinates : int
        Number of coordinates.
    """
    for each, reason in _UNSUITED.items():
        if issubclass(kind, each):
            raise ValueError(f"{kind.__name__} {reason}: {_ADVICE}")
    if issubclass(kind, _MATRICES) and coordinates > _LARGEST_MATRIX:
        size = 8e-9 * coordinates**2
        raise ValueError(
            f"{kind.__name__} keeps a matrix of {coordinates} x {coordinates} numbers, "
            f"{size:.1f} GB, and solves it in each step: {_ADVICE}"
        )


def make_optimizer(optimizer: Callable[..., Any], atoms: Atoms) -> Any:
    """Return an optimizer of atoms, a class of ASE with `settings_for` them.

    Parameters
    ----------
    optimizer : callable
        Called as ``optimizer(atoms, logfile=None)``.
    atoms : Atoms

    Returns
    -------
    Optimizer

    Raises
    ------
    ValueError
        If it can't be made, or can't relax the atoms.
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
    if issubclass(kind, _PRECONDITIONED):
        raise ValueError(
            f"{kind.__name__} needs atoms: give it precon=HalfSpacePrecon(atoms), or "
            "the modes to LBFGS"
        )
    if issubclass(kind, _DYNAMICS):
        return {"maxstep": modes.maxstep}
    if issubclass(kind, _QUASI_NEWTON):
        return {"alpha": 1.0} | _memory(kind)
    return {}


def _on_atoms(kind: type, atoms: Atoms, given: dict[str, Any]) -> dict[str, Any]:
    contact = soft_contact_of(atoms)
    longest, stiffness = _largest_change(contact), _largest_curvature(contact)
    if issubclass(kind, _PRECONDITIONED):
        return {} if "precon" in given else {"precon": HalfSpacePrecon(atoms)}
    if issubclass(kind, _QUASI_NEWTON):
        return {"alpha": stiffness, "maxstep": longest} | _memory(kind)
    if not issubclass(kind, _DYNAMICS):
        return {}
    if not indenter_fixed(atoms):
        stiffness = max(stiffness, _indenter_curvature(contact, atoms))
    stable = 2.0 * _STABLE / stiffness**0.5
    # FIRE and FIRE2 limit the norm of a step, ABC-FIRE each coordinate
    norm = 1.0 if given.get("use_abc") else contact.heights.size**0.5
    if issubclass(kind, MDMin):
        return {"maxstep": norm * longest, "dt": stable}
    return {"maxstep": norm * longest, "dt": _FIRST * stable, "dtmax": stable}


def _memory(kind: type) -> dict[str, Any]:
    return {"memory": _MEMORY} if issubclass(kind, LBFGS) else {}


def _largest_change(contact: Contact) -> float:
    """Return the largest change of a coordinate in a step (length)."""
    wall, longest = contact.interaction, _PART_OF_SPACING * contact.halfspace.spacing
    if wall.attractive:
        longest = min(longest, _PART_OF_RANGE * wall.attraction_range)
    return longest


def _wall_curvature(contact: Contact) -> float:
    """Return the curvature of the energy of the wall on an atom (force per length)."""
    stiffness = _UNDER_PRESSURE * contact.interaction.stiffness_at_contact
    return contact.halfspace.cell_area * stiffness


def _largest_curvature(contact: Contact) -> float:
    """Return the largest curvature of the energy of an atom (force per length)."""
    halfspace = contact.halfspace
    elastic = halfspace.cell_area * float(halfspace.stiffness.max())
    return elastic + _wall_curvature(contact)


def _indenter_curvature(contact: Contact, atoms: Atoms) -> float:
    """Return the curvature of the energy of the indenter alone (force per length)."""
    _, run = solution(atoms, error=0.1)
    return run.fields.repulsive_atoms * _wall_curvature(contact)
