"""The problems that all codes solve, and one judge of all their answers.

Units are reduced: contact modulus E* = 1 and spacing a0 = 1. The indenter is a
paraboloid of radius 10 n a0 with self-affine roughness, pressed on n x n atoms of a
free half space with the load of a smooth Hertzian contact of radius 0.3 n a0; or, for a
periodic half space, the roughness alone under a mean pressure of 0.004 E*. The hardness
of plastic walls is 0.03 E*.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from ase import Atoms

from ase_roughcontact import (
    DugdaleWall,
    ExponentialWall,
    HardWall,
    LennardJones93,
    PlasticWall,
    RoughContact,
    RoughSphere,
    SelfAffine,
    substrate,
)
from ase_roughcontact.contact import Contact
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace, PeriodicHalfSpace
from ase_roughcontact.interactions import Interaction
from ase_roughcontact.topography import Surface

WALLS: dict[str, Interaction] = {
    "hard": HardWall(),
    "periodic": HardWall(),
    "plastic": PlasticWall(0.03),
    "plastic-periodic": PlasticWall(0.03),
    "repulsive": LennardJones93.repulsive(1.0, 1.0),
    "exponential": ExponentialWall(0.005, 0.5),
    "exponential-periodic": ExponentialWall(0.005, 0.5),
    "dugdale-periodic": DugdaleWall(0.005, 0.5, relative_taper=0.0),
    "adhesive-0.0005": LennardJones93.full(distance=1.0, work_of_adhesion=0.0005),
    "adhesive-0.005": LennardJones93.full(distance=1.0, work_of_adhesion=0.005),
}

# Largest gap in contact (a0, hard walls) or force left on an atom (E* a0^2).
TOLERANCE = 1e-6
# Part of the hardness by which pressures in plastic contact may differ from it.
ROUNDING = 1e-6


@dataclass(frozen=True)
class Problem:
    """One input for every code.

    A hard wall is pressed down with the load. A wall with attraction, or a soft one,
    stands at the height at which it carries the load, because not every peer can take a
    load there.
    """

    kind: str
    n: int
    indenter: Surface = field(init=False)

    def __post_init__(self) -> None:
        longest = float(min(512, self.n))
        side = float(self.n) if self.periodic else max(4.0 * longest, float(self.n))
        surface = SelfAffine(0.1, 0.8, 4.0, longest, seed=1, domain=side)
        if not self.periodic:
            surface = RoughSphere(radius=10.0 * self.n, roughness=surface)
        object.__setattr__(self, "indenter", surface)

    @property
    def periodic(self) -> bool:
        """Periodic or free half space."""
        return self.kind.endswith("periodic")

    @property
    def wall(self) -> Interaction:
        """Interaction with the indenter."""
        return WALLS[self.kind]

    @property
    def hard(self) -> bool:
        """Hard wall without attraction."""
        return self.wall.hard and not self.wall.attractive

    @property
    def plastic(self) -> bool:
        """Whether pressures are limited by a hardness."""
        return self.wall.hardness < np.inf

    @property
    def solvers(self) -> str:
        """Kind of solvers: for hard, plastic, adhesive hard or soft walls."""
        if self.wall.hard and not self.hard:
            return "adhesive-periodic" if self.periodic else "adhesive"
        return "plastic" if self.plastic else "hard" if self.hard else "soft"

    @property
    def shape(self) -> tuple[int, int]:
        """Window of atoms that may touch."""
        return self.n, self.n

    @property
    def load(self) -> float:
        """Force on the indenter."""
        if self.periodic:
            return 4e-3 * self.n**2
        return 4.0 * (0.3 * self.n) ** 3 / (3.0 * 10.0 * self.n)

    @cached_property
    def heights(self) -> np.ndarray:
        """Lower surface of the indenter, shape (n, n)."""
        axis = float(self.n // 2)
        return self.indenter.heights(self.shape, 1.0, (-axis, -axis))

    @cached_property
    def height(self) -> float:
        """Where a soft wall stands: carries the load, found off the clock."""
        from ase_roughcontact.solvers.soft.newton import newton_krylov

        contact = self.contact()
        states = newton_krylov(
            contact,
            height=contact.first_contact,
            external=self.press,
            start=None,
            tolerance=TOLERANCE,
        )
        *_, last = (state.height for state in states)
        return last

    def press(self, height: float) -> tuple[float, float]:
        """Energy and force of the load at a height of the indenter."""
        return self.load * height, -self.load

    def contact(self) -> Contact:
        """Arrays for the solvers: a new one, with its plans and kernel made."""
        kind = PeriodicHalfSpace if self.periodic else FreeHalfSpace
        halfspace = kind(self.shape, 1.0, 1.0)
        halfspace.displacement(np.zeros(self.shape))
        return Contact(halfspace, self.heights, self.wall)

    def atoms(self) -> Atoms:
        """Atoms for the optimizers, pressed by the load or fixed at the height."""
        atoms = substrate(
            "Cu",
            self.shape,
            self.indenter,
            spacing=1.0,
            periodic=self.periodic,
            height=None if self.hard else self.height,
            fixed=not self.hard,
        )
        atoms.calc = RoughContact(self.indenter, 1.0, self.wall, load=self.load)
        return atoms


@dataclass(frozen=True)
class Answer:
    """What a code returned.

    Either the pressure on the window, or the displacement of the whole padded grid
    (positive upward). `setup` is the time for what depends on the grid alone, and
    `convolutions` counts those with the Green's function.
    """

    setup: float
    seconds: float
    iterations: int | None = None
    convolutions: float | None = None
    pressure: np.ndarray = field(default_factory=lambda: np.empty(0))
    displacement: np.ndarray = field(default_factory=lambda: np.empty(0))


def optimality_residuals(problem: Problem, answer: Answer) -> dict[str, float]:
    """How good an answer is, by our half space: the same measure for every code."""
    contact = problem.contact()
    if problem.hard:
        return _hard(problem, contact, answer.pressure)
    if problem.wall.hard:
        return _adhesive(problem, contact, answer)
    values = answer.displacement
    if values.size == 0:
        values = contact.halfspace.padded_displacement(answer.pressure)
    state = contact.evaluate(values, problem.height)
    return {
        "area": state.contact_area,
        "height": problem.height,
        "load error": abs(state.normal_force / problem.load - 1.0),
        "residual": float(np.abs(state.forces).max()),
    }


def _hard(problem: Problem, contact: Contact, pressure: np.ndarray) -> dict[str, float]:
    # the height follows from the pressures too: codes differ in their reference
    gap = problem.heights - contact.halfspace.displacement(pressure)
    touching, hardness = pressure > 0.0, problem.wall.hardness
    plastic = pressure >= (1.0 - ROUNDING) * hardness
    elastic = touching & ~plastic
    height = -float(gap[elastic].mean())
    gap += height
    open_at_hardness = float(gap[plastic].max(initial=0.0))
    return {
        "area": float(np.count_nonzero(touching)),
        "height": height,
        "load error": abs(float(pressure.sum()) / problem.load - 1.0),
        "gap": max(float(np.abs(gap[elastic]).max()), open_at_hardness),
        "overlap": max(0.0, -float(gap[~touching].min(initial=0.0))),
        "tension": max(0.0, -float(pressure.min())),
        "plastic": float(np.count_nonzero(plastic)),
        "excess": max(0.0, float(pressure.max()) - hardness),
    }


def _adhesive(problem: Problem, contact: Contact, answer: Answer) -> dict[str, float]:
    """Gap and reaction exclude each other: the smaller one must be zero."""
    pressure, (n, m) = answer.pressure, problem.shape
    if pressure.size == 0:
        pressure = contact.elastic_pressure(answer.displacement)[:n, :m]
    gap = problem.heights - contact.halfspace.displacement(pressure)
    height = problem.height
    if problem.periodic:  # pressed by the load: the height follows
        height = -float(gap.min())
    gap += height
    reaction = pressure - contact.evaluate_wall(np.maximum(gap, 0.0))[1]
    gap_of_reaction = contact.halfspace.self_compliance * reaction
    return {
        "area": float(np.count_nonzero(reaction > gap / contact.halfspace.spacing)),
        "height": height,
        "load error": abs(float(pressure.sum()) / problem.load - 1.0),
        "gap": float(abs(np.minimum(gap, gap_of_reaction)).max()),
        "overlap": max(0.0, -float(gap.min())),
    }
