"""Limit of fine grids, from results on two or three of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ase_roughcontact._util.validation import FloatArray, finite_array, positive


class GridLimit(NamedTuple):
    """Values on an infinitely fine grid.

    Attributes
    ----------
    value : ndarray
    error : ndarray
        Estimated error of the values.
    """

    value: FloatArray
    error: FloatArray


def extrapolate(
    spacings: Sequence[float], values: ArrayLike, order: float = 1.0
) -> GridLimit:
    r"""Return the limit of values on two or three grids, with an estimate of its error.

    .. math:: L = f_1 + \frac{f_1 - f_2}{(h_2/h_1)^p - 1}

    with the values :math:`f_1` and :math:`f_2` on the two finest grids of spacing
    :math:`h_1 < h_2`. The error of two grids is :math:`|L - f_1|`. That of three grids
    is the change of the limit from the two coarser grids to the two finer ones, but at
    least :math:`|L - f_1| / 2`.

    Parameters
    ----------
    spacings : sequence of float
        Two or three different spacings, in any order (length).
    values : array_like, shape (grids, ...)
        Values on each grid, such as the `contact_area` of all steps of a path.
    order : float
        Power p of the spacing with which the error falls. It is 1 for the contact area.

    Returns
    -------
    GridLimit
        Arrays of shape (...).

    Raises
    ------
    ValueError
        If there are not two or three different positive spacings with values each, or a
        number is not finite.

    Notes
    -----
    Under a hard wall the area of the continuum is the limit of `contact_area`, whose
    error is proportional to the spacing, rather than of `continuum_area`, whose smaller
    error is less regular.

    References
    ----------
    L. F. Richardson, Phil. Trans. R. Soc. A 210, 307 (1911).

    Examples
    --------
    >>> limit = extrapolate([1.0, 0.5, 0.25], [1.4, 1.2, 1.1])
    >>> round(float(limit.value), 9), round(float(limit.error), 9)
    (1.0, 0.05)
    """
    h, f = finite_array("spacings", spacings), finite_array("values", values)
    if h.shape not in ((2,), (3,)) or f.shape[:1] != h.shape:
        raise ValueError(
            "extrapolation needs two or three spacings and as many rows of values, got "
            f"shapes {h.shape} and {f.shape}"
        )
    finest_first = np.argsort(h)
    h, f = h[finest_first], f[finest_first]
    positive(order=order, spacing=h[0])
    if not np.diff(h).all():
        raise ValueError(f"spacings must differ, got {spacings}")
    limits = [
        f[i] + (f[i] - f[i + 1]) / ((h[i + 1] / h[i]) ** order - 1.0)
        for i in range(len(h) - 1)
    ]
    error = abs(limits[0] - f[0])
    if len(limits) == 2:
        error = np.maximum(abs(limits[0] - limits[1]), error / 2.0)
    return GridLimit(limits[0], error)
