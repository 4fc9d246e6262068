"""State of a relaxation, as every solver of the contact problem reports it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ase_roughcontact.contact import Contact
from ase_roughcontact.elasticity.halfspace import HalfSpace

#: Energy and upward force on the indenter, of load and springs, at a height.
External = Callable[[float], tuple[float, float]]


@dataclass(frozen=True)
class Relaxation:
    """Where a solver of the half space has come to.

    Attributes
    ----------
    pressure : ndarray, shape (n, m)
        Elastic pressure on the window (pressure), from which the displacement follows.
    height : float
        Of the indenter (length).
    energy : float
        Elastic and wall energy and that of load and springs.
    error : float
        Largest force that is left on any atom or the indenter.
    converged : bool
        Whether `error` is below the tolerance, by a fresh convolution.
    message : str
        Why it stopped, empty while it goes on.
    pairs : float
        Padded transform pairs spent since the last one, in units of a pair on the
        whole window; work on smaller grids counts by its share of atoms.
    """

    pressure: np.ndarray
    height: float
    energy: float
    error: float
    converged: bool
    message: str
    pairs: float


def precision_advice(halfspace: HalfSpace) -> str:
    """Return what a message about rounding says of single precision, if it is used."""
    if np.dtype(halfspace.fft.get("dtype", float)) == np.float64:
        return ""
    return " (the transforms are in single precision: fft dtype float64 goes further)"


def without_rounding(pressure: np.ndarray) -> np.ndarray:
    """Return a pressure read off a displacement, zero where it is only rounding."""
    return np.where(abs(pressure) < 1e-9 * abs(pressure).max(), 0.0, pressure)


def indenter_stiffness(contact: Contact) -> float:
    """Stiffness of a contact half as wide as the window, ``2 E* a`` (force/length)."""
    n, m = contact.halfspace.shape
    halfspace = contact.halfspace
    return halfspace.contact_modulus * halfspace.spacing * (n * m) ** 0.5
