"""Tolerance of forces for a wanted error of force and area."""

from __future__ import annotations

import math

from ase import Atoms

from ase_roughcontact.atoms.calculator import model_of, state_of
from ase_roughcontact.atoms.constraints import support_beside_others
from ase_roughcontact.solvers.relaxation import Run
from ase_roughcontact.stepping.convergence import StepRelaxer
from ase_roughcontact.stepping.options import StepOptions
from ase_roughcontact.stepping.surface_history import SurfaceHistory


def fmax_for(atoms: Atoms, error: float = 0.01) -> float:
    """Return the tolerance of forces that gives a wanted error of force and area.

    ASE's usual 0.05 eV/Å may be as large as the forces on the atoms in contact, so that
    an optimizer would stop before the surface has deformed. The returned tolerance is
    the tolerance of `load_path` for ``accuracy=error``. It is relative to the mean
    force on the atoms in contact at this height or load, which the solver for the wall
    finds with few FFT pairs. The atoms are not moved.

    Parameters
    ----------
    atoms : Atoms
        Atoms with a `RoughContact` calculator, and the indenter at its height, or free
        under the load. Constraints of surface atoms are left out.
    error : float
        Largest error of the normal force, relative to the sum of the magnitudes of the
        forces in contact, and largest relative error of the contact area, beyond one
        atom.

    Returns
    -------
    float
        Tolerance, the argument `fmax` of an optimizer (eV/Å).

    Raises
    ------
    ValueError
        If the calculator is not a `RoughContact`, the error is not between 1e-12 and 1,
        or no atom is in contact.
    RuntimeError
        If the solver does not converge.

    Examples
    --------
    >>> from ase.optimize import FIRE
    >>> from ase_roughcontact import FourierModes, RoughContact, RoughSphere
    >>> from ase_roughcontact import fmax_for, substrate
    >>> sphere = RoughSphere(radius=200.0)
    >>> atoms = substrate('Cu', (16, 16), sphere, height=1.0)
    >>> atoms.calc = RoughContact(sphere, contact_modulus=0.5)
    >>> fmax = fmax_for(atoms, error=0.01)
    >>> print(f'{fmax:.1e}')
    2.4e-04
    >>> modes = FourierModes(atoms)
    >>> FIRE(modes, maxstep=modes.maxstep, logfile=None).run(fmax=fmax)
    True
    """
    relax, run = solution(atoms, error)
    if not run.converged:
        raise RuntimeError(f"the relaxed state is not found: {run.message}")
    fmax = relax.required(run.fields)
    if math.isinf(fmax):
        raise ValueError(
            f"no atom is in contact at the height {run.state.height:.4g} Å: lower the "
            "indenter, or set it free under a load"
        )
    return fmax


def solution(atoms: Atoms, error: float) -> tuple[StepRelaxer, Run]:
    """Relax a state of atoms by the solver for the wall, without moving the atoms.

    Parameters
    ----------
    atoms : Atoms
        Atoms with a `RoughContact` calculator. Constraints of surface atoms are left
        out.
    error : float
        Relative error of force and area.

    Returns
    -------
    relax : StepRelaxer
        Relaxer with this error.
    run : Run
        Run of the solver, with the relaxed state.
    """
    problem = model_of(atoms).problem
    surface = SurfaceHistory(problem)
    state, contact = surface.contact(state_of(atoms), surface.step(0.0))
    relax = StepRelaxer(problem, StepOptions(accuracy=error))
    return relax, relax(contact, state, support_beside_others(atoms))
