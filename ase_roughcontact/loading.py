"""Quasi-static load paths: one relaxed state after the other, each written at once."""

from __future__ import annotations

import csv
import hashlib
import json
import os
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import asdict, dataclass, fields
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from ase import Atoms
from ase.constraints import Hookean
from ase.io import Trajectory

from ase_roughcontact.calculator import RoughContact
from ase_roughcontact.checks import integer, positive
from ase_roughcontact.optimize import NewtonKrylov
from ase_roughcontact.substrate import Layout, indenter_fixed, restore, snapshot
from ase_roughcontact.window import AutoWindow, FixedWindow, box_of, rewindow

PathName = str | os.PathLike


@dataclass(frozen=True)
class LoadStep:
    """What is known of one relaxed step.

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
    iterations : int
        Steps of the optimizer.
    seconds : float
        Time that the step took.
    converged : bool
        Whether the optimizer came below its tolerance.
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
    iterations: int
    seconds: float
    converged: bool


def load_path(
    atoms: Atoms,
    penetrations: Sequence[float] | None = None,
    optimizer: Callable[..., Any] = NewtonKrylov,
    fmax: float = 1e-3,
    trajectory: PathName | None = None,
    csv: PathName | None = None,
    *,
    heights: Sequence[float] | None = None,
    loads: Sequence[float] | None = None,
    max_steps: int = 10_000,
    window: str = "fixed",
    edge: str = "raise",
    resume: bool = False,
) -> Iterator[LoadStep]:
    """Relax the atoms at one load after the other.

    Parameters
    ----------
    atoms : Atoms
        From `substrate`, with a `RoughContact` calculator. They are moved.
    penetrations, heights, loads : sequence of float
        The path, exactly one of: distances that the indenter has come down since it
        first repels the flat substrate (Å), heights of the indenter (Å), or loads on
        it (eV/Å). The first two need an indenter that is fixed, loads one that is free.
    optimizer : callable
        Called as ``optimizer(atoms, logfile=None)``; returns an ASE optimizer. A class,
        or a `functools.partial` of one with its options.
    fmax : float
        Tolerance of the force on every atom (eV/Å).
    trajectory : path, optional
        File of an ASE trajectory of snapshots, one per step.
    csv : path, optional
        File of a table of the records, one line per step.
    max_steps : int
        Steps of the optimizer at most, per step of the path.
    window : {"fixed", "auto"}
        Keep the window of the atoms, or, on a free half space, exchange it in place for
        one that holds all atoms that can touch at the step, and few others. That needs
        an indenter that rises out of reach, such as `RoughSphere`.
    edge : {"raise", "ignore"}
        What to do when the wall acts on an atom at the edge of a fixed free window: the
        atoms beyond it, which can't touch, would have touched, unless the indenter ends
        there, as a flat punch does.
    resume : bool
        Go on from the steps that `trajectory` holds already: they are yielded again and
        not calculated again.

    Yields
    ------
    LoadStep
        As soon as it is known, and written. A step that does not converge is yielded
        and written too, marked.

    Raises
    ------
    ValueError
        If not exactly one path is given, it is empty or not finite, the indenter's
        constraint does not fit it, or `resume` finds another path. With automatic
        windows, if the indenter does not rise out of reach, or atoms could touch at
        which its roughness is not known.
    RuntimeError
        If the contact has come to the edge of a fixed window.
    """
    if resume and trajectory is None:
        raise ValueError("resume needs the trajectory to go on from")
    control, targets = _one_path(
        penetrations=penetrations, heights=heights, loads=loads
    )
    positive(fmax=fmax)
    integer("max_steps", max_steps, 1)
    if edge not in ("raise", "ignore"):
        raise ValueError(f"edge must be 'raise' or 'ignore', got {edge!r}")
    if window not in ("fixed", "auto"):
        raise ValueError(f"window must be 'fixed' or 'auto', got {window!r}")
    if not isinstance(atoms.calc, RoughContact):
        raise ValueError(f"load_path needs a RoughContact calculator, got {atoms.calc}")
    _check_constraint(atoms, control)
    auto = window == "auto" and not atoms.pbc.any()
    windows = AutoWindow(atoms) if auto else FixedWindow(atoms, edge)
    system = _fingerprint(atoms, windows, fmax)
    done = _done(trajectory, system, control, targets) if resume else []
    relax = partial(_relax, optimizer=optimizer, fmax=fmax, max_steps=max_steps)
    path = _Path(atoms, control, targets, system, relax, windows)
    return _steps(path, trajectory, csv, done)


@dataclass(frozen=True)
class _Path:
    """What is relaxed, how, and under which loads."""

    atoms: Atoms
    control: str
    targets: np.ndarray
    system: str
    relax: Callable[[Atoms], tuple[int, bool]]
    windows: AutoWindow | FixedWindow

    def step(self, number: int) -> LoadStep:
        """Relax the atoms at a step, in windows that grow until they suffice."""
        start = time.perf_counter()
        first_contact = self.windows.first_contact
        _apply(self.atoms, self.control, self.targets[number], first_contact)
        self.windows.place(self.atoms, self.control)
        iterations, converged = self.relax(self.atoms)
        while self.windows.grow(self.atoms):
            more, converged = self.relax(self.atoms)
            iterations += more
        seconds = time.perf_counter() - start
        return _record(
            self.atoms, number, first_contact, iterations, seconds, converged
        )

    def frame(self, record: LoadStep) -> Atoms:
        """Return what is kept of the atoms, from which the path goes on."""
        target = self.targets[record.step]
        path = {"system": self.system, "control": self.control, "target": target}
        return snapshot(self.atoms, load_step=asdict(record), path=path)


def _steps(
    path: _Path,
    trajectory: PathName | None,
    table: PathName | None,
    done: list[Atoms],
) -> Iterator[LoadStep]:
    with ExitStack() as files:
        # the table first: a trajectory that is there is lost once it is opened to write
        rows = None if table is None else files.enter_context(_Table(table))
        frames = None
        if trajectory is not None:
            mode = "a" if done else "w"
            frames = files.enter_context(Trajectory(os.fspath(trajectory), mode))
        before = [LoadStep(**frame.info["load_step"]) for frame in done]
        if rows is not None:
            for record in before:
                rows.write(record)
        yield from before
        if done:
            _continue_from(path.atoms, done[-1])
            path.windows.settle(path.atoms)
        for number in range(len(done), len(path.targets)):
            record = path.step(number)
            if frames is not None:
                frames.write(path.frame(record))
            if rows is not None:
                rows.write(record)
            yield record


def _one_path(**paths: Sequence[float] | None) -> tuple[str, np.ndarray]:
    given = {name: path for name, path in paths.items() if path is not None}
    if len(given) != 1:
        raise ValueError(
            f"give exactly one of {', '.join(paths)}; got {', '.join(given) or 'none'}"
        )
    ((control, path),) = given.items()
    try:
        targets = np.asarray(path, dtype=float)
    except (TypeError, ValueError):
        targets = np.array(np.nan)
    if targets.ndim != 1 or targets.size == 0 or not np.isfinite(targets).all():
        raise ValueError(f"{control} must be a sequence of finite numbers, got {path}")
    return control, targets


def _check_constraint(atoms: Atoms, control: str) -> None:
    fixed = indenter_fixed(atoms)
    if fixed and control == "loads":
        raise ValueError(
            "loads need an indenter that is free to move, but it is fixed: build the "
            "atoms with substrate(..., fixed=False)"
        )
    if not fixed and control != "loads":
        raise ValueError(
            f"{control} need an indenter that is fixed, but it is free: constrain it "
            "with ase.constraints.FixAtoms, or build the atoms with "
            "substrate(..., fixed=True)"
        )


def _apply(atoms: Atoms, control: str, target: float, first_contact: float) -> None:
    if control == "loads":
        atoms.calc.set(load=float(target))
        # out of contact nothing but the load acts, and some optimizers divide by zero
        atoms.positions[-1, 2] = min(atoms.positions[-1, 2], first_contact)
    else:
        height = target if control == "heights" else first_contact - target
        atoms.positions[-1, 2] = height


def _relax(
    atoms: Atoms, optimizer: Callable[..., Any], fmax: float, max_steps: int
) -> tuple[int, bool]:
    """Relax the atoms; return the number of steps and whether they converged."""
    dynamics = optimizer(atoms, logfile=None)
    converged = dynamics.run(fmax=fmax, steps=max_steps)
    for _ in dynamics.optimizable.iterimages():
        pass  # an optimizer with coordinates of its own moves the atoms only now
    return int(dynamics.nsteps), bool(converged)


def _record(
    atoms: Atoms,
    step: int,
    first_contact: float,
    iterations: int,
    seconds: float,
    converged: bool,
) -> LoadStep:
    state = atoms.calc.state(atoms)
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
        iterations=iterations,
        seconds=seconds,
        converged=converged,
    )


def _fingerprint(atoms: Atoms, windows: AutoWindow | FixedWindow, fmax: float) -> str:
    """Digest of all that a state depends on but height, load and displacement."""
    parameters = {
        k: v for k, v in atoms.calc.todict().items() if k not in ("load", "fft")
    }
    precision = atoms.calc.parameters["fft"].get("dtype")
    springs = [_spring(c) for c in atoms.constraints if isinstance(c, Hookean)]
    system = [parameters, precision, springs, windows.system(), fmax]
    text = json.dumps(system, sort_keys=True, default=_plain)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _spring(constraint: Hookean) -> list:
    """Return what counts of a spring: its x and y move with automatic windows."""
    given = constraint.todict()["kwargs"]
    return [given["k"], given["rt"], np.ravel(given["a2"]).tolist()[2:]]


def _plain(value: Any) -> Any:
    """Return a number or text in place of what JSON does not know."""
    return value.item() if isinstance(value, np.generic) else repr(value)


def _done(
    trajectory: PathName | None, system: str, control: str, targets: np.ndarray
) -> list[Atoms]:
    """Frames that were calculated before, checked against the path."""
    if trajectory is None or not Path(trajectory).exists():
        return []
    if Path(trajectory).stat().st_size == 0:
        return []
    try:
        with Trajectory(os.fspath(trajectory)) as frames:
            done = list(frames)
    except Exception as error:
        raise ValueError(
            f"can't resume: {os.fspath(trajectory)} is not a whole trajectory ({error})"
        ) from error
    known = [frame.info.get("path") for frame in done]
    wanted = [
        {"system": system, "control": control, "target": target}
        for target in targets[: len(done)]
    ]
    if known != wanted:
        raise ValueError(
            f"can't resume: {os.fspath(trajectory)} holds {len(done)} steps of another "
            "path or system (indenter, wall, solid, window, loads or fmax differ): "
            "delete it, or give another file or folder"
        )
    return done


def _continue_from(atoms: Atoms, frame: Atoms) -> None:
    restored = restore(frame, atoms.calc.parameters["contact_modulus"])
    if not atoms.pbc.any():
        rewindow(atoms, box_of(Layout.of(restored)))
    atoms.positions = restored.positions


class _Table:
    """CSV file of records, each line on disk before the next step begins."""

    def __init__(self, path: PathName) -> None:
        # written from start to end by this object, closed by its __exit__
        self._file = open(path, "w", newline="")  # noqa: SIM115
        self._writer = csv.DictWriter(self._file, [f.name for f in fields(LoadStep)])
        self._writer.writeheader()

    def __enter__(self) -> _Table:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def write(self, record: LoadStep) -> None:
        self._writer.writerow(asdict(record))
        self._file.flush()
