"""Errors of the modulus of a crystal, and what to do about them."""

from __future__ import annotations

import numpy as np

from ase_roughcontact.elasticity.crystals.cubic import surface_modulus
from ase_roughcontact.elasticity.crystals.kernel import (
    interpolate,
    interpolation_table,
    node_vectors,
)
from ase_roughcontact.elasticity.crystals.lattice_greens import LatticeGreensFunction

#: What to do about an error of a crystal, by its name.
ADVICE = {
    "repetition": "the calculator returns other forces when asked again",
    "rest": "the relaxed slab has forces once it is repeated along the surface: the "
    "calculator describes large slabs in another way than small ones",
    "sum_rule": "the forces on all atoms have a resultant that is not zero",
    "symmetry": "the forces are not those of an energy, or change the displacement",
    "reach": "the forces reach beyond the slab: increase size and layers",
    "thickness": "the slab is too thin, or its forces are not linear in the "
    "displacement: increase layers, or decrease displacement",
    "square": "the surface is not that of a square grid",
    "interpolation": "the modulus is not smooth: check the force constants",
    "long_waves": "the forces in the slab are not those of the energies of strained "
    "bulk: the calculator describes slabs in another way than crystals, or its forces "
    "have noise that a larger displacement reduces",
}

# Wave number, in units of 1/a0, of waves that see a continuum.
_LONG = 1e-6


def _inverse_modulus(greens: LatticeGreensFunction, q: np.ndarray) -> np.ndarray:
    """Return ``1/E*`` at wave vectors in units of 1/a0, shape (n, 2)."""
    compliance = greens(q / greens.spacing)[:, 2, 2].real
    return 0.5 * greens.spacing * np.hypot(*q.T) * compliance


def modulus_table(greens: LatticeGreensFunction) -> np.ndarray:
    """Return the coefficients of ``1/E*``; see `interpolation_table`."""
    return interpolation_table(_inverse_modulus(greens, node_vectors()))


def modulus_errors(
    table: np.ndarray,
    thick: LatticeGreensFunction,
    thin: LatticeGreensFunction,
    moduli: np.ndarray,
) -> dict[str, float]:
    """Return the relative errors of the modulus of a crystal.

    Parameters
    ----------
    table : ndarray
        Coefficients of the thick slab, see `modulus_table`.
    thick, thin : LatticeGreensFunction
        From slabs of different thickness.
    moduli : ndarray, shape (3, 3, 3, 3)
        Of the bulk, see `nominal_moduli`.

    Returns
    -------
    dict of float
    """
    numbers = np.linspace(0.03, 0.97, 12) * np.pi
    q = np.stack(
        [np.repeat(numbers, 5), np.outer(numbers, np.linspace(0, 1, 5)).ravel()]
    )
    expected = interpolate(table, *q)

    def error(greens: LatticeGreensFunction, q: np.ndarray) -> float:
        return float(abs(_inverse_modulus(greens, q.T) / expected - 1.0).max())

    turned = np.array([[q[0], -q[1]], [q[1], q[0]], [-q[0], q[1]]])
    angles = np.linspace(0.0, np.pi / 4, 5)
    long_waves = interpolate(
        table, *(_LONG * np.array([np.cos(angles), np.sin(angles)]))
    )
    return {
        "thickness": error(thin, q),
        "square": max(error(thick, other) for other in turned),
        "interpolation": error(thick, q),
        "long_waves": float(
            abs(long_waves * surface_modulus(moduli, angles) - 1.0).max()
        ),
    }


def check_errors(figures: dict[str, float], tolerance: float, name: str) -> None:
    """Raise an error about the first figure in the order of the advice."""
    for figure, advice in ADVICE.items():
        if not figures.get(figure, 0.0) <= tolerance:  # or not a number
            raise ValueError(
                f"the relative error {figure!r} of {name} is {figures[figure]:.2g}, "
                f"above {tolerance:g}: {advice}"
            )
