"""State of a contact, and the energy, forces and local fields that follow from it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ase_roughcontact._util.kernels import total_abs
from ase_roughcontact._util.summary import Summarized
from ase_roughcontact._util.validation import instance_of
from ase_roughcontact.contact.history import HistoryEntry, declare, entry_of
from ase_roughcontact.elasticity.creep import Creep
from ase_roughcontact.elasticity.lattice import Box, carried

#: Depth by which the surface has flowed.
PLASTIC_DEPTH = declare(HistoryEntry("plastic_depth", "Å", in_frames=True)).name
#: Tractions of friction along x and y.
TRACTIONS = tuple(
    declare(HistoryEntry(f"traction_{axis}", "eV/Å^3", in_frames=True)).name
    for axis in "xy"
)
#: Lateral displacements that the tractions cause. Frames have them as positions.
DISPLACEMENTS = tuple(
    declare(HistoryEntry(f"displacement_{axis}", "Å", in_frames=True)).name
    for axis in "xy"
)
#: Mask of the atoms that slip, 1 or 0.
SLIPPING = declare(HistoryEntry("slipping", in_frames=True)).name
#: All entries of friction.
LATERAL = (*TRACTIONS, *DISPLACEMENTS, SLIPPING)
#: Depth that the tractions cause, if normal and lateral motion are coupled.
TRACTION_DEPTH = declare(HistoryEntry("traction_depth", "Å")).name

# Largest relative distance from the hardness of a pressure that counts as the hardness:
# the pressure on atoms that have flowed, at the same load again, is known to the
# tolerance of the solver only.
_FLOW_PRESSURE = 1e-5
# Largest rounding error of an array in single precision, relative to its largest value.
_SINGLE_PRECISION = 1e-6
# Largest rounding error of a pressure, relative to the largest pressure.
_PRESSURE_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class EarlierState(Summarized):
    """Relaxed state of an earlier step, from which the next one is extrapolated.

    Attributes
    ----------
    target : float
        Load or height that was prescribed, or the time.
    window : Box
        Window of the state.
    pressure : ndarray, shape (n, m)
        Pressure of the wall.
    height : float
        Height of the indenter (length).
    """

    target: float
    window: Box
    pressure: np.ndarray
    height: float


@dataclass(frozen=True, eq=False)
class State(Summarized):
    """State of a contact, with all that the next step of a path starts from.

    Arrays of a state are never changed in place.

    Attributes
    ----------
    window : Box
        Atoms that may carry a pressure.
    height : float
        Height of the indenter (length).
    pressure : ndarray, shape (n, m)
        Elastic pressure, which determines the displacement; up to its mean if periodic.
    displacement : ndarray, shape (n, m), optional
        Displacement that the pressure causes, if it is known (length).
    history : mapping of str to ndarray of shape (n, m)
        History that the surface keeps of earlier steps: entries that are declared, see
        `HistoryEntry`, such as a plastic depth, the pressures of a viscoelastic past,
        or the tractions of friction.
    depths : mapping of str to ndarray of shape (n, m)
        Depths that pressures of the history cause, as far as they are known (length).
    creep : Creep or None
        Creep of the solid in which the surface has crept.
    earlier : tuple of EarlierState
        The last two relaxed states at most, in order.
    mean_force : float
        Mean force on an atom in contact, for which the tolerance of the next step is
        made; NaN before any contact (force).
    """

    window: Box
    height: float
    pressure: np.ndarray
    displacement: np.ndarray | None = None
    history: Mapping[str, np.ndarray] = field(default_factory=dict)
    depths: Mapping[str, np.ndarray] = field(default_factory=dict)
    creep: Creep | None = None
    earlier: tuple[EarlierState, ...] = ()
    mean_force: float = math.nan

    def __post_init__(self) -> None:
        """Check window, height and pressure."""
        instance_of(Box, window=self.window)
        instance_of((int, float, np.number), height=self.height)
        instance_of(np.ndarray, pressure=self.pressure)

    @classmethod
    def flat(cls, window: Box, height: float) -> State:
        """Return the state of a surface that nothing acts on."""
        zeros = np.broadcast_to(0.0, window.shape)  # without memory
        return cls(window, height, zeros, zeros)

    def flattened(self, height: float) -> State:
        """Return the state without pressure, with all that the surface has kept."""
        zeros = np.broadcast_to(0.0, self.window.shape)  # without memory
        return replace(self, height=height, pressure=zeros, displacement=zeros)

    @property
    def displaced(self) -> bool:
        """Whether the surface is not flat."""
        return bool(self.pressure.any())

    @property
    def plastic_depth(self) -> np.ndarray | None:
        """Depth by which the surface has flowed; None without (length)."""
        return self.history.get(PLASTIC_DEPTH)

    def changed_entries(self, other: State) -> list[str]:
        """Return the names of the entries of the history that differ in another state.

        Differences that single precision leaves in frames do not count.
        """
        window = self.window.union(other.window)
        ours, theirs = self.on(window).history, other.on(window).history
        changed = []
        for name in sorted(ours.keys() | theirs.keys()):
            new = np.full(window.shape, entry_of(name).entering)
            old, new = ours.get(name, new), theirs.get(name, new)
            largest = max(abs(old).max(), abs(new).max())
            if abs(new - old).max() > _SINGLE_PRECISION * largest:
                changed.append(name)
        return changed

    def at(self, height: float) -> State:
        """Return the state with the indenter at another height."""
        return replace(self, height=height)

    def on(self, window: Box) -> State:
        """Return the state on another window, with flat atoms that are new in it.

        They have the values of `HistoryEntry.entering`.
        """
        if window == self.window:
            return self
        pressure = carried(without_rounding(self.pressure), self.window, window)
        history = {
            name: carried(values, self.window, window, entry_of(name).entering)
            for name, values in self.history.items()
        }
        return replace(
            self,
            window=window,
            pressure=pressure,
            displacement=None,
            history=history,
            depths={},
        )

    def in_order(self) -> State:
        """Return the state with arrays in the order in which a file returns them.

        Sums over the same numbers in another order of memory round differently.
        """

        def ordered(values: np.ndarray) -> np.ndarray:
            return values if not any(values.strides) else np.ascontiguousarray(values)

        displacement = self.displacement
        return replace(
            self,
            pressure=ordered(self.pressure),
            displacement=None if displacement is None else ordered(displacement),
            history={name: ordered(each) for name, each in self.history.items()},
            depths={name: ordered(each) for name, each in self.depths.items()},
            earlier=tuple(
                replace(each, pressure=ordered(each.pressure)) for each in self.earlier
            ),
        )

    def keeping(self, **history: np.ndarray | None) -> State:
        """Return the state with other entries of its history; None removes one.

        Raises
        ------
        ValueError
            If an entry is not declared, or has not the shape of the window.
        """
        for name, values in history.items():
            entry_of(name)
            if values is not None and np.shape(values) != self.window.shape:
                raise ValueError(
                    f"the entry {name!r} of the history must have the shape "
                    f"{self.window.shape} of the window, got {np.shape(values)}"
                )
        new = {
            name: values for name, values in self.history.items() if name not in history
        }
        for name, values in history.items():
            if values is not None:
                new[name] = values
        return replace(self, history=new)


def without_rounding(pressure: np.ndarray) -> np.ndarray:
    """Return a pressure with the entries set to zero that are only rounding errors."""
    least = _PRESSURE_ROUNDING * abs(pressure).max()
    return np.where(abs(pressure) < least, 0.0, pressure)


def flows(pressure: np.ndarray, hardness: float) -> np.ndarray:
    """Return the mask of the pressures that are at the hardness."""
    return pressure >= (1.0 - _FLOW_PRESSURE) * hardness


@dataclass(frozen=True, eq=False)
class ContactState(Summarized):
    """Energy, forces and local fields of one configuration.

    Attributes
    ----------
    energy : float
        Elastic and wall energy.
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
    touching : ndarray, shape (n, m), optional
        Mask of the atoms that touch a hard wall with attraction, where the pressure may
        be a tension; by default atoms touch where the pressure is repulsive.
    hardness : float
        Largest pressure of the wall, by default infinity.
    kept_depth : ndarray, shape (n, m), optional
        Plastic depth that the surface has kept from earlier steps (length).
    """

    energy: float
    forces: np.ndarray
    gap: np.ndarray
    pressure: np.ndarray
    normal_force: float
    cell_area: float
    touching: np.ndarray | None = None
    hardness: float = math.inf
    kept_depth: np.ndarray | None = None

    def read_only(self) -> ContactState:
        """Return the same state with arrays that can't be written to."""
        touching, kept_depth = self.touching, self.kept_depth
        return replace(
            self,
            forces=_read_only(self.forces),
            gap=_read_only(self.gap),
            pressure=_read_only(self.pressure),
            touching=None if touching is None else _read_only(touching),
            kept_depth=None if kept_depth is None else _read_only(kept_depth),
        )

    @cached_property
    def contact(self) -> np.ndarray:
        """Mask of the atoms that the wall repels, shape (n, m)."""
        return _read_only(
            self.pressure > 0.0 if self.touching is None else self.touching
        )

    @cached_property
    def repulsive_atoms(self) -> int:
        """Number of atoms in contact."""
        return int(np.count_nonzero(self.contact))

    @cached_property
    def contact_pressure(self) -> float:
        """Mean magnitude of the pressure on the atoms in contact, zero without any."""
        pressures = abs(self.pressure[self.contact])
        return float(pressures.mean()) if pressures.size else 0.0

    @cached_property
    def total_magnitude(self) -> float:
        """Sum of the magnitudes of the forces of the wall on the atoms."""
        return self.cell_area * total_abs(self.pressure)

    @cached_property
    def attractive_atoms(self) -> int:
        """Number of other atoms under an attractive pressure."""
        return int(np.count_nonzero((self.pressure < 0.0) & ~self.contact))

    @cached_property
    def plastic(self) -> np.ndarray:
        """Mask of the atoms under the hardness, in plastic contact, shape (n, m)."""
        return _read_only(flows(self.pressure, self.hardness))

    @cached_property
    def plastic_atoms(self) -> int:
        """Number of atoms in plastic contact, which count as atoms in contact, too."""
        return int(np.count_nonzero(self.plastic))

    @property
    def plastic_depth(self) -> np.ndarray:
        """Depth by which the surface has flowed, shape (n, m) (length)."""
        if self.hardness == math.inf:
            return np.broadcast_to(0.0, self.gap.shape)
        depth = np.maximum(-self.gap, 0.0) * self.plastic
        return depth if self.kept_depth is None else depth + self.kept_depth

    @property
    def contact_area(self) -> float:
        """Area of the atoms in contact."""
        return self.repulsive_atoms * self.cell_area


def _read_only(values: np.ndarray) -> np.ndarray:
    """Return a view of an array that can't be written to."""
    view = values.view()
    view.flags.writeable = False
    return view
