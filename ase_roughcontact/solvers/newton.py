"""Relaxation of a soft wall by Newton's method with a cheap model of the half space.

The unknowns are the elastic pressure on the window and the indenter's height; the
`contact_energy` is their energy.

*Direction.* Newton's equations are solved loosely with a cheap model in place of the
Green's function (see `krylov`); the one exact convolution of a step gives its lift.
From the step and the few before it the best combination is made by the exact Hessian
among them, which costs no transform, always leads downhill, and makes up for what the
model misses.

*Load.* Under a wall that only repels, the indenter moves alone where nothing but its
force is larger than the tolerance.

*Length.* Along a step, energy and slope cost no transform either. The energy falls in
every step, down to rounding.

*Adhesion.* The wall's negative stiffness, in its tail, is left out while the forces
are large, so that the model is convex and the surface follows the state that a slow
approach would find; it is put in for the quadratic end.

References
----------
J. Nocedal, S. J. Wright, Numerical Optimization (2006), Ch. 7 (inexact Newton methods).
"""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator
from dataclasses import replace

import numpy as np

from ase_roughcontact._util.kernels import combined
from ase_roughcontact._util.validation import finite, finite_array, positive
from ase_roughcontact.contact import Contact
from ase_roughcontact.elasticity.circulant import CirculantModel
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.solvers.coarsening import can_coarsen, coarsen, refine
from ase_roughcontact.solvers.energy import ContactEnergy, State, Step
from ase_roughcontact.solvers.gcr import System, norm, residuals
from ase_roughcontact.solvers.relaxation import (
    External,
    Relaxation,
    indenter_stiffness,
    precision_advice,
)

# Residual pressure, in contact moduli: of coarse grids, and from where on the wall's
# negative stiffness is put in.
_COARSE = 0.1
_NEAR = 0.3
# Part of the residual that the linear solution may leave, and its steps at most.
_REDUCTION = 0.1
_KRYLOV_STEPS = 40
# The same of the exact equations: a solution of the model that leaves more of them than
# there was, it only preconditions.
_EXACT_REDUCTION = 1.0
_EXACT_STEPS = 10
# Part of the load that may be missing for a start to be worth more than coarser grids:
# a start with 5 % less load took 20, 17 and 22 pairs on free windows of 128, 256 and
# 480 atoms along a side, one with 20 % less 23, 23 and 27, and none 25, 24 and 23.
_FAR = 0.05
# The state under attraction depends on where it comes from, and is followed, unless the
# indenter is to move by so many spacings: deep in the wall's core, atoms would stall.
_FAR_DOWN = 3.0
# Steps that are combined with the present one.
_MEMORY = 3
# Steps without progress before giving up.
_PATIENCE = 5
# After so many steps an energy that fell by less than this many times its rounding (a
# millionth of its terms), with a force that was not halved, is no progress either.
_CRAWL = 50
_CRAWL_FALL = 1e8
_ROUNDED = "only rounding is left of the energy's fall"
# Steps on a coarse grid: a contact that attraction spreads over 800 x 800 atoms took
# 954 pairs with 50 of them, and 648 with 300.
_COARSE_STEPS = 300


def newton_krylov(
    contact: Contact,
    *,
    height: float,
    external: External | None,
    start: np.ndarray | None,
    tolerance: float,
) -> Generator[Relaxation, None, None]:
    """Relax the contact of a soft wall, step by step.

    Parameters
    ----------
    contact : Contact
        With any wall but the hard one.
    height : float
        Of the indenter (length): fixed, or where to start from if there is a load.
    external : callable, optional
        Energy and force, positive upward, of load and springs on the indenter at a
        height. By default the height is fixed.
    start : ndarray, shape (n, m), optional
        Pressure to start from. By default it comes from coarser grids, and with a load
        the height too; so it does if a wall that only repels, whose state is unique,
        carries much more or less than the load, and under any wall where the load would
        move the indenter by several spacings.
    tolerance : float
        Largest force that is left on any atom, and on the indenter if it is free.

    Yields
    ------
    Relaxation
        The start, and the state after each step. The last one is converged, or has a
        message that says why there is no further step; the energy never rises.

    Raises
    ------
    ValueError
        If the wall is hard, the start does not fit, or a number is not what it should
        be.
    """
    _check(contact, height, start, tolerance)
    spent = 0.0
    if start is None or _far(contact, height, external, start):
        start, height, spent = _cold_start(contact, height, external)
    start = np.asarray(start, float)
    for state in _relax(contact, height, external, start, tolerance):
        yield replace(state, pairs=state.pairs + spent)
        spent = 0.0


def _check(
    contact: Contact, height: float, start: np.ndarray | None, tolerance: float
) -> None:
    if contact.interaction.hard:
        raise ValueError("a hard wall has no gradient: relax it with ActiveSet")
    finite(height=height)
    positive(tolerance=tolerance)
    if start is not None:
        finite_array("start", start)
        if start.shape != contact.halfspace.shape:
            raise ValueError(
                f"start must have the shape {contact.halfspace.shape} of the window, "
                f"got {start.shape}"
            )


