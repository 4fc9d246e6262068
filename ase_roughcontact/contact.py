r"""Contact of a rigid surface with an elastic half space: arrays in, arrays out.

The energy of a displacement :math:`u` under an indenter at height :math:`Z` is

.. math:: U(u, Z) = a_0^2 \left[\tfrac12 \sum u\, K u + \sum V(g)\right], \qquad
          g = Z + h - (u - \langle u \rangle),

summed over the displaced atoms (elastic energy) and those of the window (wall). The
mean :math:`\langle u \rangle` is that of a periodic cell, and zero for a free half
space. With the pressure :math:`p = -V'(g)` of the wall, the force on an atom and the
normal force on the indenter are

.. math:: f = -\frac{\partial U}{\partial u}
            = -a_0^2 \left[K u + p - \langle p \rangle\right], \qquad
          N = -\frac{\partial U}{\partial Z} = a_0^2 \sum p.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ase_roughcontact._util.kernels import rowwise
from ase_roughcontact.elasticity.halfspace import HalfSpace
from ase_roughcontact.interactions import Interaction

# An atom is in contact with a hard wall if its gap is below this part of the spacing,
# and carries load if its pressure is above this part of the largest one.
_HARD_GAP = 1e-5
_HARD_PRESSURE = 1e-9


@dataclass(frozen=True, eq=False)
class ContactState:
    """Energy, forces and local fields of one configuration.

    Attributes
    ----------
    energy : float
        Elastic and wall energy.
    energies : ndarray, shape of the displaced atoms
        Energy of each atom.
    forces : ndarray, shape of the displaced atoms
        Force on each atom, positive upward.
    gap : ndarray, shape (n, m)
        Distance to the indenter (length).
    pressure : ndarray, shape (n, m)
        Pressure of the wall, positive in repulsion.
    normal_force : float
        Force of the wall on the indenter, positive upward.
    cell_area : float
        Area of an atom.
    """

    energy: float
    energies: np.ndarray
    forces: np.ndarray
    gap: np.ndarray
    pressure: np.ndarray
    normal_force: float
    cell_area: float

    @property
    def contact(self) -> np.ndarray:
        """Mask of the atoms under a repulsive pressure, shape (n, m)."""
        return self.pressure > 0.0

    @property
    def repulsive_atoms(self) -> int:
        """Number of atoms in contact."""
        return int(np.count_nonzero(self.pressure > 0.0))

    @property
    def attractive_atoms(self) -> int:
        """Number of atoms under an attractive pressure."""
        return int(np.count_nonzero(self.pressure < 0.0))

    @property
    def contact_area(self) -> float:
        """Area of the atoms in contact."""
        return self.repulsive_atoms * self.cell_area


class Contact:
    """Half space, indenter and the interaction between them.

    Parameters
    ----------
    halfspace : HalfSpace
        The elastic solid.
    heights : ndarray, shape (n, m)
        Lower surface of the indenter above its reference height, at every atom of the
        window (length).
    interaction : Interaction
        The wall.

    Raises
    ------
    ValueError
        If `heights` does not have the shape of the window, or is not finite.
    """

    def __init__(
        self, halfspace: HalfSpace, heights: np.ndarray, interaction: Interaction
    ) -> None:
        heights = np.asarray(heights, dtype=float)
        if heights.shape != halfspace.shape:
            raise ValueError(
                f"heights must have the shape {halfspace.shape} of the window, "
                f"got {heights.shape}"
            )
        if not np.isfinite(heights).all():
            raise ValueError(
                "heights must be finite, got "
                f"{np.count_nonzero(~np.isfinite(heights))} values that are not"
            )
        self.halfspace = halfspace
        self.heights = heights
        self.interaction = interaction

    @property
    def first_contact(self) -> float:
        """Height of the indenter at which the wall begins to repel a flat surface."""
        return float(self.interaction.contact_distance - self.heights.min())

    def gap(self, displacement: np.ndarray, height: float) -> np.ndarray:
        """Return the gap ``Z + h - u`` at every atom of the window.

        Parameters
        ----------
        displacement : ndarray, shape of the displaced atoms or (n, m)
            Displacement of all atoms or of the window (length).
        height : float
            Height of the indenter (length).

        Returns
        -------
        ndarray, shape (n, m)
        """
        n, m = self.halfspace.shape
        window = displacement[:n, :m]
        if self.halfspace.periodic:
            window = window - window.mean()
        gap = self.heights - window
        gap += height
        return gap

    def elastic_pressure(self, displacement: np.ndarray) -> np.ndarray:
        """Return the pressure that causes a displacement; see `HalfSpace`.

        Parameters
        ----------
        displacement : ndarray, shape of the displaced atoms
            Displacement (length).

        Returns
        -------
        ndarray, shape of the displaced atoms
            Zero, without a transform, if the surface is flat.
        """
        if not displacement.any():
            return np.zeros(displacement.shape)
        return self.halfspace.elastic_pressure(displacement)

    def wall(self, gap: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return energy per area and pressure of the wall.

        Parameters
        ----------
        gap : ndarray, shape (n, m)
            Gap as returned by `gap` (length).

        Returns
        -------
        energy, pressure : ndarray, shape (n, m)
        """
        energy, pressure = np.zeros(gap.shape), np.zeros(gap.shape)
        _evaluate_in_range(energy, pressure, gap, self.interaction)
        return energy, pressure

    def evaluate(
        self,
        displacement: np.ndarray,
        height: float,
        known_pressure: np.ndarray | None = None,
        reaction: np.ndarray | None = None,
    ) -> ContactState:
        """Return energy, forces and fields of a configuration.

        Parameters
        ----------
        displacement : ndarray, shape of the displaced atoms
            Displacement of every atom (length).
        height : float
            Height of the indenter (length).
        known_pressure : ndarray, shape (n, m), optional
            Elastic pressure on the window, if a solver knows it: it replaces a
            transform of the displacement.
        reaction : ndarray, shape (n, m), optional
            Pressure of a hard wall, if a solver knows it. By default it is the elastic
            pressure on the atoms that touch it; if all atoms of a periodic surface do,
            the smallest one.

        Returns
        -------
        ContactState

        Raises
        ------
        ValueError
            If the displacement has a wrong shape, or atoms overlap with a hard wall,
            whose reaction is not a function of the positions then.
        """
        if displacement.shape != self.halfspace.dof_shape:
            raise ValueError(
                f"displacement must have the shape {self.halfspace.dof_shape} of the "
                f"atoms, got {displacement.shape}"
            )
        if self.halfspace.periodic:
            displacement = displacement - displacement.mean()
        if known_pressure is None:
            elastic = self.elastic_pressure(displacement)
        else:
            elastic = self._padded(known_pressure)
        gap = self.gap(displacement, height)
        if not self.interaction.hard:
            wall_energy, pressure = self.wall(gap)
        else:
            wall_energy = np.zeros(gap.shape)
            pressure = self._reaction(gap, elastic) if reaction is None else reaction

        area, (n, m) = self.halfspace.cell_area, gap.shape
        energies = displacement * elastic
        energies *= -0.5 * area
        energies[:n, :m] += area * wall_energy
        forces = elastic
        if self.halfspace.periodic:
            forces += pressure.mean()
        forces *= area
        forces[:n, :m] -= area * pressure
        return ContactState(
            energy=float(energies.sum()),
            energies=energies,
            forces=forces,
            gap=gap,
            pressure=pressure,
            normal_force=float(area * pressure.sum()),
            cell_area=area,
        )

    def _padded(self, pressure: np.ndarray) -> np.ndarray:
        """Return a pressure on the window as one on all atoms; without a mean."""
        if self.halfspace.periodic:
            return pressure - pressure.mean()
        padded = np.zeros(self.halfspace.dof_shape)
        n, m = pressure.shape
        padded[:n, :m] = pressure
        return padded

    def _reaction(self, gap: np.ndarray, elastic: np.ndarray) -> np.ndarray:
        """Return the elastic pressure on the atoms that touch a hard wall."""
        tolerance = _HARD_GAP * self.halfspace.spacing
        if gap.min() < -tolerance:
            raise ValueError(
                f"{np.count_nonzero(gap < -tolerance)} atoms overlap with the hard "
                f"wall by up to {-gap.min():.3g}, where its force is not defined: "
                "relax them with ActiveSet, or use LennardJones93.repulsive with "
                "another optimizer"
            )
        window = elastic[: gap.shape[0], : gap.shape[1]]
        if self.halfspace.periodic:
            # the displacement determines the pressure up to its mean
            window = window - window.min()
        least = _HARD_PRESSURE * max(window.max(), 0.0)
        return np.where((gap <= tolerance) & (window > least), window, 0.0)


@rowwise()
def _evaluate_in_range(
    energy: np.ndarray, pressure: np.ndarray, gap: np.ndarray, wall: Interaction
) -> None:
    """Set ``V(g)`` and ``-V'(g)`` where the wall is in range."""
    near = gap < wall.cutoff
    if near.any():
        energy[near], pressure[near], _ = wall.evaluate(gap[near])
