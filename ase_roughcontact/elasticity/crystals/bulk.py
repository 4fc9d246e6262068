"""Lattice constant and pressure of bulk crystals, from an ASE calculator."""

from __future__ import annotations

from typing import Any

import numpy as np
from ase import Atoms
from ase.build import bulk
from ase.data import atomic_numbers, reference_states
from ase.neighborlist import neighbor_list
from scipy.optimize import brentq

# Strain of the finite difference that gives the pressure of a bulk crystal, and the
# range of lattice constants in which that pressure vanishes.
_STRAIN, _RANGE = 1e-4, 0.1
_ATOMS = {"fcc": 4, "bcc": 2}  # in a cubic cell
# Distance, in lattice constants, up to which neighbours distinguish fcc, hcp and bcc.
_SHELLS = 1.3


def element(bulk: Atoms | str, structure: str) -> tuple[str, float]:
    """Return the symbol of a crystal and a first guess of its lattice constant.

    Parameters
    ----------
    bulk : Atoms or str
        A crystal of one element, or the symbol of one that ASE knows.
    structure : {"fcc", "bcc"}

    Returns
    -------
    symbol : str
    lattice_constant : float
        That of an equal volume per atom (Å).

    Raises
    ------
    ValueError
        If the crystal has several elements, is not periodic or has another structure,
        or the element is not known.
    """
    if isinstance(bulk, Atoms):
        if len(set(bulk.symbols)) != 1 or not bulk.pbc.all():
            raise ValueError(
                f"bulk must be a periodic crystal of one element, got {bulk!r}"
            )
        symbol, volume = bulk.symbols[0], bulk.cell.volume / len(bulk)
        if not _has_structure(bulk, structure, (volume * _ATOMS[structure]) ** (1 / 3)):
            raise ValueError(f"bulk must be {structure} for this surface, got {bulk!r}")
    else:
        reference = reference_states[atomic_numbers.get(bulk, 0)] or {}
        if reference.get("symmetry") not in _ATOMS:
            raise ValueError(
                f"no cubic crystal of {bulk!r} is known to ASE: give a crystal as Atoms"
            )
        symbol, volume = bulk, reference["a"] ** 3 / _ATOMS[reference["symmetry"]]
    return symbol, float((volume * _ATOMS[structure]) ** (1 / 3))


def _has_structure(crystal: Atoms, structure: str, a: float) -> bool:
    """Return whether the neighbours of all atoms are those of a cubic crystal."""
    expected = neighbor_list("d", bulk(crystal.symbols[0], structure, a), _SHELLS * a)
    found = neighbor_list("d", crystal, _SHELLS * a)
    return len(found) == len(crystal) * len(expected) and np.allclose(
        np.sort(found), np.sort(np.tile(expected, len(crystal))), rtol=0.02
    )


def relaxed_lattice_constant(
    calculator: Any, symbol: str, structure: str, guess: float
) -> float:
    """Return the lattice constant at which a cubic crystal has no stress.

    Parameters
    ----------
    calculator : Calculator
        Any ASE calculator.
    symbol : str
        Chemical symbol.
    structure : {"fcc", "bcc"}
        Crystal structure.
    guess : float
        Lattice constant within 10 % of the result (Å).

    Returns
    -------
    float
        In Å.

    Raises
    ------
    ValueError
        If the stress does not vanish within 10 % of the guess.
    """
    low, high = (1.0 - _RANGE) * guess, (1.0 + _RANGE) * guess
    ends = [pressure(calculator, symbol, structure, a) for a in (low, high)]
    if not ends[0] > 0.0 > ends[1]:
        raise ValueError(
            f"{structure} {symbol} has no lattice constant without stress between "
            f"{low:.3f} and {high:.3f} Å with this calculator: give lattice_constant"
        )
    return float(
        brentq(lambda a: pressure(calculator, symbol, structure, a), low, high)
    )


def pressure(calculator: Any, symbol: str, structure: str, a: float) -> float:
    """Return the pressure of a cubic crystal by differences of its energy.

    Parameters
    ----------
    calculator : Calculator
    symbol : str
    structure : {"fcc", "bcc"}
    a : float
        Lattice constant (Å).

    Returns
    -------
    float
        Negative under tension (eV/Å^3).

    Raises
    ------
    ValueError
        If the calculator gives no energy.
    """
    energies, volumes = [], []
    for factor in (1.0 - _STRAIN, 1.0 + _STRAIN):
        atoms = bulk(symbol, structure, a=factor * a)
        atoms.calc = calculator
        try:
            energies.append(atoms.get_potential_energy())
        except Exception as error:
            raise ValueError(
                f"{type(calculator).__name__} gives no energy for {structure} "
                f"{symbol}: {error}"
            ) from error
        volumes.append(atoms.cell.volume)
    return -float(np.diff(energies)[0] / np.diff(volumes)[0])
