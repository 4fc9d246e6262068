"""Frames to look at: the indenter made visible, fewer atoms, named columns.

The results are copies for `ase gui`, OVITO and other viewers, not to calculate with.
"""

from __future__ import annotations

import numpy as np
from ase import Atoms
from ase.calculators.singlepoint import SinglePointCalculator
from ase.data import atomic_numbers

from ase_roughcontact._util.validation import integer
from ase_roughcontact.atoms.build import TAG_CONTACT, snapshot
from ase_roughcontact.atoms.grid import SurfaceGrid, surface_above
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
    """Show the indenter's surface as atoms above those of the substrate.

    Parameters
    ----------
    atoms : Atoms
        With a `RoughContact` calculator, or a frame as `snapshot` made it.
    indenter : Surface, optional
        The indenter; by default that of the calculator. A frame from a file needs it.
    symbol : str
        Element of the new atoms, and so their colour and size.
    every : int
        Show one row of atoms in so many, of substrate and indenter; see `thinned`.
    half : bool
        Show only the half of the indenter that is towards positive y, and so the
        contact below the other one.

    Returns
    -------
    Atoms
        The window, the indenter (symbol X), and an atom of the indenter's surface above
        each of the window's, with tag 3. The distance between the two is the gap.

    Raises
    ------
    ValueError
        If there is no indenter, the symbol is unknown, or `every` is less than one.
    """
    if symbol not in atomic_numbers:
        raise ValueError(f"unknown chemical symbol {symbol!r}")
    indenter = _indenter_of(atoms) if indenter is None else indenter
    if indenter is None:
        raise ValueError("the atoms don't tell their indenter: give indenter=")
    frame = _frame(atoms)
    layout = SurfaceGrid.of(frame)
    places = frame.positions[:-1].copy()
    places[:, 2] = surface_above(frame, layout, indenter)
    places = places[_kept(layout, every)] / every
    if half:
        middle = 0.5 * (places[:, 1].min() + places[:, 1].max())
        places = places[places[:, 1] >= middle]
    sphere = Atoms([symbol] * len(places), places)
    sphere.set_tags(TAG_INDENTER)
    return _with_energy_of(frame, thinned(frame, every) + sphere)


def thinned(atoms: Atoms, every: int) -> Atoms:
    """Show one row of atoms in so many, along x and y, and the indenter.

    In large windows an atom is smaller than a pixel, and viewers are slow: `ase gui`
    opens one of 512 x 512 atoms in 7 s, and with ``every=4`` in 0.6 s.

    Parameters
    ----------
    atoms : Atoms
        With a `RoughContact` calculator, or a frame as `snapshot` made it.
    every : int
        How many. All lengths are divided by it, so that the atoms that are left look
        like neighbours.

    Returns
    -------
    Atoms

    Raises
    ------
    ValueError
        If `every` is less than one.
    """
    frame = _frame(atoms)
    shown = frame[np.append(_kept(SurfaceGrid.of(frame), every), True)]
    shown.positions /= every
    shown.cell /= every
    return _with_energy_of(frame, shown)


def centred(atoms: Atoms) -> Atoms:
    """Put the indenter's axis at x = y = 0, and leave the cell out.

    The frames of a path with automatic windows begin at the corners of their windows:
    in a movie the contact jumps.

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
    """Give pressure, contact and gap columns of their own, by name.

    ``write("sweep.extxyz", frames)`` keeps them; OVITO reads them as particle
    properties, and `ase gui` colours by them. A ``.traj`` file does not keep them.

    Parameters
    ----------
    atoms : Atoms
        With a `RoughContact` calculator, or a frame as `snapshot` made it.
    indenter : Surface, optional
        The indenter of a frame, from whose heights the gap follows. Atoms with a
        calculator don't need it.

    Returns
    -------
    Atoms
        With the arrays ``pressure`` (GPa), ``contact`` (1 or 0) and, if the indenter is
        known, ``gap`` (Å); all are zero at the indenter.
    """
    indenter = _indenter_of(atoms) if indenter is None else indenter
    frame = _frame(atoms)
    told = _with_energy_of(frame, frame.copy())
    told.set_array("pressure", frame.get_initial_charges())
    told.set_array("contact", (frame.get_tags() == TAG_CONTACT).astype(int))
    if indenter is not None:
        gap = (
            surface_above(frame, SurfaceGrid.of(frame), indenter)
            - frame.positions[:-1, 2]
        )
        told.set_array("gap", np.append(gap, 0.0))
    return told


def _frame(atoms: Atoms) -> Atoms:
    """Frame of atoms with a calculator, or the frame that they are."""
    return snapshot(atoms) if hasattr(atoms.calc, "state") else atoms


def _indenter_of(atoms: Atoms) -> Surface | None:
    """Return the indenter of a calculator."""
    return atoms.calc.parameters["indenter"] if hasattr(atoms.calc, "state") else None


def _kept(layout: SurfaceGrid, every: int) -> np.ndarray:
    """Which surface atoms are shown."""
    every = integer("every", every, 1)
    i, j = np.indices(layout.grid)
    return ((i % every == 0) & (j % every == 0)).ravel()


def _with_energy_of(frame: Atoms, atoms: Atoms) -> Atoms:
    """Atoms that tell the energy of a frame."""
    if frame.calc is not None:
        energy = frame.get_potential_energy(apply_constraint=False)
        atoms.calc = SinglePointCalculator(atoms, energy=energy)
    return atoms
