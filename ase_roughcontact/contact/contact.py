"""Half space, indenter and wall: energy, forces, gap and pressure as arrays."""

from __future__ import annotations

import numpy as np

from ase_roughcontact._util.kernels import inner, rowwise
from ase_roughcontact.contact.state import ContactState, flows
from ase_roughcontact.elasticity.halfspace import HalfSpace
from ase_roughcontact.interactions import Interaction, scaled_attraction

# Largest gap of an atom in contact with a hard wall, in units of the spacing.
_HARD_GAP = 1e-5
# Smallest pressure of an atom that carries load, relative to the largest pressure.
_HARD_PRESSURE = 1e-9
# Largest relative distance from the hardness of the pressure on an atom that may
# overlap.
_OVERLAP_PRESSURE = 1e-3


class Contact:
    """Half space, indenter and the interaction between them.

    Parameters
    ----------
    halfspace : HalfSpace
        The elastic solid.
    heights : ndarray, shape (n, m)
        Lower surface of the indenter above its reference height, at every atom of the
        window (length).
    wall : Interaction
        The wall.
    adhesion : ndarray, shape (n, m), optional
        Local work of adhesion, relative to the wall's work of adhesion; see
        `scaled_attraction`. By default it is one everywhere.
    plastic_depth : ndarray, shape (n, m), optional
        Depth by which the surface has flowed in earlier steps (length).
    creep_pressure, past_depth : ndarray, shape (n, m), optional
        Pressure that a viscoelastic surface remembers, relative to its instantaneous
        response, and the depth that this, or tractions of friction, cause (pressure,
        length).

    Attributes
    ----------
    indenter_heights : ndarray, shape (n, m)
        The given heights.
    heights : ndarray, shape (n, m)
        Lower surface of the indenter above the surface that the wall does not press:
        with plastic depth, creep and friction.

    Raises
    ------
    ValueError
        If an array does not have the shape of the window or is not finite, or the local
        work of adhesion is negative.
    """

    def __init__(
        self,
        halfspace: HalfSpace,
        heights: np.ndarray,
        wall: Interaction,
        adhesion: np.ndarray | None = None,
        plastic_depth: np.ndarray | None = None,
        creep_pressure: np.ndarray | None = None,
        past_depth: np.ndarray | None = None,
    ) -> None:
        self.halfspace = halfspace
        self.indenter_heights = self._checked("heights", heights)
        self.heights = self.indenter_heights
        if plastic_depth is not None:
            self.heights = self.heights + self._checked("plastic_depth", plastic_depth)
        if past_depth is not None:
            self.heights = self.heights + self._checked("past_depth", past_depth)
        self.wall, self.plastic_depth = wall, plastic_depth
        self.creep_pressure, self.past_depth = creep_pressure, past_depth
        self.adhesion = None
        if adhesion is not None:
            self.adhesion = self._checked("adhesion", adhesion)
            if self.adhesion.min() < 0.0:
                raise ValueError(
                    f"adhesion must be at least 0, got {self.adhesion.min():g}"
                )

    @property
    def first_contact(self) -> float:
        """Height of the indenter at which the wall begins to repel a flat surface."""
        return float(self.wall.contact_distance - self.indenter_heights.min())

    @property
    def plastic_work(self) -> float:
        """Work of the plastic flow in earlier steps."""
        if self.plastic_depth is None or not self.wall.plastic:
            return 0.0
        depth = float(self.plastic_depth.sum())
        return self.wall.hardness * self.halfspace.cell_area * depth

    def changed(
        self,
        halfspace: HalfSpace,
        plastic_depth: np.ndarray | None,
        creep_pressure: np.ndarray | None = None,
        past_depth: np.ndarray | None = None,
    ) -> Contact:
        """Return the contact of the same window with another past; see `Contact`."""
        return Contact(
            halfspace,
            self.indenter_heights,
            self.wall,
            self.adhesion,
            plastic_depth,
            creep_pressure,
            past_depth,
        )

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
        if self.halfspace.periodic:
            height = height + displacement.mean()
        gap = self.heights - self._on_window(displacement)
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

    def evaluate_wall(self, gap: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return energy per area and pressure of the wall, without a reaction.

        Parameters
        ----------
        gap : ndarray, shape (n, m)
            Gap as returned by `gap` (length).

        Returns
        -------
        energy, pressure : ndarray, shape (n, m)
        """
        energy, pressure = np.zeros(gap.shape), np.zeros(gap.shape)
        _evaluate_in_range(energy, pressure, gap, self.adhesion, self.wall)
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
            Elastic pressure on the window, if a solver has it: it replaces a
            transform of the displacement.
        reaction : ndarray, shape (n, m), optional
            Pressure of a hard wall, if a solver has it. By default it is the elastic
            pressure on the atoms that touch it; if all atoms of a periodic surface do,
            the smallest one is the pressure of the attraction, or zero.

        Returns
        -------
        ContactState

        Raises
        ------
        ValueError
            If the displacement has a wrong shape, or atoms overlap with a hard wall:
            the reaction is not a function of the positions then.
        """
        if displacement.shape != self.halfspace.dof_shape:
            raise ValueError(
                f"displacement must have the shape {self.halfspace.dof_shape} of the "
                f"atoms, got {displacement.shape}"
            )
        periodic, area = self.halfspace.periodic, self.halfspace.cell_area
        elastic = known_pressure  # on the window: zero on the padding
        if elastic is None:
            elastic = self.elastic_pressure(displacement)
        loaded = displacement[: elastic.shape[0], : elastic.shape[1]]
        gap = self.gap(displacement, height)
        wall_energy, pressure, touching = self._with_reaction(gap, elastic, reaction)
        work, normal_force = inner(loaded, elastic), float(area * pressure.sum())
        if periodic:  # their means do no work
            work -= float(displacement.mean() * elastic.sum())
        if pressure is known_pressure:  # zeros without memory, read-only
            forces = np.broadcast_to(0.0, displacement.shape)
        else:
            forces = np.zeros(displacement.shape)
            forces[: loaded.shape[0], : loaded.shape[1]] = elastic
            if periodic:
                forces += pressure.mean() - elastic.mean()
            self._on_window(forces)[:] -= pressure
            forces *= area
        return ContactState(
            energy=area * (float(np.sum(wall_energy)) - 0.5 * work),
            forces=forces,
            gap=gap,
            pressure=pressure,
            normal_force=normal_force,
            cell_area=area,
            touching=touching,
            hardness=self.wall.hardness,
            kept_depth=self.plastic_depth,
        )

    def energies(self, displacement: np.ndarray, state: ContactState) -> np.ndarray:
        """Return the energy of each displaced atom in a state.

        Parameters
        ----------
        displacement : ndarray, shape of the displaced atoms
            Displacement of every atom in the state (length).
        state : ContactState

        Returns
        -------
        ndarray, shape of the displaced atoms
        """
        energies = state.forces / state.cell_area  # the elastic pressure at first
        self._on_window(energies)[:] += state.pressure
        if self.halfspace.periodic:
            displacement = displacement - displacement.mean()
            energies -= energies.mean()
        energies *= displacement
        energies *= -0.5
        on_window, wall = self._on_window(energies), self.wall
        if not wall.purely_hard:
            gap = np.maximum(state.gap, 0.0) if wall.hard else state.gap
            on_window += self.evaluate_wall(gap)[0]
        if wall.plastic:
            on_window += self._plastic_energy(state.gap, state.pressure)
        energies *= state.cell_area
        return energies

    def _on_window(self, values: np.ndarray) -> np.ndarray:
        """Return the part of an array of the displaced atoms that is on the window."""
        return values[: self.halfspace.shape[0], : self.halfspace.shape[1]]

    def _with_reaction(
        self, gap: np.ndarray, elastic: np.ndarray, reaction: np.ndarray | None
    ) -> tuple[np.ndarray | float, np.ndarray, np.ndarray | None]:
        """Return energy and pressure of the wall, and which atoms touch it.

        The latter is None unless a hard wall attracts: atoms under pressure touch.
        """
        wall = self.wall
        if not wall.hard:
            return *self.evaluate_wall(gap), None
        energy: np.ndarray | float = 0.0
        attraction: np.ndarray | float = 0.0
        if wall.attractive:
            energy, attraction = self.evaluate_wall(np.maximum(gap, 0.0))
        if reaction is None:
            reaction = self._reaction(gap, elastic, attraction)
        elif wall.attractive:
            reaction = self._where_touching(gap, reaction, attraction)
        touching = reaction > attraction if wall.attractive else None
        if wall.plastic:
            energy = energy + self._plastic_energy(gap, reaction)
        return energy, reaction, touching

    def _checked(self, name: str, values: np.ndarray) -> np.ndarray:
        """Return an array of the window, or raise `ValueError`."""
        values = np.asarray(values, dtype=float)
        if values.shape != self.halfspace.shape:
            raise ValueError(
                f"{name} must have the shape {self.halfspace.shape} of the window, "
                f"got {values.shape}"
            )
        wrong = np.count_nonzero(~np.isfinite(values))
        if wrong:
            raise ValueError(f"{name} must be finite, got {wrong} values that are not")
        return values

    def _check_overlap(self, gap: np.ndarray) -> None:
        """Raise `ValueError` if atoms overlap with a hard wall."""
        tolerance = _HARD_GAP * self.halfspace.spacing
        if gap.min() < -tolerance:
            raise ValueError(
                f"{np.count_nonzero(gap < -tolerance)} atoms overlap with the hard "
                f"wall by up to {-gap.min():.3g}, where its force is not defined: "
                f"relax them with {self.wall.optimizer}, or use "
                "LennardJones93.repulsive with another optimizer"
            )

    def _reaction(
        self, gap: np.ndarray, elastic: np.ndarray, attraction: np.ndarray | float
    ) -> np.ndarray:
        """Return the elastic pressure on the atoms that touch a hard wall."""
        window = elastic[: gap.shape[0], : gap.shape[1]]
        if self.wall.plastic:
            return self._plastic_reaction(gap, window)
        self._check_overlap(gap)
        if self.halfspace.periodic:
            # the displacement determines the pressure up to its mean
            window = window - (window - attraction).min()
        return self._where_touching(gap, window, attraction)

    def _plastic_reaction(self, gap: np.ndarray, elastic: np.ndarray) -> np.ndarray:
        """Return the elastic pressure on touching atoms, the hardness at overlaps."""
        hardness = self.wall.hardness
        tolerance = _HARD_GAP * self.halfspace.spacing
        overlaps = gap < -tolerance
        if self.halfspace.periodic:
            flowed = elastic[overlaps]
            shift = flowed.mean() - hardness if flowed.size else elastic.min()
            elastic = elastic - shift
        if (elastic[overlaps] < (1.0 - _OVERLAP_PRESSURE) * hardness).any():
            self._check_overlap(gap)
        least = _HARD_PRESSURE * hardness
        reaction = np.where((gap <= tolerance) & (elastic > least), elastic, 0.0)
        reaction[overlaps | flows(reaction, hardness)] = hardness
        return reaction

    def _plastic_energy(self, gap: np.ndarray, pressure: np.ndarray) -> np.ndarray:
        """Return the work of the plastic flow per area."""
        hardness = self.wall.hardness
        depth = np.maximum(-gap, 0.0) * flows(pressure, hardness)
        if self.plastic_depth is not None:
            depth += self.plastic_depth
        return hardness * depth

    def _where_touching(
        self, gap: np.ndarray, pressure: np.ndarray, attraction: np.ndarray | float
    ) -> np.ndarray:
        """Return a pressure where atoms touch a hard wall, else the attraction."""
        excess = pressure - attraction
        touches = gap <= np.minimum(
            self.halfspace.self_compliance * excess, _HARD_GAP * self.halfspace.spacing
        )
        touches &= excess > _HARD_PRESSURE * max(excess.max(), 0.0)
        return np.where(touches, pressure, attraction)


@rowwise()
def _evaluate_in_range(
    energy: np.ndarray,
    pressure: np.ndarray,
    gap: np.ndarray,
    adhesion: np.ndarray | None,
    wall: Interaction,
) -> None:
    """Set ``V(g)`` and ``-V'(g)`` where the wall is in range."""
    near = gap < wall.cutoff
    if near.any():
        local = None if adhesion is None else adhesion[near]
        energy[near], pressure[near], _ = scaled_attraction(wall, gap[near], local)
