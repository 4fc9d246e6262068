r"""Expected depth and extent of a contact, before it is calculated.

A rigid sphere at a depth :math:`d` overlaps the flat surface within a radius
:math:`s = \sqrt{2 R d}`; by Hertz it touches the elastic one within
:math:`a = \sqrt{R d} = s/\sqrt 2` under the load

.. math:: N = \tfrac43 E^* \sqrt R\, d^{3/2} = c\, E^* d\, s, \qquad c = \sqrt 8/3.

References
----------
K. L. Johnson, Contact Mechanics (Cambridge, 1985), Section 4.2: force and gap.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from ase_roughcontact.elasticity.greens import ElasticSolid
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.interactions import Interaction
from ase_roughcontact.windows.footprint import Footprint

#: Normal force over ``E*``, depth and half the side of the overlap; that of Hertz.
LOAD_FACTOR = math.sqrt(8.0) / 3.0
# Depths are searched from this part of the spacing on, by this factor.
_FIRST_DEPTH, _DEPTH_RATIO = 1e-3, 1.2
# Wave number that represents a contact, times its radius.
_WAVE_NUMBER = math.pi
# Corrections of the modulus of a solid that is not homogeneous.
_CORRECTIONS = 12
# Gap at a radius a (1 + e) beside a Hertzian contact of radius a, for small e, in units
# of e^(3/2) a^2/(pi R).
_GAP_BESIDE = 8.0 * math.sqrt(2.0) / 3.0


def predicted_depth(
    load: float, footprint: Footprint, wall: Interaction, solid: ElasticSolid
) -> float:
    """Return a depth at which the indenter carries at least a load, ``N = c E* d s``.

    ``c`` is `LOAD_FACTOR`. The half side ``s`` is that of the box of the atoms that the
    rigid indenter overlaps. With a hardness the load is at most ``pi H s^2``.

    Parameters
    ----------
    load : float
        Positive (force).
    footprint : Footprint
        Of the indenter.
    wall : Interaction
    solid : ElasticSolid
        Its modulus is that of waves of the size of the overlap.

    Returns
    -------
    float
        At most 1.2 times that of the equation, or that at which the overlap leaves
        the domain of the roughness. It is searched from small depths on, as the surface
        is then evaluated only where the indenter overlaps.
    """
    spacing = footprint.spacing

    def carried(depth: float, half_side: float) -> float:
        radius = half_side * spacing
        elastic = LOAD_FACTOR * modulus_under(radius, solid, spacing) * depth * radius
        return min(elastic, wall.hardness * math.pi * radius**2)

    level = wall.cutoff - wall.contact_distance + footprint.lowest
    largest = math.inf if wall.plastic else load / carried(1.0, 0.5)
    depth = _FIRST_DEPTH * spacing
    while depth < largest:
        box = footprint.box_below(level + depth)
        if carried(depth, half_side(box)) > load or footprint.clip(box) != box:
            return depth
        depth *= _DEPTH_RATIO
    return largest


def modulus_under(radius: float, solid: ElasticSolid, spacing: float) -> float:
    """Return the modulus of waves of the size of a contact.

    Parameters
    ----------
    radius : float
        Of the contact (length).
    solid : ElasticSolid
    spacing : float
        Of the atoms (length).

    Returns
    -------
    float
        Pressure.
    """
    return float(solid.wave_modulus(_WAVE_NUMBER / max(radius, spacing)))


def contact_radius_on(
    solid: ElasticSolid, spacing: float, radius: Callable[[float], float]
) -> float:
    """Return the radius of a contact from that on a homogeneous solid.

    Parameters
    ----------
    solid : ElasticSolid
        Its modulus depends on the length of waves.
    spacing : float
        Of the atoms (length).
    radius : callable
        Returns the radius on an isotropic solid from its modulus (length).

    Returns
    -------
    float
        That for the modulus of waves of its own size (length).
    """
    result = radius(solid.contact_modulus)
    for _ in range(_CORRECTIONS):
        corrected = radius(modulus_under(result, solid, spacing))
        # on a thin incompressible layer E* is proportional to the cube of the radius,
        # and the corrected radius to 1/radius: without the mean it would alternate
        result = math.sqrt((result or spacing) * corrected)
    return result


def contact_level(
    level: float, lowest: float, wall: Interaction, scale: float
) -> float:
    r"""Return the level below which the atoms lie that are expected to touch.

    Atoms beside the Hertzian contact touch where its gap is smaller than the depth
    :math:`\delta` of the roughness and the range of the wall. With the depth
    :math:`d` of the smooth sphere, as :math:`a^2/R = d`, these are the atoms within
    :math:`a (1 + e)`,

    .. math:: \frac{8 \sqrt 2}{3\pi}\, e^{3/2}\, d = \delta.

    The side of a paraboloid's footprint is proportional to the root of its depth.

    Parameters
    ----------
    level : float
        Below which the rigid indenter overlaps (length).
    lowest : float
        Lowest height of the indenter at an atom (length).
    wall : Interaction
    scale : float
        Factor of the side.

    Returns
    -------
    float
        At most `level`.
    """
    roughness = max(-lowest, 0.0) + wall.cutoff - wall.contact_distance
    depth = level - lowest
    smooth_depth = depth - roughness
    if smooth_depth <= 0.0:
        return level
    beside = (math.pi * roughness / (_GAP_BESIDE * smooth_depth)) ** (2.0 / 3.0)
    side = scale * (1.0 + beside) * math.sqrt(smooth_depth / (2.0 * depth))
    return lowest + depth * min(side, 1.0) ** 2


def half_side(box: Box) -> float:
    """Return half of the mean side of a box, in spacings."""
    return 0.25 * sum(box.shape)
