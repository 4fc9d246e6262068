r"""Materials of tips and substrates by name: moduli, hardness and work of adhesion.

Two elastic bodies are replaced by a rigid body and a body with the contact modulus

.. math:: \frac{1}{E^*} = \frac{1 - \nu_1^2}{E_1} + \frac{1 - \nu_2^2}{E_2} .

The work of adhesion by van der Waals forces across vacuum is
:math:`w = 2 \sqrt{\gamma_1 \gamma_2}`, with the surface energies :math:`\gamma = A/(24
\pi D_0^2)` from the Hamaker constants A and :math:`D_0 = 0.165` nm. Water films,
chemical bonds and charges add to it; contamination reduces it. :math:`D_0` is also a
typical range of the attraction: the Lennard-Jones form of two half spaces with the same
Hamaker constant and w has its minimum at :math:`\sqrt{3} D_0/2` = 0.143 nm.

References
----------
J. N. Israelachvili, Intermolecular and Surface Forces, 3rd ed. (2011), Ch. 13.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

from ase.data import atomic_names, atomic_numbers, chemical_symbols

from ase_roughcontact._util.validation import shown
from ase_roughcontact.elasticity.creep import Creep
from ase_roughcontact.elasticity.material import (
    CRYSTALS,
    HARDNESS,
    TABLES,
    crystal_constants,
    crystal_modulus,
    plane_strain_modulus,
    poisson_ratio,
)

#: Cutoff :math:`D_0` of van der Waals forces (nm), a typical range of the attraction.
ATTRACTION_RANGE = 0.165


@dataclass(frozen=True)
class Material:
    """Elastic and adhesive properties of a material.

    Attributes
    ----------
    contact_modulus : float
        Contact modulus E/(1 - nu^2) (GPa).
    source : str
        Source of the modulus.
    symbol : str
        Chemical symbol for the atoms.
    spacing : float or None
        Distance of the atoms (Å): the spacing of the square lattice of a (100) surface,
        or, for amorphous and layered solids, the edge of a cube with the mean volume of
        an atom. None for the distance of nearest neighbours in an fcc crystal.
    surface_energy : float or None
        Dispersive surface energy (J/m^2), None if it is not known.
    adhesion_source : str
        Source of the surface energy.
    poisson : float or None
        Poisson's ratio; an average for cubic crystals, None for other anisotropic
        solids.
    hardness : float
        Mean pressure under a plastic indentation (GPa); infinity for a rubber, which
        recovers, NaN if it is not known.
    hardness_source : str
        Source of the hardness.
    crystalline : bool
        Whether the solid is a cubic crystal, with atoms on the lattice of its surface.
    """

    contact_modulus: float
    source: str
    symbol: str
    spacing: float | None = None
    surface_energy: float | None = None
    adhesion_source: str = ""
    poisson: float | None = None
    hardness: float = math.nan
    hardness_source: str = ""
    crystalline: bool = False


def indentation_modulus(c11: float, c33: float, c13: float, c44: float) -> float:
    """Return the contact modulus of a transversely isotropic solid along its axis, 3.

    References
    ----------
    A. Delafargue, F.-J. Ulm, Int. J. Solids Struct. 41, 7351 (2004).
    """
    mean = math.sqrt(c11 * c33)
    shear = 1.0 / c44 + 2.0 / (mean + c13)
    return 2.0 * math.sqrt((c11 * c33 - c13**2) / (c11 * shear))


def _read(
    crystal: str = "",
    isotropic: tuple[float, float] | None = None,
    axial: tuple[float, ...] = (),
    hamaker: float | None = None,
    **entry: Any,
) -> Material:
    """Return the material of an entry of the file ``materials.toml``."""
    moduli: tuple[float, float | None]
    if crystal:
        entry["crystalline"] = True
        entry["hardness"] = HARDNESS.get(crystal, math.nan)
        entry["hardness_source"] = "table of the elements"
        moduli = crystal_modulus(crystal), poisson_ratio(crystal_constants(crystal))
    elif isotropic:
        moduli = plane_strain_modulus(*isotropic), isotropic[1]
    else:
        moduli = indentation_modulus(*axial), None
    if hamaker is not None:  # 1e-20 J
        area = 24.0 * math.pi * (ATTRACTION_RANGE * 1e-9) ** 2
        entry["surface_energy"] = hamaker * 1e-20 / area
    return Material(moduli[0], poisson=moduli[1], **entry)


#: Materials by name, from the file ``materials.toml``. The function `material` also
#: finds the crystals of `CRYSTALS`.
MATERIALS = {name: _read(**entry) for name, entry in TABLES["materials"].items()}
# Crystals of the table `CRYSTALS`, replaced by materials of the same name.
_ALL_MATERIALS = {
    each: _read(crystal=each, source=MATERIALS["Si"].source, symbol=each)
    for each in CRYSTALS
}
_ALL_MATERIALS.update(MATERIALS)
#: Largest hardness of a material relative to its contact modulus: 0.103, of DLC. The
#: theoretical strength of solids is about a tenth of Young's modulus, too.
LARGEST_RELATIVE_HARDNESS = max(
    each.hardness / each.contact_modulus
    for each in _ALL_MATERIALS.values()
    if math.isfinite(each.hardness)
)
#: Largest modulus of rubbers and gels (GPa), which recover from any pressure.
LARGEST_RUBBER_MODULUS = 0.1


def material(name: str) -> Material:
    """Return a material by name, one of `MATERIALS` or a symbol in `CRYSTALS`.

    Raises
    ------
    ValueError
        If the material is unknown.
    """
    if name not in _ALL_MATERIALS:
        names = {each.lower(): each for each in _ALL_MATERIALS}
        names.update(TABLES["other_names"])
        for symbol in CRYSTALS:
            names[atomic_names[atomic_numbers[symbol]].lower()] = symbol
        similar = get_close_matches(name[:100].lower(), names, n=1)
        hint = f"did you mean {names[similar[0]]!r}? " if similar else ""
        raise ValueError(
            f"unknown material {shown(name)}; {hint}Known: {', '.join(_ALL_MATERIALS)}"
        )
    return _ALL_MATERIALS[name]


def find_material(name: str) -> Material | None:
    """Return a material by name; None for another chemical element.

    Raises
    ------
    ValueError
        If the name is neither a material nor a chemical symbol.
    """
    if name in chemical_symbols[1:] and name not in _ALL_MATERIALS:
        return None
    return material(name)


def hardness_of(name: str) -> float:
    """Return the hardness of a material or an element by name.

    Parameters
    ----------
    name : str
        One of `MATERIALS`, or a chemical symbol.

    Returns
    -------
    float
        Hardness (GPa); infinity for a rubber, NaN if it is not known.
    """
    if name in _ALL_MATERIALS:
        return _ALL_MATERIALS[name].hardness
    return HARDNESS.get(name, math.nan)


def hardness_bound(modulus: float, creep: Creep | None = None) -> float:
    """Return the largest pressure that a solid of unknown hardness may bear.

    Parameters
    ----------
    modulus : float
        Instantaneous contact modulus (GPa).
    creep : Creep, optional
        Creep of a viscoelastic solid.

    Returns
    -------
    float
        `LARGEST_RELATIVE_HARDNESS` times the modulus (GPa). NaN for rubbers: the
        relaxed modulus is at most `LARGEST_RUBBER_MODULUS`.
    """
    relaxed = modulus * (creep.relaxed if creep else 1.0)
    if relaxed <= LARGEST_RUBBER_MODULUS:
        return math.nan
    return LARGEST_RELATIVE_HARDNESS * modulus


def combined_modulus(*moduli: float) -> float:
    """Return the contact modulus of elastic bodies in contact, from each one's modulus.

    Examples
    --------
    >>> combined_modulus(100.0, 100.0)
    50.0
    """
    return 1.0 / sum(1.0 / modulus for modulus in moduli)


def combined_poisson(*bodies: tuple[float, float]) -> float:
    r"""Return Poisson's ratio of the solid with the lateral compliance of two bodies.

    With the shear moduli :math:`G = E^* (1 - \nu)/2`, the compliances
    :math:`(1 - \nu)/G` along a wave and :math:`1/G` across it add up,

    .. math:: \frac{1}{G} = \frac{1}{G_1} + \frac{1}{G_2}, \qquad
              \frac{\nu}{G} = \frac{\nu_1}{G_1} + \frac{\nu_2}{G_2} .

    Parameters
    ----------
    *bodies : (float, float)
        Contact modulus (pressure) and Poisson's ratio of each body.

    References
    ----------
    K. L. Johnson, Contact Mechanics (1985), Sec. 7.1.
    """
    inverse_shear = [2.0 / (modulus * (1.0 - nu)) for modulus, nu in bodies]
    terms = [nu * each for each, (_, nu) in zip(inverse_shear, bodies, strict=True)]
    return sum(terms) / sum(inverse_shear)


def dundurs_parameter(first: tuple[float, float], second: tuple[float, float]) -> float:
    r"""Return Dundurs' second parameter, the coupling of two elastic bodies.

    .. math:: \beta = \frac{1}{2} \frac{(1 - 2\nu_1)/G_1 - (1 - 2\nu_2)/G_2}
              {(1 - \nu_1)/G_1 + (1 - \nu_2)/G_2}

    Parameters
    ----------
    first, second : (float, float)
        Contact modulus (pressure) and Poisson's ratio of each body.

    References
    ----------
    J. Dundurs, J. Appl. Mech. 36, 650 (1969).

    Examples
    --------
    >>> dundurs_parameter((80.0, 0.3), (80.0, 0.3))
    0.0
    """
    rigid = [(1.0 - 2.0 * nu) / (2.0 - 2.0 * nu) / m for m, nu in (first, second)]
    return (rigid[0] - rigid[1]) * combined_modulus(first[0], second[0])


def work_of_adhesion(first: str, second: str) -> float:
    """Return the work of adhesion of two materials by van der Waals forces.

    Parameters
    ----------
    first, second : str
        Names of the materials.

    Returns
    -------
    float
        Work of adhesion (J/m^2).

    Raises
    ------
    ValueError
        If a material or its surface energy is unknown.

    Examples
    --------
    >>> round(work_of_adhesion("SiO2", "SiO2"), 3)
    0.063
    """
    product = 1.0
    for name in (first, second):
        entry = find_material(name)
        energy = None if entry is None else entry.surface_energy
        if energy is None:
            others = [k for k, v in MATERIALS.items() if v.surface_energy is not None]
            raise ValueError(
                f"the surface energy of {name} is not known: give work_of_adhesion, or "
                f"one of {', '.join(others)}"
            )
        product *= energy
    return 2.0 * math.sqrt(product)
