"""Accuracy as one word or one number: a relative error in force and area.

Optimizers stop at a force that is left on atoms. What error of the whole that makes was
measured (``examples/benchmarks/promises.py --study paths``) for walls that push and
that pull, at heights and under loads, in small steps and large ones, at relative
tolerances from 1e-1 to 1e-5. In 480 states in contact the error of the force was at
most 0.4 of the tolerance. On ways through the first and the last touch, 494 states, it
was more than four times the tolerance in 8 of 2470 cases, all of them with strong
adhesion, where the path jumps: mostly up to 26 times, and without limit where a jump
was taken a step too late. So the tolerance is a quarter of the error, which takes up to
15 % more transforms, and no such factor is safe at a jump. The table of errors and
costs is in ``examples/guide/accuracy.md``.

An accuracy is that of the solution, and leaves the model as it is: the wall, its cutoff
too, and the spacing.
"""

from __future__ import annotations

from dataclasses import dataclass

from ase_roughcontact._util.validation import positive, unknown


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
    """

    error: float
    tolerance: float


# Relative error per relative tolerance, at most (measured).
_FACTOR = 4.0


def _within(error: float) -> Accuracy:
    return Accuracy(error, error / _FACTOR)


#: Accuracies by name. On contacts 30 and 100 atoms in radius, from a cold start, "fast"
#: erred by 2e-8 to 3e-5 in the force, "normal" by 5e-10 to 1e-6, "high" by 1e-12 to
#: 7e-11, all with the same atoms in contact but for two of 25 000; "normal" took up to
#: 1.5 times the transforms of "fast", "high" up to 2.2 times.
LEVELS = {
    "fast": _within(1e-2),
    "normal": _within(1e-4),
    "high": _within(1e-8),
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
    return _within(float(wanted))
