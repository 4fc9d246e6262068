"""Errors of commands, as lines on the error output."""

import sys

#: Errors that are printed as a line.
ERRORS = ValueError, RuntimeError, OSError, MemoryError, ImportError


def print_error(message: object) -> None:
    """Print an error or a warning as a line on the error output."""
    if isinstance(message, OSError) and message.filename and message.strerror:
        message = f"{message.filename}: {message.strerror}"
    print(f"ase-roughcontact: {message}", file=sys.stderr)
