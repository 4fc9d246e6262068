"""Adhesion loops: approach and retraction in small steps, with their instabilities.

The indenter is moved in small steps and held; each state is relaxed from the last one,
so that the surface stays in its minimum of energy until that minimum disappears. As
long as it does, the work done on the indenter is stored, ``dE = -N dZ``. A step whose
energy balance does not close is undone and repeated at half its size. The largest
tension is bracketed. The loop turns at a given penetration, or else where the force is
compressive by at least the largest tension so far: a rough indenter adheres by more
asperities the deeper it was.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

from ase_roughcontact._util.identity import differences
from ase_roughcontact.paths.instabilities import balanced, jumped, least_force
from ase_roughcontact.paths.loop_specification import LoopSpecification
from ase_roughcontact.paths.path_steps import DescribedSteps, LastStep, PathSteps
from ase_roughcontact.paths.record import LoadStep

# Normal force below which the error of the balance does not decrease further, in units
# of E* a0^2: about that on one atom in contact.
_SMALLEST_FORCE = 0.05
# Part of the smallest step by which the deepest height may be missed.
_ROUNDING = 1e-3
# Smallest step of which parts change the heights, relative to them.
_RESOLVED = 1e-12
# Smallest step at a kink of the force, where no energy is lost, relative to others.
_AT_KINK = 1 / 16


@dataclass
class _Position:
    """Where a loop is.

    Attributes
    ----------
    size : float
        Size of the next step (length).
    least : float
        Least force of the branch so far, at most zero.
    retracts : bool
        Whether it has turned.
    """

    size: float
    least: float = 0.0
    retracts: bool = False


@dataclass
class LoopSteps(PathSteps):
    """Heights of a loop whose steps are halved until their energy balance closes.

    Parameters
    ----------
    stepper : Stepper
        Its targets are heights.
    loop : LoopSpecification
        `AdhesionLoop.of` all steps is the loop.
    """

    loop: LoopSpecification

    def __post_init__(self) -> None:
        """Find the heights where to begin and to turn."""
        problem, wall = self.stepper.problem, self.stepper.problem.wall
        touching = self.stepper.windows.first_contact
        self._top = touching + wall.cutoff - wall.contact_distance
        self._bottom = touching - self.loop.lowest
        resolved = _RESOLVED * max(abs(self._top), abs(touching - self.loop.expected))
        if not self.loop.smallest_step > resolved:
            raise ValueError(
                f"smallest_step must be above {resolved:.2g}, the rounding of heights, "
                f"got {self.loop.smallest_step}"
            )
        unit = problem.solid.contact_modulus * problem.spacing**2
        self._smallest_force = _SMALLEST_FORCE * unit
        self.position = _Position(self.loop.step)

    def differences(self, path: dict[str, Any], number: int) -> list[str]:
        """Return in what the description of a step differs; see `PathSteps`."""
        if "loop" not in path:
            return ["its path is not a loop"]
        new = self.loop.todict() | self.system
        return differences(path["loop"] | path["system"], new)

    def remaining(self, last: LastStep | None) -> DescribedSteps:
        """Yield the states after the last one that is done; see `PathSteps`."""
        if last is not None:
            self.stepper.restart_from(last.state)
            self._kept, self._last = self.stepper.state, last.step
            self.position = _Position(**last.path["position"])
        for state in self._states(last is None):
            at = {"loop": self.loop.todict(), "position": asdict(self.position)}
            yield state, self.described(state.height, **at)

    def _states(self, anew: bool) -> Iterator[LoadStep]:
        """Approach until the loop turns, and retract until nothing interacts."""
        at = self.position
        if anew:
            top = self._top + 0.5 * self.loop.smallest_step
            yield self._accepted(self.stepper.step(0, top, self.record))
        if not at.retracts:
            while not self._turns():
                height = max(self._last.height - at.size, self._bottom)
                yield self._moved_towards(height)
            at.least, at.retracts = min(self._last.normal_force, 0.0), True
        while self._last.repulsive_atoms + self._last.attractive_atoms:
            yield self._moved_towards(self._last.height + at.size)

    def _turns(self) -> bool:
        """Return whether the loop turns at its last state.

        Raises
        ------
        RuntimeError
            If no depth is given and the force does not become compressive enough.
        """
        left = self._last.height - self._bottom
        at_bottom = left <= _ROUNDING * self.loop.smallest_step
        if self.loop.deepest is not None:
            return at_bottom
        force, tension = self._last.normal_force, -self.position.least
        if force > 0.0 and force >= tension:
            return True
        if at_bottom:
            raise RuntimeError(
                f"the loop does not turn: at a penetration of "
                f"{self._last.penetration:.4g} Å the force is {force:.4g} eV/Å, after "
                f"a tension of {tension:.4g} eV/Å: give deepest, where it turns anyway"
            )
        return False

    def _moved_towards(self, height: float) -> LoadStep:
        """Move to a height, or to one on the way up to which the force is known."""
        at, new, halved = self.position, self._relax(height), False
        # each height is nearer to the last one, until the step is the smallest
        while (between := self._height_between(new)) is not None:
            size = abs(new.height - self._last.height)
            at_kink = self._balanced(new)
            if size <= self.loop.smallest_step * (_AT_KINK if at_kink else 1.0):
                if jumped(self._last, new):
                    at.size, halved = self.loop.step, True  # on the new branch
                break
            # the rest of the step is tried next
            at.size = max(abs(height - between), abs(between - self._last.height))
            height, halved = between, True
            self.stepper.restart_from(self._kept)
            new = self._relax(height)
        if not halved:
            at.size = min(2.0 * at.size, self.loop.step)
        return self._accepted(new)

    def _height_between(self, new: LoadStep) -> float | None:
        """Return a height at which to relax before a new state, None to accept it."""
        if not self._balanced(new):
            return 0.5 * (self._last.height + new.height)
        height, force = least_force(self._last, new)
        known = min(self.position.least, new.normal_force)
        error = self.loop.tolerance * max(abs(force), self._smallest_force)
        return height if force < known - error else None

    def _balanced(self, new: LoadStep) -> bool:
        return balanced(self._last, new, self.loop.tolerance, self._smallest_force)

    def _relax(self, height: float) -> LoadStep:
        return self.stepper.step(self._last.step + 1, height, self.record)

    def _accepted(self, state: LoadStep) -> LoadStep:
        self._kept, self._last = self.stepper.state, state
        self.position.least = min(self.position.least, state.normal_force)
        return state
