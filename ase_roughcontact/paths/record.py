"""What is known of a relaxed step, and the table in which it is kept."""

from __future__ import annotations

import csv
import os
from dataclasses import asdict, dataclass, fields
from itertools import islice

import numpy as np
from ase import Atoms

from ase_roughcontact.windows.memory import memory_of, points_of


@dataclass(frozen=True)
class LoadStep:
    """What is known of one relaxed step, and how it was obtained.

    Attributes
    ----------
    step : int
        Number of the step, from zero.
    height : float
        Height of the indenter (Å).
    penetration : float
        How far the indenter has come down since the height at which the flat substrate
        began to repel it (Å).
    normal_force : float
        Of the wall on the indenter, positive in compression (eV/Å).
    contact_area : float
        Number of atoms that feel a repulsive force, times the area of one (Å^2).
    repulsive_atoms, attractive_atoms : int
        Number of atoms that the wall pushes, and that it pulls.
    energy : float
        Of substrate, wall and load (eV).
    max_force : float
        Largest force that is left on any atom (eV/Å).
    gap_error : float
        Of a hard wall, the largest gap of an atom that it pushes, or overlap of one
        that it does not; zero for a soft wall (Å).
    converged : bool
        Whether the optimizer came below its tolerance.
    message : str
        Why it did not.
    tolerance : float
        Largest force that was to be left (eV/Å).
    iterations : int
        Steps of the optimizer.
    pairs : float
        Pairs of Fourier transforms that it took, in units of one on the grid.
    window, grid : str
        Shapes of the window of atoms that may touch and of the grid of the transforms.
    precision : str
        Of the transforms.
    memory : float
        That the step needs, estimated between 3/4 and 4/3 of it; see `memory_of`
        (bytes).
    seconds : float
        Time that the step took.
    """

    step: int
    height: float
    penetration: float
    normal_force: float
    contact_area: float
    repulsive_atoms: int
    attractive_atoms: int
    energy: float
    max_force: float
    gap_error: float
    converged: bool
    message: str
    tolerance: float
    iterations: int
    pairs: float
    window: str
    grid: str
    precision: str
    memory: float
    seconds: float


@dataclass
class SolverStatistics:
    """How a step was relaxed; grows while it is.

    Attributes
    ----------
    converged : bool
    message : str
    tolerance : float
    iterations : int
    pairs : float
        See `LoadStep`.
    """

    converged: bool = False
    message: str = ""
    tolerance: float = np.inf
    iterations: int = 0
    pairs: float = 0.0


def record_of(
    atoms: Atoms,
    step: int,
    first_contact: float,
    effort: SolverStatistics,
    seconds: float,
) -> LoadStep:
    """Read a record off relaxed atoms.

    Parameters
    ----------
    atoms : Atoms
        With a `RoughContact` calculator.
    step : int
        Number of the step.
    first_contact : float
        Height at which the flat substrate begins to repel the indenter (Å).
    effort : SolverStatistics
        How they were relaxed.
    seconds : float
        Time that it took.

    Returns
    -------
    LoadStep
        Forces, energy and gaps are calculated afresh, not taken from the optimizer.
    """
    state, halfspace = atoms.calc.state(atoms), atoms.calc.contact(atoms).halfspace
    height = float(atoms.positions[-1, 2])
    return LoadStep(
        step=step,
        height=height,
        penetration=first_contact - height,
        normal_force=state.normal_force,
        contact_area=state.contact_area,
        repulsive_atoms=state.repulsive_atoms,
        attractive_atoms=state.attractive_atoms,
        energy=float(atoms.get_potential_energy()),
        max_force=float(np.linalg.norm(atoms.get_forces(), axis=1).max()),
        gap_error=_gap_error(atoms),
        window=text_of(halfspace.shape),
        grid=text_of(halfspace.grid),
        precision=np.dtype(halfspace.fft.get("dtype", float)).name,
        memory=_memory(atoms),
        seconds=seconds,
        **asdict(effort),
    )


class Table:
    """CSV file of records, each line on disk before the next step begins.

    Parameters
    ----------
    path : path
        Of the file.
    kept : int
        Number of lines, below the head, that stay of a file that is there; all else is
        written anew.
    """

    def __init__(self, path: str | os.PathLike, kept: int = 0) -> None:
        # closed by __exit__
        self._file = open(path, "a+" if kept else "w", newline="")  # noqa: SIM115
        self._writer = csv.DictWriter(self._file, [f.name for f in fields(LoadStep)])
        if not (kept and self._cut(kept)):
            self._writer.writeheader()

    def __enter__(self) -> Table:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def write(self, record: LoadStep) -> None:
        """Append a line.

        Parameters
        ----------
        record : LoadStep
        """
        self._writer.writerow(asdict(record))
        self._file.flush()

    def _cut(self, kept: int) -> int:
        """Cut the file off after some lines, and return its size."""
        self._file.seek(0)
        lines = csv.reader(iter(self._file.readline, ""))  # next() would not tell()
        for _ in islice(lines, kept + 1):
            pass
        return self._file.truncate(self._file.tell())


def _gap_error(atoms: Atoms) -> float:
    if not atoms.calc.contact(atoms).interaction.hard:
        return 0.0
    state = atoms.calc.state(atoms)
    pushed, gap = state.contact, state.gap
    closed = abs(gap[pushed]).max(initial=0.0)
    return float(max(closed, -gap[~pushed].min(initial=0.0)))


def _memory(atoms: Atoms) -> float:
    halfspace = atoms.calc.contact(atoms).halfspace
    return memory_of(
        halfspace.shape,
        margin=halfspace.dof_shape != halfspace.shape,
        points=points_of(atoms.calc.parameters["indenter"], halfspace.spacing),
    )


def text_of(shape: tuple[int, ...]) -> str:
    """Return a shape as records have it.

    Parameters
    ----------
    shape : tuple of int

    Returns
    -------
    str
    """
    return "x".join(map(str, shape))
