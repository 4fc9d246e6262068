"""Adhesion loops: approach and retraction in small steps, with their instabilities.

The indenter is moved in small steps and held; each state is relaxed from the last one,
so that the surface stays in its minimum of energy until that minimum disappears. As
long as it does, the work done on the indenter is stored, ``dE = -N dZ``. If the energy
balance of a step does not close, it is undone and repeated at half its size. The
largest tension is bracketed. The loop turns at a given penetration, or else where the
force is compressive by at least the largest tension so far: a rough indenter adheres by
more asperities the deeper it was.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from ase_roughcontact._util.identity import differences
from ase_roughcontact.contact import State
from ase_roughcontact.path_kinds.loop.instabilities import balanced, jumped, least_force
from ase_roughcontact.path_kinds.loop.specification import ContactLoop
from ase_roughcontact.paths.path_steps import PathStep, PathSteps, Position
from ase_roughcontact.paths.restart import Restart
from ase_roughcontact.results.record import LoadStep
from ase_roughcontact.stepping.relaxed import RelaxedStep

# Normal force below which the error of the balance does not decrease further, in units
# of E* a0^2: about the force on one atom in contact.
_SMALLEST_FORCE = 0.05
# Largest distance from the deepest height at the turn, relative to the smallest step.
_MAX_TURN_DISTANCE = 1e-3
# Smallest step that still changes the heights when divided, relative to the heights.
_MIN_RELATIVE_STEP = 1e-12
# Smallest step at a kink of the force, where no energy is lost, relative to others.
_KINK_STEP_RATIO = 1 / 16


@dataclass(frozen=True)
class LoopPosition(Position):
    """Position of a state in a loop.

    Attributes
    ----------
    size : float
        Size of the next step (length).
    least : float
        Least force of the branch so far, at most zero.
    retracts : bool
        Whether the loop has turned.
    """

    size: float
    least: float = 0.0
    retracts: bool = False


@dataclass
class LoopSteps(PathSteps):
    """Heights of a loop, in steps halved until their energy balance closes.

    Parameters
    ----------
    stepper : Stepper
        Stepper with heights as targets.
    loop : ContactLoop
        `AdhesionLoop.of` all steps is the loop.
    """

    position = LoopPosition
    loop: ContactLoop

    def __post_init__(self) -> None:
        """Find the heights where to begin and to turn."""
        problem, wall = self.stepper.problem, self.stepper.problem.wall
        touching = self.stepper.windows.first_contact
        self._top = touching + wall.reach
        self._bottom = touching - self.loop.lowest
        resolved = _MIN_RELATIVE_STEP * max(
            abs(self._top), abs(touching - self.loop.expected)
        )
        if not self.loop.smallest_step > resolved:
            raise ValueError(
                f"smallest_step must be above {resolved:.2g}, the rounding of heights, "
                f"got {self.loop.smallest_step}"
            )
        if self.loop.deepest is not None:
            self.stepper.windows.check(self._bottom)
        unit = problem.solid.contact_modulus * problem.spacing**2
        self._smallest_force = _SMALLEST_FORCE * unit

    @property
    def specification(self) -> dict[str, Any]:
        """Quantities that the loop prescribes for all its steps; see `PathSteps`."""
        return {"loop": self.loop.todict()}

    def differences(self, done: Restart) -> list[str]:
        """Return the differences of the finished steps; see `PathSteps`."""
        return differences(done.path["loop"], self.loop.todict())

    def start(self, state: State) -> PathStep:
        """Return the start of the loop; see `PathSteps`."""
        return PathStep(None, state, {}, LoopPosition(self.loop.step))

    def steps(
        self, last: PathStep, record: type[Any]
    ) -> Iterator[tuple[PathStep, RelaxedStep]]:
        """Approach until the loop turns, and retract until nothing interacts."""
        at = last
        if at.record is None:
            top = self._top + 0.5 * self.loop.smallest_step
            at, left = self._kept(at.position, *self._relax(top, at, record))
            yield at, left
        if not at.position.retracts:
            while not self._turns(at):
                height = max(at.record.height - at.position.size, self._bottom)
                at, left = self._moved_towards(height, at, record)
                yield at, left
            least = min(at.record.normal_force, 0.0)
            at = replace(at, position=replace(at.position, least=least, retracts=True))
        while at.record.repulsive_atoms + at.record.attractive_atoms:
            height = at.record.height + at.position.size
            at, left = self._moved_towards(height, at, record)
            yield at, left

    def _turns(self, at: PathStep) -> bool:
        """Return whether the loop turns at its last state.

        Raises
        ------
        RuntimeError
            If no depth is given and the force does not become compressive enough.
        """
        left = at.record.height - self._bottom
        at_bottom = left <= _MAX_TURN_DISTANCE * self.loop.smallest_step
        if self.loop.deepest is not None:
            return at_bottom
        force, tension = at.record.normal_force, -at.position.least
        if force > 0.0 and force >= tension:
            return True
        if at_bottom:
            raise RuntimeError(
                f"the loop does not turn: at a penetration of "
                f"{at.record.penetration:.4g} Å the force is {force:.4g} eV/Å, after "
                f"a tension of {tension:.4g} eV/Å: give deepest, where it turns anyway"
            )
        return False

    def _moved_towards(
        self, height: float, at: PathStep, record: type[Any]
    ) -> tuple[PathStep, RelaxedStep]:
        """Move to a height, or to one on the way up to which the force is known."""
        size, halved = at.position.size, False
        relaxed, new = self._relax(height, at, record)
        # each height is nearer to the last one, until the step is the smallest
        while (between := self._height_between(at, new)) is not None:
            moved = abs(new.height - at.record.height)
            at_kink = self._balanced(at.record, new)
            if moved <= self.loop.smallest_step * (
                _KINK_STEP_RATIO if at_kink else 1.0
            ):
                if jumped(at.record, new):
                    size, halved = self.loop.step, True  # on the new branch
                break
            # the rest of the step is tried next
            size = max(abs(height - between), abs(between - at.record.height))
            height, halved = between, True
            relaxed, new = self._relax(height, at, record)
        if not halved:
            size = min(2.0 * size, self.loop.step)
        return self._kept(replace(at.position, size=size), relaxed, new)

    def _height_between(self, at: PathStep, new: LoadStep) -> float | None:
        """Return a height at which to relax before a new state, None to accept it."""
        if not self._balanced(at.record, new):
            return 0.5 * (at.record.height + new.height)
        height, force = least_force(at.record, new)
        known = min(at.position.least, new.normal_force)
        error = self.loop.tolerance * max(abs(force), self._smallest_force)
        return height if force < known - error else None

    def _balanced(self, last: LoadStep, new: LoadStep) -> bool:
        return balanced(last, new, self.loop.tolerance, self._smallest_force)

    def _relax(
        self, height: float, at: PathStep, record: type[Any]
    ) -> tuple[RelaxedStep, LoadStep]:
        relaxed = self.stepper.relax(at.state, height, number=at.number + 1)
        return relaxed, record.of(relaxed)

    def _kept(
        self, position: LoopPosition, relaxed: RelaxedStep, new: LoadStep
    ) -> tuple[PathStep, RelaxedStep]:
        """Return a state that is kept, with its position."""
        position = replace(position, least=min(position.least, new.normal_force))
        left = self.stepper.commit(relaxed)
        return PathStep(new, left.state, {"target": new.height}, position), left
