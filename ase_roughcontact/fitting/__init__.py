"""Parameters of a contact from measured force curves."""

SHOWN: dict[str, dict[str, str]] = {}
