"""Times as text."""

from datetime import timedelta

_YEAR = 365.25 * 86400.0
# Time above which years are printed (s).
_LONG = 100.0 * _YEAR


def duration(seconds: float) -> str:
    """Return a time (s) as hours, minutes and seconds, or as years if very long."""
    if seconds > _LONG:
        return f"{seconds / _YEAR:.2g} years"
    return str(timedelta(seconds=round(seconds)))
