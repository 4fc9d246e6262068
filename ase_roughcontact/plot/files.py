"""Figures written to files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from ase_roughcontact._util.files import replaced


def draw_file(file: Path, draw: Callable[..., Any], *values: Any) -> None:
    """Write the figure of one of the functions that draw into axes.

    Parameters
    ----------
    file : path
    draw : callable
        Called with axes and the values.
    *values
    """
    figure = Figure(figsize=(5, 4), layout="constrained")
    draw(figure.subplots(), *values)
    save(figure, file, dpi=150)


def check_picture(file: Path) -> None:
    """Raise `ValueError` if a file can't be a picture by its ending or its folder."""
    if not file.parent.is_dir():
        raise ValueError(
            f"there is no folder {file.parent} for the picture {file.name}"
        )
    formats = Figure().canvas.get_supported_filetypes()
    if file.suffix and _format(file) not in formats:
        raise ValueError(
            f"a picture ends in one of .{', .'.join(sorted(formats))}; got {file.name}"
        )


def save(figure: Figure, file: Path, dpi: float) -> None:
    """Write a figure, in the format of the file's ending, or PNG without one."""
    with replaced(file) as name:
        figure.savefig(name, format=_format(file), dpi=dpi)


def _format(file: Path) -> str:
    return file.suffix[1:].lower() or "png"
