"""Specification of an adhesion loop: where it turns, its steps, and their defaults.

A loop without a given depth turns where the normal force is compressive by at least the
largest tension before it. How deep that is follows from the loop itself; its plan, its
default step and the depth at which it is given up need an estimate.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ase_roughcontact._util.validation import finite, positive
from ase_roughcontact.contact import Problem
from ase_roughcontact.interactions import Interaction
from ase_roughcontact.theory import JKR, ShapeTheory
from ase_roughcontact.topography import HeightMap, RandomWaves, ShapedIndenter
from ase_roughcontact.topography.topography import Topography
from ase_roughcontact.windows.expected import contact_radius_on, modulus_under

# Default of the smallest step, relative to the largest step.
_SMALLEST_STEP_RATIO = 1 / 256
# Number of the largest steps of an approach by default.
_APPROACH_STEPS = 10
# Height of the highest peaks of a roughness, in units of its rms height.
_PEAK_RATIO = 2.0
# Largest depth of a loop without a given depth, in units of the expected depth.
_MAX_DEPTH_RATIO = 100.0


@dataclass(frozen=True)
class LoopSpecification:
    """Given numbers of a loop; the others follow from the contact.

    Attributes
    ----------
    deepest : float or None
        Penetration at which to turn; None to turn where the force is compressive by at
        least the largest tension before (length).
    step : float or None
        Largest step; None for a tenth of the way down (length).
    smallest_step : float or None
        Size below which steps are not halved; None for 1/256 of the largest (length).
    tolerance : float
        Relative tolerance of the energy balance of a step.

    Raises
    ------
    ValueError
        If a number is not finite, or a step or the tolerance not positive.
    """

    deepest: float | None = None
    step: float | None = None
    smallest_step: float | None = None
    tolerance: float = 1e-3

    def __post_init__(self) -> None:
        """Check the numbers that are given."""
        if self.deepest is not None:
            finite(deepest=self.deepest)
        if self.step is not None:
            positive(step=self.step)
        if self.smallest_step is not None:
            positive(smallest_step=self.smallest_step)
        positive(tolerance=self.tolerance)

    def on(self, problem: Problem, radius: float | None = None) -> ContactLoop:
        """Return the loop of a contact.

        Parameters
        ----------
        problem : Problem
        radius : float, optional
            Radius of the indenter; by default the radius that the problem knows
            (length).

        Raises
        ------
        ValueError
            If the range of the wall is infinite, the depth is beyond it, no depth is
            given and the wall does not attract, or the smallest step is larger than
            the largest.
        """
        wall = problem.wall
        if not math.isfinite(wall.cutoff):
            raise ValueError(
                "a loop begins and ends beyond the range of the wall: the wall must "
                f"have a finite cutoff, got {wall.cutoff}"
            )
        expected = self.deepest
        if expected is None:
            expected = expected_turn(problem, radius)
        if expected <= -wall.reach:
            raise ValueError(
                f"deepest must be a finite penetration above {-wall.reach:g}, where "
                f"the wall begins to act, got {self.deepest}"
            )
        step, smallest_step = self.step, self.smallest_step
        if step is None:
            step = default_step(wall, expected)
            positive(step=step)
        if smallest_step is None:
            smallest_step = _SMALLEST_STEP_RATIO * step
        if smallest_step > step:
            raise ValueError(
                f"smallest_step must not be larger than step {step}, got "
                f"{smallest_step}"
            )
        return ContactLoop(self.deepest, expected, step, smallest_step, self.tolerance)


@dataclass(frozen=True)
class ContactLoop:
    """Where the loop of a contact turns, and its steps.

    Attributes
    ----------
    deepest, tolerance
        See `LoopSpecification`.
    expected : float
        Penetration at which the loop turns, an estimate if it is not given (length).
    step, smallest_step : float
        Largest step, and size below which steps are not halved (length).
    """

    deepest: float | None
    expected: float
    step: float
    smallest_step: float
    tolerance: float

    @property
    def lowest(self) -> float:
        """Penetration at which the loop turns, or is given up (length)."""
        return (
            _MAX_DEPTH_RATIO * self.expected if self.deepest is None else self.deepest
        )

    def todict(self) -> dict[str, Any]:
        """Return the numbers on which the states of the loop depend."""
        return {
            "deepest": self.deepest,
            "step": self.step,
            "smallest_step": self.smallest_step,
            "tolerance": self.tolerance,
        }


def default_step(wall: Interaction, depth: float) -> float:
    """Return the default of the largest step of a loop: a tenth of the way down.

    Parameters
    ----------
    wall : Interaction
    depth : float
        Penetration at which the loop turns (length).

    Returns
    -------
    float
        Largest step (length).
    """
    return (wall.reach + depth) / _APPROACH_STEPS


def expected_turn(problem: Problem, radius: float | None = None) -> float:
    r"""Return an estimate of the penetration at which a loop turns by itself.

    A smooth sphere carries as much as its pull-off force at the depth of JKR theory
    under the load :math:`\frac32 \pi w R`. Peaks of a roughness touch before the sphere
    does, by two rms heights in this estimate. It is at least the range of the wall.

    Parameters
    ----------
    problem : Problem
    radius : float, optional
        Radius of the indenter; by default the radius that the problem knows (length).

    Returns
    -------
    float
        Penetration, positive (length).

    Raises
    ------
    ValueError
        If the wall does not attract, so that no force is tensile.
    """
    wall, indenter = problem.wall, problem.topography
    if not wall.attractive:
        raise ValueError(
            "a loop under a wall without attraction needs deepest, the penetration at "
            "which to turn"
        )
    if isinstance(indenter, ShapedIndenter):
        smooth = ShapeTheory(
            indenter.shape, problem.solid.contact_modulus, wall.work_of_adhesion
        )
        depth = smooth.penetration_under(smooth.pull_off_force)
        return max(depth, wall.attraction_range)
    radius = indenter.apex_radius if radius is None else radius
    depth = _peak_height(indenter)
    if radius < math.inf:
        depth += _depth_at_pull_off_load(problem, radius)
    return max(depth, wall.attraction_range)


def _depth_at_pull_off_load(problem: Problem, radius: float) -> float:
    """Return the penetration of a JKR sphere that is pressed by its pull-off force."""
    work = problem.wall.work_of_adhesion

    def contact_radius(modulus: float) -> float:
        jkr = JKR(radius, modulus, work)
        return float(jkr.contact_radius(jkr.pull_off_force))

    contact = contact_radius_on(problem.solid, problem.spacing, contact_radius)
    modulus = modulus_under(contact, problem.solid, problem.spacing)
    return float(JKR(radius, modulus, work).penetration(contact))


def _peak_height(indenter: Topography) -> float:
    """Return the height of the highest peaks; zero if the roughness is not known."""
    rough = indenter.rough
    if rough is indenter and not indenter.repeats:  # a whole tip
        return 0.0
    return _PEAK_RATIO * math.hypot(*map(_rms_height, rough.parts))


def _rms_height(rough: Topography) -> float:
    """Return the rms height; zero if it is not known (length)."""
    if isinstance(rough, RandomWaves):
        return rough.expected_height
    return rough.statistics().rms_height if isinstance(rough, HeightMap) else 0.0
