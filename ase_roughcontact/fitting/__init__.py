"""Parameters of a contact from measured force curves."""
