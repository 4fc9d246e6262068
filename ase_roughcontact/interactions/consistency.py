"""Check that pressure and stiffness of a user's wall are derivatives of its energy."""

from __future__ import annotations

import numpy as np

from ase_roughcontact.interactions.base import Interaction

# Attributes that a wall must define.
_REQUIRED = "cutoff", "contact_distance", "work_of_adhesion", "attraction_range"
# Number of gaps at which derivatives are compared.
_GAPS = 200
# Smallest of these gaps, in spacings below the contact distance.
_DEPTH_BELOW = 1.1
# Largest of these gaps, in spacings above the contact distance.
_HEIGHT_ABOVE = 3.0
# Change of the gap for differences, in spacings.
_GAP_STEP = 1e-6
# Largest relative error of a pressure.
_PRESSURE_ERROR = 1e-3
# Largest relative error of a stiffness.
_STIFFNESS_ERROR = 1e-2
# Rounding error of a difference of two values, in the spacing of numbers next to them.
_DIFFERENCE_ERROR = 100.0
# Largest number of gaps with an error, which are taken for kinks and jumps.
_MAX_KINKS = 3


def check_attributes(wall: Interaction) -> None:
    """Raise `ValueError` if a wall does not define what `Interaction` declares."""
    missing = [each for each in _REQUIRED if not hasattr(wall, each)]
    if missing:
        name = type(wall).__name__
        raise ValueError(f"the wall {name} must define {', '.join(missing)}")


def check_wall(wall: Interaction, spacing: float) -> None:
    """Raise `ValueError` if a wall from outside the package contradicts itself.

    Pressure and stiffness are compared with differences of energy and pressure at gaps
    within the range of the wall.
    """
    name = type(wall).__name__
    if type(wall).__module__.startswith("ase_roughcontact."):
        return
    check_attributes(wall)
    if wall.purely_hard:
        return
    lowest = 0.0 if wall.hard else wall.contact_distance - _DEPTH_BELOW * spacing
    highest = min(wall.cutoff, wall.contact_distance + _HEIGHT_ABOVE * spacing)
    # irregular distances, so that few gaps are at kinks
    fractions = (np.arange(_GAPS) + 0.5 + 0.4 * np.sin(np.arange(_GAPS))) / _GAPS
    gap, step = lowest + fractions * (highest - lowest), _GAP_STEP * spacing
    below = _values(wall, name, gap - step)
    here = _values(wall, name, gap)
    above = _values(wall, name, gap + step)
    for index, function, derivative, tolerance in (
        (1, "energy", "pressure", _PRESSURE_ERROR),
        (2, "pressure", "stiffness", _STIFFNESS_ERROR),
    ):
        returned, integral = here[index], here[index - 1]
        expected = (below[index - 1] - above[index - 1]) / (2.0 * step)
        eps = np.finfo(np.result_type(integral, np.float16)).eps
        allowed = tolerance * np.maximum(abs(returned), abs(expected))
        allowed += _DIFFERENCE_ERROR * eps * abs(integral) / step
        wrong = np.flatnonzero(abs(returned - expected) > allowed)
        if len(wrong) > _MAX_KINKS:
            example = wrong[len(wrong) // 2]
            raise ValueError(
                f"the {derivative} of the wall {name} must be minus the derivative of "
                f"its {function}: at the gap {gap[example]:.4g} it is "
                f"{returned[example]:.4g} instead of {expected[example]:.4g}"
            )


def _values(wall: Interaction, name: str, gap: np.ndarray) -> list[np.ndarray]:
    """Return energy, pressure and stiffness of a wall, checked."""
    values = [np.asarray(each) for each in wall.evaluate(gap)]
    if [each.shape for each in values] != 3 * [gap.shape]:
        raise ValueError(
            f"evaluate of the wall {name} must return energy, pressure and stiffness "
            f"of the shape {gap.shape} of the gaps, got shapes "
            f"{', '.join(str(each.shape) for each in values)}"
        )
    for each in values:
        if not np.isfinite(each).all():
            bad = int((~np.isfinite(each)).argmax())
            raise ValueError(
                f"the wall {name} must be finite at all gaps, got {each[bad]} at "
                f"{gap[bad]:.4g}"
            )
    return values
