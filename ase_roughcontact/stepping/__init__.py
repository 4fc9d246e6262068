"""One relaxed step of a path."""
