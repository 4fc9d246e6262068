"""The substrate as ASE Atoms: surface atoms on a square lattice, and the indenter.

The surface atoms come first, row by row along y: atom ``i*M + j`` of an N x M grid is
at ``(x0 + i a0, y0 + j a0, u)``, where z is the displacement u. The last atom, of
symbol X, is the indenter: its z is the indenter's height, its x and y are the position
of the indenter's axis. The cell is the window of atoms that may touch the indenter. The
atoms outside the window are the padding of a free half space, which does not interact
with the indenter and may be left out.
"""

from __future__ import annotations

import math

import numpy as np
from ase import Atoms
from ase.constraints import FixAtoms, Hookean
from ase.data import atomic_numbers

from ase_roughcontact._util.callers import warn
from ase_roughcontact._util.keywords import suggesting
from ase_roughcontact._util.validation import (
    boolean,
    finite,
    grid_shape,
    positive,
    surface,
)
from ase_roughcontact.atoms.grid import SurfaceGrid
from ase_roughcontact.atoms.info import BY_PATH, INDENTER_KEY, SUPPORT_KEY
from ase_roughcontact.atoms.marks import marked_fields, set_mark
from ase_roughcontact.atoms.sticking import indenter_fixed
from ase_roughcontact.elasticity.material import check_element, fcc_spacing
from ase_roughcontact.topography import Surface
from ase_roughcontact.topography.base import surface_id
from ase_roughcontact.topography.topography import Topography, topography_of


@suggesting
def substrate(
    symbol: str,
    shape: tuple[int, int],
    indenter: Surface,
    *,
    spacing: float | None = None,
    periodic: bool = False,
    height: float | None = None,
    center: tuple[float, float] = (0.0, 0.0),
    fixed: bool | None = None,
) -> Atoms:
    """Build the surface atoms and the indenter above them.

    Parameters
    ----------
    symbol : str
        Chemical symbol of the substrate. For a crystal of fcc or diamond structure it
        sets the spacing ``a0 = a/sqrt(2)``, the distance of neighbours in its (100)
        surface.
    shape : (int, int)
        Number of atoms ``(n, m)`` that may touch the indenter: the window.
    indenter : Surface
        `RoughSphere`, `SelfAffine`, `HeightMap` or any object with their method
        `heights` and, so that files and checks can name it, `todict`.
    spacing : float, optional
        Distance of neighbours (Å), in place of the crystal's spacing.
    periodic : bool
        Periodic half space (pbc in x and y) instead of a free one. A free half space is
        built with its padding, which makes about four times as many atoms.
    height : float, optional
        Height Z of the indenter (Å); by default its lowest point is one spacing
        above the substrate, where a bulk-matched wall begins to repel.
    center : (float, float)
        Position of the window's centre relative to the indenter's axis (Å), rounded
        to whole spacings.
    fixed : bool, optional
        Fix the indenter (displacement control), or leave it free to move along z (load
        control, cantilever). By default the indenter is fixed until a path needs a free
        one, and paths fix and free it as they need.

    Returns
    -------
    Atoms
        The surface atoms, then the indenter (symbol X). `Atoms.info` identifies the
        surface of the indenter under "indenter", which the calculator compares with its
        own.

    Raises
    ------
    ValueError
        If the symbol has no fcc or diamond reference and no spacing is given, or a
        number is not finite or not positive, or the heights of the indenter are not
        finite real numbers.
    MemoryError
        If the window does not fit into the memory.

    Warns
    -----
    UserWarning
        If the heights of a flat indenter jump at the edges of a periodic cell, because
        its sides are not the periods of the indenter.

    Examples
    --------
    >>> from ase_roughcontact import RoughSphere, substrate
    >>> atoms = substrate('Cu', (8, 8), RoughSphere(radius=100.0))
    >>> len(atoms), atoms.symbols[0], atoms.symbols[-1]
    (226, 'Cu', 'X')
    """
    n, m = grid_shape(shape)
    check_element(symbol)
    surface(indenter=indenter)
    boolean(periodic=periodic, fixed=True if fixed is None else fixed)
    a0 = fcc_spacing(symbol) if spacing is None else spacing
    positive(spacing=a0)
    if np.shape(center) != (2,):
        raise ValueError(f"center must be two numbers (x, y), got {center!r}")
    finite(center_x=center[0], center_y=center[1])
    x, y = (a0 * (round(c / a0) - k // 2) for c, k in zip(center, (n, m), strict=True))
    padded = SurfaceGrid.padded_shape((n, m), periodic)
    grid = SurfaceGrid((n, m), padded, a0, (float(x), float(y)), periodic)
    try:
        if height is None:
            height = a0 - float(grid.heights(indenter).min())
        finite(height=height)
        atoms = grid.atoms(atomic_numbers[symbol], height)
    except MemoryError as error:
        raise MemoryError(
            f"a window of {n} x {m} atoms does not fit into the memory: give a smaller "
            "shape, and window='auto' to load_path"
        ) from error
    topography = topography_of(indenter)
    if periodic and topography.apex_radius == math.inf:
        _check_period(topography, (n, m), a0)
    if fixed is None:
        atoms.info[SUPPORT_KEY] = BY_PATH
        fixed = True
    return supported(atoms, indenter, fixed)


def supported(atoms: Atoms, indenter: Surface, fixed: bool) -> Atoms:
    """Return atoms with the name of the indenter and its constraint; in place."""
    identity = surface_id(indenter)
    if identity is not None:
        atoms.info[INDENTER_KEY] = identity
    if fixed:
        atoms.set_constraint(FixAtoms([len(atoms) - 1]))
    set_mark(atoms, fields=0)
    return atoms


def set_support(atoms: Atoms, fixed: bool) -> None:
    """Fix or free the indenter, in place, if `substrate` has left that to paths.

    Parameters
    ----------
    atoms : Atoms
        Substrate and indenter. An indenter on springs stays free.
    fixed : bool
        Whether the path needs a fixed indenter.
    """
    if atoms.info.get(SUPPORT_KEY) != BY_PATH or indenter_fixed(atoms) == fixed:
        return
    last, held = len(atoms) - 1, list(atoms.constraints)
    if not fixed:
        kept = [each for each in held if not _fixes_only(each, last)]
    elif any(isinstance(each, Hookean) for each in held):
        kept = held
    else:
        kept = [*held, FixAtoms([last])]
    atoms.set_constraint(kept)
    set_mark(atoms, marked_fields(atoms))


def _fixes_only(constraint: object, atom: int) -> bool:
    """Return whether a constraint fixes one atom and no other."""
    if not isinstance(constraint, FixAtoms):
        return False
    return bool(np.array_equal(constraint.get_indices(), [atom]))


def _check_period(indenter: Topography, shape: tuple[int, int], spacing: float) -> None:
    """Warn if a flat indenter does not continue across the edges of a periodic cell."""
    sides = spacing * np.array(shape)
    if indenter.part_of_period(sides) < 1.0:
        (x, y), points = sides, [round(side / spacing, 6) for side in indenter.periods]
        warn(
            f"the periodic cell of {x:g} x {y:g} Å is smaller than the period of the "
            f"indenter, {indenter.periods[0]:g} x {indenter.periods[1]:g} Å, and "
            "heights jump at its edges: give a shape of "
            f"{points[0]:g} x {points[1]:g} spacings"
        )
