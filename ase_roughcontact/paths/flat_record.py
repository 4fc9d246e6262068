"""Output columns of nominally flat contacts."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ase_roughcontact.paths.record import LoadStep, column
from ase_roughcontact.paths.relaxed import RelaxedStep


@dataclass(frozen=True)
class FlatStep(LoadStep):
    """Result for a nominally flat indenter; its attributes are the output columns."""

    nominal_pressure: float = column(
        lambda s: s.fields.normal_force / _cell_area(s),
        "force over the area of the periodic cell",
        "eV/Å^3",
        "pressure",
    )
    mean_gap: float = column(
        lambda s: float(np.maximum(s.fields.gap, 0.0).mean()),
        "mean distance of the surfaces over the periodic cell",
        "Å",
        "mean gap",
    )


def _cell_area(step: RelaxedStep) -> float:
    return math.prod(step.halfspace.shape) * step.fields.cell_area
