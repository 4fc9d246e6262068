"""Moduli of a viscoelastic solid over frequency."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ase_roughcontact.elasticity.creep import RelaxationFit
from ase_roughcontact.plot.style import BLUE, ORANGE

# Number of points of fitted moduli.
_CURVE_POINTS = 400


def plot_moduli(
    axes: Any,
    fit: RelaxationFit,
    frequencies: ArrayLike,
    storage: ArrayLike,
    loss: ArrayLike,
    unit: str = "Pa",
) -> Any:
    """Plot measured storage and loss moduli, and the relaxation series fitted to them.

    Parameters
    ----------
    axes : matplotlib Axes
    fit : RelaxationFit
        Relaxation series from `elasticity.fit_relaxation`.
    frequencies : array_like, shape (n,)
        Angular frequencies (rad/s).
    storage, loss : array_like, shape (n,)
        Measured moduli.
    unit : str
        Unit of the moduli, for the label.

    Returns
    -------
    matplotlib Axes
    """
    omega = np.asarray(frequencies, dtype=float)
    line = np.geomspace(omega.min(), omega.max(), _CURVE_POINTS)
    fitted = fit.modulus * fit.creep.modulus(line)
    axes.loglog(omega, storage, "o", color=BLUE, label="storage")
    axes.loglog(line, fitted.real, color=BLUE, label="fit")
    axes.loglog(omega, loss, "s", color=ORANGE, label="loss")
    axes.loglog(line, fitted.imag, "--", color=ORANGE, label="fit")
    axes.set(xlabel="angular frequency (rad/s)", ylabel=f"modulus ({unit})")
    axes.set_title(f"rms error {100.0 * fit.error:.2g} %", loc="right")
    axes.legend(ncols=2)
    return axes
