"""Snapshots: the window and the indenter as a frame that files can hold.

What a file must carry is in the `info` of a frame. Tags and initial charges only colour
the atoms in viewers.
"""

from __future__ import annotations

import binascii
import math
import zlib
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from ase import Atoms
from ase.calculators.singlepoint import SinglePointCalculator
from ase.constraints import FixAtoms
from ase.units import GPa

from ase_roughcontact._util.validation import instance_of
from ase_roughcontact.atoms.calculator import model_of
from ase_roughcontact.atoms.grid import SurfaceGrid, displacement, set_displacement
from ase_roughcontact.atoms.history import (
    check_history,
    creep_of,
    history_of,
    set_history,
)
from ase_roughcontact.atoms.info import (
    HISTORY,
    INDENTED,
    INDENTER_KEY,
    LATTICE,
    PAST_DEPTH,
    PRESSURE,
    TOUCHING,
    as_text,
    field_of,
    info_of,
)
from ase_roughcontact.atoms.marks import TAG_KEPT
from ase_roughcontact.atoms.sticking import STICKS, sticking_of
from ase_roughcontact.contact import ContactState
from ase_roughcontact.contact.history import entry_of, is_entry
from ase_roughcontact.contact.state import DISPLACEMENTS, PLASTIC_DEPTH, SLIPPING
from ase_roughcontact.elasticity.greens import ElasticSolid
from ase_roughcontact.elasticity.reduced import ReducedHalfSpace

# Tags of the atoms of a snapshot; 3 is the tag of the indenter in a view.
#: Tag of an atom without pressure.
TAG_OPEN = 0
#: Tag of an atom in contact.
TAG_CONTACT = 1
#: Tag of an attracted atom.
TAG_ATTRACTED = 2
#: Tag of an atom in contact with the pressure of the hardness.
TAG_PLASTIC = 4
#: Tag of an atom in contact that slips.
TAG_SLIPPING = 5


def snapshot(atoms: Atoms, **info: Any) -> Atoms:
    """Return a copy of window and indenter, with results that survive in a file.

    Parameters
    ----------
    atoms : Atoms
        Atoms with a `RoughContact` calculator.
    **info
        Numbers and strings to be stored with the frame.

    Returns
    -------
    Atoms
        Energy, energies and forces, under friction also minus the lateral force on the
        indenter, are in a `SinglePointCalculator`. Its `info` has the normal force
        (eV/Å), the contact area (Å^2), under friction the lateral force (eV/Å),
        compressed fields, which `analysis.ContactMap.from_frame` reads, the pressures
        also `pressure_of`, and `info`. For viewers, tags are 1 for atoms in contact, 4
        for atoms in plastic contact, 5 for atoms that slip, 2 for atoms under
        attraction and 0 for all others, and initial charges are the pressures in GPa.
        The arrays ``contact`` (1 or 0), ``pressure`` (GPa) and ``gap`` (Å) of all atoms
        become columns of .extxyz files, by which OVITO colours them.
        The tag of the indenter is 6 if the surface keeps fields of earlier steps.

    Raises
    ------
    ValueError
        If the atoms have no `RoughContact` calculator, or have lost what their surface
        keeps of earlier steps.
    TypeError
        If they are no atoms.

    Notes
    -----
    The formats .traj and .extxyz keep `info`. ASE's databases (.db, .json) keep it as
    the data of a row: write it by ``database.write(frame, data=frame.info)`` and read
    it by ``database.get_atoms(id, add_additional_information=True)``.
    """
    model = model_of(atoms)
    grid = model.grid
    state = atoms.calc.state(atoms)
    in_frame = np.append(grid.in_window, True)
    frame = atoms[in_frame]
    history = history_of(atoms, grid)
    for key in history:
        frame.arrays.pop(key, None)
    fields, found = fields_and_info(state, history)
    results, sticking = atoms.calc.results, sticking_of(atoms)
    forces = results["forces"].copy()
    if sticking is not None:
        forces[sticking.index, :2] = 0.0  # the indenter has them
    if SLIPPING in history:
        lateral_force = atoms.calc.get_property("lateral_force", atoms)
        found["lateral_force"] = lateral_force.tolist()
        frame.info[LATTICE] = frame.info[LATTICE] | {"shape": list(grid.window)}
        frame.info[LATTICE].pop(STICKS, None)
        forces[-1, :2] = -lateral_force
    frame.set_array("tags", None)  # of another type of integer
    tags = tags_of(state, history).ravel()
    frame.set_tags(np.append(tags, TAG_KEPT if history else TAG_OPEN))
    frame.set_initial_charges(np.append(state.pressure / GPa, 0.0))
    frame.set_array("contact", np.append(state.contact, False).astype(int))
    frame.set_array("pressure", np.append(state.pressure / GPa, 0.0))
    frame.set_array("gap", np.append(state.gap, 0.0))
    depth = model.contact.past_depth
    if depth is not None:
        fields[PAST_DEPTH] = depth
        frame.positions[:-1, 2] -= depth.ravel()
    frame.info.update(**found, **info)
    frame.info.update({key: as_text(values) for key, values in fields.items()})
    frame.calc = SinglePointCalculator(
        frame,
        energy=results["energy"],
        energies=results["energies"][in_frame],
        forces=forces[in_frame],
    )
    return frame


