"""Frame of a relaxed step, made from its state without moving atoms."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from ase import Atoms

from ase_roughcontact.atoms.grid import SurfaceGrid
from ase_roughcontact.atoms.history import CREEP
from ase_roughcontact.atoms.info import LATTICE
from ase_roughcontact.atoms.snapshot import fields_and_info, tags_of
from ase_roughcontact.contact.state import DISPLACEMENTS, SLIPPING, TRACTIONS
from ase_roughcontact.stepping.relaxed import RelaxedStep


@dataclass(frozen=True)
class FrameAtoms:
    """Window of surface atoms and the indenter, apart from the state of a step.

    Attributes
    ----------
    number : int
        Atomic number of the surface atoms.
    axis : (float, float)
        Position of the indenter along x and y (Å).
    cell : ndarray, shape (3, 3)
        Cell (Å).
    constraints : list
        Constraints of ASE.
    info : mapping
        The `info` of the atoms.
    """

    number: int
    axis: tuple[float, float]
    cell: np.ndarray
    constraints: list[Any]
    info: Mapping[str, Any]

    @classmethod
    def of(cls, atoms: Atoms) -> FrameAtoms:
        """Return the window and the indenter of atoms."""
        kept = np.append(SurfaceGrid.of(atoms).in_window, True)
        x, y = atoms.positions[-1, :2].tolist()
        constraints = atoms[kept].constraints
        return cls(
            int(atoms.numbers[0]), (x, y), atoms.cell.array, constraints, atoms.info
        )


@dataclass(frozen=True)
class StepFrame:
    """Frame of a step.

    Attributes
    ----------
    atoms : FrameAtoms
    grid : SurfaceGrid
        Grid of the window.
    height : float
        Height of the indenter (Å).
    energy : float
        Energy of solid, wall and load, without springs (eV).
    info : dict
        The `info` of the frame, without fields.
    tags : ndarray of int, shape (n, m)
        Tags of the surface atoms; see `snapshot`.
    displacement : ndarray, shape (n, m)
        Positions z of the surface atoms (Å).
    lateral : ndarray, shape (2, n, m), or None
        Displacements along x and y of the surface atoms; None without (Å).
    fields : dict of ndarray, shape (n, m)
        Fields of the contact and of the history of the surface.
    """

    atoms: FrameAtoms
    grid: SurfaceGrid
    height: float
    energy: float
    info: dict[str, Any]
    tags: np.ndarray
    displacement: np.ndarray
    lateral: np.ndarray | None
    fields: dict[str, np.ndarray]


def step_frame(relaxed: RelaxedStep, atoms: FrameAtoms, **info: Any) -> StepFrame:
    """Return the frame of a step as it leaves the surface.

    Parameters
    ----------
    relaxed : RelaxedStep
    atoms : FrameAtoms
        Atoms on the window of the step.
    **info
        Numbers and strings to be stored with the frame.

    Returns
    -------
    StepFrame
        The frame that `snapshot` makes of atoms in the same state.
    """
    state, contact, support = relaxed.state, relaxed.contact, relaxed.run.support
    history, problem, shape = state.history, relaxed.problem, state.window.shape
    origin = problem.origin(state.window)
    grid = SurfaceGrid(shape, shape, problem.spacing, origin, problem.periodic)
    displacement, lateral = state.displacement, None
    if displacement is None:
        displacement = contact.halfspace.displacement(state.pressure)
    if contact.past_depth is not None:
        displacement = displacement - contact.past_depth
    fields, found = fields_and_info(relaxed.fields, history)
    if state.creep is not None:
        found[CREEP] = state.creep.todict()
    if SLIPPING in history:
        lateral = np.stack([history[key] for key in DISPLACEMENTS])
        forces = [relaxed.fields.cell_area * history[key].sum() for key in TRACTIONS]
        found["lateral_force"] = np.array(forces).tolist()
        found[LATTICE] = atoms.info.get(LATTICE, {}) | asdict(grid)
    load = 0.0 if support.fixed else support.load
    return StepFrame(
        atoms=atoms,
        grid=grid,
        height=state.height,
        energy=relaxed.fields.energy + load * state.height,
        info={**atoms.info, **found, **info},
        tags=tags_of(relaxed.fields, history),
        displacement=displacement,
        lateral=lateral,
        fields=fields,
    )