def _far(
    contact: Contact, height: float, external: External | None, start: np.ndarray
) -> bool:
    """Whether a start is so far from the load that coarser grids are nearer."""
    if external is None:
        return False
    gap = height + contact.heights - contact.halfspace.displacement(start)
    carried = contact.halfspace.cell_area * float(contact.wall(gap)[1].sum())
    load = -external(height)[1]
    if contact.interaction.attractive:
        way = abs(carried - load) / indenter_stiffness(contact)
        return way > _FAR_DOWN * contact.halfspace.spacing
    return abs(carried - load) > _FAR * abs(load)


def _cold_start(
    contact: Contact, height: float, external: External | None
) -> tuple[np.ndarray, float, float]:
    """Pressure and height to start from, and the pairs that they cost."""
    if not can_coarsen(contact):
        if external is not None:
            carried = ContactEnergy(contact, external).carrying_height()
            height = height if carried is None else carried
        return np.zeros(contact.heights.shape), height, 0.0
    coarse = coarsen(contact)
    start, height, pairs = _cold_start(coarse, height, external)
    halfspace = coarse.halfspace
    accuracy = _COARSE * halfspace.contact_modulus
    states = _relax(coarse, height, external, start, accuracy * halfspace.cell_area)
    for _, state in zip(range(_COARSE_STEPS), states, strict=False):
        pairs += state.pairs
    share = coarse.heights.size / contact.heights.size
    return refine(state.pressure, contact.heights.shape), state.height, pairs * share


class _Newton:
    """Steps downhill, and what they remember of each other."""

    def __init__(self, contact_energy: ContactEnergy) -> None:
        halfspace = contact_energy.contact.halfspace
        self.contact_energy, self.halfspace = contact_energy, halfspace
        self.convex = True
        self.near = _NEAR * halfspace.contact_modulus * halfspace.cell_area
        self.history: list[Step] = []
        self.model: CirculantModel | None = None
        self.points = 0
        self.reported = self._pairs()

    def advance(self, state: State, wanted: float) -> State | None:
        """Return a state of lower energy, None if there is none to be found."""
        if self.contact_energy.loaded and not self.contact_energy.resists(state):
            return self._approached(state)
        step = self._correction(state, max(_REDUCTION, 0.3 * wanted / state.error))
        if step is None or not (self.convex or self._downhill(state, step)):
            return None if self.convex else self._advance_convex(state, wanted)
        if abs(self.contact_energy.slope(state, step)) <= state.noise:
            self.convex = False  # only the quadratic end is left
            return self.contact_energy.moved(state, step, 1.0)
        steps = [step, *self.history]
        step, self.history = (
            self.contact_energy.combination(state, steps),
            steps[:_MEMORY],
        )
        length = self.contact_energy.line_search(state, step)
        if length == 0.0:
            return None if self.convex else self._advance_convex(state, wanted)
        self._choose(state, length)
        return self.contact_energy.moved(state, step, length)

    def report(
        self, state: State, *, converged: bool = False, message: str = ""
    ) -> Relaxation:
        """Return a state for the outside, and what it cost since the last one."""
        pairs = self._pairs()
        spent, self.reported = pairs - self.reported, pairs
        return Relaxation(
            pressure=state.pressure,
            height=state.height,
            energy=state.energy,
            error=state.error,
            converged=converged,
            message=message,
            pairs=spent,
        )

    def forget(self) -> None:
        """Start anew, with the wall as it is."""
        self.history, self.convex = [], False

    def _pairs(self) -> float:
        """Count the transforms so far, in units of padded pairs on the window."""
        size = math.prod(self.halfspace.grid)
        return self.halfspace.pairs + self.points / size

    def _advance_convex(self, state: State, wanted: float) -> State | None:
        self.convex, self.near = True, _NEAR * state.error
        return self.advance(state, wanted)

    def _choose(self, state: State, length: float) -> None:
        """Take the negative stiffness in while steps are accepted whole."""
        if length < 0.5 and not self.convex:
            self.convex, self.near = True, _NEAR * state.error
        elif length >= 1.0 and state.error < self.near:
            self.convex = False

    def _approached(self, state: State) -> State | None:
        """Bring the indenter down to where the frozen surface carries the load."""
        height = self.contact_energy.carrying_height(state.lift, state.height)
        if height is None or height == state.height:
            return None
        return self.contact_energy.state(state.pressure, state.lift, height)

    def _correction(self, state: State, reduction: float) -> Step | None:
        """Newton's step by the model, and its exact lift."""
        stiffness = state.stiffness[state.box.slices]
        if self.convex:
            stiffness = np.maximum(stiffness, 0.0, out=np.empty(stiffness.shape))
        model = self._model(state.box)
        row = None
        if self.contact_energy.loaded:
            area = self.halfspace.cell_area
            missing = float(state.residual.sum()) - state.load_residual / area
            row = self.contact_energy.spring(state.height) / area, missing
        before = model.transforms
        system = System(model, state.box, stiffness)
        step = self._solved(system, state, row, reduction)
        self.points += (model.transforms - before) * model.points
        return step

    def _model(self, needed: Box) -> CirculantModel:
        """Model of the half space for some atoms, the last one if it has them all."""
        if self.model is None or not self.model.box.contains(needed):
            self.model = CirculantModel(self.halfspace, needed)
        return self.model

    def _solved(
        self,
        system: System,
        state: State,
        row: tuple[float, float] | None,
        reduction: float,
    ) -> Step | None:
        """Solve by the model, and again for what is left with the exact lift.

        Where atoms overlap deeply, the wall is so stiff that the model's small error
        spoils its solution: then it only preconditions the exact equations.
        """
        right = system.rows(state.residual[state.box.slices])
        change = system.solve(right, row, reduction, _KRYLOV_STEPS)
        if change is None:
            return None
        step = self._step(state, change)
        if self.model is not None and self.model.exact:
            return step
        image = system.image(change, step.lift[state.box.slices])
        accepted = _EXACT_REDUCTION * max(norm(right), norm(image))
        rest = combined([(1.0, right), (-1.0, image)])
        if norm(rest) <= accepted:
            return step

        def exact(change: np.ndarray) -> np.ndarray:
            lift = self._step(state, change).lift
            return system.image(change, lift[state.box.slices])

        def precondition(rest: np.ndarray) -> np.ndarray:
            still = None if row is None else (row[0], 0.0)
            found = system.solve(rest, still, reduction, _KRYLOV_STEPS)
            return np.append(rest, 0.0) if found is None else found

        more = residuals(exact, precondition, rest, accepted, _EXACT_STEPS)
        return self._step(state, change + more)

    def _step(self, state: State, change: np.ndarray) -> Step:
        """Return a change of pressure and height with its exact lift."""
        pressure = np.zeros(state.pressure.shape)
        pressure[state.box.slices] = change[:-1].reshape(state.box.shape)
        return Step(pressure, self.contact_energy.lift(pressure), float(change[-1]))

    def _downhill(self, state: State, step: Step) -> bool:
        falls = self.contact_energy.slope(state, step) < 0.0
        return falls and self.contact_energy.curvatures(state, [step])[0, 0] > 0.0


