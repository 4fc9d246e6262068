"""Figures written to files."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from ase_roughcontact._util.files import replaced
from ase_roughcontact.plot.style import WIDTH, style


@contextmanager
def written(file: Path, height: float, width: float = WIDTH) -> Iterator[Figure]:
    """Yield a figure in the printed style, and write it to a file.

    Parameters
    ----------
    file : path
        Its ending is the format; PNG without one.
    height, width : float
        Of the figure (inches).
    """
    with style():
        figure = Figure(figsize=(width, height))
        yield figure
        with replaced(file) as name:
            figure.savefig(name, format=_format(file))


def draw_file(file: Path, draw: Callable[..., Any], *values: Any) -> None:
    """Write the figure of one of the functions that draw into axes.

    Parameters
    ----------
    file : path
    draw : callable
        Called with axes and the values.
    *values
    """
    with written(file, 2.8) as figure:
        draw(figure.subplots(), *values)


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


def _format(file: Path) -> str:
    return file.suffix[1:].lower() or "png"
