"""Contact of a rigid surface with an elastic half space: arrays in, arrays out.

The energy of a displacement ``u`` under an indenter at height ``Z`` is

::

    U(u, Z) = a0^2 [ 1/2 sum u (K u)  +  sum V(g) ],     g = Z + h - (u - <u>)

over the cells of the grid (elastic part) and of the window (wall), ``<u>`` being the
mean of a periodic cell and zero for a free half space. From it follow the force on an
atom and the normal force on the indenter,

::

    f = -dU/du = -a0^2 [ K u + (p - <p>) ],     N = -dU/dZ = a0^2 sum p,

with the wall's pressure ``p = -V'(g)``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ase_roughcontact._util.kernels import by_rows, combined
from ase_roughcontact.elasticity.halfspace import HalfSpace
from ase_roughcontact.interactions import Interaction

# A hard wall's atom is in contact if its gap is below this part of the spacing, and
# carries load if its pressure is above this part of the largest one.
_HARD_GAP = 1e-5
_HARD_PRESSURE = 1e-9


@dataclass(frozen=True, eq=False)
class ContactState:
    """Energy, forces and local fields of one configuration.

    Attributes
    ----------
    energy : float
        Elastic and wall energy.
    energies : ndarray, shape of the layer
        The same, atom by atom.
    forces : ndarray, shape of the layer
        Force on each atom, positive upward.
    gap : ndarray, shape (n, m)
        Distance to the indenter (length).
    pressure : ndarray, shape (n, m)
        Of the wall, positive where it repels (pressure).
    normal_force : float
        Of the wall on the indenter, positive upward.
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
        """Mask of the atoms that feel a repulsive force, shape (n, m)."""
        return self.pressure > 0.0

    @property
    def repulsive_atoms(self) -> int:
        """Number of atoms in contact."""
        return int(np.count_nonzero(self.pressure > 0.0))

    @property
    def attractive_atoms(self) -> int:
        """Number of atoms that the wall pulls."""
        return int(np.count_nonzero(self.pressure < 0.0))

    @property
    def contact_area(self) -> float:
        """Number of atoms in contact times the area of one."""
        return self.repulsive_atoms * self.cell_area


