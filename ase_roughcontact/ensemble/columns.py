"""The columns of an ensemble: what is stored of each load step."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict
from importlib.metadata import version
from typing import Any, get_type_hints

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.paths.path_records import FlatStep, SlidingStep, TimeStep
from ase_roughcontact.paths.record import MISSING, LoadStep
from ase_roughcontact.scene import Scene


def _relative(scene: Scene, length: float | None) -> float | None:
    """Return a length in units of the spacing."""
    return None if length is None else length / scene.spacing


def _wavelength(scene: Scene, name: str) -> float | None:
    return _relative(scene, getattr(scene.rough, name, None))


def _rate(path: Any) -> float | None:
    """Return the rate of a path in time in the unit of the file, if it has one."""
    rate = getattr(path, "rate", None)
    return rate if isinstance(rate, (int, float)) else None


# Columns that the scene determines: type, and how to obtain the value, None if missing.
# Parameters of the wall are also those that follow from named materials.
_OF_SCENE: dict[str, tuple[type, Callable[[Scene], Any]]] = {
    "control": (str, lambda s: s.path.control),
    "radius": (float, lambda s: s.radius / s.spacing),
    "rms_slope": (float, lambda s: getattr(s.rough, "rms_slope", 0.0)),
    "hurst": (float, lambda s: getattr(s.rough, "hurst", None)),
    "short_wavelength": (float, lambda s: _wavelength(s, "short_wavelength")),
    "long_wavelength": (float, lambda s: _wavelength(s, "long_wavelength")),
    "seed": (int, lambda s: getattr(s.rough, "seed", None)),
    "kind": (str, lambda s: s.interaction.kind),
    "work_of_adhesion": (
        float,
        lambda s: s.wall.work_of_adhesion / UNITS["J/m^2"] or None,
    ),
    "attraction_range": (
        float,
        lambda s: _relative(s, s.wall.attraction_range or None),
    ),
    "hardness": (
        float,
        lambda s: s.hardness / UNITS["GPa"] if s.wall.hardness < math.inf else None,
    ),
    "permanent": (bool, lambda s: s.wall.permanent),
    "friction_coefficient": (
        float,
        lambda s: s.friction.coefficient if s.friction else None,
    ),
    "shear_strength": (
        float,
        lambda s: s.friction.shear_strength if s.friction else None,
    ),
    "spacing": (float, lambda s: s.spacing),
    "contact_modulus": (float, lambda s: s.contact_modulus),
    "rate": (float, lambda s: _rate(s.path)),
}

#: Columns of an ensemble and their types; see `read_ensemble`.
COLUMNS: dict[str, type] = {
    "case": str,
    "step": int,
    "control": str,
    "target": float,
    **{name: kind for name, (kind, _) in _OF_SCENE.items()},
    **{
        name: kind
        for record in (LoadStep, TimeStep, FlatStep, SlidingStep)
        for name, kind in get_type_hints(record).items()
        if name != "step"
    },
    "version": str,
}


def scene_columns(scene: Scene) -> dict[str, Any]:
    """Return the columns that a scene determines, the same for all its steps."""
    values = {name: value(scene) for name, (_, value) in _OF_SCENE.items()}
    return {
        name: MISSING[COLUMNS[name]] if value is None else COLUMNS[name](value)
        for name, value in values.items()
    }


def step_columns(case: str, scene: Scene, record: LoadStep) -> dict[str, Any]:
    """Return all columns of a load step of a case; see `COLUMNS`."""
    return {
        "case": case,
        "target": scene.path.target_of(scene.bodies, record),
        **scene_columns(scene),
        **asdict(record),
        # with a letter, since ASE's databases refuse text that reads as a number
        "version": f"v{version('ase-roughcontact')}",
    }
