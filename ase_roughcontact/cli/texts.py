"""Commands that print a text, before NumPy and others are imported."""

from __future__ import annotations

import argparse
from importlib.resources import files

from ase_roughcontact._util.extras import imported
from ase_roughcontact._util.printing import write
from ase_roughcontact.cli.parser import make_parser


def print_scene(options: argparse.Namespace) -> int:
    """Print the built-in scene file, a template with a description of each key."""
    text = files("ase_roughcontact").joinpath("default.toml").read_text("utf-8")
    write(text.removesuffix("\n"))
    return 0


def completion(options: argparse.Namespace) -> int:
    """Print a script that completes commands and options in a shell.

    It needs shtab (pip install '.[completion]' in the folder of the source code). For
    bash::

      ase-roughcontact completion > ~/.ase-roughcontact-completion
      echo 'source ~/.ase-roughcontact-completion' >> ~/.bashrc
    """
    shtab = imported("shtab", "completion", "completion needs shtab")
    write(shtab.complete(make_parser(), options.shell))
    return 0
