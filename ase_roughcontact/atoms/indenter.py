"""The indenter atom: whether it can move, and which surface it stands for."""

from __future__ import annotations

import hashlib
import json
from typing import Any

import numpy as np
from ase import Atoms

from ase_roughcontact._util.validation import Point, Shape, check_heights
from ase_roughcontact.topography import Surface

#: Key of `Atoms.info` under which `substrate` stores the `surface_id` of the indenter.
INDENTER_KEY = "indenter"


def indenter_fixed(atoms: Atoms) -> bool:
    """Return whether a constraint cancels the force on the indenter along z.

    Parameters
    ----------
    atoms : Atoms
        Substrate and indenter.

    Returns
    -------
    bool
    """
    if not atoms.constraints:
        return False
    force = np.zeros((len(atoms), 3))
    force[-1, 2] = 1.0
    for constraint in atoms.constraints:
        if not hasattr(constraint, "adjust_potential_energy"):  # adds a force
            constraint.adjust_forces(atoms, force)
    return bool(force[-1, 2] == 0.0)


def surface_id(surface: Surface | None) -> str | None:
    """Return a name that is the same for the same surface only.

    Parameters
    ----------
    surface : Surface, optional

    Returns
    -------
    str or None
        Name of the class and a digest of ``surface.todict()``; None if the surface does
        not have this method, or returns something that JSON cannot represent.
    """
    try:
        text = json.dumps(surface.todict(), default=_plain)  # type: ignore[union-attr]
    except (AttributeError, TypeError, ValueError):
        return None
    # 10 and 10.0 are the same radius
    numbers = json.dumps(json.loads(text, parse_int=float), sort_keys=True)
    digest = hashlib.sha256(numbers.encode()).hexdigest()[:16]
    return f"{type(surface).__name__}-{digest}"


def check_surface(atoms: Atoms, identity: str | None) -> None:
    """Raise `ValueError` if atoms were built for another indenter.

    Parameters
    ----------
    atoms : Atoms
        Substrate and indenter.
    identity : str or None
        `surface_id` of the indenter to be used; None is not checked.
    """
    built_for = atoms.info.get(INDENTER_KEY)
    if None not in (built_for, identity) and built_for != identity:
        raise ValueError(
            f"the atoms were built for the indenter {built_for}, got {identity}: give "
            "substrate() and the calculator the same indenter, or delete "
            f"atoms.info[{INDENTER_KEY!r}] to replace the indenter on purpose"
        )


def heights_of(
    indenter: Surface, shape: Shape, spacing: float, origin: Point
) -> np.ndarray:
    """Return the heights of an indenter; see `Surface.heights`.

    Raises
    ------
    ValueError
        If they are not a matrix of finite real numbers.
    """
    heights = np.asarray(indenter.heights(shape, spacing, origin))
    check_heights(heights)
    return heights


def part_of_period(indenter: Surface, sides: np.ndarray) -> float:
    """Return the smaller ratio of a side of a cell and the period of an indenter.

    Parameters
    ----------
    indenter : Surface
    sides : ndarray, shape (2,)
        Of the cell along x and y (length).

    Returns
    -------
    float
        One, but for rounding, if the indenter continues across the edges of a periodic
        cell, as no cell is larger than a period; NaN if it has no `periods`.
    """
    periods = getattr(indenter, "periods", (np.inf, np.inf))
    ratios = np.where(np.isfinite(periods), np.divide(sides, periods), np.nan)
    return float(np.round(ratios.min(), 9))


def _plain(value: Any) -> Any:
    """Return what JSON can represent in place of NumPy's types."""
    if isinstance(value, np.ndarray):
        return [value.shape, hashlib.sha256(value.tobytes()).hexdigest()]
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"{type(value).__name__} is not supported")
