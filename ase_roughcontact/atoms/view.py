"""Frames for viewers: with the indenter's surface, with fewer atoms, with columns.

The results are copies for `ase gui`, OVITO and other viewers. They are not meant for
calculations.
"""

from __future__ import annotations

import numpy as np
from ase import Atoms
from ase.calculators.singlepoint import SinglePointCalculator
from ase.data import atomic_numbers
from ase.units import GPa

from ase_roughcontact._util.validation import integer
from ase_roughcontact.atoms.calculator import RoughContact
from ase_roughcontact.atoms.grid import SurfaceGrid, surface_above
from ase_roughcontact.atoms.snapshot import pressure_of, snapshot
from ase_roughcontact.topography import Surface

#: Tag of the atoms that show the indenter's surface.
TAG_INDENTER = 3


def with_indenter(
    atoms: Atoms,
    indenter: Surface | None = None,
    *,
    symbol: str = "C",
    every: int = 1,
    half: bool = False,
) -> Atoms:
    """Return a frame with the indenter's surface as atoms above the substrate.

    Parameters
    ----------
    atoms : Atoms
        With a `RoughContact` calculator, or a frame from `snapshot`.
    indenter : Surface, optional
        The indenter; by default that of the calculator. Frames from a file need it.
    symbol : str
        Element of the new atoms, and so their colour and size.
    every : int
        Show every n-th row of atoms of substrate and indenter; see `thinned`.
    half : bool
        Show only the half of the indenter with the larger y, so that the other half of
        the contact can be seen.

    Returns
    -------
    Atoms
        The window, the indenter (symbol X), and an atom of the indenter's surface above
        each atom of the window, with tag 3. Their distance is the gap.

    Raises
    ------
    ValueError
        If there is no indenter, or it is not that of the frame, the symbol is unknown,
        or `every` is less than one.
    """
    if symbol not in atomic_numbers:
        raise ValueError(f"unknown chemical symbol {symbol!r}")
    indenter = _indenter_of(atoms) if indenter is None else indenter
    if indenter is None:
        raise ValueError("the atoms have no calculator that knows it: give indenter=")
    frame = _frame(atoms)
    grid = SurfaceGrid.of(frame)
    positions = frame.positions[:-1].copy()
    positions[:, 2] = surface_above(frame, grid, indenter)
    positions = positions[_every_row(grid, every)] / every
    if half:
        middle = 0.5 * (positions[:, 1].min() + positions[:, 1].max())
        positions = positions[positions[:, 1] >= middle]
    sphere = Atoms([symbol] * len(positions), positions)
    sphere.set_tags(TAG_INDENTER)
    return _with_energy_of(frame, thinned(frame, every) + sphere)


def thinned(atoms: Atoms, every: int) -> Atoms:
    """Return a frame with every n-th row of atoms along x and y, and the indenter.

    In large windows an atom is smaller than a pixel, and viewers are slow: `ase gui`
    opens 512 x 512 atoms in 7 s, and in 0.6 s with ``every=4``.

    Parameters
    ----------
    atoms : Atoms
        With a `RoughContact` calculator, or a frame from `snapshot`.
    every : int
        The n. All lengths are divided by it, so that the remaining atoms are at the
        distance of neighbours.

    Returns
    -------
    Atoms

    Raises
    ------
    ValueError
        If `every` is less than one.
    """
    frame = _frame(atoms)
    shown = frame[np.append(_every_row(SurfaceGrid.of(frame), every), True)]
    shown.positions /= every
    shown.cell /= every
    return _with_energy_of(frame, shown)


def centred(atoms: Atoms) -> Atoms:
    """Return a frame with the indenter's axis at x = y = 0, and without a cell.

    Frames of a path with automatic windows start at the corners of their windows, so
    that the contact moves from frame to frame of a movie.

    Parameters
    ----------
    atoms : Atoms
        With one indenter (symbol X).

    Returns
    -------
    Atoms
    """
    moved = _frame(atoms).copy()
    moved.positions[:, :2] -= moved.positions[moved.numbers == 0][0, :2]
    moved.cell[:] = 0.0
    moved.pbc = False
    return _with_energy_of(atoms, moved)


def with_columns(atoms: Atoms, indenter: Surface | None = None) -> Atoms:
    """Return a frame with pressure, contact and gap as named arrays.

    ``write("sweep.extxyz", frames)`` stores them; OVITO reads them as particle
    properties, and `ase gui` can colour by them. A ``.traj`` file does not store them.

    Parameters
    ----------
    atoms : Atoms
        With a `RoughContact` calculator, or a frame from `snapshot`.
    indenter : Surface, optional
        The indenter of a frame, from whose heights the gap follows; by default that of
        the calculator.

    Returns
    -------
    Atoms
        With the arrays ``pressure`` (GPa), ``contact`` (1 or 0) and, if the indenter is
        known, ``gap`` (Å), all of them zero for the indenter.
    """
    indenter = _indenter_of(atoms) if indenter is None else indenter
    frame = _frame(atoms)
    pressure = pressure_of(frame).ravel()
    columns = _with_energy_of(frame, frame.copy())
    columns.set_array("pressure", np.append(pressure / GPa, 0.0))
    columns.set_array("contact", np.append(pressure > 0.0, False).astype(int))
    if indenter is not None:
        above = surface_above(frame, SurfaceGrid.of(frame), indenter)
        columns.set_array("gap", np.append(above - frame.positions[:-1, 2], 0.0))
    return columns


def _frame(atoms: Atoms) -> Atoms:
    """Return a snapshot of atoms with a calculator, or the frame itself."""
    return snapshot(atoms) if isinstance(atoms.calc, RoughContact) else atoms


def _indenter_of(atoms: Atoms) -> Surface | None:
    """Return the indenter of the calculator, if there is one."""
    if isinstance(atoms.calc, RoughContact):
        return atoms.calc.parameters["indenter"]
    return None


def _every_row(grid: SurfaceGrid, every: int) -> np.ndarray:
    """Return the mask of every n-th row of surface atoms along x and y."""
    every = integer("every", every, 1)
    i, j = np.indices(grid.shape)
    return ((i % every == 0) & (j % every == 0)).ravel()


def _with_energy_of(frame: Atoms, atoms: Atoms) -> Atoms:
    """Attach the energy of a frame to atoms."""
    if frame.calc is not None:
        energy = frame.get_potential_energy(apply_constraint=False)
        atoms.calc = SinglePointCalculator(atoms, energy=energy)
    return atoms
