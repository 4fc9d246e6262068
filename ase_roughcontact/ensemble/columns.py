"""The columns of an ensemble: what is stored of each load step."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict
from importlib.metadata import version
from typing import Any, get_type_hints

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.paths.record import MISSING, LoadStep
from ase_roughcontact.scene import Scene


def _roughness(name: str, smooth: float | None = None) -> Callable[[Scene], Any]:
    """Return a function that reads a parameter of the roughness, if it has it."""
    return lambda scene: getattr(scene.rough, name, smooth)


def _wavelength(name: str) -> Callable[[Scene], Any]:
    """Return a function that reads a wavelength in units of the spacing."""

    def value(scene: Scene) -> float | None:
        wavelength = getattr(scene.rough, name, None)
        return None if wavelength is None else wavelength / scene.spacing

    return value


def _work_of_adhesion(scene: Scene) -> float | None:
    """Return the work of adhesion (J/m^2), also that of named materials."""
    wall = scene.wall
    return wall.work_of_adhesion / UNITS["J/m^2"] if wall.attractive else None


def _attraction_range(scene: Scene) -> float | None:
    """Return the range of the attraction in units of the spacing."""
    wall = scene.wall
    return wall.attraction_range / scene.spacing if wall.attractive else None


def _hardness(scene: Scene) -> float | None:
    """Return the largest pressure of a plastic wall (GPa)."""
    hardness = scene.wall.hardness
    return hardness / UNITS["GPa"] if hardness < math.inf else None


# Columns that the scene determines: type, and how to obtain the value, None if missing.
_OF_SCENE: dict[str, tuple[type, Callable[[Scene], Any]]] = {
    "control": (str, lambda scene: scene.path.control),
    "radius": (float, lambda scene: scene.radius / scene.spacing),
    "rms_slope": (float, _roughness("rms_slope", 0.0)),
    "hurst": (float, _roughness("hurst")),
    "short_wavelength": (float, _wavelength("short_wavelength")),
    "long_wavelength": (float, _wavelength("long_wavelength")),
    "seed": (int, _roughness("seed")),
    "kind": (str, lambda scene: scene.interaction.kind),
    "work_of_adhesion": (float, _work_of_adhesion),
    "attraction_range": (float, _attraction_range),
    "hardness": (float, _hardness),
    "permanent": (bool, lambda scene: scene.wall.permanent),
    "spacing": (float, lambda scene: scene.spacing),
    "contact_modulus": (float, lambda scene: scene.contact_modulus),
}

#: Columns of an ensemble and their types; see `read_ensemble`.
COLUMNS: dict[str, type] = {
    "case": str,
    "step": int,
    "control": str,
    "target": float,
    **{name: kind for name, (kind, _) in _OF_SCENE.items()},
    **{name: kind for name, kind in get_type_hints(LoadStep).items() if name != "step"},
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
        "target": float(scene.targets[record.step]),
        **scene_columns(scene),
        **asdict(record),
        # with a letter, since ASE's databases refuse text that reads as a number
        "version": f"v{version('ase-roughcontact')}",
    }
