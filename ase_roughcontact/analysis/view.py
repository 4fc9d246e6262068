"""Frames for viewers: the indenter cut open above the contact, and named columns.

The results are copies for `ase gui`, OVITO and other viewers. They are not meant for
calculations.
"""

from __future__ import annotations

import math

import numpy as np
from ase import Atoms
from ase.calculators.singlepoint import SinglePointCalculator
from ase.data import atomic_numbers, covalent_radii
from ase.units import GPa

from ase_roughcontact._util.validation import FloatArray, integer
from ase_roughcontact.analysis.contact_map import ContactMap
from ase_roughcontact.atoms.calculator import RoughContact
from ase_roughcontact.atoms.grid import SurfaceGrid, surface_above
from ase_roughcontact.atoms.snapshot import snapshot
from ase_roughcontact.contact.state import PLASTIC_DEPTH, SLIPPING, TRACTIONS
from ase_roughcontact.topography import Surface

#: Tag of the atoms that show the indenter.
TAG_INDENTER = 3
#: Elements of which no solid is made, whose colours in viewers (purple, light blue,
#: bluish grey and green) show what an atom is.
CONTACT, ATTRACTED, INDENTER, SLIPS = "I", "Kr", "Hg", "Cl"

# Distance of neighbours in covalent radii; circles overlap in viewers.
_NEIGHBOURS = 1.5
# Radius of the indenter relative to half the longer side of the window, height of the
# dome relative to this radius, and range of heights relative to its diameter.
_BODY, _DOME, _RANGE = 0.85, 0.8, 0.15
# Share of the atoms in contact in front of the plane in which the indenter is cut.
_VISIBLE = 0.7


