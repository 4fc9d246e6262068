"""Variants of a scene that `tradeoff` compares: choices, and the most accurate ones."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from ase_roughcontact.paths.accuracy import LEVELS, OF_ATOMS
from ase_roughcontact.scene.config import InteractionConfig
from ase_roughcontact.scene.scene import Scene
from ase_roughcontact.topography import SelfAffine

#: Number of realisations from which their spread is estimated; plans are checked on the
#: one after them.
PILOT = 4
# Sides of periodic cells in diameters of a smooth contact, as multiples of atoms that
# any grid divides.
_CELLS, _MULTIPLE = (2, 4), 16
# Loose and tight tolerance of the model of atoms.
_LOOSE, _TIGHT = 1e-1, 1e-8
# Error of the continuum that the finest grid is chosen for: half that of "high".
_FINEST = LEVELS["high"] / 2.0
# Cutoffs of the 9-3 wall in units of the spacing, and that of the most accurate scene.
_CUTOFFS, _LARGEST_CUTOFF = (3.0, 5.0, 10.0, 20.0), 30.0


def most_accurate(scene: Scene) -> Scene:
    """Return the scene with the most accurate numerical choices."""
    values: dict[str, Any] = {
        "solver.optimizer": None,
        "solver.fmax": None,
        "solver.accuracy": "high" if scene.is_continuum else _TIGHT,
    }
    is_given = "cutoff" in scene.interaction.entries()
    if "cutoff" in scene.wall.parameters and not is_given:
        values["interaction.cutoff"] = _LARGEST_CUTOFF
    if scene.substrate.periodic and scene.radius < math.inf:
        values |= {"substrate.periodic": False, "substrate.shape": "auto"}
    return scene.with_values(values).with_grid(None)


def finest_grid(best: Scene) -> Scene:
    """Return the scene on a grid finer than that of any choice, if the memory allows.

    The error of the most accurate choice is then only known by its own estimate.
    """
    if not best.is_continuum:
        return best
    finest = best.with_values({"solver.accuracy": _FINEST})
    try:
        finest.check()
    except MemoryError:
        return best
    return finest


def with_one_field(*scenes: Scene) -> tuple[Scene, ...]:
    """Return scenes with the period of the last one's local work of adhesion."""
    field = getattr(scenes[-1].local_adhesion, "pattern", None)
    if not isinstance(field, SelfAffine):
        return scenes
    domain = f"{field.side / scenes[-1].spacing:.12g} a0"
    return tuple(s.with_values({"heterogeneity.domain": domain}) for s in scenes)


def variants(best: Scene) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Yield source, label and settings of the choices that are calculated."""
    if best.is_continuum:
        for level in LEVELS:
            yield "grid", level, {"solver.accuracy": level}
    else:
        for error in (_LOOSE, OF_ATOMS):
            yield "tolerance", f"{error:g}", {"solver.accuracy": error}
    free: dict[str, Any] = {"substrate.periodic": False, "substrate.shape": "auto"}
    if best.interaction.entries().get("cutoff") == _LARGEST_CUTOFF:
        for cutoff in _CUTOFFS:
            yield "cutoff", f"{cutoff:g} a0", {"interaction.cutoff": cutoff}
    if best.radius < math.inf:
        yield "boundary", "free", free
    if best.radius < math.inf and best.control == "loads":
        largest = float(best.hertz_area(best.targets.max()))
        diameter = 2.0 * math.sqrt(largest / math.pi) / best.spacing
        for ratio in _CELLS:
            side = _MULTIPLE * math.ceil(ratio * diameter / _MULTIPLE)
            cells = {"substrate.periodic": True, "substrate.shape": (side, side)}
            yield "boundary", f"cell of {ratio} diameters", cells
    other = "repulsive" if best.wall.hard or best.wall.attractive else "hard"
    yield "wall", f"{other} instead", {"interaction": InteractionConfig(other)}


def unseen(scene: Scene, targets: Sequence[float]) -> tuple[Scene, Sequence[float]]:
    """Return another surface, or for a smooth one other targets."""
    if scene.roughness is not None:
        seed = scene.roughness.seed + PILOT
        return scene.with_values({"roughness.seed": seed}), targets
    between = np.unique([*targets, 0.9 * targets[-1]])
    return scene, list((between[1:] + between[:-1]) / 2.0)
