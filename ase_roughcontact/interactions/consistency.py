"""Check of a user's wall: its pressure and stiffness are derivatives of its energy."""

from __future__ import annotations

import numpy as np

from ase_roughcontact.interactions.base import Interaction

_ATTRIBUTES = "cutoff", "contact_distance", "work_of_adhesion", "attraction_range"
# Gaps that are compared, from so many spacings below the contact distance to so many
# above it, and the difference of gaps in spacings.
_GAPS, _BELOW, _ABOVE, _STEP = 200, 1.1, 3.0, 1e-6
# Relative errors above which pressure and stiffness are wrong, the larger rounding
# errors of differences, and the number of gaps at which kinks and jumps may be.
_PRESSURE, _STIFFNESS, _ROUNDING, _KINKS = 1e-3, 1e-2, 100.0, 3


def check_wall(wall: Interaction, spacing: float) -> None:
    """Raise `ValueError` if a wall from outside the package contradicts itself.

    Pressure and stiffness are compared with differences of energy and pressure at some
    gaps within its range.
    """
    name = type(wall).__name__
    if type(wall).__module__.startswith("ase_roughcontact."):
        return
    missing = [each for each in _ATTRIBUTES if not hasattr(wall, each)]
    if missing:
        raise ValueError(f"the wall {name} must define {', '.join(missing)}")
    if wall.purely_hard:
        return
    lowest = 0.0 if wall.hard else wall.contact_distance - _BELOW * spacing
    highest = min(wall.cutoff, wall.contact_distance + _ABOVE * spacing)
    # not at regular distances, which may be those of kinks
    fractions = (np.arange(_GAPS) + 0.5 + 0.4 * np.sin(np.arange(_GAPS))) / _GAPS
    gap, step = lowest + fractions * (highest - lowest), _STEP * spacing
    below, here, above = (
        _values(wall, name, gap + shift) for shift in (-step, 0.0, step)
    )
    for index, of, what, tolerance in (
        (1, "energy", "pressure", _PRESSURE),
        (2, "pressure", "stiffness", _STIFFNESS),
    ):
        given, before = here[index], here[index - 1]
        expected = (below[index - 1] - above[index - 1]) / (2.0 * step)
        eps = np.finfo(np.result_type(before, np.float16)).eps
        allowed = tolerance * np.maximum(abs(given), abs(expected))
        allowed += _ROUNDING * eps * abs(before) / step
        wrong = np.flatnonzero(abs(given - expected) > allowed)
        if len(wrong) > _KINKS:
            worst = wrong[len(wrong) // 2]
            raise ValueError(
                f"the {what} of the wall {name} must be minus the derivative of its "
                f"{of}: at the gap {gap[worst]:.4g} it is {given[worst]:.4g} instead "
                f"of {expected[worst]:.4g}"
            )


def _values(wall: Interaction, name: str, gap: np.ndarray) -> list[np.ndarray]:
    values = [np.asarray(each) for each in wall.evaluate(gap)]
    if [each.shape for each in values] != 3 * [gap.shape]:
        raise ValueError(
            f"evaluate of the wall {name} must return energy, pressure and stiffness, "
            f"each of the shape of the gaps, {gap.shape}, got "
            f"{', '.join(str(each.shape) for each in values)}"
        )
    for each in values:
        if not np.isfinite(each).all():
            bad = int((~np.isfinite(each)).argmax())
            raise ValueError(
                f"the wall {name} must be finite at all gaps, also at negative ones, "
                f"got {each[bad]} at {gap[bad]:.4g}"
            )
    return values
