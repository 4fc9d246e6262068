"""Errors of the modulus of a crystal, and what to do about them."""

from __future__ import annotations

import numpy as np

from ase_roughcontact.elasticity.crystals.angular import cos2, sin2
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
    "square": "the surface does not have the symmetry of its structure",
    "interpolation": "the modulus is not smooth: check the force constants",
    "long_waves": "the forces in the slab are not those of the energies of strained "
    "bulk: the calculator describes slabs in another way than crystals, or its forces "
    "have noise that a larger displacement reduces",
}

# Waves along the surface, times the spacing, at which the modulus is compared.
_NUMBERS = np.linspace(0.03, 0.97, 12) * np.pi
_WAVES = np.array([[q, q * part] for q in _NUMBERS for part in np.linspace(0, 1, 5)])
# Wave number, times the spacing, and directions of long waves.
_LONG, _ANGLES = 1e-3, np.linspace(0.0, np.pi, 24, endpoint=False)


def inverse_modulus(
    greens: LatticeGreensFunction, q: np.ndarray, cell_area: float
) -> np.ndarray:
    """Return ``1/E*(q) = cell_area |q| G_zz(q) / 2`` at wave vectors, shape (n, 2)."""
    return 0.5 * cell_area * np.hypot(*q.T) * greens(q)[:, 2, 2].real


def long_wave_compliance(greens: LatticeGreensFunction, cell_area: float) -> np.ndarray:
    """Return ``1/E*(theta)`` of long waves at angles between 0 and pi, shape (n,)."""
    waves = _LONG / greens.spacing * np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], -1)
    once, twice = (inverse_modulus(greens, n * waves, cell_area) for n in (1, 2))
    return 2.0 * once - twice  # linear in the wave number


def surface_errors(
    thick: LatticeGreensFunction,
    thin: LatticeGreensFunction,
    cell_area: float,
    moduli: np.ndarray,
) -> dict[str, float]:
    """Return the errors "thickness" and "long_waves" of a surface, see `Crystal`.

    The moduli of the bulk are a full tensor.
    """
    q = _WAVES / thick.spacing
    change = inverse_modulus(thin, q, 1.0) / inverse_modulus(thick, q, 1.0) - 1.0
    long = long_wave_compliance(thick, cell_area) * surface_modulus(moduli, _ANGLES)
    return {
        "thickness": float(abs(change).max()),
        "long_waves": float(abs(long - 1.0).max()),
    }


def modulus_table(
    greens: LatticeGreensFunction,
) -> tuple[np.ndarray, dict[str, float]]:
    """Return the coefficients of ``1/E*``, see `interpolate`, and their errors.

    They are "square" and "interpolation", see `Crystal`.
    """

    def inverse(q: np.ndarray) -> np.ndarray:
        return inverse_modulus(greens, q / greens.spacing, greens.spacing**2)

    nodes = node_vectors()
    values = inverse(nodes)
    if greens.sublattices == 1:
        table = interpolation_table(values)
    else:  # the rows of atoms along x and y are not equivalent
        exchanged = inverse(nodes[:, ::-1])
        other = (values - exchanged) / cos2(*nodes.T)
        parts = (values + exchanged) / 2.0, other / 2.0
        table = np.stack([interpolation_table(part) for part in parts])
    x, y = _WAVES.T
    interpolation, *others = (
        float(abs(inverse(np.stack(q, -1)) / interpolate(table, *q) - 1.0).max())
        for q in ((x, y), (x, -y), (y, x), (-x, y))
    )
    return table, {"square": max(others), "interpolation": interpolation}


def lateral_tables(greens: LatticeGreensFunction) -> np.ndarray:
    """Return the coefficients of the lateral components, see `Crystal.lateral`."""
    nodes = node_vectors()

    def components(q: np.ndarray) -> np.ndarray:
        matrix, number = greens(q / greens.spacing), np.hypot(*q.T)
        lateral = matrix[:, (0, 1, 0), (0, 1, 1)].real.T
        lateral[2] /= sin2(*q.T)
        cross = -matrix[:, :2, 2].imag.T * number / q.T
        return 0.5 * greens.spacing * number * np.concatenate([lateral, cross])

    values, exchanged = components(nodes), components(nodes[:, ::-1])
    values[4], exchanged[4] = exchanged[4], values[4].copy()  # y before x
    other = (values - exchanged) / cos2(*nodes.T)
    if greens.sublattices == 1:
        other[2] = 0.0  # but for rounding, which its expansion would amplify
    parts = np.stack([values + exchanged, other], axis=1) / 2.0
    return np.array([[interpolation_table(v) for v in part] for part in parts])


def check_errors(figures: dict[str, float], tolerance: float, name: str) -> None:
    """Raise an error about the first figure in the order of the advice."""
    for figure, advice in ADVICE.items():
        if not figures.get(figure, 0.0) <= tolerance:  # or not a number
            raise ValueError(
                f"the relative error {figure!r} of {name} is {figures[figure]:.2g}, "
                f"above {tolerance:g}: {advice}"
            )
