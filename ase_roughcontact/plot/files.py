"""Figures written to files."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from ase_roughcontact._util.files import check_replaced, replaced
from ase_roughcontact.plot.style import WIDTH, style

# Mark of the package in the metadata of its pictures.
_MARK = "ase_roughcontact"
# Key of the mark in the metadata, by format.
_MARK_KEY = {"png": "Software", "pdf": "Creator", "svg": "Creator", "eps": "Creator"}


@contextmanager
def written(file: Path, height: float, width: float = WIDTH) -> Iterator[Figure]:
    """Yield a figure in the printed style, and write it to a file.

    Parameters
    ----------
    file : path
        Name of the file; its ending is the format, PNG without an ending.
    height, width : float
        Height and width of the figure (inches).
    """
    with style():
        figure = Figure(figsize=(width, height))
        yield figure
        save(figure, file)


def save(figure: Figure, file: Path) -> None:
    """Write a figure to a file; its ending is the format, PNG without an ending."""
    with style(), replaced(file) as name:
        kind = _format(file)
        key = _MARK_KEY.get(kind)
        figure.savefig(name, format=kind, metadata={key: _MARK} if key else None)


def draw_file(file: Path, draw: Callable[..., Any], *values: Any) -> None:
    """Write the figure of one of the functions that draw into axes.

    Parameters
    ----------
    file : path
        Picture to write; its ending is the format.
    draw : callable
        Function that is called with axes and the values.
    *values
        Further arguments of the function.
    """
    with written(file, 2.8) as figure:
        draw(figure.subplots(), *values)


def check_picture(file: Path) -> None:
    """Raise `ValueError` if a file can't be a picture, or is not one of the package."""
    formats = Figure().canvas.get_supported_filetypes()
    if file.suffix and _format(file) not in formats:
        raise ValueError(
            f"a picture ends in one of .{', .'.join(sorted(formats))}; got {file.name}"
        )
    check_replaced(file, (_MARK if _format(file) in _MARK_KEY else "").encode())


def _format(file: Path) -> str:
    return file.suffix[1:].lower() or "png"
