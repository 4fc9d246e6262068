r"""Contact problem in scaled Fourier modes, for optimizers of ASE.

The Hessian of the energy is :math:`a_0^2 [K + \operatorname{diag} V'']`. The elastic
part is diagonal in Fourier space, with eigenvalues that increase from the longest to
the shortest wave: the larger the grid, the worse the condition number. In the modes

.. math:: x(q) = \sqrt{\frac{w(q)\, a_0^2 [K(q) + k_\text{ref}]}{N M\, c}}\; \tilde u(q)

the Hessian is nearly the identity times :math:`c` = 1 eV/Å\ :sup:`2`, on any grid. The
weight :math:`w` is 2 for modes that also stand for their complex conjugates, otherwise
1, and :math:`k_\text{ref}` is three times the stiffness of the wall where it begins to
repel.

References
----------
Y. Zhou, M. Moseler, M. H. Müser, Phys. Rev. B 99, 144103 (2019), for the idea of
giving every mode a mass in proportion to its stiffness.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from ase import Atoms
from ase.utils.abc import Optimizable

from ase_roughcontact._util.kernels import array_equal, inner, rowwise
from ase_roughcontact.atoms.calculator import model_of, uses_model
from ase_roughcontact.atoms.constraints import (
    reference_stiffness,
    soft_contact_of,
    support_of,
)
from ase_roughcontact.atoms.grid import displacement, set_displacement
from ase_roughcontact.solvers.relaxation import indenter_stiffness, is_relaxed

# Advice about optimizers that need more than coordinates, energy and gradient.
_NEEDS_ATOMS = "this optimizer needs atoms: use LBFGS, FIRE2 or SciPyFminCG on modes"


class FourierModes(Optimizable):
    """Atoms of a `RoughContact` in the scaled Fourier modes of their half space.

    The modes are an ASE `Optimizable`: give them to FIRE, FIRE2, LBFGS or the SciPy
    optimizers in place of the atoms. BFGSLineSearch works, too, with its dense Hessian
    for windows of a few hundred atoms at most. Energy and gradient together cost one
    FFT pair.

    The atoms always have the positions of the present iterate. If atoms are moved, or
    their calculator or constraints are changed, the modes follow. The history of an
    optimizer (vectors, velocities) then belongs to another problem: make a new
    optimizer.

    The curvature of the energy is about 1 eV/Å^2 in these coordinates, which LBFGS
    needs as ``alpha=1`` (its default is meant for atoms). FIRE and FIRE2 limit the norm
    of a step; ``maxstep=modes.maxstep`` limits the mean displacement of an atom.

    Parameters
    ----------
    atoms : Atoms
        Atoms with a `RoughContact` calculator and a soft wall. Constraints of the
        indenter are supported, other constraints are not.

    Raises
    ------
    ValueError
        If the calculator is not a `RoughContact`, the wall is hard, or there is a
        constraint that is not supported.

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

    _gradient: np.ndarray | None
    _norm: float | None

    def __init__(self, atoms: Atoms) -> None:
        self.atoms = atoms
        self.evaluations, self._pressure = 0, 0.0
        self._connect()
        self._read()

    @property
    def maxstep(self) -> float:
        """Norm of a step that moves atoms by 0.1 spacings (root mean square)."""
        halfspace = self.contact.halfspace
        n, m = halfspace.shape
        stiffness = self._reference + np.median(halfspace.stiffness)
        curvature = halfspace.cell_area * stiffness
        return float(0.1 * halfspace.spacing * np.sqrt(n * m * curvature))

    def __getattr__(self, name: str) -> Any:
        """Raise `AttributeError` for optimizers that need atoms."""
        raise AttributeError(f"FourierModes has no {name!r}: {_NEEDS_ATOMS}")

    def __len__(self) -> int:
        """Raise `TypeError` for optimizers that need atoms."""
        raise TypeError(f"FourierModes has no length: {_NEEDS_ATOMS}")

    def __bool__(self) -> bool:
        """Return true, as there are always modes."""
        return True

    def ndofs(self) -> int:
        """Return the number of real and imaginary parts, and one for the indenter."""
        return self._modes + 1

    def get_x(self) -> np.ndarray:
        """Return a copy of the coordinates, shape (ndofs,).

        The last one belongs to the indenter, and is 0 if the indenter is fixed.
        """
        self._follow()
        return self._x.copy()

    def set_x(self, x: np.ndarray) -> None:
        """Move the atoms to coordinates; the height of a fixed indenter is kept."""
        if array_equal(x, self._x) and array_equal(
            self.atoms.positions, self._positions
        ):
            return  # as SciPy asks for energy and gradient one after the other
        rows, columns = self.contact.halfspace.dof_shape
        values = self._real(x, self._from_mode)[:rows, :columns]
        set_displacement(self.atoms, values)
        if not self.support.fixed:
            self.atoms.positions[-1, 2] = x[-1] * self._z_scale
        self.atoms.calc.reset()
        self._set(x)

    def get_value(self) -> float:
        """Return the energy, including the energies of the load and of springs (eV)."""
        self._follow()
        self._evaluate()
        return self._value

    def get_gradient(self) -> np.ndarray:
        """Return the gradient as a read-only array, shape (ndofs,)."""
        self._follow()
        return self._evaluate()

    def gradient_norm(self, gradient: np.ndarray) -> float:
        """Return the largest force on an atom, or the largest displacement in a step.

        ASE's optimizers use this method for the gradient, which they compare with
        `fmax`, and for steps, which they compare with `maxstep`.

        Parameters
        ----------
        gradient : ndarray, shape (ndofs,)
            Array from `get_gradient`, or a step.

        Returns
        -------
        float
            Force (eV/Å), or displacement (Å).
        """
        if gradient is not self._gradient:
            moved = self._real(gradient, self._from_mode)
            return float(max(np.abs(moved).max(), abs(gradient[-1]) * self._z_scale))
        if self._norm is None:
            self._norm = self._largest_force(gradient)
        return self._norm

    def converged(self, gradient: np.ndarray, fmax: float) -> bool:
        """Return whether the atoms are relaxed; if so, store results.

        The largest force is then below `fmax`, and at most 1 % of the largest force of
        the wall on an atom.
        """
        if gradient is self._gradient:
            force = self.gradient_norm(gradient)
        else:
            force = self._largest_force(gradient)
        done = is_relaxed(self.contact, self._pressure, force, fmax)
        if done:
            self.atoms.get_potential_energy()
        return done

    def iterimages(self) -> Iterator[Atoms]:
        """Yield the atoms, with energy and forces."""
        self.atoms.get_potential_energy()
        yield self.atoms

    def _connect(self) -> None:
        self.contact = soft_contact_of(self.atoms)
        self.support = support_of(self.atoms)
        self._model = model_of(self.atoms)
        self._positions = np.empty_like(self.atoms.positions)
        self._scale()

    def _settings(self) -> list[Any]:
        """Return everything but model and positions on which the problem depends.

        The last entry is the energy and the force of load and springs.
        """
        atoms = self.atoms
        external = self.support.external(float(atoms.positions[-1, 2]))
        settings = (
            atoms.cell.tolist(),
            atoms.pbc.tolist(),
            atoms.calc.parameters["load"],
        )
        return [*settings, *atoms.constraints, external]

    def _follow(self) -> None:
        """Read the atoms if they, their calculator or constraints have changed."""
        if (
            uses_model(self.atoms, self._model)
            and array_equal(self.atoms.positions, self._positions)
            and self._settings() == self._known_settings
        ):
            return
        modes = self._modes
        self._connect()
        if self._modes != modes:
            raise ValueError(
                "the number of surface atoms has changed: make new FourierModes"
            )
        self._read()

    def _scale(self) -> None:
        contact, halfspace = self.contact, self.contact.halfspace
        reference = self._reference = reference_stiffness(contact)
        stiffness = halfspace.stiffness
        weight = np.full(stiffness.shape, 2.0)
        weight[:, 0] = 1.0
        if halfspace.grid[1] % 2 == 0:
            weight[:, -1] = 1.0
        cells = halfspace.grid[0] * halfspace.grid[1]
        area = halfspace.cell_area
        share = stiffness / (stiffness + reference)
        to_mode = np.sqrt(weight * area * (stiffness + reference) / cells)
        self._elastic = _twice(share)
        self._from_mode = _twice(1.0 / (to_mode * cells))
        self._pressure_to_gradient = _twice(weight * area / (cells * to_mode))
        self._gradient_to_force = _twice(to_mode / weight)
        self._modes = self._elastic.size
        self._shape = self._elastic.shape
        # geometric mean of the stiffnesses against relaxed and against fixed atoms.
        # Compared with relaxed atoms alone, FIRE takes up to 6 times fewer steps, and
        # LBFGS up to 30 % more
        held = area * reference * contact.heights.size
        self._z_scale = (held * indenter_stiffness(contact)) ** -0.25

    def _read(self) -> None:
        halfspace = self.contact.halfspace
        transform = halfspace.grid_transform
        values = displacement(self.atoms, self._model.grid)
        if halfspace.dof_shape != halfspace.grid:
            values = halfspace.grid_displacement(
                self._model.elastic_pressure(self.atoms)
            )
        modes = transform.forward(values).view(transform.dtype) / self._from_mode
        cells = values.size
        height = self.atoms.positions[-1, 2] / self._z_scale
        self._set(np.append(modes.ravel() / cells, height))

    def _set(self, x: np.ndarray) -> None:
        """Set the coordinates of the atoms, and discard the results of the old ones."""
        self._known_settings = self._settings()
        self._positions[:] = self.atoms.positions
        self._x = np.array(x, dtype=float)
        if self.support.fixed:
            self._x[-1] = 0.0
        self._gradient = self._norm = None

    def _largest_force(self, gradient: np.ndarray) -> float:
        forces = self._real(gradient, self._gradient_to_force)
        return float(max(np.abs(forces).max(), abs(gradient[-1]) / self._z_scale))

    def _real(self, coordinates: np.ndarray, factor: np.ndarray) -> np.ndarray:
        """Return scaled coordinates in real space, shape of the padded grid."""
        transform = self.contact.halfspace.grid_transform
        modes = coordinates[: self._modes].reshape(self._shape)
        np.multiply(modes, factor, out=transform.spectrum.view(transform.dtype))
        return transform.inverse()

    def _evaluate(self) -> np.ndarray:
        if self._gradient is not None:
            return self._gradient
        self.evaluations += 1
        contact, transform = self.contact, self.contact.halfspace.window_transform
        height = float(self.atoms.positions[-1, 2])
        gap = contact.gap(displacement(self.atoms, self._model.grid), height)
        wall_energy, pressure = contact.evaluate_wall(gap)
        self._pressure = float(abs(pressure).max())
        wall_force = contact.halfspace.cell_area * pressure.sum()
        if contact.halfspace.periodic:
            pressure -= pressure.mean()
        transform.forward(pressure)
        transform.pairs += 1

        gradient = np.empty(self.ndofs())
        twice_elastic = _set_gradient(
            gradient[: self._modes].reshape(self._shape),
            self._x[: self._modes].reshape(self._shape),
            self._elastic,
            transform.spectrum.view(transform.dtype),
            self._pressure_to_gradient,
        )
        external_energy, external_force = self._known_settings[-1]
        force = 0.0 if self.support.fixed else wall_force + external_force
        gradient[-1] = -force * self._z_scale
        gradient.flags.writeable = False
        self._gradient = gradient
        self._value = float(
            0.5 * twice_elastic
            + contact.halfspace.cell_area * wall_energy.sum()
            + external_energy
        )
        return gradient


@rowwise(np.add)
def _set_gradient(
    gradient: np.ndarray,
    modes: np.ndarray,
    elastic: np.ndarray,
    pressure: np.ndarray,
    factor: np.ndarray,
) -> float:
    """Set ``gradient = elastic x + factor pressure`` and return ``elastic x^2``."""
    force = elastic * modes
    np.multiply(pressure, factor, out=gradient)
    gradient += force
    return inner(force, modes)


def _twice(values: np.ndarray) -> np.ndarray:
    """Return every column twice, for real and imaginary parts."""
    return np.repeat(values, 2, axis=1)
