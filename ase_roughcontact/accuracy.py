"""Accuracy as one word or one number: a relative error in force and area.

Optimizers stop at a force that is left on atoms. What error of the whole that makes was
measured: along paths of small and of large steps, at given heights and under given
loads, for walls that push and that pull, on surfaces of several slopes and radii. In
about 1400 states, each relaxed to tolerances from 1e-1 to 1e-5, the error was mostly
below 0.08 of the relative tolerance, and up to once the tolerance. In two states of an
adhesive wall it was 2.8 and 4 times: there the path jumps, and a tolerance of 1e-2 was
met on the way through the jump (one of 1e-3 was not). So the tolerance is a quarter of
the error, which takes up to 15 % more transforms; it covers all that was seen, without
a margin, and no such factor is safe at a jump. The table of errors and costs is in
``examples/SPEED_ACCURACY.md``.
"""

from __future__ import annotations

from dataclasses import dataclass

from ase_roughcontact.checks import positive, unknown


@dataclass(frozen=True)
class Accuracy:
    """What an accuracy asks of a calculation.

    Attributes
    ----------
    error : float
        That is allowed in the normal force, relative to the push on the atoms in
        contact, and in the contact area, beyond one atom: the area is a number of
        atoms. A state in which the path jumps is not meant.
    tolerance : float
        Largest force that may be left on any atom, in units of the mean force on the
        atoms in contact.
    dtype : str
        Precision of the transforms. Single precision saves no time, see `RealFFT2`.
    cutoff : float
        Of an attraction without an end (`LennardJones93.full`), in units of the
        distance of its minimum. Measured: 3, 5, 10 and 30 leave errors of 3e-3, 6e-4,
        7e-5 and 2e-6 in the force.
    """

    error: float
    tolerance: float
    dtype: str
    cutoff: float


# Relative error per relative tolerance, at most (measured).
_FACTOR = 4.0
# A 9-3 attraction still has this times (r0/r)^3 of its depth at a distance r.
_TAIL = 1.5


def _within(error: float, cutoff: float) -> Accuracy:
    return Accuracy(error, error / _FACTOR, "float64", cutoff)


#: Accuracies by name. On contacts 30 and 100 atoms in radius, from a cold start, "fast"
#: erred by 3e-8 to 6e-5 in the force, "normal" by 5e-10 to 3e-6, "high" by 9e-13 to
#: 5e-11, all with the same atoms in contact but for two of 25 000; "normal" took up to
#: 1.4 times the transforms of "fast", "high" up to 2.1 times. The cutoff of "high" is
#: the exception to its promise: it keeps to 1e-5.
LEVELS = {
    "fast": _within(1e-2, 5.0),
    "normal": _within(1e-4, 10.0),
    "high": _within(1e-8, 30.0),
}


def accuracy_of(wanted: str | float) -> Accuracy:
    """Accuracy by name, or for a relative error in force and area.

    Parameters
    ----------
    wanted : {"fast", "normal", "high"} or float
        A number is a relative error, from 1e-12 to below 1; ten times less takes 2
        to 3.5 more pairs of transforms where 10 to 80 are needed.

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
    return _within(float(wanted), max(3.0, (_TAIL / wanted) ** (1 / 3)))
