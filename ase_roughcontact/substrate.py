"""The substrate as ASE Atoms: surface atoms on a square lattice, and the indenter.

The surface atoms come first, row by row along y: atom ``i*M + j`` of an N x M grid at
``(x0 + i a0, y0 + j a0, u)``, its z being its displacement. The last atom, of symbol X,
is the indenter: its z is the indenter's height, its x and y are the position of the
indenter's axis. The cell is the window of atoms that may touch the indenter; atoms
outside of it are the margin of a free half space, which no wall acts on. The margin may
be left out, and, where few atoms can touch, all the others, too: a cell that is flat,
as high as the spacing, tells that its atoms are scattered.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from ase import Atoms
from ase.calculators.singlepoint import SinglePointCalculator
from ase.constraints import FixAtoms
from ase.data import atomic_numbers, chemical_symbols, reference_states
from ase.units import GPa

from ase_roughcontact.checks import finite, grid_shape, positive, surface
from ase_roughcontact.condensed import CondensedHalfSpace, ScatteredHalfSpace
from ase_roughcontact.halfspace import FreeHalfSpace, HalfSpace, PeriodicHalfSpace
from ase_roughcontact.topography import Surface, heights_at

# Lateral positions may differ from the grid's by this part of the spacing: text formats
# round them.
_OFF_GRID = 1e-4

TAG_OPEN, TAG_CONTACT, TAG_ATTRACTED = 0, 1, 2


@dataclass(frozen=True)
class Layout:
    """How the atoms of a substrate make a grid.

    Attributes
    ----------
    window : (int, int)
        Shape of the window that may touch.
    grid : (int, int)
        Shape of all surface atoms: of the window and its margin, of the window, or
        ``(k, 1)`` if they are scattered.
    spacing : float
        Distance of neighbours (length).
    origin : (float, float)
        Position of the window's first corner relative to the indenter's axis (length).
    periodic : bool
        Periodic or free half space.
    sites : ndarray of int, shape (k, 2), or None
        Places of scattered atoms in the window, in spacings.
    """

    window: tuple[int, int]
    grid: tuple[int, int]
    spacing: float
    origin: tuple[float, float]
    periodic: bool
    sites: np.ndarray | None = None

    def halfspace(self, contact_modulus: float, **fft: Any) -> HalfSpace:
        """Half space below the atoms; see there for the parameters."""
        given = self.spacing, contact_modulus
        if self.sites is not None:
            return ScatteredHalfSpace(self.sites, *given, **fft)
        if self.periodic:
            return PeriodicHalfSpace(self.window, *given, **fft)
        margin = self.grid == FreeHalfSpace.padded(self.window)
        return (FreeHalfSpace if margin else CondensedHalfSpace)(
            self.window, *given, **fft
        )

    def heights(self, indenter: Surface) -> np.ndarray:
        """Heights of an indenter at the atoms that may touch (length)."""
        if self.sites is None:
            return indenter.heights(self.window, self.spacing, self.origin)
        return heights_at(indenter, self.sites, self.spacing, self.origin)[:, None]

    @classmethod
    def of(cls, atoms: Atoms) -> Layout:
        """Read the layout off the atoms.

        Parameters
        ----------
        atoms : Atoms
            Substrate and indenter.

        Returns
        -------
        Layout

        Raises
        ------
        ValueError
            If the last atom is not the indenter, the other ones are not on a square
            grid that fits the cell, or the boundary is neither periodic in x and y
            nor free in all directions.
        """
        _check_indenter(atoms)
        periodic = _check_boundary(atoms)
        if not np.isfinite(atoms.positions).all():
            raise ValueError("positions must be finite, got NaN or infinity")
        xy = atoms.positions[:-1, :2]
        axis = atoms.positions[-1, :2]
        if _is_flat(atoms.cell):
            window, spacing, sites = _scattered(xy, atoms.cell)
            corner = xy[0] - spacing * sites[0] - axis
            origin = float(corner[0]), float(corner[1])
            return cls(window, (len(xy), 1), spacing, origin, periodic, sites)
        grid, spacing = _grid_of(xy, atoms.cell)
        _check_on_grid(xy, grid, spacing)
        window = _window_of(atoms.cell, spacing)
        expected = Layout.grid_for(window, periodic)
        if grid not in (expected, window):
            raise ValueError(
                f"a cell of {window} atoms needs a grid of {expected} atoms, margin "
                f"included, or of {window} without; got {grid}. Build the atoms with "
                "substrate()"
            )
        origin = (float(xy[0, 0] - axis[0]), float(xy[0, 1] - axis[1]))
        return cls(window, grid, spacing, origin, periodic)

    @staticmethod
    def grid_for(window: tuple[int, int], periodic: bool) -> tuple[int, int]:
        """Shape of the grid for a window."""
        return (PeriodicHalfSpace if periodic else FreeHalfSpace).padded(window)


def substrate(
    symbol: str,
    shape: tuple[int, int],
    indenter: Surface,
    *,
    spacing: float | None = None,
    periodic: bool = False,
    height: float | None = None,
    center: tuple[float, float] = (0.0, 0.0),
    fixed: bool = True,
) -> Atoms:
    """Build the surface atoms and the indenter above them.

    Parameters
    ----------
    symbol : str
        Chemical symbol of the substrate. For an fcc crystal it sets the spacing,
        ``a0 = a/sqrt(2)``, the distance of neighbours in its (100) surface.
    shape : (int, int)
        Number of atoms ``(n, m)`` that may touch the indenter: the window.
    indenter : Surface
        `RoughSphere`, `SelfAffine`, `HeightMap` or anything with their `heights`.
    spacing : float, optional
        Distance of neighbours (Å), instead of the crystal's.
    periodic : bool
        Periodic half space (pbc in x and y) instead of a free one. A free one gets a
        margin of atoms around the window, so that the whole has about four times as
        many.
    height : float, optional
        Height Z of the indenter (Å); by default its lowest point is one spacing
        above the substrate, where a bulk-matched wall begins to repel.
    center : (float, float)
        Position of the window's centre relative to the indenter's axis (Å); rounded
        to whole spacings.
    fixed : bool
        Fix the indenter (displacement control). Else it is free to move along z
        (load control, cantilever).

    Returns
    -------
    Atoms
        The grid, then the indenter (symbol X).

    Raises
    ------
    ValueError
        If the symbol has no fcc reference and no spacing is given, or a number is not
        finite or not positive.

    Examples
    --------
    >>> from ase_roughcontact import RoughSphere, substrate
    >>> atoms = substrate('Cu', (8, 8), RoughSphere(radius=100.0))
    >>> len(atoms), atoms.symbols[0], atoms.symbols[-1]
    (226, 'Cu', 'X')
    """
    n, m = grid_shape(shape)
    _check_element(symbol)
    surface(indenter=indenter)
    a0 = fcc_spacing(symbol) if spacing is None else spacing
    positive(spacing=a0)
    if np.shape(center) != (2,):
        raise ValueError(f"center must be two numbers (x, y), got {center!r}")
    finite(center_x=center[0], center_y=center[1])
    grid = Layout.grid_for((n, m), periodic)
    axis = a0 * np.array(
        [n // 2 - round(center[0] / a0), m // 2 - round(center[1] / a0)]
    )
    if height is None:
        height = a0 - float(indenter.heights((n, m), a0, (-axis[0], -axis[1])).min())
    finite(height=height)

    positions = np.zeros((grid[0] * grid[1] + 1, 3))
    positions[:-1, :2] = a0 * np.indices(grid).reshape(2, -1).T
    positions[-1] = *axis, height
    atoms = Atoms(
        numbers=[atomic_numbers[symbol]] * (len(positions) - 1) + [0],
        positions=positions,
        cell=[n * a0, m * a0, max(n, m) * a0],
        pbc=(periodic, periodic, False),
    )
    if fixed:
        atoms.set_constraint(FixAtoms([len(atoms) - 1]))
    return atoms


def fcc_spacing(symbol: str) -> float:
    """Spacing of the atoms in the (100) surface of an fcc crystal, a/sqrt(2) (Å).

    Parameters
    ----------
    symbol : str
        Chemical symbol.

    Returns
    -------
    float

    Raises
    ------
    ValueError
        If the symbol is unknown, or its reference crystal is not fcc.
    """
    _check_element(symbol)
    state = reference_states[atomic_numbers[symbol]]
    if state is None or state.get("symmetry") != "fcc":
        raise ValueError(
            f"{symbol} is not fcc in ASE's reference states: give spacing="
        )
    return float(state["a"] / math.sqrt(2))


def displacement(atoms: Atoms, layout: Layout) -> np.ndarray:
    """Displacement of the surface atoms, shape of the layout's grid (Å)."""
    return atoms.positions[:-1, 2].reshape(layout.grid)


