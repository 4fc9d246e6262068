"""Lines of JSON, which name the units of their numbers."""

from __future__ import annotations

import json
import math
from typing import Any

UNITS_OF_STEPS = {
    "height": "Å",
    "penetration": "Å",
    "normal_force": "eV/Å",
    "contact_area": "Å^2",
    "energy": "eV",
    "max_force": "eV/Å",
    "gap_error": "Å",
    "tolerance": "eV/Å",
    "memory": "bytes",
    "seconds": "s",
}
UNITS_OF_EFFORT = {"memory": "bytes", "seconds": "s"}
UNITS_OF_PROGRESS = {"elapsed": "s", "left": "s"}


def json_line(told: dict[str, Any], units: dict[str, str] | None = None) -> str:
    """Return a line of JSON, which has null in place of NaN and infinity.

    Parameters
    ----------
    told : dict
        Of numbers, words, lists and dicts.
    units : dict, optional
        Units by key, told as ``units``; keys without one have no unit.

    Returns
    -------
    str
    """
    return json.dumps(_known(told | ({"units": units} if units else {})))


def _known(value: Any) -> Any:
    """Return a value with None in place of what JSON does not know."""
    if isinstance(value, dict):
        return {key: _known(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [_known(inner) for inner in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
