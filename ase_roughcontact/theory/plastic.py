"""Plastic contact: pressures limited by the hardness H of the solid.

In fully plastic contact the area is A = N/H. All functions broadcast over arrays,
accept any consistent system of units, and raise `ValueError` for an argument that is
not finite or of the wrong sign.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import erf

from ase_roughcontact._util.validation import (
    FloatArray,
    nonnegative_array,
    positive_array,
)

# Ratio of the hardness to the width of the distribution of pressures, below which
# contact is fully plastic.
_MIN_HARDNESS_RATIO = 0.05
# Number of images of the source for a width of one hardness.
_IMAGES_PER_WIDTH = 4.0


def plastic_area(normal_force: ArrayLike, hardness: ArrayLike) -> FloatArray:
    """Return the area of fully plastic contact, A = N/H.

    Parameters
    ----------
    normal_force : array_like
        Normal force N >= 0 (force).
    hardness : array_like
        Hardness H (force per area).

    Returns
    -------
    ndarray
        Contact area A (area).

    References
    ----------
    F. P. Bowden, D. Tabor, The Friction and Lubrication of Solids (1950), Ch. 1.
    """
    force = nonnegative_array("normal_force", normal_force)
    return force / positive_array("hardness", hardness)


def yield_load(
    radius: ArrayLike, contact_modulus: ArrayLike, hardness: ArrayLike
) -> FloatArray:
    """Return the load at which the largest pressure below a sphere is the hardness.

    N = pi^3 R^2 H^3/(6 E*^2), from Hertz' p(0) = 2 E* a/(pi R) = H.

    Parameters
    ----------
    radius : array_like
        Radius R of the sphere (length).
    contact_modulus : array_like
        Contact modulus E* (force per area).
    hardness : array_like
        Hardness H (force per area).

    Returns
    -------
    ndarray
        Normal force N (force).

    References
    ----------
    K. L. Johnson, Contact Mechanics (Cambridge University Press, 1985), section 4.2.
    """
    radius = positive_array("radius", radius)
    modulus = positive_array("contact_modulus", contact_modulus)
    hardness = positive_array("hardness", hardness)
    return np.pi**3 * radius**2 * hardness**3 / (6.0 * modulus**2)


def plastic_crossover_load(
    radius: ArrayLike, contact_modulus: ArrayLike, hardness: ArrayLike
) -> FloatArray:
    """Return the load at which Hertz' mean pressure is the hardness.

    N = 9 pi^3 R^2 H^3/(16 E*^2): the crossover from A_Hertz to A = N/H.

    Parameters
    ----------
    radius, contact_modulus, hardness : array_like
        See `yield_load`; this load is 27/8 of the yield load.

    Returns
    -------
    ndarray
        Normal force N (force).
    """
    return 27.0 / 8.0 * yield_load(radius, contact_modulus, hardness)


def plastic_contact_fraction(
    pressure: ArrayLike, rough_pressure: ArrayLike, hardness: ArrayLike
) -> tuple[FloatArray, FloatArray]:
    r"""Return the fractions of the area in contact and in plastic contact.

    In Persson's theory the distribution of the pressures broadens by diffusion from the
    nominal pressure p as roughness is added, and is absorbed at zero, where the
    surfaces separate, and at H, where they flow. With the variance
    ``V = 2 p_rough^2/pi``, which gives `contact_fraction` without a hardness, the
    distribution of the elastic pressures is

    .. math:: P(\sigma) = \sum_k \left[ G(\sigma - p - 2kH)
              - G(\sigma + p - 2kH) \right], \qquad
              G(x) = \frac{e^{-x^2/2V}}{\sqrt{2\pi V}} .

    The fraction in elastic contact is :math:`\int_0^H P\,d\sigma`, and the fraction in
    plastic contact carries the rest of the load,
    :math:`(p - \int_0^H \sigma P\,d\sigma)/H`.

    Parameters
    ----------
    pressure : array_like
        Nominal pressure p = N/A0 >= 0 (force per area).
    rough_pressure : array_like
        Mean pressure p_rough, see `mean_contact_pressure` (force per area).
    hardness : array_like
        Hardness H (force per area).

    Returns
    -------
    contact, plastic : ndarray
        Fractions (dimensionless). Both are p/H for p beyond H, where the plastic
        contact is larger than the nominal area.

    References
    ----------
    B. N. J. Persson, J. Chem. Phys. 115, 3840 (2001), with the variance of L. Pastewka,
    M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016), eq. (2).
    """
    p, scale, limit = np.broadcast_arrays(
        nonnegative_array("pressure", pressure),
        positive_array("rough_pressure", rough_pressure),
        positive_array("hardness", hardness),
    )
    ratio = p / limit  # all pressures in units of the hardness from here on
    width = np.minimum(scale / limit, 1.0 / _MIN_HARDNESS_RATIO)
    width = np.sqrt(2.0 / np.pi) * width
    count = int(np.ceil(_IMAGES_PER_WIDTH * width.max(initial=0.0))) + 1
    elastic = carried = np.zeros(p.shape)
    for k in range(-count, count + 1):
        for sign, source in ((1.0, ratio + 2 * k), (-1.0, 2 * k - ratio)):
            part, moment = _between_bounds(source, width)
            elastic, carried = elastic + sign * part, carried + sign * moment
    plastic = np.where(ratio < 1.0, ratio - carried, ratio)
    return np.where(ratio < 1.0, elastic + plastic, ratio), plastic


def _between_bounds(
    mean: FloatArray, width: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return integral and first moment of a normal distribution from 0 to 1."""
    low, high = -mean / (np.sqrt(2.0) * width), (1.0 - mean) / (np.sqrt(2.0) * width)
    part = 0.5 * (erf(high) - erf(low))
    slope = width / np.sqrt(2.0 * np.pi) * (np.exp(-(low**2)) - np.exp(-(high**2)))
    return part, mean * part + slope
