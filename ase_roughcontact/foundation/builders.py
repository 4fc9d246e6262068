"""Construction of slabs of atoms on an elastic foundation."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

from ase import Atoms

from ase_roughcontact._util.validation import boolean, grid_shape, instance_of, integer
from ase_roughcontact.foundation.calculator import ElasticFoundation
from ase_roughcontact.foundation.surface import CrystalSurface


def crystal_slab(
    symbol: str | Atoms,
    size: tuple[int, int],
    layers: int,
    calculator: Any,
    surface: str | CrystalSurface = "fcc100",
    *,
    held: bool | Literal["lowest", "surface"] = True,
    fft: Mapping[str, Any] | None = None,
) -> tuple[Atoms, ElasticFoundation]:
    """Return the upper layers of a crystal, and their elastic foundation as calculator.

    Parameters
    ----------
    symbol : str or Atoms
        Chemical symbol, or a crystal of one element; see
        `CrystalSurface.from_calculator`.
    size : (int, int)
        Numbers of surface cells along both sides.
    layers : int
        Number of explicit layers.
    calculator : Calculator
        Any ASE calculator of energies and forces.
    surface : {"fcc100", "fcc111", "bcc100", "diamond100"} or CrystalSurface
        The surface. `CrystalSurface.from_calculator` calculates a surface that is given
        by name, which takes about ten seconds for EMT.
    held : bool or {"lowest", "surface"}
        Layer that is held against loads on the surface, see `ElasticFoundation.hold`.
        True stands for the lowest layer; with False no layer is held.
    fft : dict, optional
        Options of the transforms, see `RealFFT2`: `dtype`, `engine`, `threads`.

    Returns
    -------
    atoms : Atoms
        Relaxed atoms, ordered from the lowest layer up, with the surface at z = 0 and
        the foundation as calculator. Tags count the layers, 1 at the surface.
    foundation : ElasticFoundation
        The calculator of the atoms.

    Raises
    ------
    ValueError
        See `CrystalSurface.from_calculator` and `ElasticFoundation`; also if the
        surface has another element.

    Examples
    --------
    >>> from ase.calculators.emt import EMT
    >>> from ase_roughcontact.foundation import crystal_slab
    >>> atoms, foundation = crystal_slab("Cu", (8, 8), 4, EMT())  # doctest: +SKIP
    """
    instance_of((str, Atoms), symbol=symbol)
    instance_of((str, CrystalSurface), surface=surface)
    if not isinstance(held, str):
        boolean(held=held)
    n, m = grid_shape(size)
    integer("layers", layers, 1)
    if isinstance(surface, str):
        surface = CrystalSurface.from_calculator(calculator, symbol, surface)
    elements = {symbol} if isinstance(symbol, str) else set(symbol.symbols)
    if elements != {surface.symbol}:
        raise ValueError(
            f"symbol must be {surface.symbol}, the element of the surface, got "
            f"{', '.join(elements)}"
        )
    column = surface.column(layers)
    column.set_tags(range(1, layers + 1))
    atoms = column.repeat((n, m, 1))
    atoms = atoms[atoms.positions[:, 2].argsort(kind="stable")]
    foundation = ElasticFoundation(calculator, surface, atoms, layers, fft=fft)
    atoms.calc = foundation
    if held:
        foundation.hold(atoms, held if isinstance(held, str) else "lowest")
    return atoms, foundation
