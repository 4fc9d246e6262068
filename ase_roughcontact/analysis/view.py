"""Frames for viewers, with the indenter cut open or with named columns.

The results are copies for `ase gui`, OVITO and other viewers. They are not meant for
calculations.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from os import PathLike
from typing import Any

import numpy as np
from ase import Atoms
from ase.calculators.singlepoint import SinglePointCalculator
from ase.data import atomic_numbers, covalent_radii
from ase.io import iread
from ase.units import GPa

from ase_roughcontact._util.validation import FloatArray, instance_of, integer
from ase_roughcontact.analysis.contact_map import ContactMap
from ase_roughcontact.atoms.calculator import RoughContact
from ase_roughcontact.atoms.grid import SurfaceGrid, surface_above
from ase_roughcontact.atoms.snapshot import snapshot
from ase_roughcontact.contact.state import PLASTIC_DEPTH, SLIPPING, TRACTIONS
from ase_roughcontact.topography import Surface

#: Tag of the atoms of the indenter.
TAG_INDENTER = 3
#: Element of atoms in contact, purple in viewers.
CONTACT = "I"
#: Element of attracted atoms, light blue in viewers.
ATTRACTED = "Kr"
#: Element of the indenter's atoms, bluish grey in viewers.
INDENTER = "Hg"
#: Element of atoms in contact that slip, green in viewers.
SLIPS = "Cl"

# Distance of neighbours in covalent radii, at which circles overlap in viewers.
_NEIGHBOUR_DISTANCE = 1.5
# Radius of the indenter relative to half the longer side of the window.
_RELATIVE_RADIUS = 0.85
# Height of the dome relative to the radius of the indenter.
_DOME_HEIGHT = 0.8
# Range of heights relative to the diameter of the indenter.
_RELATIVE_RANGE = 0.15
# Fraction of the atoms in contact in front of the plane that cuts the indenter.
_VISIBLE_FRACTION = 0.7


def with_indenter(
    atoms: Atoms, indenter: Surface | None = None, *, rows: int = 48
) -> Atoms:
    """Return a frame for `ase gui`: the contact in colour, the indenter cut open.

    Parameters
    ----------
    atoms : Atoms
        Atoms with a `RoughContact` calculator, or a frame from `snapshot`.
    indenter : Surface, optional
        Shape of the indenter, by default the calculator's; required for frames from a
        file.
    rows : int
        Largest number of rows of surface atoms along a side. From a larger window,
        every n-th row is taken.

    Returns
    -------
    Atoms
        Surface atoms, the indenter (symbol X) at x = y = 0, and atoms with tag 3 for
        the part of the indenter behind a plane through the contact: its lower surface
        above the window, closed by a dome. Atoms in contact, attracted atoms, and atoms
        in contact that slip have the elements `CONTACT`, `ATTRACTED` and `SLIPS`.
        Lengths are scaled to the size of circles in viewers, and heights further, since
        a contact is far wider than deep. The keys of `info` are the factors
        ``horizontal_scale`` and ``vertical_scale``, the normal force and the contact
        area. There is no energy: positions are scaled, and `ase gui` would draw
        energies over the atoms.

    Raises
    ------
    ValueError
        If there is no indenter, the frame has another one, or `rows` is less than two.
    """
    frame, indenter = _read(atoms, indenter)
    if indenter is None:
        raise ValueError("the atoms have no RoughContact calculator: give indenter=")
    contact_map = ContactMap.from_frame(frame)
    grid = SurfaceGrid.of(frame)
    every = math.ceil(max(grid.shape) / integer("rows", rows, 2))
    chosen = tuple(slice(min(every, n) // 2, None, every) for n in grid.shape)
    index = np.arange(len(frame) - 1).reshape(grid.shape)[chosen]
    axis = frame.positions[-1].copy()
    axis[2] = frame.positions[index, 2].min()
    lower = frame.positions[index] - axis
    upper = lower.copy()
    upper[..., 2] = surface_above(frame, grid, indenter)[chosen] - axis[2]

    view = frame[index.ravel()]
    step = every * grid.spacing
    radius = 0.5 * _RELATIVE_RADIUS * (max(index.shape) - 1) * step + 0.6 * step
    inside = _from_middle(upper) <= radius
    # vertical sides, as of a punch, are as high as the body is wide
    upper[..., 2] = np.minimum(upper[..., 2], radius)
    horizontal = _NEIGHBOUR_DISTANCE * covalent_radii[view.numbers[0]] / step
    height, steepness = float(upper[inside, 2].max()), 1.0
    if height > 0.0:  # not a flat punch on a flat surface
        steepness = max(1.0, 2.0 * _RELATIVE_RANGE * radius / height)
    scale = np.array([horizontal, horizontal, horizontal * steepness])
    contact = contact_map.contact
    slips = contact & (contact_map.lateral.get(SLIPPING, np.zeros(1)) > 0.0)
    cut = _plane(contact[chosen])
    body = _body(upper * scale, inside, radius * horizontal, step * horizontal, cut)

    view.positions = (lower * scale).reshape(-1, 3)
    attracted = contact_map.pressure < 0.0
    # later elements replace earlier ones
    for symbol, mask in ((ATTRACTED, attracted), (CONTACT, contact), (SLIPS, slips)):
        view.numbers[mask[chosen].ravel()] = atomic_numbers[symbol]
    view += Atoms("X", [[0.0, 0.0, (frame.positions[-1, 2] - axis[2]) * scale[2]]])
    view += Atoms([INDENTER] * len(body), body, tags=[TAG_INDENTER] * len(body))
    view.info = {
        "normal_force": frame.info["normal_force"],
        "contact_area": frame.info["contact_area"],
        "horizontal_scale": horizontal,
        "vertical_scale": horizontal * steepness,
    }
    view.cell[:] = 0.0
    view.pbc = False
    return view


def view_frames(
    frames: str | PathLike[str] | Atoms | Iterable[Atoms],
    calculator: RoughContact,
    *,
    rows: int = 48,
) -> list[Atoms]:
    """Return frames for `ase gui` from a trajectory of an optimizer of ASE.

    Trajectories of optimizers have positions and forces, but no pressures. They are
    calculated again, at the cost of one evaluation of the energy for each frame.

    Parameters
    ----------
    frames : str, path, Atoms or iterable of Atoms
        Trajectory file, such as ``FIRE(atoms, trajectory="fire.traj")`` writes, or some
        of its frames; ``"fire.traj@::10"`` reads every tenth.
    calculator : RoughContact
        Calculator of the atoms that were relaxed.
    rows : int
        Largest number of rows of atoms, see `with_indenter`.

    Returns
    -------
    list of Atoms
        A frame of `with_indenter` for each frame, for `ase.io.write` and
        `ase.visualize.view`.

    Raises
    ------
    ValueError
        If the frames do not fit the calculator: they have another indenter, or their
        surface keeps something of earlier steps, which trajectories lose.
    """
    instance_of(RoughContact, calculator=calculator)
    images: Any = frames
    if isinstance(frames, Atoms):
        images = [frames]
    elif isinstance(frames, (str, PathLike)):
        images = iread(frames)
    # its own results and neighbours of the user's calculator stay
    model = RoughContact(**calculator.parameters)
    shown = []
    for frame in images:
        atoms = frame.copy()
        atoms.calc = model
        shown.append(with_indenter(atoms, rows=rows))
    return shown


def _plane(contact: np.ndarray) -> int:
    """Return the column of a plane behind most of the contact, or in the middle."""
    count = contact.sum(axis=0).cumsum()
    if not count[-1]:
        return contact.shape[1] // 2
    return int(np.searchsorted(count, _VISIBLE_FRACTION * count[-1]))


def _body(
    lower: FloatArray, inside: np.ndarray, radius: float, step: float, cut: int
) -> FloatArray:
    """Return the rear part of a body with a lower side and a dome.

    Parameters
    ----------
    lower : ndarray, shape (n, m, 3)
        Points of the lower side.
    inside : ndarray of bool, shape (n, m)
        Whether each point is less than `radius` from the middle.
    radius : float
        Radius of the dome (length).
    step : float
        Distance of points (length).
    cut : int
        Column of the points in the plane that cuts the body.

    Returns
    -------
    ndarray, shape (k, 3)
        Points of the lower side, the dome and the plane of the cut.
    """
    dome = np.sqrt(np.maximum(radius**2 - _from_middle(lower) ** 2, 0.0))
    upper = lower.copy()
    upper[..., 2] = lower[inside, 2].max() + _DOME_HEIGHT * dome
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
        Atoms with a `RoughContact` calculator, or a frame from `snapshot`.
    indenter : Surface, optional
        Shape of the indenter, required for the gap; by default the calculator's.

    Returns
    -------
    Atoms
        Copy with the arrays ``pressure`` (GPa), ``contact`` (1 or 0),
        ``plastic_depth`` (Å) if the wall has a hardness, the fields of
        `ContactMap.lateral` (GPa, Å) and, if there is an indenter, ``gap`` (Å). All
        arrays are zero for the indenter.
    """
    frame, indenter = _read(atoms, indenter)
    contact_map = ContactMap.from_frame(frame, indenter)
    fields = {
        "pressure": contact_map.pressure / GPa,
        "contact": contact_map.contact.astype(int),
        PLASTIC_DEPTH: contact_map.plastic_depth,
        "gap": contact_map.gap,
    }
    for key, values in contact_map.lateral.items():
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
    """Return frame and indenter, of the calculator if the atoms have one."""
    if not isinstance(atoms.calc, RoughContact):
        return atoms, indenter
    if indenter is None:
        indenter = atoms.calc.parameters["indenter"]
    return snapshot(atoms), indenter
