"""Preview of a scene: its steps, or some of them, on a much coarser grid."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.scene.scene import Scene
from ase_roughcontact.windows.regrid import GridChange, regrid

# Ratios of the spacings, tried in this order; the first one costs a sixteenth.
_RATIOS = (4, 2, 1)
# Part of the points and steps that are calculated: the time of small windows is hardly
# that of their points.
_PART = 1 / 96
# Part of the rms slope above which a grid loses too much.
_LARGEST_LOSS = 0.5


def preview(scene: Scene) -> Scene:
    """Return a scene that shows the results of another one in a part of its time.

    It asks for the continuum on a grid of up to four times the spacing, without the
    waves that this grid can't resolve, at every sixth step or fewer. A crystal of
    atoms becomes an isotropic solid of the same contact modulus. The errors are
    estimated as in any scene.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    Scene
    """
    continuum = _continuum(scene)
    for ratio in _RATIOS:
        coarse = continuum.with_grid(_coarser(scene.grids.change, ratio))
        if ratio == 1 or _is_possible(coarse):
            break
    if coarse.path.is_loop:
        return coarse
    every = math.ceil(1.0 / (_PART * ratio**2))
    number = len(scene.steps)
    count = min(number, max(2, math.ceil(number / every)))
    if coarse.path.values is None:
        return coarse.with_values({"path.steps": count})
    kept = np.linspace(0, number - 1, count).round().astype(int)
    values = tuple(coarse.path.values[i] for i in kept)
    return coarse.with_values({"path.values": values})


def _continuum(scene: Scene) -> Scene:
    """Return the scene that asks for the continuum, and has a solid without atoms."""
    solid = scene.substrate
    if solid.of_atoms:
        solid = replace(
            solid,
            calculator="",
            potential="",
            crystal="",
            spacing=scene.spacing,
            contact_modulus=scene.contact_modulus / UNITS["GPa"],
        )
    return scene.with_values({"substrate": replace(solid, model="continuum")})


def _coarser(change: GridChange, ratio: int) -> GridChange:
    """Return the grid of a multiple of the spacing."""
    common = math.gcd(change.refine, ratio)
    return GridChange(change.refine // common, change.coarsen * ratio // common)


def _is_possible(scene: Scene) -> bool:
    """Return whether a grid fits window and surface, and does not lose too much."""
    try:
        return regrid(scene.lattice(), scene.grids.change) <= _LARGEST_LOSS
    except ValueError:
        return False
