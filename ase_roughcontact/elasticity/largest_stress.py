r"""Equivalent stresses, and the place of the largest one below a surface.

The largest stress is searched on planes at depths of powers of two spacings, and on
both sides of the interface of a layer, where stresses along it jump. At the depth z
waves shorter than z have decayed, so that points at distances of 3 z/4 show where the
stress is large. Around the best of them parabolas through values at closer points give
the place of the largest stress. Stresses at these points are sums over waves, without
an FFT, of tractions within a square of 48 depths; others add the same stress to all.

References
----------
K. L. Johnson, Contact Mechanics (1985), Sec. 6.1; O. K. Smith, Commun. ACM 4, 168
(1961).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ase_roughcontact._util.validation import lookup
from ase_roughcontact.elasticity.stress_field import StressField

# Distance of points over the depth of their plane.
_RELATIVE_RESOLUTION = 0.75
# Distances of the points around the largest value, over its depth, one after the other.
_STEPS = 0.4, 0.13
# Side of the square of tractions around the largest value that are summed, over its
# depth.
_RELATIVE_SIDE = 48
# Neighbours along each direction.
_NEIGHBOURS = np.array([-1.0, 0.0, 1.0])
# Smallest depth of the search, in spacings.
_MIN_DEPTH = 1.0


def von_mises(stress: np.ndarray) -> np.ndarray:
    r"""Return the von Mises stress.

    .. math:: \sigma_v^2 = \tfrac12 [(\sigma_{xx} - \sigma_{yy})^2
              + (\sigma_{yy} - \sigma_{zz})^2 + (\sigma_{zz} - \sigma_{xx})^2]
              + 3 (\sigma_{yz}^2 + \sigma_{xz}^2 + \sigma_{xy}^2)

    Parameters
    ----------
    stress : ndarray, shape (6, ...)
        Components xx, yy, zz, yz, xz and xy (pressure).

    Returns
    -------
    ndarray, shape (...)
        Von Mises stress (pressure), at least zero.

    Examples
    --------
    >>> import numpy as np
    >>> from ase_roughcontact.elasticity import von_mises
    >>> round(float(von_mises(np.array([0.0, 0.0, 0.0, 0.0, 1.0, 0.0]))), 3)
    1.732
    """
    stress = np.asarray(stress)
    stress = stress.astype(np.result_type(stress, np.float32), copy=False)
    xx, yy, zz, *shears = stress.reshape(6, -1)
    # two arrays for all terms: new ones take longer than the arithmetic
    total, term = np.empty_like(xx), np.empty_like(xx)
    np.subtract(xx, yy, out=total)
    total *= total
    for first, second in ((yy, zz), (zz, xx)):
        np.subtract(first, second, out=term)
        term *= term
        total += term
    total /= 6.0
    for shear in shears:
        np.multiply(shear, shear, out=term)
        total += term
    total *= 3.0
    return np.sqrt(total, out=total).reshape(stress.shape[1:])


def principal_stresses(stress: np.ndarray) -> np.ndarray:
    r"""Return the principal stresses in ascending order, shape (3, ...) (pressure).

    .. math:: \sigma_k = \bar\sigma + \tfrac23 \sigma_v \cos(\phi + 2 \pi k/3), \qquad
              \cos 3 \phi = \tfrac{27}{2} J_3/\sigma_v^3

    with the mean stress :math:`\bar\sigma`, the von Mises stress :math:`\sigma_v` and
    the determinant :math:`J_3` of the deviatoric stress (Smith 1961).

    Parameters
    ----------
    stress : ndarray, shape (6, ...)
        Components xx, yy, zz, yz, xz and xy (pressure).

    Examples
    --------
    >>> import numpy as np
    >>> from ase_roughcontact.elasticity import principal_stresses
    >>> shear = np.array([0.0, 0.0, 0.0, 0.0, 1.0, 0.0])
    >>> [round(float(each), 3) + 0.0 for each in principal_stresses(shear)]
    [-1.0, 0.0, 1.0]
    """
    stress = np.asarray(stress, dtype=float)
    mean, size = stress[:3].mean(axis=0), von_mises(stress)
    # components are scaled before they are multiplied: small ones would underflow
    scale = np.where(size > 0.0, size, 1.0)
    xx, yy, zz = (stress[:3] - mean) / scale
    yz, xz, xy = stress[3:] / scale
    determinant = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz)
    determinant += xz * (xy * yz - yy * xz)
    angle = np.arccos(np.clip(13.5 * determinant, -1.0, 1.0)) / 3.0
    radius = 2.0 / 3.0 * size
    largest = mean + radius * np.cos(angle)
    smallest = mean + radius * np.cos(angle + 2.0 * np.pi / 3.0)
    return np.stack([smallest, 3.0 * mean - smallest - largest, largest])


def tresca(stress: np.ndarray) -> np.ndarray:
    """Return the difference of the largest and the smallest principal stress.

    It is twice the largest shear stress; see `principal_stresses` for the parameters.
    """
    principal = principal_stresses(stress)
    return principal[2] - principal[0]


def tension(stress: np.ndarray) -> np.ndarray:
    """Return the largest principal stress, positive in tension.

    See `principal_stresses` for the parameters.
    """
    return principal_stresses(stress)[2]


#: Functions of the stress by name.
MEASURES: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "von_mises": von_mises,
    "tresca": tresca,
    "tension": tension,
}


@dataclass(frozen=True)
class LargestStress:
    """Largest equivalent stress below a surface, and its place.

    Attributes
    ----------
    value : float
        The stress (pressure).
    depth : float
        Depth below the surface (length); NaN if there is no stress.
    x, y : float
        Position from the first point of the window (length); NaN if there is no stress.
    """

    value: float
    depth: float
    x: float
    y: float


def largest_stress(field: StressField, measure: str = "von_mises") -> LargestStress:
    """Return the largest equivalent stress below a surface, and its place.

    Parameters
    ----------
    field : StressField
        Stress below the surface.
    measure : {"von_mises", "tresca", "tension"}
        The stress of which the largest value is searched: the von Mises stress,
        the difference of principal stresses, or the largest principal stress.

    Returns
    -------
    LargestStress
        From a depth of one spacing on: closer to the surface the stress depends on how
        the pressure varies between the points of the grid. The largest principal stress
        is negative if the solid is compressed everywhere.

    Examples
    --------
    The largest stress below a smooth sphere is 0.62 times the largest pressure, at a
    depth of 0.48 contact radii (nu = 0.3):

    >>> import numpy as np
    >>> from ase_roughcontact.elasticity import Isotropic, StressField, largest_stress
    >>> x = np.arange(-40, 41) / 30.0
    >>> pressure = np.sqrt(np.maximum(1.0 - x[:, None] ** 2 - x**2, 0.0))
    >>> peak = largest_stress(StressField(Isotropic(1.0, 0.3), 1.0, pressure))
    >>> round(peak.value, 2), round(peak.depth / 30.0, 2)
    (0.62, 0.48)
    """
    lookup(measure, MEASURES, "measure of stress")
    evaluate = MEASURES[measure]
    largest, place, there = -math.inf, (0.0, 0.0, 0.0), np.zeros(6)
    for depth in _depths(field):
        stress, steps = field.coarse_stress(depth, _RELATIVE_RESOLUTION * depth)
        values = evaluate(stress)
        i, j = np.unravel_index(values.argmax(), values.shape)
        if values[i, j] > largest:
            largest, there = float(values[i, j]), stress[:, i, j]
            place = float(i) * steps[0], float(j) * steps[1], depth
    if largest == 0.0:
        return LargestStress(0.0, math.nan, math.nan, math.nan)
    x, y, depth = _refined(field, evaluate, place, there)
    value = float(evaluate(field.stress_at(np.array([x]), np.array([y]), depth))[0, 0])
    return LargestStress(value, depth, x * field.spacing, y * field.spacing)


def _depths(field: StressField) -> list[float]:
    """Return the depths of the planes of a search, from the surface downward."""
    spacing, thickness = field.spacing, field.solid.thickness
    longest = max(2, *field.shape)
    depths = [_MIN_DEPTH * spacing * 2.0**k for k in range(longest.bit_length())]
    if depths[0] < thickness < depths[-1]:
        depths += [thickness, _below(thickness)]
    return sorted(depths)


def _below(interface: float) -> float:
    """Return the depth of the points in the base at its interface with a layer."""
    return math.nextafter(interface, math.inf)


def _refined(
    field: StressField,
    evaluate: Callable[[np.ndarray], np.ndarray],
    place: tuple[float, float, float],
    stress: np.ndarray,
) -> tuple[float, float, float]:
    """Return the place of the largest value around a place in the same material.

    Places are (x, y, depth), with x and y in spacings. The stress at the given place is
    known.
    """
    (x, y, depth), spacing, thickness = place, field.spacing, field.solid.thickness
    top, bottom = _MIN_DEPTH * spacing, thickness
    if depth > thickness:
        top, bottom = max(top, _below(thickness)), math.inf
    near, corner, others = _near(field, place, stress)
    for step in _STEPS:
        depths = np.unique(np.clip(depth * 2.0 ** (step * _NEIGHBOURS), top, bottom))
        rows, columns = (
            middle + step * depth / spacing * _NEIGHBOURS for middle in (x, y)
        )
        if not field.periodic:
            rows = np.clip(rows, 0, field.shape[0] - 1)
            columns = np.clip(columns, 0, field.shape[1] - 1)
        points = rows - corner[0], columns - corner[1]
        planes = [evaluate(others + near.stress_at(*points, each)) for each in depths]
        values = np.stack(planes)
        k, i, j = np.unravel_index(values.argmax(), values.shape)
        x = _vertex(rows, values[k, :, j])
        y = _vertex(columns, values[k, i])
        depth = _vertex(depths, values[:, i, j])
    return x, y, depth


def _near(
    field: StressField, place: tuple[float, float, float], stress: np.ndarray
) -> tuple[StressField, tuple[int, int], np.ndarray]:
    """Return the field of the tractions near a place, its first point, and the rest.

    The rest of the stress, by tractions that are many depths away, is the same around
    the place.
    """
    x, y, depth = place
    side = math.ceil(_RELATIVE_SIDE * depth / field.spacing)
    if side >= min(field.shape):
        return field, (0, 0), np.zeros((6, 1, 1))
    near, (row, column) = field.around(x, y, side)
    point = np.array([x - row]), np.array([y - column])
    return near, (row, column), stress[:, None, None] - near.stress_at(*point, depth)


def _vertex(positions: np.ndarray, values: np.ndarray) -> float:
    """Return the vertex of a parabola through three values.

    If the largest value is not between two others, it is its position.
    """
    largest = int(values.argmax())
    if (
        len(values) < 3
        or largest != 1
        or not positions[0] < positions[1] < positions[2]
    ):
        return float(positions[largest])
    low, middle, high = values
    curvature = low - 2.0 * middle + high
    if not curvature < 0.0:
        return float(positions[largest])
    shift = (low - high) / (2.0 * curvature)
    return float(np.interp(1.0 + shift, (0.0, 1.0, 2.0), positions))
