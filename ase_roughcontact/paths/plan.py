"""Plan of a path: windows, memory and time of its steps, before they are calculated."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache, partial
from typing import Any

import numpy as np

from ase_roughcontact.contact import Contact, Problem
from ase_roughcontact.contact.control import LOAD, Control, control_of
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.paths.planned_steps import Plan, PlannedStep, step_timer, thinned
from ase_roughcontact.results.record import text_of
from ase_roughcontact.solvers.hard.active_set import check_capacity
from ase_roughcontact.theory import Hertz
from ase_roughcontact.topography import RoughSphere
from ase_roughcontact.windows.auto import CONTACT_WINDOW_SIZE, AutoWindow
from ase_roughcontact.windows.expected import (
    LARGEST_DOMAIN,
    ExpectedContact,
    coarser,
    contact_radius_on,
)
from ase_roughcontact.windows.fixed import at_edge
from ase_roughcontact.windows.footprint import BeyondSurfaceError
from ase_roughcontact.windows.memory import available_memory, memory_of

#: Approximation of paths without friction.
LATERAL_LEFT_OUT = (
    "displacements along x and y: without friction no force drives them, and their "
    "effect on the gap is of second order in the slopes (none for an isotropic half "
    "space with a Poisson ratio of 1/2)"
)

Shapes = tuple[tuple[int, int], tuple[int, int]]


def plan_path(
    problem: Problem,
    start: Box,
    control: Control | str,
    targets: Sequence[float] | np.ndarray,
    window: str,
    timed: bool = True,
) -> Plan:
    """Plan a path without calculating it; see `load_path` for the parameters.

    Parameters
    ----------
    problem : Problem
    start : Box
        Window of all steps, or of the first one.
    control : Control or str
        "penetration", "height" or "load", or their plural.
    targets : sequence of float
        Targets of the path, in the order of the steps.
    window : {"fixed", "auto"}
        Whether the window is fixed or follows the contact; see `load_path`.
    timed : bool
        Whether transforms are measured for the times of steps, which are NaN otherwise.

    Returns
    -------
    Plan
        Plan of at most 500 steps of the path. Windows at loads are made for Hertzian
        contacts; windows of rough spheres differ a little. Very large ones are planned
        on a coarser lattice, without short waves. A step can't be calculated if atoms
        could touch where the surface is not defined, or if a Hertzian contact, which is
        never wider than a rough one, is wider than a fixed window of a free half space.
    """
    wall, solid, control = problem.wall, problem.solid, control_of(control)
    indenter: Any = problem.indenter
    points = problem.topography.points(problem.spacing)
    timer = step_timer(problem.halfspace(start.shape), wall) if timed else None
    left_out = _left_out(problem, window)
    if window == "auto" and not problem.periodic:
        shapes = _auto_shapes(problem, control)
    else:
        if points > LARGEST_DOMAIN**2 and isinstance(indenter, RoughSphere):
            problem = replace(problem, indenter=replace(indenter, roughness=None))
        contact = problem.contact(start)
        shapes = partial(_fixed_shapes, problem, contact, control)
        if not problem.periodic and _misses_first_contact(problem, contact):
            left_out.append(
                "THE ATOM THAT IS TOUCHED FIRST: the indenter is lowest outside the "
                f"window of {text_of(start.shape)} atoms: give a larger shape"
            )
    steps: list[PlannedStep] = []
    beyond: list[BeyondSurfaceError] = []
    listed, counts = thinned(targets)
    for target, count in zip(listed.tolist(), counts.tolist(), strict=True):
        try:
            shape, grid = shapes(target)
        except BeyondSurfaceError as error:
            beyond.append(
                BeyondSurfaceError(problem.topography, problem.spacing, error.radius)
            )
            steps.append(PlannedStep(target, count, problem=beyond[-1].problem))
            continue
        except ValueError as error:
            steps.append(PlannedStep(target, count, problem=str(error)))
            continue
        memory = memory_of(shape, wall, solid, points=points, periodic=problem.periodic)
        seconds = timer(grid) if timer else math.nan
        steps.append(
            PlannedStep(target, count, text_of(shape), text_of(grid), memory, seconds)
        )
    largest = max(beyond, key=lambda error: error.radius, default=None)
    return Plan(
        tuple(steps),
        tuple(left_out),
        available_memory(),
        advice=largest.advice if largest else "",
        domain=largest.domain if largest else 0,
    )


def _auto_shapes(problem: Problem, control: Control) -> Callable[[float], Shapes]:
    """Return a function of the target: the expected window, and its FFT grid."""
    is_sphere = isinstance(problem.indenter, RoughSphere)
    expected = ExpectedContact(problem) if is_sphere else None

    @cache
    def windows(coarsening: int) -> tuple[AutoWindow, float]:
        lattice = problem if coarsening == 1 else coarser(problem, coarsening)
        ratio = lattice.spacing / problem.spacing
        return AutoWindow(lattice, max(round(CONTACT_WINDOW_SIZE / ratio**2), 1)), ratio

    def shapes(target: float) -> Shapes:
        coarsening = 1
        if expected:
            expected.check(control, target, memory=False)
            coarsening = expected.coarsening(control, target)
        window, ratio = windows(coarsening)
        n, m = window.forecast(control, target).shape
        shape = round(ratio * n), round(ratio * m)
        return shape, FreeHalfSpace.padded_shape(shape)

    return shapes


def _fixed_shapes(
    problem: Problem, contact: Contact, control: Control, target: float
) -> Shapes:
    """Return the shapes of the window and its FFT grid, if the contact fits into it."""
    halfspace = contact.halfspace
    if control == LOAD:
        check_capacity(contact, target)
    width = _contact_width(problem, contact, control, target)
    if not halfspace.periodic and width > min(halfspace.shape) - 1:
        raise ValueError(
            f"the contact is about {width:.0f} atoms wide, the window has "
            f"{text_of(halfspace.shape)}: give a larger shape"
        )
    return halfspace.shape, halfspace.grid


def _misses_first_contact(problem: Problem, contact: Contact) -> bool:
    """Return whether the indenter touches first outside the window."""
    try:
        lowest = AutoWindow(problem).footprint.lowest
    except ValueError:  # not a bounded indenter
        return False
    return bool(lowest < contact.heights.min())


def _contact_width(
    problem: Problem, contact: Contact, control: Control, target: float
) -> float:
    """Return the width of the Hertzian contact in atoms; zero if it is not known.

    Zero also if the rigid indenter is in the range of the wall only inside the window.
    """
    wall, radius = problem.wall, problem.topography.apex_radius
    if radius == math.inf:
        return 0.0
    if control == LOAD:
        load = max(target, 0.0)

        def radius_on(modulus: float) -> float:
            return float(Hertz(radius, modulus).contact_radius(load))

        a = contact_radius_on(problem.solid, problem.spacing, radius_on)
    else:
        height = control.height(target, contact.first_contact)
        if not at_edge(contact.heights < wall.cutoff - height):
            return 0.0
        # the depth of the mean sphere, not of the lowest atom
        a = math.sqrt(radius * max(wall.contact_distance - height, 0.0))
    return 2.0 * a / problem.spacing


def _left_out(problem: Problem, window: str) -> list[str]:
    """Return the effects that are not calculated, with the reasons."""
    wall, solid = problem.wall, problem.solid
    reasons = [LATERAL_LEFT_OUT]
    if problem.periodic:
        reasons.append("nothing of the cell: it repeats along x and y")
        if solid.uniform_compliance:
            reasons.append(
                "the uniform compression of the layer by the mean pressure: heights "
                "are measured from the mean plane of its surface"
            )
        return reasons
    reasons.append(
        "images of the contact: the half space is free, by exact convolution on a grid "
        "of twice the window"
    )
    if window == "fixed":
        reasons.append(
            "atoms outside the window: a contact that reaches its edge is an error"
        )
    elif wall.attractive or solid.bulges:
        reasons.append(
            "atoms beyond the range of the wall: they are checked after every step, "
            "and the window is enlarged until none is missing, beyond the planned one "
            "where adhesion or a bulge of the surface extends the contact"
        )
    else:
        reasons.append(
            "atoms that can't touch, as a repulsive wall lifts none; a large window is "
            "made for the contact only, and the other atoms are checked after the step"
        )
    if math.isfinite(wall.cutoff) and wall.cutoff > wall.contact_distance:
        reasons.append(
            f"the wall beyond a gap of {wall.cutoff:.4g} Å, where its energy is zero"
        )
    return reasons
