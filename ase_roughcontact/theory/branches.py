"""Checks shared by the laws of adhesion: pull-off, and the stable and unstable branch.

In a range of forces from pull-off on there are two contact radii: the larger one is
stable, the smaller one is not.
"""

from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ase_roughcontact._util.validation import FloatArray, finite_array

Branch: TypeAlias = Literal["stable", "unstable"]


def is_stable(branch: str) -> bool:
    """Return whether a branch is the stable one.

    Parameters
    ----------
    branch : {"stable", "unstable"}
        Name of the branch.

    Returns
    -------
    bool

    Raises
    ------
    ValueError
        If the name is unknown.
    """
    if branch not in ("stable", "unstable"):
        raise ValueError(f"branch must be 'stable' or 'unstable', got {branch!r}")
    return branch == "stable"


def check_unstable(name: str, values: FloatArray, end: float) -> None:
    """Raise an error for values beyond the end of the unstable branch.

    Parameters
    ----------
    name : str
        Name of the values, for the error.
    values : ndarray
        Forces or penetrations.
    end : float
        Value at which the radius on the unstable branch is zero.

    Raises
    ------
    ValueError
        If a value is above `end`.
    """
    if np.any(values > end):
        raise ValueError(
            f"{name} must not exceed {end} on the unstable branch, got {values}"
        )


def above_pull_off(normal_force: ArrayLike, pull_off: FloatArray) -> FloatArray:
    """Return the force above pull-off; rounding at pull-off itself counts as zero.

    Parameters
    ----------
    normal_force : array_like
        N, force.
    pull_off : ndarray
        Pull-off force, negative.

    Returns
    -------
    ndarray
        N - pull_off >= 0, force.

    Raises
    ------
    ValueError
        If a force is not finite or below pull-off.
    """
    excess = finite_array("normal_force", normal_force) - pull_off
    if not np.all(excess >= 1e-12 * pull_off):
        raise ValueError(
            f"normal_force must not be below the pull-off force {pull_off}, "
            f"got {normal_force!r}"
        )
    return np.maximum(excess, 0.0)
