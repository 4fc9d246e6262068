"""Comparison of optimizers on the deepest state of a scene."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from ase import Atoms

from ase_roughcontact.loading.path_atoms import ProblemAtoms
from ase_roughcontact.optimize.comparison import compare_optimizers
from ase_roughcontact.optimize.comparison_result import OptimizerComparison

if TYPE_CHECKING:
    from ase_roughcontact.scene.scene import Scene

# The solver for the wall finds the deepest state.
_SOLVER_DEFAULTS = {"solver.optimizer": None, "solver.fmax": None}


def deepest_atoms(scene: Scene) -> Atoms:
    """Return flat atoms on the window of the deepest state, and the indenter there.

    At a given height or penetration the indenter is at its height; under a load it is
    free, and at the height of the first contact.

    Parameters
    ----------
    scene : Scene
        Scene with the deepest state on its path.

    Returns
    -------
    Atoms
        Atoms with the padding of a free half space, and the indenter.

    Raises
    ------
    RuntimeError
        If the solver for the wall does not converge.
    """
    scene = scene.planned.with_values(_SOLVER_DEFAULTS)
    stepper = scene.stepper(scene.frames())
    target = float(scene.path.deepest_of(scene.targets.tolist()))
    relaxed = stepper.relax(stepper.start, target)
    if not relaxed.run.converged:
        raise RuntimeError(f"the deepest state is not found: {relaxed.run.message}")
    fixed = not scene.control.free
    frames = ProblemAtoms(
        scene.problem, relaxed.state.window, scene.bodies.symbol, fixed, padded=True
    )
    atoms = frames.atoms
    atoms.positions[-1, 2] = relaxed.height
    if not fixed:
        atoms.positions[-1, 2] = stepper.windows.first_contact
        atoms.calc.set(load=target)
    return atoms


def compare_on(
    scene: Scene,
    optimizers: Iterable[str] | None = None,
    accuracy: float = 0.01,
    *,
    max_steps: int = 2000,
) -> OptimizerComparison:
    """Compare optimizers on the deepest state of a scene; see `compare_optimizers`."""
    atoms = deepest_atoms(scene)
    return compare_optimizers(atoms, optimizers, accuracy, max_steps=max_steps)
