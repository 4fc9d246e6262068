r"""Force constants of a crystal with a free surface, from an ASE calculator.

A slab with one atom per layer in each surface cell is relaxed, and one atom of each
layer from the surface to the middle is displaced (or the calculator's Hessian is
read). Every coupling is stored with the true distance of the two atoms along the
surface, so that the couplings deep in the crystal depend on the distance of the layers
alone, and in diamond, whose two sublattices have alternate layers, on the sublattice.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from ase import Atoms
from ase.build import bcc100, diamond100, fcc100, fcc111
from ase.optimize import BFGS

from ase_roughcontact._util.validation import integer, lookup, positive

#: Builders of surfaces, by name.
SURFACES = {
    "fcc100": fcc100,
    "fcc111": fcc111,
    "bcc100": bcc100,
    "diamond100": diamond100,
}
#: Sublattices of a crystal, on alternate layers, by the name of its surface.
SUBLATTICES = dict.fromkeys(SURFACES, 1) | {"diamond100": 2}

_VACUUM = 10.0  # on both sides of a slab (Å)
# Couplings below this part of the largest one are left out.
_NEGLIGIBLE = 1e-9
# Largest force on a relaxed slab (eV/Å), and largest number of iterations.
_FMAX, _MAX_STEPS = 1e-6, 1000
# Relative change of the couplings of metals with the distance of atoms.
_ANHARMONICITY = 10.0


@dataclass(frozen=True, eq=False)
class ForceConstants:
    """Couplings of a crystal with a surface.

    Attributes
    ----------
    source, target : ndarray of int, shape (n,)
        Layers of the two atoms of a coupling, 0 at the surface. Sources are the
        layers down to the middle of the slab; the last one of each sublattice
        represents the bulk.
    offset : ndarray, shape (n, 2)
        Position of the target relative to the source along the surface (length).
    matrix : ndarray, shape (n, 3, 3)
        ``d^2 U/(du_source du_target)`` (force/length).
    spacing : float
        Distance of nearest neighbours in the surface (length).
    figures : dict
        Errors of the couplings, each relative to the largest one: "sum_rule" (their
        sum for one atom), "symmetry" (under exchange of the two atoms), "reach" (those
        across half of the slab's side), "repetition" (change of the forces when they
        are calculated again), "rest" (change by the forces on the slab before an atom
        is displaced, if a strain changes couplings by ten times as much).
    sublattices : int
        Number of sublattices, on alternate layers.
    """

    source: np.ndarray
    target: np.ndarray
    offset: np.ndarray
    matrix: np.ndarray
    spacing: float
    figures: dict[str, float]
    sublattices: int = 1

    @property
    def bulk(self) -> int:
        """Index of the first layer that represents the bulk."""
        return int(self.source.max()) + 1 - self.sublattices

    @property
    def reach(self) -> int:
        """Number of layers, of all sublattices, that the bulk is coupled to."""
        bulk = self.source >= self.bulk
        layers = abs(self.target[bulk] - self.source[bulk]).max()
        return int(-(-layers // self.sublattices) * self.sublattices)


def relaxed_slab(
    calculator: Any, symbol: str, surface: str, a: float, layers: int
) -> Atoms:
    """Return a slab of one surface cell, relaxed, without a calculator.

    It is ordered from the surface down; ``a`` is its lattice constant (Å).
    """
    build = lookup(surface, SURFACES, "surface")
    atoms = build(symbol, (1, 1, layers), a=a, vacuum=_VACUUM)[::-1]
    atoms.calc = calculator
    try:
        converged = BFGS(atoms, logfile=None).run(fmax=_FMAX, steps=_MAX_STEPS)
    except Exception as error:
        raise ValueError(
            f"{type(calculator).__name__} gives no forces for a slab of {layers} "
            f"layers of {surface} {symbol}: {error}"
        ) from error
    if not converged or not np.isfinite(atoms.positions).all():
        raise ValueError(
            f"a slab of {layers} layers of {surface} {symbol} does not relax to forces "
            f"of {_FMAX:g} eV/Å: check the calculator"
        )
    atoms.calc = None
    return atoms


def force_constants(
    calculator: Any,
    slab: Atoms,
    size: int,
    displacement: float = 1e-3,
    sublattices: int = 1,
) -> ForceConstants:
    """Return the force constants of a slab down to its middle.

    They are read from the Hessian of calculators that have the method `get_hessian`,
    as those of matscipy do, and are central differences of forces otherwise.

    Parameters
    ----------
    calculator : Calculator
    slab : Atoms
        One surface cell, see `relaxed_slab`; an odd number of layers.
    size : int
        Number of surface cells along each side of the slab; odd. It must be larger
        than twice the reach of the force constants.
    displacement : float, optional
        Displacement for the differences (Å); 0 for the Hessian.
    sublattices : int, optional
        Number of sublattices, see `SUBLATTICES`.

    Returns
    -------
    ForceConstants

    Raises
    ------
    ValueError
        If the numbers of layers or cells are not odd, forces are not finite, or a
        calculator without a Hessian is asked for it.
    """
    layers = len(slab)
    if layers % 2 == 0 or integer("size", size, 3) % 2 == 0:
        raise ValueError(
            f"layers and size must be odd, got {layers} layers and a size of {size}"
        )
    middle, half = layers // 2, [size // 2, size // 2 + 1]
    atoms = slab.repeat((size, size, 1))
    atoms.calc = calculator
    reference = atoms.get_forces()
    source, target, offset, matrix = couplings(
        calculator, slab, size, range(middle + 1), displacement
    )
    scale = abs(matrix).max()
    if scale == 0.0:
        raise ValueError(
            "the calculator returns the same forces for displaced atoms: check it, or "
            "increase displacement"
        )
    repetition = np.zeros(1)
    if displacement != 0.0:
        repetition = (atoms.get_forces() - reference) / displacement
    spacing = float(np.linalg.norm(slab.cell[0]))
    # couplings of one atom of each layer to those of all cells and layers
    blocks = matrix.reshape(middle + 1, size, size, layers, 3, 3)
    known, back = blocks[:, :, :, : middle + 1], -np.arange(size) % size
    exchanged = known[:, back][:, :, back].transpose(3, 1, 2, 0, 5, 4)
    far = blocks[:, half], blocks[:, :, half], blocks[-sublattices:, ..., [0, -1], :, :]
    errors = {
        "sum_rule": blocks.sum(axis=(1, 2, 3)),
        "symmetry": known - exchanged,
        "reach": np.concatenate([each.ravel() for each in far]),
        "repetition": repetition,
        "rest": _ANHARMONICITY * reference / spacing,
    }
    figures = {name: float(abs(e).max() / scale) for name, e in errors.items()}
    kept = abs(matrix).max(axis=(1, 2)) > _NEGLIGIBLE * scale
    return ForceConstants(
        source[kept],
        target[kept],
        offset[kept],
        matrix[kept],
        spacing,
        figures,
        sublattices,
    )


def couplings(
    calculator: Any,
    slab: Atoms,
    size: int,
    sources: Sequence[int],
    displacement: float = 1e-3,
) -> tuple[np.ndarray, ...]:
    """Return the couplings of some layers of a slab to all layers.

    See `force_constants`. They are source, target, offset and matrix as in
    `ForceConstants`, by source, cell and target; distances are within half of the side
    of the repeated slab.
    """
    atoms = slab.repeat((size, size, 1))
    atoms.calc = calculator
    atoms.get_forces()  # the Hessian may need the atoms that the calculator knows
    if displacement == 0.0:
        if not hasattr(atoms.calc, "get_hessian"):
            raise ValueError(
                f"{type(atoms.calc).__name__} has no method get_hessian: give a "
                "displacement that is not 0"
            )
        index = (3 * np.array(sources)[:, None] + np.arange(3)).ravel()
        hessian = atoms.calc.get_hessian(atoms, format="sparse").tocsr()[index]
    else:
        # its import takes as long as a small contact
        from matscipy.numerical import numerical_hessian

        positive(displacement=displacement)
        hessian = numerical_hessian(atoms, displacement, sources)
    rows = hessian.toarray().reshape(len(sources), 3, len(atoms), 3).swapaxes(1, 2)
    if not np.isfinite(rows).all():
        raise ValueError("the calculator returns forces that are not finite")
    layers, half = len(slab), size // 2
    cell, layer = np.divmod(np.arange(len(atoms)), layers)
    steps = (np.stack(np.divmod(cell, size), -1) + half) % size - half
    source, target = np.repeat(sources, len(atoms)), np.tile(layer, len(sources))
    positions = slab.positions[:, :2]
    offset = positions[target] - positions[source]
    offset += np.tile(steps @ slab.cell[:2, :2], (len(sources), 1))
    return source, target, offset, rows.reshape(-1, 3, 3)
