"""The command ``ase-roughcontact``."""

from ase_roughcontact.cli.commands import main

__all__ = ["main"]