class _Progress:
    """What has been reached since a state, and whether the steps lead anywhere."""

    def __init__(self, state: State) -> None:
        self.best = state
        self.milestone = state.energy, state.error
        self.steps = self.idle = 0
        self.obstacle = ""

    def note(self, old: State, new: State) -> None:
        """Take a step into account."""
        lower = new.energy < old.energy - old.noise
        self.idle = 0 if lower or new.error < 0.9 * self.best.error else self.idle + 1
        if lower or new.error < self.best.error:
            self.best = new
        if self.idle > _PATIENCE:
            self.obstacle = _ROUNDED
        self.steps += 1
        if self.steps % _CRAWL == 0:
            (energy, error), self.milestone = self.milestone, (new.energy, new.error)
            fall = energy - new.energy
            if fall < _CRAWL_FALL * new.noise and new.error > 0.5 * error:
                slow = "the energy falls too slowly to matter"
                self.obstacle = slow if fall > _CRAWL * new.noise else _ROUNDED


def _relax(
    contact: Contact,
    height: float,
    external: External | None,
    start: np.ndarray,
    tolerance: float,
) -> Iterator[Relaxation]:
    """Relax on one grid."""
    contact_energy = ContactEnergy(contact, external)
    newton = _Newton(contact_energy)
    state = contact_energy.state(start, contact_energy.lift(start), height)
    progress = _Progress(state)
    fresh, refreshed = True, False
    while True:
        if state.error <= tolerance and not fresh:
            state = contact_energy.balanced(contact_energy.afresh(state), tolerance)
            progress.best, fresh = state, True
        if state.error <= tolerance:
            yield newton.report(state, converged=True)
            return
        yield newton.report(state)
        new = newton.advance(state, tolerance)
        if new is None:
            held = not contact_energy.loaded or contact_energy.resists(state)
            progress.obstacle = (
                "no step lowers the energy" if held else "nothing holds the indenter"
            )
        else:
            new = contact_energy.balanced(new, tolerance)
            progress.note(state, new)
            state, fresh = new, False
        if progress.obstacle:
            state = contact_energy.afresh(progress.best)
            if refreshed and not state.error <= tolerance:
                break
            newton.forget()
            progress, fresh, refreshed = _Progress(state), True, True
    obstacle = progress.obstacle + precision_advice(contact_energy.contact.halfspace)
    if not math.isfinite(state.error):
        obstacle = "energy or pressure of the wall are not finite"
    message = f"stalled at a force of {state.error:.2g}: {obstacle}"
    yield newton.report(state, message=message)
