"""Lines of JSON with the units of their numbers."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any


def json_line(values: Mapping[str, Any], units: Mapping[str, str]) -> str:
    """Return a line of JSON, with null in place of NaN and infinity.

    Parameters
    ----------
    values : mapping
        Numbers, strings, lists and dicts.
    units : mapping
        Units of the values that have one, written under the key ``units``; those of
        other keys are ignored.

    Returns
    -------
    str
    """
    used = {key: unit for key, unit in units.items() if key in values}
    return json.dumps(_finite({**values, "units": used}))


def _finite(value: Any) -> Any:
    """Return a value with None in place of numbers that are not finite."""
    if isinstance(value, dict):
        return {key: _finite(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(inner) for inner in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
