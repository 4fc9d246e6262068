"""Registry of the entries of a surface's history; see `contact.history`."""

from __future__ import annotations

import string
from dataclasses import dataclass


@dataclass(frozen=True)
class HistoryEntry:
    """Entry of `State.history`: an array on the window.

    Attributes
    ----------
    name : str
        Key of the entry. A name that ends with "_" represents all names that continue
        it by a number: ``creep_pressure_1``, ``creep_pressure_2``.
    unit : str
        Unit of ASE; empty for a number without unit.
    in_frames : bool
        Whether frames of trajectories have the entry.
    entering : float
        Value of an atom that enters a window, and of friction laws also of an atom that
        is not in contact.
    start : float or None
        Value of all atoms before the first step that keeps the entry; by default
        `entering`.
    """

    name: str
    unit: str = ""
    in_frames: bool = False
    entering: float = 0.0
    start: float | None = None

    @property
    def first(self) -> float:
        """Value before the first step that keeps the entry."""
        return self.entering if self.start is None else self.start


# Declared entries by name.
_ENTRIES: dict[str, HistoryEntry] = {}


def declare(entry: HistoryEntry) -> HistoryEntry:
    """Add an entry to the registry, and return it.

    Parameters
    ----------
    entry : HistoryEntry

    Raises
    ------
    ValueError
        If another entry has this name.
    """
    if _ENTRIES.setdefault(entry.name, entry) != entry:
        raise ValueError(
            f"the history has an entry {entry.name!r} already, "
            f"{_ENTRIES[entry.name]}: choose another name"
        )
    return entry


def is_entry(name: str) -> bool:
    """Return whether an entry of this name is declared."""
    return _declared(name) in _ENTRIES


def entry_of(name: str) -> HistoryEntry:
    """Return the entry of a name.

    Raises
    ------
    ValueError
        If it is not declared.
    """
    if not is_entry(name):
        raise ValueError(
            f"no entry {name!r} of the history is declared: declare a HistoryEntry "
            "of this name, or import the module that does"
        )
    return _ENTRIES[_declared(name)]


def _declared(name: str) -> str:
    """Return the name under which an entry of this name is declared."""
    stem = name.rstrip(string.digits)
    return stem if stem.endswith("_") else name
