"""What the solvers take and return: external forces and states of a relaxation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ase_roughcontact.contact import Contact
from ase_roughcontact.elasticity.halfspace import HalfSpace

#: Energy of load and springs at a height, and their upward force on the indenter.
External = Callable[[float], tuple[float, float]]


@dataclass(frozen=True)
class Relaxation:
    """State of a relaxation.

    Attributes
    ----------
    pressure : ndarray, shape (n, m)
        Elastic pressure on the window, which determines the displacement.
    height : float
        Height of the indenter (length).
    energy : float
        Energy of half space, wall, load and springs.
    error : float
        Largest force on an atom, or on the indenter unless its height is fixed.
    converged : bool
        Whether `error` is within the tolerance.
    message : str
        Why the solver stopped without convergence; empty otherwise.
    pairs : float
        Forward and inverse FFT pairs since the last state, normalised to one pair on
        the grid of the half space.
    """

    pressure: np.ndarray
    height: float
    energy: float
    error: float
    converged: bool
    message: str
    pairs: float


def precision_advice(halfspace: HalfSpace) -> str:
    """Return an addition to messages about rounding errors in single precision."""
    if np.dtype(halfspace.fft.get("dtype", float)) == np.float64:
        return ""
    return " (the transforms are in single precision: use fft dtype float64)"


def without_rounding(pressure: np.ndarray) -> np.ndarray:
    """Return a pressure with the entries set to zero that are only rounding errors."""
    return np.where(abs(pressure) < 1e-9 * abs(pressure).max(), 0.0, pressure)


def indenter_stiffness(contact: Contact) -> float:
    """Return the stiffness ``2 E* a`` (force per length) of half the window's width."""
    n, m = contact.halfspace.shape
    halfspace = contact.halfspace
    return halfspace.contact_modulus * halfspace.spacing * (n * m) ** 0.5
