"""The half space as a preconditioner for ASE's `PreconLBFGS` and `PreconFIRE`."""

from __future__ import annotations

import math

import numpy as np
from ase import Atoms

from ase_roughcontact._util.precon import ConstantPrecon
from ase_roughcontact.atoms.constraints import reference_stiffness, soft_contact_of
from ase_roughcontact.solvers.relaxation import indenter_stiffness


class HalfSpacePrecon(ConstantPrecon):
    r"""Preconditioner: elastic stiffness of the half space plus a uniform stiffness.

    .. math:: P = a_0^2 [K + k_\text{ref}]

    along z, where :math:`k_\text{ref}` is three times the stiffness of the wall where
    it begins to repel. P is diagonal in Fourier space: `solve` and `Pdot` cost one FFT
    pair. Lateral coordinates are multiplied by a constant. Use this class in scripts
    that need atoms; otherwise `FourierModes`, which needs no line search, is faster.

    Parameters
    ----------
    atoms : Atoms
        Atoms with a `RoughContact` calculator and a soft wall.

    Raises
    ------
    ValueError
        If the calculator is not a `RoughContact` or the wall is hard.

    Examples
    --------
    >>> from ase.optimize.precon import PreconLBFGS
    >>> from ase_roughcontact import HalfSpacePrecon, RoughContact, RoughSphere
    >>> from ase_roughcontact import substrate
    >>> sphere = RoughSphere(radius=200.0)
    >>> atoms = substrate('Cu', (16, 16), sphere, height=1.0)
    >>> atoms.calc = RoughContact(sphere, contact_modulus=0.5)
    >>> precon = HalfSpacePrecon(atoms)
    >>> bool(PreconLBFGS(atoms, precon=precon, logfile=None).run(fmax=1e-4))
    True
    """

    def __init__(self, atoms: Atoms) -> None:
        contact = soft_contact_of(atoms)
        halfspace = contact.halfspace
        stiffness = halfspace.cell_area * (
            halfspace.stiffness + reference_stiffness(contact)
        )
        self._shape = halfspace.dof_shape
        super().__init__(math.prod(self._shape) + 1)
        self._transform = halfspace.dof_transform
        self._multiply = self._transform.multiplier(stiffness)
        self._divide = self._transform.multiplier(1.0 / stiffness)
        lateral = float(np.median(stiffness))
        self._scale = np.array([lateral, lateral, indenter_stiffness(contact)])

    def _applied(self, vectors: np.ndarray, inverse: bool) -> np.ndarray:
        result = vectors / self._scale if inverse else vectors * self._scale
        heights = vectors[:-1, 2].reshape(self._shape)
        multiplier = self._divide if inverse else self._multiply
        result[:-1, 2] = self._transform.filter(heights, multiplier).ravel()
        return result