def set_displacement(atoms: Atoms, values: np.ndarray) -> None:
    """Move the surface atoms to a displacement, shape of the layout's grid (Å)."""
    atoms.positions[:-1, 2] = values.ravel()


def snapshot(atoms: Atoms, **info: Any) -> Atoms:
    """Copy of window and indenter to look at, with results that travel in a file.

    Parameters
    ----------
    atoms : Atoms
        With a `RoughContact` calculator.
    **info
        Numbers and strings to keep with the frame.

    Returns
    -------
    Atoms
        Tags are 1 for atoms in contact, 2 for atoms that are attracted, 0 for open ones
        and the indenter. Initial charges are the pressures in GPa
        (`ase gui` colours by either). Energy, energies and forces are kept in a
        `SinglePointCalculator`; normal force, contact area and `info` are in its
        `info`.
    """
    if not hasattr(atoms.calc, "state"):
        raise ValueError(f"snapshot needs a RoughContact calculator, got {atoms.calc}")
    state = atoms.calc.state(atoms)
    layout = atoms.calc.layout(atoms)
    keep = np.append(_inside(layout), True)
    frame = atoms[keep]
    tags = np.full(state.pressure.shape, TAG_OPEN)
    tags[state.pressure > 0] = TAG_CONTACT
    tags[state.pressure < 0] = TAG_ATTRACTED
    frame.set_tags(np.append(tags, TAG_OPEN))
    frame.set_initial_charges(np.append(state.pressure / GPa, 0.0))
    frame.info.update(
        normal_force=state.normal_force, contact_area=state.contact_area, **info
    )
    frame.calc = SinglePointCalculator(
        frame,
        energy=atoms.get_potential_energy(apply_constraint=False),
        energies=atoms.calc.results["energies"][keep],
        forces=atoms.get_forces(apply_constraint=False)[keep],
    )
    return frame


