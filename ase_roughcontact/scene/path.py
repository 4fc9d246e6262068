"""Path of a scene: its targets, its atoms, its solver, and a plan of it."""

from __future__ import annotations

import math
from bisect import bisect_left
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np
from ase import Atoms

from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import grid_shape, integer, lookup, positive
from ase_roughcontact.atoms.calculator import contact_of
from ase_roughcontact.atoms.path_atoms import ProblemAtoms, relaxer_of
from ase_roughcontact.contact import Problem
from ase_roughcontact.elasticity import Crystal, Isotropic
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.paths.accuracy import Accuracy, accuracy_of
from ase_roughcontact.paths.hardness import hardness_for
from ase_roughcontact.paths.plan import plan_path
from ase_roughcontact.paths.planned_steps import Plan, PlannedStep, thinned
from ase_roughcontact.paths.record import LoadStep
from ase_roughcontact.paths.step import StepOptions, Stepper
from ase_roughcontact.scene.optimizers import OPTIMIZERS
from ase_roughcontact.scene.predictions import Predictions
from ase_roughcontact.windows.expected import (
    LARGEST_DOMAIN,
    ExpectedContact,
    coarsened,
)
from ase_roughcontact.windows.footprint import Footprint
from ase_roughcontact.windows.memory import check_memory, points_of
from ase_roughcontact.windows.regrid import on_grid

AnyPath = TypeVar("AnyPath", bound="ContactPath")

# Least side of the atoms before a window is chosen.
_FIRST_SIDE = 8
# Number of steps up to which an error lists them.
_MOST_LISTED = 20


