"""Output columns of nominally flat contacts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ase_roughcontact.results.column import Range, column
from ase_roughcontact.results.record import LoadStep

_PERIODIC = Range("periodic cells", lambda s: s.halfspace.periodic, constant=True)


@dataclass(frozen=True)
class FlatStep(LoadStep):
    """Result for a nominally flat indenter; its attributes are the output columns."""

    default_columns = ("conductance",)

    nominal_pressure: float = column(
        lambda s: s.fields.normal_force / (s.fields.gap.size * s.fields.cell_area),
        "force over the area of the periodic cell",
        "eV/Å^3",
        "pressure",
        _PERIODIC,
    )
    mean_gap: float = column(
        lambda s: float(np.maximum(s.fields.gap, 0.0).mean()),
        "mean distance of the surfaces over the periodic cell",
        "Å",
        "mean gap",
        _PERIODIC,
    )
