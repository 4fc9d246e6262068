"""Variants of a scene that `tradeoff` compares: choices, and the most accurate ones."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.contact.control import LOAD
from ase_roughcontact.optimize import ActiveSet, NewtonKrylov
from ase_roughcontact.scene.config import InteractionConfig
from ase_roughcontact.scene.scene import Scene
from ase_roughcontact.stepping.accuracy import ATOMS_ERROR, LEVELS
from ase_roughcontact.topography import SelfAffine

#: Number of realisations from which their spread is estimated; plans are checked on the
#: one after them.
PILOT = 4
#: Optimizers of this package, which need no tolerance of their own.
SOLVERS = NewtonKrylov, ActiveSet
# Sides of periodic cells, in diameters of a smooth contact.
_CELL_SIDES = (2, 4)
# Divisor of these sides (atoms), so that any grid divides them.
_SIDE_MULTIPLE = 16
# Errors for which a grid is chosen, between the errors of the levels.
_GRID_ERRORS = (0.03, 0.02, 0.005)
# Relative errors of the energy balance of a loop.
_LOOP_TOLERANCES = (1e-2, 1e-3)
# Relative error of the energy balance in the most accurate scene of a loop.
_MIN_LOOP_TOLERANCE = 1e-4
# Tolerances of optimizers of ASE, in units of E* a0^2.
_FORCE_TOLERANCES = (1e-3, 1e-4, 1e-5)
# Loose accuracy of the model of atoms.
_LOOSE_ACCURACY = 1e-1
# Accuracy of the model of atoms in the most accurate scene.
_TIGHT_ACCURACY = 1e-8
# Error of the continuum for which the finest grid is chosen: half the error of "high".
_FINEST_GRID_ERROR = LEVELS["high"] / 2.0
# Accuracy of the solver with which optimizers are compared.
_REFERENCE_ACCURACY = 1e-3
# Radius or modulus with which the plan of a loop is checked, relative to the given one.
_CHECKED_RATIO = 1.1
# Cutoffs of the 9-3 wall.
_CUTOFFS = ("3 a0", "5 a0", "10 a0", "20 a0")
# Cutoff of the 9-3 wall in the most accurate scene.
_MAX_CUTOFF = "30 a0"


def most_accurate(scene: Scene) -> Scene:
    """Return the scene with the most accurate numerical choices."""
    values: dict[str, Any] = {
        "solver.optimizer": None,
        "solver.fmax": None,
        "solver.accuracy": "high" if scene.is_continuum else _TIGHT_ACCURACY,
    }
    is_given = "cutoff" in scene.interaction.entries()
    if "cutoff" in scene.wall.parameters and not is_given:
        values["interaction.cutoff"] = _MAX_CUTOFF
    if scene.substrate.periodic and scene.radius < math.inf:
        values |= {"substrate.periodic": False, "substrate.shape": "auto"}
    if scene.path.is_loop:
        values["path.tolerance"] = _MIN_LOOP_TOLERANCE
    return scene.with_values(values).with_grid(None)


def of_continuum(best: Scene) -> Scene | None:
    """Return the most accurate scene of the continuum for a scene of counted atoms.

    None if the scene is of the continuum itself, or the solid is a lattice of atoms.
    """
    if best.is_continuum or best.substrate.of_atoms:
        return None
    return most_accurate(best.with_values({"substrate.model": "continuum"}))


def with_optimizers(scene: Scene) -> tuple[Scene, list[tuple[str, dict[str, Any]]]]:
    """Return a scene with the built-in solver, and choices of its optimizer of ASE.

    The choices are labels and settings; a solver of this package has no choices.
    """
    solved: dict[str, Any] = {"solver.optimizer": None, "solver.fmax": None}
    accurate = scene.with_values({**solved, "solver.accuracy": _REFERENCE_ACCURACY})
    if scene.is_continuum:
        accurate = accurate.with_grid(scene.grid_change)
    name = scene.solver.optimizer
    if name is None or scene.optimizer in SOLVERS:
        return accurate, []
    choices = [("built-in solver", solved)]
    force = scene.contact_modulus * scene.spacing**2
    for tolerance in _FORCE_TOLERANCES:
        fmax = float(f"{tolerance * force:.2g}")
        settings = {"solver.optimizer": name, "solver.fmax": fmax}
        choices.append((f"{name}, fmax = {fmax:g} eV/Å", settings))
    return accurate, choices


def finest_grid(best: Scene) -> Scene:
    """Return the scene on a grid finer than all choices, if the memory allows it.

    Otherwise the error of the most accurate choice is only known by its own estimate.
    """
    if not best.is_continuum:
        return best
    finest = best.with_values({"solver.accuracy": _FINEST_GRID_ERROR})
    try:
        finest.check()
    except MemoryError:
        return best
    return finest


def with_one_field(*scenes: Scene) -> tuple[Scene, ...]:
    """Return scenes with the period of the last one's local work of adhesion."""
    adhesion = scenes[-1].bodies.problem.heterogeneity
    field = None if adhesion is None else adhesion.pattern
    if not isinstance(field, SelfAffine):
        return scenes
    domain = f"{field.side / scenes[-1].spacing:.12g} a0"
    return tuple(
        scene.with_values({"heterogeneity.domain": domain}) for scene in scenes
    )