def fields_and_info(
    state: ContactState, history: Mapping[str, np.ndarray]
) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Return what a frame has of a contact and of the history of its surface.

    Parameters
    ----------
    state : ContactState
    history : mapping of str to ndarray of shape (n, m)
        See `State.history`.

    Returns
    -------
    fields : dict of ndarray, shape (n, m)
        Fields on the window by name, but for the lateral displacements.
    info : dict
        Entries of the `info` of the frame.
    """
    as_positions = (PLASTIC_DEPTH, *DISPLACEMENTS)
    fields = {key: each for key, each in history.items() if key not in as_positions}
    fields[PRESSURE] = state.pressure
    info: dict[str, Any] = {
        "normal_force": state.normal_force,
        "contact_area": state.contact_area,
    }
    if state.hardness < math.inf:
        fields[PLASTIC_DEPTH] = state.plastic_depth
        info[INDENTED] = PLASTIC_DEPTH in history
    if state.touching is not None:
        fields[TOUCHING] = state.touching
    if history:
        info[HISTORY] = list(history)
    return fields, info


def tags_of(state: ContactState, history: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return the tags of the surface atoms of a frame, shape (n, m); see `snapshot`."""
    slips = state.contact & (history.get(SLIPPING, 0.0) > 0.0)
    return np.select(
        [slips, state.plastic, state.contact, state.pressure < 0.0],
        [TAG_SLIPPING, TAG_PLASTIC, TAG_CONTACT, TAG_ATTRACTED],
        TAG_OPEN,
    )


def is_in_trajectories(field: str) -> bool:
    """Return whether the frames of trajectories have a field of a snapshot."""
    if is_entry(field):
        return entry_of(field).in_frames
    return field in (PRESSURE, TOUCHING)


def pressure_of(frame: Atoms) -> np.ndarray:
    """Return the pressure of a snapshot.

    Parameters
    ----------
    frame : Atoms
        Frame from `snapshot`, also read back from a file.

    Returns
    -------
    ndarray, shape (n, m)
        Pressure of the wall, positive in compression (eV/Å^3).

    Raises
    ------
    ValueError
        If the frame has no pressures in its `info`.
    """
    instance_of(Atoms, frame=frame)
    try:
        return field_of(frame, PRESSURE, SurfaceGrid.of(frame).window)
    except (KeyError, TypeError, ValueError, binascii.Error, zlib.error) as error:
        raise ValueError(
            "the frame has no pressures in its info: make it by snapshot(), and write "
            "it to a database (.db, .json) by database.write(frame, data=frame.info)"
        ) from error


def restore(frame: Atoms, solid: ElasticSolid | float) -> Atoms:
    """Rebuild the atoms of a calculation, padding included, from a frame.

    A calculation can start from the frame itself, too. With the padding, an evaluation
    of the energy costs one FFT pair instead of the solution of a linear system.

    Parameters
    ----------
    frame : Atoms
        Frame from `snapshot`, also read back from a file.
    solid : ElasticSolid or float
        Substrate, or its contact modulus (eV/Å^3), from which the displacement of the
        padding follows.

    Returns
    -------
    Atoms
        Window, padding and indenter, without calculator. The indenter is fixed if it
        was; other constraints are not restored.

    Raises
    ------
    ValueError
        If the frame is not a grid of surface atoms and an indenter, or has lost what
        the surface keeps of earlier steps.
    TypeError
        If it is no frame.
    """
    instance_of(Atoms, frame=frame)
    check_history(frame)
    grid = SurfaceGrid.of(frame)
    window = displacement(frame, grid)[: grid.window[0], : grid.window[1]]
    values = window
    if not grid.periodic:
        halfspace = ReducedHalfSpace(grid.window, grid.spacing, solid)
        values = halfspace.grid_displacement(halfspace.elastic_pressure(window))
        values[: window.shape[0], : window.shape[1]] = window
    atoms = replace(grid, shape=values.shape).atoms(frame.numbers[0], 0.0)
    atoms.positions[:-1, :2] += np.add(grid.origin, frame.positions[-1, :2])
    atoms.positions[-1], atoms.cell = frame.positions[-1], frame.cell
    set_displacement(atoms, values)
    if INDENTER_KEY in info_of(frame):
        atoms.info[INDENTER_KEY] = info_of(frame)[INDENTER_KEY]
    if any(isinstance(constraint, FixAtoms) for constraint in frame.constraints):
        atoms.set_constraint(FixAtoms([len(atoms) - 1]))
    history = history_of(frame, grid)
    set_history(atoms, SurfaceGrid.of(atoms), history, creep_of(frame))
    return atoms