def restore(frame: Atoms, contact_modulus: float) -> Atoms:
    """Rebuild the atoms of a calculation, with their margin, from a frame.

    A frame is good for a calculation as it is, too; with its margin an energy costs one
    pair of transforms.

    Parameters
    ----------
    frame : Atoms
        As `snapshot` made it, also read back from a file.
    contact_modulus : float
        E* of the substrate (eV/Å^3), from which the margin's displacement follows.

    Returns
    -------
    Atoms
        Window, margin and indenter, without calculator; scattered atoms have no margin.
        The indenter is fixed if it was; set other constraints anew.
    """
    if not frame.has("initial_charges"):
        raise ValueError("the frame has no pressures: it was not made by snapshot()")
    if _is_flat(frame.cell):
        atoms = Atoms(frame.numbers, frame.positions, cell=frame.cell, pbc=frame.pbc)
        _fix_like(frame, atoms)
        return atoms
    window = _window_of(frame.cell, _grid_of(frame.positions[:-1, :2], frame.cell)[1])
    periodic = _check_boundary(frame)
    spacing = frame.cell[0, 0] / window[0]
    grid = Layout.grid_for(window, periodic)
    pressure = frame.get_initial_charges()[:-1].reshape(window) * GPa
    heights = frame.positions[:-1, 2].reshape(window)
    if periodic:
        values = heights
    else:
        halfspace = FreeHalfSpace(window, spacing, contact_modulus)
        values = halfspace.surroundings(pressure)
        values[: window[0], : window[1]] = heights

    positions = np.zeros((grid[0] * grid[1] + 1, 3))
    positions[:-1, :2] = frame.positions[0, :2]
    positions[:-1, :2] += spacing * np.indices(grid).reshape(2, -1).T
    positions[:-1, 2] = values.ravel()
    positions[-1] = frame.positions[-1]
    atoms = Atoms(
        numbers=[frame.numbers[0]] * (len(positions) - 1) + [0],
        positions=positions,
        cell=frame.cell,
        pbc=frame.pbc,
    )
    _fix_like(frame, atoms)
    return atoms


def indenter_fixed(atoms: Atoms) -> bool:
    """Whether the constraints keep the indenter at its height."""
    moved = atoms.positions.copy()
    moved[-1, 2] += 1.0
    for constraint in atoms.constraints:
        constraint.adjust_positions(atoms, moved)
    return bool(moved[-1, 2] == atoms.positions[-1, 2])


def _check_element(symbol: str) -> None:
    if symbol not in chemical_symbols[1:]:
        raise ValueError(f"unknown chemical symbol {symbol!r}")


def _fix_like(frame: Atoms, atoms: Atoms) -> None:
    """Fix the indenter if it is in the frame."""
    if any(isinstance(constraint, FixAtoms) for constraint in frame.constraints):
        atoms.set_constraint(FixAtoms([len(atoms) - 1]))


