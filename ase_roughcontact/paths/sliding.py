r"""Sliding paths: contacts with friction under lateral displacements or forces.

Each step relaxes the contact along its normal, and then finds the lateral tractions at
its pressure, see `solvers.friction`. That the tractions do not change the pressure, nor
the pressure the lateral displacement, is exact for a Poisson's ratio of 1/2, and else
Goodman's approximation; or both are repeated until they agree, see `coupling`. The
indenter's heights are those before it slides: lateral displacements must be small
compared to the roughness.

References
----------
L. E. Goodman, J. Appl. Mech. 29, 515 (1962).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from time import perf_counter
from typing import Any

import numpy as np

from ase_roughcontact._util.validation import finite_array, one_of, positive
from ase_roughcontact.contact import State
from ase_roughcontact.contact.state import LATERAL, TRACTION_DEPTH, TRACTIONS
from ase_roughcontact.elasticity.lateral import LateralHalfSpace
from ase_roughcontact.elasticity.lattice import Box, carried
from ase_roughcontact.interactions.friction import FrictionLaw, check_law
from ase_roughcontact.paths.coupling import COUPLINGS, Coupling
from ase_roughcontact.paths.path_records import SlidingStep
from ase_roughcontact.paths.path_steps import LastStep, NumberedSteps
from ase_roughcontact.paths.record import LoadStep
from ase_roughcontact.paths.relaxed import LateralState, RelaxedStep
from ase_roughcontact.paths.retraction import step_in_contact
from ase_roughcontact.solvers.friction import Drive, FrictionOptions, solve_friction

#: What a sliding path prescribes laterally: displacement of the indenter, force on it,
#: or displacement of the base of a spring that moves it.
LATERAL_CONTROLS = ("displacements", "forces", "bases")
# Number of boxes of which half spaces are kept.
_KEPT_HALFSPACES = 3
# Relative difference of lateral targets that counts as rounding.
_ROUNDING = 1e-12


@dataclass
class SlidingSteps(NumberedSteps):
    """Steps of a contact with friction, each from the last one.

    At first the contact has no tractions, unless the stepper's state has: a first
    displacement is where the indenter comes down. A contact that can't carry a force is
    not converged: how far it slides is not known, and counted neither as displacement
    nor as energy.

    Parameters
    ----------
    stepper : Stepper
    targets : ndarray, shape (steps,), or float
        Of the stepper; one number is that of all steps.
    friction : FrictionLaw
    lateral : ndarray, shape (steps, 2) or (steps,)
        Lateral targets along x and y, or along x alone.
    control : {"displacements", "forces", "bases"}
        Whether they are displacements of the indenter (length), forces on it (force),
        or displacements of the base of a spring (length).
    spring : float, optional
        Stiffness of the spring, for bases (force/length).
    coupling : {"neglected", "solved"}
        Whether tractions leave the pressure as it is, and the pressure the lateral
        displacement. Where atoms come into contact within a step, they stick as if they
        had been in contact since its beginning: load in several steps.

    Raises
    ------
    ValueError
        If a target is not valid, or the spring is missing.
    TypeError
        If friction is no law.
    NotImplementedError
        If the solid has no lateral components.
    """

    kind = SlidingStep
    friction: FrictionLaw
    lateral: np.ndarray
    control: str = "displacements"
    spring: float | None = None
    coupling: str = "neglected"

    def __post_init__(self) -> None:
        """Check the targets, and set up the lateral response of the solid."""
        one_of(LATERAL_CONTROLS, control=self.control)
        one_of(COUPLINGS, coupling=self.coupling)
        if (self.control == "bases") != (self.spring is not None):
            raise ValueError(
                "bases need the stiffness of the spring, and only they do, got "
                f"spring={self.spring}"
            )
        if self.spring is not None:
            positive(spring=self.spring)
        check_law(self.friction)
        self._check_targets()
        self._origin = np.zeros(2)  # where the indenter came down
        if self.control == "displacements":
            self._origin = self.lateral[0]
        self._displacement: np.ndarray | None = None
        self._dissipated = 0.0
        self._cross: Coupling | None = None
        problem = self.stepper.problem
        if self.coupling == "solved":
            if problem.solid.coupling:  # none for a Poisson's ratio of 1/2
                self._cross = Coupling(problem, self.stepper.accuracy)
        elif TRACTION_DEPTH in self.stepper.state.history:
            raise ValueError(
                "the surface is displaced by tractions of a path with "
                "coupling='solved': go on with that, or start from new atoms"
            )

        @lru_cache(_KEPT_HALFSPACES)
        def halfspace(shape: tuple[int, int]) -> LateralHalfSpace:
            return LateralHalfSpace(
                shape, problem.spacing, problem.solid, problem.periodic
            )

        halfspace((2, 2))  # raises if the solid has no lateral components
        self._halfspace = halfspace

    def _check_targets(self) -> None:
        """Make one pair of targets for each step."""
        normal = finite_array(self.stepper.control, self.targets)
        path = finite_array(self.control, self.lateral)
        if path.ndim == 1:
            path = np.stack([path, np.zeros(path.shape)], axis=1)
        if path.ndim != 2 or path.shape[1] != 2 or not len(path):
            raise ValueError(
                f"{self.control} must be numbers along x, or rows of two along x and "
                f"y, got an array of the shape {path.shape}"
            )
        if normal.shape not in ((), (len(path),)):
            raise ValueError(
                f"give one of {self.stepper.control} for all {len(path)} "
                f"{self.control}, or one for each, got {normal.size}"
            )
        self.lateral, self.targets = path, np.broadcast_to(normal, len(path))

    @property
    def parameters(self) -> dict[str, Any]:
        """Friction, spring and coupling, which a state depends on."""
        law = {"friction": self.friction.todict(), "spring": self.spring or 0.0}
        return law | ({"coupling": "solved"} if self.coupling == "solved" else {})

    def resume(self, last: LastStep) -> None:
        """Continue after a step."""
        super().resume(last)
        self._displacement = np.array([last.step.lateral_x, last.step.lateral_y])
        self._dissipated = last.step.dissipated_energy

    def described_step(self, number: int) -> dict[str, Any]:
        """Return the description that the frame of a step carries."""
        lateral = {self.control: self.lateral[number].tolist()}
        return super().described_step(number) | {"lateral": lateral}

    def differences(self, path: dict[str, Any], number: int) -> list[str]:
        """Return in what the description of a step differs; see `PathSteps`."""
        found = super().differences(path, number)
        if found:
            return found
        old, new = path.get("lateral", {}).get(self.control), self.lateral
        if old is None:
            return [f"its path has no lateral {self.control}"]
        if abs(new[number] - old).max() > _ROUNDING * np.ptp(new, axis=0).max():
            values = [
                ", ".join(f"{v:.12g}" for v in each) for each in (old, new[number])
            ]
            found = [f"{self.control}[{number}] was {values[0]}, is {values[1]}"]
        return found

    def step(self, number: int) -> LoadStep:
        """Relax the contact, and then its tractions."""
        target, lateral = self.targets[number], self.lateral[number]
        slid = partial(self._slid, self.stepper.state, lateral)

        def completed(relaxed: RelaxedStep) -> RelaxedStep:
            begun = perf_counter() - relaxed.seconds
            if self._cross:
                again = partial(self.stepper.repeat, target=target)
                relaxed, state = self._cross.agreed(relaxed, again, slid)
            else:
                state = slid(relaxed)
            relaxed = relaxed.marked(state.solution.message)
            self._displacement, self._dissipated = state.displacement, state.dissipated
            self._fields = self._on_window(state, relaxed.run.state)
            return replace(relaxed, lateral=state, seconds=perf_counter() - begun)

        result = step_in_contact(self.stepper, number, target, self.record, completed)
        for key, values in self._fields.items():
            self.stepper.remember(key, values)
        return result

    def _on_window(self, lateral: LateralState, state: State) -> dict[str, np.ndarray]:
        """Return what the surface keeps of a step."""
        window, box, found = state.window, lateral.box, lateral.solution
        tractions, shifts = _carried(found.tractions, box, window), found.displacement
        if box != window:
            shifts = self._halfspace(window.shape).displacement(tractions)
        if self._cross:
            shifts = shifts + self._cross.lateral(state, window)
        slipping = carried(found.slipping.astype(float), box, window)
        return dict(zip(LATERAL, (*tractions, *shifts, slipping), strict=True))

    def _slid(
        self,
        before: State,
        lateral: np.ndarray,
        relaxed: RelaxedStep,
        last: LateralState | None = None,
        tolerance: float = 0.0,
    ) -> LateralState:
        """Return the tractions at a target; the last ones are at another pressure.

        The tolerance is at least that of `FrictionOptions`.
        """
        bounds, box, start = self._on_box(relaxed, before)
        halfspace = self._halfspace(box.shape)
        imposed, new = halfspace.displacement(start), 0.0
        by_pressure: np.ndarray | float = 0.0
        if self._cross:
            touching = bounds > 0.0  # coupled atoms have tractions
            new = float((touching & ~start.any(axis=0)).sum()) / max(touching.sum(), 1)
            by_pressure = self._cross.lateral(relaxed.run.state, box)
            imposed = imposed + self._cross.lateral(before, box) - by_pressure
        area, options = relaxed.fields.cell_area, FrictionOptions()
        at, move, drive = self._driven(lateral, area, last)
        imposed = imposed + move[:, None, None]
        if last is not None:
            start = _carried(last.solution.tractions, last.box, box)
        options = replace(options, tolerance=max(tolerance, options.tolerance))
        solution = solve_friction(
            halfspace, bounds, imposed, start, drive=drive, options=options
        )
        slip = imposed + solution.shift[:, None, None] - solution.displacement
        lost = area * float((solution.tractions * slip).sum())
        if self.control == "forces" and not solution.converged:
            move, lost = np.zeros(2), 0.0  # not known
            solution = replace(solution, shift=np.zeros(2))
        if last is not None:
            pairs = last.solution.pairs + solution.pairs
            solution = replace(solution, pairs=pairs)
        at = at + move + solution.shift
        return LateralState(
            box=box,
            halfspace=halfspace,
            bounds=bounds,
            displacement=at,
            moved=at - self._origin,
            base=lateral if self.spring else np.full(2, np.nan),
            dissipated=self._dissipated + lost,
            solution=solution,
            cell_area=area,
            by_pressure=by_pressure,
            new_contact=new,
        )

    def _on_box(
        self, relaxed: RelaxedStep, before: State
    ) -> tuple[np.ndarray, Box, np.ndarray]:
        """Return the bounds, a box of all tractions, and those before the step."""
        window, fields = relaxed.run.state.window, relaxed.fields
        problem = relaxed.problem
        place = problem.spacing, problem.origin(window)
        bounds = self.friction.bounds(fields.pressure, fields.contact, *place)
        old = [before.history.get(k, np.zeros(before.window.shape)) for k in TRACTIONS]
        box = window
        if not problem.periodic:
            loaded = Box.bounding(np.hypot(*old) > 0.0, before.window.start)
            touching = Box.bounding(bounds > 0.0, window.start)
            box = touching.union(loaded) if touching else loaded or Box((0, 0), (1, 1))
        return carried(bounds, window, box), box, _carried(old, before.window, box)

    def _driven(
        self, lateral: np.ndarray, area: float, last: LateralState | None
    ) -> tuple[np.ndarray, np.ndarray, Drive | None]:
        """Return where the indenter was, its known move, and what moves it further."""
        at = self._displacement
        if self.control == "displacements":
            at = lateral if at is None else at
            return at, lateral - at, None
        at = np.zeros(2) if at is None else at
        move = np.zeros(2) if last is None else last.displacement - at
        spring = self.spring or 0.0
        force = spring * (lateral - at - move) if spring else lateral
        x, y = (force / area).tolist()
        return at, move, Drive((x, y), spring / area)


def _carried(vectors: Iterable[np.ndarray], box: Box, window: Box) -> np.ndarray:
    """Return both components of vectors on another box."""
    return np.stack([carried(each, box, window) for each in vectors])
