"""Constraints of ASE: on the indenter, and the one by which atoms stick to it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from ase import Atoms
from ase.constraints import FixCartesian

from ase_roughcontact._util.validation import finite_array, shown
from ase_roughcontact.atoms.info import LATTICE

#: Key in the lattice of atoms of whether they stick, also without the constraint.
STICKS = "sticks"
# Relative excess of friction over its bound that is no slip.
_BOUND_TOLERANCE = 1e-6
# Largest distance of an atom that sticks from its place (Å).
_PLACE_TOLERANCE = 1e-6


def exceeds(friction: np.ndarray, bounds: np.ndarray) -> np.ndarray:
    """Return where the magnitude of friction, shape (2, ...), exceeds its bound."""
    return np.hypot(*friction) > (1.0 + _BOUND_TOLERANCE) * bounds


class SlipError(RuntimeError):
    """Atoms slip, so that lateral forces are not the gradient of an energy."""

    def __init__(self, slipping: np.ndarray, count: int, when: str) -> None:
        numbers = ", ".join(map(str, slipping[:5]))
        if len(slipping) > 5:
            numbers += ", ..."
        super().__init__(
            f"{len(slipping)} of {count} atoms with friction slip {when} (atoms "
            f"{numbers}): friction at its bound is not the gradient of an energy; use "
            "sliding_path"
        )


class Sticking:
    """Constraint of ASE under which atoms move sideways with the indenter: see `stick`.

    It adds the lateral forces on these atoms to the force on the indenter. In a
    periodic half space it keeps the mean lateral displacement of the surface.

    Parameters
    ----------
    atoms : Atoms
        Atoms in the positions at which the friction is as given.
    index : ndarray of int, shape (k,)
        Numbers of the atoms that stick.
    bounds : ndarray, shape (k,)
        Largest magnitude of the friction on each (eV/Å).
    friction : ndarray, shape (k, 2)
        Friction on each along x and y (eV/Å).
    stiffness : ndarray, shape (k, 2, 2)
        Derivative of the friction to the position of the indenter (eV/Å^2).

    Raises
    ------
    SlipError
        By `Atoms.get_forces`, if an atom slips where the indenter is held, or on its
        way to where its lateral force vanishes.
    """

    def __init__(
        self,
        atoms: Atoms,
        index: np.ndarray,
        bounds: np.ndarray,
        friction: np.ndarray,
        stiffness: np.ndarray,
    ) -> None:
        self.index, self._bounds = index, bounds
        self._friction, self._stiffness = friction, stiffness
        self._start = atoms.positions[-1, :2].copy()
        self._offsets = atoms.positions[index, :2] - self._start
        self._others = np.zeros(0, dtype=int)  # with a mean to be adjusted
        if atoms.pbc.any():
            self._others = np.setdiff1d(np.arange(len(atoms) - 1), index)
            self._middle = atoms.positions[:-1, :2].mean(axis=0)

    def __eq__(self, other: object) -> bool:
        """Return whether the same friction acts on the same atoms."""
        if not isinstance(other, Sticking):
            return False
        names = "index", "_bounds", "_friction", "_stiffness", "_start", "_offsets"
        return all(
            np.array_equal(getattr(self, name), getattr(other, name)) for name in names
        )

    __hash__ = None  # type: ignore[assignment]

    def move(self, atoms: Atoms, displacement: Sequence[float]) -> None:
        """Move the indenter, and the atoms that stick to it, sideways.

        Parameters
        ----------
        atoms : Atoms
            Surface and indenter. The other atoms stay where they are: relax them.
        displacement : (float, float)
            Displacement along x and y (Å).

        Raises
        ------
        ValueError
            If the displacement is not two finite numbers.
        SlipError
            If atoms slip there; nothing is moved then.
        """
        step = finite_array("displacement", displacement)
        if step.shape != (2,):
            raise ValueError(
                "displacement must be two numbers, along x and y, got "
                f"{shown(displacement)}"
            )
        place = atoms.positions[-1, :2] + step
        self._check(place)
        self._set(atoms.positions, place)

    def friction(self, place: np.ndarray) -> np.ndarray:
        """Return the friction on the atoms that stick, with all others relaxed.

        Parameters
        ----------
        place : ndarray, shape (2,)
            Position of the indenter along x and y (Å).

        Returns
        -------
        ndarray, shape (k, 2)
            Friction along x and y (eV/Å).
        """
        return self._friction + self._stiffness @ (place - self._start)

    def lateral_force(self, forces: np.ndarray) -> np.ndarray:
        """Return the force on the indenter that balances the elastic forces."""
        found = -forces[self.index, :2].sum(axis=0)
        if self._others.size:  # they move backwards, by the mean
            found += len(self.index) * forces[self._others, :2].mean(axis=0)
        return found

    def adjust_positions(self, atoms: Atoms, new: np.ndarray) -> None:
        """Move the atoms that stick with the indenter."""
        held, _ = self._support(atoms)
        self._set(new, np.where(held, atoms.positions[-1, :2], new[-1, :2]))

    def adjust_forces(self, atoms: Atoms, forces: np.ndarray) -> None:
        """Add the forces on the atoms that stick to the force on the indenter."""
        place = atoms.positions[-1, :2]
        distance = abs(atoms.positions[self.index, :2] - place - self._offsets).max()
        if distance > _PLACE_TOLERANCE:
            raise ValueError(
                f"atoms that stick to the indenter are {distance:.3g} Å off their "
                "places: move the indenter by the method move of the constraint"
            )
        held, pull = self._support(atoms)
        self._check(place, held, pull)
        forces[-1, :2] -= np.where(held, 0.0, self.lateral_force(forces))
        if self._others.size:
            forces[self._others, :2] -= forces[self._others, :2].mean(axis=0)
        forces[self.index, :2] = 0.0

    def todict(self) -> dict[str, Any]:
        """Return the constraint of ASE that files store in place of this one.

        It fixes x and y of the atoms. They don't stick to the indenter any more, which
        a calculation notices.
        """
        return FixCartesian(self.index, mask=(True, True, False)).todict()

    def index_shuffle(self, atoms: Atoms, index: object) -> None:
        """Raise an error, by which ASE leaves the constraint out of parts of atoms."""
        raise NotImplementedError

    def _set(self, positions: np.ndarray, place: np.ndarray) -> None:
        positions[-1, :2] = place
        positions[self.index, :2] = place + self._offsets
        if self._others.size:
            count = len(positions) - 1
            shift = positions[:-1, :2].mean(axis=0) - self._middle
            positions[self._others, :2] -= shift * count / self._others.size

    def _support(self, atoms: Atoms) -> tuple[np.ndarray, np.ndarray]:
        """Return whether other constraints hold the indenter, and their force on it."""
        forces = np.zeros((len(atoms), 3))
        forces[-1] = 1.0
        for constraint in atoms.constraints:
            if constraint is not self:
                constraint.adjust_forces(atoms, forces)
        return forces[-1, :2] == 0.0, forces[-1, :2] - 1.0

    def _check(
        self,
        place: np.ndarray,
        held: np.ndarray | bool = True,
        pull: np.ndarray | float = 0.0,
    ) -> None:
        """Raise `SlipError` if atoms slip at a place, and where forces balance, too."""
        free = np.flatnonzero(~(np.zeros(2, dtype=bool) | held))
        lateral = self.friction(place).sum(axis=0)
        missing, moved = (pull - lateral)[free], (place - self._start)[free]
        if missing @ moved < 0.0:  # an optimizer has moved it too far
            stiffness = self._stiffness.sum(axis=0)[np.ix_(free, free)]
            place = place.copy()
            place[free] += np.linalg.solve(stiffness, missing)
        slipping = self.index[exceeds(self.friction(place).T, self._bounds)]
        if slipping.size:
            x, y = place - self._start
            when = f"if the indenter moves by ({x:.4g}, {y:.4g}) Å"
            raise SlipError(slipping, len(self.index), when)


def sticking_of(atoms: Atoms) -> Sticking | None:
    """Return the constraint by which atoms stick to the indenter; None without."""
    found = (c for c in atoms.constraints if isinstance(c, Sticking))
    return next(found, None)


def check_kept(atoms: Atoms) -> None:
    """Raise `ValueError` if the constraint by which atoms stick was removed."""
    if sticking_of(atoms) is None and atoms.info.get(LATTICE, {}).get(STICKS):
        raise ValueError(
            "the constraint of stick() is not among atoms.constraints: give it to "
            "set_constraint, too, or call release(atoms); to a file write "
            "snapshot(atoms)"
        )


def check_released(atoms: Atoms) -> None:
    """Raise `ValueError` if atoms stick, which our solvers and paths do not support."""
    check_kept(atoms)
    if sticking_of(atoms) is not None:
        raise ValueError(
            "the atoms stick to the indenter: relax them by an optimizer of ASE, or "
            "call release(atoms)"
        )


def indenter_fixed(atoms: Atoms) -> bool:
    """Return whether a constraint cancels the force on the indenter along z.

    Parameters
    ----------
    atoms : Atoms
        Substrate and indenter.

    Returns
    -------
    bool

    Raises
    ------
    ValueError
        If a constraint is a dictionary, as in atoms that ASE reads from a
        `BundleTrajectory`.
    """
    if not atoms.constraints:
        return False
    if any(isinstance(constraint, dict) for constraint in atoms.constraints):
        raise ValueError(
            "constraints of the atoms are dictionaries: call atoms.set_constraint("
            "[dict2constraint(c) for c in atoms.constraints]), from ase.constraints"
        )
    force = np.zeros((len(atoms), 3))
    force[-1, 2] = 1.0
    for constraint in atoms.constraints:
        # others add a force
        if not hasattr(constraint, "adjust_potential_energy") and not isinstance(
            constraint, Sticking
        ):
            constraint.adjust_forces(atoms, force)
    return bool(force[-1, 2] == 0.0)
