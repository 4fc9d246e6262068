r"""Contact modulus of a crystal from its elastic constants, and hardness.

The contact modulus under a rigid indenter is

.. math:: E^* = \frac{E}{1 - \nu^2} .

A crystal is replaced by its isotropic average after Voigt, Reuss and Hill.
"""

from __future__ import annotations

import math
from functools import cache
from importlib.resources import files

import numpy as np
from ase.data import atomic_numbers, chemical_symbols, reference_states

from ase_roughcontact._util.files import tomllib
from ase_roughcontact._util.validation import check_poisson, finite_array, positive

#: Contents of the file ``materials.toml``.
TABLES = tomllib.loads(
    files("ase_roughcontact.elasticity").joinpath("materials.toml").read_text("utf-8")
)
#: Elastic constants C11, C12 and C44 of cubic crystals at room temperature (GPa).
#: Sources are in the file ``materials.toml``.
CRYSTALS: dict[str, tuple[float, float, float]] = {
    symbol: (c11, c12, c44) for symbol, (c11, c12, c44) in TABLES["crystals"].items()
}

#: Hardness of pure, soft elements (GPa): mean pressure under a plastic indentation.
#: Cold work raises it. Sources are in the file ``materials.toml``.
HARDNESS = TABLES["hardness"]


def cubic_stiffness(c11: float, c12: float, c44: float) -> np.ndarray:
    """Return the stiffness of a cubic crystal in Voigt's notation, shape (6, 6)."""
    stiffness = np.diag([c11 - c12] * 3 + [c44] * 3)
    stiffness[:3, :3] += c12
    return stiffness


def contact_modulus(elastic_constants: object) -> float:
    r"""Return the contact modulus of the isotropic average of a crystal.

    With bulk modulus :math:`B` and shear modulus :math:`\mu`, each the mean of Voigt's
    and Reuss's bounds,

    .. math:: E^* = \frac{E}{1 - \nu^2} = \frac{4 \mu (3 B + \mu)}{3 B + 4 \mu}.

    Parameters
    ----------
    elastic_constants : array_like, shape (3,) or (6, 6)
        C11, C12 and C44 of a cubic crystal, or the stiffness in Voigt's notation
        (pressure).

    Returns
    -------
    float
        E* (pressure).

    Raises
    ------
    ValueError
        If the constants have another shape or are not finite, or the crystal is not
        stable (its stiffness is not positive definite).

    References
    ----------
    R. Hill, Proc. Phys. Soc. A 65, 349 (1952).

    Examples
    --------
    >>> from ase_roughcontact.elasticity.material import CRYSTALS, contact_modulus
    >>> round(contact_modulus(CRYSTALS["Cu"]), 1)
    144.6
    """
    bulk, shear = _isotropic_moduli(elastic_constants)
    return 4.0 * shear * (3.0 * bulk + shear) / (3.0 * bulk + 4.0 * shear)


def plane_strain_modulus(youngs_modulus: float, poisson: float) -> float:
    """Return the contact modulus E/(1 - nu^2) of an isotropic solid.

    Parameters
    ----------
    youngs_modulus : float
        Young's modulus E (pressure).
    poisson : float
        Poisson's ratio nu, above -1 and at most 1/2.

    Returns
    -------
    float
        E* (pressure).

    Raises
    ------
    ValueError
        If a value is out of range.

    Examples
    --------
    >>> round(plane_strain_modulus(70.0, 0.3), 2)
    76.92
    """
    positive(youngs_modulus=youngs_modulus)
    check_poisson(poisson=poisson)
    return youngs_modulus / (1.0 - poisson**2)


def poisson_ratio(elastic_constants: object) -> float:
    """Return Poisson's ratio of the isotropic average; see `contact_modulus`."""
    bulk, shear = _isotropic_moduli(elastic_constants)
    return (3.0 * bulk - 2.0 * shear) / (6.0 * bulk + 2.0 * shear)


