"""Errors of commands, as lines on the error output."""

from ase_roughcontact._util.printing import write_error

#: Errors that are printed as a line.
ERRORS = ValueError, RuntimeError, OSError, MemoryError, ImportError


def print_error(message: object) -> None:
    """Print an error or a warning as a line on the error output."""
    if isinstance(message, OSError) and message.filename and message.strerror:
        message = f"{message.filename}: {message.strerror}"
    write_error(f"ase-roughcontact: {message}")