def variants(best: Scene) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Yield source, label and settings of the choices that are calculated."""
    if best.is_continuum:
        for level in LEVELS:
            yield "grid", level, {"solver.accuracy": level}
        for error in _GRID_ERRORS:
            yield "grid", f"{100 * error:g} %", {"solver.accuracy": error}
    else:
        for error in (_LOOSE_ACCURACY, ATOMS_ERROR):
            yield "tolerance", f"{error:g}", {"solver.accuracy": error}
    if best.path.is_loop:
        for tolerance in _LOOP_TOLERANCES:
            yield "steps", f"{tolerance:g}", {"path.tolerance": tolerance}
    free: dict[str, Any] = {"substrate.periodic": False, "substrate.shape": "auto"}
    if best.interaction.entries().get("cutoff") == _MAX_CUTOFF:
        for cutoff in _CUTOFFS:
            yield "cutoff", cutoff, {"interaction.cutoff": cutoff}
    if best.radius < math.inf:
        yield "boundary", "free", free
    if best.radius < math.inf and best.control == LOAD:
        largest = float(best.bodies.hertz_area(best.targets.max()))
        diameter = 2.0 * math.sqrt(largest / math.pi) / best.spacing
        for ratio in _CELL_SIDES:
            side = _SIDE_MULTIPLE * math.ceil(ratio * diameter / _SIDE_MULTIPLE)
            cells = {"substrate.periodic": True, "substrate.shape": (side, side)}
            yield "boundary", f"cell of {ratio} diameters", cells
    other = best.wall.compared_with
    yield "wall", f"{other} instead", {"interaction": InteractionConfig(other)}


def unseen(scene: Scene, targets: Sequence[float]) -> tuple[Scene, Sequence[float]]:
    """Return scene and targets to check a plan: other surface, targets or radius."""
    if scene.roughness is not None:
        seed = scene.roughness.seed + PILOT
        return scene.with_values({"roughness.seed": seed}), targets
    if scene.path.is_loop and scene.bodies.shape is not None:
        modulus = _CHECKED_RATIO * scene.contact_modulus / UNITS["GPa"]
        return scene.settled.with_values({"substrate.contact_modulus": modulus}), []
    if scene.path.is_loop:
        return scene.with_values(
            {"sphere.radius": f"{_CHECKED_RATIO * scene.radius} Å"}
        ), []
    between = np.unique([*targets, 0.9 * targets[-1]])
    return scene, list((between[1:] + between[:-1]) / 2.0)
