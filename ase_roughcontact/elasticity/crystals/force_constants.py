r"""Force constants of a crystal with a free surface, from an ASE calculator.

A slab with one atom per layer in each surface cell is relaxed, and one atom of each
layer from the surface to the middle is displaced (or the calculator's Hessian is
read). Every coupling is stored with the true distance of the two atoms along the
surface. Deep in the crystal the couplings then depend only on the distance of the
layers, and in diamond, where two sublattices have alternate layers, on the sublattice.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from ase import Atoms
from ase.build import bcc100, diamond100, fcc100, fcc111
from ase.optimize import BFGS

from ase_roughcontact._util.summary import Summarized
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

# Vacuum on each side of a slab (Å).
_VACUUM = 10.0
# Smallest coupling that is kept, relative to the largest one.
_MIN_COUPLING = 1e-9
# Largest force on an atom of a relaxed slab (eV/Å).
_FMAX = 1e-6
# Largest number of iterations of the relaxation.
_MAX_STEPS = 1000
# Relative change of the couplings of metals over the strain that causes it.
_ANHARMONICITY = 10.0


@dataclass(frozen=True, eq=False)
class ForceConstants(Summarized):
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
        Errors of the couplings, each relative to the largest one: "sum_rule" (sum of
        the couplings of an atom), "symmetry" (difference under exchange of the two
        atoms), "reach" (couplings across half of the slab's side), "repetition" (change
        of the forces when they are calculated again), "rest" (change by the forces on
        the slab before an atom is displaced, if a strain changes couplings by ten times
        as much).
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
        """Number of layers to which a bulk layer is coupled, for all sublattices."""
        bulk = self.source >= self.bulk
        layers = abs(self.target[bulk] - self.source[bulk]).max()
        return int(-(-layers // self.sublattices) * self.sublattices)


def relaxed_slab(
    calculator: Any, symbol: str, surface: str, a: float, layers: int
) -> Atoms:
    """Return a relaxed slab of one surface cell, without a calculator.

    Its atoms are ordered from the surface down; ``a`` is the lattice constant (Å).
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

    Central differences of forces give them, or the method `get_hessian` of the
    calculator, which calculators of matscipy have.

    Parameters
    ----------
    calculator : Calculator
        ASE calculator of the forces.
    slab : Atoms
        One surface cell with an odd number of layers, see `relaxed_slab`.
    size : int
        Number of surface cells along each side of the slab; odd. It must be larger
        than twice the reach of the force constants.
    displacement : float, optional
        Displacement for the differences (Å); 0 for the Hessian of the calculator.
    sublattices : int, optional
        Number of sublattices, see `SUBLATTICES`.

    Returns
    -------
    ForceConstants
        Couplings, with the errors of the list there.

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
    # couplings of one atom of each layer to the atoms of all cells and layers
    blocks = matrix.reshape(middle + 1, size, size, layers, 3, 3)
    upper, opposite = blocks[:, :, :, : middle + 1], -np.arange(size) % size
    exchanged = upper[:, opposite][:, :, opposite].transpose(3, 1, 2, 0, 5, 4)
    far = blocks[:, half], blocks[:, :, half], blocks[-sublattices:, ..., [0, -1], :, :]
    errors = {
        "sum_rule": blocks.sum(axis=(1, 2, 3)),
        "symmetry": upper - exchanged,
        "reach": np.concatenate([each.ravel() for each in far]),
        "repetition": repetition,
        "rest": _ANHARMONICITY * reference / spacing,
    }
    figures = {name: float(abs(e).max() / scale) for name, e in errors.items()}
    kept = abs(matrix).max(axis=(1, 2)) > _MIN_COUPLING * scale
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

    See `force_constants` for the parameters. The arrays source, target, offset and
    matrix, as in `ForceConstants`, are sorted by source, cell and target; offsets are
    within half of the side of the repeated slab.
    """
    atoms = slab.repeat((size, size, 1))
    atoms.calc = calculator
    atoms.get_forces()  # the Hessian of some calculators needs a calculation before
    if displacement == 0.0:
        if not hasattr(atoms.calc, "get_hessian"):
            raise ValueError(
                f"{type(atoms.calc).__name__} has no method get_hessian: give a "
                "displacement that is not 0"
            )
        index = (3 * np.array(sources)[:, None] + np.arange(3)).ravel()
        hessian = atoms.calc.get_hessian(atoms, format="sparse").tocsr()[index]
    else:
        # the import takes as long as a small contact
        from matscipy.numerical import numerical_hessian

        positive(displacement=displacement)
        hessian = numerical_hessian(atoms, displacement, sources)
    rows = hessian.toarray().reshape(len(sources), 3, len(atoms), 3).swapaxes(1, 2)
    if not np.isfinite(rows).all():
        raise ValueError("the calculator returns forces that are not finite")
    layers, half = len(slab), size // 2
    cell, layer = np.divmod(np.arange(len(atoms)), layers)
    cells = (np.stack(np.divmod(cell, size), -1) + half) % size - half
    source, target = np.repeat(sources, len(atoms)), np.tile(layer, len(sources))
    positions = slab.positions[:, :2]
    offset = positions[target] - positions[source]
    offset += np.tile(cells @ slab.cell[:2, :2], (len(sources), 1))
    return source, target, offset, rows.reshape(-1, 3, 3)
