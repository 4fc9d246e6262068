r"""The contact in scaled Fourier modes, for any optimizer of ASE.

The Hessian of the energy is :math:`a_0^2 [K + \operatorname{diag} V'']`. Its elastic
part is diagonal in Fourier space, with values that reach from those of the longest to
those of the shortest wave: the larger the grid, the worse for an optimizer that does
not know. In the modes

.. math:: x(q) = \sqrt{\frac{w(q)\, a_0^2 [K(q) + k_\text{ref}]}{N M\, c}}\; \tilde u(q)

it is nearly the identity times :math:`c` = 1 eV/Å\ :sup:`2`, on any grid. :math:`w`
is 2 for the waves that stand for their conjugates, too.

References
----------
Y. Zhou, M. Moseler, M. H. Müser, Phys. Rev. B 99, 144103 (2019), for the idea of
giving every mode the mass that suits its stiffness.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from ase import Atoms
from ase.utils.abc import Optimizable

from ase_roughcontact.atoms.calculator import elastic_pressure, grid_of
from ase_roughcontact.atoms.grid import displacement, set_displacement
from ase_roughcontact.optimize.constraints import (
    Indenter,
    reference_stiffness,
    soft_contact_of,
)
from ase_roughcontact.solvers.relaxation import indenter_stiffness

# Curvature of the energy in the scaled modes (eV/Å^2).
_CURVATURE = 1.0

# Rows of the spectrum that are worked on at once, to stay in the processor's cache.
_BLOCK = 32


class FourierModes(Optimizable):
    """Atoms of a `RoughContact` in the scaled modes of their half space.

    An ASE `Optimizable`: hand it to FIRE, FIRE2, LBFGS, BFGSLineSearch or the SciPy
    optimizers in place of the atoms. Energy and gradient together cost one inverse and
    one forward transform. The atoms are written when the optimizer has converged or
    writes a trajectory, and by `write`.

    The curvature of the energy is about 1 eV/Å^2 in these coordinates: tell LBFGS so
    (``alpha=1``; its default is meant for atoms). FIRE and FIRE2 limit the norm of a
    step: ``maxstep=modes.maxstep`` limits the mean displacement of an atom instead.
    Load and constraints are those at the time when it is made.

    The steps to a force do not grow with the resolution of a problem: for a rough
    sphere, a repulsive wall, and 64 to 512 atoms along the window's side, LBFGS took
    100 and 102, FIRE2 193 and 152. When the contact grows at fixed spacing, windows of
    64 to 256 atoms, LBFGS's steps grow with the 0.65th power of the side, on plain
    atoms with the first. With a window of 512 x 512 atoms an evaluation takes 1.2 times
    its pair of transforms and the wall; FIRE2 adds 1.5 times that again, and LBFGS
    (20 vectors kept) ten times.

    Parameters
    ----------
    atoms : Atoms
        With a `RoughContact` calculator and a soft wall. Constraints of the indenter
        act; others are refused.
    reference_stiffness : float, optional
        ``k_ref`` of the scaling (eV/Å^4, pressure per length); by default three times
        the wall's stiffness where it begins to repel.

    Raises
    ------
    ValueError
        If the calculator is not a `RoughContact`, the wall is hard, or there is a
        constraint on another atom than the indenter.

    Examples
    --------
    >>> from ase.optimize import LBFGS
    >>> from ase_roughcontact import FourierModes, RoughContact, RoughSphere, substrate
    >>> sphere = RoughSphere(radius=200.0)
    >>> atoms = substrate('Cu', (16, 16), sphere, height=1.0)
    >>> atoms.calc = RoughContact(sphere, contact_modulus=0.5)
    >>> LBFGS(FourierModes(atoms), alpha=1.0, logfile=None).run(fmax=1e-4)
    True
    """

    def __init__(self, atoms: Atoms, reference_stiffness: float | None = None) -> None:
        self.atoms = atoms
        self.contact = soft_contact_of(atoms)
        self.indenter = Indenter(atoms)
        self._grid = grid_of(atoms)
        self.evaluations = 0
        self._scale(reference_stiffness)
        self._read()

    @property
    def maxstep(self) -> float:
        """Norm of a step that moves the atoms of the window by 0.1 spacings (rms)."""
        halfspace = self.contact.halfspace
        n, m = halfspace.shape
        stiffness = self._reference + np.median(halfspace.stiffness)
        curvature = halfspace.cell_area * stiffness / _CURVATURE
        return float(0.1 * halfspace.spacing * np.sqrt(n * m * curvature))

    def ndofs(self) -> int:
        """Return the number of real and imaginary parts, and one for the indenter."""
        return self._modes + 1

    def get_x(self) -> np.ndarray:
        """Return a copy of the coordinates, shape (ndofs,)."""
        return self._x.copy()

    def set_x(self, x: np.ndarray) -> None:
        """Set the coordinates and forget what was calculated at the old ones."""
        self._x = np.array(x, dtype=float)
        self._gradient: np.ndarray | None = None
        self._norm: float | None = None

    def get_value(self) -> float:
        """Return the energy, that of the load and of the constraints included (eV)."""
        self._evaluate()
        return self._value

    def get_gradient(self) -> np.ndarray:
        """Return the gradient, shape (ndofs,), not to be written to."""
        return self._evaluate()

    def gradient_norm(self, gradient: np.ndarray) -> float:
        """Largest force on any atom; of a step, the largest displacement.

        The optimizers of ASE ask for both by this name: of the gradient, which they
        compare with `fmax`, and of a step, which they compare with `maxstep`.

        Parameters
        ----------
        gradient : ndarray, shape (ndofs,)
            As `get_gradient` returned it, or a step.

        Returns
        -------
        float
            eV/Å, or Å.
        """
        if gradient is not self._gradient:
            moved = self._real(gradient, self._from_mode)
            return float(max(np.abs(moved).max(), abs(gradient[-1]) * self._z_scale))
        if self._norm is None:
            self._norm = self._largest_force(gradient)
        return self._norm

    def converged(self, gradient: np.ndarray, fmax: float) -> bool:
        """Whether the largest force is below `fmax`; if it is, write the atoms."""
        if gradient is self._gradient:
            done = self.gradient_norm(gradient) < fmax
        else:
            done = self._largest_force(gradient) < fmax
        if done:
            self.write()
        return done

    def write(self) -> None:
        """Move the atoms to the present coordinates."""
        rows, columns = self.contact.halfspace.dof_shape
        values = self._real(self._x, self._from_mode)[:rows, :columns]
        set_displacement(self.atoms, values)
        self.atoms.positions[-1, 2] = self._x[-1] * self._z_scale

    def iterimages(self) -> Iterator[Atoms]:
        """Yield the atoms where they are now, with energy and forces."""
        self.write()
        self.atoms.get_potential_energy()
        yield self.atoms

    def _scale(self, reference: float | None) -> None:
        contact, halfspace = self.contact, self.contact.halfspace
        reference = reference_stiffness(contact, reference)
        self._reference = reference
        stiffness = halfspace.stiffness
        weight = np.full(stiffness.shape, 2.0)
        weight[:, 0] = 1.0
        if halfspace.grid[1] % 2 == 0:
            weight[:, -1] = 1.0
        cells = halfspace.grid[0] * halfspace.grid[1]
        area = halfspace.cell_area
        share = stiffness / (stiffness + reference)
        to_mode = np.sqrt(
            weight * area * (stiffness + reference) / (cells * _CURVATURE)
        )
        self._elastic = _twice(_CURVATURE * share)
        self._from_mode = _twice(1.0 / (to_mode * cells))
        self._pressure_to_gradient = _twice(weight * area / (cells * to_mode))
        self._gradient_to_force = _twice(to_mode / weight)
        self._modes = self._elastic.size
        self._shape = self._elastic.shape
        self._z_scale = np.sqrt(_CURVATURE / indenter_stiffness(contact))

    def _read(self) -> None:
        halfspace = self.contact.halfspace
        transform = halfspace.grid_transform
        values = displacement(self.atoms, self._grid)
        if halfspace.dof_shape != halfspace.grid:
            values = halfspace.grid_displacement(elastic_pressure(self.atoms))
        modes = transform.forward(values).view(transform.dtype) / self._from_mode
        cells = values.size
        height = self.atoms.positions[-1, 2] / self._z_scale
        self.set_x(np.append(modes.ravel() / cells, height))

    def _largest_force(self, gradient: np.ndarray) -> float:
        forces = self._real(gradient, self._gradient_to_force)
        return float(max(np.abs(forces).max(), abs(gradient[-1]) / self._z_scale))

    def _real(self, coordinates: np.ndarray, factor: np.ndarray) -> np.ndarray:
        """Return coordinates times a factor in real space, shape of the grid."""
        transform = self.contact.halfspace.grid_transform
        modes = coordinates[: self._modes].reshape(self._shape)
        np.multiply(modes, factor, out=transform.spectrum.view(transform.dtype))
        return transform.inverse()

    def _evaluate(self) -> np.ndarray:
        if self._gradient is not None:
            return self._gradient
        self.evaluations += 1
        contact, transform = self.contact, self.contact.halfspace.window_transform
        spectrum = transform.spectrum.view(transform.dtype)
        modes = self._x[: self._modes].reshape(self._shape)
        np.multiply(modes, self._from_mode, out=spectrum)
        height = self._x[-1] * self._z_scale
        wall_energy, pressure = contact.wall(contact.gap(transform.inverse(), height))
        wall_force = contact.halfspace.cell_area * pressure.sum()
        if contact.halfspace.periodic:
            pressure -= pressure.mean()
        transform.forward(pressure)
        transform.pairs += 1

        gradient = np.empty(self.ndofs())
        slopes = gradient[: self._modes].reshape(self._shape)
        twice_elastic = 0.0
        for start in range(0, self._shape[0], _BLOCK):
            rows = slice(start, start + _BLOCK)
            elastic = self._elastic[rows] * modes[rows]
            twice_elastic += np.einsum("ij,ij->", elastic, modes[rows])
            np.multiply(
                spectrum[rows], self._pressure_to_gradient[rows], out=slopes[rows]
            )
            slopes[rows] += elastic
        external_energy, external_force = self.indenter.external(height)
        force = 0.0 if self.indenter.fixed else wall_force + external_force
        gradient[-1] = -force * self._z_scale
        gradient.flags.writeable = False
        self._gradient = gradient
        self._value = float(
            0.5 * twice_elastic
            + contact.halfspace.cell_area * wall_energy.sum()
            + external_energy
        )
        return gradient


def _twice(values: np.ndarray) -> np.ndarray:
    """Each value twice, for the real and the imaginary part."""
    return np.repeat(values, 2, axis=1)
