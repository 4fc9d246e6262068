"""The command ``ase-roughcontact``, also as ``python -m ase_roughcontact``."""

import signal
import sys


def main() -> int:
    """Run the command; return its exit status. Ctrl-C may interrupt its imports."""
    try:
        from ase_roughcontact.cli import main as command

        return command()
    except KeyboardInterrupt:
        print("\ninterrupted", file=sys.stderr)
        return 128 + signal.SIGINT


if __name__ == "__main__":
    sys.exit(main())
