"""Edges of bins."""

import numpy as np
from numpy.typing import ArrayLike

from ase_roughcontact._util.validation import FloatArray, finite_array


def rising(bins: ArrayLike) -> FloatArray:
    """Return edges of bins as an array, checked.

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
        Unless they are two or more finite numbers that rise.
    """
    edges = finite_array("bins", bins)
    if edges.ndim != 1 or len(edges) < 2 or not (np.diff(edges) > 0.0).all():
        raise ValueError(f"edges of bins must be two or more that rise, got {bins!r}")
    return edges
