"""The solvers of the contact problem as ASE optimizers."""

from __future__ import annotations

from dataclasses import replace

from ase_roughcontact.interactions import Interaction
from ase_roughcontact.optimize.base import ContactOptimizer
from ase_roughcontact.solvers.hard.active_set import active_set
from ase_roughcontact.solvers.optimality import (
    OptimalityResiduals,
    optimality_residuals,
)
from ase_roughcontact.solvers.soft.newton import newton_krylov


class NewtonKrylov(ContactOptimizer):
    """Newton-Krylov solver for soft walls, and for all walls with attraction.

    It is an inexact Newton method for the pressure on the window. A preconditioned
    Krylov method in Fourier space solves the linear systems. The energy decreases in
    every step, except with walls that define their inverse, such as the default one,
    where it may rise in between. A flat surface is first relaxed on coarser grids. The
    indenter may be fixed, under a load, or on a `Hookean` spring.

    An augmented Lagrangian satisfies the constraint of a hard wall with attraction.
    Overlaps, and gaps of atoms under a reaction, are then at most the tolerance of the
    force divided by ``E* a0/1.122``, and at most 1e-6 spacings.

    Parameters
    ----------
    atoms : Atoms
        Atoms with a `RoughContact` calculator and a soft or an attractive wall.
    **kwargs
        Further arguments, see `ContactOptimizer`, which also has the attributes.

    Raises
    ------
    ValueError
        If the calculator is not a `RoughContact`, the wall is hard without attraction,
        or there is a constraint that the solver does not support.

    Examples
    --------
    >>> from ase_roughcontact import NewtonKrylov, RoughContact, RoughSphere, substrate
    >>> sphere = RoughSphere(radius=200.0)
    >>> atoms = substrate('Cu', (16, 16), sphere, fixed=False)
    >>> atoms.calc = RoughContact(sphere, contact_modulus=0.5, load=5.0)
    >>> NewtonKrylov(atoms).run(fmax=1e-9)
    True
    >>> round(atoms.calc.state(atoms).normal_force, 6)
    5.0
    """

    solver = staticmethod(newton_krylov)


class ActiveSet(ContactOptimizer):
    """Solver for the hard wall without attraction: ``g >= 0, p >= 0, g p = 0``.

    It is an active-set iteration with preconditioned conjugate gradients for the
    pressure in the contact. The tolerance `fmax` is a bound to the force that closes
    the gap of an atom: ``E* a0/1.122`` times the largest gap in contact or overlap
    outside of it, which is also at most 1e-6 spacings. The indenter may be fixed, under
    a load, or on a `Hookean` spring. After a run, `optimality_residuals` returns the
    errors of the conditions.

    Parameters
    ----------
    atoms : Atoms
        Atoms with a `RoughContact` calculator and a `HardWall`.
    **kwargs
        Further arguments, see `ContactOptimizer`, which also has the attributes.

    Raises
    ------
    ValueError
        If the calculator is not a `RoughContact`, the wall is not hard, or there is a
        constraint that the solver does not support.

    Examples
    --------
    >>> from ase_roughcontact import HardWall, ActiveSet, RoughContact, RoughSphere
    >>> from ase_roughcontact import substrate
    >>> sphere = RoughSphere(radius=200.0)
    >>> atoms = substrate('Cu', (16, 16), sphere, fixed=False)
    >>> atoms.calc = RoughContact(sphere, 0.5, HardWall(), load=5.0)
    >>> optimizer = ActiveSet(atoms)
    >>> optimizer.run(fmax=1e-9)
    True
    >>> optimizer.optimality_residuals.gap_in_contact < 1e-6
    True
    >>> round(atoms.calc.state(atoms).normal_force, 6)
    5.0
    """

    solver = staticmethod(active_set)
    hard_walls = True

    @property
    def optimality_residuals(self) -> OptimalityResiduals:
        """Residuals of the optimality (KKT) conditions in the last state.

        One convolution with the pressure gives them.

        Raises
        ------
        RuntimeError
            If there was no step yet.
        """
        if self.state is None:
            raise RuntimeError(
                "there are no residuals before the first step: run first"
            )
        height, load = self.state.height, None
        if not self.support.fixed:
            support = replace(self.support, load=self.atoms.calc.parameters["load"])
            load = -support.external(height)[1]
        return optimality_residuals(self.contact, self.state.pressure, height, load)


def default_optimizer(wall: Interaction) -> type[ContactOptimizer]:
    """Return the recommended optimizer for a wall.

    Parameters
    ----------
    wall : Interaction
        The wall.

    Returns
    -------
    type
        `ActiveSet` for a hard wall without attraction, otherwise `NewtonKrylov`.
    """
    return ActiveSet if ActiveSet.supports(wall) else NewtonKrylov
