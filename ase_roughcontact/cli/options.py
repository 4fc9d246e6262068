"""What the options of several commands mean."""

from __future__ import annotations

import argparse

from ase_roughcontact.scene import Scene, default_text

#: Errors that are printed as a line.
ERRORS = ValueError, RuntimeError, OSError, MemoryError, ImportError


def scene_text(options: argparse.Namespace) -> tuple[str, str]:
    """Return text and name of the scene file, by default of the built-in one."""
    if not options.scene:
        return default_text(), "default.toml"
    return Scene.text_of(options.scene), options.scene


def checked_scene(options: argparse.Namespace) -> Scene:
    """Return the scene; raise `ValueError` if it is invalid."""
    text, name = scene_text(options)
    scene = Scene.parse(text, name)
    scene.check(name)
    return scene


def prints_text(options: argparse.Namespace) -> bool:
    """Return whether text is printed, rather than JSON or nothing."""
    return not (options.quiet or options.json)