@dataclass(frozen=True)
class ContactPath(Predictions):
    """What is calculated with the bodies of a scene, in units of ASE."""

    @property
    def control(self) -> str:
        """Controlled quantity of the path: loads, penetrations or heights."""
        return f"{self.path.control}s"

    @property
    def targets(self) -> np.ndarray:
        """Targets of the path: loads (eV/Å), penetrations or heights (Å)."""
        return self.path.targets(self)

    @property
    def planned(self: AnyPath) -> AnyPath:
        """The scene with the known targets that are planned and previewed."""
        path = self.path.planned(self)
        return self if path is self.path else replace(self, path=path)

    @property
    def fmax(self) -> float | None:
        """Tolerance of the forces (eV/Å); None if it is not given."""
        if self.solver.fmax is None:
            return None
        positive(fmax=self.solver.fmax)
        return self.solver.fmax * self.contact_modulus * self.spacing**2

    @property
    def accuracy(self) -> Accuracy:
        """Accuracy of force and area."""
        return accuracy_of(self.solver.accuracy, self.is_continuum)

    @property
    def max_steps(self) -> int:
        """Largest number of steps of the optimizer, for each step of the path."""
        return integer("max_steps", self.solver.max_steps, 1)

    @property
    def optimizer(self) -> Any:
        """Optimizer; None if it is chosen for the wall."""
        name = self.solver.optimizer
        return None if name is None else lookup(name, OPTIMIZERS, "optimizer")

    @property
    def shape(self) -> tuple[int, int] | None:
        """Shape of the window of atoms; None if it is chosen for each step."""
        shape = self.substrate.shape
        if not isinstance(shape, str):
            return grid_shape(shape)
        if self.substrate.periodic:
            raise ValueError(
                'shape = "auto" needs a free half space: give the shape of the '
                "periodic cell, [n, m]"
            )
        return lookup(shape, {"auto": None}, "shape")

    @property
    def window(self) -> str:
        """``"fixed"`` if all steps have the same window, else ``"auto"``."""
        return "fixed" if self.shape else "auto"

    @property
    def problem(self) -> Problem:
        """Solid, wall and indenter on the grid of the path."""
        return self._on_grid[0]

    @property
    def start(self) -> Box:
        """Window of all steps, or of the first one."""
        return self._on_grid[1]

    @property
    def _on_grid(self) -> tuple[Problem, Box]:
        return on_grid(*self.lattice, self.grid_change)

    @property
    def lattice(self) -> tuple[Problem, Box]:
        """The problem and its first window on the lattice of the atoms."""
        change = self.grid_change
        if self.shape:
            check_memory(change.shape(self.shape))
        first = math.ceil(_FIRST_SIDE / change.coarsen) * change.coarsen
        n, m = self.shape or (first, first)
        problem = Problem(
            indenter=self.surface,
            solid=self.solid,
            wall=self.wall,
            spacing=self.spacing,
            periodic=self.substrate.periodic,
            heterogeneity=self.local_adhesion,
        )
        return problem, Box((-(n // 2), -(m // 2)), (n, m))

    def atoms(self) -> Atoms:
        """Return the substrate and the indenter above it, with a calculator."""
        atoms = self.frames().atoms
        atoms.positions[-1, 2] = contact_of(atoms).first_contact
        return atoms

    def frames(self) -> ProblemAtoms:
        """Return the atoms of the path, which are made when they are needed."""
        return ProblemAtoms(*self._on_grid, self.symbol, self.path.control != "load")

    def stepper(
        self, frames: ProblemAtoms, record: type[LoadStep] = LoadStep
    ) -> Stepper:
        """Return what relaxes the steps of the path.

        Parameters
        ----------
        frames : ProblemAtoms
            Atoms on which an optimizer of ASE works.
        record : type
            Class of the results.

        Returns
        -------
        Stepper
        """
        (problem, window), control = self._on_grid, self.control
        options = StepOptions(
            relaxer=relaxer_of(self.optimizer, self.wall, frames),
            fmax=self.fmax,
            accuracy=self.solver.accuracy,
            max_steps=self.max_steps,
            window=self.window,
            hardness=hardness_for(self.lattice[0], self.symbol, self.hardness),
            record=record,
            continuum=self.is_continuum,
            lost_slope=self.lost_slope,
        )
        return Stepper(problem, control, window, options)

    @property
    def first_contact(self) -> float:
        """Height at which the indenter begins to repel the flat substrate (Å)."""
        if self.shape:
            return self.problem.contact(self.start).first_contact
        footprint = Footprint(self.problem.indenter, self.problem.spacing)
        return self.wall.contact_distance - footprint.lowest

    @property
    def cantilever(self) -> float | None:
        """Stiffness of the cantilever (eV/Å^2); None if it is not given."""
        return self.path.stiffness

    @property
    def expected_contact(self) -> ExpectedContact:
        """Bounds for the contact, which are known without the roughness."""
        change = self.grid_change
        surface: Any = change.surface(self.surface, self.spacing)
        return ExpectedContact(
            surface, self.wall, self.solid, change.spacing(self.spacing)
        )

    def check_path(self) -> None:
        """Raise an error if a step certainly can't be calculated in automatic windows.

        Nothing is calculated for this: neither the roughness nor a window.

        Raises
        ------
        ValueError
            If atoms touch where the roughness is not defined.
        MemoryError
            If a contact exceeds the free memory.
        """
        planned = self.planned
        if planned is not self:
            planned.check_path()
            return
        if self.shape:
            return
        expected, control = self.expected_contact, self.control
        steps = np.sort(self.targets)
        if control == "heights":  # the deepest one last
            steps = steps[::-1]
        problems = dict[int, ValueError | MemoryError]()

        def fails(number: int) -> bool:
            try:
                expected.check_surface(control, float(steps[number]))
                expected.check_memory(control, float(steps[number]))
            except (ValueError, MemoryError) as error:
                problems[number] = error
            return number in problems

        if fails(len(steps) - 1):
            first = bisect_left(range(len(steps)), True, key=fails)
            error = problems[len(steps) - 1]  # what the others need is less
            kind = MemoryError if isinstance(error, MemoryError) else ValueError
            raise kind(self._without(steps[first:], str(error))) from error

    def _without(self, failing: np.ndarray, problem: str) -> str:
        """Return a message that steps can't be calculated, and how to omit them."""
        unit = UNITS[self.path.unit]
        first, last = failing[[0, -1]] / unit
        kept = self.targets[~np.isin(self.targets, failing)] / unit
        which = f"{first:g}" if first == last else f"{first:g} to {last:g}"
        text = f"[path] {self.path.control} of {which} {self.path.unit}: {problem}"
        if not kept.size:
            return text
        if kept.size > _MOST_LISTED:
            return f"{text}; or leave out the {len(failing)} steps from {first:g} on"
        return f"{text}; or give values = [{', '.join(f'{k:.6g}' for k in kept)}]"

    def plan(self) -> Plan:
        """Return the windows, memory and time that the path will need.

        Very large windows and roughnesses are planned on a coarser lattice. Of a path
        that chooses its targets as it runs, `planned` has a plan. If the domain of the
        roughness is too small, the advised one is planned as well, as a larger one may
        be rougher.
        """
        plan, change = self._plan_of_domain(), self.grid_change
        if not plan.domain:
            return plan
        side = math.ceil(plan.domain / change.refine) * change.coarsen
        larger = self.with_values({"roughness.domain": f"{side} a0"}).plan()
        advice = f"give the roughness a domain of {side} a0 or more"
        return replace(plan, advice=larger.advice or advice)

    def _plan_of_domain(self) -> Plan:
        expected, control = self.expected_contact, self.control
        surface, spacing = expected.indenter, expected.spacing
        path: dict[str, Any] = {"indenter": surface, "spacing": spacing}
        if self.shape:
            many = points_of(surface, spacing) > LARGEST_DOMAIN**2
            scene = replace(self, roughness=None) if many else self
            problem, window = scene._on_grid
            return plan_path(problem, window, control, self.targets, "fixed", **path)
        targets, counts = thinned(self.targets)
        ratios = np.array([expected.coarsening(control, t) for t in targets.tolist()])
        plans, planned = {}, dict[float, PlannedStep]()
        for ratio in np.unique(ratios).tolist():
            problem, window = self._on_grid
            if ratio > 1:
                problem = self._coarse_problem(expected, ratio)
            part = targets[ratios == ratio]
            plans[ratio] = plan_path(problem, window, control, part, "auto", **path)
            planned |= {step.target: step for step in plans[ratio].steps}
        failing = next((p for p in reversed(plans.values()) if p.advice), plans[ratio])
        return replace(
            failing,
            steps=tuple(
                replace(planned[target], count=count)
                for target, count in zip(targets.tolist(), counts.tolist(), strict=True)
            ),
        )

    def _coarse_problem(self, expected: ExpectedContact, ratio: int) -> Problem:
        """Return the problem with which a plan is made on a coarser lattice."""
        surface, spacing = coarsened(expected.indenter, expected.spacing, ratio)
        solid = self.solid  # a crystal has only the spacing of its own
        if isinstance(solid, Crystal):
            solid = Isotropic(solid.contact_modulus)
        return Problem(surface, solid, self.wall, spacing)