def _inside(layout: Layout) -> np.ndarray:
    if layout.sites is not None:
        return np.ones(len(layout.sites), dtype=bool)
    inside = np.zeros(layout.grid, dtype=bool)
    inside[: layout.window[0], : layout.window[1]] = True
    return inside.ravel()


def _check_indenter(atoms: Atoms) -> None:
    ghosts = np.flatnonzero(atoms.numbers == 0)
    if len(atoms) < 2 or list(ghosts) != [len(atoms) - 1]:
        where = "none" if len(ghosts) == 0 else f"atoms {ghosts[:5].tolist()}"
        raise ValueError(
            "the last atom, and no other, must be the indenter (symbol X); "
            f"of {len(atoms)} atoms, {where} have that symbol"
        )


def _check_boundary(atoms: Atoms) -> bool:
    pbc = tuple(bool(flag) for flag in atoms.pbc)
    if pbc not in ((True, True, False), (False, False, False)):
        raise ValueError(
            "pbc must be (True, True, False) for a periodic half space or all False "
            f"for a free one, got {pbc}"
        )
    cell = atoms.cell.array
    if np.abs(cell - np.diag(np.diag(cell))).max() > 0 or np.diag(cell)[:2].min() <= 0:
        raise ValueError(
            "the cell must be the rectangular window of atoms that may touch, got "
            f"{cell.tolist()}"
        )
    return pbc[0]


def _grid_of(xy: np.ndarray, cell: Any) -> tuple[tuple[int, int], float]:
    """Shape and spacing from the order of the atoms."""
    spacing = float(np.abs(xy[1] - xy[0]).max()) if len(xy) > 1 else float(cell[0, 0])
    next_row = np.flatnonzero(xy[:, 0] - xy[0, 0] > spacing / 2)
    columns = int(next_row[0]) if len(next_row) else len(xy)
    rows, rest = divmod(len(xy), columns)
    if rest or not spacing > 0:
        raise ValueError(
            f"{len(xy)} surface atoms do not make a grid with rows of {columns}"
        )
    return (rows, columns), spacing


def _is_flat(cell: Any) -> bool:
    """Whether a cell tells that its atoms are scattered."""
    return bool(0.0 < cell[2, 2] < 0.999 * max(cell[0, 0], cell[1, 1]))


def _scattered(xy: np.ndarray, cell: Any) -> tuple[tuple[int, int], float, np.ndarray]:
    """Window, spacing and sites of scattered atoms."""
    window = _window_of(cell, float(cell[2, 2]))
    longer = int(np.argmax(window))
    spacing = float(cell[longer, longer]) / window[longer]
    steps = (xy - xy.min(axis=0)) / spacing
    sites = np.rint(steps).astype(int)
    off = np.abs(steps - sites).max(axis=1)
    if off.max() > _OFF_GRID * max(1.0, 1e-3 * max(window)):
        raise ValueError(
            f"atom {off.argmax()} is off the lattice by {off.max():.3g} spacings of "
            f"{spacing:.6g}, the height of the cell: surface atoms may move along z "
            "only"
        )
    if len(np.unique(sites, axis=0)) < len(sites):
        raise ValueError("several atoms are on one site of the lattice")
    if tuple(sites.max(axis=0) + 1) != window:
        raise ValueError(
            f"scattered atoms must span the cell of {window} atoms, got "
            f"{tuple(sites.max(axis=0) + 1)}"
        )
    return window, spacing, sites


def _check_on_grid(xy: np.ndarray, grid: tuple[int, int], spacing: float) -> None:
    expected = xy[0] + spacing * np.indices(grid).reshape(2, -1).T
    # a spacing read off two rounded positions drifts with the index
    tolerance = _OFF_GRID * spacing * max(1.0, 1e-3 * max(grid))
    off = np.abs(xy - expected).max(axis=1)
    if off.max() > tolerance:
        worst = int(off.argmax())
        raise ValueError(
            f"atom {worst} is off the square grid by {off[worst]:.3g} (spacing "
            f"{spacing:.6g}): surface atoms may move along z only"
        )


def _window_of(cell: Any, spacing: float) -> tuple[int, int]:
    sides = np.diag(cell.array)[:2] / spacing
    window = np.rint(sides).astype(int)
    if np.abs(sides - window).max() > 1e-3 * max(1.0, 1e-3 * sides.max()):
        raise ValueError(
            f"the cell's sides must be whole numbers of spacings, got {sides.tolist()}"
        )
    return int(window[0]), int(window[1])
