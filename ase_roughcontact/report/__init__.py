"""What a run of a scene tells: lines of text, and pictures beside theory."""

from ase_roughcontact.report.pictures import draw, write_view
from ase_roughcontact.report.text import (
    farewell,
    heading,
    largest_tension,
    row,
    time_left,
    touching_height,
)

__all__ = [
    "draw",
    "farewell",
    "heading",
    "largest_tension",
    "row",
    "time_left",
    "touching_height",
    "write_view",
]