def _isotropic_moduli(elastic_constants: object) -> tuple[float, float]:
    """Return bulk and shear modulus of the isotropic average of a crystal."""
    constants = finite_array("elastic_constants", elastic_constants)
    if constants.shape == (3,):
        constants = cubic_stiffness(*constants)
    if constants.shape != (6, 6):
        raise ValueError(
            "elastic_constants must be (C11, C12, C44) or a 6 x 6 matrix, got shape "
            f"{constants.shape}"
        )
    if not np.allclose(constants, constants.T) or np.linalg.eigvalsh(constants)[0] <= 0:
        raise ValueError(
            "elastic_constants must be symmetric and positive definite (a stable "
            f"crystal), got {np.asarray(elastic_constants).tolist()}"
        )
    return _hill(constants, np.linalg.inv(constants))


def crystal_constants(symbol: str) -> tuple[float, float, float]:
    """Return C11, C12 and C44 of a crystal in the table `CRYSTALS` (GPa).

    Raises
    ------
    ValueError
        If the crystal is not in the table.
    """
    if symbol not in CRYSTALS:
        raise ValueError(
            f"the elastic constants of {symbol!r} are not known: give them, or the "
            f"contact modulus, or one of {', '.join(CRYSTALS)}"
        )
    return CRYSTALS[symbol]


@cache
def crystal_modulus(symbol: str) -> float:
    """Return the contact modulus of the isotropic average of a crystal (GPa).

    Parameters
    ----------
    symbol : str
        Chemical symbol of a crystal in the table `CRYSTALS`.

    Returns
    -------
    float
        E* (GPa).

    Raises
    ------
    ValueError
        If the crystal is not in the table.
    """
    return contact_modulus(crystal_constants(symbol))


def _hill(stiffness: np.ndarray, compliance: np.ndarray) -> tuple[float, float]:
    """Return Hill's averages of the bulk and the shear modulus."""
    total, trace, shear = _block_sums(stiffness)
    voigt_bulk = total / 9.0
    voigt_shear = (3.0 * trace - total + 6.0 * shear) / 30.0
    total, trace, shear = _block_sums(compliance)
    reuss_bulk = 1.0 / total
    reuss_shear = 7.5 / (3.0 * trace - total + 1.5 * shear)
    return (voigt_bulk + reuss_bulk) / 2.0, (voigt_shear + reuss_shear) / 2.0


def _block_sums(matrix: np.ndarray) -> tuple[float, float, float]:
    """Return the sum and the trace of the normal block, and the trace of shear."""
    normal, shear = matrix[:3, :3], matrix[3:, 3:]
    return float(normal.sum()), float(np.trace(normal)), float(np.trace(shear))


def fcc_spacing(symbol: str) -> float:
    """Return the spacing of atoms in a (100) surface, a/sqrt(2).

    It holds for fcc crystals and for unreconstructed diamond structures.

    Parameters
    ----------
    symbol : str
        Chemical symbol.

    Returns
    -------
    float
        Spacing (Å).

    Raises
    ------
    ValueError
        If the symbol is unknown, or its reference crystal is neither fcc nor diamond.
    """
    check_element(symbol)
    state = reference_states[atomic_numbers[symbol]]
    if state is None or state.get("symmetry") not in ("fcc", "diamond"):
        raise ValueError(
            f"the (100) surface of {symbol} is not known: its crystal is neither fcc "
            "nor diamond in ASE's reference states; give spacing"
        )
    return float(state["a"] / math.sqrt(2))


def surface_spacing(symbol: str) -> float:
    """Return the spacing of atoms in a (100) surface, also of a bcc crystal (Å).

    Raises
    ------
    ValueError
        See `fcc_spacing`.
    """
    check_element(symbol)
    state = reference_states[atomic_numbers[symbol]]
    if state is not None and state.get("symmetry") == "bcc":
        return float(state["a"])
    return fcc_spacing(symbol)


def check_element(symbol: str) -> None:
    """Raise `ValueError` for an unknown chemical symbol."""
    if symbol not in chemical_symbols[1:]:
        raise ValueError(f"unknown chemical symbol {symbol!r}")
