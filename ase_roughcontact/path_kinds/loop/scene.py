"""Loops of a scene: approach and retraction, with or without a cantilever."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ase_roughcontact._util.callers import warn
from ase_roughcontact._util.printing import number
from ase_roughcontact._util.units import UNITS, with_unit
from ase_roughcontact._util.validation import FloatArray
from ase_roughcontact.contact.control import HEIGHT, PENETRATION
from ase_roughcontact.path_kinds.loop.cantilever import (
    CantileverCurve,
    CantileverJump,
    cantilever_curve,
)
from ase_roughcontact.path_kinds.loop.instabilities import AdhesionLoop
from ase_roughcontact.path_kinds.loop.results import RESULTS
from ase_roughcontact.path_kinds.loop.specification import (
    ContactLoop,
    LoopSpecification,
)
from ase_roughcontact.path_kinds.loop.steps import LoopSteps
from ase_roughcontact.paths.path_steps import PathSteps
from ase_roughcontact.results.record import LoadStep
from ase_roughcontact.results.validity import Reaction
from ase_roughcontact.scene.bodies import Bodies
from ase_roughcontact.scene.path_kind import (
    PathKind,
    Steps,
    check_deepest,
    stiffness_of,
    turn_text,
    write_curve,
)
from ase_roughcontact.scene.scene import Scene
from ase_roughcontact.scene.section import lengths
from ase_roughcontact.stepping.step import Stepper

_NN, _NM = UNITS["nN"], UNITS["nm"]


@dataclass(frozen=True)
class Loop(PathKind):
    """``[path]`` of kind "loop": lengths in Å, or with a unit; see `adhesion_loop`."""

    kind = "loop"
    control = HEIGHT.name
    is_loop = True
    along = "penetration"
    units = {"cantilever_stiffness": "N/m"}
    aliases = {"cantilever": "cantilever_stiffness"}
    columns = {
        "penetration": "depth",
        "normal_force": "force",
        "contact_stiffness": "stiffness",
        "contact_area": "area",
        "largest_pressure": "p max",
        "seconds": "time",
    }
    captions = {
        "curve.png": "Contact area along the whole loop, also under tension, beside "
        "theory.",
        "loop.png": "Force of the tip held at each height; arrows: instabilities.",
        "cantilever.png": "Force curve of the cantilever; arrows: snap-in, pull-off.",
    }
    results = RESULTS
    main_result = "pull_off_force"

    deepest: float | str | None = None
    step: float | str | None = None
    tolerance: float = LoopSpecification.tolerance
    cantilever_stiffness: float | None = None

    @property
    def stiffness(self) -> float | None:
        """Stiffness of the cantilever (eV/Å^2); None without one."""
        return stiffness_of("cantilever_stiffness", self.cantilever_stiffness)

    def loop(self, bodies: Bodies) -> ContactLoop:
        """Return where the loop turns, its steps (Å) and the tolerance.

        Raises
        ------
        ValueError
            See `LoopSpecification`.
        """
        path = self.plain(["deepest", "step"], lengths(bodies.spacing), "Å")
        if path.deepest is not None:
            check_deepest(bodies, self.deepest, path.deepest)
        given = LoopSpecification(path.deepest, path.step, tolerance=path.tolerance)
        return given.on(bodies.problem, bodies.radius)

    def planned(self, bodies: Bodies) -> PathKind:
        """Return the path of one step, to the penetration at which the loop turns."""
        return Steps.at(PENETRATION, [self.loop(bodies).expected])

    def certain(self, bodies: Bodies) -> PathKind:
        """Return the path of one step, to a depth that is certainly reached."""
        if self.deepest is not None:
            return self.planned(bodies)
        return Steps.at(PENETRATION, [0.0])

    def describe(self, bodies: Bodies) -> str:
        """Return a text on the plan, with the force that a cantilever must hold."""
        if self.deepest is None:
            return (
                "The loop goes on until the tip is pressed as much as it was pulled "
                "before; its number of steps is not known. Its deepest state, at a "
                "depth that is an estimate:"
            )
        text = "The deepest state of the loop:"
        if self.stiffness is None:
            return text
        depth = self.loop(bodies).expected
        # the base at the deepest state must be lower than when the free tip jumps in
        force = self.stiffness * max(depth, 0.0) / _NN
        return (
            f"Cantilever of {self.cantilever_stiffness:.4g} N/m: if the contact still "
            f"pulls with more than about {force:.2g} nN at a depth of "
            f"{depth / _NM:.3g} nm, the tip jumps in beyond it: then give a larger "
            f"deepest, or a stiffer cantilever.\n\n{text}"
        )

    def steps_of(self, bodies: Bodies, stepper: Stepper) -> PathSteps:
        """Return the steps of the loop."""
        return LoopSteps(stepper, self.loop(bodies))

    def result(self, bodies: Bodies, states: Sequence[LoadStep]) -> AdhesionLoop:
        """Return the states as branches with their instabilities."""
        return AdhesionLoop.of(states, self.loop(bodies).smallest_step)

    def extremes(
        self, bodies: Bodies, states: Sequence[LoadStep]
    ) -> tuple[LoadStep, float]:
        """Return the deepest state, and the pull-off force (eV/Å)."""
        loop = self.result(bodies, states)
        return loop.approach[-1], loop.pull_off_force

    def summary(self, bodies: Bodies, states: Sequence[LoadStep]) -> dict[str, str]:
        """Return numbers of states and instabilities, forces and energies."""
        loop = self.result(bodies, states)
        jumps = len(loop.approach_jumps), len(loop.retraction_jumps)
        lost, error = loop.dissipated_energy, loop.dissipation_error
        found = {
            "states": str(len(states)),
            "instabilities": f"{jumps[0]} on approach, {jumps[1]} on retraction",
            "pull-off force": f"{with_unit(loop.pull_off_force, 'nN')} (simulation)",
            "turn": turn_text(loop.turn),
            "dissipated energy": _energy(lost, error),
        }
        with suppress(ValueError):  # the loop itself is valid
            curve = self._curve(loop)
            if curve is not None:
                found |= {
                    "cantilever": f"{self.cantilever_stiffness:.4g} N/m",
                    "cantilever snap-in": _jump(curve.snap_in),
                    "cantilever pull-off": _jump(curve.pull_off),
                    "cantilever dissipation": f"{number(curve.dissipated_energy)} eV",
                }
        return found

    def warnings(self, bodies: Bodies, states: Sequence[LoadStep]) -> tuple[str, ...]:
        """Return why the pull-off force is a lower bound; see `PathKind.warnings`."""
        return self.result(bodies, states).warnings

    def draw(
        self,
        bodies: Bodies,
        states: Sequence[LoadStep],
        folder: Path,
        ending: str = "png",
    ) -> Iterator[str]:
        """Draw force against depth, and with a cantilever its force curve."""
        # imports matplotlib
        from ase_roughcontact.path_kinds.loop import figures
        from ase_roughcontact.plot.files import draw_file

        loop = self.result(bodies, states)
        levels, curves = self._theory(bodies, states)
        name = f"loop.{ending}"
        figures.draw_loop(folder / name, loop, levels, curves)
        yield name
        curve = self._curve(loop)
        if curve is not None:
            down, up = curve.approach, curve.retraction
            names = ["approach"] * len(down.force) + ["retraction"] * len(up.force)
            columns = {
                "distance": np.concatenate([down.distance, up.distance]),
                "deflection": np.concatenate([down.deflection, up.deflection]),
                "force": np.concatenate([down.force, up.force]),
            }
            write_curve(folder / "cantilever.csv", names, columns)
            name = f"cantilever.{ending}"
            draw_file(folder / name, figures.plot_cantilever, curve)
            yield name

    def _theory(
        self, bodies: Bodies, states: Sequence[LoadStep]
    ) -> tuple[dict[str, float], dict[str, tuple[FloatArray, FloatArray]]]:
        """Return pull-off force, or else force over depth, of a smooth indenter."""
        if bodies.is_flat:
            return {}, {}
        modulus, work = bodies.contact_modulus, bodies.wall.work_of_adhesion
        smooth = bodies.smooth_theory(modulus, work)
        label = bodies.labelled(smooth.label)
        curves = bodies.forces_over_depth({label: smooth}, states)
        if curves or not smooth.pull_off_force:
            return {}, curves
        return {f"pull-off, {label}": smooth.pull_off_force}, {}

    def _curve(self, loop: AdhesionLoop) -> CantileverCurve | None:
        """Return the force curve with the cantilever; None without one."""
        stiffness = self.stiffness
        return None if stiffness is None else cantilever_curve(loop, stiffness)


def relax_loop(scene: Scene, validity: Reaction = "warn") -> AdhesionLoop:
    """Approach and retract along the path of a scene; see `adhesion_loop`.

    Parameters
    ----------
    scene : Scene
        Scene with a path of kind "loop".
    validity : {"warn", "raise", "ignore"}
        Reaction to a step that exceeds a limit of the model; see `load_path`.

    Returns
    -------
    AdhesionLoop

    Raises
    ------
    ValueError
        If the path is not a loop.
    """
    path = scene.path
    if not isinstance(path, Loop):
        raise ValueError(
            f'the path is not a loop but kind = "{path.kind}": give [path] kind = '
            '"loop"'
        )
    loop = path.result(scene.bodies, tuple(scene.relax(validity=validity)))
    for message in loop.warnings:
        warn(message)
    return loop


def _energy(lost: float, error: float) -> str:
    if math.isnan(error):
        return f"{number(lost)} eV; its error is not known, as steps have no results"
    if abs(lost) <= error:
        return f"none within the tolerance of {number(error, 2)} eV"
    return f"{number(lost)} ± {number(error, 2)} eV"


def _jump(jump: CantileverJump | None) -> str:
    if jump is None:
        return "none"
    return (
        f"from {jump.force_before / _NN:.4g} to {with_unit(jump.force_after, 'nN')} "
        f"with the base at {with_unit(jump.distance, 'nm')}"
    )
