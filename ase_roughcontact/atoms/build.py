"""The substrate as ASE Atoms: surface atoms on a square lattice, and the indenter.

The surface atoms come first, row by row along y: atom ``i*M + j`` of an N x M grid at
``(x0 + i a0, y0 + j a0, u)``, its z being its displacement. The last atom, of symbol X,
is the indenter: its z is the indenter's height, its x and y are the position of the
indenter's axis. The cell is the window of atoms that may touch the indenter; atoms
outside of it are the margin of a free half space, which no wall acts on. The margin may
be left out.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from ase import Atoms
from ase.calculators.singlepoint import SinglePointCalculator
from ase.constraints import FixAtoms
from ase.data import atomic_numbers, chemical_symbols, reference_states
from ase.units import GPa

from ase_roughcontact._util.validation import finite, grid_shape, positive, surface
from ase_roughcontact.atoms.grid import SurfaceGrid, displacement, inside
from ase_roughcontact.elasticity.greens import ElasticSolid
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace
from ase_roughcontact.topography import Surface

TAG_OPEN, TAG_CONTACT, TAG_ATTRACTED = 0, 1, 2


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
        `RoughSphere`, `SelfAffine`, `HeightMap` or anything with their `heights`, and,
        to be written to files, `todict`.
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
    grid = SurfaceGrid.grid_for((n, m), periodic)
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

    Raises
    ------
    ValueError
        If the atoms have no `RoughContact` calculator.
    """
    if not hasattr(atoms.calc, "state"):
        raise ValueError(f"snapshot needs a RoughContact calculator, got {atoms.calc}")
    state = atoms.calc.state(atoms)
    layout = atoms.calc.layout(atoms)
    keep = np.append(inside(layout), True)
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


def restore(frame: Atoms, solid: ElasticSolid | float) -> Atoms:
    """Rebuild the atoms of a calculation, with their margin, from a frame.

    A frame is good for a calculation as it is, too; with its margin an energy costs one
    pair of transforms.

    Parameters
    ----------
    frame : Atoms
        As `snapshot` made it, also read back from a file.
    solid : ElasticSolid or float
        Substrate, or its contact modulus (eV/Å^3), from which the displacement of the
        margin follows.

    Returns
    -------
    Atoms
        Window, margin and indenter, without calculator.
        The indenter is fixed if it was; set other constraints anew.

    Raises
    ------
    ValueError
        If the frame was not made by `snapshot`.
    """
    if not frame.has("initial_charges"):
        raise ValueError("the frame has no pressures: it was not made by snapshot()")
    layout = SurfaceGrid.of(frame)
    if layout.periodic:
        atoms = Atoms(frame.numbers, frame.positions, cell=frame.cell, pbc=frame.pbc)
        _fix_like(frame, atoms)
        return atoms
    window, spacing = layout.window, layout.spacing
    pressure = frame.get_initial_charges()[:-1].reshape(window) * GPa
    values = FreeHalfSpace(window, spacing, solid).padded_displacement(pressure)
    values[: window[0], : window[1]] = displacement(frame, layout)
    grid = values.shape

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
