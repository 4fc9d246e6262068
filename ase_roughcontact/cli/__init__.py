"""The command ``ase-roughcontact``."""

from ase_roughcontact.cli.entry import main

__all__ = ["main"]