def with_indenter(
    atoms: Atoms, indenter: Surface | None = None, *, rows: int = 48
) -> Atoms:
    """Return a frame for `ase gui`: the contact in colour, the indenter cut open.

    Parameters
    ----------
    atoms : Atoms
        With a `RoughContact` calculator, or a frame from `snapshot`.
    indenter : Surface, optional
        The indenter; by default that of the calculator. Frames from a file need it.
    rows : int
        Largest number of rows of surface atoms along a side. Of larger windows every
        n-th row is shown.

    Returns
    -------
    Atoms
        Surface atoms, the indenter (symbol X) at x = y = 0, and atoms with tag 3 for
        the part of it behind a plane through the contact. Its lower side is the surface
        above the window, the dome on it closes it. Atoms in contact, attracted atoms,
        and those in contact that slip have the elements `CONTACT`, `ATTRACTED` and
        `SLIPS`. Lengths are scaled to the size of
        circles in viewers, and heights further, since a contact is far wider than deep;
        `info` has the factors ``horizontal_scale`` and ``vertical_scale``, the normal
        force and the contact area, and nothing else. There is no energy: positions are
        scaled, and `ase gui` would draw it over the atoms.

    Raises
    ------
    ValueError
        If there is no indenter, or it is not that of the frame, or `rows` is less than
        two.
    """
    frame, indenter = _read(atoms, indenter)
    if indenter is None:
        raise ValueError("the atoms have no calculator that knows it: give indenter=")
    grid = SurfaceGrid.of(frame)
    every = math.ceil(max(grid.shape) / integer("rows", rows, 2))
    chosen = tuple(slice(min(every, n) // 2, None, every) for n in grid.shape)
    index = np.arange(len(frame) - 1).reshape(grid.shape)[chosen]
    axis = frame.positions[-1].copy()
    axis[2] = frame.positions[index, 2].min()
    lower = frame.positions[index] - axis
    upper = lower.copy()
    upper[..., 2] = surface_above(frame, grid, indenter)[chosen] - axis[2]

    shown = frame[index.ravel()]
    step = every * grid.spacing
    radius = 0.5 * _BODY * (max(index.shape) - 1) * step + 0.6 * step
    inside = _from_middle(upper) <= radius
    horizontal = _NEIGHBOURS * covalent_radii[shown.numbers[0]] / step
    steepness = max(1.0, 2.0 * _RANGE * radius / upper[inside, 2].max())
    scale = np.array([horizontal, horizontal, horizontal * steepness])
    seen = ContactMap.from_frame(frame)
    contact = seen.contact
    slips = contact & (seen.lateral.get(SLIPPING, np.zeros(1)) > 0.0)
    cut = _plane(contact[chosen])
    body = _body(upper * scale, inside, radius * horizontal, step * horizontal, cut)

    shown.positions = (lower * scale).reshape(-1, 3)
    kinds = (ATTRACTED, seen.pressure < 0.0), (CONTACT, contact), (SLIPS, slips)
    for symbol, mask in kinds:  # the last one holds
        shown.numbers[mask[chosen].ravel()] = atomic_numbers[symbol]
    shown += Atoms("X", [[0.0, 0.0, (frame.positions[-1, 2] - axis[2]) * scale[2]]])
    shown += Atoms([INDENTER] * len(body), body, tags=[TAG_INDENTER] * len(body))
    shown.info = {key: frame.info[key] for key in ("normal_force", "contact_area")} | {
        "horizontal_scale": horizontal,
        "vertical_scale": horizontal * steepness,
    }
    shown.cell[:] = 0.0
    shown.pbc = False
    return shown


def _plane(contact: np.ndarray) -> int:
    """Return the column of a plane behind most of the contact, or in the middle."""
    count = contact.sum(axis=0).cumsum()
    middle = contact.shape[1] // 2
    return int(np.searchsorted(count, _VISIBLE * count[-1])) if count[-1] else middle


def _body(
    lower: FloatArray, inside: np.ndarray, radius: float, step: float, cut: int
) -> FloatArray:
    """Return the rear part of a body with a lower side and a dome.

    Parameters
    ----------
    lower : ndarray, shape (n, m, 3)
        Points of the lower side.
    inside : ndarray of bool, shape (n, m)
        Which of them are less than `radius` from the middle.
    radius : float
        Of the dome.
    step : float
        Distance of points.
    cut : int
        Column of the points in the plane in which the body is cut.

    Returns
    -------
    ndarray, shape (k, 3)
        Points of the lower side, the dome and the plane of the cut.
    """
    dome = np.sqrt(np.maximum(radius**2 - _from_middle(lower) ** 2, 0.0))
    upper = lower.copy()
    upper[..., 2] = lower[inside, 2].max() + _DOME * dome
    half = inside[:, cut:]
    plane = [
        np.linspace(start, end, math.ceil((end[2] - start[2]) / (0.8 * step)) + 1)
        for start, end in zip(
            lower[inside[:, cut], cut], upper[inside[:, cut], cut], strict=True
        )
    ]
    return np.concatenate([*plane, lower[:, cut:][half], upper[:, cut:][half]])


def _from_middle(points: FloatArray) -> FloatArray:
    """Return the horizontal distance of points, shape (n, m, 3), from their middle."""
    x, y, _ = np.moveaxis(points - points.mean((0, 1)), -1, 0)
    return np.hypot(x, y)


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
        With the arrays ``pressure`` (GPa), ``contact`` (1 or 0), ``plastic_depth`` (Å)
        of a wall with a hardness, those of `ContactMap.lateral` (GPa, Å) and, if the
        indenter is known, ``gap`` (Å), all of them zero for the indenter.
    """
    frame, indenter = _read(atoms, indenter)
    seen = ContactMap.from_frame(frame, indenter)
    fields = {
        "pressure": seen.pressure / GPa,
        "contact": seen.contact.astype(int),
        PLASTIC_DEPTH: seen.plastic_depth,
        "gap": seen.gap,
    }
    for key, values in seen.lateral.items():
        fields[key] = values / GPa if key in TRACTIONS else values
    columns = frame.copy()
    if frame.calc is not None:
        energy = frame.get_potential_energy(apply_constraint=False)
        columns.calc = SinglePointCalculator(columns, energy=energy)
    for key, field in fields.items():
        if field is not None:
            columns.set_array(key, np.append(field, np.zeros(1, field.dtype)))
    return columns


def _read(atoms: Atoms, indenter: Surface | None) -> tuple[Atoms, Surface | None]:
    """Return frame and indenter: of atoms with a calculator, or those given."""
    if not isinstance(atoms.calc, RoughContact):
        return atoms, indenter
    known = atoms.calc.parameters["indenter"]
    return snapshot(atoms), known if indenter is None else indenter
