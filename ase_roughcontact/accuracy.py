"""Accuracy as one word or one number."""

from __future__ import annotations

from dataclasses import dataclass

from ase_roughcontact.checks import positive, unknown


@dataclass(frozen=True)
class Accuracy:
    """What an accuracy asks of a calculation.

    Attributes
    ----------
    tolerance : float
        Largest force that may be left on any atom, in units of the mean force on the
        atoms in contact.
    dtype : str
        Precision of the transforms.
    cutoff : float
        Of an attraction without an end (`LennardJones93.full`), in units of the
        distance of its minimum.
    """

    tolerance: float
    dtype: str
    cutoff: float


# A 9-3 attraction still has this times (r0/r)^3 of its depth at a distance r.
_TAIL = 1.5

#: Accuracies by name.
LEVELS = {
    "fast": Accuracy(1e-2, "float64", 5.0),
    "normal": Accuracy(1e-4, "float64", 10.0),
    "high": Accuracy(1e-8, "float64", 30.0),
}


def accuracy_of(wanted: str | float) -> Accuracy:
    """Accuracy by name, or for a relative error in force and area.

    Parameters
    ----------
    wanted : {"fast", "normal", "high"} or float
        A number is a relative error, above 1e-12 and below 1.

    Returns
    -------
    Accuracy

    Raises
    ------
    ValueError
        If there is none of this name, or the error is out of range.
    """
    if isinstance(wanted, str):
        if wanted not in LEVELS:
            raise ValueError(unknown(wanted, list(LEVELS), "accuracy"))
        return LEVELS[wanted]
    positive(accuracy=wanted)
    if not 1e-12 <= wanted < 1.0:
        raise ValueError(
            f"accuracy must be a relative error from 1e-12 to 1, got {wanted:g}"
        )
    return Accuracy(float(wanted), "float64", max(3.0, (_TAIL / wanted) ** (1 / 3)))
