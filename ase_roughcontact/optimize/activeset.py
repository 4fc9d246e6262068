r"""The contact problem of a hard wall on one grid.

*Outer steps*, defect correction. One exact convolution gives the exact gap. Then
:math:`G` is replaced by a `Circulant` on the atoms that may touch, and the contact
problem of this model is solved for the correction of the pressure. The model's gradient
is exact at the present pressure, hence its minimum lies in a direction of descent: a
step that overshoots is cut to the least energy :math:`p \cdot G p/2 + (Z + h) \cdot p`
along it, which so never rises. Where the model is not good enough, the last moves are
combined to the least energy among them.

*Inner steps*, inexact active set. With the present set of atoms in contact the model's
linear system is solved by conjugate gradients, preconditioned by the model's inverse,
to a tenth of the violation only; then atoms under tension leave and atoms that overlap
enter. Vectors are lists of the atoms that may touch, `members` the positions in these
lists of those that do.

References
----------
M. Hintermüller, K. Ito, K. Kunisch, SIAM J. Optim. 13, 865 (2002) (active set);
I. A. Polonsky, L. M. Keer, Wear 231, 206 (1999); E. A. H. Vollebregt, J. Comput. Phys.
257, 332 (2014) (preconditioner).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ase_roughcontact.condensed import ScatteredHalfSpace
from ase_roughcontact.contact import Contact
from ase_roughcontact.halfspace import HalfSpace
from ase_roughcontact.optimize.circulant import Circulant
from ase_roughcontact.optimize.matrix import Matrix
from ase_roughcontact.optimize.problem import dot, precision_advice

# Part of a violation that the model's solution may leave, and that its linear systems
# may leave before the set of atoms in contact is looked at again.
_CONTRACTION = 0.1
_FORCING = 0.1
# Moves before the last that are combined with it, where a violation stays above this
# part of the one before: large contacts that fill their window (a contact of 1500 atoms
# across took 82 pairs instead of 127).
_MEMORY = 2
_SLOW = 0.3
# Steps of conjugate gradients for one correction, outer steps without progress.
_BUDGET = 300
_PATIENCE = 10


@dataclass(frozen=True)
class Step:
    """Where the solver has come to.

    Attributes
    ----------
    pressure : ndarray, shape (n, m)
        Nowhere negative (pressure).
    displacement : ndarray, shape (n, m), or None
        ``-G pressure`` (length), if it is known.
    height : float
        Of the indenter (length).
    elastic_energy : float
        Of the half space.
    violation : float
        Largest gap in contact or overlap outside of it (length).
    converged : bool
        Whether the violation is small enough.
    message : str
        Why there is no way on.
    work : float
        Number of grid points transformed (forth and back) since the last step.
    """

    pressure: np.ndarray
    displacement: np.ndarray | None
    height: float
    elastic_energy: float
    violation: float
    converged: bool
    message: str
    work: float


def descend(
    contact: Contact,
    height: float,
    load: float | None,
    start: np.ndarray | None,
    tolerance: float,
) -> Iterator[Step]:
    """Solve the contact problem on the grid as it is.

    Parameters
    ----------
    contact : Contact
        Its wall is taken for hard.
    height : float
        Of the indenter (length); ignored if there is a load.
    load : float, optional
        Positive (force).
    start : ndarray, shape (n, m), optional
        Pressure to start from, nowhere negative.
    tolerance : float
        Largest violation that is left (length).

    Yields
    ------
    Step
        The start, and one for each outer step. The last one is converged, or has a
        message.
    """
    halfspace = contact.halfspace
    pressure = _first(contact, load, start)
    displacement = halfspace.displacement(pressure)
    if load is None:
        share = _share(pressure, displacement, contact.heights + height)
        pressure, displacement = share * pressure, share * displacement
    work = math.prod(halfspace.grid)
    model: Circulant | Matrix | None = None
    candidate = np.zeros(halfspace.shape, bool)
    violations: list[float] = []
    moves: list[tuple[np.ndarray, np.ndarray]] = []
    part = 1.0
    while True:
        gap, height = _gap(contact, pressure, displacement, height, load)
        violation = _violation(pressure, gap)
        violations.append(violation)
        converged = violation <= tolerance
        message = "" if converged else _obstacle(violations, part, tolerance)
        message += precision_advice(halfspace) if message else ""
        yield Step(
            pressure=pressure,
            displacement=displacement,
            height=height,
            elastic_energy=-0.5 * halfspace.cell_area * dot(pressure, displacement),
            violation=violation,
            converged=converged,
            message=message,
            work=work,
        )
        if converged or message:
            return
        if model is None or gap.min(where=~candidate, initial=np.inf) < 0.0:
            candidate = (pressure > 0.0) | (gap < violation)
            model = model_of(halfspace, np.flatnonzero(candidate))
        before = model.transforms
        # there is no need to come back to an exact model
        contraction = 0.0 if model.exact else _CONTRACTION
        correction = _Correction(contact, model, pressure, gap, load is not None)
        trial = correction.solve(max(0.3 * tolerance, contraction * violation))
        sunk = halfspace.displacement(trial)
        work = math.prod(halfspace.grid) + model.points * (model.transforms - before)
        moves = [(trial - pressure, displacement - sunk), *moves[:_MEMORY]]
        if len(violations) > 1 and violation > _SLOW * violations[-2]:
            better = _combined(pressure, gap, moves, load is not None)
            pressure, displacement, part = better, halfspace.displacement(better), 1.0
            work += math.prod(halfspace.grid)
            continue
        part = _part(pressure, trial, gap, displacement - sunk)
        pressure = _between(pressure, trial, part)
        displacement = _between(displacement, sunk, part)


def model_of(halfspace: HalfSpace, atoms: np.ndarray) -> Circulant | Matrix:
    """Cheap model of the half space below some atoms."""
    if isinstance(halfspace, ScatteredHalfSpace):
        return Matrix(halfspace, atoms)
    return Circulant(halfspace, atoms)


def _first(
    contact: Contact, load: float | None, start: np.ndarray | None
) -> np.ndarray:
    """Pressure to start from, which carries the load."""
    if load is None:
        return np.zeros(contact.heights.shape) if start is None else start
    halfspace = contact.halfspace
    total = load / halfspace.cell_area
    if start is None or not start.any():
        start = _springs(contact.heights, total, 1.0 / halfspace.atom_compliance)
    return start * (total / start.sum())


def _share(
    pressure: np.ndarray, displacement: np.ndarray, undeformed: np.ndarray
) -> float:
    """Part of a start to take: less than all if it is much too large for a gap."""
    stored, done = -dot(pressure, displacement), -dot(pressure, undeformed)
    if done >= 0.5 * stored:
        return 1.0
    return done / stored if done > 0.0 else 0.0


def _springs(heights: np.ndarray, total: float, stiffness: float) -> np.ndarray:
    """Pressures of springs without neighbours which add up to a total."""
    above = heights - heights.min()
    h = np.sort(above, axis=None)
    carried = stiffness * (np.arange(1, h.size) * h[1:] - np.cumsum(h[:-1]))
    count = int(np.searchsorted(carried, total)) + 1
    level = (total / stiffness + h[:count].sum()) / count
    return stiffness * np.maximum(level - above, 0.0)


def _gap(
    contact: Contact,
    pressure: np.ndarray,
    displacement: np.ndarray,
    height: float,
    load: float | None,
) -> tuple[np.ndarray, float]:
    """Gap and height; under a load the one at which the gaps in contact balance."""
    gap = contact.heights - displacement
    if load is not None:
        touching = gap[pressure > 0.0]
        height = -float(touching.min() + touching.max()) / 2.0
    gap += height
    return gap, height


def _violation(pressure: np.ndarray, gap: np.ndarray) -> float:
    """Largest gap in contact, or overlap anywhere."""
    return max(
        0.0, float(gap.max(where=pressure > 0.0, initial=0.0)), -float(gap.min())
    )


def _obstacle(violations: list[float], part: float, tolerance: float) -> str:
    """Why there is no way on, or nothing."""
    reached = f"a gap of {violations[-1]:.3g} is left, not {tolerance:.3g}"
    if part == 0.0:
        return f"rounding: the energy can't be lowered, {reached}"
    late, early = violations[-_PATIENCE:], violations[:-_PATIENCE]
    if early and min(late) >= min(early):
        return f"no progress in {_PATIENCE} steps: {reached}"
    return ""


def _part(
    old: np.ndarray, new: np.ndarray, gap: np.ndarray, deepening: np.ndarray
) -> float:
    """Part of the way from the old to the new pressure to go: the least energy.

    The whole way, if that lowers the energy and the set in contact changes: else the
    atoms that leave would keep a part of their pressure for ever.
    """
    step = new - old
    slope, curvature = dot(step, gap), dot(step, deepening)
    if slope >= 0.0:
        return 0.0
    if curvature <= 0.0:  # the mean of a periodic surface moves at no cost
        return 1.0
    part = -slope / curvature
    settled = np.array_equal(new > 0.0, old > 0.0) and (old + part * step).min() >= 0.0
    return part if settled or part < 0.5 else 1.0


def _combined(
    pressure: np.ndarray,
    gap: np.ndarray,
    moves: list[tuple[np.ndarray, np.ndarray]],
    loaded: bool,
) -> np.ndarray:
    """Pressure of the least energy among moves, the last one and those before.

    Together they make up for the long waves that the model misses.
    """
    count = len(moves)
    hessian, slopes = np.empty((count, count)), np.empty(count)
    for i, (step, _) in enumerate(moves):
        slopes[i] = dot(step, gap)
        for j, (_, deepening) in enumerate(moves):
            hessian[i, j] = dot(step, deepening)
    parts, *_ = np.linalg.lstsq(hessian, -slopes, rcond=1e-8)
    new = pressure + sum(
        part * step for part, (step, _) in zip(parts, moves, strict=True)
    )
    touching = pressure + moves[0][0] > 0.0
    new = np.where(touching, new.clip(0.0), 0.0)
    if loaded:
        new *= pressure.sum() / new.sum()
    return new


def _between(old: np.ndarray, new: np.ndarray, part: float) -> np.ndarray:
    """Part of the way from old to new."""
    return new if part == 1.0 else old + part * (new - old)


class _Correction:
    """The model's contact problem, from the pressure and gap of a window.

    With `loaded`, the load is kept, and `shift` is the change of the height. Otherwise,
    `floating` tells that the atoms are all of a periodic surface.
    """

    def __init__(
        self,
        contact: Contact,
        model: Circulant | Matrix,
        pressure: np.ndarray,
        gap: np.ndarray,
        loaded: bool,
    ) -> None:
        halfspace = contact.halfspace
        self.shape = gap.shape
        self.model = model
        self.pressure = pressure.reshape(-1)[model.atoms]
        self.gap = gap.reshape(-1)[model.atoms]
        self.contact = halfspace.atom_compliance * self.pressure > self.gap
        self.loaded = loaded
        everywhere = model.atoms.size == gap.size
        self.floating = halfspace.periodic and everywhere and not loaded
        self.total = self.pressure.sum()
        self.shift = 0.0
        self.budget = _BUDGET

    def solve(self, target: float) -> np.ndarray:
        """Pressure on the window, to a violation, as far as the budget goes."""
        while True:
            self.budget -= 1
            self._let_go()
            self._clip()
            self._equilibrate(target)
            leave = self.contact & (self.pressure < 0.0)
            enter = ~self.contact & (self.gap + self.shift < -target)
            self.contact &= ~leave
            if self.budget <= 0 or not (leave.any() or enter.any()):
                window = np.zeros(self.shape)
                window.reshape(-1)[self.model.atoms] = self._clipped()
                return window
            self.contact |= enter

    def _let_go(self) -> None:
        """Open an atom of a periodic surface in full contact: nothing holds it."""
        if self.floating and self.contact.all():
            self.pressure -= self.pressure.min()
            self.contact = self.pressure > 0.0

    def _clipped(self) -> np.ndarray:
        """Pressure in contact alone and without tension, at the same load."""
        clipped = np.where(self.contact, self.pressure.clip(0.0), 0.0)
        if self.loaded:
            clipped *= self.total / clipped.sum()
        return clipped

    def _clip(self) -> None:
        """Clip the pressure, and let the gap follow."""
        clipped = self._clipped()
        moved = np.flatnonzero(clipped != self.pressure)
        if moved.size:
            change = (clipped - self.pressure)[moved]
            self.gap += self.model.compliance(change, moved)
            self.pressure = clipped

    def _residual(self, members: np.ndarray) -> np.ndarray:
        """Overlap of the members; under a load without its mean, which is a shift."""
        residual = -self.gap[members]
        if self.loaded:
            self.shift = float(residual.mean())
            residual -= self.shift
        return residual

    def _equilibrate(self, target: float) -> None:
        """Close the gap of the atoms in contact by conjugate gradients.

        They end at a tenth of the first violation, at the target or with the budget.
        Under a load their directions carry none.
        """
        members = np.flatnonzero(self.contact)
        if not members.size:
            return
        residual = self._residual(members)
        overlap = -self.gap.min(where=~self.contact, initial=np.inf) - self.shift
        target = max(target, _FORCING * max(abs(residual).max(), overlap))
        direction = np.zeros(members.size)
        last, last_work = residual, math.inf
        while abs(residual).max() > target and self.budget > 0:
            z = self.model.stiffness(residual, members)
            if self.loaded:
                z -= z.mean()
            work = dot(z, residual)
            # Polak-Ribiere, restarted when it turns negative
            direction = z + max(0.0, (work - dot(z, last)) / last_work) * direction
            last, last_work = residual, work
            change = self.model.compliance(direction, members)
            length = dot(direction, residual) / dot(direction, change[members])
            self.pressure[members] += length * direction
            self.gap += length * change
            residual = self._residual(members)
            self.budget -= 1