class Contact:
    """Half space, indenter and the interaction between them.

    Parameters
    ----------
    halfspace : HalfSpace
        The elastic solid.
    heights : ndarray, shape (n, m)
        Height of the indenter's lower surface above its reference height at every
        atom of the window (length).
    interaction : Interaction
        The wall.

    Raises
    ------
    ValueError
        If `heights` does not have the shape of the half space's window, or is not
        finite.
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
        """Height of the indenter at which the flat substrate begins to repel it."""
        return float(self.interaction.contact_distance - self.heights.min())

    def gap(self, displacement: np.ndarray, height: float) -> np.ndarray:
        """Gap at every atom of the window.

        Parameters
        ----------
        displacement : ndarray, shape of the layer or (n, m)
            Of all atoms or of the window (length).
        height : float
            Of the indenter (length).

        Returns
        -------
        ndarray, shape (n, m)
        """
        n, m = self.halfspace.shape
        window = displacement[:n, :m]
        if self.halfspace.periodic:
            window = window - window.mean()
        gap = combined([(1.0, self.heights), (-1.0, window)])
        gap += height
        return gap

    def elastic_pressure(self, displacement: np.ndarray) -> np.ndarray:
        """Pressure that holds all atoms at a displacement; see `HalfSpace`.

        Parameters
        ----------
        displacement : ndarray, shape of the layer
            Length.

        Returns
        -------
        ndarray, shape of the layer
            Zero, without a transform, where the surface is flat.
        """
        if not displacement.any():
            return np.zeros(displacement.shape)
        return self.halfspace.elastic_pressure(displacement)

    def wall(self, gap: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Energy per area and pressure of the wall; only atoms in range cost.

        Parameters
        ----------
        gap : ndarray, shape (n, m)
            As `gap` returns it (length).

        Returns
        -------
        energy, pressure : ndarray, shape (n, m)
        """
        energy, pressure = np.zeros(gap.shape), np.zeros(gap.shape)

        def evaluate(rows: slice) -> None:
            near = gap[rows] < self.interaction.cutoff
            if near.any():
                values = self.interaction.evaluate(gap[rows][near])
                energy[rows][near], pressure[rows][near], _ = values

        by_rows(evaluate, gap.shape)
        return energy, pressure

    def evaluate(
        self,
        displacement: np.ndarray,
        height: float,
        held: np.ndarray | None = None,
    ) -> ContactState:
        """Energy, forces and fields of a configuration.

        Parameters
        ----------
        displacement : ndarray, shape of the half space's layer
            Of every atom (length).
        height : float
            Of the indenter (length).
        held : ndarray, shape (n, m), optional
            The pressure on the window that displaces it so, where a solver knows it:
            no transform is needed then. A hard wall exerts it. By default the wall
            exerts what holds the atoms that touch; under all atoms of a periodic
            surface, the least that does.

        Returns
        -------
        ContactState

        Raises
        ------
        ValueError
            If the displacement does not have the shape of the layer, or the wall is
            hard and atoms overlap with the indenter: the reaction of a hard wall is no
            function of the positions then.
        """
        if displacement.shape != self.halfspace.dof_shape:
            raise ValueError(
                f"displacement must have the shape {self.halfspace.dof_shape} of the "
                f"atoms, got {displacement.shape}"
            )
        if self.halfspace.periodic:
            displacement = displacement - displacement.mean()
        area = self.halfspace.cell_area
        if held is None:
            elastic = self.elastic_pressure(displacement)
        else:
            elastic = self._on_layer(held)
        gap = self.gap(displacement, height)
        if self.interaction.hard:
            wall_energy = np.zeros(gap.shape)
            pressure = self._reaction(gap, elastic) if held is None else held
        else:
            wall_energy, pressure = self.wall(gap)

        n, m = gap.shape
        forces, energies = elastic, np.empty(elastic.shape)
        mean = float(pressure.mean()) if self.halfspace.periodic else 0.0

        def bulk(rows: slice) -> None:
            np.multiply(displacement[rows], elastic[rows], out=energies[rows])
            energies[rows] *= -0.5 * area
            forces[rows] += mean
            forces[rows] *= area

        def wall(rows: slice) -> None:
            energies[:n, :m][rows] += area * wall_energy[rows]
            forces[:n, :m][rows] -= area * pressure[rows]

        by_rows(bulk, energies.shape)
        by_rows(wall, gap.shape)
        return ContactState(
            energy=float(energies.sum()),
            energies=energies,
            forces=forces,
            gap=gap,
            pressure=pressure,
            normal_force=float(area * pressure.sum()),
            cell_area=area,
        )

    def _on_layer(self, pressure: np.ndarray) -> np.ndarray:
        """Pressure on all atoms of one on the window, without its mean if periodic."""
        if self.halfspace.periodic:
            return pressure - pressure.mean()
        everywhere = np.zeros(self.halfspace.dof_shape)
        n, m = pressure.shape
        everywhere[:n, :m] = pressure
        return everywhere

    def _reaction(self, gap: np.ndarray, elastic: np.ndarray) -> np.ndarray:
        """Pressure of a hard wall: what holds the atoms that touch it."""
        touching = _HARD_GAP * self.halfspace.spacing
        if gap.min() < -touching:
            raise ValueError(
                f"the hard wall overlaps with {np.count_nonzero(gap < -touching)} "
                f"atoms by up to {-gap.min():.3g}, and exerts no force that would "
                "push them out: relax it with ActiveSet, or take "
                "LennardJones93.repulsive with any other optimizer"
            )
        window = elastic[: gap.shape[0], : gap.shape[1]]
        if self.halfspace.periodic:
            # the mean pressure does not show in the displacement: an open atom's is 0
            window = window - window.min()
        least = _HARD_PRESSURE * max(window.max(), 0.0)
        holds = (gap <= touching) & (window > least)
        return np.where(holds, window, 0.0)
