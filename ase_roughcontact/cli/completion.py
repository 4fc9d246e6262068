"""Completion of commands and options in bash, read off the parser itself."""

from __future__ import annotations

import argparse

BASHRC = "complete -o default -C 'ase-roughcontact completion' ase-roughcontact"


def candidates(parser: argparse.ArgumentParser, line: str) -> list[str]:
    """Tell what may stand where the cursor is.

    Parameters
    ----------
    parser : ArgumentParser
    line : str
        The command line up to the cursor.

    Returns
    -------
    list of str
        Commands, options or values that begin as the last word does; none where a file
        is wanted, which bash completes itself.
    """
    _, *words = line.split()
    begun = words.pop() if words and not line[-1].isspace() else ""
    for word in words:
        parser = _commands(parser).get(word, parser)
    before = parser._option_string_actions.get(words[-1]) if words else None
    if before is not None and before.nargs != 0:
        known = before.choices or ()
    elif begun.startswith("-"):
        known = parser._option_string_actions
    else:
        known = _commands(parser)
    return sorted(word for word in known if word.startswith(begun))


def _commands(parser: argparse.ArgumentParser) -> dict[str, argparse.ArgumentParser]:
    """Parsers of the commands, by name."""
    commands: dict[str, argparse.ArgumentParser] = {}
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            commands |= action.choices
    return commands
