"""What a run of a scene tells: lines of text, and pictures beside theory."""

from ase_roughcontact.report.pictures import draw, write_view
from ase_roughcontact.report.text import (
    effort,
    farewell,
    heading,
    largest_tension,
    row,
    time_left,
    touching_height,
)

__all__ = [
    "draw",
    "effort",
    "farewell",
    "heading",
    "largest_tension",
    "row",
    "time_left",
    "touching_height",
    "write_view",
]
