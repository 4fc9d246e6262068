"""What the laws of adhesion share: forces from pull-off on, and the two branches.

Under a force between pull-off and a greatest one, a contact has two radii: it is stable
at the larger one, and at the smaller one it either grows or parts.
"""

from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ase_roughcontact._util.validation import FloatArray, finite_array

Branch: TypeAlias = Literal["stable", "unstable"]


def is_stable(branch: str) -> bool:
    """Whether a branch is the stable one.

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


def refuse_beyond(name: str, values: FloatArray, end: float) -> None:
    """Raise an error for values beyond the end of the unstable branch.

    Parameters
    ----------
    name : str
        Of the values.
    values : ndarray
        Forces or penetrations.
    end : float
        Largest value with an unstable contact, where its radius is zero.

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
    """Force in excess of pull-off; rounding at pull-off itself counts as zero.

    Parameters
    ----------
    normal_force : array_like
        N, force.
    pull_off : ndarray
        Least force, negative.

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
            f"normal_force must not lie below the pull-off force {pull_off}, "
            f"got {normal_force!r}"
        )
    return np.maximum(excess, 0.0)
