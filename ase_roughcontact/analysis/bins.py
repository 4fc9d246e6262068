"""Edges of bins."""

import numpy as np
from numpy.typing import ArrayLike

from ase_roughcontact._util.validation import FloatArray, finite_array


def increasing(bins: ArrayLike) -> FloatArray:
    """Return the edges of bins as an array, if they increase.

    Parameters
    ----------
    bins : array_like
        Edges.

    Returns
    -------
    ndarray

    Raises
    ------
    ValueError
        If they are not two or more increasing finite numbers.
    """
    edges = finite_array("bins", bins)
    if edges.ndim != 1 or len(edges) < 2 or not (np.diff(edges) > 0.0).all():
        raise ValueError(
            f"edges of bins must be two or more increasing numbers, got {bins!r}"
        )
    return edges
